#![cfg(all(unix, feature = "cli"))]

mod corpus;
mod schemas;
