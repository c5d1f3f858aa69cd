//! Streams of planes that come out wrong: a mistake in the decoder's own JPEG or JPEG-LS.
//!
//! Such a mistake loses its place in some streams and not in others, and ends in a refusal here and in nonsense there. It
//! shows in planes that are not predicted, which nothing but their stream makes. What it is tells the first place of each
//! plane that comes out wrong.

use super::evidence::{CODECS, Codec, First, evidence, firsts};
use super::file_streams::{FileStreams, Fit};
use super::inverse_dcts::{ShownBlock, largest_error, wrong_number};
use super::separate::{Evidence, Separation, separate};
use super::stream_slips::StreamSlip;
use crate::diagnose::diagnosis::{Category, Diagnosis, Words};
use crate::diagnose::failure_mode::FailureMode;
use crate::diagnose::mistake::Mistake;
use crate::diagnose::search::{Found, Id, Search, of};
use crate::diagnose::solved::Act;
use crate::diagnose::witness::{Agreement, Witness};
use crate::diagnose::words::pictures;
use crate::diagnose::words::refusals::{self, example};
use crate::protocol::frame::View;
use crate::suite::cases::Expect;

/// Wrong pictures, or first wrong blocks, that tell something.
const FEWEST: usize = 3;

/// Whether a file must be read and has streams of the codec.
fn is_legal(witness: &Witness, codec: &Codec) -> bool {
    codec.formats.contains(&witness.case.format()) && witness.case.expect == Expect::Decode
}

/// Takes away mistakes of the catalog that only refusals of one codec's files speak for, where that codec goes wrong in a
/// way that none of the mistakes explains: a stream in which a decoder has lost its place ends in a refusal, too.
pub(in crate::diagnose) fn drop(search: &Search, found: &mut Found) {
    for codec in &CODECS {
        let set = of(&found.members);
        let legal = (0..search.witnesses.len()).filter(|&w| is_legal(&search.witnesses[w], codec));
        let legal: Vec<usize> = legal.collect();
        let (refused, shown): (Vec<usize>, Vec<usize>) =
            (legal.iter()).partition(|&&w| FailureMode::of(&search.witnesses[w]).is_some());
        let is_open = |w: &usize| {
            search.witnesses[*w].failed
                && search.agreement(*w, &set) != Agreement::Picture
                && !firsts(search, &set, codec, *w).is_empty()
        };
        let open: Vec<usize> = shown.iter().copied().filter(is_open).collect();
        if shown.iter().all(|&w| !search.witnesses[w].failed) && refused.len() >= FEWEST {
            drop_parts(search, found, codec, &refused, &legal);
        }
        drop_where_all_fails(search, found, &legal, &refused);
        if open.len() < FEWEST {
            continue;
        }
        let set = of(&found.members);
        let keep = search.each(&set, |&id| {
            let explained =
                |w: &usize| search.witnesses[*w].failed && search.agreement(*w, &[id]).explains();
            let all = (0..search.witnesses.len()).filter(explained);
            let all: Vec<usize> = all.collect();
            let is_denied = || {
                let against = |w: &usize| search.agreement(*w, &[id]) == Agreement::Against;
                let others = refused.iter().filter(|w| !all.contains(w)).count();
                open.iter().any(against) || others >= FEWEST
            };
            all.is_empty() || !all.iter().all(|w| refused.contains(w)) || !is_denied()
        });
        found.keep(&keep);
        if keep.contains(&false) {
            return drop(search, found);
        }
    }
}

/// Takes away mistakes that only refuse files of a codec, where most of its other files are not read right either: nothing
/// tells the files that such a mistake refuses from those.
fn drop_where_all_fails(search: &Search, found: &mut Found, legal: &[usize], refused: &[usize]) {
    let set = of(&found.members);
    let keep = search.each(&set, |&id| {
        let explains = |&w: &usize| search.agreement(w, &[id]).explains();
        let failed = (0..search.witnesses.len()).filter(|&w| search.witnesses[w].failed);
        let of: Vec<usize> = failed.filter(explains).collect();
        let others = legal.iter().filter(|w| !of.contains(w));
        let (wrong, right): (Vec<usize>, Vec<usize>) =
            others.partition(|&&w| search.witnesses[w].failed);
        let refuses_only = of.iter().all(|w| refused.contains(w));
        of.is_empty() || !refuses_only || wrong.len() <= right.len()
    });
    found.keep(&keep);
}

