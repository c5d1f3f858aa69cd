//! Requests the first files again in a locale with a decimal comma.
//!
//! In such a locale, `strtod` and `scanf` read "0.5" as 0 after `setlocale`. PTM files always use a decimal point.

use std::process::{Command, Stdio};

use crate::runner::run::Decoder;
use crate::runner::scratch::Scratch;
use crate::session::{contact::FirstFile, run::Run};
use ptm_suite::cases::Suite;
use ptm_suite::protocol::frame::{Answer, View, ViewKind};
use ptm_suite::protocol::request::Request;

/// Languages and territories whose locales have a decimal comma.
const COMMA_LANGUAGES: [&str; 12] = [
    "de_DE", "fr_FR", "es_ES", "it_IT", "nl_NL", "pl_PL", "pt_BR", "ru_RU", "sv_SE", "da_DK",
    "fi_FI", "cs_CZ",
];

/// Returns an installed locale with a decimal comma, as listed by `locale -a`.
#[must_use]
pub fn comma_locale() -> Option<String> {
    let mut list = Command::new("locale");
    let list = list.arg("-a").stdin(Stdio::null()).stderr(Stdio::null());
    choose(&String::from_utf8_lossy(&list.output().ok()?.stdout))
}

fn choose(list: &str) -> Option<String> {
    COMMA_LANGUAGES.iter().find_map(|language| {
        let is_of_language = |name: &&str| name.split(['.', '@']).next() == Some(language);
        let mut names = list.lines().map(str::trim);
        names.find(is_of_language).map(str::to_owned)
    })
}

/// Requests each first file again in `locale`, in a view in which it was decoded, and describes the first difference.
#[must_use]
pub fn difference(
    suite: &Suite,
    run: &Run,
    decoder: &Decoder,
    locale: &str,
    scratch: &Scratch,
) -> Option<String> {
    let mut decoder = decoder.clone();
    locale.clone_into(&mut decoder.locale);
    // The view raw depends on no number except the size, so other views are preferred.
    let preference = |view: &View| (view.kind() == ViewKind::Raw, view.kind() != ViewKind::Coef);
    let mut first: Vec<&FirstFile> = run.first.iter().collect();
    first.retain(|first| matches!(first.reply.answer, Answer::Decoded(_)));
    first.sort_by_key(|first| (first.case, preference(&first.view)));
    first.dedup_by_key(|first| first.case);
    first.into_iter().find_map(|first| {
        let FirstFile {
            case, view, reply, ..
        } = first;
        let Answer::Decoded(frame) = &reply.answer else {
            return None;
        };
        let case = &suite.cases[*case];
        let built = case.build(run.table);
        let request = Request::new(&case.id, view, &built.file, frame.samples.bytes());
        let answer = decoder.ask(&request, scratch).answer;
        let got = match &answer {
            answer if answer.is_equivalent(&reply.answer) => return None,
            Answer::Decoded(other) => match (other.width, other.height) {
                size if size == (frame.width, frame.height) => "gives a different image".to_owned(),
                (width, height) => format!("gives an image of {width}x{height}"),
            },
            Answer::TimedOut(limit) => limit.to_string(),
            other => format!("gives {}", other.describe()),
        };
        Some(format!(
            "in the locale {locale}, which uses a decimal comma, {} in {view} {got}: PTM files use a decimal point in every locale (LC_NUMERIC)",
            case.id
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comma_locale_is_found_by_language() {
        assert_eq!(choose("C\nC.utf8\nPOSIX\nen_US.utf8\n"), None);
        let euro = Some("de_DE@euro".to_owned());
        assert_eq!(choose("C\nfr_FR.utf8\nde_DE@euro\n"), euro);
        assert_eq!(choose("de_DEX\nsv_SE\n"), Some("sv_SE".to_owned()));
    }
}
