//! Slips in how planes are rebuilt, each with the planes and samples in which it is made.

use super::means::MEANS;
use super::places::{LAST, PLANES, Place, PlaneIs, SAMPLES};
use super::rules::{
    Border, Coding, Half, Inverse, List, Order, Reach, Records, Slip, Sum, Undecoded, Vector, Whole,
};
use crate::diagnose::witness::Witness;
use crate::ptm::Ptm;
use crate::reading::Reading;
use crate::session::observation::Response;

/// A slip and where it is made.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::diagnose) struct PlaneSlip {
    pub slip: Slip,
    pub place: Place,
}

/// What becomes of the stored values of a file whose planes are rebuilt with these slips.
pub(in crate::diagnose) fn apply(
    slips: &[&PlaneSlip],
    ptm: &mut Ptm,
    witness: &Witness,
    reading: &Reading,
) {
    let Some(coding) = Coding::of(&witness.built.file, witness.ranks(), reading) else {
        return;
    };
    let (right, made) = (coding.rebuilt(&[], reading), coding.rebuilt(slips, reading));
    let (width, channels) = (coding.size.width as usize, coding.planes.len());
    // Other mistakes may read another size.
    let is_of_size = [ptm.header.size, ptm.planes.size] == [coding.size; 2];
    if !is_of_size || ptm.planes.samples.len() != coding.size.texels() * channels {
        return;
    }
    for y in 0..coding.size.height as usize {
        let row = (reading.stored_row)(&ptm.header, y);
        for x in 0..width {
            for i in 0..channels {
                let stored = row * width + x;
                if made[i][stored] != right[i][stored] {
                    ptm.planes.samples[(y * width + x) * channels + i] = made[i][stored];
                }
            }
        }
    }
}

/// Whether no picture is shown of a file in which these slips predict a plane from one that is not decoded yet: some decoders
/// refuse that.
pub(in crate::diagnose) fn lack_a_reference(
    slips: &[&PlaneSlip],
    witness: &Witness,
    reading: &Reading,
) -> bool {
    let is_other =
        |one: &&&PlaneSlip| matches!(one.slip, Slip::FromPlaneBefore(_) | Slip::FromNeighbor(..));
    let others: Vec<Slip> = slips.iter().filter(is_other).map(|one| one.slip).collect();
    let is_shown = matches!(witness.observation.response, Response::Picture { .. });
    let coding = || Coding::of(&witness.built.file, witness.ranks(), reading);
    !others.is_empty()
        && !is_shown
        && coding().is_some_and(|coding| coding.lacks_a_reference(&others))
}

impl Coding {
    /// All planes, decoded with these slips.
    fn rebuilt(&self, slips: &[&PlaneSlip], reading: &Reading) -> Vec<Vec<u8>> {
        let mut planes = vec![vec![0; self.size.texels()]; self.planes.len()];
        let all: Vec<Slip> = slips.iter().map(|one| one.slip).collect();
        for i in self.sequence(&all) {
            planes[i] = self.plane_with(i, &planes, slips, reading);
            let overwrites = |one: &&PlaneSlip| {
                one.slip == Slip::Overwrites && one.place.holds_of_plane(self, i)
            };
            if let Some(reference) = self.planes[i].step.reference
                && slips.iter().any(overwrites)
            {
                let plane = planes[i].clone();
                planes[reference] = plane;
            }
        }
        planes
    }

    /// Plane `i` decoded with these slips, where all others are as `planes` says.
    pub fn plane_with(
        &self,
        i: usize,
        planes: &[Vec<u8>],
        slips: &[&PlaneSlip],
        reading: &Reading,
    ) -> Vec<u8> {
        let of_plane = slips.iter().filter(|one| one.place.holds_of_plane(self, i));
        let (of_samples, of_all): (Vec<&&PlaneSlip>, Vec<&&PlaneSlip>) =
            of_plane.partition(|one| one.place.sample.is_some());
        let mut made: Vec<Slip> = of_all.iter().map(|one| one.slip).collect();
        let mut plane = self.plane(i, planes, &made, reading);
        for one in of_samples {
            let Some(sample) = one.place.sample else {
                continue;
            };
            made.push(one.slip);
            let other = self.plane(i, planes, &made, reading);
            let predictor = self.right_predictor(i, planes, reading);
            for at in 0..plane.len() {
                let of = || self.sample((i, at), planes, &predictor, reading);
                if plane[at] != other[at] && (SAMPLES[sample].holds)(&of()) {
                    plane[at] = other[at];
                }
            }
            made.pop();
        }
        plane
    }
}

