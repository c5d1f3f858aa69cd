#![cfg(all(unix, feature = "cli"))]

mod causes;
mod recordings;
mod work;
