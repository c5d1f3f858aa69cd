//! The offer of a decoder: views, and formats in them.

use std::collections::BTreeSet;

use crate::session::observation::{Observation, Response};
use crate::suite::cases::{Case, Expect};
use crate::suite::test_case::TestCase;

/// The offer of a decoder.
#[derive(Clone, Debug)]
pub struct Offer<C: TestCase = Case> {
    /// The views, best first.
    pub views: Vec<&'static str>,
    /// Views that it does not have for a kind of case, although it shows that kind in other views.
    pub lacking: Vec<(&'static str, C::Feature)>,
    /// The kinds of case for which it answered 69 to every first file in every view.
    pub unsupported: Vec<C::Feature>,
    /// The names of the kinds of case that it declares to read.
    pub declared: Vec<String>,
}

impl<C: TestCase> Default for Offer<C> {
    fn default() -> Self {
        Offer {
            views: Vec::new(),
            lacking: Vec::new(),
            unsupported: Vec::new(),
            declared: Vec::new(),
        }
    }
}

impl<C: TestCase> Offer<C> {
    /// Returns true if it shows cases of this kind in other views only.
    #[must_use]
    pub fn lacks(&self, view: &C::View, kind: &C::Feature) -> bool {
        let view = C::view_name(view);
        self.lacking
            .iter()
            .any(|(lacking, of)| *lacking == view && of == kind)
    }

    /// Returns the first view of the case that is offered, preferably for files of its kind.
    #[must_use]
    pub fn chosen_view<'a>(&self, case: &'a C) -> Option<&'a C::View> {
        let offered = |view: &&C::View| self.views.contains(&C::view_name(view));
        let mut views = case.views().iter().filter(offered);
        views
            .clone()
            .find(|view| !self.lacks(view, &case.kind()))
            .or_else(|| views.next())
    }

    /// Returns true if the decoder declares this kind of case, supports none of it, and always answered 69 to this legal one.
    #[must_use]
    pub fn is_broken_by(
        &self,
        case: &C,
        observation: &Observation<C>,
        unsupported: &BTreeSet<C::Feature>,
    ) -> bool {
        matches!(observation.response, Response::Unsupported)
            && case.expect() == Expect::Decode
            && observation.nondeterminism.is_none()
            && self.declared.contains(&case.kind().to_string())
            && unsupported.contains(&case.kind())
    }
}
