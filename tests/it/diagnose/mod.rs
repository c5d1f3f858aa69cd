#![cfg(unix)]

mod causes;
mod recordings;
mod work;
