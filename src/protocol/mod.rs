//! How a decoder is asked and how it answers: views, frames, other files that are understood, capabilities.

pub mod capabilities;

pub mod frame;

pub mod npy;

pub mod picture;

pub mod forms;
