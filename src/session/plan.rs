//! What of a suite is run, and how.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::protocol::capabilities::Capabilities;
use crate::suite::cases::{Case, Expect, Suite, TableSpelling};
use crate::suite::features::Feature;
use crate::suite::test_case::TestCase;

/// What of a suite is run, and how.
#[derive(Clone, Debug)]
pub struct RunPlan<C: TestCase = Case> {
    /// Which cases are judged, a place for each case of the suite.
    pub selected: Vec<bool>,
    /// Requests at a time, at least 1.
    pub jobs: usize,
    /// Views to ask for; all that the decoder offers if empty.
    pub views: Vec<&'static str>,
    /// The views that the decoder says it has, if it says so.
    pub declared_views: Option<Vec<&'static str>>,
    /// The kinds of case that the decoder says it reads, if it says so.
    pub declared_kinds: Option<Vec<C::Feature>>,
    /// What is asked again.
    pub repeat: Repeat,
    /// Which cases are asked before the others, a place for each case of the suite; empty if none is.
    pub soonest: Vec<bool>,
    /// Why a case is not asked, a place for each case of the suite; nothing for those that are. Empty if all are.
    pub withheld: Vec<Option<String>>,
    /// Whether the answers were made before the run: there are no first files, and tables stand in the ordinary spelling.
    pub precomputed: bool,
    /// Set when the user wants the run to end.
    pub stop: Arc<AtomicBool>,
}

/// Which cases are asked again, of a process of its own, to find answers that differ.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Repeat {
    /// None: the decoder is a function.
    #[default]
    Nothing,
    /// Those that failed: it may answer differently each time.
    Failures,
    /// Those that failed, and one in [`SAMPLE`] of the others: it serves, and may carry something from file to file.
    FailuresAndSample,
}

/// Of so many cases that did not fail, one is asked again.
pub const SAMPLE: usize = 100;

impl<C: TestCase> RunPlan<C> {
    /// Everything is asked once, of a decoder that says nothing of itself.
    #[must_use]
    pub fn of(suite: &Suite<C>, jobs: usize) -> RunPlan<C> {
        RunPlan {
            selected: vec![true; suite.cases.len()],
            jobs,
            views: Vec::new(),
            soonest: Vec::new(),
            withheld: Vec::new(),
            precomputed: false,
            declared_views: None,
            declared_kinds: None,
            repeat: Repeat::Nothing,
            stop: Arc::default(),
        }
    }

    /// Whether a view is asked for at all: if the user wants it and the decoder does not say that it has others.
    pub(super) fn may_ask(&self, view: &'static str) -> bool {
        let declared = self.declared_views.as_ref();
        let declared = declared.filter(|views| !views.is_empty());
        (self.views.is_empty() || self.views.contains(&view))
            && declared.is_none_or(|views| views.contains(&view))
    }

    /// Whether the case at place `i` is asked.
    pub(super) fn asks(&self, i: usize) -> bool {
        self.withheld.get(i).is_none_or(Option::is_none)
    }

    /// Why a case is not asked, a place for each case of the suite, where tables are spelled so.
    pub(super) fn withheld_in(
        &self,
        suite: &Suite<C>,
        table: TableSpelling,
    ) -> Vec<Option<String>> {
        let mut withheld = self.withheld.clone();
        withheld.resize(suite.cases.len(), None);
        if self.precomputed && table != TableSpelling::default() {
            for (case, why) in suite.cases.iter().zip(&mut withheld) {
                if case.has_table() && case.expect() != Expect::Spelling {
                    why.get_or_insert_with(|| {
                        "its table is spelled in a way that the decoder does not know".to_owned()
                    });
                }
            }
        }
        withheld
    }

    /// The selected cases and the twins that they stand on; and those of them that are asked first.
    pub(super) fn with_twins(&self, suite: &Suite<C>) -> (Vec<bool>, Vec<bool>) {
        let mut wanted = self.selected.clone();
        let mut soonest = self.soonest.clone();
        soonest.resize(suite.cases.len(), false);
        for (i, twins) in C::twins(&suite.cases).into_iter().enumerate() {
            if let (true, Some(&twin)) = (self.selected[i], twins.first()) {
                wanted[twin] = true;
                soonest[twin] |= soonest[i];
            }
        }
        (wanted, soonest)
    }
}

impl RunPlan {
    /// The same for a decoder that says this of itself.
    #[must_use]
    pub fn declared_by(self, capabilities: &Capabilities) -> RunPlan {
        let formats = capabilities.formats.as_ref();
        RunPlan {
            declared_views: capabilities.views.clone(),
            declared_kinds: formats
                .map(|formats| formats.iter().copied().map(Feature::Format).collect()),
            ..self
        }
    }
}
