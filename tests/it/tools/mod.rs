#![cfg(unix)]

mod bad_input;
mod collections;
mod files;
mod hostile;
mod identification;
mod lint;
mod lint_page;
mod relight;
mod repair;
mod sheet;
