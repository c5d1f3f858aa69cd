//! Profiles of readers, and what is predicted by them.

#![cfg(all(unix, feature = "cli"))]

mod predictions;
