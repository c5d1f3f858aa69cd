#![cfg(unix)]

mod usage;
