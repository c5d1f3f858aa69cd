#[cfg(feature = "harness")]
mod frames;
