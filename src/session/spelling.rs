//! Which spelling of a table's count the decoder knows.

use crate::protocol::frame::Answer;
use crate::session::asking::Asking;
use crate::session::observation::Response;
use crate::session::offer::Offer;
use crate::session::plan::RunPlan;
use crate::suite::cases::{Expect, Suite, TableSpelling};
use crate::suite::dialect::Right;
use crate::suite::test_case::TestCase;

/// The first spelling of a table in which the decoder shows the right picture.
pub(super) fn table_spelling<C: TestCase>(
    suite: &Suite<C>,
    plan: &RunPlan<C>,
    offer: &Offer<C>,
    asking: &Asking<C>,
) -> Option<TableSpelling> {
    let numbered = suite.cases.iter().enumerate();
    for (_, case) in numbered.filter(|&(i, _)| plan.asks(i)) {
        let (Some(spelling), Some(view)) = (case.spelling(), offer.chosen_view(case)) else {
            continue;
        };
        let (observation, _) = asking.observe(case, view, TableSpelling::default(), 0);
        let right = Right::Anyway(true);
        if matches!(observation.response, Response::Picture { right: shown, .. } if shown == right)
        {
            return Some(spelling);
        }
    }
    None
}

/// The spelling of tables in which a decoder that shows none of the spelling's own cases rightly comes nearest: by small
/// tables, of which it may show some rightly. None if that says little.
pub(super) fn likely_spelling<C: TestCase>(
    suite: &Suite<C>,
    offer: &Offer<C>,
    asking: &Asking<C>,
) -> Option<TableSpelling> {
    const PROBES: usize = 4;
    let mut probes: Vec<&C> = suite
        .cases
        .iter()
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
            let (observation, _) = asking.observe(case, view, table, 0);
            if asking.is_over() {
                return None;
            }
            score += match observation.response {
                Response::Unsupported | Response::Violation(Answer::Hung(_)) => {
                    silent += 1;
                    0.0
                }
                // A wrong picture tells more of the spelling than none: its values may be wrong for another reason.
                Response::Picture { difference, .. } => {
                    1.0 + difference.map_or(1.0, |difference| C::likeness(&difference))
                }
                _ => 0.0,
            };
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
