//! The spelling of a table's count that the decoder reads.

use crate::protocol::frame::Answer;
use crate::session::asking::Session;
use crate::session::observation::Response;
use crate::session::offer::Offer;
use crate::suite::cases::{Expect, TableSpelling};
use crate::suite::dialect::Right;
use crate::suite::test_case::TestCase;

impl<C: TestCase> Session<'_, C> {
    /// Returns the first spelling of a table that the decoder reads correctly.
    pub(super) fn table_spelling(&self, offer: &Offer<C>) -> Option<TableSpelling> {
        let cases = self.suite.cases.iter().enumerate();
        let mut asked = cases.filter(|&(i, _)| self.plan.asks(i));
        asked.find_map(|(_, case)| {
            let (spelling, view) = (case.spelling()?, offer.chosen_view(case)?);
            let (observation, _) = self.observe(case, view, TableSpelling::default(), 0);
            let right = Right::Anyway(true);
            matches!(observation.response, Response::Picture { right: shown, .. } if shown == right)
                .then_some(spelling)
        })
    }

    /// Returns the spelling of tables that a decoder that shows no `spelling` case correctly reads best, by small tables;
    /// `None` if the evidence is weak.
    pub(super) fn likely_spelling(&self, offer: &Offer<C>) -> Option<TableSpelling> {
        const PROBES: usize = 4;
        if self.plan.precomputed {
            return None;
        }
        let cases = self.suite.cases.iter();
        let mut probes: Vec<&C> = cases
            .filter(|case| case.expect() == Expect::Decode && case.has_table())
            .collect();
        // Each file is made once.
        probes.sort_by_cached_key(|case| C::file(&case.made(TableSpelling::default())).len());
        probes.truncate(PROBES);
        let mut scores: Vec<(f64, TableSpelling)> = Vec::new();
        for table in TableSpelling::all() {
            let (mut score, mut silent) = (0.0, 0);
            for case in &probes {
                let Some(view) = offer.chosen_view(case) else {
                    continue;
                };
                let (observation, _) = self.observe(case, view, table, 0);
                if self.is_over() {
                    return None;
                }
                match observation.response {
                    Response::Unsupported | Response::Violation(Answer::Hung(_)) => silent += 1,
                    // A wrong image is better evidence than none: its values may be wrong for another reason.
                    Response::Picture { difference, .. } => {
                        score +=
                            1.0 + difference.map_or(1.0, |difference| C::likeness(&difference));
                    }
                    _ => {}
                }
            }
            if silent == probes.len() {
                return None;
            }
            scores.push((score, table));
        }
        let &(ordinary, _) = scores.first()?;
        let best = scores.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
        (best.0 > ordinary + PROBES as f64 / 4.0).then_some(best.1)
    }
}
