#![cfg(unix)]

mod frames;
