//! What may have been done, read off one wrong picture.

use super::layout::blocks::Block;
use super::layout::indices::{Index, IndexBlock};
use super::layout::strides::{Extent, Strides};
use super::mistake::Mistake;
use super::pair::Pair;
use super::search::{Search, Set};
use super::solved::{Act, Channels, frame, values};
use super::values::changes::{Change, Values};
use super::values::formulas::{Numbers, joint_slips, single_slips};
use super::values::terms::Terms;
use super::witness::{Witness, alike};
use crate::misreadings::{self, Misreading, Stage, misread};
use crate::protocol::frame::{Answer, Frame, View};
use crate::ptm::Ptm;
use crate::reading::Reading;
use crate::session::observation::Response;

/// Samples of a picture of which pictures are made for each candidate.
const SMALL: usize = 4096;
/// Ways to read one block of one picture that are held against others.
const FITTING: usize = 3;
/// How far a stored value that is computed back may be from a whole number.
const WHOLE: f64 = 0.02;

/// A picture, and what it should be with the mistakes known so far.
struct Wrong<'a> {
    witness: &'a Witness<'a>,
    received: &'a Frame,
    pair: Pair,
    ptm: Ptm,
    reading: Reading,
}

/// What may have been done besides `set`. Acts in one group are made together.
pub(super) fn candidates(search: &Search, set: &Set, w: usize) -> Vec<Vec<Act>> {
    let witness = &search.witnesses[w];
    let Response::Picture {
        frame: Some(received),
        ..
    } = &witness.observation.response
    else {
        return Vec::new();
    };
    let mistakes = search.mistakes_of(set);
    let listed: Vec<_> = mistakes.iter().filter_map(|one| one.listed()).collect();
    let made = search.made(w, set);
    let (Answer::Decoded(made), Ok(ptm)) = (&*made, witness.planes(&mistakes)) else {
        return Vec::new();
    };
    let Some(pair) = Pair::of(made, received) else {
        return Vec::new();
    };
    let wrong = Wrong {
        witness,
        received,
        pair,
        ptm,
        reading: misread(&listed, witness.reading),
    };
    match &witness.observation.view {
        View::Raw => {
            let got = wrong
                .pair
                .got
                .iter()
                .map(|&value| Some(value as u8))
                .collect();
            wrong.of_stored(&Stored::of(&wrong, got))
        }
        View::Coef => wrong.of_finals(),
        View::Rgb(_) => wrong.of_colors(),
    }
}

/// Stored values as they were received, where they can be told.
struct Stored {
    got: Vec<Option<u8>>,
    /// For each channel, whether one of its values is wrong.
    wrong: Vec<bool>,
}

impl Stored {
    fn of(wrong: &Wrong, got: Vec<Option<u8>>) -> Stored {
        let want = &wrong.ptm.planes.samples;
        let channels = wrong.pair.channels;
        let is_off = |k: usize| {
            (k..got.len())
                .step_by(channels)
                .any(|i| got[i] != Some(want[i]))
        };
        let wrong = (0..channels).map(is_off).collect();
        Stored { got, wrong }
    }
}

fn alone(act: Act) -> Vec<Act> {
    vec![act]
}

