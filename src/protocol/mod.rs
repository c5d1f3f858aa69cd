//! Requests to a decoder and its answers: views, frames, other file formats of answers, capabilities.

pub mod capabilities;

pub mod frame;

pub mod npy;

pub mod picture;

pub mod forms;
