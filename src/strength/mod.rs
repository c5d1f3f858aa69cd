//! The strength of the suite: the misreadings that its cases catch, and those that it can distinguish.

pub mod coverage;

pub mod matrix;

pub mod smoke;
