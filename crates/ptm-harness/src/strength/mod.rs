//! The strength of the suite: which misreadings its cases catch, and which it distinguishes.

pub mod coverage;

pub mod matrix;

pub mod smoke;
