//! Tests of reader profiles and of the predictions based on them.

#![cfg(all(unix, feature = "cli"))]

mod predictions;
