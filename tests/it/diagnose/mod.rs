#[cfg(feature = "harness")]
mod causes;

#[cfg(feature = "harness")]
mod replay;
