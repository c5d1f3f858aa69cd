//! Legal files that were refused, or that brought the decoder down: what they share and no accepted file has.

use crate::diagnose::diagnosis::{Category, Diagnosis, Words};
use crate::diagnose::failure_mode::FailureMode;
use crate::diagnose::scope::shared_scope;
use crate::diagnose::tuning::{MIN_SHARE_OF_A_PROPERTY, REFUSALS_PER_CHANCE_IMAGE};
use crate::diagnose::witness::Witness;
use crate::kit::last_words::last_words;
use crate::misreadings::{Misreading, Symptom};
use crate::ptm::Format;
use crate::session::observation::Response;
use crate::suite::cases::Expect;

/// So many files have to be read before it means something that those which are not share nothing else.
const ENOUGH_READ: usize = 20;

/// Refusals that a trait explains: every file of the suite that has it is treated so. They are taken out of `left`.
pub(in crate::diagnose) fn describe(
    witnesses: &[Witness],
    left: &mut Vec<usize>,
) -> Vec<Diagnosis> {
    let mut diagnoses = Vec::new();
    let accepted = accepted(witnesses);
    for mode in FailureMode::among(witnesses, left) {
        let mut open = mode.select(witnesses, left);
        while let Some(shared) = shared_scope(witnesses, &open, &accepted, true) {
            // What few of many share is a coincidence.
            if open.len() > shared.of.len() * MIN_SHARE_OF_A_PROPERTY {
                break;
            }
            open.retain(|w| !shared.of.contains(w));
            left.retain(|w| !shared.of.contains(w));
            let effect = format!("{mode} every file {}", shared.scope.describe());
            let refusal = refusal(witnesses, &shared.of, &mode, effect);
            diagnoses.push(match shared.scope.clause() {
                Some(clause) => refusal.about(clause),
                None => refusal,
            });
        }
    }
    diagnoses
}

/// A diagnosis of files that are treated alike.
fn refusal(witnesses: &[Witness], of: &[usize], mode: &FailureMode, effect: String) -> Diagnosis {
    let fix = match mode {
        FailureMode::Refuses | FailureMode::Unsupported => {
            "read such files, they are legal; if they are not meant to be read, answer 69 to all of them"
        }
        FailureMode::Hangs => "find the loop that does not end there",
        _ => "run the example under a debugger: these files are legal",
    };
    let words = Words {
        effect,
        fix: fix.to_owned(),
        example: example(witnesses, of),
    };
    Diagnosis::described(Category::Refusal, witnesses, of, words)
}

/// For each way not to show a picture, the failures that one shared trait explains.
pub(in crate::diagnose) fn widest(witnesses: &[Witness], failing: &[usize]) -> Vec<Vec<usize>> {
    let accepted = accepted(witnesses);
    let of = |mode: FailureMode| {
        let of = mode.select(witnesses, failing);
        shared_scope(witnesses, &of, &accepted, true).map(|shared| shared.of)
    };
    FailureMode::among(witnesses, failing)
        .into_iter()
        .filter_map(of)
        .collect()
}

/// Legal files that the decoder reads, rightly or wrongly. One that ends in another crash says nothing.
fn accepted(witnesses: &[Witness]) -> Vec<usize> {
    let is_read = |w: &usize| {
        witnesses[*w].case.expect == Expect::Decode
            && matches!(witnesses[*w].observation.response, Response::Picture { .. })
    };
    (0..witnesses.len()).filter(is_read).collect()
}

/// The one way in which all of these fail.
fn one_mode(witnesses: &[Witness], of: &[usize]) -> Option<FailureMode> {
    let mode = FailureMode::of(&witnesses[*of.first()?])?;
    (mode.select(witnesses, of).len() == of.len()).then_some(mode)
}

