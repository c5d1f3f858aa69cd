//! Decoders inside this process, and runs of the suite against them.

use ptm::Format;
use ptm::Reading;
use ptm_harness::pipeline::judge_answers;
use ptm_harness::session::plan::RunPlan;
use ptm_harness::session::run::Run;
use ptm_mistakes::formula::Edit;
use ptm_mistakes::{Change, Misreading};
use ptm_suite::cases::{Case, Suite, TableSpelling};
use ptm_suite::protocol::frame::Answer;
use ptm_suite::protocol::request::{Reply, Request};

pub fn suite() -> Suite {
    Suite::load().expect("the suite loads")
}

/// Returns the suite with prepared files. To save time, files of more than 24 KiB are included only in LUM and `PTM_LUT`.
pub fn suite_of_small_files() -> Suite {
    let mut suite = suite().with_prepared_files();
    let is_small = |case: &Case| case.build(TableSpelling::default()).file.len() <= 24 << 10;
    let is_needed = |case: &Case| matches!(case.format(), Format::Lum | Format::PtmLut);
    suite.cases.retain(|case| is_small(case) || is_needed(case));
    suite
}

/// Returns the number of processors.
pub fn jobs() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Returns the misreading in the catalog with this slug.
#[track_caller]
pub fn misreading(slug: &str) -> &'static Misreading {
    ptm_mistakes::find(slug).unwrap_or_else(|| panic!("no misreading {slug}"))
}

/// Returns a misreading that applies these edits to formulas.
pub fn formula_misreading(edits: Vec<Edit>) -> Misreading {
    Misreading {
        slug: "none",
        ..Misreading::unlisted("1.0/1", Change::Edits(edits.leak()))
    }
}

/// Returns the answer of a decoder with these misreadings.
pub fn answer_with(mistakes: &[&Misreading], request: &Request) -> Answer {
    ptm_mistakes::answer(mistakes, Reading::SPEC, request.file, request.view)
}

/// Returns the answer of the reference decoder.
pub fn reference_answer(request: &Request) -> Answer {
    answer_with(&[], request)
}

/// Runs the cases of a plan against a decoder.
pub fn run(suite: &Suite, plan: &RunPlan, decoder: impl Fn(&Request) -> Answer + Sync) -> Run {
    let ask = |request: &Request<'_>, _: usize| Reply::from(decoder(request));
    judge_answers(suite, plan, &ask)
}

/// Runs all cases against a decoder.
pub fn run_all(suite: &Suite, decoder: impl Fn(&Request) -> Answer + Sync) -> Run {
    run(suite, &RunPlan::new(suite, jobs()), decoder)
}
