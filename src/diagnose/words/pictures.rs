//! Wrong pictures of unknown cause: how they differ, and where.

use super::formats::formats_of;
use super::places::{Claim, channels_concerned, root_channels, texels_concerned};
use super::refusals::WORTH_SAYING;
use crate::diagnose::diagnosis::{Category, Diagnosis, Words};
use crate::diagnose::files::scope::Scope;
use crate::diagnose::files::shared::{Shared, shared};
use crate::diagnose::layout::blocks::{Block, block_clause, row_clause, texel_clause};
use crate::diagnose::layout::provenance;
use crate::diagnose::pair::{Pair, distance};
use crate::diagnose::search::{Id, Search, without};
use crate::diagnose::values::arithmetic::arithmetic;
use crate::diagnose::values::formulas::single_slips;
use crate::diagnose::values::numbers::{self, OTHER_BIAS, OTHER_SCALE};
use crate::diagnose::values::relations::{self, ROWS, relations};
use crate::diagnose::witness::Witness;
use crate::protocol::frame::{Answer, Frame, Samples, View};
use crate::ptm::Format;
use crate::session::observation::Response;
use crate::suite::cases::Expect;
use crate::suite::compare::{Expected, ExpectedValues, apart};
use crate::suite::dialect::Right;

/// What inverse transforms of lossy planes may make of one stream, and of a plane that is predicted from another.
const TRANSFORM: f64 = 4.0;
/// Files of which something is said; what fewer share may be chance.
const FEWEST: usize = 3;
/// Ways to differ that are told apart; what is beyond, or true of few, is said together.
const WAYS: usize = 6;
/// Formats that are named where wrong pictures share nothing else.
const FORMATS: usize = 2;
/// Diagnoses of pictures of which nothing is said but that they are wrong, and where.
const MOST_GROUPS: usize = 12;

/// What is shown of a file by one reading of an open question, and of the others by another.
const MIXED: &str =
    "pictures that are right by another reading of an open question than its other pictures are";
/// What is shown where bytes are read from another place.
const ELSEWHERE: &str = "the values that stand";

/// Where wrong values are is said if one in so many suites would have them there by chance.
const CHANCE: f64 = 500.0;

/// All that is true of how one picture differs, and of where; the most telling first.
#[derive(Default)]
struct Said {
    what: Vec<String>,
    channels: Vec<Claim>,
    texels: Vec<Claim>,
}

/// The wrong pictures in `left`, alike ones together. `set` are the mistakes that have been found.
pub(in crate::diagnose) fn describe(search: &Search, set: &[Id], left: &[usize]) -> Vec<Diagnosis> {
    let said: Vec<Said> = search.each(left, |&w| say(search, set, w));
    let mut open: Vec<usize> = (0..left.len()).collect();
    let mut diagnoses = Vec::new();
    while !open.is_empty() {
        // What can be said of most; and at the end, what can be said of every wrong picture.
        let what = match diagnoses.len() {
            0..WAYS => commonest(open.iter().flat_map(|&i| &said[i].what)),
            _ => None,
        };
        let telling = what.and_then(|what| {
            let holds = |&i: &usize| said[i].what.contains(&what);
            let of: Vec<usize> = open.iter().copied().filter(holds).collect();
            (of.len() * WORTH_SAYING >= open.len()).then_some((what, of))
        });
        let (what, of) = telling.unwrap_or_else(|| {
            let of = match diagnoses.len() {
                0..MOST_GROUPS => alike_in_place(search, left, &said, &open),
                _ => open.clone(),
            };
            ("wrong values".to_owned(), of)
        });
        open.retain(|i| !of.contains(i));
        let sides: [fn(&Said) -> &[Claim]; 2] = [|said| &said.channels, |said| &said.texels];
        let of_these: Vec<&Said> = of.iter().map(|&i| &said[i]).collect();
        // Neighbors are wrong together: in few pictures they may be at one place by chance.
        let places = sides.iter().take(if of.len() > FEWEST { 2 } else { 1 });
        let place: Vec<&str> = places
            .filter_map(|side| {
                let mut claims = shared_claims(&of_these, *side).into_iter();
                let telling = claims.find(|claim| claim.chance + CHANCE.ln() < 0.0);
                telling.map(|claim| claim.says)
            })
            .collect();
        let of: Vec<usize> = of.iter().map(|&i| left[i]).collect();
        let others: Vec<usize> = left.iter().copied().filter(|w| !of.contains(w)).collect();
        let is_changed = |&w: &usize| *search.made(w, set) != search.witnesses[w].right;
        let besides = match of.iter().any(is_changed) {
            true => ", besides what other causes change",
            false => "",
        };
        let what = format!("{what}{}{besides}", place.concat());
        diagnoses.push(difference(search, set, &of, &others, &what));
    }
    diagnoses
}

