//! Planes from what their streams hold (§2.9.2 – 2.9.5, 2.9.8), with every decision as a choice.
//!
//! A decoder under test shows every plane, and with it the reference of every plane. So each plane can be made again from
//! the reference that was shown, by itself, and a wrong plane tells of its own rule alone.

use super::means::MEANS;
use crate::decode::{predict, streams_as};
use crate::parts::Step;
use crate::ptm::Size;
use crate::reading::Reading;

/// A file's planes before they are rebuilt.
pub(in crate::diagnose) struct Coding {
    pub size: Size,
    pub is_jpeg_ls: bool,
    pub parameter: i64,
    /// The planes in the order in which they are decoded.
    pub sequence: Vec<usize>,
    pub planes: Vec<CodedPlane>,
}

/// One of them.
pub(in crate::diagnose) struct CodedPlane {
    pub residuals: Vec<u8>,
    pub step: Step,
    pub rank: i64,
    pub records: Vec<[u8; 5]>,
}

/// One decision that is taken otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnose) enum Slip {
    /// Every sample that a stream holds is so much more, within 0…255.
    Shifted(i8),
    Sum(Sum),
    Inverse(Inverse),
    /// Whether a reference is inverted, or moved, is taken from its own entry.
    ByReference {
        inverted: bool,
    },
    /// Predicted from the plane with the number before; what is not decoded yet is so.
    FromPlaneBefore(Undecoded),
    /// Predicted from the plane so many numbers on, where there is one; what is not decoded yet is so.
    FromNeighbor(i8, Undecoded),
    /// What stands in a list for the place of a plane in the order, not for its number.
    ByPlace(List),
    /// A reference is inverted and moved as the entry of the plane so many numbers on says, where there is one.
    TransformOfNeighbor(i8),
    /// A reference is inverted where that of any plane before was.
    StaysInverted,
    /// What an intra coded plane holds is inverted where its transform says so.
    IntraInverted,
    /// What an intra coded plane holds is so much more, modulo 256.
    IntraPlus(u8),
    NotMoved,
    Vector(Vector),
    /// Whole texels and halves of a displacement.
    Split(Whole, Half),
    /// By its place in the list of means; of two columns, of two rows, of four.
    Mean {
        how: usize,
        of: [bool; 3],
    },
    /// Beyond the first column, the last, the first stored row, the last.
    Border {
        how: Border,
        sides: [bool; 4],
        reach: Reach,
    },
    /// The first sample of a mean is kept within the plane, or within all of it but its last column or row, and the second
    /// one is its neighbor; of columns, of rows.
    FirstWithin {
        but_one: bool,
        axes: [bool; 2],
    },
    /// Columns, or rows, are kept within the height, or the width.
    WithinOther {
        axes: [bool; 2],
    },
    /// The second sample of a mean is the one before the first; of columns, of rows.
    HalfBefore {
        axes: [bool; 2],
    },
    /// Columns, or rows, are kept within all but the last one.
    WithinLess {
        axes: [bool; 2],
    },
    Order(Order),
    Records(Records),
    /// What was corrected stands in the place of the reference as well.
    Overwrites,
}

/// What becomes of residual and predictor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnose) enum Sum {
    /// So many times each, and a number, modulo 256.
    Terms {
        residual: i8,
        predictor: i8,
        plus: u8,
    },
    /// Sums below 0, and above 255, are limited.
    Limited { below: bool, above: bool },
    /// 255 is added below 0, or subtracted above 255, where 256 belongs.
    Modulo255 { below: bool, above: bool },
    /// Sums are taken modulo 255.
    Remainder255,
    /// Sums below 0 lose their sign.
    Absolute,
    /// Residual and predictor, bit by bit exclusive or.
    Xor,
    /// The residual less 128 is at least −127.
    ResidualLimited,
}

/// What becomes of v where it is inverted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnose) enum Inverse {
    /// This number less v.
    From(u8),
    /// The largest sample less v.
    FromLargest,
    /// v
    None,
    /// Samples of this value stay as they are.
    NoneOf(u8),
}