const AXES: [[bool; 2]; 3] = [[true, true], [true, false], [false, true]];

impl Slip {
    /// All that are tried, the plainest first; sums are solved.
    pub fn all() -> Vec<Slip> {
        let mut all = vec![
            Slip::Inverse(Inverse::None),
            Slip::NotMoved,
            Slip::IntraInverted,
            Slip::IntraPlus(128),
            Slip::IntraPlus(127),
            Slip::IntraPlus(129),
            Slip::StaysInverted,
        ];
        let lists = [List::Transforms, List::Vectors, List::Records];
        all.extend(lists.map(Slip::ByPlace));
        for undecoded in [Undecoded::Zeros, Undecoded::Stream] {
            all.push(Slip::FromPlaneBefore(undecoded));
            all.extend([-1, 1].map(|by| Slip::FromNeighbor(by, undecoded)));
        }
        all.extend([true, false].map(|inverted| Slip::ByReference { inverted }));
        all.extend([-1, 1].map(Slip::TransformOfNeighbor));
        all.extend([0, 254, 1, 128, 127].map(|top| Slip::Inverse(Inverse::From(top))));
        let others = [
            Inverse::NoneOf(0),
            Inverse::NoneOf(255),
            Inverse::FromLargest,
        ];
        all.extend(others.map(Slip::Inverse));
        for (below, above) in [(true, true), (true, false), (false, true)] {
            let sums = [
                Sum::Limited { below, above },
                Sum::Modulo255 { below, above },
            ];
            all.extend(sums.map(Slip::Sum));
        }
        let sums = [
            Sum::Remainder255,
            Sum::Absolute,
            Sum::Xor,
            Sum::ResidualLimited,
        ];
        all.extend(sums.map(Slip::Sum));
        all.extend([-1, 1, -2, 2].map(Slip::Shifted));
        all.extend(Vector::all().map(Slip::Vector));
        all.extend(splits());
        all.extend(means());
        all.extend(borders());
        all.extend(AXES.into_iter().rev().map(|axes| Slip::HalfBefore { axes }));
        for axes in AXES {
            all.extend([false, true].map(|but_one| Slip::FirstWithin { but_one, axes }));
            all.push(Slip::WithinOther { axes });
            all.push(Slip::WithinLess { axes });
        }
        let orders = [
            Order::AsText,
            Order::SignedByte,
            Order::LastOfRank,
            Order::FirstOfRank,
            Order::IntraFirst(Undecoded::Stream),
            Order::IntraFirst(Undecoded::Zeros),
        ];
        let unsorted =
            (0..=3).flat_map(|missing| [0, 1].map(|early| Order::Unsorted(missing, early)));
        let unsorted = unsorted.filter(|order| *order != Order::Unsorted(0, 0));
        all.extend(orders.into_iter().chain(unsorted).map(Slip::Order));
        all.extend(Records::all().into_iter().map(Slip::Records));
        all
    }

    /// Whether plane `i` could show it.
    pub fn concerns(self, coding: &Coding, i: usize) -> bool {
        let plane = &coding.planes[i];
        let (step, is_predicted) = (&plane.step, plane.step.reference.is_some());
        match self {
            Slip::Sum(_)
            | Slip::ByReference { .. }
            | Slip::FromPlaneBefore(_)
            | Slip::FromNeighbor(..)
            | Slip::ByPlace(List::Transforms)
            | Slip::StaysInverted
            | Slip::TransformOfNeighbor(_)
            | Slip::Overwrites => is_predicted,
            Slip::Inverse(_) => is_predicted && step.inverted,
            Slip::IntraInverted => !is_predicted && step.inverted,
            Slip::IntraPlus(_) => !is_predicted,
            Slip::Order(_) | Slip::Shifted(_) | Slip::ByPlace(List::Records) => true,
            Slip::Records(Records::OfPlaneBefore | Records::SingleOfPlaneBefore) => {
                plane.records.is_empty()
            }
            Slip::Records(_) => !plane.records.is_empty(),
            _ => is_predicted && step.moved,
        }
    }

