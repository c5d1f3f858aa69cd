//! Tests of reader profiles and of the predictions based on them.

#![cfg(unix)]

mod predictions;
