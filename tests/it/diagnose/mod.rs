#[cfg(feature = "harness")]
mod causes;

#[cfg(feature = "harness")]
mod recordings;

#[cfg(feature = "harness")]
mod work;