    /// What is done, as a sentence without its subject.
    pub fn says(self) -> String {
        match self {
            Slip::Sum(sum) => sum.says(),
            Slip::Inverse(inverse) => inverse.says(),
            Slip::IntraPlus(plus) => format!(
                "subtracts {} from intra coded planes, modulo 256",
                plus.wrapping_neg()
            ),
            Slip::Shifted(by) => format!(
                "decodes every sample of its streams {} too {}, as a level shift of {} would where 128 belongs",
                by.unsigned_abs(),
                if by < 0 { "small" } else { "large" },
                128 + i16::from(by)
            ),
            Slip::Vector(vector) => vector.says(),
            Slip::Split(whole, half) => says_split(whole, half),
            Slip::Mean { how, of } => {
                let which = match of {
                    [true, true, true] => "two samples and of four",
                    [true, true, false] => "two samples",
                    [true, ..] => "two columns",
                    [_, true, _] => "two rows",
                    _ => "four samples",
                };
                format!("{} in means of {which}", MEANS[how].says)
            }
            Slip::Border { how, sides, reach } => says_border(how, sides, reach),
            Slip::FirstWithin { but_one, axes } => format!(
                "keeps the first sample of a mean within the {}{}, and takes its neighbor for the second one",
                lines(axes),
                if but_one { " before the last one" } else { "" },
            ),
            Slip::WithinOther { axes } => match axes {
                [true, true] => "keeps columns within the height and rows within the width",
                [true, false] => {
                    "keeps columns within the height of a plane, where its width belongs"
                }
                _ => "keeps rows within the width of a plane, where its height belongs",
            }
            .to_owned(),
            Slip::HalfBefore { axes } => format!(
                "takes the sample before, along {}, for the second one of a mean, where the one behind belongs",
                lines(axes)
            ),
            Slip::WithinLess { axes } => format!(
                "keeps the samples of a reference within all {} but the last one",
                lines(axes)
            ),
            Slip::Order(order) => order.says(),
            Slip::Records(records) => records.says(),
            _ => self.says_plain().to_owned(),
        }
    }