/// What stands in the place of a plane that is not decoded yet.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::diagnose) enum Undecoded {
    #[default]
    Zeros,
    /// What its stream holds.
    Stream,
}

/// What 2.9 lists for each plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnose) enum List {
    Transforms,
    Vectors,
    Records,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnose) enum Vector {
    Exchanged,
    /// x or y, by its place, for both.
    Copied(usize),
    Negated([bool; 2]),
    Without([bool; 2]),
    Absolute,
    Doubled,
    /// Half of it, the floor of that.
    Halved([bool; 2]),
    /// So many bits of x, y or both.
    Bits(u32, [bool; 2]),
    /// At least and at most so much; x, y or both.
    Within([i64; 2], [bool; 2]),
    /// x, y or both of the plane so many places before.
    Earlier(usize, [bool; 2]),
    /// y from the tenth number of the lists on, also where there are eighteen planes.
    YFromTheTenth,
    /// x, y or both of the plane as far from the last one.
    FromEnd([bool; 2]),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnose) enum Whole {
    Floor,
    TowardZero,
    AwayFromZero,
    Exchanged,
    ExchangedTowardZero,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnose) enum Half {
    Own,
    None,
    OfX,
    OfY,
    Exchanged,
    PositiveOnly,
    /// Of y alone.
    NotOfX,
    /// Of x alone.
    NotOfY,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnose) enum Border {
    Wrapped,
    OneBefore,
    Mirrored,
    Reflected,
    OtherEnd,
    /// The sample that is stored there: of the next row or the row before.
    NextRow,
    Value(u8),
}

/// How far beyond the edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnose) enum Reach {
    Any,
    Near,
    Far,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnose) enum Order {
    AsText,
    SignedByte,
    /// So many passes of a bubble sort are missing, and each ends so many places too early.
    Unsorted(usize, usize),
    /// Of planes of one rank only the last is decoded, or the first.
    LastOfRank,
    FirstOfRank,
    /// Planes that are not predicted come first, then the others by their numbers; what is not decoded yet is so.
    IntraFirst(Undecoded),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnose) enum Records {
    Ignored,
    LastLost,
    /// The number of records is kept in a byte.
    CountInByte,
    Plus(u8),
    Added,
    /// 255 less the value, in planes whose reference is inverted.
    Inverted,
    /// The value of the first record for all.
    FirstValue,
    /// Which of P3, P2, P1, P0 stand at the four places of a position; 4 for none.
    Bytes([u8; 4]),
    /// Those of the plane before, where there are none.
    OfPlaneBefore,
    /// The same, if it is a single one.
    SingleOfPlaneBefore,
    ByColumns,
    /// The column times the height, and the row.
    Transposed,
    /// The lowest byte counts from −128 to 127, or without its highest bit.
    LowSigned,
    LowSevenBits,
    /// So many records of a plane at the most.
    AtMost(usize),
    /// Those before the first with position 0.
    UntilZero,
    /// As `ByColumns`; what is beyond the last texel is the last.
    ByColumnsWithin,
    /// P1 counts 255 times.
    HighByte255,
    LaterFrom255,
    RowsFromTop,
    OneLater,
    OneEarlier,
}

/// All decisions; what is left open is as the reading has it.
#[derive(Clone, Copy, Default)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is a decision of its own"
)]
struct Rules {
    shift: i8,
    sum: Option<Sum>,
    inverse: Option<Inverse>,
    is_intra_inverted: bool,
    /// What is added to it.
    intra_plus: u8,
    by_place: Option<List>,
    stays_inverted: bool,
    transform_neighbor: i8,
    is_inverted_by_reference: bool,
    is_moved_by_reference: bool,
    is_from_plane_before: bool,
    from_neighbor: i8,
    undecoded: Undecoded,
    is_still: bool,
    vector: Option<Vector>,
    split: Option<(Whole, Half)>,
    means: [Option<usize>; 3],
    borders: [Option<(Border, Reach)>; 4],
    first: [Option<bool>; 2],
    within_other: [bool; 2],
    within_less: [bool; 2],
    half_before: [bool; 2],
    order: Option<Order>,
    records: Option<Records>,
}

