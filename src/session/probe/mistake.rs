//! A mistake of a wrapper.

/// One mistake: what is observed, and what to do.
#[derive(Clone, Debug)]
pub(in crate::session) struct Mistake {
    pub(in crate::session) says: String,
    pub(in crate::session) next: &'static str,
    /// Whether all samples are there, each as it should be, and stand in another order.
    pub(in crate::session) is_order: bool,
}

pub(in crate::session) fn mistake(says: impl Into<String>, next: &'static str) -> Mistake {
    Mistake {
        says: says.into(),
        next,
        is_order: false,
    }
}

/// Samples as numbers, and what had to be undone to read them so.
pub(in crate::session) type Interpretation = (Vec<f64>, Vec<Mistake>);
