//! Sentences used in both text and HTML reports, and descriptions of misreadings from the catalogs.

use crate::diagnose::Category;
use crate::report::document::LikelyCause;
use ptm_mistakes::{texture, writing};
use ptm_suite::name::SuiteName;

/// Looks up slugs in the catalogs of the suite and returns the slug, clause and effect of each. Unknown slugs are skipped.
fn misreading_texts(suite: SuiteName, slugs: &[String]) -> impl Iterator<Item = [&str; 3]> {
    slugs.iter().filter_map(move |slug| {
        if suite == SuiteName::Writers {
            return writing::find(slug).map(|one| [slug, one.clause, one.effect]);
        }
        let ptm = ptm_mistakes::find(slug).map(|one| [slug, one.clause, one.effect]);
        ptm.or_else(|| texture::find(slug).map(|one| [slug, one.clause, one.effect]))
    })
}

/// Maximum number of equivalent misreadings that are described. The rest are only counted.
const MAX_EQUIVALENT_MISREADINGS: usize = 3;

/// Additional sentence about a cause, without the final period: the text before a name, the name of a misreading or case (may be
/// empty), the text after the name, and the page of the misreading on the site.
type Detail<'a> = (String, &'a str, &'static str, Option<String>);

/// Returns the details of a cause: misreadings with the same effect, and misreadings that the decoder also makes.
#[must_use]
pub fn details(cause: &LikelyCause, suite: SuiteName) -> Vec<Detail<'_>> {
    let subject = suite.subject();
    let mut details: Vec<Detail> = Vec::new();
    let same = match cause.kind {
        // A refusal and a crash do not look the same.
        Some(Category::Refusal) => "also show no image of these files",
        _ => "look the same in these cases",
    };
    let mut equivalent = misreading_texts(suite, &cause.equivalents);
    for [slug, clause, effect] in equivalent.by_ref().take(MAX_EQUIVALENT_MISREADINGS) {
        let before = format!("A decoder that {effect} would {same} (clause {clause}; ");
        details.push((before, slug, ")", Some(suite.misreading_page(slug))));
    }
    let more = equivalent.count();
    if more > 0 {
        let plural = if more == 1 { "" } else { "s" };
        let before = format!("{more} other misreading{plural} would {same}; see the report");
        details.push((before, "", "", None));
    }
    for [slug, _, effect] in misreading_texts(suite, &cause.accompanying) {
        let before =
            format!("Some of these responses need a second mistake: the {subject} also {effect} (");
        details.push((before, slug, ")", None));
    }
    for effect in &cause.accompanying_edits {
        let text =
            format!("Some of these responses need a second mistake: the {subject} also {effect}");
        details.push((text, "", "", None));
    }
    details
}

/// Name shown in reports if the decoder is a function in the process that started ptm-conform.
pub const CALLER_COMMAND: &str = "a function of the caller";

/// Returns a text about a function instead of a program: it raises exceptions instead of exiting with a status.
pub(super) fn for_functions(text: &str) -> String {
    let mut text = text.to_owned();
    for (status, kind) in [("65", "malformed"), ("69", "unsupported")] {
        let exception = format!("the exception for {kind} files");
        for (exit, raise) in [("exits", "raises"), ("exit", "raise")] {
            for words in [
                format!("status {status}"),
                format!("{status} ({kind})"),
                status.to_owned(),
            ] {
                text = text.replace(
                    &format!("{exit} with {words}"),
                    &format!("{raise} {exception}"),
                );
            }
        }
        text = text.replace(&format!("exit status {status}"), &exception);
    }
    text.replace("last message on its standard error", "its message")
        .replace("on standard error", "as a message")
        .replace("standard error", "message")
}

/// Advice for a program that is called through `check-writer --cmd` and is not a writer.
const OK_EXIT_ADVICE: &str =
    "If its exit status is not 0 on success, name the status with --ok-exit; see docs/writers.md.";

/// Returns lines that explain how the program under test is called.
#[must_use]
pub fn call_instructions(suite: SuiteName, command: &str) -> String {
    match suite {
        SuiteName::Texture => format!(
            "Usage of a texture stage: DECODER texture FILE\nExample: {command} texture case.json\nFILE contains a question in JSON, and the answer is a JSON object on standard output; see spec-cases/texture/README.md."
        ),
        SuiteName::Writers if command.contains("{out}") => {
            format!("Placeholders of --cmd: {{out}} is the file to write, {{in}} is the request in JSON, and {{planes}} is the NumPy array; {{format}}, {{width}}, {{height}}, {{scale}}, {{bias}}, {{matrix}}, {{quality}} and {{near}} are values of the request.\n{OK_EXIT_ADVICE}")
        }
        SuiteName::Fitters if command.contains("{out}") => {
            format!("Placeholders of --cmd: {{out}} is the file to write, {{lp}} is the list of lights, and {{in}} is the request in JSON; {{format}}, {{width}} and {{height}} are values of the request.\n{OK_EXIT_ADVICE}")
        }
        SuiteName::Writers => format!(
            "Usage of a writer: WRITER write REQUEST OUT\nExample: {command} write request.json out.ptm\nREQUEST is a JSON file, and the PTM goes to OUT; see docs/writers.md."
        ),
        SuiteName::Fitters => format!(
            "Usage of a fitter: FITTER fit REQUEST OUT\nExample: {command} fit request.json out.ptm\nREQUEST is a JSON file that names an .lp file, and the PTM goes to OUT; see docs/writers.md."
        ),
        SuiteName::Ptm if command == CALLER_COMMAND => {
            "The functions raw(file), coef(file) and rgb(file, lu, lv) take the bytes of a file and return an image; see the README of the package.".to_owned()
        }
        SuiteName::Ptm if command.contains("{in}") => {
            "A program called through --cmd reads the file {in} and writes an image to {out}, or prints it; see docs/check.md.".to_owned()
        }
        SuiteName::Ptm => format!(
            "Usage of a decoder: DECODER VIEW FILE\nExample: {command} raw x.ptm\nFor raw, it prints \"PTM1 raw WIDTH HEIGHT CHANNELS u8\", a line feed and the samples; see docs/protocol.md.\nTo find the fault step by step, run: ptm-conform probe DECODER"
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::for_functions;

    #[test]
    fn functions_raise_exceptions() {
        for (program, function) in [
            (
                "refuse these files with exit status 65",
                "refuse these files with the exception for malformed files",
            ),
            (
                "read these legal files, or exit with 69 for all",
                "read these legal files, or raise the exception for unsupported files for all",
            ),
            (
                "it exits with 69 (unsupported) on files",
                "it raises the exception for unsupported files on files",
            ),
            (
                "exit with status 65",
                "raise the exception for malformed files",
            ),
            (
                "last message on its standard error: bad",
                "its message: bad",
            ),
            ("the width is 65", "the width is 65"),
        ] {
            assert_eq!(for_functions(program), function);
        }
    }
}