impl Rules {
    fn of(slips: &[Slip]) -> Rules {
        let mut rules = Rules::default();
        for &slip in slips {
            rules.set(slip);
        }
        rules
    }

    fn set(&mut self, slip: Slip) {
        match slip {
            Slip::Shifted(by) => self.shift = by,
            Slip::Sum(sum) => self.sum = Some(sum),
            Slip::Inverse(inverse) => self.inverse = Some(inverse),
            Slip::ByReference { inverted: true } => self.is_inverted_by_reference = true,
            Slip::ByReference { inverted: false } => self.is_moved_by_reference = true,
            Slip::FromPlaneBefore(undecoded) => {
                (self.is_from_plane_before, self.undecoded) = (true, undecoded);
            }
            Slip::FromNeighbor(by, undecoded) => {
                (self.from_neighbor, self.undecoded) = (by, undecoded);
            }
            Slip::ByPlace(list) => self.by_place = Some(list),
            Slip::TransformOfNeighbor(by) => self.transform_neighbor = by,
            Slip::StaysInverted => self.stays_inverted = true,
            Slip::IntraInverted => self.is_intra_inverted = true,
            Slip::IntraPlus(plus) => self.intra_plus = plus,
            Slip::NotMoved => self.is_still = true,
            Slip::Vector(vector) => self.vector = Some(vector),
            Slip::Split(whole, half) => self.split = Some((whole, half)),
            Slip::Mean { how, of } => {
                for kind in (0..3).filter(|&kind| of[kind]) {
                    self.means[kind] = Some(how);
                }
            }
            Slip::Border { how, sides, reach } => {
                for side in (0..4).filter(|&side| sides[side]) {
                    self.borders[side] = Some((how, reach));
                }
            }
            Slip::FirstWithin { but_one, axes } => {
                for axis in (0..2).filter(|&axis| axes[axis]) {
                    self.first[axis] = Some(but_one);
                }
            }
            Slip::WithinOther { axes } => self.within_other = axes,
            Slip::HalfBefore { axes } => self.half_before = axes,
            Slip::WithinLess { axes } => self.within_less = axes,
            Slip::Order(order) => {
                self.order = Some(order);
                if let Order::IntraFirst(undecoded) = order {
                    self.undecoded = undecoded;
                }
            }
            Slip::Records(records) => self.records = Some(records),
            Slip::Overwrites => {}
        }
    }

    /// Whether planes are moved otherwise.
    fn moves_otherwise(&self) -> bool {
        self.vector.is_some()
            || self.by_place == Some(List::Vectors)
            || self.split.is_some()
            || self.means.iter().any(Option::is_some)
            || self.borders.iter().any(Option::is_some)
            || self.first.iter().any(Option::is_some)
            || self.within_other.contains(&true)
            || self.within_less.contains(&true)
            || self.half_before.contains(&true)
    }
}

impl Coding {
    /// The planes of a compressed file, as `reading` reads its lists and streams.
    pub fn of(file: &[u8], ranks: &[i64], reading: &Reading) -> Option<Coding> {
        let streams = streams_as(file, reading)?;
        let coded = streams.coded();
        let mut residuals: Vec<Vec<u8>> = vec![Vec::new(); coded.plan.steps.len()];
        for (plane, samples) in streams.residuals() {
            residuals[plane] = samples.to_vec();
        }
        // Other mistakes may lose streams.
        if (residuals.iter()).any(|plane| plane.len() != coded.size.texels()) {
            return None;
        }
        let planes = residuals.into_iter().enumerate().map(|(i, residuals)| {
            let side = (reading.side_information)(&coded, i);
            CodedPlane {
                residuals,
                step: coded.plan.steps[i],
                rank: ranks.get(i).copied().unwrap_or_default(),
                records: side.as_chunks::<5>().0.to_vec(),
            }
        });
        Some(Coding {
            size: coded.size,
            is_jpeg_ls: coded.format.is_jpeg_ls(),
            parameter: coded.plan.parameter,
            sequence: coded.plan.sequence.clone(),
            planes: planes.collect(),
        })
    }

