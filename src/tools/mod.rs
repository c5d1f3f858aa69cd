//! Tools for one file: what its bytes are, what is odd about it, how it looks, and the same map written otherwise.
//!
//! anatomy → inspect, lint. decode → render, export, diff. decode → generate → convert. Nothing here judges a decoder, and
//! nothing reads or writes a file: that is the program's part.

pub mod segments;

pub mod anatomy;

pub mod inspect;

pub mod lint;

pub mod render;

pub mod export;

pub mod convert;

pub mod diff;

pub mod profiles;
