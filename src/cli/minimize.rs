//! Subcommand `ptm-conform minimize`.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::Args;

use super::guard::{ScratchGuard, check_for_trouble, stop_on_signals};
use super::output::{bar, print};
use super::{CommandResult, calls::CallArgs, files, fuzz::CALLS_TEMPLATE};

use ptm::reading::Reading;
use ptm_harness::diagnose::equal_up_to_rounding;
use ptm_harness::fuzz::reduce;
use ptm_mistakes::Misreading;
use ptm_suite::cases::{Suite, TableSpelling};
use ptm_suite::protocol::frame::{Answer, Frame, View};
use ptm_suite::protocol::request::Request;

/// Reduce a file while a decoder still fails on it in the same way.
///
/// The file is decoded, made narrower, shorter and simpler step by step, and written again. A step is kept if the decoder's
/// response still differs from the reference in the same way: a wrong image, a refusal or a crash.
///
/// Exit status: 0 a smaller file was written, 1 the decoder does not fail on the file, 2 usage error.
#[derive(Args)]
#[command(
    after_help = "Example:\n  ptm-conform minimize --view raw -o small.ptm large.ptm -- ./my-decoder"
)]
pub struct MinimizeArgs {
    /// The view: raw, coef or rgb:LU,LV.
    #[arg(long, default_value = "raw")]
    view: View,
    /// The output file; by default FILE with the suffix .small.ptm.
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    call: CallArgs,
    /// A PTM file, or the id of a case.
    #[arg(value_name = "FILE|CASE")]
    file: String,
    /// The decoder and its arguments.
    #[arg(value_name = "DECODER", trailing_var_arg = true, required = true)]
    decoder: Vec<OsString>,
}

/// Writes the smallest file on which the decoder still fails in the same way.
pub fn run(args: &MinimizeArgs) -> CommandResult {
    let file = match Suite::load()?.case(&args.file) {
        Some(case) => case.build(TableSpelling::default()).file.clone(),
        None => files::read(Path::new(&args.file))
            .map_err(|error| format!("neither a case id nor a readable file: {error}"))?,
    };
    let stop = stop_on_signals()?;
    let decoder = args.call.decoder(&args.decoder, &stop)?;
    let guarded = ScratchGuard::new()?;
    let scratch = &guarded.scratch;
    let ask = |file: &[u8]| {
        let max_frame_bytes = 72 * (file.len() + (1 << 20));
        let request = Request::new("case", &args.view, file, max_frame_bytes);
        decoder.ask(&request, scratch).answer
    };
    let first = ask(&file);
    let Some(found) = symptom(&file, &args.view, &first) else {
        print("the decoder gives the same response as the reference; there is nothing to reduce\n");
        return Ok(1);
    };
    let bar = bar(Some(0), CALLS_TEMPLATE);
    let fails = |file: &[u8]| {
        bar.inc(1);
        symptom(file, &args.view, &ask(file)).as_ref() == Some(&found)
    };
    let small = reduce::reduce(&file, &stop, &fails);
    bar.finish_and_clear();
    check_for_trouble(&decoder)?;
    let Some(small) = small else {
        let says = "the file cannot be made smaller, because the failure depends on the spelling of the header";
        print(&(says.to_owned() + "\n"));
        return Ok(2);
    };
    let out = args.out.clone().unwrap_or_else(|| {
        let stem = Path::new(&args.file).file_stem().unwrap_or_default();
        PathBuf::from(format!("{}.small.ptm", stem.to_string_lossy()))
    });
    std::fs::write(&out, &small).map_err(files::with_path(&out))?;
    let (after, before, out) = (small.len(), file.len(), out.display());
    print(&format!(
        "{found}: reduced from {before} to {after} bytes in {out}\n"
    ));
    print_causes(&[(&file, first), (&small, ask(&small))], &args.view);
    Ok(0)
}

/// Prints the misreadings that reproduce all answers, unless there are too many.
fn print_causes(answers: &[(&Vec<u8>, Answer)], view: &View) {
    let explains = |misreading: &&Misreading| {
        answers.iter().all(|(file, answer)| {
            let made = ptm_mistakes::answer(&[*misreading], Reading::SPEC, file, view);
            match (&made, answer) {
                (Answer::Decoded(made), Answer::Decoded(shown)) => {
                    equal_up_to_rounding(made, shown)
                }
                (made, answer) => made.is_same_kind_as(answer),
            }
        })
    };
    let causes: Vec<&Misreading> = ptm_mistakes::all().filter(explains).collect();
    for cause in causes.iter().filter(|_| causes.len() <= MAX_CAUSES) {
        let (slug, effect, clause) = (cause.slug, cause.effect, cause.clause);
        print(&format!(
            "a decoder that {effect} (clause {clause}) gives the same responses for the original and the reduced file; more: ptm-conform explain {slug}\n"
        ));
    }
}

/// Maximum number of misreadings that are printed as possible causes. A single file often cannot distinguish them.
const MAX_CAUSES: usize = 3;

/// Describes how an answer differs from the reference. Returns `None` if it does not differ.
fn symptom(file: &[u8], view: &View, answer: &Answer) -> Option<String> {
    let symptom = match (ptm::decode(file), answer) {
        (Ok(ptm), Answer::Decoded(frame)) => {
            let is_equivalent = equal_up_to_rounding(&Frame::render(&ptm, view), frame);
            if is_equivalent {
                return None;
            }
            "a different image"
        }
        (Err(_), Answer::Decoded(_)) => "an image for a malformed file",
        (Ok(_), Answer::Rejected) => "a refusal of a legal file",
        (_, Answer::Rejected | Answer::Unsupported) => return None,
        (_, Answer::TimedOut(limit)) => return Some(limit.to_string()),
        (_, other) => other.name(),
    };
    Some(symptom.to_owned())
}
