#![cfg(unix)]

mod equality;
