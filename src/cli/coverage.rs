//! `ptm-conform coverage`: measures the strength of the suite.

use std::path::PathBuf;

use clap::Args;

use ptm_harness::strength::{coverage::Coverage, matrix::matrix, smoke};
use ptm_suite::cases::Suite;
use ptm_suite::kit::yaml::to_yaml;

use super::output::{jobs, print, with_progress};
use super::{CommandResult, files::write_atomically};

/// Measure the suite: clauses covered, misreadings caught and distinguished, parameter pairs, redundant cases. Takes minutes.
#[derive(Args)]
#[command(after_help = "Example:\n  ptm-conform coverage --yaml > coverage.yaml")]
pub struct CoverageArgs {
    /// Print everything as YAML instead of a summary.
    #[arg(long)]
    yaml: bool,
    /// Compute the smoke subset and write a list of its cases to FILE.
    #[arg(long, value_name = "FILE")]
    write_smoke: Option<PathBuf>,
    /// Number of files decoded in parallel; does not affect the result.
    #[arg(long, value_name = "N")]
    jobs: Option<usize>,
}

/// Runs the suite against every misreading and prints the coverage of the suite.
pub fn run(args: &CoverageArgs) -> CommandResult {
    let suite = Suite::load()?.with_prepared_files();
    let jobs = jobs(args.jobs)?;
    let rows = with_progress(|progress| matrix(&suite, jobs, progress));
    let coverage = Coverage::new(&suite, &rows)?;
    print(&match args.yaml {
        true => to_yaml(&coverage)?,
        false => coverage.to_text(&suite),
    });
    if let Some(path) = &args.write_smoke {
        write_atomically(path, smoke::to_yaml(&suite, &rows))?;
        if !args.yaml {
            let count = smoke::choose_cases(&suite, &rows).len();
            print(&format!(
                "{count} cases for all formats in {}\n",
                path.display()
            ));
        }
    }
    Ok(0)
}
