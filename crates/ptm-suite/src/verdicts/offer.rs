//! The offer of a decoder: its views, and the kinds of cases that it supports in each view.

use std::collections::BTreeSet;

use crate::cases::Expect;
use crate::features::Feature;
use crate::test_case::TestCase;
use crate::verdicts::observation::{ObservationOf, Response};

/// The views and kinds of cases that a decoder offers. `F` is the type of kinds.
#[derive(Clone, Debug)]
pub struct Offer<F = Feature> {
    /// Offered views, in order of preference.
    pub views: Vec<&'static str>,
    /// Missing views, each with a kind of case that the decoder decodes only in other views.
    pub missing_views: Vec<(&'static str, F)>,
    /// Kinds of cases for which every first file resulted in exit status 69 in every view.
    pub unsupported: Vec<F>,
    /// Names of the kinds of cases that the decoder declares.
    pub declared: Vec<String>,
}

impl<F> Default for Offer<F> {
    fn default() -> Self {
        Offer {
            views: Vec::new(),
            missing_views: Vec::new(),
            unsupported: Vec::new(),
            declared: Vec::new(),
        }
    }
}

impl Offer {
    /// Returns true if the decoder decodes this kind of case only in views other than `view`.
    #[must_use]
    pub fn lacks(&self, view: &str, kind: &Feature) -> bool {
        let mut lacking = self.missing_views.iter();
        lacking.any(|(name, other)| *name == view && other == kind)
    }

    /// Returns the first view of the case that is offered for this kind of case, or else the first that is offered at all.
    pub fn chosen_view<'a, C: TestCase>(&self, case: &'a C) -> Option<&'a C::View> {
        let offered = |view: &&C::View| self.views.contains(&C::view_name(view));
        let mut views = case.views().iter().filter(offered);
        let first = views.clone().next();
        views
            .find(|view| !self.lacks(C::view_name(view), &case.kind()))
            .or(first)
    }

    /// Returns true if the case breaks the offer: its kind is declared but unsupported, and the answer to it was 69.
    pub fn is_broken_by<C: TestCase>(
        &self,
        case: &C,
        observation: &ObservationOf<C>,
        unsupported: &BTreeSet<Feature>,
    ) -> bool {
        matches!(observation.response, Response::Unsupported)
            && case.expect() == Expect::Decode
            && observation.nondeterminism.is_none()
            && self.declared.contains(&case.kind().to_string())
            && unsupported.contains(&case.kind())
    }
}
