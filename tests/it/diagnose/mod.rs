#![cfg(unix)]

mod causes;
mod precision;
mod recordings;
mod sentences;
mod work;