    /// The same of those that have no numbers.
    const fn says_plain(self) -> &'static str {
        match self {
            Slip::IntraInverted => "inverts intra coded planes whose transform says so",
            Slip::ByPlace(List::Transforms) => {
                "takes the transform of a plane by its place in the order of decoding, where its number belongs"
            }
            Slip::ByPlace(List::Vectors) => {
                "takes the vector of a plane by its place in the order of decoding, where its number belongs"
            }
            Slip::ByPlace(List::Records) => {
                "takes the side information of a plane by its place in the order of decoding, where its number belongs"
            }
            Slip::TransformOfNeighbor(by) if by < 0 => {
                "takes the transform of the plane before, where that of the plane belongs"
            }
            Slip::TransformOfNeighbor(_) => {
                "takes the transform of the next plane, where that of the plane belongs"
            }
            Slip::StaysInverted => {
                "inverts the references of all planes after the first that is inverted, in the order of decoding"
            }
            Slip::ByReference { inverted: true } => {
                "inverts a reference where the transform of the reference says so"
            }
            Slip::ByReference { inverted: false } => {
                "displaces a reference where the transform of the reference says so"
            }
            Slip::FromPlaneBefore(_) => "predicts planes from the plane with the number before",
            Slip::FromNeighbor(by, _) if by < 0 => {
                "predicts planes from the plane before their reference, as if planes were counted from 1"
            }
            Slip::FromNeighbor(..) => "predicts planes from the plane behind their reference",
            Slip::Overwrites => {
                "shows a predicted plane in place of the plane that it is predicted from"
            }
            _ => "does not displace references",
        }
    }

    /// What to do about it.
    pub const fn fix(self) -> &'static str {
        match self {
            Slip::Shifted(_) => {
                "add 128 to the samples of an inverse DCT, round to the nearest, and limit them to 0…255 (T.81 A.3.1)"
            }
            Slip::Sum(_) => "plane = (residual + predictor − 128) modulo 256",
            Slip::Inverse(_) => {
                "where the plane's own transform has bit 1, its predictor is 255 − the reference, everywhere"
            }
            Slip::ByReference { .. } | Slip::StaysInverted | Slip::TransformOfNeighbor(_) => {
                "use the transform of the predicted plane"
            }
            Slip::ByPlace(_) => {
                "the lists of 2.9 have one entry for each plane, by its number; the order says only which plane comes first"
            }
            Slip::FromPlaneBefore(_) | Slip::FromNeighbor(..) => {
                "planes are counted from 0: the number at place i of the reference list is the plane that plane i is predicted from"
            }
            Slip::IntraInverted | Slip::IntraPlus(_) => {
                "leave intra coded planes as their streams hold them"
            }
            Slip::NotMoved => {
                "where the plane's own transform has bit 2, displace the reference by the plane's own vector"
            }
            Slip::Vector(_) => {
                "take x and y of the plane's own vector as they stand in the two halves of the list"
            }
            Slip::Split(..) => {
                "by x and y alike: whole texels are the floor of half of it (v >> 1), and a half is left where it is odd (v & 1), below zero too"
            }
            Slip::Mean { .. } | Slip::HalfBefore { .. } => {
                "(a + b + 1) >> 1 of two samples, (a + b + c + d + 2) >> 2 of four, in more than eight bits"
            }
            Slip::Border { .. }
            | Slip::FirstWithin { .. }
            | Slip::WithinOther { .. }
            | Slip::WithinLess { .. } => {
                "clamp each column to 0 … width − 1 and each row to 0 … height − 1, for each sample of a mean by itself"
            }
            Slip::Order(_) => {
                "decode the plane of the lowest rank first; ranks are numbers, and planes of one rank are all decoded"
            }
            Slip::Records(_) => {
                "read every record of the plane: P3 P2 P1 P0, high byte first, is the place in the stored plane, row by row, and V takes the place of the value there"
            }
            Slip::Overwrites => "give each plane memory of its own",
        }
    }

    /// The clause that it violates.
    pub const fn clause(self) -> &'static str {
        match self {
            Slip::Shifted(_) => "2.9.8/3",
            Slip::Sum(_) | Slip::Overwrites => "2.9.5/4",
            Slip::Inverse(_) => "2.9.2/3",
            Slip::ByReference { .. }
            | Slip::ByPlace(List::Transforms)
            | Slip::StaysInverted
            | Slip::TransformOfNeighbor(_) => "2.9.2/1",
            Slip::FromPlaneBefore(_) | Slip::FromNeighbor(..) => "2.9.5/1",
            Slip::IntraInverted | Slip::IntraPlus(_) => "2.9.5/2",
            Slip::NotMoved => "2.9.2/4",
            Slip::ByPlace(List::Vectors)
            | Slip::Vector(
                Vector::Exchanged
                | Vector::Copied(_)
                | Vector::Earlier(..)
                | Vector::YFromTheTenth
                | Vector::FromEnd(_),
            ) => "2.9.3/1",
            Slip::Vector(_) | Slip::Split(..) => "2.9.3/2",
            Slip::Mean { .. } | Slip::HalfBefore { .. } => "2.9.3/5",
            Slip::Border { .. }
            | Slip::FirstWithin { .. }
            | Slip::WithinOther { .. }
            | Slip::WithinLess { .. } => "2.9.3/6",
            Slip::Order(_) => "2.9.4/2",
            Slip::Records(Records::Bytes(_)) => "2.9.8/5",
            Slip::Records(
                Records::ByColumns
                | Records::Transposed
                | Records::LowSigned
                | Records::LowSevenBits
                | Records::ByColumnsWithin
                | Records::HighByte255
                | Records::LaterFrom255
                | Records::RowsFromTop
                | Records::OneLater
                | Records::OneEarlier,
            ) => "2.9.8/6",
            Slip::Records(
                Records::Plus(_) | Records::Added | Records::Inverted | Records::FirstValue,
            ) => "2.9.8/8",
            Slip::Records(_) | Slip::ByPlace(List::Records) => "2.9.8/4",
        }
    }
}

impl PlaneSlip {
    /// Slips that show in other planes than in the one in which they are made, wherever that may be.
    pub fn of_other_planes() -> impl Iterator<Item = PlaneSlip> {
        let listed = (0..PLANES.len()).map(PlaneIs::Listed);
        let last = PLANES
            .iter()
            .position(|one| one.says == LAST)
            .map(PlaneIs::Listed);
        let pairs = (listed.clone()).filter_map(move |one| last.map(|last| vec![last, one]));
        let places = std::iter::once(Vec::new()).chain(listed.map(|one| vec![one]));
        places.chain(pairs).map(|planes| PlaneSlip {
            slip: Slip::Overwrites,
            place: Place {
                planes,
                sample: None,
            },
        })
    }