/// One diagnosis for each codec that goes wrong. Its failures are taken out of `left`.
pub(in crate::diagnose) fn describe(
    search: &Search,
    found: &Found,
    left: &mut Vec<usize>,
) -> Vec<Diagnosis> {
    let set = of(&found.members);
    CODECS
        .iter()
        .filter_map(|codec| describe_codec(search, &set, codec, left))
        .collect()
}

/// What else goes wrong in the streams of a codec in whose decoder a slip is known: decoders that are out of step go on in
/// their own ways.
pub(in crate::diagnose) fn attribute_to_slips(
    search: &Search,
    diagnoses: &mut [(Id, Diagnosis)],
    left: &mut Vec<usize>,
) {
    let solved = diagnoses
        .iter()
        .filter_map(|(id, _)| search.mistakes.get(*id)?.solved());
    let all: Vec<StreamSlip> = solved
        .filter_map(|solved| match solved.act {
            Act::Stream(slip) => Some(slip),
            _ => None,
        })
        .collect();
    for (id, diagnosis) in diagnoses {
        let Some(solved) = search.mistakes.get(*id).and_then(Mistake::solved) else {
            continue;
        };
        let is_of = |w: &usize| {
            let case = search.witnesses[*w].case;
            case.expect == Expect::Decode && solved.act.is_of_streams(case.format())
        };
        if left.iter().filter(|w| is_of(w)).count() > diagnosis.explains.len() {
            continue;
        }
        // What the slip would show otherwise has another cause.
        let slips: Vec<StreamSlip> = all.clone();
        let of = left.extract_if(.., |w| {
            let fit = || FileStreams::of(&search.witnesses[*w]).map(|file| file.fit(&slips));
            is_of(w) && !matches!(fit(), Some(Fit::Other | Fit::Picture))
        });
        diagnosis
            .partly
            .extend(of.map(|w| search.witnesses[w].place));
    }
}

fn describe_codec(
    search: &Search,
    set: &[Id],
    codec: &Codec,
    left: &mut Vec<usize>,
) -> Option<Diagnosis> {
    let witnesses = search.witnesses;
    let is_near = |w: usize| {
        let near = |&member: &Id| pictures::is_near(search, w, set, member);
        FailureMode::of(&witnesses[w]).is_none() && set.iter().any(near)
    };
    let of_codec = |w: &usize| codec.formats.contains(&witnesses[*w].case.format()) && !is_near(*w);
    let (open, others): (Vec<usize>, Vec<usize>) = left
        .iter()
        .copied()
        .filter(of_codec)
        .partition(|&w| is_legal(&witnesses[w], codec));
    let (refused, wrong): (Vec<usize>, Vec<usize>) = open
        .iter()
        .partition(|&&w| FailureMode::of(&witnesses[w]).is_some());
    let firsts: Vec<(usize, First)> = wrong
        .iter()
        .map(|&w| (w, firsts(search, set, codec, w)))
        .flat_map(|(w, firsts)| firsts.into_iter().map(move |first| (w, first)))
        .collect();
    // What only goes wrong where planes are predicted has another cause, and so has what other formats share.
    let mut in_streams: Vec<usize> = firsts.iter().map(|&(w, _)| w).collect();
    in_streams.dedup();
    let is_of_streams = in_streams.len() * 2 > wrong.len() || refused.len() > 3 * wrong.len();
    let elsewhere = left.iter().filter(|&&w| {
        let case = witnesses[w].case;
        case.expect == Expect::Decode && !codec.formats.contains(&case.format())
    });
    let one_trait = !refused.is_empty()
        && refusals::widest(witnesses, &refused)
            .iter()
            .any(|of| of.len() == refused.len());
    // A decoder of JPEG-LS that goes wrong is out of step from there on: what is right again was changed later.
    let recovers = |(_, first): &&(usize, First)| first.recovers == Some(true);
    let is_changed_later =
        codec.side == 1 && firsts.iter().filter(recovers).count() * 2 > firsts.len();
    if is_changed_later || !is_of_streams || elsewhere.count() * 4 > open.len() || one_trait {
        return None;
    }
    let words = words(search, set, codec, [&wrong, &refused], &firsts);
    left.retain(|w| !open.contains(w) && !others.contains(w));
    let category = match wrong.is_empty() {
        true => Category::Refusal,
        false => Category::Difference,
    };
    let mut diagnosis = Diagnosis::described(category, witnesses, &open, words).about("2.9.8/3");
    diagnosis
        .partly
        .extend(others.iter().map(|&w| witnesses[w].place));
    Some(diagnosis)
}

