//! Wrong pictures that no mistake of the catalogue makes: how they differ, and where.

use super::formulas::{self, Formula};
use super::provenance;
use super::refusals::{WORTH_SAYING, shared};
use super::search::Search;
use super::witness::Witness;
use super::{Diagnosis, Kind};
use crate::generate::scene::Compressed;
use crate::harness::cases::Expect;
use crate::harness::compare::{COLOR, is_close};
use crate::harness::judge::{Right, Shown};
use crate::harness::misreadings::Misreading;
use crate::harness::protocol::{Answer, Frame, Samples, View};
use crate::ptm::{Format, channel_name};

/// What inverse transforms of lossy planes may make of one stream, and of a plane that is predicted from another.
const TRANSFORM: f64 = 4.0;
/// Files of which something is said; what fewer share may be chance.
const FEWEST: usize = 3;
/// Kinds of difference that are told apart; what is beyond, or true of few, is said together.
const KINDS: usize = 6;

/// The wrong pictures in `left`, alike ones together. `set` are the mistakes that have been found.
pub(super) fn describe(
    search: &Search,
    set: &[&'static Misreading],
    left: &[usize],
) -> Vec<Diagnosis> {
    let witnesses = search.witnesses;
    let said: Vec<Said> = search.each(left, |&w| say(search, set, w));
    let mut open: Vec<usize> = (0..left.len()).collect();
    let mut kinds: Vec<((Claim, String), Vec<usize>)> = Vec::new();
    while !open.is_empty() {
        // What can be said of most; and at the end, what can be said of every wrong picture.
        let what = if kinds.len() < KINDS {
            commonest(open.iter().flat_map(|&i| &said[i].what))
        } else {
            None
        };
        let telling = what.map(|what| {
            let holds = |&&i: &&usize| said[i].what.contains(&what);
            let of: Vec<usize> = open.iter().filter(holds).copied().collect();
            (what, of)
        });
        let (what, of) = telling
            .filter(|(_, of)| of.len() * WORTH_SAYING >= open.len())
            .unwrap_or_else(|| (Claim::from("wrong values".to_owned()), open.clone()));
        open.retain(|i| !of.contains(i));
        let mut place = String::new();
        let sides: [fn(&Said) -> &Vec<String>; 2] = [|said| &said.channels, |said| &said.texels];
        for side in sides {
            let first = side(&said[of[0]]).iter();
            let mut shared =
                first.filter(|claim| of.iter().all(|&i| side(&said[i]).contains(claim)));
            place.push_str(shared.next().map_or("", String::as_str));
        }
        kinds.push(((what, place), of.iter().map(|&i| left[i]).collect()));
    }
    let right: Vec<usize> = (0..witnesses.len())
        .filter(|&w| {
            let witness = &witnesses[w];
            !witness.failed
                && witness.case.expect == Expect::Decode
                && matches!(&witness.finding.shown, Shown::Picture { right, .. } if *right != Right::Anyway(false))
        })
        .collect();
    kinds
        .into_iter()
        .map(|((what, place), of)| {
            let files = match shared(witnesses, &of, &right, false) {
                _ if of.len() < FEWEST => String::new(),
                Some((says, having)) if having.len() == of.len() => {
                    format!(", in every file {says}")
                }
                Some((says, having)) if having.len() * 4 > of.len() * 3 => format!(
                    ", in every file {says} ({} of these {})",
                    having.len(),
                    of.len()
                ),
                _ => String::new(),
            };
            let smallest = of
                .iter()
                .copied()
                .min_by_key(|&w| witnesses[w].built.file.len())
                .expect("a kind has at least one case");
            let mend = what.formula.map_or_else(
                || match witnesses[of[0]].finding.view {
                    View::Raw => "compare these bytes of the file with what is read there",
                    View::Coef => "follow scale and bias of this value by hand",
                    View::Rgb(_) => {
                        "follow this texel by hand: scale and bias, the polynomial, the color, and only then rounding and cutting off"
                    }
                },
                Formula::mend,
            );
            let diagnosis = Diagnosis::described(
                Kind::Difference,
                witnesses,
                &of,
                (
                    format!("shows {}{place}{files}", what.says),
                    mend.to_owned(),
                    example(search, set, smallest),
                ),
            );
            match what.formula {
                Some(formula) => diagnosis.about(formula.clause()),
                None => match values_of(witnesses, &of) {
                    Some(clause) => diagnosis.about(clause),
                    None => diagnosis,
                },
            }
        })
        .collect()
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
    let all = |formats: &[Format]| {
        of.iter()
            .all(|&w| formats.contains(&witnesses[w].case.format()))
    };
    let of_luminance = [
        Format::Lrgb,
        Format::PtmLut,
        Format::PtmCLut,
        Format::JpegLrgb,
        Format::JpeglsLrgb,
    ];
    match witnesses[*first].finding.view {
        View::Rgb(_) if all(&of_luminance) => Some("2.7.3/4"),
        View::Rgb(_) if all(&[Format::Lum]) => Some("2.6/4"),
        View::Rgb(_) => Some("1.0/1"),
        View::Coef => Some("2.4/8"),
        View::Raw => None,
    }
}

/// How many pictures one wrong number in a formula explains, the one that explains most.
pub(super) fn widest_slip(search: &Search, failing: &[usize]) -> usize {
    let slips = search.each(failing, |&w| match &search.witnesses[w].finding.shown {
        Shown::Picture {
            frame: Some(shown), ..
        } => claims_of_slips(search, w, shown),
        _ => Vec::new(),
    });
    let slips: Vec<Claim> = slips.into_iter().flatten().collect();
    commonest(slips.iter()).map_or(0, |widest| {
        slips.iter().filter(|&slip| *slip == widest).count()
    })
}

fn claims_of_slips(search: &Search, w: usize, shown: &Frame) -> Vec<Claim> {
    let slips = formulas::slips(&search.witnesses[w], shown);
    let claim = |(formula, says)| Claim {
        says: format!("values as if {says}"),
        formula: Some(formula),
    };
    slips.into_iter().map(claim).collect()
}

/// Whether the decoder goes wrong in `w` much as one with `misreading` does.
pub(super) fn is_near(
    search: &Search,
    w: usize,
    set: &[&'static Misreading],
    misreading: &'static Misreading,
) -> bool {
    let witness = &search.witnesses[w];
    let without: Vec<&'static Misreading> = set
        .iter()
        .copied()
        .filter(|other| other.slug != misreading.slug)
        .collect();
    let (with, without) = (search.made(w, set), search.made(w, &without));
    let (Answer::Decoded(with), Answer::Decoded(without)) = (&*with, &*without) else {
        return false;
    };
    if with == without {
        return false;
    }
    match &witness.finding.shown {
        Shown::Picture {
            frame: Some(shown), ..
        } => {
            let lossy = matches!(witness.case.format(), Format::JpegRgb | Format::JpegLrgb);
            let slack = if lossy { TRANSFORM } else { 0.0 };
            let wrong = |made: &Frame| Some(Pair::of(made, shown)?.wrong_by_more_than(slack));
            matches!((wrong(with), wrong(without)), (Some(with), Some(without)) if with * 2 < without)
        }
        // One decoder shows nonsense where another gives up; but only a mistake about few files says so much.
        Shown::Rejected | Shown::Misconduct(Answer::Crashed(_)) => ["2.5", "2.6", "2.8", "2.9"]
            .iter()
            .any(|section| misreading.clause.starts_with(section)),
        _ => false,
    }
}

/// All that is true of how one picture differs, and of where; the most telling first.
#[derive(Default)]
struct Said {
    what: Vec<Claim>,
    channels: Vec<String>,
    texels: Vec<String>,
}

/// How a picture differs.
#[derive(Clone, PartialEq)]
struct Claim {
    says: String,
    /// The formula that is computed with a wrong number.
    formula: Option<Formula>,
}

impl From<String> for Claim {
    fn from(says: String) -> Claim {
        Claim {
            says,
            formula: None,
        }
    }
}

fn say(search: &Search, set: &[&'static Misreading], w: usize) -> Said {
    let plain = |what: &str| Said {
        what: vec![Claim::from(what.to_owned())],
        ..Said::default()
    };
    let witness = &search.witnesses[w];
    let Shown::Picture {
        frame: Some(shown), ..
    } = &witness.finding.shown
    else {
        return plain("no picture");
    };
    let made = search.made(w, set);
    // The mistakes that were found may refuse what the reference reads.
    let ((Answer::Decoded(wanted), _) | (_, Answer::Decoded(wanted))) = (&*made, &witness.right)
    else {
        return plain("a picture of a file that should be refused");
    };
    let Some(mut pair) = Pair::of(wanted, shown) else {
        return plain(&of_shape(wanted, shown));
    };
    if pair.wrong().is_empty() {
        // Wrong by less than a color and its neighbour differ: what is exact tells.
        match witness.exact(wanted) {
            Some(exact) => pair.want = exact,
            None => return plain("values that differ by less than they are rounded"),
        }
    }
    if pair.wrong().is_empty() {
        return plain("values that differ by less than they are rounded");
    }
    let mut what = claims_of_slips(search, w, shown);
    what.extend(pair.relations().into_iter().map(Claim::from));
    what.extend(pair.whole().map(Claim::from));
    if let Some(shift) = provenance::shift(witness, &pair) {
        let (count, way) = (
            shift.unsigned_abs(),
            if shift > 0 { "later" } else { "earlier" },
        );
        let bytes = if count == 1 { "byte" } else { "bytes" };
        what.push(Claim::from(format!(
            "the values that stand {count} {bytes} {way} in the file: the binary data is read from a wrong place"
        )));
    }
    Said {
        what,
        channels: pair.channels_concerned(witness),
        texels: pair.texels_concerned(witness),
    }
}

/// What occurs most often; among equals what comes first.
fn commonest<'a>(claims: impl Iterator<Item = &'a Claim>) -> Option<Claim> {
    let mut counts: Vec<(&Claim, usize)> = Vec::new();
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
    } else if wanted.width != shown.width && wanted.height == shown.height {
        "a picture of another width".to_owned()
    } else if wanted.width == shown.width {
        "a picture of another height".to_owned()
    } else {
        "a picture of another width and height".to_owned()
    }
}

/// A picture and what it should be, of the same shape.
pub(super) struct Pair {
    pub width: usize,
    pub height: usize,
    pub channels: usize,
    pub want: Vec<f64>,
    pub got: Vec<f64>,
    view: &'static str,
}

impl Pair {
    fn of(wanted: &Frame, shown: &Frame) -> Option<Pair> {
        let numbers = |samples: &Samples| -> Vec<f64> {
            match samples {
                Samples::U8(bytes) => bytes.iter().map(|&byte| f64::from(byte)).collect(),
                Samples::F32(values) => values.iter().map(|&value| f64::from(value)).collect(),
            }
        };
        let shape = |frame: &Frame| {
            (
                frame.view,
                frame.width,
                frame.height,
                frame.channels,
                matches!(frame.samples, Samples::U8(_)),
            )
        };
        (shape(wanted) == shape(shown) && wanted.channels > 0).then(|| Pair {
            width: wanted.width as usize,
            height: wanted.height as usize,
            channels: wanted.channels as usize,
            want: numbers(&wanted.samples),
            got: numbers(&shown.samples),
            view: wanted.view,
        })
    }

    fn near(&self, a: f64, b: f64) -> bool {
        match self.view {
            "raw" => a == b,
            "rgb" => (a - b).abs() <= COLOR,
            _ => is_close(a, b, 0.0),
        }
    }

    /// Samples that are not as they should be.
    pub fn wrong(&self) -> Vec<usize> {
        (0..self.want.len())
            .filter(|&i| !self.near(self.want[i], self.got[i]))
            .collect()
    }

    /// How many samples are farther off.
    fn wrong_by_more_than(&self, slack: f64) -> usize {
        let wrong = self.wrong();
        let is_off = |&&i: &&usize| (self.want[i] - self.got[i]).abs() > slack;
        wrong.iter().filter(is_off).count()
    }

    fn at(&self, x: usize, y: usize, channel: usize) -> usize {
        (y * self.width + x) * self.channels + channel
    }

    fn name(&self, channel: usize) -> String {
        channel_name(self.channels, channel)
    }

    /// Whether every sample is the one that should be at another place.
    fn is_moved(&self, from: impl Fn(usize, usize, usize) -> Option<usize>) -> bool {
        let mut compared = 0;
        for y in 0..self.height {
            for x in 0..self.width {
                for channel in 0..self.channels {
                    if let Some(i) = from(x, y, channel) {
                        compared += 1;
                        if !self.near(self.want[i], self.got[self.at(x, y, channel)]) {
                            return false;
                        }
                    }
                }
            }
        }
        compared * 2 >= self.want.len()
    }

    /// One transform of the whole picture.
    fn whole(&self) -> Option<String> {
        // A few wrong samples are no transform of the whole.
        if self.wrong().len() * 4 < self.want.len() {
            return None;
        }
        let (w, h, c) = (self.width, self.height, self.channels);
        if self.is_moved(|x, y, k| Some(self.at(x, h - 1 - y, k))) {
            return Some("pictures upside down".to_owned());
        }
        if self.is_moved(|x, y, k| Some(self.at(w - 1 - x, y, k))) {
            return Some("mirrored pictures, left for right".to_owned());
        }
        if self.is_moved(|x, y, k| Some(self.at(w - 1 - x, h - 1 - y, k))) {
            return Some("pictures turned by half a turn".to_owned());
        }
        if w == h && self.is_moved(|x, y, k| Some(self.at(y, x, k))) {
            return Some("rows for columns".to_owned());
        }
        if self.is_moved(|x, y, k| {
            let i = self.at(x, y, k);
            Some(i % (w * h) * c + i / (w * h))
        }) || self.is_moved(|x, y, k| {
            let plane = (y * w + x) + k * w * h;
            Some(plane)
        }) {
            return Some(
                "one channel after the other, where the channels of a texel stand together"
                    .to_owned(),
            );
        }
        if w * h >= 3 {
            for dy in -2_isize..=2 {
                for dx in -2_isize..=2 {
                    let from = |x: usize, y: usize, k: usize| {
                        let (x, y) = (x.checked_add_signed(dx)?, y.checked_add_signed(dy)?);
                        (x < w && y < h).then(|| self.at(x, y, k))
                    };
                    if (dx, dy) != (0, 0) && self.is_moved(from) {
                        return Some(format!(
                            "pictures displaced by {} columns and {} rows",
                            -dx, -dy
                        ));
                    }
                }
            }
        }
        self.permutation()
    }

    /// Channels in another order.
    fn permutation(&self) -> Option<String> {
        let same = |channel: usize, from: usize| {
            (0..self.width * self.height).all(|texel| {
                let i = texel * self.channels;
                self.near(self.want[i + from], self.got[i + channel])
            })
        };
        let from: Vec<usize> = (0..self.channels)
            .map(|channel| {
                if same(channel, channel) {
                    Some(channel)
                } else {
                    (0..self.channels).find(|&from| same(channel, from))
                }
            })
            .collect::<Option<_>>()?;
        let changed: Vec<String> = (0..self.channels)
            .filter(|&channel| from[channel] != channel)
            .map(|channel| format!("{} in {}", self.name(from[channel]), self.name(channel)))
            .collect();
        (!changed.is_empty()).then(|| {
            if changed.len() > 6 {
                format!(
                    "the channels in another order ({}, …)",
                    changed[..6].join(", ")
                )
            } else {
                format!("channels exchanged ({})", changed.join(", "))
            }
        })
    }

    /// How wrong samples stand to what they should be: all that is true of them.
    fn relations(&self) -> Vec<String> {
        let wrong = self.wrong();
        let pairs: Vec<(f64, f64)> = wrong.iter().map(|&i| (self.want[i], self.got[i])).collect();
        let all =
            |holds: &dyn Fn(f64, f64) -> bool| pairs.iter().all(|&(want, got)| holds(want, got));
        let byte = self.view != "coef";
        let raw = self.view == "raw";
        let first = pairs[0];
        // One or two wrong samples, or those of one right value, are off by the same whatever the reason.
        let telling = pairs.len() > 2 && pairs.iter().any(|pair| !self.near(pair.0, first.0));
        let mut says: Vec<String> = Vec::new();
        let mut offer = |holds: bool, claim: &dyn Fn() -> String| {
            if holds {
                says.push(claim());
            }
        };
        offer(all(&|_, got| !got.is_finite()), &|| {
            "values that are no numbers (NaN or infinite)".to_owned()
        });
        offer(telling && all(&|_, got| self.near(got, first.1)), &|| {
            format!("{} instead of the right value", short(first.1))
        });
        let around = |apart: f64| match raw {
            true => apart.rem_euclid(256.0),
            false => apart,
        };
        let apart = around(first.1 - first.0);
        let constant = telling && all(&|want, got| self.near(around(got - want), apart));
        if raw && apart == 128.0 {
            offer(constant, &|| {
                "values with their highest bit changed, 128 more or less than they should be"
                    .to_owned()
            });
        } else {
            let less = apart < 0.0 || raw && apart > 128.0;
            let by = if raw && less {
                256.0 - apart
            } else {
                apart.abs()
            };
            offer(constant, &|| {
                format!(
                    "values that are {} {} than they should be{}",
                    short(by),
                    if less { "less" } else { "more" },
                    if raw { " (modulo 256)" } else { "" }
                )
            });
        }
        let times = first.1 / first.0;
        offer(
            telling
                && first.0 != 0.0
                && times.is_finite()
                && times != 0.0
                && all(&|want, got| self.near(want * times, got)),
            &|| format!("values that are {} times what they should be", short(times)),
        );
        offer(byte && all(&|want, got| got == 255.0 - want), &|| {
            "values inverted (255 less the right ones)".to_owned()
        });
        let bits =
            |change: fn(u8) -> u8| byte && all(&|want, got| f64::from(change(want as u8)) == got);
        offer(bits(u8::reverse_bits), &|| {
            "values with their bits in reverse order".to_owned()
        });
        offer(bits(|value| value >> 1), &|| {
            "half the right values".to_owned()
        });
        offer(bits(|value| value & 0xfe), &|| {
            "values without their lowest bit".to_owned()
        });
        offer(bits(|value| value & 0x7f), &|| {
            "values without their highest bit".to_owned()
        });
        offer(bits(|value| value & 0xf0), &|| {
            "values without their lower four bits".to_owned()
        });
        if let Some((factor, offset)) = self.line(&pairs) {
            offer(true, &|| {
                format!(
                    "values that are {} times the right ones and {} {}",
                    short(factor),
                    short(offset.abs()),
                    if offset < 0.0 { "less" } else { "more" }
                )
            });
        }
        offer(
            !byte && all(&|want, got| (got - want).abs() < 1.0 && got.fract() == 0.0),
            &|| "final values rounded to whole numbers".to_owned(),
        );
        let color = self.view == "rgb";
        let by_two = all(&|want, got| (got - want).abs() <= 2.0);
        offer(color && by_two && all(&|want, got| got > want), &|| {
            "colors that are a unit or two too large, as of another divisor or of rounding twice"
                .to_owned()
        });
        offer(color && by_two && all(&|want, got| got < want), &|| {
            "colors that are a unit or two too small, as of another divisor or of fractions cut off"
                .to_owned()
        });
        offer(by_two, &|| {
            "values that are off by two at most, as of another rounding".to_owned()
        });
        let is_grey = color
            && self
                .got
                .chunks_exact(3)
                .all(|rgb| rgb.windows(2).all(|two| two[0] == two[1]));
        offer(is_grey && pairs.len() > 2, &|| {
            "grey: one value for red, green and blue".to_owned()
        });
        let neighbour = self.of_neighbour(&wrong);
        offer(neighbour.is_some(), &|| {
            neighbour.clone().unwrap_or_default()
        });
        let sorted = |values: &[f64]| {
            let mut values: Vec<u64> = values.iter().map(|value| value.to_bits()).collect();
            values.sort_unstable();
            values
        };
        offer(
            pairs.len() > 2 && sorted(&self.want) == sorted(&self.got),
            &|| "the right values in wrong places".to_owned(),
        );
        says
    }

    /// got = factor · want + offset, for three different values or more.
    fn line(&self, pairs: &[(f64, f64)]) -> Option<(f64, f64)> {
        let &(a, x) = pairs.first()?;
        let &(b, y) = pairs.iter().find(|pair| (pair.0 - a).abs() > 1e-9)?;
        pairs
            .iter()
            .find(|pair| (pair.0 - a).abs() > 1e-9 && (pair.0 - b).abs() > 1e-9)?;
        let factor = (y - x) / (b - a);
        let offset = x - factor * a;
        let fits = pairs
            .iter()
            .all(|&(want, got)| self.near(factor * want + offset, got));
        (fits && factor != 0.0).then_some((factor, offset))
    }

    /// Wrong samples that are those of another channel or texel.
    fn of_neighbour(&self, wrong: &[usize]) -> Option<String> {
        let c = self.channels;
        for other in 0..c {
            let fits = |&i: &usize| self.near(self.want[i - i % c + other], self.got[i]);
            if wrong.len() > 1 && wrong.iter().all(fits) {
                return Some(format!(
                    "the value of {} in place of their own",
                    self.name(other)
                ));
            }
        }
        let steps: [(isize, isize, &str); 8] = [
            (-1, 0, "left"),
            (1, 0, "right"),
            (0, -1, "above"),
            (0, 1, "below"),
            (-1, -1, "above left"),
            (1, -1, "above right"),
            (-1, 1, "below left"),
            (1, 1, "below right"),
        ];
        for (dx, dy, name) in steps {
            let fits = |&i: &usize| {
                let (texel, k) = (i / c, i % c);
                let (x, y) = (texel % self.width, texel / self.width);
                let (Some(x), Some(y)) = (x.checked_add_signed(dx), y.checked_add_signed(dy))
                else {
                    return false;
                };
                x < self.width
                    && y < self.height
                    && self.near(self.want[self.at(x, y, k)], self.got[i])
            };
            if wrong.len() > 1 && wrong.iter().all(fits) {
                return Some(format!(
                    "the value of the texel {name} in place of their own"
                ));
            }
        }
        None
    }

    /// How the planes of a compressed file are coded, where they are the channels of this picture.
    fn coded<'w>(&self, witness: &'w Witness) -> Option<&'w Compressed> {
        let compressed = witness.model()?.compressed.as_ref()?;
        (self.view != "rgb" && compressed.planes.len() == self.channels).then_some(compressed)
    }

    /// What is true of the wrong channels; the most telling first.
    fn channels_concerned(&self, witness: &Witness) -> Vec<String> {
        let mut wrong = vec![false; self.channels];
        for i in self.wrong() {
            wrong[i % self.channels] = true;
        }
        let planes: Vec<usize> = (0..self.channels).filter(|&k| wrong[k]).collect();
        let mut says: Vec<String> = Vec::new();
        let mut offer = |holds: bool, claim: String| {
            if holds {
                says.push(claim);
            }
        };
        if let Some(coded) = self.coded(witness) {
            let plan = &coded.plan;
            let transform = |plane: usize| match plan.reference(plane) {
                Some(_) => plan.transforms.get(plane).copied().unwrap_or_default(),
                None => 0,
            };
            let all = |holds: &dyn Fn(usize) -> bool| planes.iter().all(|&plane| holds(plane));
            let some_intra = plan.predicts();
            offer(
                all(&|plane| transform(plane) & 3 == 3),
                ", only in planes predicted with inversion and motion".to_owned(),
            );
            offer(
                all(&|plane| transform(plane) & 2 != 0),
                ", only in planes predicted with motion".to_owned(),
            );
            offer(
                all(&|plane| transform(plane) & 1 != 0),
                ", only in planes predicted from an inverted reference".to_owned(),
            );
            offer(
                all(&|plane| plan.reference(plane).is_some()),
                ", only in predicted planes".to_owned(),
            );
            offer(
                some_intra && all(&|plane| plan.reference(plane).is_none()),
                ", only in planes that are not predicted".to_owned(),
            );
        }
        if self.channels > 3 {
            let coefficients = if self.channels == 18 { 18 } else { 6 };
            let inside = planes.iter().all(|&k| k < coefficients);
            for a in 0..6 {
                offer(
                    inside && planes.iter().all(|k| k % 6 == a),
                    format!(", only in a{a}"),
                );
            }
            for (color, name) in ["red", "green", "blue"].iter().enumerate() {
                offer(
                    self.channels == 18 && planes.iter().all(|k| k / 6 == color),
                    format!(", only in the coefficients of {name}"),
                );
            }
            offer(inside, ", only in coefficients".to_owned());
            offer(
                coefficients == 6 && planes.iter().all(|&k| k >= 6),
                ", only in colors".to_owned(),
            );
        }
        for k in 0..self.channels {
            offer(planes == [k], format!(", only in {}", self.name(k)));
        }
        says
    }

    /// What is true of the wrong texels; the most telling first.
    fn texels_concerned(&self, witness: &Witness) -> Vec<String> {
        let (w, h) = (self.width, self.height);
        let wrong = self.wrong();
        let mut says: Vec<String> = Vec::new();
        if let Some(coded) = self.coded(witness) {
            // Positions count in the stored raster, from the bottom row.
            let corrected = |&i: &usize| {
                let (texel, k) = (i / self.channels, i % self.channels);
                let stored = (h - 1 - texel / w) * w + texel % w;
                let records = &coded.planes[k].records;
                records
                    .iter()
                    .any(|&(position, _)| position as usize == stored)
            };
            if wrong.iter().all(corrected) {
                says.push(", only at texels that side information corrects".to_owned());
            }
        }
        let texels: Vec<(usize, usize)> = wrong
            .iter()
            .map(|i| (i / self.channels % w, i / self.channels / w))
            .collect();
        let all = |holds: &dyn Fn(usize, usize) -> bool| texels.iter().all(|&(x, y)| holds(x, y));
        let claims = [
            (
                all(&|x, y| (x, y) == (w - 1, h - 1)),
                ", only at the last texel (bottom right)",
            ),
            (
                all(&|x, y| (x, y) == (w - 1, 0)),
                ", only at the texel that is stored last (top right)",
            ),
            (
                all(&|x, y| (x, y) == (0, 0)),
                ", only at the first texel (top left)",
            ),
            (
                all(&|x, y| (x, y) == (0, h - 1)),
                ", only at the texel that is stored first (bottom left)",
            ),
            (
                all(&|_, y| y == 0),
                ", only in the top row, which is stored last",
            ),
            (
                all(&|_, y| y == h - 1),
                ", only in the bottom row, which is stored first",
            ),
            (all(&|x, _| x == 0), ", only in the left column"),
            (all(&|x, _| x == w - 1), ", only in the right column"),
            (
                all(&|x, y| x == 0 || y == 0 || x == w - 1 || y == h - 1),
                ", only at the border",
            ),
            (all(&|x, _| x % 2 == 1), ", only in every second column"),
            (all(&|_, y| y % 2 == 1), ", only in every second row"),
            (
                all(&|x, y| x > 0 && y > 0 && x < w - 1 && y < h - 1),
                ", everywhere but at the border",
            ),
            (
                all(&|x, y| x >= 8 || y >= 8),
                ", only beyond the first 8x8 block",
            ),
            (
                all(&|x, y| (h - 1 - y) * w + x >= 256),
                ", only from the 257th stored texel on",
            ),
        ];
        let true_ones = claims.into_iter().filter(|&(holds, _)| holds);
        says.extend(true_ones.map(|(_, claim)| claim.to_owned()));
        says
    }
}