    /// What is done and where, as a sentence without its subject.
    pub fn says(&self) -> String {
        format!("{}{}", self.slip.says(), self.place.says())
    }
}

/// Which of the three choices of axes.
fn place(axes: [bool; 2]) -> usize {
    AXES.iter()
        .position(|&other| other == axes)
        .unwrap_or_default()
}

/// What lies along these axes.
fn lines(axes: [bool; 2]) -> &'static str {
    ["columns and rows", "columns", "rows"][place(axes)]
}

fn says_terms(residual: i8, predictor: i8, plus: u8) -> String {
    let mut terms: Vec<String> = Vec::new();
    for (many, name) in [(residual, "residual"), (predictor, "predictor")] {
        match (many, terms.is_empty()) {
            (0, _) => {}
            (1, true) => terms.push(name.to_owned()),
            (1, false) => terms.push(format!(" + {name}")),
            (_, true) => terms.push(format!("−{name}")),
            _ => terms.push(format!(" − {name}")),
        }
    }
    match plus {
        0 => {}
        1..128 => terms.push(format!(" + {plus}")),
        _ => terms.push(format!(" − {}", 256 - u32::from(plus))),
    }
    let terms = terms.concat();
    let what =
        format!("computes a plane as {terms} modulo 256, where residual + predictor − 128 belongs");
    match (residual, predictor, plus) {
        (1, 0, 0) => "does not predict: shows what the streams hold".to_owned(),
        (0, 1, 0) => "shows the predictor, without residual − 128".to_owned(),
        _ => what,
    }
}

impl Sum {
    fn says(self) -> String {
        let says = match self {
            Sum::Terms {
                residual,
                predictor,
                plus,
            } => return says_terms(residual, predictor, plus),
            Sum::Limited { below, above } => match (below, above) {
                (true, true) => {
                    "limits residual + predictor − 128 to 0…255, which is meant modulo 256"
                }
                (true, false) => {
                    "limits residual + predictor − 128 to 0 or more, which is meant modulo 256"
                }
                _ => "limits residual + predictor − 128 to 255 or less, which is meant modulo 256",
            },
            Sum::Modulo255 { below, above } => match (below, above) {
                (true, true) => {
                    "adds 255 to a plane's values below 0 and subtracts it from those above 255, where 256 belongs"
                }
                (true, false) => "adds 255 to a plane's values below 0, where 256 belongs",
                _ => "subtracts 255 from a plane's values above 255, where 256 belongs",
            },
            Sum::Remainder255 => {
                "takes residual + predictor − 128 modulo 255 (255 becomes 0), which is meant modulo 256"
            }
            Sum::Xor => {
                "takes residual XOR predictor, where residual + predictor − 128 modulo 256 belongs"
            }
            Sum::Absolute => {
                "takes residual + predictor − 128 without its sign where it is below 0"
            }
            Sum::ResidualLimited => "takes a residual of 0, which is −128, for −127",
        };
        says.to_owned()
    }
}

impl Inverse {
    fn says(self) -> String {
        match self {
            Inverse::From(0) => "inverts v to 256 − v in a byte, where 255 − v belongs".to_owned(),
            Inverse::From(top) => {
                format!("inverts v to {top} − v in a byte, where 255 − v belongs")
            }
            Inverse::NoneOf(kept) => {
                format!("inverts {kept} to {kept}, where {} belongs", 255 - kept)
            }
            Inverse::FromLargest => {
                "inverts v to the largest sample of the plane less v, where 255 − v belongs"
                    .to_owned()
            }
            Inverse::None => "does not invert references".to_owned(),
        }
    }
}