impl Wrong<'_> {
    fn extent(&self, c: usize) -> Extent {
        Extent::of(self.pair.width, self.pair.height, c)
    }

    /// What may have been done to stored values.
    fn of_stored(&self, stored: &Stored) -> Vec<Vec<Act>> {
        let mut acts: Vec<Act> = self.exchanged(stored).into_iter().collect();
        acts.extend(self.blocks(stored));
        acts.extend(self.index_blocks(stored));
        acts.extend(self.moved(stored));
        acts.extend(self.indices(stored));
        acts.extend(self.misread_channels(stored));
        for mask in groups(&stored.wrong) {
            let Some(channels) = Channels::of(&mask) else {
                continue;
            };
            let pairs: Option<Vec<(f64, f64)>> = self
                .of_channels(&mask)
                .map(|i| {
                    Some((
                        f64::from(self.ptm.planes.samples[i]),
                        f64::from(stored.got[i]?),
                    ))
                })
                .collect();
            let changes = pairs.map_or(Vec::new(), |pairs| Change::fitting(&pairs, Values::Bytes));
            acts.extend(
                changes
                    .into_iter()
                    .map(|change| Act::Stored { channels, change }),
            );
        }
        acts.into_iter().map(alone).collect()
    }

    /// The places of the samples of some channels.
    fn of_channels<'s>(&'s self, mask: &'s [bool]) -> impl Iterator<Item = usize> + 's {
        (0..self.pair.want.len()).filter(|i| mask[i % mask.len()])
    }

    /// Channels that are other ones.
    fn exchanged(&self, stored: &Stored) -> Option<Act> {
        let (count, want) = (self.pair.channels, &self.ptm.planes.samples);
        let texels = want.len() / count;
        let is_from = |k: usize, from: usize| {
            (0..texels)
                .all(|texel| stored.got[texel * count + k] == Some(want[texel * count + from]))
        };
        let source = |k: usize| {
            if is_from(k, k) {
                return Some(k);
            }
            let mut sources = (0..count).filter(|&from| is_from(k, from));
            // Where two channels are equal, nobody knows which it is.
            sources.next().filter(|_| sources.next().is_none())
        };
        let from: Vec<usize> = (0..count).map(source).collect::<Option<_>>()?;
        if texels < 2 || from.iter().enumerate().all(|(k, &from)| k == from) {
            return None;
        }
        let coefficients: [usize; 6] = from[..6].try_into().ok()?;
        let everywhere = coefficients.iter().all(|&from| from < 6)
            && (6..count).all(|k| match count {
                18 => from[k] == k / 6 * 6 + coefficients[k % 6],
                _ => from[k] == k,
            });
        Some(match everywhere {
            true => Act::Coefficients(coefficients),
            false => Act::Channels(from),
        })
    }

    /// Blocks of the file that are read with other strides.
    fn blocks(&self, stored: &Stored) -> Vec<Act> {
        let (file, mut found) = (&self.witness.built.file, Vec::new());
        let blocks = Block::of(self.witness.case.format());
        for &(block, first, c) in blocks {
            let Some(start) = block.range(self.witness).map(|range| range.start) else {
                continue;
            };
            if !stored.wrong[first..first + c].contains(&true) {
                found.push(None);
                continue;
            }
            let value = |place: isize| {
                let at = usize::try_from(start as isize + place).ok()?;
                file.get(at).copied()
            };
            let got = |x: usize, y: usize, k: usize| {
                stored.got[((self.pair.height - 1 - y) * self.pair.width + x) * self.pair.channels
                    + first
                    + k]
            };
            let strides = Strides::all(true).into_iter();
            let fitting = strides.filter(|strides| fits(strides, self.extent(c), &got, &value));
            found.push(Some((block, fitting.take(FITTING).collect::<Vec<_>>())));
        }
        let is_everywhere = |strides: &&Strides| {
            let has = |(_, fitting): &(Block, Vec<Strides>)| fitting.contains(strides);
            found.iter().all(|one| one.as_ref().is_some_and(has))
        };
        let first = found.first().and_then(Option::as_ref);
        let everywhere: Vec<Act> = first
            .filter(|_| found.len() > 1)
            .into_iter()
            .flat_map(|(_, fitting)| fitting.iter().filter(is_everywhere))
            .map(|&strides| Act::Block {
                block: Block::All,
                strides,
            })
            .collect();
        if !everywhere.is_empty() {
            return everywhere;
        }
        let alternating = Act::Block {
            block: Block::Alternating,
            strides: Strides::RIGHT,
        };
        if self.is_shown_by(&alternating, stored) {
            return vec![alternating];
        }
        let of_block = |(block, fitting): (Block, Vec<Strides>)| {
            let fitting = fitting.into_iter();
            fitting.map(move |strides| Act::Block { block, strides })
        };
        found.into_iter().flatten().flat_map(of_block).collect()
    }

    /// Whether just these stored values come out.
    fn is_shown_by(&self, act: &Act, stored: &Stored) -> bool {
        let mut ptm = self.ptm.clone();
        let is_done = act.apply(&mut ptm, self.witness).is_ok();
        let made = ptm.planes.samples.into_iter().map(Some);
        is_done && made.eq(stored.got.iter().copied())
    }

    /// Indices that are read with other strides.
    fn index_blocks(&self, stored: &Stored) -> Vec<Act> {
        let (witness, count) = (self.witness, self.pair.channels);
        let Some(indices) = IndexBlock::of(witness) else {
            return Vec::new();
        };
        let texels = || 0..self.pair.width * self.pair.height;
        let is_it = |entry: &[u8], texel: usize| {
            let got = &stored.got[texel * count..];
            entry.iter().zip(got).all(|(a, b)| Some(*a) == *b)
        };
        let fits = |strides: &Strides| {
            let entry = |texel: usize| indices.entry(texel, strides, self.extent(indices.bytes));
            let read = texels().filter_map(|texel| Some((entry(texel)?, texel)));
            let compared = read.clone().count();
            compared >= 4
                && compared * 2 >= self.pair.width * self.pair.height
                && read.into_iter().all(|(entry, texel)| is_it(entry, texel))
        };
        let strides = Strides::all(true).into_iter().filter(fits);
        let act = |strides| Act::Block {
            block: Block::Indices,
            strides,
        };
        strides.take(FITTING).map(act).collect()
    }

    /// Texels from other places of the picture, all wrong channels alike, or those of one kind.
    fn moved(&self, stored: &Stored) -> Vec<Act> {
        let (w, h, count) = (self.pair.width, self.pair.height, self.pair.channels);
        let want = &self.ptm.planes.samples;
        let mut acts = Vec::new();
        for mask in groups(&stored.wrong) {
            let ks: Vec<usize> = (0..count).filter(|&k| mask[k]).collect();
            let Some(channels) = Channels::of(&mask) else {
                continue;
            };
            let value = |place: isize, k: usize| {
                let place = usize::try_from(place).ok().filter(|&place| place < w * h)?;
                Some(want[((h - 1 - place / w) * w + place % w) * count + ks[k]])
            };
            let got =
                |x: usize, y: usize, k: usize| stored.got[((h - 1 - y) * w + x) * count + ks[k]];
            let all_fit = |strides: &Strides| {
                (0..ks.len()).all(|k| {
                    let got = |x: usize, y: usize, _: usize| got(x, y, k);
                    fits(strides, self.extent(1), &got, &|place| value(place, k))
                })
            };
            // Another order and another beginning at once fit small pictures by chance.
            let is_one = |strides: &Strides| {
                strides.shift.0 == 0 || *strides == Strides::RIGHT.moved(strides.shift)
            };
            let strides = Strides::all(true).into_iter().filter(is_one);
            let strides = strides.filter(all_fit).take(FITTING);
            acts.extend(strides.map(|strides| Act::Texels { channels, strides }));
        }
        acts
    }

    /// Other entries of the table.
    fn indices(&self, stored: &Stored) -> Vec<Act> {
        let Some(indices) = IndexBlock::of(self.witness) else {
            return Vec::new();
        };
        let (extent, count) = (self.extent(indices.bytes), self.pair.channels);
        let texels = self.pair.width * self.pair.height;
        let mut pairs = Vec::new();
        for texel in 0..texels {
            let got = &stored.got[texel * count..];
            let is_it = |entry: &[u8]| entry.iter().zip(got).all(|(a, b)| Some(*a) == *b);
            // Entries that are not there were shown as something.
            if let Some(entry) = indices.entries().position(is_it) {
                pairs.push((indices.stored(texel, extent) as f64, entry as f64));
            }
        }
        if pairs.len() * 2 < texels {
            return Vec::new();
        }
        Change::fitting(&pairs, Values::Reals)
            .into_iter()
            .map(|change| Act::Index(Index::Changed(change)))
            .collect()
    }

    /// Mistakes of the catalog that are made in some channels only.
    fn misread_channels(&self, stored: &Stored) -> Vec<Act> {
        let right = &self.ptm.planes.samples;
        let count = self.ptm.planes.shape.channels();
        if right.len() > SMALL || stored.wrong.len() != count {
            return Vec::new();
        }
        let act = |misreading: &'static Misreading| {
            let mistake = Mistake::Listed(misreading);
            let stage = misreading.at.stage();
            if !matches!(stage, Stage::Decoding | Stage::Planes) || !self.witness.concerns(&mistake)
            {
                return None;
            }
            let made = self.witness.planes(&[&mistake]).ok()?.planes.samples;
            if made.len() != right.len() || made == *right {
                return None;
            }
            let agrees = |k: usize, of: &[u8]| {
                let mut places = (k..of.len()).step_by(count);
                places.all(|i| stored.got[i] == Some(of[i]))
            };
            let fits = |mask: &Vec<bool>| {
                (0..count).all(|k| agrees(k, if mask[k] { &made } else { right }))
            };
            let mask = groups(&stored.wrong).into_iter().find(fits)?;
            // What is made in every channel needs no more words.
            let is_all = (0..count).all(|k| mask[k] || agrees(k, &made));
            let channels = Channels::of(&mask).filter(|_| !is_all)?;
            Some(Act::Partly {
                slug: misreading.slug,
                channels,
            })
        };
        misreadings::all().filter_map(act).collect()
    }

    /// Mistakes that are made in some colors only.
    fn misread_colors(&self) -> Vec<Act> {
        let wrong = self.pair.wrong_channels();
        if self.pair.want.len() > SMALL || wrong.iter().all(|is| *is) {
            return Vec::new();
        }
        let colors = [wrong[0], wrong[1], wrong[2]];
        let view = &self.witness.observation.view;
        let of_color = |misreading: &&'static Misreading| {
            let concerned = self.witness.concerns(&Mistake::Listed(misreading));
            misreading.at.stage() == Stage::Color && concerned
        };
        let listed = misreadings::all().filter(of_color);
        let listed = listed.map(|misreading| Act::PartlyShown {
            slug: misreading.slug,
            colors,
        });
        let numbers = Numbers::of(
            &self.ptm.planes,
            &self.ptm.header.scale_bias,
            view,
            &self.reading,
        );
        let slips = numbers.slips(self.ptm.planes.shape).into_iter();
        let slips = slips.map(|(formula, says, _)| Act::PartlySlipped {
            formula,
            says,
            colors,
        });
        let fits = |act: &Act| {
            let made = frame(&[act], &self.ptm, view, &self.reading);
            alike(&made, self.received)
        };
        listed.chain(slips).filter(fits).take(8).collect()
    }

    /// What may have been done to stored or final values.
    fn of_finals(&self) -> Vec<Vec<Act>> {
        let mut groups_of_acts = Vec::new();
        let got = self.computed_back();
        if got.iter().any(Option::is_some) {
            groups_of_acts.extend(self.of_stored(&Stored::of(self, got)));
        }
        let wrong = self.pair.wrong_channels();
        for mask in groups(&wrong) {
            let Some(channels) = Channels::of(&mask) else {
                continue;
            };
            let pairs: Vec<(f64, f64)> = self
                .of_channels(&mask)
                .map(|i| (self.pair.want[i], self.pair.got[i]))
                .collect();
            let changes = Change::fitting(&pairs, Values::Reals).into_iter();
            groups_of_acts.extend(changes.map(|change| alone(Act::Final { channels, change })));
        }
        groups_of_acts.extend(self.slips_by_channel().into_iter().map(alone));
        groups_of_acts
    }

    /// The stored values that the final ones were computed of, if scales and biases were the right ones.
    fn computed_back(&self) -> Vec<Option<u8>> {
        let numbers = &self.ptm.header.scale_bias;
        let (count, coefficients) = (self.pair.channels, self.ptm.planes.shape.coefficients());
        let whole = |value: f64| {
            let near = value.round();
            ((near - value).abs() <= WHOLE && (0.0..=255.0).contains(&near)).then_some(near as u8)
        };
        let back = |(i, &value): (usize, &f64)| match i % count {
            channel if channel < coefficients => {
                whole(value / numbers.scale[channel % 6] + numbers.bias[channel % 6])
            }
            _ => whole(value),
        };
        self.pair.got.iter().enumerate().map(back).collect()
    }

    /// Slips that explain one coefficient of every polynomial, whatever the others are.
    fn slips_by_channel(&self) -> Vec<Act> {
        let view = &self.witness.observation.view;
        let planes = &self.ptm.planes;
        let right = Numbers::of(planes, &self.ptm.header.scale_bias, view, &self.reading);
        let before = self.pair.wrong_channels();
        let mut acts = Vec::new();
        for (formula, says, numbers) in right.slips(planes.shape) {
            let made = numbers.frame(planes, &self.reading, view);
            let Some(pair) = Pair::of(&made, self.received) else {
                continue;
            };
            let after = pair.wrong_channels();
            let better = before
                .iter()
                .zip(&after)
                .any(|(before, after)| *before && !after);
            let worse = before
                .iter()
                .zip(&after)
                .any(|(before, after)| !before && *after);
            if better && !worse {
                acts.push(Act::Slip(formula, says));
            }
        }
        acts
    }

    /// What may have been done to colors, and to the values behind them.
    fn of_colors(&self) -> Vec<Vec<Act>> {
        let view = &self.witness.observation.view;
        let slips = single_slips(&self.ptm, view, &self.reading, self.received);
        let mut found: Vec<Vec<Act>> = slips
            .into_iter()
            .map(|(formula, says)| alone(Act::Slip(formula, says)))
            .collect();
        if found.is_empty() {
            let joint = joint_slips(&self.ptm, view, &self.reading, self.received);
            let acts = |group: Vec<_>| {
                group
                    .into_iter()
                    .map(|(formula, says)| Act::Slip(formula, says))
            };
            found.extend(joint.into_iter().map(|group| acts(group).collect()));
        }
        found.extend(self.misread_colors().into_iter().map(alone));
        if found.is_empty() {
            found.extend(self.exchanged_numbers().into_iter().map(alone));
        }
        found.extend(self.retouched().into_iter().map(alone));
        found.extend(self.tried().into_iter().map(alone));
        found
    }

    /// Scales and biases of other coefficients.
    fn exchanged_numbers(&self) -> Vec<Act> {
        let view = &self.witness.observation.view;
        let acts = Terms::exchanges().into_iter().map(Act::Terms);
        let fits = |act: &Act| {
            let made = frame(&[act], &self.ptm, view, &self.reading);
            alike(&made, self.received)
        };
        acts.filter(fits).take(4).collect()
    }

    /// Colors that are a function of the right ones.
    fn retouched(&self) -> Vec<Act> {
        let view = &self.witness.observation.view;
        let exact = values(&[], &self.ptm, view, &self.reading);
        let wrong = self.pair.wrong_channels();
        let mut masks = vec![vec![true; 3]];
        masks.extend(
            (0..3)
                .filter(|&k| wrong[k])
                .map(|one| (0..3).map(|k| k == one).collect()),
        );
        let mut acts = Vec::new();
        for mask in masks {
            let pairs: Vec<(f64, f64)> = self
                .of_channels(&mask)
                .map(|i| (exact[i], self.pair.got[i]))
                .collect();
            let changes = Change::fitting(&pairs, Values::Colors);
            acts.extend(changes.into_iter().map(|change| Act::Shown {
                colors: [mask[0], mask[1], mask[2]],
                change,
            }));
        }
        acts
    }

    /// Places and orders that cannot be read off colors, one after the other.
    fn tried(&self) -> Vec<Act> {
        if self.pair.want.len() > SMALL {
            return Vec::new();
        }
        let all = Channels::of(&[true; 18]).into_iter();
        let far: Vec<Strides> = (-18..=18)
            .filter(|&shift| shift != 0)
            .map(|shift| Strides::RIGHT.later(shift))
            .chain(Strides::all(false))
            .collect();
        let texels = all.flat_map(|channels| {
            let near = Strides::all(false).into_iter();
            near.map(move |strides| Act::Texels { channels, strides })
        });
        let blocks = far.into_iter().flat_map(|strides| {
            let of = Block::of(self.witness.case.format()).iter();
            let single = of.map(|&(block, ..)| block);
            let others = [Block::All, Block::Indices];
            let blocks = single.chain(others).collect::<Vec<_>>();
            blocks
                .into_iter()
                .map(move |block| Act::Block { block, strides })
        });
        let orders = orders().into_iter().map(Act::Coefficients);
        let fits = |act: &Act| {
            let mut ptm = self.ptm.clone();
            act.apply(&mut ptm, self.witness).is_ok()
                && ptm.planes.samples != self.ptm.planes.samples
                && alike(
                    &frame(&[act], &ptm, &self.witness.observation.view, &self.reading),
                    self.received,
                )
        };
        orders
            .chain(texels)
            .chain(blocks)
            .filter(fits)
            .take(4)
            .collect()
    }
}