/// What is true of all these pictures, and how likely that is by chance.
fn shared_claims(of: &[&Said], side: fn(&Said) -> &[Claim]) -> Vec<Claim> {
    let first = of.first().map_or(&[][..], |said| side(said));
    let everywhere = |claim: &Claim| {
        let same = |said: &&Said| {
            side(said)
                .iter()
                .find(|other| other.says == claim.says)
                .copied()
        };
        let chances = of.iter().map(|said| Some(same(said)?.chance));
        let chance = chances.sum::<Option<f64>>()?;
        Some(Claim { chance, ..*claim })
    };
    first.iter().filter_map(everywhere).collect()
}

/// Of pictures that nothing else is said of, those of the formats that are wrong in the same channels as the first one's:
/// what is wrong in other channels elsewhere is another mistake.
fn alike_in_place(search: &Search, left: &[usize], said: &[Said], open: &[usize]) -> Vec<usize> {
    let format = |i: usize| search.witnesses[left[i]].case.format();
    let channels = |of: Format| {
        let pictures = open.iter().filter(|&&i| format(i) == of);
        let pictures: Vec<&Said> = pictures.map(|&i| &said[i]).collect();
        let claims = shared_claims(&pictures, |said| &said.channels);
        claims.first().map(|claim| claim.says)
    };
    let first = channels(format(open[0]));
    let is_alike = |i: &usize| channels(format(*i)) == first;
    open.iter().copied().filter(is_alike).collect()
}

const BYTES: &str = "compare the bytes that the example names with what is read there";

/// Whether nothing but stored colors, or Cr and Cb, are wrong in a picture of stored or final values.
fn is_of_colors(search: &Search, w: usize) -> bool {
    pair_of(search, &[], w).is_some_and(|pair| {
        let is_color = |i: &usize| matches!(pair.channels, 8 | 9) && i % pair.channels >= 6;
        pair.wrong().iter().all(is_color)
    })
}

/// A way to differ, in words.
fn difference(
    search: &Search,
    set: &[Id],
    of: &[usize],
    others: &[usize],
    what: &str,
) -> Diagnosis {
    let witnesses = search.witnesses;
    let smallest = smallest(witnesses, of);
    let is_compressed = witnesses[smallest].case.format().is_compressed();
    let fix = match witnesses[smallest].observation.view {
        View::Raw if is_compressed => {
            "follow this sample by hand: the stream of its plane, the plane that it is predicted from, and only then side information"
        }
        View::Raw => BYTES,
        View::Coef if is_of_colors(search, smallest) => BYTES,
        View::Coef => "follow scale and bias of this value by hand",
        View::Rgb(_) => {
            "follow this texel by hand: scale and bias, the polynomial, the color, and only then rounding and clamping"
        }
    };
    let words = Words {
        effect: format!(
            "shows {what}{}; the cause is unknown",
            files(search, of, others)
        ),
        fix: fix.to_owned(),
        example: example_beside(search, set, smallest),
    };
    let diagnosis = Diagnosis::described(Category::Difference, witnesses, of, words);
    let format = witnesses[of[0]].case.format();
    let clause = match what {
        _ if is_of_another_size(&witnesses[smallest]) => Some("2.3/1"),
        _ if what.starts_with(OTHER_BIAS) => Some("2.4/4"),
        _ if what.starts_with(OTHER_SCALE) => Some("2.4/3"),
        _ if what.starts_with(ELSEWHERE) => block_clause(format, Block::All),
        _ if what.starts_with(ROWS) => row_clause(format),
        _ => stored_values_of(search, of).or_else(|| values_of(witnesses, of)),
    };
    match clause {
        Some(clause) => diagnosis.about(clause),
        None => diagnosis,
    }
}