impl Vector {
    fn all() -> impl Iterator<Item = Vector> {
        let plain = [Vector::Exchanged, Vector::Absolute, Vector::Doubled];
        let some = AXES.into_iter().map(Vector::Negated);
        let without = [[true, false], [false, true]].map(Vector::Without);
        let earlier = [1, 2, 3, 6, 9].into_iter();
        let earlier = earlier.flat_map(|k| AXES.map(|axes| Vector::Earlier(k, axes)));
        let from_end = AXES.into_iter().map(Vector::FromEnd);
        let copied = [0, 1].map(Vector::Copied);
        let plain = plain.into_iter().chain([Vector::YFromTheTenth]);
        let limits = [4_i64, 8, 16, 32, 64, 128].into_iter();
        let limits = limits.flat_map(|most| [[-most, most - 1], [-most, most], [i64::MIN, most]]);
        let within = limits.flat_map(|limits| AXES.map(|axes| Vector::Within(limits, axes)));
        // Many explain the same: the widest first.
        let bits = (3..=31).rev().map(|bits| Vector::Bits(bits, [true, true]));
        let bits_of_one = [[true, false], [false, true]].into_iter();
        let bits_of_one = bits_of_one
            .flat_map(|axes| [16, 8, 7, 6, 5, 4].map(move |bits| Vector::Bits(bits, axes)));
        let halved = AXES.into_iter().map(Vector::Halved);
        (plain.chain(some).chain(without).chain(from_end))
            .chain(copied)
            .chain(halved)
            .chain(earlier.chain(within).chain(bits).chain(bits_of_one))
    }

    fn says(self) -> String {
        let parts = |axes: [bool; 2]| ["x and y", "x", "y"][place(axes)];
        match self {
            Vector::Exchanged => "takes x of a vector for y and y for x".to_owned(),
            Vector::Negated(axes) => {
                format!("takes {} of a vector with the other sign", parts(axes))
            }
            Vector::Without(axes) => format!("leaves out {} of a vector", parts(axes)),
            Vector::Copied(0) => "takes x of a vector for y too".to_owned(),
            Vector::Copied(_) => "takes y of a vector for x too".to_owned(),
            Vector::Absolute => "loses the sign of vectors".to_owned(),
            Vector::Doubled => "takes whole texels for half texels".to_owned(),
            Vector::Halved(axes) => format!(
                "halves {} of a vector once more than half texels ask for",
                parts(axes)
            ),
            Vector::Bits(bits, axes) => {
                format!("keeps {} of a vector in {bits} bits", parts(axes))
            }
            Vector::Within([i64::MIN, most], axes) => {
                format!("limits {} of a vector to {most} at the most", parts(axes))
            }
            Vector::Within([least, most], axes) => {
                format!("limits {} of a vector to −{} … {most}", parts(axes), -least)
            }
            Vector::YFromTheTenth => "takes y of the vectors from the tenth number of their lists on, also where there are eighteen planes".to_owned(),
            Vector::FromEnd(axes) => format!(
                "moves each plane by {} of the vector as far from the end of the list",
                parts(axes)
            ),
            Vector::Earlier(1, axes) => {
                format!("takes {} of the vector of the plane before", parts(axes))
            }
            Vector::Earlier(k, axes) => format!(
                "moves plane {k} + k by {} of the vector of plane k",
                parts(axes)
            ),
        }
    }
}

fn splits() -> impl Iterator<Item = Slip> {
    let wholes = [
        Whole::Floor,
        Whole::TowardZero,
        Whole::AwayFromZero,
        Whole::Exchanged,
        Whole::ExchangedTowardZero,
    ];
    let halves = [
        Half::Own,
        Half::None,
        Half::NotOfX,
        Half::NotOfY,
        Half::PositiveOnly,
        Half::OfX,
        Half::OfY,
        Half::Exchanged,
    ];
    let pairs = halves
        .into_iter()
        .flat_map(move |half| wholes.map(|whole| (whole, half)));
    let is_slip = |&(whole, half): &(Whole, Half)| (whole, half) != (Whole::Floor, Half::Own);
    pairs
        .filter(is_slip)
        .map(|(whole, half)| Slip::Split(whole, half))
}

fn says_split(whole: Whole, half: Half) -> String {
    let whole = match whole {
        Whole::Floor => "",
        Whole::TowardZero => "rounds half of a vector toward zero (−3/2 to −1)",
        Whole::AwayFromZero => "rounds half of a vector away from zero (3/2 to 2)",
        Whole::Exchanged => "takes the whole texels of x for y and those of y for x",
        Whole::ExchangedTowardZero => {
            "takes the whole texels of x for y and those of y for x, rounded toward zero (−3/2 to −1)"
        }
    };
    let half = match half {
        Half::Own => "",
        Half::None => "loses the halves of vectors",
        Half::NotOfX => "loses the half of x",
        Half::NotOfY => "loses the half of y",
        Half::PositiveOnly => "loses the half of negative odd vectors",
        Half::OfX => "takes the half of x for y too",
        Half::OfY => "takes the half of y for x too",
        Half::Exchanged => "takes the half of x for y and that of y for x",
    };
    match (whole.is_empty(), half.is_empty()) {
        (false, false) => format!("{whole}, and {half}"),
        _ => format!("{whole}{half}"),
    }
}