    /// Plane `i`, where all others are as `planes` says; `slips` are the decisions that are taken otherwise.
    pub fn plane(
        &self,
        i: usize,
        planes: &[Vec<u8>],
        slips: &[Slip],
        reading: &Reading,
    ) -> Vec<u8> {
        let rules = Rules::of(slips);
        let (step, mut plane) = (&self.planes[i].step, self.planes[i].residuals.clone());
        // Whether a sample at a limit was beyond it before, nobody knows.
        for sample in plane
            .iter_mut()
            .filter(|sample| !matches!(**sample, 0 | 255))
        {
            *sample = sample.saturating_add_signed(rules.shift);
        }
        let sequence = self.sequence(slips);
        let place = |i: usize| sequence.iter().position(|&other| other == i);
        let Some(own) = place(i) else {
            return vec![0; plane.len()];
        };
        if let Some(reference) = step.reference {
            let reference = self.reference(i, reference, &rules);
            let is_there = place(reference).is_some_and(|other| other < own);
            let blank = || match rules.undecoded {
                Undecoded::Zeros => vec![0; plane.len()],
                Undecoded::Stream => self.planes[reference].residuals.clone(),
            };
            let predictor = match is_there {
                true => self.predictor(i, &planes[reference], &rules, reading),
                false => self.predictor(i, &blank(), &rules, reading),
            };
            self.add(&mut plane, &predictor, &rules, reading);
        } else {
            if rules.is_intra_inverted && step.inverted {
                (reading.invert)(&mut plane);
            }
            for sample in &mut plane {
                *sample = sample.wrapping_add(rules.intra_plus);
            }
        }
        let listed = match rules.by_place {
            Some(List::Records) => self.place(i),
            _ => i,
        };
        self.correct(listed, &mut plane, rules.records);
        plane
    }

    /// The place of plane `i` in the order of decoding.
    fn place(&self, i: usize) -> usize {
        let place = self.sequence.iter().position(|&other| other == i);
        place.unwrap_or(i)
    }

    /// The plane that plane `i` is predicted from, where its entry says `listed`.
    fn reference(&self, i: usize, listed: usize, rules: &Rules) -> usize {
        let neighbor = listed.checked_add_signed(rules.from_neighbor.into());
        let neighbor = neighbor.filter(|&other| other < self.planes.len());
        match i.checked_sub(1) {
            Some(before) if rules.is_from_plane_before => before,
            _ => neighbor.unwrap_or(listed),
        }
    }

    /// Whether a plane is predicted from one that is not decoded yet.
    pub fn lacks_a_reference(&self, slips: &[Slip]) -> bool {
        let rules = Rules::of(slips);
        let sequence = self.sequence(slips);
        let is_early = |(place, &i): (usize, &usize)| {
            let listed = self.planes[i].step.reference;
            listed.is_some_and(|listed| {
                let reference = self.reference(i, listed, &rules);
                !sequence[..place].contains(&reference)
            })
        };
        sequence.iter().enumerate().any(is_early)
    }

    /// The planes in the order in which they are decoded with these slips.
    pub fn sequence(&self, slips: &[Slip]) -> Vec<usize> {
        let order = slips.iter().find_map(|slip| match slip {
            Slip::Order(order) => Some(*order),
            _ => None,
        });
        let rank = |i: &usize| self.planes[*i].rank;
        let mut sequence: Vec<usize> = (0..self.planes.len()).collect();
        match order {
            None => sequence.clone_from(&self.sequence),
            Some(Order::AsText) => sequence.sort_by_key(|i| rank(i).to_string()),
            Some(Order::SignedByte) => sequence.sort_by_key(|i| rank(i) as i8),
            Some(Order::Unsorted(missing, early)) => {
                let passes = sequence.len().saturating_sub(1 + missing);
                for pass in 0..passes {
                    for k in 0..(sequence.len() - pass - 1).saturating_sub(early) {
                        if rank(&sequence[k]) > rank(&sequence[k + 1]) {
                            sequence.swap(k, k + 1);
                        }
                    }
                }
            }
            Some(Order::LastOfRank) => {
                sequence.sort_by_key(rank);
                let next = sequence[1..].iter().map(rank).map(Some).chain([None]);
                let next: Vec<Option<i64>> = next.collect();
                let mut next = next.into_iter();
                sequence.retain(|i| next.next() != Some(Some(rank(i))));
            }
            Some(Order::FirstOfRank) => {
                sequence.sort_by_key(rank);
                sequence.dedup_by_key(|i| rank(i));
            }
            Some(Order::IntraFirst(_)) => {
                sequence.sort_by_key(|&i| self.planes[i].step.reference.is_some());
            }
        }
        sequence
    }

