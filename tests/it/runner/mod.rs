#![cfg(unix)]

mod cmd;
mod serve;
mod trouble;
mod zoo;
