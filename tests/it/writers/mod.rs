#![cfg(all(unix, feature = "cli"))]

mod diagnosis;
mod examples;
mod fitting;
mod hostile;
mod judging;
