//! Solves, from planes as they were shown, which decision of rebuilding them is taken otherwise, and where.
//!
//! Every plane is made again from the reference that was shown. A slip explains a plane if each of its samples is as it
//! should be or as the slip makes it. Where it is made is what tells the samples that show it from those that deny it, in
//! the files that fail and in those that pass.

use std::collections::BTreeSet;

use super::places::{PLANES, Place, PlaneIs, SAMPLES, Sample};
use super::rules::{Coding, Slip, Sum};
use super::slips::PlaneSlip;
use crate::diagnose::mistake::Mistake;
use crate::diagnose::pair::distance;
use crate::diagnose::search::{Search, Set, spread};
use crate::diagnose::solved::Act;
use crate::diagnose::witness::Witness;
use crate::misreadings::{At, Misreading, misread};
use crate::protocol::frame::{Answer, Frame, Samples, View};
use crate::reading::Reading;
use crate::session::observation::Response;

/// Samples of all failing files that are looked at, and of a passing one; and how many files.
const SAMPLES_OF_ALL: usize = 1 << 17;
const SAMPLES_OF_PASSING: usize = 1 << 12;
const FAILING: usize = 120;
const PASSING: usize = 240;
/// Slips that are found one after another.
const ROUNDS: usize = 4;
/// Slips that are held against passing files too.
const FINALISTS: usize = 24;
/// Fewer planes tell of no slip, and fewer files of no place.
const FEWEST: usize = 2;
const FEWEST_FILES: usize = 4;
/// So many ways to divide planes must there be, for a place that divides them so to be no coincidence; and for two places.
const DIVISIONS: f64 = 100.0;
const DIVISIONS_OF_BOTH: f64 = 10_000.0;

/// The planes of a file as they were shown, bottom row first.
pub(in crate::diagnose) struct Shown {
    pub coding: Coding,
    pub planes: Vec<Vec<u8>>,
    pub reading: Reading,
}

/// A plane in which a slip would show: samples that are as it makes them, and samples that are not.
pub(in crate::diagnose) struct Trace {
    pub file: usize,
    pub plane: usize,
    pub hits: Vec<usize>,
    pub misses: Vec<usize>,
}

/// The slips beside `set` that planes of these files show, made together.
pub(in crate::diagnose) fn candidates(
    search: &Search,
    set: &Set,
    pictures: &[usize],
) -> Vec<PlaneSlip> {
    let mut slips = slips_of(search, set);
    let known = slips.len();
    let (_, failing) = of_files(search, set, &unlike(search, pictures, FAILING));
    if failing.is_empty() {
        return Vec::new();
    }
    let (_, passing) = of_files(search, set, &passing_files(search, pictures));
    for _ in 0..ROUNDS {
        match next(search, &failing, &passing, &slips) {
            Some(slip) => slips.push(slip),
            None => break,
        }
    }
    slips.split_off(known)
}

/// The slips in rebuilding planes among the mistakes of a set.
pub(in crate::diagnose) fn slips_of(search: &Search, set: &Set) -> Vec<PlaneSlip> {
    let mistakes = search.mistakes_of(set);
    mistakes.into_iter().filter_map(slip_of).cloned().collect()
}

fn slip_of(mistake: &Mistake) -> Option<&PlaneSlip> {
    match &mistake.solved()?.act {
        Act::Planes(slip) => Some(slip),
        _ => None,
    }
}

/// Compressed files of which stored values were asked, of every format and about every clause; the smallest of them.
fn unlike(search: &Search, of: &[usize], most: usize) -> Vec<usize> {
    let is_of = |w: &usize| {
        let witness = &search.witnesses[*w];
        witness.case.format().is_compressed() && witness.observation.view == View::Raw
    };
    let of: Vec<usize> = of.iter().copied().filter(is_of).collect();
    let kind = |w: usize| {
        let case = search.witnesses[w].case;
        (case.clauses.first().cloned(), case.format())
    };
    let mut of = spread(&search.smallest(&of, SAMPLES_OF_ALL), kind);
    of.truncate(most);
    of
}