/// "refuses every file of RGB, LRGB", where these are all the legal files of some formats and fail in one way.
pub(in crate::diagnose) fn of_whole_formats(witnesses: &[Witness], of: &[usize]) -> Option<String> {
    let mode = one_mode(witnesses, of)?;
    let format = |w: usize| witnesses[w].case.format();
    let formats: Vec<Format> = Format::ALL
        .into_iter()
        .filter(|known| of.iter().any(|&w| format(w) == *known))
        .collect();
    let is_other = |w: &usize| {
        witnesses[*w].case.expect == Expect::Decode
            && formats.contains(&format(*w))
            && !of.contains(w)
    };
    if (0..witnesses.len()).any(|w| is_other(&w)) {
        return None;
    }
    let names: Vec<&str> = formats.iter().map(|format| format.short_name()).collect();
    Some(format!("{mode} every file of {}", names.join(", ")))
}

/// Formats of which every legal file fails in one and the same way, without a picture.
pub(in crate::diagnose) struct WholeFormats {
    mode: FailureMode,
    formats: Vec<Format>,
    /// These files, and those that may be refused and fail so too.
    pub of: Vec<usize>,
}

/// Fewer legal files of a format are no whole format.
const WHOLE: usize = 4;

/// All of them, those of one way together.
pub(in crate::diagnose) fn whole_formats(witnesses: &[Witness]) -> Vec<WholeFormats> {
    let mut whole: Vec<WholeFormats> = Vec::new();
    for format in Format::ALL {
        let of_format = |w: &usize| witnesses[*w].case.format() == format;
        let is_legal = |w: &usize| witnesses[*w].case.expect == Expect::Decode;
        let all: Vec<usize> = (0..witnesses.len()).filter(of_format).collect();
        let legal: Vec<usize> = all.iter().copied().filter(is_legal).collect();
        if legal.len() < WHOLE || !legal.iter().all(|&w| witnesses[w].failed) {
            continue;
        }
        let Some(mode) = one_mode(witnesses, &legal) else {
            continue;
        };
        let alike = mode.select(witnesses, &all).into_iter();
        let of = alike.filter(|&w| witnesses[w].failed);
        match whole.iter_mut().find(|known| known.mode == mode) {
            Some(known) => {
                known.formats.push(format);
                known.of.extend(of);
            }
            None => whole.push(WholeFormats {
                formats: vec![format],
                of: of.collect(),
                mode,
            }),
        }
    }
    whole
}

impl WholeFormats {
    /// Just this, and the mistakes of the catalog that would look the same.
    pub fn describe(&self, witnesses: &[Witness], alike: Vec<&'static Misreading>) -> Diagnosis {
        let names: Vec<&str> = self
            .formats
            .iter()
            .map(|format| format.short_name())
            .collect();
        let effect = format!("{} every file of {}", self.mode, names.join(", "));
        refusal(witnesses, &self.of, &self.mode, effect).like(alike)
    }
}

/// All that can be observed of a cause that explains these legal files, if that is nothing but not to show files that
/// share something: their format, or one other thing.
pub(in crate::diagnose) fn all_that_shows(witnesses: &[Witness], of: &[usize]) -> Option<String> {
    let mode = one_mode(witnesses, of)?;
    of_whole_formats(witnesses, of).or_else(|| {
        let is_other = |w: &usize| witnesses[*w].case.expect == Expect::Decode && !of.contains(w);
        let others: Vec<usize> = (0..witnesses.len()).filter(is_other).collect();
        let shared = shared_scope(witnesses, of, &others, false)?;
        (shared.of.len() == of.len())
            .then(|| format!("{mode} every file {}", shared.scope.describe()))
    })
}

/// These files in just these words.
pub(in crate::diagnose) fn of_effect(
    witnesses: &[Witness],
    of: &[usize],
    effect: String,
) -> Diagnosis {
    let mode = one_mode(witnesses, of).unwrap_or(FailureMode::Refuses);
    refusal(witnesses, of, &mode, effect)
}