    /// What plane `i` is predicted with, where all others are as `planes` says; nothing for an intra coded plane.
    pub fn right_predictor(&self, i: usize, planes: &[Vec<u8>], reading: &Reading) -> Vec<u8> {
        let reference = self.planes[i].step.reference;
        let of =
            |reference: usize| self.predictor(i, &planes[reference], &Rules::default(), reading);
        reference.map_or_else(Vec::new, of)
    }

    /// The same with other rules.
    fn predictor(&self, i: usize, reference: &[u8], rules: &Rules, reading: &Reading) -> Vec<u8> {
        let mut step = self.planes[i].step;
        if let Some(reference) = step.reference {
            let theirs = &self.planes[reference].step;
            if rules.is_inverted_by_reference {
                step.inverted = theirs.inverted;
            }
            if rules.is_moved_by_reference {
                step.moved = theirs.moved;
            }
        }
        let neighbor = i.checked_add_signed(rules.transform_neighbor.into());
        if let Some(theirs) = neighbor.and_then(|other| self.planes.get(other)) {
            (step.inverted, step.moved) = (theirs.step.inverted, theirs.step.moved);
        }
        if rules.by_place == Some(List::Transforms) {
            let listed = &self.planes[self.place(i)].step;
            (step.inverted, step.moved) = (listed.inverted, listed.moved);
        }
        if rules.stays_inverted {
            let before = self.sequence[..self.place(i)].iter();
            let mut before = before.map(|&other| &self.planes[other].step);
            step.inverted |= before.any(|step| step.inverted && step.reference.is_some());
        }
        step.moved &= !rules.is_still;
        if rules.inverse.is_none() && !rules.moves_otherwise() {
            return (reading.predictor)(reference, &step, self.size, reading).into_owned();
        }
        let still = Step {
            moved: false,
            ..step
        };
        let turned = |plane: &[u8]| match rules.inverse.filter(|_| step.inverted) {
            Some(Inverse::None) => plane.to_vec(),
            Some(Inverse::NoneOf(kept)) => {
                let one = |&v: &u8| if v == kept { v } else { 255 - v };
                plane.iter().map(one).collect()
            }
            Some(Inverse::From(top)) => plane.iter().map(|&v| top.wrapping_sub(v)).collect(),
            Some(Inverse::FromLargest) => {
                let top = plane.iter().copied().max().unwrap_or_default();
                plane.iter().map(|&v| top - v).collect()
            }
            None => predict::inverted_then_moved(plane, &still, self.size, reading).into_owned(),
        };
        let moved = |plane: &[u8]| match step.moved {
            true if rules.moves_otherwise() => self.moved(i, plane, rules, reading),
            true => predict::moved(plane, self.size, step.motion, reading),
            false => plane.to_vec(),
        };
        let is_moved_first: crate::reading::Predictor = predict::moved_then_inverted;
        match std::ptr::fn_addr_eq(reading.predictor, is_moved_first) {
            true => turned(&moved(reference)),
            false => moved(&turned(reference)),
        }
    }

