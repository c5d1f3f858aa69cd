//! What holds of one file, by the place of each trait in the tables of [`traits`](super::traits).

/// The traits of a file.
pub(in crate::diagnose) struct Traits {
    /// Whether each of the traits holds.
    pub has: Vec<bool>,
    /// Each of the quantities, where the file has it.
    pub quantities: Vec<Option<f64>>,
}
