#[cfg(feature = "harness")]
mod corpus;

#[cfg(feature = "harness")]
mod schemas;