    /// A plane seen through the vector of plane `i`.
    fn moved(&self, i: usize, plane: &[u8], rules: &Rules, reading: &Reading) -> Vec<u8> {
        let taps = Taps {
            coding: self,
            displacement: self.displacement(i, rules, reading),
            rules,
        };
        let (width, height) = self.lengths();
        let texel = |(x, y): (i64, i64)| {
            let ([left, right], half_x) = taps.along(0, x);
            let ([first, second], half_y) = taps.along(1, y);
            let corners = [
                (left, first),
                (right, first),
                (left, second),
                (right, second),
            ];
            let four = corners.map(|(x, y)| taps.at(plane, x, y, reading));
            match (half_x, half_y, rules.means) {
                (true, false, [Some(how), ..]) => (MEANS[how].of)(&four[..2]),
                (false, true, [_, Some(how), _]) => (MEANS[how].of)(&[four[0], four[2]]),
                (true, true, [.., Some(how)]) => (MEANS[how].of)(&four),
                _ => (reading.motion_half)(four),
            }
        };
        (0..height)
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .map(texel)
            .collect()
    }

    fn lengths(&self) -> (i64, i64) {
        (i64::from(self.size.width), i64::from(self.size.height))
    }

    /// The displacement of plane `i`, in half texels along columns and stored rows.
    fn displacement(&self, i: usize, rules: &Rules, reading: &Reading) -> [i64; 2] {
        let of = |i: usize| [self.planes[i].step.motion.0, self.planes[i].step.motion.1];
        let i = match rules.by_place {
            Some(List::Vectors) => self.place(i),
            _ => i,
        };
        let mut v = of(i);
        for (axis, part) in v.iter_mut().enumerate() {
            *part = (*part).clamp(-(1 << 40), 1 << 40);
            *part = match rules.vector {
                Some(Vector::Exchanged) => of(i)[1 - axis],
                Some(Vector::Copied(which)) => of(i)[which],
                Some(Vector::Negated(axes)) if axes[axis] => -*part,
                Some(Vector::Without(axes)) if axes[axis] => 0,
                Some(Vector::Absolute) => part.abs(),
                Some(Vector::Doubled) => 2 * *part,
                Some(Vector::Halved(axes)) if axes[axis] => part.div_euclid(2),
                Some(Vector::Bits(bits, axes)) if axes[axis] => *part << (64 - bits) >> (64 - bits),
                Some(Vector::Within([least, most], axes)) if axes[axis] => {
                    (*part).clamp(least, most)
                }
                Some(Vector::Earlier(places, axes)) if axes[axis] && i >= places => {
                    of(i - places)[axis]
                }
                Some(Vector::YFromTheTenth) if axis == 1 && self.planes.len() == 18 => match i {
                    0..9 => of(i + 9)[0],
                    _ => of(i - 9)[1],
                },
                Some(Vector::FromEnd(axes)) if axes[axis] => of(self.planes.len() - 1 - i)[axis],
                _ => *part,
            };
        }
        let y = (reading.motion_sign)((reading.motion_vertical)(v[1]));
        [(reading.motion_sign)(v[0]), y].map(|part| part.clamp(-(1 << 40), 1 << 40))
    }

    /// The vector that counts, as the reading has it, and how far beyond each edge it leads from a texel, in texels.
    pub fn beyond(&self, i: usize, x: i64, y: i64, reading: &Reading) -> [i64; 4] {
        if !self.planes[i].step.moved {
            return [0; 4];
        }
        let rules = Rules::default();
        let taps = Taps {
            coding: self,
            displacement: self.displacement(i, &rules, reading),
            rules: &rules,
        };
        let (width, height) = self.lengths();
        let ([left, right], _) = taps.along(0, x);
        let ([first, second], _) = taps.along(1, y);
        [-left, right - (width - 1), -first, second - (height - 1)].map(|far| far.max(0))
    }

