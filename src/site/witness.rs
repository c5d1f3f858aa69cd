//! Finds the smallest file that reveals each misreading.

use std::collections::HashMap;

use ptm::reading::Reading;
use ptm_harness::diagnose::can_affect_file;
use ptm_mistakes::{Misreading, answer};
use ptm_suite::cases::{Case, Expect, Suite, TableSpelling};
use ptm_suite::choices::CHOICES;
use ptm_suite::dialect::{Dialect, RightDialects};
use ptm_suite::kit::parallel::map_in_parallel;
use ptm_suite::protocol::frame::{Answer, View};
use ptm_suite::test_case::TestCase;

/// File that reveals a misreading.
#[derive(Clone, Debug)]
pub(super) struct MisreadingWitness {
    /// Index of the case in the suite.
    pub case: usize,
    /// View in which the misreading is visible.
    pub view: View,
    /// Answer of a decoder with the mistake.
    pub answer: Answer,
    /// Difference from the correct image, if both images exist.
    pub difference: Option<String>,
}

/// Finds the smallest witness of each misreading. Misreadings without a witness are omitted.
pub(super) fn witnesses(suite: &Suite, jobs: usize) -> HashMap<&'static str, MisreadingWitness> {
    let mut by_size: Vec<usize> = (0..suite.cases.len()).collect();
    let built = |index: usize| suite.cases[index].build(TableSpelling::default());
    by_size.sort_by_cached_key(|&index| built(index).file.len());
    let all: Vec<&'static Misreading> = ptm_mistakes::all().collect();
    let found = map_in_parallel(all.len(), jobs, &|_, _| (), &|i| {
        let mut cases = by_size.iter();
        let witness = cases.find_map(|&index| witness(all[i], index, &suite.cases[index]));
        (all[i].slug, witness)
    });
    let found = found.into_iter().filter_map(|(slug, w)| Some((slug, w?)));
    found.collect()
}

fn witness(misreading: &Misreading, index: usize, case: &Case) -> Option<MisreadingWitness> {
    let built = case.build(TableSpelling::default());
    let view = case.views.first()?;
    if case.expect == Expect::Spelling || !can_affect_file(misreading, &built.file) {
        return None;
    }
    let answer = answer(&[misreading], Reading::SPEC, &built.file, view);
    let compared = match &answer {
        Answer::Decoded(frame) => Some(case.compare(&built, view, frame)),
        _ => None,
    };
    let is_revealed = match (&case.expect, &compared) {
        (Expect::Decode, None) => true,
        (Expect::Reject, _) => !matches!(answer, Answer::Rejected),
        (Expect::Refuse, compared) => compared.is_some(),
        (Expect::Decode | Expect::Lenient, Some(compared)) => {
            let Answer::Decoded(frame) = &answer else {
                return None;
            };
            let is_wrong =
                |dialect: &Dialect| case.difference_in(&built, view, frame, dialect).is_some();
            match &compared.right {
                RightDialects::Regardless(right) => !right,
                RightDialects::Depends { axes, .. } => {
                    CHOICES.combinations(axes).iter().all(is_wrong)
                }
            }
        }
        _ => false,
    };
    let difference = compared.and_then(|compared| compared.difference);
    is_revealed.then(|| MisreadingWitness {
        case: index,
        view: view.clone(),
        answer,
        difference: difference.map(|difference| difference.to_string()),
    })
}
