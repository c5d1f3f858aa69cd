#![cfg(unix)]

mod catalog;
mod totality;
