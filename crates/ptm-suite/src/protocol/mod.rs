//! Requests to a decoder and its responses: views, frames, other output formats, capabilities.

pub mod capabilities;
pub mod forms;
pub mod frame;
pub mod image_file;
pub mod npy;
pub mod request;
mod tiff_file;
