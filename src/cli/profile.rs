//! `ptm-conform generate --profile`

use std::path::Path;

use super::{Outcome, output};
use crate::{progress_bar, show_progress};
use ptm_conform::harness::cases::Suite;
use ptm_conform::tools::profiles::{self, Profile};

/// Writes the corpus of a profile.
pub fn write(suite: &Suite, profile: Profile, out: &Path, jobs: usize) -> Outcome {
    let bar = progress_bar();
    let manifest = profiles::write(suite, out, profile, jobs, &|done, all| {
        show_progress(&bar, done, all);
    });
    bar.finish_and_clear();
    let manifest = manifest.map_err(|error| error.to_string())?;
    let answers: usize = manifest.cases.iter().map(|case| case.expected.len()).sum();
    output::note(&format!(
        "{} files and {answers} right answers in {}; its README.md says how to use them\n",
        manifest.cases.len(),
        out.display()
    ));
    Ok(0)
}
