//! What commands other than `check` do, and what `check` does besides checking.

pub mod coverage;

pub mod known_failures;

pub mod own_files;

pub mod probe;

pub mod renderings;

pub mod report;

pub mod subject;
