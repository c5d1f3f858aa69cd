#![cfg(all(unix, feature = "cli"))]

mod corpus;
mod rulings;
mod schemas;
