//! Profiles of readers, and what is predicted by them.

#[cfg(feature = "cli")]
mod predictions;