    /// Adds the predictor to the residuals.
    fn add(&self, plane: &mut [u8], predictor: &[u8], rules: &Rules, reading: &Reading) {
        let Some(slip) = rules.sum else {
            return match self.is_jpeg_ls {
                true => (reading.predict_jpeg_ls)(plane, predictor),
                false => (reading.predict)(plane, predictor),
            };
        };
        for (value, &predicted) in plane.iter_mut().zip(predictor) {
            let sum = i32::from(*value) + i32::from(predicted) - 128;
            let times = |many: i8, of: u8| (many as u8).wrapping_mul(of);
            *value = match slip {
                Sum::Terms {
                    residual,
                    predictor,
                    plus,
                } => times(residual, *value)
                    .wrapping_add(times(predictor, predicted))
                    .wrapping_add(plus),
                Sum::Limited { below: true, .. } if sum < 0 => 0,
                Sum::Limited { above: true, .. } if sum > 255 => 255,
                Sum::Remainder255 => sum.rem_euclid(255) as u8,
                Sum::Modulo255 { below: true, .. } if sum < 0 => (sum + 255) as u8,
                Sum::Modulo255 { above: true, .. } if sum > 255 => (sum - 255) as u8,
                Sum::Xor => *value ^ predicted,
                Sum::Absolute => sum.unsigned_abs() as u8,
                Sum::ResidualLimited if *value == 0 => (sum + 1) as u8,
                _ => sum as u8,
            };
        }
    }

    /// Puts the values of records in their places; what leads beyond the plane is left out.
    fn correct(&self, i: usize, plane: &mut [u8], slip: Option<Records>) {
        let (width, height) = (self.size.width as usize, self.size.height as usize);
        let texels = plane.len();
        for (position, value) in self.records(i, slip) {
            let at = position as usize;
            let at = match slip {
                Some(Records::ByColumnsWithin) => {
                    (at % height * width + at / height).min(texels - 1)
                }
                Some(Records::HighByte255) => at - (at >> 8 & 255),
                Some(Records::LaterFrom255) if at > 254 => at + 1,
                Some(Records::ByColumns) => at % height * width + at / height,
                Some(Records::Transposed) => at % width * height + at / width,
                Some(Records::LowSigned) if at & 0x80 != 0 => at.wrapping_sub(256),
                Some(Records::LowSevenBits) => at & !0x80,
                Some(Records::RowsFromTop) if at < texels => {
                    (height - 1 - at / width) * width + at % width
                }
                Some(Records::OneLater) => at + 1,
                Some(Records::OneEarlier) => at.wrapping_sub(1),
                _ => at,
            };
            if let Some(sample) = plane.get_mut(at) {
                *sample = match slip {
                    Some(Records::Added) => sample.wrapping_add(value),
                    _ => value,
                };
            }
        }
    }

    /// The records that count for plane `i`.
    fn records(&self, i: usize, slip: Option<Records>) -> Vec<(u32, u8)> {
        let mut records = &self.planes[i].records[..];
        let count = records.len();
        match slip {
            Some(Records::Ignored) => records = &[],
            Some(Records::LastLost) if count > 1 => records = &records[..count - 1],
            Some(Records::AtMost(most)) => records = &records[..count.min(most)],
            Some(Records::UntilZero) => {
                let end = records.iter().position(|record| record[..4] == [0; 4]);
                records = &records[..end.unwrap_or(count)];
            }
            Some(Records::CountInByte) => records = &records[..count % 256],
            Some(Records::OfPlaneBefore) if count == 0 => records = self.records_before(i),
            Some(Records::SingleOfPlaneBefore) if count == 0 => {
                records = self.records_before(i);
                records = if records.len() == 1 { records } else { &[] };
            }
            _ => {}
        }
        let order = match slip {
            Some(Records::Bytes(order)) => order,
            _ => [0, 1, 2, 3],
        };
        let one = |record: &[u8; 5]| {
            let byte = |from: u8| {
                if from < 4 {
                    record[usize::from(from)]
                } else {
                    0
                }
            };
            let value = match slip {
                Some(Records::Plus(more)) => record[4].wrapping_add(more),
                Some(Records::FirstValue) => records[0][4],
                Some(Records::Inverted) if self.planes[i].step.inverted => 255 - record[4],
                _ => record[4],
            };
            (u32::from_be_bytes(order.map(byte)), value)
        };
        records.iter().map(one).collect()
    }

