//! Tests that every formula in `formulas.yaml` equals its counterpart in the reference decoder on every case of the suite.

use ptm::Reading;
use ptm_mistakes::Misreading;
use ptm_mistakes::formula::{Edit, EditedForm, Formula};
use ptm_suite::cases::{Suite, TableSpelling};
use ptm_suite::protocol::frame::{Answer, Samples};

use crate::in_process::formula_misreading;

/// Maximum number of samples in an answer. Larger maps are skipped because they are slow and reveal nothing new.
const MAX_SAMPLES: usize = 1 << 12;

/// Returns a decoder that computes these formulas with the expressions of the specification.
fn specified_decoder(formulas: &[Formula]) -> Misreading {
    let edit = |&formula: &Formula| Edit {
        formula,
        change: EditedForm::Expression(formula.stated().expression.clone()),
    };
    formula_misreading(formulas.iter().map(edit).collect())
}

fn sample_count(answer: &Answer) -> usize {
    match answer {
        Answer::Decoded(frame) => frame.samples.len(),
        _ => 0,
    }
}

/// Returns true if two answers are equal. Final values may differ in the last bit, because terms are added in a different order.
fn is_equal(a: &Answer, b: &Answer) -> bool {
    match (a, b) {
        (Answer::Decoded(a), Answer::Decoded(b)) => match (&a.samples, &b.samples) {
            (Samples::U8(_), Samples::U8(_)) => a == b,
            _ => a.is_equivalent(b),
        },
        _ => a == b,
    }
}

#[test]
fn each_formula_equals_the_function_of_the_reference() {
    let suite = Suite::load().expect("the suite loads");
    let single = Formula::ALL.map(|row| (row.1, specified_decoder(&[row.0])));
    let all = (
        "all formulas",
        specified_decoder(&Formula::ALL.map(|row| row.0)),
    );
    let mut used = vec![0; single.len() + 1];
    for case in &suite.cases {
        let built = case.build(TableSpelling::default());
        for view in &case.views {
            let right = ptm_mistakes::answer(&[], Reading::SPEC, &built.file, view);
            if sample_count(&right) > MAX_SAMPLES {
                continue;
            }
            for (i, (name, decoder)) in single.iter().chain([&all]).enumerate() {
                let answer = ptm_mistakes::answer(&[decoder], Reading::SPEC, &built.file, view);
                assert!(
                    is_equal(&answer, &right),
                    "{name} differs in {} {view}",
                    case.id
                );
                used[i] += usize::from(sample_count(&right) > 0);
            }
        }
    }
    assert!(used.iter().all(|&count| count > 500), "{used:?}");
}