/// What is said of files that come out wrong, and of files that do not come out at all.
fn words(
    search: &Search,
    set: &[Id],
    codec: &Codec,
    [wrong, refused]: [&[usize]; 2],
    firsts: &[(usize, First)],
) -> Words {
    let witnesses = search.witnesses;
    // What other causes explain tells nothing here.
    let is_open = |w: &usize| !witnesses[*w].failed || wrong.contains(w) || refused.contains(w);
    let legal = (0..witnesses.len()).filter(|&w| is_legal(&witnesses[w], codec));
    let legal: Vec<usize> = legal.filter(is_open).collect();
    let evidence = evidence(search, set, codec, &legal);
    let says = (codec.says)();
    let slips = match wrong.len() < FEWEST {
        true => slips(search, codec, [wrong, refused], &legal),
        false => Vec::new(),
    };
    let shared = match what_matters(&slips) {
        None => shared_place(&evidence, codec, says.len())
            .map(|found| found.says(codec.places, says[found.feature])),
        slips => slips,
    };
    let mut manner = Manner::of(firsts);
    let mut shared = shared.unwrap_or_default();
    if codec.side == 8 && !wrong.is_empty() && refused.is_empty() {
        let blocks = |of: &[usize]| -> Vec<ShownBlock> {
            let files = of.iter().filter_map(|&w| FileStreams::of(&witnesses[w]));
            files.flat_map(|file| file.shown_blocks()).collect()
        };
        let passing = legal.iter().copied().filter(|&w| !witnesses[w].failed);
        let (blocks, right) = (blocks(wrong), blocks(&passing.collect::<Vec<_>>()));
        let largest = largest_error(&blocks);
        if let Some(number) = wrong_number(&blocks, &right) {
            (manner, shared) = (Manner::Number, format!(", all of them just {number}"));
        } else if largest < SMALL && matches!(manner, Manner::BlockByBlock) {
            manner = Manner::SmallErrors;
            shared = format!(", with errors of {largest:.0} at most");
        }
    }
    Words {
        effect: format!(
            "goes wrong in {} streams: of {} such files {} come out wrong and {} {}{}{}",
            codec.name,
            legal.len(),
            wrong.len(),
            refused.len(),
            outcome(witnesses, refused),
            shared,
            manner.says(),
        ),
        fix: manner.fix(codec),
        example: example_of(witnesses, firsts, refused),
    }
}

/// What becomes of the files of which no picture is shown.
fn outcome(witnesses: &[Witness], refused: &[usize]) -> &'static str {
    match &FailureMode::among(witnesses, refused)[..] {
        [FailureMode::Refuses] => "are refused",
        [FailureMode::Unsupported] => "are answered with 69 (unsupported)",
        _ => "not at all",
    }
}

/// What the first wrong places share. Where nothing is shown, what is so of whole streams comes first: headers are refused
/// before any block is read.
fn shared_place(evidence: &Evidence, codec: &Codec, features: usize) -> Option<Separation> {
    let of_streams = match evidence.wrong.is_empty() {
        true => separate(evidence, codec.of_streams),
        false => None,
    };
    of_streams
        .or_else(|| separate(evidence, features))
        .filter(|found| {
            let [wrong, others] = found.wrong;
            wrong == 0 || wrong * OFTEN >= found.right[0] && others * NEARLY_ALL <= wrong
        })
}

/// For one wrong place that has a feature there may be so many right ones, and for one that lacks it there must be so many
/// that have it: where there are more, it is but near to what matters.
const OFTEN: usize = 2;
const NEARLY_ALL: usize = 10;

/// Errors that no wrong code or coefficient would leave so small.
const SMALL: f64 = 32.0;

/// Slips that may be said beside each other.
const SLIPS: usize = 3;