/// What was shown, and what a decoder with these mistakes shows, where both are pictures of one shape.
pub(super) fn pair_of(search: &Search, set: &[&'static Misreading], w: usize) -> Option<Pair> {
    match (&search.witnesses[w].finding.shown, &*search.made(w, set)) {
        (
            Shown::Picture {
                frame: Some(shown), ..
            },
            Answer::Decoded(wanted),
        ) => Pair::of(wanted, shown),
        _ => None,
    }
}

/// The first wrong value of the smallest file, down to the bytes it comes from.
fn example(search: &Search, set: &[&'static Misreading], w: usize) -> String {
    let witness = &search.witnesses[w];
    let id = &witness.case.id;
    let Some((pair, i)) = pair_of(search, set, w).and_then(|pair| {
        let first = *pair.wrong().first()?;
        Some((pair, first))
    }) else {
        return format!("for example {id}: {}", witness.case.because);
    };
    let (texel, channel) = (i / pair.channels, i % pair.channels);
    let (x, y) = (texel % pair.width, texel / pair.width);
    let origin = if pair.view == "rgb" {
        provenance::texel(witness, x, y)
    } else {
        provenance::sample(witness, x, y, channel)
    };
    format!(
        "for example {id}, texel ({x}, {y}), {}: {} instead of {}{}",
        pair.name(channel),
        short(pair.got[i]),
        short(pair.want[i]),
        origin.map_or(String::new(), |origin| format!("; it comes from {origin}"))
    )
}

fn short(value: f64) -> String {
    let text = format!("{value:.4}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}