/// Whether the picture that is shown is not as wide and high as the map.
fn is_of_another_size(witness: &Witness) -> bool {
    let size = |frame: &Frame| (frame.width, frame.height);
    match (&witness.observation.response, &witness.right) {
        (
            Response::Picture {
                frame: Some(shown), ..
            },
            Answer::Decoded(right),
        ) => size(shown) != size(right),
        _ => false,
    }
}

/// What these files share, and none that is shown right has. `others` are wrong too, otherwise: what is so from a number on is
/// not wrong below it.
fn files(search: &Search, of: &[usize], others: &[usize]) -> String {
    let witnesses = search.witnesses;
    let is_right = |w: &usize| {
        let witness = &witnesses[*w];
        !witness.failed
            && witness.case.expect == Expect::Decode
            && matches!(&witness.observation.response, Response::Picture { right, .. } if *right != Right::Anyway(false))
    };
    let right: Vec<usize> = (0..witnesses.len()).filter(is_right).collect();
    if of.len() < FEWEST {
        return String::new();
    }
    // Two things together, where what is wrong has a place of its own, are of the suite and not of the decoder.
    let shared = shared(witnesses, of, &right, false);
    let is_said = |shared: &Shared| match shared.scope {
        Scope::Both(..) => false,
        Scope::Beyond { .. } => others.iter().all(|&w| {
            let format = witnesses[w].case.format();
            shared.scope.holds(&witnesses[w])
                || of.iter().all(|&one| witnesses[one].case.format() != format)
        }),
        _ => true,
    };
    match shared.filter(is_said) {
        Some(shared) if shared.of.len() == of.len() => {
            format!(", in every file {}", shared.says())
        }
        Some(shared) if shared.of.len() * 4 > of.len() * 3 => format!(
            ", in every file {} ({} of these {})",
            shared.says(),
            shared.of.len(),
            of.len()
        ),
        _ => formats_of(witnesses, of, FORMATS),
    }
}

/// Where stored values of a file without streams are wrong, the clause that places them.
fn stored_values_of(search: &Search, of: &[usize]) -> Option<&'static str> {
    let raw = of.iter().find(|&&w| {
        let witness = &search.witnesses[w];
        witness.observation.view == View::Raw && !witness.case.format().is_compressed()
    })?;
    let format = search.witnesses[*raw].case.format();
    let is_of_colors = is_of_colors(search, *raw);
    let block = if is_of_colors {
        Block::Colors
    } else {
        Block::All
    };
    match (format, is_of_colors) {
        (Format::PtmLut, false) => texel_clause(format),
        _ => block_clause(format, block).or(texel_clause(format)),
    }
}

/// Where these cases have no clause in common: the one that says how the values come about that are wrong.
fn values_of(witnesses: &[Witness], of: &[usize]) -> Option<&'static str> {
    let [first, others @ ..] = of else {
        return None;
    };
    let clauses = |w: usize| &witnesses[w].case.clauses;
    let is_shared = |clause: &String| others.iter().all(|&w| clauses(w).contains(clause));
    if clauses(*first).iter().any(is_shared) {
        return None;
    }
    let channels = |w: usize| witnesses[w].case.format().channels();
    let alike = of.iter().all(|&w| channels(w) == channels(*first));
    match witnesses[*first].observation.view {
        View::Rgb(_) if alike && channels(*first) == 9 => Some("2.7.3/4"),
        View::Rgb(_) if alike && channels(*first) == 8 => Some("2.6/4"),
        View::Rgb(_) => Some("1.0/1"),
        View::Coef => Some("2.4/8"),
        View::Raw => None,
    }
}

