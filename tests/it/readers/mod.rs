//! Profiles of readers and their predictions.

#![cfg(all(unix, feature = "cli"))]

mod predictions;
