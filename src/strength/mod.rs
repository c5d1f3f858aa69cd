//! What the suite is worth: which cases catch which misreadings, and which misreadings it can tell apart.

pub mod coverage;

pub mod matrix;

pub mod smoke;