/// Such files that the decoder passes; half of them about what the failing ones are about.
pub(in crate::diagnose) fn passing_files(search: &Search, failing: &[usize]) -> Vec<usize> {
    let clause = |w: usize| search.witnesses[w].case.clauses.first();
    let clauses: BTreeSet<&String> = failing.iter().filter_map(|&w| clause(w)).collect();
    let passing = search.passing.iter().copied();
    // Of files that are refused nothing is shown.
    let small: Vec<usize> = passing
        .filter(|&w| (1..=SAMPLES_OF_PASSING).contains(&search.samples(w)))
        .collect();
    let is_akin = |&w: &usize| clause(w).is_some_and(|clause| clauses.contains(clause));
    let akin: Vec<usize> = small.iter().copied().filter(is_akin).collect();
    let mut files = unlike(search, &akin, PASSING / 2);
    let others = unlike(search, &small, PASSING);
    files.extend(others.into_iter().filter(|w| !akin.contains(w)));
    files.truncate(PASSING);
    files
}

/// The planes of those of these files of which stored values were shown, and which files these are.
pub(in crate::diagnose) fn of_files(
    search: &Search,
    set: &Set,
    of: &[usize],
) -> (Vec<usize>, Vec<Shown>) {
    let mistakes = search.mistakes_of(set);
    let listed: Vec<&Misreading> = mistakes.iter().filter_map(|one| one.listed()).collect();
    let all = search.each(of, |&w| shown(&search.witnesses[w], &listed));
    let pairs = of.iter().copied().zip(all);
    pairs.filter_map(|(w, shown)| Some((w, shown?))).unzip()
}

/// The planes that were shown of a file.
fn shown(witness: &Witness, listed: &[&Misreading]) -> Option<Shown> {
    if !witness.case.format().is_compressed() || witness.observation.view != View::Raw {
        return None;
    }
    let frame = match (&witness.observation.response, &witness.right) {
        (
            Response::Picture {
                frame: Some(frame), ..
            },
            Answer::Decoded(_),
        ) => frame,
        (Response::Picture { frame: None, .. }, Answer::Decoded(right)) => right,
        _ => return None,
    };
    // What acts on bytes or on planes is not made again here.
    let decisions = listed
        .iter()
        .filter(|one| !matches!(one.at, At::Bytes(_) | At::Planes(_)));
    let reading = misread(&decisions.copied().collect::<Vec<_>>(), witness.reading);
    let coding = Coding::of(&witness.built.file, witness.ranks(), &reading)?;
    let planes = stored_planes(frame, &coding, witness, &reading)?;
    Some(Shown {
        coding,
        planes,
        reading,
    })
}

fn stored_planes(
    frame: &Frame,
    coding: &Coding,
    witness: &Witness,
    reading: &Reading,
) -> Option<Vec<Vec<u8>>> {
    let Samples::U8(samples) = &frame.samples else {
        return None;
    };
    let (width, height) = (coding.size.width as usize, coding.size.height as usize);
    let channels = coding.planes.len();
    let header = &witness.decoded().as_ref().ok()?.header;
    if samples.len() != width * height * channels {
        return None;
    }
    let mut planes = vec![vec![0; width * height]; channels];
    for (i, &sample) in samples.iter().enumerate() {
        let (texel, plane) = (i / channels, i % channels);
        let row = (reading.stored_row)(header, texel / width);
        planes[plane][row * width + texel % width] = sample;
    }
    Some(planes)
}

