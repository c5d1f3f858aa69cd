#[cfg(feature = "harness")]
mod corpus;

#[cfg(all(unix, feature = "cli"))]
mod schemas;
