#[cfg(all(unix, feature = "cli"))]
mod diagnosis;

#[cfg(all(unix, feature = "cli"))]
mod examples;

#[cfg(all(unix, feature = "cli"))]
mod fitting;

#[cfg(all(unix, feature = "cli"))]
mod hostile;

#[cfg(all(unix, feature = "cli"))]
mod judging;