/// The slip that explains most planes beside `slips`.
fn next(
    search: &Search,
    failing: &[Shown],
    passing: &[Shown],
    slips: &[PlaneSlip],
) -> Option<PlaneSlip> {
    let made: Vec<&PlaneSlip> = slips.iter().collect();
    let now = |files: &[Shown]| search.each(files, |file| file.all(&made));
    let now_failing = now(failing);
    let mut all = Slip::all();
    all.extend(sums(failing, &now_failing));
    let explained = search.each(&all, |&slip| {
        let traces = traces(failing, &now_failing, &made, slip);
        traces.iter().filter(|trace| !trace.hits.is_empty()).count()
    });
    let mut ranked: Vec<(usize, Slip)> = explained.into_iter().zip(all).collect();
    ranked.retain(|&(count, _)| count > 0);
    ranked.sort_by_key(|&(count, _)| std::cmp::Reverse(count));
    ranked.truncate(FINALISTS);
    if ranked.is_empty() {
        return None;
    }
    let now_passing = now(passing);
    let placed = search.each(&ranked, |&(count, slip)| {
        let mut all = traces(failing, &now_failing, &made, slip);
        let own = all.len();
        // What inverse transforms may differ in a picture that is right denies no shift.
        let may_differ = |trace: &Trace| {
            matches!(slip, Slip::Shifted(_)) && !passing[trace.file].coding.is_jpeg_ls
        };
        let of_passing = traces(passing, &now_passing, &made, slip).into_iter();
        all.extend(of_passing.filter(|trace| !may_differ(trace)));
        let file = |place: usize, trace: &Trace| match place < own {
            true => &failing[trace.file],
            false => &passing[trace.file],
        };
        let of: Vec<(&Shown, &Trace)> = (all.iter().enumerate())
            .map(|(place, trace)| (file(place, trace), trace))
            .collect();
        let samples: usize = all.iter().map(|trace| trace.hits.len()).sum();
        let place = place(&of).filter(|_| count >= FEWEST || samples > FEWEST)?;
        Some((count, PlaneSlip { slip, place }))
    });
    let plain = |place: &Place| place.planes.len() + usize::from(place.sample.is_some());
    let found = placed.into_iter().flatten().enumerate();
    let best = found
        .max_by_key(|(at, (count, one))| (*count, std::cmp::Reverse((plain(&one.place), *at))));
    best.map(|(_, (_, slip))| slip)
}

impl Shown {
    /// Every plane, made again of the references that were shown.
    pub fn all(&self, slips: &[&PlaneSlip]) -> Vec<Vec<u8>> {
        let planes = 0..self.planes.len();
        let one = |i| {
            self.coding
                .plane_with(i, &self.planes, slips, &self.reading)
        };
        planes.map(one).collect()
    }
}

/// What a slip does to each plane of these files in which it shows; planes that it explains no better are left out.
fn traces(files: &[Shown], now: &[Vec<Vec<u8>>], slips: &[&PlaneSlip], slip: Slip) -> Vec<Trace> {
    let one = PlaneSlip {
        slip,
        place: Place::default(),
    };
    let with: Vec<&PlaneSlip> = slips.iter().copied().chain([&one]).collect();
    let mut all = Vec::new();
    for (place, (file, now)) in files.iter().zip(now).enumerate() {
        for (plane, now) in now.iter().enumerate() {
            if !slip.concerns(&file.coding, plane) {
                continue;
            }
            let shown = &file.planes[plane];
            let made = file
                .coding
                .plane_with(plane, &file.planes, &with, &file.reading);
            let is_open = |&at: &usize| shown[at] != now[at] && shown[at] != made[at];
            if (0..shown.len()).any(|at| is_open(&at)) {
                continue;
            }
            let differing = (0..shown.len()).filter(|&at| made[at] != now[at]);
            // So far inverse transforms may differ.
            let is_within = |at: usize| distance(made[at], now[at]) <= 1;
            let is_jpeg = !file.coding.is_jpeg_ls && !matches!(slip, Slip::Shifted(_));
            if is_jpeg && differing.clone().all(is_within) {
                continue;
            }
            let (hits, misses) = differing.partition(|&at| shown[at] == made[at]);
            all.push(Trace {
                file: place,
                plane,
                hits,
                misses,
            });
        }
    }
    all
}

/// Sums of residual and predictor that some plane is.
fn sums(files: &[Shown], now: &[Vec<Vec<u8>>]) -> Vec<Slip> {
    let mut found = Vec::new();
    for (file, now) in files.iter().zip(now) {
        for (i, plane) in file.planes.iter().enumerate() {
            if *plane == now[i] || file.coding.planes[i].step.reference.is_none() || plane.len() < 4
            {
                continue;
            }
            let predictor = file.coding.right_predictor(i, &file.planes, &file.reading);
            for (residual, many) in (-1..=1).flat_map(|r| [(r, -1), (r, 0), (r, 1)]) {
                let times = |many: i8, of: u8| (many as u8).wrapping_mul(of);
                let rest: BTreeSet<u8> = (plane.iter().zip(&file.coding.planes[i].residuals))
                    .zip(&predictor)
                    .map(|((&shown, &r), &p)| {
                        let shown = shown.wrapping_sub(times(residual, r));
                        shown.wrapping_sub(times(many, p))
                    })
                    .collect();
                let slip = rest.first().map(|&plus| {
                    Slip::Sum(Sum::Terms {
                        residual,
                        predictor: many,
                        plus,
                    })
                });
                let is_it = rest.len() == 1 && (residual, many) != (0, 0);
                found.extend(slip.filter(|slip| is_it && !found.contains(slip)));
            }
        }
    }
    // Where residuals are all one number, any sum of them fits; and some sums are made in parts of a plane only.
    let likely = [(1, 0, 0), (0, 1, 0), (1, 0, 128)];
    found.extend(likely.map(|(residual, predictor, plus)| {
        Slip::Sum(Sum::Terms {
            residual,
            predictor,
            plus,
        })
    }));
    found
}

