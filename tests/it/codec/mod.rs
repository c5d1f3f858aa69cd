#[cfg(feature = "generate")]
mod damage;
mod errors;
#[cfg(feature = "harness")]
mod witnesses;
