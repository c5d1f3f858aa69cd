#[cfg(all(unix, feature = "cli"))]
mod decoders;

#[cfg(all(unix, feature = "cli"))]
mod examples;

#[cfg(all(unix, feature = "cli"))]
mod interrupted;

#[cfg(all(unix, feature = "cli"))]
mod outputs;

#[cfg(all(unix, feature = "cli"))]
mod probe;

#[cfg(all(unix, feature = "cli"))]
mod verdicts;