/// How many pictures one wrong number in a formula explains, the one that explains most.
pub(in crate::diagnose) fn widest_slip(search: &Search, failing: &[usize]) -> usize {
    let slips = search.each(failing, |&w| {
        let witness = &search.witnesses[w];
        match (&witness.observation.response, witness.decoded()) {
            (
                Response::Picture {
                    frame: Some(received),
                    ..
                },
                Ok(ptm),
            ) => {
                let view = &witness.observation.view;
                single_slips(ptm, view, &witness.reading, received)
            }
            _ => Vec::new(),
        }
    });
    let slips: Vec<String> = slips.into_iter().flatten().map(|(_, says)| says).collect();
    commonest(slips.iter()).map_or(0, |widest| {
        slips.iter().filter(|&slip| *slip == widest).count()
    })
}

/// Whether all wrong samples are off, modulo 256, by no more than so many shifts of their stream and of its references.
fn wrong_by_shifts(right: &Frame, shown: &Frame, shift: i8) -> bool {
    let (Samples::U8(right), Samples::U8(shown)) = (&right.samples, &shown.samples) else {
        return false;
    };
    let most = shift.unsigned_abs().saturating_mul(8);
    right.len() == shown.len()
        && (right.iter().zip(shown)).all(|(&right, &shown)| distance(right, shown) <= most)
}

/// Whether the decoder goes wrong in `w` much as one with the mistake `member` does.
pub(in crate::diagnose) fn is_near(search: &Search, w: usize, set: &[Id], member: Id) -> bool {
    let witness = &search.witnesses[w];
    let (with, without) = (search.made(w, set), search.made(w, &without(set, member)));
    let (Answer::Decoded(with), Answer::Decoded(without)) = (&*with, &*without) else {
        return false;
    };
    if with == without {
        return false;
    }
    let solved = search.mistakes[member].solved();
    if solved.is_some_and(|solved| solved.act.is_of_streams(witness.case.format())) {
        return true;
    }
    match &witness.observation.response {
        Response::Picture {
            frame: Some(shown), ..
        } => {
            let lossy = matches!(witness.case.format(), Format::JpegRgb | Format::JpegLrgb);
            let slack = if lossy { TRANSFORM } else { 0.0 };
            let wrong = |made: &Frame| Some(Pair::of(made, shown)?.wrong_by_more_than(slack));
            // Samples at a limit may have been beyond it before they were shifted.
            let shift = solved.and_then(|solved| solved.act.level_shift());
            if let Some(shift) = shift.filter(|_| lossy && witness.observation.view == View::Raw) {
                return wrong_by_shifts(without, shown, shift);
            }
            matches!((wrong(with), wrong(without)), (Some(with), Some(without)) if with * 2 < without)
        }
        // One decoder shows nonsense where another gives up; but only a mistake about few files says so much.
        Response::Rejected | Response::Violation(Answer::Crashed(_)) => {
            let listed = search.mistakes[member].listed();
            listed.is_some_and(|misreading| {
                ["2.5", "2.6", "2.8", "2.9"]
                    .iter()
                    .any(|section| misreading.clause.starts_with(section))
            })
        }
        _ => false,
    }
}

fn say(search: &Search, set: &[Id], w: usize) -> Said {
    let plain = |what: &str| Said {
        what: vec![what.to_owned()],
        ..Said::default()
    };
    let witness = &search.witnesses[w];
    let received = match &witness.observation.response {
        Response::Picture {
            frame: Some(received),
            ..
        } => received,
        // What is right by a reading of its own is not kept.
        Response::Picture { frame: None, .. } => return plain(MIXED),
        _ => return plain("no picture"),
    };
    let made = search.made(w, set);
    // The mistakes that were found may refuse what the reference reads.
    let ((Answer::Decoded(wanted), _) | (_, Answer::Decoded(wanted))) = (&*made, &witness.right)
    else {
        return plain("a picture of a file that should be refused");
    };
    let Some(mut pair) = Pair::of(wanted, received) else {
        return plain(&of_shape(wanted, received));
    };
    if pair.wrong().is_empty() {
        // Wrong by less than a color and its neighbor differ: what is exact tells.
        pair.want = witness.exact(wanted).unwrap_or(pair.want);
    }
    if pair.wrong().is_empty() {
        return plain("values that are off by little more than rounding allows");
    }
    // How it differs is said of the reference's own picture, whatever mistakes were found.
    let own = match &witness.right {
        Answer::Decoded(right) if right != wanted => Pair::of(right, received),
        _ => None,
    };
    let mut what = relations(own.as_ref().unwrap_or(&pair));
    what.extend(numbers::used(&pair, witness).map(|used| used.says.to_owned()));
    if let Some(shift) = provenance::shift(witness, &pair) {
        let count = shift.unsigned_abs();
        let way = if shift > 0 { "later" } else { "earlier" };
        let bytes = if count == 1 { "byte" } else { "bytes" };
        what.push(format!(
            "{ELSEWHERE} {count} {bytes} {way} in the file: the binary data is read from a wrong place"
        ));
    }
    Said {
        what,
        channels: channels_concerned(&pair, witness),
        texels: texels_concerned(&pair, witness),
    }
}

