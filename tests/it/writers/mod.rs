#![cfg(unix)]

mod diagnosis;
mod examples;
mod fitting;
mod hostile;
mod judging;