fn means() -> impl Iterator<Item = Slip> {
    let masks: [&[[bool; 3]]; 3] = [
        &[
            [true, true, true],
            [true, true, false],
            [true, false, false],
            [false, true, false],
            [false, false, true],
        ],
        &[
            [true, true, false],
            [true, false, false],
            [false, true, false],
        ],
        &[[false, false, true]],
    ];
    let of = move |(how, mean): (usize, &super::means::Mean)| {
        let masks = masks[mean.samples / 2];
        masks.iter().map(move |&of| Slip::Mean { how, of })
    };
    MEANS.iter().enumerate().flat_map(of)
}

/// The first column, the last, the first stored row, the last: all, and fewer and fewer of them.
const SIDES: [[bool; 4]; 9] = [
    [true, true, true, true],
    [true, true, false, false],
    [false, false, true, true],
    [true, false, true, false],
    [false, true, false, true],
    [true, false, false, false],
    [false, true, false, false],
    [false, false, true, false],
    [false, false, false, true],
];

fn borders() -> Vec<Slip> {
    let hows = [
        Border::Wrapped,
        Border::OneBefore,
        Border::OtherEnd,
        Border::NextRow,
        Border::Mirrored,
        Border::Reflected,
        Border::Value(0),
        Border::Value(255),
        Border::Value(128),
        Border::Value(127),
    ];
    let mut all = Vec::new();
    for reach in [Reach::Any, Reach::Near, Reach::Far] {
        for how in hows {
            let fits = |sides: &[bool; 4]| how != Border::NextRow || !sides[2] && !sides[3];
            let sides = SIDES.into_iter().filter(fits);
            all.extend(sides.map(|sides| Slip::Border { how, sides, reach }));
        }
    }
    all
}

fn says_border(how: Border, sides: [bool; 4], reach: Reach) -> String {
    let names = [
        "the first column",
        "the last column",
        "the first stored row",
        "the last stored row",
    ];
    let some: Vec<&str> = (0..4).filter(|&k| sides[k]).map(|k| names[k]).collect();
    let sides = match sides {
        [true, true, true, true] => "an edge".to_owned(),
        _ => some.join(" and "),
    };
    let far = match reach {
        Reach::Any => "beyond",
        Reach::Near => "one texel beyond",
        Reach::Far => "two texels or more beyond",
    };
    let how = match how {
        Border::Wrapped => "begins again at the other side".to_owned(),
        Border::OneBefore => "takes the sample one before the edge".to_owned(),
        Border::OtherEnd => "takes the sample at the other end".to_owned(),
        Border::NextRow => {
            "takes what is stored there, a sample of the next row or the row before".to_owned()
        }
        Border::Mirrored => "mirrors the plane at its edge, the edge twice".to_owned(),
        Border::Reflected => "mirrors the plane at its edge, the edge once".to_owned(),
        Border::Value(value) => format!("takes {value}"),
    };
    format!("{how} {far} {sides}, where the sample of the edge belongs")
}

impl Order {
    fn says(self) -> String {
        match self {
            Order::AsText => "sorts ranks as text (10 before 2): planes are predicted from planes that are not decoded yet, and hold 0".to_owned(),
            Order::SignedByte => "keeps ranks in a signed byte".to_owned(),
            Order::Unsorted(..) => "does not sort ranks to the end: planes are predicted from planes that are not decoded yet, and hold 0".to_owned(),
            Order::LastOfRank => "decodes one plane of each rank, the last, and shows 0 for the others".to_owned(),
            Order::IntraFirst(undecoded) => format!(
                "decodes the planes that are not predicted first, then the others by their numbers: what is not decoded yet {}",
                match undecoded {
                    Undecoded::Zeros => "holds 0",
                    Undecoded::Stream => "holds what its stream has",
                }
            ),
            Order::FirstOfRank => "decodes one plane of each rank, the first, and shows 0 for the others".to_owned(),
        }
    }
}

