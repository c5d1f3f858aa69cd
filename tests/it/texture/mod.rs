#[cfg(all(unix, feature = "cli"))]
mod decoders;

mod properties;

#[cfg(feature = "harness")]
mod suite;
