//! `ptm-conform diff`

use std::path::PathBuf;

use clap::Args;

use super::output::{self, Machine};
use super::{Outcome, files};
use ptm_conform::tools::anatomy::Anatomy;
use ptm_conform::tools::diff::diff;

/// Say what two maps differ in: header fields, planes, how many texels, by how much, where first.
///
/// Files that mean the same map are the same, however they are written: spelling, compression and the order of table
/// entries are noted and do not count.
///
/// Exit status: 0 the same map, 1 different maps, 2 a file that cannot be opened or decoded, or wrong usage.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform diff before.ptm after.ptm\n  ptm-conform diff --quiet a.ptm b.ptm && echo same"
)]
pub struct DiffArgs {
    /// A PTM file.
    a: PathBuf,
    /// Another one.
    b: PathBuf,
    #[command(flatten)]
    machine: Machine,
}

pub fn run(args: &DiffArgs) -> Outcome {
    let (a_file, b_file) = (files::read(&args.a)?, files::read(&args.b)?);
    let (a_anatomy, b_anatomy) = (Anatomy::of(&a_file), Anatomy::of(&b_file));
    let (a, b) = (
        files::map(&args.a, &a_anatomy),
        files::map(&args.b, &b_anatomy),
    );
    let (Ok(a), Ok(b)) = (a, b) else {
        return Ok(2);
    };
    let difference = diff((&a_file, a), (&b_file, b));
    if !args.machine.print(&difference)? {
        output::note(&difference.to_text());
        output::note(if difference.same {
            "the same map\n"
        } else {
            ""
        });
    }
    Ok(u8::from(!difference.same))
}
