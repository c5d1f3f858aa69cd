#[cfg(feature = "harness")]
mod properties;

#[cfg(feature = "harness")]
mod rare;