/// Where next to nothing is shown: the slips that go wrong in just the files that are refused, and show what is shown. None
/// of them is certain.
fn slips(
    search: &Search,
    codec: &Codec,
    [wrong, refused]: [&[usize]; 2],
    legal: &[usize],
) -> Vec<StreamSlip> {
    let mut all: Vec<StreamSlip> = StreamSlip::all().collect();
    all.retain(|slip| slip.is_of(codec.formats[0]) && slip.may_refuse());
    let file = |w: &usize| FileStreams::of(&search.witnesses[*w]);
    let of_refused: Vec<FileStreams> = refused.iter().filter_map(file).collect();
    let of_wrong: Vec<FileStreams> = wrong.iter().filter_map(file).collect();
    let read = legal
        .iter()
        .filter(|w| !refused.contains(w) && !wrong.contains(w));
    let of_read: Vec<FileStreams> = read.filter_map(file).collect();
    let fits = search.each(&all, |slip| {
        let mut refused = of_refused.iter();
        let mut read = of_read.iter();
        refused.all(|file| file.fit(&[*slip]) == Fit::Refused)
            && (of_wrong.iter()).all(|file| !matches!(file.fit(&[*slip]), Fit::Other))
            && !read.any(|file| file.fit(&[*slip]) == Fit::Other)
    });
    let fitting = all.into_iter().zip(fits).filter(|(_, fits)| *fits);
    fitting.map(|(slip, _)| slip).collect()
}

/// What slips are about that fit: none of them is certain, and what they have in common nearly is.
fn what_matters(slips: &[StreamSlip]) -> Option<String> {
    let about = slips.first()?.about();
    let is_one = slips.iter().all(|slip| slip.about() == about);
    let effects: Vec<&str> = slips.iter().map(|slip| slip.effect()).collect();
    match slips.len() {
        0..=SLIPS => Some(format!(
            ", just those in which it matters that a decoder {}; or another mistake in {about}",
            effects.join(", or ")
        )),
        _ if is_one => Some(format!(
            ", just those in which mistakes in {about} show; for example that a decoder {}",
            effects[0]
        )),
        _ => None,
    }
}

/// Takes away mistakes of the catalog that explain the refused files of a codec in parts, where one slip in the decoder of
/// its streams would fail just these.
fn drop_parts(
    search: &Search,
    found: &mut Found,
    codec: &Codec,
    refused: &[usize],
    legal: &[usize],
) {
    let set = of(&found.members);
    let explains = |id: Id, w: usize| search.agreement(w, &[id]).explains();
    let explained: Vec<Vec<usize>> = search.each(&set, |&id| {
        let of = (0..search.witnesses.len()).filter(|&w| search.witnesses[w].failed);
        of.filter(|&w| explains(id, w)).collect()
    });
    let is_part = |of: &Vec<usize>| {
        !of.is_empty() && of.len() < refused.len() && of.iter().all(|w| refused.contains(w))
    };
    let is_said = || what_matters(&slips(search, codec, [&[], refused], legal)).is_some();
    if explained.iter().any(is_part) && is_said() {
        let keep: Vec<bool> = explained.iter().map(|of| !is_part(of)).collect();
        found.keep(&keep);
    }
}

/// How blocks of JPEG come out wrong.
enum Manner {
    /// All samples of the first wrong block are off by one amount, also where they differ.
    ByOneAmount,
    /// Blocks after it are right.
    BlockByBlock,
    /// The same, and no sample is far off.
    SmallErrors,
    /// All blocks are as one wrong number of the inverse DCT makes them.
    Number,
    Unknown,
}

impl Manner {
    fn of(firsts: &[(usize, First)]) -> Manner {
        let nearly_all = |count: usize, all: usize| all >= FEWEST && count * 20 >= all * 19;
        let count =
            |holds: fn(&First) -> bool| firsts.iter().filter(|(_, first)| holds(first)).count();
        let uniform = count(|first| first.is_uniform == Some(true));
        if nearly_all(uniform, count(|first| first.is_uniform.is_some())) {
            return Manner::ByOneAmount;
        }
        let (right, all) = (
            count(|first| first.recovers == Some(true)),
            count(|first| first.recovers.is_some()),
        );
        match nearly_all(right, all) {
            true => Manner::BlockByBlock,
            false => Manner::Unknown,
        }
    }

    fn says(&self) -> &'static str {
        match self {
            Manner::ByOneAmount => "; all samples of such a block are off by one amount",
            Manner::BlockByBlock | Manner::SmallErrors => "; most that follow are right again",
            Manner::Number | Manner::Unknown => "",
        }
    }

    fn fix(&self, codec: &Codec) -> String {
        let standard = codec.standard;
        match self {
            Manner::ByOneAmount => format!(
                "compare the DC coefficient of the first block that is wrong with {standard}: its difference, its prediction, its step"
            ),
            Manner::BlockByBlock => format!(
                "the codes are read in step: compare order and step of the coefficients, inverse DCT and limits of the first block that is wrong with {standard}"
            ),
            Manner::SmallErrors => format!(
                "the codes are read in step: compare the constants, the rounding and the limits of the inverse DCT with {standard}"
            ),
            Manner::Number => format!(
                "compare this number of the inverse DCT with {standard} A.3.3, or with the source that it was taken from"
            ),
            Manner::Unknown => format!(
                "compare the decoder of these streams with {standard}, from the first sample that is wrong"
            ),
        }
    }
}

