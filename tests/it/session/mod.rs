#![cfg(unix)]

mod decoders;
mod examples;
mod interrupted;
mod outputs;
mod probe;
mod readings;
mod recorded_codec;
mod time_limits;
mod verdicts;
