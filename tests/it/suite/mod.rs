#![cfg(unix)]

mod corpus;
mod rulings;
mod schemas;