/// The first wrong sample of the smallest file, or the smallest file that was refused.
fn example_of(witnesses: &[Witness], firsts: &[(usize, First)], refused: &[usize]) -> String {
    let smallest = firsts.iter().min_by_key(|(w, _)| {
        let witness = &witnesses[*w];
        (
            witness.observation.view != View::Raw,
            witness.built.file.len(),
        )
    });
    match smallest {
        Some((w, first)) => format!(
            "for example {}, plane {}: received {}, expected {} in column {} of row {} of its stream, the first that is wrong, both counted from 0",
            witnesses[*w].case.id, first.plane, first.got, first.want, first.column, first.row
        ),
        None => example(witnesses, refused),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use super::*;
    use crate::decode::planes;
    use crate::diagnose::diagnosis::Cause;
    use crate::diagnose::witness::witnesses;
    use crate::error::Result;
    use crate::misreadings;
    use crate::parts::PlaneStream;
    use crate::reading::Reading;
    use crate::runner::run::Request;
    use crate::session::plan::RunPlan;
    use crate::session::run::check;
    use crate::suite::cases::Suite;

    /// What is said of a decoder that makes these samples of a stream.
    #[track_caller]
    fn effects(stream: fn(&PlaneStream) -> Result<Vec<u8>>) -> Vec<String> {
        let mut suite = Suite::load().expect("the suite loads");
        suite.cases.retain(|case| {
            let is_sized = case.id.starts_with("planes-in-size");
            case.first || is_sized || case.clauses == ["2.9.8/3"] && case.damage().is_none()
        });
        let reading = Reading {
            stream,
            ..Reading::SPEC
        };
        let ask = |request: &Request<'_>, _: usize| {
            misreadings::answer(&[], reading, request.file, request.view).into()
        };
        let run = check(&suite, &RunPlan::of(&suite, 2), &ask, &|_, _, _, _| ());
        let witnesses = witnesses(&suite, &run, None, 2);
        let stop = AtomicBool::new(false);
        let search = Search::new(&witnesses, &[], 2, &stop);
        let failed = (0..witnesses.len()).filter(|&w| witnesses[w].failed);
        let diagnoses = describe(&search, &Found::default(), &mut failed.collect());
        let effects = diagnoses
            .into_iter()
            .map(|diagnosis| match diagnosis.cause {
                Cause::Described { effect, .. } => effect,
                Cause::Misreading { .. } => unreachable!("these are words"),
            });
        effects.collect()
    }

    /// The samples, with those changed that are at these columns and rows.
    fn changed(stream: &PlaneStream, at: impl Fn(usize, usize) -> bool) -> Result<Vec<u8>> {
        let mut samples = planes::stream(stream)?;
        let width = stream.size.width as usize;
        for (i, sample) in samples.iter_mut().enumerate() {
            *sample ^= if at(i % width, i / width) { 0x55 } else { 0 };
        }
        Ok(samples)
    }

    #[test]
    fn wrong_blocks_are_told_by_their_place_in_the_plane() {
        let effects = effects(|stream| {
            let width = stream.size.width as usize;
            changed(stream, |x, _| {
                stream.format.is_jpeg() && width.is_multiple_of(8) && x + 8 >= width
            })
        });
        assert_eq!(effects.len(), 1, "{effects:?}");
        let words = "first at blocks at the end of a row, of planes whose width is a multiple of 8";
        assert!(effects[0].contains(words), "{effects:?}");
    }

    #[test]
    fn samples_of_jpeg_ls_that_are_right_again_were_changed_after_they_were_decoded() {
        let effects =
            effects(|stream| changed(stream, |x, y| stream.format.is_jpeg_ls() && x + y == 1));
        assert!(effects.is_empty(), "{effects:?}");
    }

    #[test]
    fn wrong_samples_are_told_by_their_place_in_the_plane() {
        // A decoder of JPEG-LS that goes wrong stays so.
        let effects = effects(|stream| changed(stream, |_, y| stream.format.is_jpeg_ls() && y > 0));
        assert_eq!(effects.len(), 1, "{effects:?}");
        let words = "first at samples in the first column of a row that is not the first";
        assert!(effects[0].contains(words), "{effects:?}");
    }
}