/// What occurs most often; among equals what comes first.
fn commonest<'a>(claims: impl Iterator<Item = &'a String>) -> Option<String> {
    let mut counts: Vec<(&String, usize)> = Vec::new();
    for claim in claims {
        match counts.iter_mut().find(|(known, _)| *known == claim) {
            Some((_, count)) => *count += 1,
            None => counts.push((claim, 1)),
        }
    }
    let most = counts.iter().map(|&(_, count)| count).max()?;
    let first = counts.iter().find(|&&(_, count)| count == most)?;
    Some(first.0.clone())
}

/// A picture of another shape.
fn of_shape(wanted: &Frame, shown: &Frame) -> String {
    let size = |frame: &Frame| (frame.width, frame.height);
    if wanted.view != shown.view {
        format!("view {} where {} was asked for", shown.view, wanted.view)
    } else if std::mem::discriminant(&wanted.samples) != std::mem::discriminant(&shown.samples) {
        "samples of another type (raw and rgb are u8, coef is f32)".to_owned()
    } else if wanted.channels != shown.channels {
        format!(
            "{} channels where there are {}",
            shown.channels, wanted.channels
        )
    } else if size(wanted) == (shown.height, shown.width) {
        "width and height exchanged".to_owned()
    } else {
        of_size(size(wanted), size(shown))
    }
}

/// What may become of one length: words, and the function.
const LENGTHS: &[(&str, fn(u32) -> u32)] = &[
    ("one less than it should be", |n| n.wrapping_sub(1)),
    ("one more than it should be", |n| n + 1),
    ("cut off to its low 16 bits", |n| n & 0xffff),
    ("cut off to its low 8 bits", |n| n & 0xff),
    ("rounded up to a multiple of 8", |n| n.next_multiple_of(8)),
    ("rounded up to a multiple of 4", |n| n.next_multiple_of(4)),
    ("rounded up to a multiple of 2", |n| n.next_multiple_of(2)),
    ("rounded down to a multiple of 8", |n| n / 8 * 8),
    ("rounded down to a multiple of 4", |n| n / 4 * 4),
    ("rounded down to a multiple of 2", |n| n / 2 * 2),
    ("half of what it should be", |n| n / 2),
    ("twice what it should be", |n| n.saturating_mul(2)),
    ("without its last digit", |n| n / 10),
];

/// A picture of another size, in words.
fn of_size(wanted: (u32, u32), shown: (u32, u32)) -> String {
    let length = |name: &str, wanted: u32, shown: u32| {
        let mut known = LENGTHS.iter().filter(|(_, of)| of(wanted) == shown);
        // Of a single number that may be several things nobody knows which it is.
        match (known.next(), known.next()) {
            (Some((says, _)), None) => format!("a picture whose {name} is {says}"),
            _ => format!("a picture of another {name}"),
        }
    };
    match (wanted.0 == shown.0, wanted.1 == shown.1) {
        (true, _) => length("height", wanted.1, shown.1),
        (_, true) => length("width", wanted.0, shown.0),
        _ if shown.0 == shown.1 && (shown.0 == wanted.0 || shown.0 == wanted.1) => {
            "a picture as wide as high".to_owned()
        }
        _ => "a picture of another width and height".to_owned(),
    }
}