    /// The records of the last plane that is decoded before plane `i` and has any.
    fn records_before(&self, i: usize) -> &[[u8; 5]] {
        let earlier = self.sequence.iter().take_while(|&&other| other != i);
        let has_records = |&other: &usize| !self.planes[other].records.is_empty();
        let last = earlier.copied().filter(has_records).last();
        last.map_or(&[], |last| &self.planes[last].records)
    }
}

/// The samples that a displacement leads to.
struct Taps<'a> {
    coding: &'a Coding,
    displacement: [i64; 2],
    rules: &'a Rules,
}

impl Taps<'_> {
    fn length(&self, axis: usize) -> i64 {
        let (width, height) = self.coding.lengths();
        [width, height][axis]
    }

    /// The two places along one axis, and whether they are two.
    fn along(&self, axis: usize, from: i64) -> ([i64; 2], bool) {
        let v = self.displacement;
        let (whole, half) = self.rules.split.unwrap_or((Whole::Floor, Half::Own));
        let whole = match whole {
            Whole::Floor => v[axis].div_euclid(2),
            Whole::TowardZero => v[axis] / 2,
            Whole::AwayFromZero => v[axis] / 2 + v[axis] % 2,
            Whole::Exchanged => v[1 - axis].div_euclid(2),
            Whole::ExchangedTowardZero => v[1 - axis] / 2,
        };
        let half = match half {
            Half::Own => v[axis] & 1 != 0,
            Half::None => false,
            Half::OfX => v[0] & 1 != 0,
            Half::OfY => v[1] & 1 != 0,
            Half::Exchanged => v[1 - axis] & 1 != 0,
            Half::PositiveOnly => v[axis] % 2 == 1,
            Half::NotOfX => axis == 1 && v[axis] & 1 != 0,
            Half::NotOfY => axis == 0 && v[axis] & 1 != 0,
        };
        let mut first = from + whole;
        if let Some(but_one) = self.rules.first[axis] {
            let last = self.length(axis) - 1 - i64::from(but_one && self.length(axis) > 1);
            first = first.clamp(0, last);
        }
        let step = if self.rules.half_before[axis] { -1 } else { 1 };
        let mut places = [first, first + step * i64::from(half)];
        if self.rules.within_other[axis] {
            let last = self.length(axis).min(self.length(1 - axis)) - 1;
            places = places.map(|place| place.clamp(0, last));
        }
        if self.rules.within_less[axis] {
            let last = (self.length(axis) - 2).max(0);
            places = places.map(|place| place.clamp(0, last));
        }
        (places, half)
    }

    /// The sample there.
    fn at(&self, plane: &[u8], x: i64, y: i64, reading: &Reading) -> u8 {
        let mut place = [x, y];
        for (axis, at) in place.iter_mut().enumerate() {
            let length = self.length(axis);
            let far = (-*at).max(*at - length + 1);
            let side = 2 * axis + usize::from(*at >= 0);
            let Some((how, reach)) = self.rules.borders[side].filter(|_| far > 0) else {
                continue;
            };
            if reach == Reach::Near && far > 1 || reach == Reach::Far && far < 2 {
                continue;
            }
            let is_before = *at < 0;
            *at = match how {
                Border::Value(value) => return value,
                Border::Wrapped => at.rem_euclid(length),
                Border::OneBefore if is_before => 1.min(length - 1),
                Border::OneBefore => (length - 2).max(0),
                Border::Mirrored if is_before => (-1 - *at).min(length - 1),
                Border::Mirrored => (2 * length - 1 - *at).max(0),
                Border::Reflected if is_before => (-*at).min(length - 1),
                Border::Reflected => (2 * length - 2 - *at).max(0),
                Border::OtherEnd if is_before => length - 1,
                Border::OtherEnd => 0,
                Border::NextRow => {
                    let row = y.clamp(0, self.length(1) - 1);
                    let flat = usize::try_from(row * self.length(0) + x).ok();
                    match flat.and_then(|flat| plane.get(flat)) {
                        Some(&sample) => return sample,
                        None => *at,
                    }
                }
            };
        }
        (reading.motion_border)(plane, self.coding.size, place[0], place[1])
    }
}
