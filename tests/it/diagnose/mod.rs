#![cfg(unix)]

mod causes;
mod claims;
mod precision;
mod recordings;
mod sentences;
mod work;