/// What was shown, and what a decoder with these mistakes shows, where both are pictures of one shape.
pub(in crate::diagnose) fn pair_of(search: &Search, set: &[Id], w: usize) -> Option<Pair> {
    match (
        &search.witnesses[w].observation.response,
        &*search.made(w, set),
    ) {
        (
            Response::Picture {
                frame: Some(shown), ..
            },
            Answer::Decoded(wanted),
        ) => Pair::of(wanted, shown),
        _ => None,
    }
}

/// The smallest of these files; where stored or final values are shown, of these: there is less to follow.
pub(in crate::diagnose) fn smallest(witnesses: &[Witness], of: &[usize]) -> usize {
    let is_color = |w: usize| witnesses[w].is_in_colors();
    let size = |w: &usize| (is_color(*w), witnesses[*w].built.file.len());
    let smallest = of.iter().copied().min_by_key(size);
    smallest.expect("a diagnosis explains at least one case")
}

/// The first wrong value of a file: the reference's own, the one received, the bytes and the arithmetic.
pub(in crate::diagnose) fn example(search: &Search, w: usize) -> String {
    example_beside(search, &[], w)
}

/// The same, where these mistakes do not explain the sample.
fn example_beside(search: &Search, set: &[Id], w: usize) -> String {
    let witness = &search.witnesses[w];
    let id = &witness.case.id;
    let first = pair_of(search, &Vec::new(), w).and_then(|mut pair| {
        if let Some(exact) = expected(witness, &pair) {
            pair.want = exact;
        }
        let open = pair_of(search, set, w).map(|beside| beside.wrong());
        let first = first_wrong(&pair, witness, &open.unwrap_or_default())?;
        Some((pair, first))
    });
    let Some((pair, i)) = first else {
        return format!("for example {id}: {}", witness.case.because);
    };
    let (texel, channel) = (i / pair.channels, i % pair.channels);
    let (x, y) = (texel % pair.width, texel / pair.width);
    let [got, want] = apart(pair.got[i], pair.want[i], 4);
    let mut says = format!(
        "for example {id}, texel ({x}, {y}), {}: received {got}, expected {want}",
        pair.name(channel),
    );
    says.extend(numbers::used(&pair, witness).map(|used| used.in_words()));
    let elsewhere = relations::in_words(&pair);
    if elsewhere.is_some() {
        says.extend(elsewhere);
        return says;
    }
    says.extend(arithmetic(witness, texel, channel).map(|steps| format!(" = {steps}")));
    let origin = match pair.view {
        "rgb" => provenance::texel(witness, x, y),
        _ => provenance::sample(witness, x, y, channel),
    };
    says.extend(origin.map(|origin| format!("; it comes from {origin}")));
    says
}

/// The first wrong sample; in compressed planes the first that is stored, of the first plane in which it begins.
fn first_wrong(pair: &Pair, witness: &Witness, open: &[usize]) -> Option<usize> {
    let mut wrong = pair.wrong();
    let is_open = |i: &usize| open.binary_search(i).is_ok();
    if wrong.iter().any(is_open) {
        wrong.retain(is_open);
    }
    if !witness.case.format().is_compressed() || pair.view == "rgb" {
        return wrong.first().copied();
    }
    let roots = root_channels(pair, witness);
    let wrong = wrong.into_iter().filter(|i| roots[i % pair.channels]);
    let stored = |&i: &usize| {
        let (texel, plane) = (i / pair.channels, i % pair.channels);
        (
            plane,
            pair.height - 1 - texel / pair.width,
            texel % pair.width,
        )
    };
    wrong.min_by_key(stored)
}

/// What the suite expects, not rounded.
fn expected(witness: &Witness, pair: &Pair) -> Option<Vec<f64>> {
    let view = &witness.observation.view;
    let expected = Expected::of(&witness.built.values, view)?;
    let values = match expected.values {
        ExpectedValues::Rgb(values) | ExpectedValues::Coef(values) => values,
        ExpectedValues::Raw(_) => return None,
    };
    (values.len() == pair.want.len()).then_some(values)
}