/// The smallest place that has all samples that show a slip, and none that denies it.
fn place(of: &[(&Shown, &Trace)]) -> Option<Place> {
    let hits: Vec<_> = of
        .iter()
        .filter(|(_, trace)| !trace.hits.is_empty())
        .collect();
    let misses: Vec<_> = of
        .iter()
        .filter(|(_, trace)| !trace.misses.is_empty())
        .collect();
    if misses.is_empty() {
        return Some(Place::default());
    }
    let divisions = divisions(hits.len(), misses.len());
    let files: BTreeSet<usize> = hits.iter().map(|(_, trace)| trace.file).collect();
    if divisions < DIVISIONS || files.len() < FEWEST_FILES {
        return None;
    }
    let holds =
        |one: PlaneIs, (file, trace): &(&Shown, &Trace)| one.holds(&file.coding, trace.plane);
    let listed: Vec<PlaneIs> = (0..PLANES.len()).map(PlaneIs::Listed).collect();
    // All that is true of every plane that shows the slip.
    let mut shared: Vec<PlaneIs> = listed.into_iter().chain(bounds(&hits, &misses)).collect();
    shared.retain(|&one| hits.iter().all(|item| holds(one, item)));
    let of_planes = |planes: &[PlaneIs]| {
        misses
            .iter()
            .all(|item| planes.iter().any(|&one| !holds(one, item)))
    };
    let place = |planes: &[PlaneIs], sample| Place {
        planes: planes.to_vec(),
        sample,
    };
    if let Some(&one) = shared.iter().find(|&&one| of_planes(&[one])) {
        return Some(place(&[one], None));
    }
    let samples = Samplings::of(&hits, &misses);
    if let Some(sample) = samples
        .shared()
        .find(|&sample| samples.divides(sample, |_| true))
    {
        return Some(place(&[], Some(sample)));
    }
    if divisions < DIVISIONS_OF_BOTH {
        return None;
    }
    let mut pairs = (shared.iter().enumerate())
        .flat_map(|(k, &a)| shared[k + 1..].iter().map(move |&b| [a, b]));
    if let Some(pair) = pairs.find(|pair| of_planes(pair)) {
        return Some(place(&pair, None));
    }
    let mut both = shared
        .iter()
        .flat_map(|&one| samples.shared().map(move |sample| (one, sample)));
    let found =
        both.find(|&(one, sample)| samples.divides(sample, |item| holds(one, misses[item])));
    found.map(|(one, sample)| place(&[one], Some(sample)))
}

/// In how many ways so many planes can be divided.
fn divisions(hits: usize, misses: usize) -> f64 {
    let few = hits.min(misses);
    (0..few)
        .map(|k| (hits + misses - k) as f64 / (k + 1) as f64)
        .product()
}