impl Records {
    fn all() -> Vec<Records> {
        let mut all = vec![
            Records::Ignored,
            Records::LastLost,
            Records::AtMost(1),
            Records::CountInByte,
            Records::Added,
            Records::Inverted,
            Records::FirstValue,
            Records::OfPlaneBefore,
            Records::SingleOfPlaneBefore,
            Records::ByColumns,
            Records::Transposed,
            Records::ByColumnsWithin,
            Records::LowSigned,
            Records::LowSevenBits,
            Records::UntilZero,
            Records::HighByte255,
            Records::LaterFrom255,
            Records::RowsFromTop,
            Records::OneLater,
            Records::OneEarlier,
        ];
        all.extend([1, 255].map(Records::Plus));
        let most = [2, 3, 4, 5, 8, 10, 16, 32, 50, 51, 64, 100, 128, 255, 256];
        all.extend(most.map(Records::AtMost));
        let each = |from: u8| (0..4).map(move |byte| (from, byte));
        // One byte lost; the low ones alone; two exchanged; the other order.
        let orders =
            (0..4).map(|lost| std::array::from_fn(|k| if k == lost { 4 } else { k as u8 }));
        let low = (2..4).map(|first| std::array::from_fn(|k| if k < first { 4 } else { k as u8 }));
        let exchanged = (0..4).flat_map(each).filter(|(a, b)| a < b).map(|(a, b)| {
            let mut order = [0, 1, 2, 3];
            order.swap(usize::from(a), usize::from(b));
            order
        });
        let others = [[3, 2, 1, 0], [1, 0, 3, 2], [2, 3, 0, 1]];
        // One byte twice, in the place of another.
        let twice = (0..4)
            .flat_map(each)
            .filter(|(from, at)| from != at)
            .map(|(from, at)| {
                let mut order = [0, 1, 2, 3];
                order[usize::from(at)] = from;
                order
            });
        let orders = orders
            .chain(twice)
            .chain(low)
            .chain(exchanged)
            .chain(others);
        all.extend(orders.map(Records::Bytes));
        all
    }

    fn says(self) -> String {
        match self {
            Records::Ignored => "ignores records of side information".to_owned(),
            Records::LastLost => "loses the last record of a plane that has two or more".to_owned(),
            Records::AtMost(1) => "reads only one record for each plane".to_owned(),
            Records::CountInByte => "keeps the number of a plane's records in a byte".to_owned(),
            Records::Plus(1) => "puts V + 1 where a record says V".to_owned(),
            Records::Plus(255) => "puts V − 1 where a record says V".to_owned(),
            Records::Plus(more) => format!("puts V + {more}, modulo 256, where a record says V"),
            Records::Added => "adds the value of a record to what was decoded".to_owned(),
            Records::Inverted => "puts 255 − V where a record says V, in planes whose reference is inverted".to_owned(),
            Records::FirstValue => "takes the value of a plane's first record for all of them".to_owned(),
            Records::Bytes(order) => {
                let byte = |from: u8| match from {
                    4 => "0".to_owned(),
                    _ => format!("P{}", 3 - from),
                };
                let names: Vec<String> = order.into_iter().map(byte).collect();
                format!("reads the position of a record as {}, where P3 P2 P1 P0 belongs", names.join(" "))
            }
            Records::OfPlaneBefore => "corrects a plane without records with those of a plane before".to_owned(),
            Records::SingleOfPlaneBefore => {
                "corrects a plane without records with the record of a plane before, where that has a single one".to_owned()
            }
            Records::ByColumns => "counts the positions of records down the columns".to_owned(),
            Records::Transposed => "corrects the sample at column · height + row, where row · width + column belongs".to_owned(),
            Records::LowSigned => "takes P0 of a position for a signed byte".to_owned(),
            Records::LowSevenBits => "loses the highest bit of P0 of a position".to_owned(),
            Records::AtMost(most) => format!("reads {most} records of a plane at the most"),
            Records::UntilZero => "ends the records of a plane before the first whose position is 0".to_owned(),
            Records::ByColumnsWithin => "counts the positions of records down the columns, and takes the last texel for those beyond it".to_owned(),
            Records::HighByte255 => "counts P1 of a position 255 times, where 256 belongs".to_owned(),
            Records::LaterFrom255 => "counts the positions of records one too high, from 255 on".to_owned(),
            Records::RowsFromTop => "counts the positions of records from the other end of the rows".to_owned(),
            Records::OneLater => "counts the positions of records one too high".to_owned(),
            Records::OneEarlier => "counts the positions of records one too low".to_owned(),
        }
    }
}