/// How those of these files end that are legal, where hardly a picture is shown and nothing else speaks for a mistake;
/// nothing where such refusals are the mistake. `otherwise` counts the pictures that are wrong otherwise than it would make them.
pub(in crate::diagnose) fn no_picture(
    witnesses: &[Witness],
    of: &[usize],
    misreading: &Misreading,
    otherwise: impl Fn() -> usize,
) -> Option<String> {
    let is_legal = |w: &usize| witnesses[*w].case.expect == Expect::Decode;
    let of: Vec<usize> = of.iter().copied().filter(is_legal).collect();
    let is_refusal =
        |mode: &FailureMode| matches!(mode, FailureMode::Refuses | FailureMode::Unsupported);
    let modes = FailureMode::among(witnesses, &of);
    let shown = of
        .iter()
        .filter(|&&w| FailureMode::of(&witnesses[w]).is_none());
    // Which few of many files are refused tells what is done, which whole formats are does not.
    let is_of_formats = |w: &usize| {
        let mut formats = of.iter().map(|&w| witnesses[w].case.format());
        is_legal(w) && formats.any(|format| format == witnesses[*w].case.format())
    };
    let all = (0..witnesses.len()).filter(is_of_formats).count();
    let is_the_mistake = modes.iter().all(is_refusal)
        && (misreading.shows == Symptom::Refusals
            || of.len() * 2 < all && otherwise() * REFUSALS_PER_CHANCE_IMAGE <= of.len());
    if of.is_empty() || shown.count() * REFUSALS_PER_CHANCE_IMAGE > of.len() || is_the_mistake {
        return None;
    }
    let files = |mode: &FailureMode| match mode.select(witnesses, &of)[..] {
        [only] => format!("{mode} a legal file, {}", witnesses[only].case.id),
        ref all => format!(
            "{mode} {} legal files, for example {}",
            all.len(),
            witnesses[all[0]].case.id
        ),
    };
    Some(modes.iter().map(files).collect::<Vec<_>>().join(", and "))
}

/// What no trait explains.
pub(in crate::diagnose) fn rest(witnesses: &[Witness], left: &mut Vec<usize>) -> Vec<Diagnosis> {
    let mut diagnoses = Vec::new();
    for mode in FailureMode::among(witnesses, left) {
        let of = mode.select(witnesses, left);
        left.retain(|w| !of.contains(w));
        let effect = match of.len() {
            1 => format!("{mode} a legal file; the cause is unknown"),
            count if accepted(witnesses).len() < ENOUGH_READ => {
                format!("{mode} {count} legal files; too few others are read to tell these apart")
            }
            count => format!(
                "{mode} {count} legal files{}; no known property separates these files from the ones it reads",
                of_formats(witnesses, &of)
            ),
        };
        let words = Words {
            effect,
            fix: "begin with the example, the smallest of these files".to_owned(),
            example: example(witnesses, &of),
        };
        diagnoses.push(Diagnosis::described(
            Category::Refusal,
            witnesses,
            &of,
            words,
        ));
    }
    diagnoses
}

/// " of the 160 of LRGB, LUM", where they are of some formats only.
fn of_formats(witnesses: &[Witness], of: &[usize]) -> String {
    let is_of =
        |of: &[usize], format: Format| of.iter().any(|&w| witnesses[w].case.format() == format);
    let asked: Vec<usize> = (0..witnesses.len())
        .filter(|&w| witnesses[w].case.expect == Expect::Decode)
        .collect();
    let known = Format::ALL
        .into_iter()
        .filter(|&format| is_of(&asked, format));
    let (these, others): (Vec<Format>, Vec<Format>) = known.partition(|&format| is_of(of, format));
    if others.is_empty() {
        return String::new();
    }
    let all = asked
        .iter()
        .filter(|&&w| these.contains(&witnesses[w].case.format()));
    let names: Vec<&str> = these.iter().map(|format| format.short_name()).collect();
    format!(" of the {} of {}", all.count(), names.join(", "))
}

/// The smallest of these files, and what it is there for.
pub(in crate::diagnose) fn example(witnesses: &[Witness], of: &[usize]) -> String {
    let smallest = of
        .iter()
        .map(|&w| &witnesses[w])
        .min_by_key(|witness| witness.built.file.len())
        .expect("a diagnosis explains at least one case");
    let stderr = &smallest.observation.stderr;
    let because = smallest.case.because.trim_end_matches('.');
    let words = last_words(stderr).map_or(String::new(), |line| {
        format!("; its standard error ends: {line}")
    });
    format!("for example {}: {because}{words}", smallest.case.id)
}