/// Bounds of numbers of planes and of vectors beyond which the slip is seen.
fn bounds<'a>(
    hits: &[&(&'a Shown, &'a Trace)],
    misses: &[&(&'a Shown, &'a Trace)],
) -> Vec<PlaneIs> {
    let vector = |(file, trace): &(&Shown, &Trace)| {
        let (x, y) = file.coding.planes[trace.plane].step.motion;
        x.saturating_abs().max(y.saturating_abs())
    };
    let first = hits.iter().map(|(_, trace)| trace.plane).min();
    let last = hits.iter().map(|(_, trace)| trace.plane).max();
    let longest = misses.iter().map(|item| vector(item)).max();
    [
        longest.map(PlaneIs::Longer),
        first.map(PlaneIs::From),
        last.map(PlaneIs::UpTo),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// What the samples are that show a slip, and those that deny it.
struct Samplings {
    hits: Vec<Sample>,
    /// Each with the place of its plane.
    misses: Vec<(usize, Sample)>,
}

impl Samplings {
    fn of(hits: &[&(&Shown, &Trace)], misses: &[&(&Shown, &Trace)]) -> Samplings {
        let samples = |(file, trace): &(&Shown, &Trace), of: &[usize]| -> Vec<Sample> {
            let predictor = file
                .coding
                .right_predictor(trace.plane, &file.planes, &file.reading);
            let one = |&at: &usize| {
                file.coding
                    .sample((trace.plane, at), &file.planes, &predictor, &file.reading)
            };
            of.iter().map(one).collect()
        };
        let of_misses = misses.iter().enumerate().flat_map(|(item, of)| {
            let all = samples(of, &of.1.misses);
            all.into_iter().map(move |sample| (item, sample))
        });
        Samplings {
            hits: hits.iter().flat_map(|of| samples(of, &of.1.hits)).collect(),
            misses: of_misses.collect(),
        }
    }

    /// What is true of every sample that shows it.
    fn shared(&self) -> impl Iterator<Item = usize> + '_ {
        (0..SAMPLES.len()).filter(|&one| self.hits.iter().all(SAMPLES[one].holds))
    }

    /// Whether it is true of no sample that denies the slip, of the planes that count.
    fn divides(&self, one: usize, counts: impl Fn(usize) -> bool) -> bool {
        let mut misses = self.misses.iter();
        !misses.any(|(item, sample)| counts(*item) && (SAMPLES[one].holds)(sample))
    }
}

#[cfg(test)]
mod tests {
    use crate::Reading;
    use crate::decode::{compressed, planes, predict};
    use crate::diagnose::tests::first_cause;
    use crate::error::Result;
    use crate::parts::{Plan, RawLists, Step};
    use crate::ptm::Size;
    use crate::suite::cases::{Case, Expect, TableSpelling};

    const SPEC: Reading = Reading::SPEC;

    /// The lists as they are, but for what is changed of each step.
    fn stepping(lists: &RawLists, change: fn(usize, &mut Step)) -> Result<Plan> {
        let mut plan = compressed::plan(lists)?;
        for (i, step) in plan.steps.iter_mut().enumerate() {
            change(i, step);
        }
        Ok(plan)
    }

    fn by_steps(plan: fn(&RawLists) -> Result<Plan>) -> Reading {
        Reading { plan, ..SPEC }
    }

    fn minus(residuals: &mut [u8], predictor: &[u8]) {
        for (value, predicted) in residuals.iter_mut().zip(predictor) {
            *value = value.wrapping_sub(*predicted).wrapping_sub(127);
        }
    }

    /// Beyond the last stored row stands the row before the last.
    fn row_before_the_last(plane: &[u8], size: Size, x: i64, y: i64) -> u8 {
        let height = i64::from(size.height);
        let y = if y >= height { (height - 2).max(0) } else { y };
        predict::border_edge(plane, size, x, y)
    }

    /// Small files with planes that a decoder must read.
    fn keep(case: &Case) -> bool {
        let is_legal = case.format().is_compressed() && case.expect == Expect::Decode;
        is_legal && case.build(TableSpelling::default()).file.len() < 20_000
    }

    /// Whether that is said first of such decoders.
    #[track_caller]
    fn tells(decoders: &[(Reading, &str)]) {
        for (reading, says) in decoders {
            let told = first_cause(*reading, keep);
            assert!(told.contains(says), "{says}: {told}");
        }
    }

    /// The lists with what `change` makes of the steps as they are listed, in the order of decoding.
    fn by_order(lists: &RawLists, change: fn(&mut Plan, &[Step])) -> Result<Plan> {
        let mut plan = compressed::plan(lists)?;
        let listed = plan.steps.clone();
        change(&mut plan, &listed);
        Ok(plan)
    }

    #[test]
    fn what_stands_in_a_list_for_another_plane_is_told() {
        tells(&[
            (
                by_steps(|lists| {
                    by_order(lists, |plan, listed| {
                        for (place, &i) in plan.sequence.iter().enumerate() {
                            let Step {
                                inverted, moved, ..
                            } = listed[place];
                            (plan.steps[i].inverted, plan.steps[i].moved) = (inverted, moved);
                        }
                    })
                }),
                "takes the transform of a plane by its place in the order of decoding",
            ),
            (
                by_steps(|lists| {
                    by_order(lists, |plan, _| {
                        let mut is_inverted = false;
                        for &i in &plan.sequence {
                            let step = &mut plan.steps[i];
                            is_inverted |= step.inverted && step.reference.is_some();
                            step.inverted = is_inverted;
                        }
                    })
                }),
                "inverts the references of all planes after the first that is inverted",
            ),
            (
                by_steps(|lists| {
                    by_order(lists, |plan, listed| {
                        for i in 0..listed.len() / 18 * 18 {
                            plan.steps[i].motion.1 = match i {
                                0..9 => listed[i + 9].motion.0,
                                _ => listed[i - 9].motion.1,
                            };
                        }
                    })
                }),
                "takes y of the vectors from the tenth number of their lists on",
            ),
            (
                by_steps(|lists| stepping(lists, |_, step| step.motion.0 = step.motion.0.min(8))),
                "limits x of a vector to 8 at the most",
            ),
        ]);
    }

    #[test]
    fn a_slip_in_planes_is_told_with_the_planes_in_which_it_is_made() {
        tells(&[
            (
                by_steps(|lists| stepping(lists, |_, step| step.moved &= step.motion.0 != 0)),
                "does not displace references, only in planes with a vector whose x is 0",
            ),
            (
                by_steps(|lists| stepping(lists, |i, step| step.moved &= i < 6)),
                "does not displace references, only in planes with number 6 or a higher one",
            ),
            (
                by_steps(|lists| {
                    stepping(lists, |_, step| {
                        let is_plain = !step.inverted && !step.moved;
                        step.reference = step.reference.filter(|_| !is_plain);
                    })
                }),
                "does not predict: shows what the streams hold, only in planes of transform 0",
            ),
            // The catalog's 16 bits explain a part of what 12 bits do.
            (
                by_steps(|lists| {
                    stepping(lists, |_, step| {
                        let bits_12 = |part: i64| part << 52 >> 52;
                        step.motion = (bits_12(step.motion.0), bits_12(step.motion.1));
                    })
                }),
                "keeps x and y of a vector in 12 bits",
            ),
            (
                by_steps(|lists| {
                    let mut plan = compressed::plan(lists)?;
                    plan.sequence.sort_unstable();
                    plan.sequence
                        .sort_by_key(|&i| lists.order[i].value.to_string());
                    Ok(plan)
                }),
                "sorts ranks as text (10 before 2)",
            ),
        ]);
    }

    #[test]
    fn a_slip_in_sums_and_means_is_told() {
        let half = |samples: [u8; 4]| {
            let sum: u32 = samples.into_iter().map(u32::from).sum();
            (f64::from(sum) / 4.0).round_ties_even() as u8
        };
        let invert = |plane: &mut [u8]| {
            for value in plane.iter_mut().filter(|value| **value > 0) {
                *value = 255 - *value;
            }
        };
        tells(&[
            (
                Reading {
                    predict: minus,
                    predict_jpeg_ls: minus,
                    ..SPEC
                },
                "computes a plane as residual − predictor − 127 modulo 256",
            ),
            (
                Reading {
                    motion_border: row_before_the_last,
                    ..SPEC
                },
                "takes the sample one before the edge beyond the last stored row",
            ),
            (
                Reading {
                    motion_half: half,
                    ..SPEC
                },
                "rounds at a half to the even number in means of two samples and of four",
            ),
            (
                Reading { invert, ..SPEC },
                "inverts 0 to 0, where 255 belongs",
            ),
        ]);
    }

    #[test]
    fn a_slip_in_side_information_is_told() {
        tells(&[
            (
                Reading {
                    records: |block, at, texels| {
                        let mut records = planes::records(block, at, texels)?;
                        if records.len() > 1 {
                            records.pop();
                        }
                        Ok(records)
                    },
                    ..SPEC
                },
                "loses the last record of a plane that has two or more",
            ),
            (
                Reading {
                    correct: |plane, records| {
                        for &(position, value) in records {
                            plane[position as usize] = value.min(254);
                        }
                    },
                    ..SPEC
                },
                "puts V − 1 where a record says V, only where a record has the value 255",
            ),
            (
                Reading {
                    correct: |plane, records| {
                        for &(position, _) in records {
                            plane[position as usize] = records[0].1;
                        }
                    },
                    ..SPEC
                },
                "takes the value of a plane's first record for all of them",
            ),
        ]);
    }
}