/// Orders of six coefficients that are tried where they cannot be read off.
fn orders() -> Vec<[usize; 6]> {
    let right = [0, 1, 2, 3, 4, 5];
    let mut orders = vec![[5, 4, 3, 2, 1, 0], [1, 2, 3, 4, 5, 0], [5, 0, 1, 2, 3, 4]];
    for a in 0..6 {
        for b in a + 1..6 {
            let mut order = right;
            order.swap(a, b);
            orders.push(order);
        }
    }
    for (a, taken) in (0..36).map(|pair| (pair / 6, pair % 6)) {
        if a != taken {
            let mut order = right;
            order[a] = taken;
            orders.push(order);
        }
    }
    orders
}

/// Sets of channels that may have one cause: all of them, those of one coefficient, the colors, each wrong one alone.
fn groups(wrong: &[bool]) -> Vec<Vec<bool>> {
    let count = wrong.len();
    let coefficients = if count == 18 { 18 } else { 6 };
    let of = |holds: &dyn Fn(usize) -> bool| -> Vec<bool> {
        (0..count).map(|k| wrong[k] && holds(k)).collect()
    };
    // Where a change leaves most values as they are, channels may be right by chance: the widest sets come first.
    let wide = |holds: &dyn Fn(usize) -> bool| -> Vec<bool> { (0..count).map(holds).collect() };
    let mut groups = vec![
        wide(&|_| true),
        wide(&|k| k < coefficients),
        wide(&|k| k >= coefficients),
    ];
    groups.extend((0..6).map(|a| wide(&|k| k < coefficients && k % 6 == a)));
    groups.extend([
        of(&|_| true),
        of(&|k| k < coefficients),
        of(&|k| k >= coefficients),
    ]);
    groups.extend((0..6).map(|a| of(&|k| k < coefficients && k % 6 == a)));
    groups.extend((0..count / 6).map(|p| of(&|k| k < coefficients && k / 6 == p)));
    groups.extend((0..count).map(|one| of(&|k| k == one)));
    let mut distinct: Vec<Vec<bool>> = Vec::new();
    for group in groups {
        if group.contains(&true) && !distinct.contains(&group) {
            distinct.push(group);
        }
    }
    distinct
}

/// Whether every value stands where `strides` say, as far as that is inside of what there is; four or more of them, and
/// half of all.
fn fits(
    strides: &Strides,
    extent: Extent,
    got: &dyn Fn(usize, usize, usize) -> Option<u8>,
    value: &dyn Fn(isize) -> Option<u8>,
) -> bool {
    let (mut compared, mut first, mut differing) = (0, None, false);
    for y in 0..extent.h {
        for x in 0..extent.w {
            for k in 0..extent.c {
                let Some(value) = value(strides.place(x, y, k, extent)) else {
                    continue;
                };
                if got(x, y, k) != Some(value) {
                    return false;
                }
                compared += 1;
                differing |= first.is_some_and(|first| first != value);
                first.get_or_insert(value);
            }
        }
    }
    differing && compared >= 4 && compared * 2 >= extent.w * extent.h * extent.c
}
