#[cfg(feature = "harness")]
mod catalog;

#[cfg(all(feature = "harness", unix))]
mod totality;
