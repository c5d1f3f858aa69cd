//! Fuzzing finds rare mistakes, names them, makes them small, and finds nothing where nothing is wrong.
#![cfg(feature = "harness")]

use std::sync::Arc;

use arbitrary::Unstructured;
use proptest::prelude::*;
use ptm_conform::harness::capabilities::Capabilities;
use ptm_conform::harness::cases::{Suite, TableSpelling, Values};
use ptm_conform::harness::compare::Expected;
use ptm_conform::harness::fuzz::draft::Draft;
use ptm_conform::harness::fuzz::{Outcomes, Plan, fuzz};
use ptm_conform::harness::misreadings;
use ptm_conform::harness::protocol::{Frame, View};
use ptm_conform::harness::run::{Reply, Request};
use ptm_conform::{Reading, decode};

fn plan(executions: usize) -> Plan {
    Plan {
        seed: 1,
        executions,
        jobs: 2,
        views: Vec::new(),
        declared: Capabilities::default(),
        formats: Vec::new(),
        stop: Arc::default(),
    }
}

/// Fuzzes a decoder with these mistakes.
fn fuzzed(slugs: &[&str], executions: usize) -> Outcomes {
    let mistakes: Vec<_> = slugs
        .iter()
        .map(|slug| misreadings::named(slug).unwrap_or_else(|| panic!("{slug}")))
        .collect();
    let ask = |request: &Request<'_>, _: usize| {
        Reply::from(misreadings::answer(
            &mistakes,
            Reading::SPEC,
            request.file,
            request.view,
        ))
    };
    let suite = Suite::load().expect("the suite loads");
    fuzz(&suite, &plan(executions), &ask, &|_| ())
}

#[test]
fn nothing_is_found_in_the_reference() {
    let outcomes = fuzzed(&[], 3000);
    let names: Vec<String> = outcomes
        .finds
        .iter()
        .map(|find| format!("{} {:?}", find.cause.name(), find.small))
        .collect();
    assert_eq!(names, [""; 0]);
    assert!(outcomes.files > 2000);
}

#[test]
fn mistakes_are_named_and_made_small() {
    for slug in ["width-by-largest-index", "rows-top-down"] {
        let outcomes = fuzzed(&[slug], 5000);
        let names: Vec<String> = outcomes
            .finds
            .iter()
            .map(|find| find.cause.name())
            .collect();
        assert_eq!(names[0], slug);
        let small = &outcomes.finds[0].small;
        assert!(small.width * small.height <= 2, "{small:?}");
    }
}

proptest! {
    #[test]
    fn drawn_files_decode_to_what_was_painted(bytes in proptest::collection::vec(any::<u8>(), 2048)) {
        let draft = Draft::draw(&mut Unstructured::new(&bytes)).expect("enough bytes");
        prop_assume!(draft.width * draft.height < 5000);
        let cases = draft.cases("drawn").map_err(TestCaseError::fail)?;
        let built = cases[0].build(TableSpelling::default());
        let ptm = decode(&built.file).map_err(|error| TestCaseError::fail(format!("{error}: {}", draft.to_yaml("drawn", ""))))?;
        prop_assert!(matches!(built.values, Values::Painted(_)));
        let expected = Expected::of(&built.values, &View::Raw).expect("painted");
        prop_assert!(expected.compare(&Frame::of(&ptm, &View::Raw)).is_none());
    }
}
