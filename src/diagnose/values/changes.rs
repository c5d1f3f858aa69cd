//! What may be done to a single value: each of these is a function of the right value alone.

use crate::suite::compare::{self, is_close};

/// What is done to each value.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::diagnose) enum Change {
    /// One value for all.
    Constant(f64),
    /// So much more, around the circle of 256 values where these are bytes.
    Offset(f64),
    /// So much more, but never past 0 or 255.
    OffsetClamped(f64),
    Factor(f64),
    /// A factor, and then an offset.
    Line(f64, f64),
    /// These bits are changed.
    Xor(u8),
    /// Only these bits are kept.
    And(u8),
    /// These bits are set.
    Or(u8),
    ReversedBits,
    SwappedNibbles,
    AtMost(f64),
    AtLeast(f64),
    /// Never below the first and never above the second.
    Within(f64, f64),
    /// 255 less the value.
    Inverted,
    Absolute,
    Truncated,
    Floored,
    Rounded,
    /// To eleven significant bits.
    HalfPrecision,
    /// Bytes over 127 count from −128.
    Signed,
    /// Modulo 256.
    Wrapped,
    /// 255 · (value / 255) to this power.
    Power(f64),
    SrgbEncoded,
    SrgbDecoded,
    /// Single values are others, all the rest is right.
    Points(Vec<(u8, u8)>),
    /// Some table, as far as it is known.
    Table(Vec<Option<u8>>),
}

/// Powers that picture libraries apply.
const POWERS: [f64; 8] = [2.2, 1.0 / 2.2, 1.8, 1.0 / 1.8, 2.4, 1.0 / 2.4, 2.0, 0.5];

/// One value that becomes another so often, and never stays, is changed by itself.
const OFTEN: usize = 2;

/// How values of a view are compared and computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::diagnose) enum Values {
    /// Stored bytes.
    Bytes,
    /// Final values.
    Reals,
    /// Colors under a light, rounded anyhow.
    Colors,
}

impl Values {
    fn near(self, a: f64, b: f64) -> bool {
        match self {
            Values::Bytes => a == b,
            Values::Reals => is_close(a, b, 0.0),
            Values::Colors => (a - b).abs() <= 1.0,
        }
    }
}

impl Change {
    /// What becomes of `value`; of a byte another byte.
    pub fn apply(&self, value: f64, of: Values) -> f64 {
        let bits =
            |change: &dyn Fn(u8) -> u8| f64::from(change(value.round().clamp(0.0, 255.0) as u8));
        let changed = match self {
            Change::Constant(constant) => *constant,
            Change::Offset(offset) => match of {
                Values::Reals => value + offset,
                _ => (value + offset).rem_euclid(256.0),
            },
            Change::OffsetClamped(offset) => (value + offset).clamp(0.0, 255.0),
            Change::Factor(factor) => value * factor,
            Change::Line(factor, offset) => value * factor + offset,
            Change::Xor(mask) => bits(&|value| value ^ mask),
            Change::And(mask) => bits(&|value| value & mask),
            Change::Or(mask) => bits(&|value| value | mask),
            Change::ReversedBits => bits(&u8::reverse_bits),
            Change::SwappedNibbles => bits(&|value| value.rotate_left(4)),
            Change::AtMost(most) => value.min(*most),
            Change::AtLeast(least) => value.max(*least),
            Change::Within(least, most) => value.max(*least).min(*most),
            Change::Inverted => 255.0 - value,
            Change::Absolute => value.abs(),
            Change::Truncated => value.trunc(),
            Change::Floored => value.floor(),
            Change::Rounded => value.round(),
            Change::HalfPrecision => half(value),
            Change::Signed if value > 127.0 => value - 256.0,
            Change::Signed => value,
            Change::Wrapped => value.rem_euclid(256.0),
            Change::Power(power) => 255.0 * (value.max(0.0) / 255.0).powf(*power),
            Change::SrgbEncoded => 255.0 * srgb_encoded(value / 255.0),
            Change::SrgbDecoded => 255.0 * srgb_decoded(value / 255.0),
            Change::Points(points) => {
                let point = points.iter().find(|(from, _)| f64::from(*from) == value);
                point.map_or(value, |(_, to)| f64::from(*to))
            }
            Change::Table(table) => {
                let entry = table.get(value as usize).copied().flatten();
                entry.map_or(value, f64::from)
            }
        };
        match of {
            Values::Reals => changed,
            Values::Bytes => changed.floor().clamp(0.0, 255.0),
            Values::Colors => changed.clamp(0.0, 255.0),
        }
    }

    /// Whether it makes the second of each pair of the first.
    pub fn fits(&self, pairs: &[(f64, f64)], of: Values) -> bool {
        pairs
            .iter()
            .all(|&(right, got)| of.near(self.apply(right, of), got))
    }

    /// All changes that make the second of each pair of the first. Pairs of values that are right are among them.
    pub fn fitting(pairs: &[(f64, f64)], of: Values) -> Vec<Change> {
        let wrong: Vec<(f64, f64)> = pairs
            .iter()
            .copied()
            .filter(|&(right, got)| !of.near(right, got))
            .collect();
        // One or two wrong values, or those of one right value, are off by the same whatever the reason.
        let Some(&first) = wrong.first() else {
            return Vec::new();
        };
        let is_one = wrong.iter().all(|pair| pair.0 == first.0);
        if is_one && of == Values::Bytes && wrong.len() >= OFTEN {
            return points(pairs).into_iter().collect();
        }
        if wrong.len() < 3 || is_one {
            return Vec::new();
        }
        let mut changes = match of {
            Values::Bytes => of_bytes(pairs, &wrong),
            Values::Reals => of_reals(pairs, &wrong),
            Values::Colors => of_colors(pairs, &wrong),
        };
        changes.retain(|change| change.fits(pairs, of));
        if changes.is_empty() && of == Values::Bytes {
            changes.extend(points(pairs).or_else(|| table(pairs)));
        }
        changes
    }

    /// As a sentence without its subject and its object: "128 more than they should be".
    pub fn says(&self, of: Values) -> String {
        let more = |offset: f64| match offset < 0.0 {
            true => format!("{} less", short(-offset)),
            false => format!("{} more", short(offset)),
        };
        match self {
            Change::Constant(constant) => format!("{} instead of the right value", short(*constant)),
            Change::Offset(offset) if of == Values::Bytes && *offset == 128.0 => {
                "values with their highest bit changed, 128 more or less than they should be".to_owned()
            }
            Change::Offset(offset) => format!(
                "values that are {} than they should be{}",
                more(if of == Values::Bytes && *offset > 128.0 { offset - 256.0 } else { *offset }),
                if of == Values::Reals { "" } else { " (modulo 256)" }
            ),
            Change::OffsetClamped(offset) => format!(
                "values that are {} than they should be, at most 255 and at least 0",
                more(*offset)
            ),
            Change::Factor(factor) => {
                format!("values that are {} times what they should be", short(*factor))
            }
            Change::Line(factor, offset) => format!(
                "values that are {} times the right ones and {}",
                short(*factor),
                more(*offset)
            ),
            Change::Xor(mask) => format!("values with {} changed", bits(*mask)),
            Change::And(mask) => format!("values without {}", bits(!mask)),
            Change::Or(mask) => format!("values with {} always set", bits(*mask)),
            Change::ReversedBits => "values with their bits in reverse order".to_owned(),
            Change::SwappedNibbles => "values with their two halves of four bits exchanged".to_owned(),
            Change::AtMost(most) => format!("values of at most {}: larger ones are cut off", short(*most)),
            Change::AtLeast(least) => {
                format!("values of at least {}: smaller ones are raised", short(*least))
            }
            Change::Within(least, most) => format!(
                "values from {} to {}: those beyond are taken to these limits",
                short(*least),
                short(*most)
            ),
            Change::Inverted => "values inverted (255 less the right ones)".to_owned(),
            Change::Absolute => "values without their sign".to_owned(),
            Change::Truncated => "values whose fractions are cut off (towards zero)".to_owned(),
            Change::Floored => "values rounded down to whole numbers".to_owned(),
            Change::Rounded => "values rounded to whole numbers".to_owned(),
            Change::HalfPrecision => "values in half precision, eleven significant bits and at most 65504".to_owned(),
            Change::Signed => "bytes over 127 as negative numbers, 256 less than they should be".to_owned(),
            Change::Wrapped => "values modulo 256".to_owned(),
            Change::Power(power) => format!(
                "one monotone curve over all values, 255 · (value / 255) to the power of {}",
                short(*power)
            ),
            Change::SrgbEncoded => "one monotone curve over all values, that of sRGB: linear values are encoded".to_owned(),
            Change::SrgbDecoded => "one monotone curve over all values, the inverse of that of sRGB: values are made linear".to_owned(),
            Change::Points(points) => says_points(points),
            Change::Table(table) => says_table(table),
        }
    }
}

/// "0 for 255, and every other value right".
fn says_points(points: &[(u8, u8)]) -> String {
    let points = points.iter().take(4);
    let points: Vec<String> = points
        .map(|(from, to)| format!("{to} for {from}"))
        .collect();
    format!("{}, and every other value right", points.join(", "))
}

/// Some entries of a table, and whether it is a monotone curve.
fn says_table(table: &[Option<u8>]) -> String {
    let known: Vec<(usize, u8)> = table
        .iter()
        .enumerate()
        .filter_map(|(from, to)| Some((from, (*to)?)))
        .collect();
    let step = (known.len() / 5).max(1);
    let some: Vec<String> = known
        .iter()
        .step_by(step)
        .map(|(from, to)| format!("{to} for {from}"))
        .collect();
    let curve = match known.windows(2).all(|two| two[0].1 <= two[1].1) {
        true => "one monotone curve over all values",
        false => "another value for each value, always the same",
    };
    format!("{curve}: {}", some.join(", "))
}

/// "the lowest bit", "bits 0 and 3", "the highest four bits".
fn bits(mask: u8) -> String {
    match mask {
        0x01 => "their lowest bit".to_owned(),
        0x80 => "their highest bit".to_owned(),
        0x0f => "their lower four bits".to_owned(),
        0xf0 => "their upper four bits".to_owned(),
        _ => {
            let set: Vec<String> = (0..8)
                .filter(|bit| mask >> bit & 1 == 1)
                .map(|bit| bit.to_string())
                .collect();
            format!("bits {} of each", set.join(", "))
        }
    }
}

fn of_bytes(pairs: &[(f64, f64)], wrong: &[(f64, f64)]) -> Vec<Change> {
    let first = wrong[0];
    let offset = (first.1 - first.0).rem_euclid(256.0);
    let byte = |value: f64| value as u8;
    let over = |from: u8, step: &dyn Fn(u8, u8, u8) -> u8| {
        let fold = |mask: u8, &(right, got): &(f64, f64)| step(mask, byte(right), byte(got));
        pairs.iter().fold(from, fold)
    };
    // Bits that are ever lost, and bits that are ever gained.
    let lost = over(0, &|mask, right, got| mask | right & !got);
    let gained = over(0, &|mask, right, got| mask | !right & got);
    let most = pairs.iter().map(|pair| pair.1).fold(f64::MIN, f64::max);
    let least = pairs.iter().map(|pair| pair.1).fold(f64::MAX, f64::min);
    let mut changes = vec![
        Change::Constant(first.1),
        Change::Offset(offset),
        Change::Inverted,
        Change::ReversedBits,
        Change::SwappedNibbles,
    ];
    let mask = byte(first.0) ^ byte(first.1);
    // All eight bits changed are the same as inverted.
    if mask != 0xff {
        changes.push(Change::Xor(mask));
    }
    if lost != 0 {
        changes.push(Change::And(!lost));
    }
    if gained != 0 {
        changes.push(Change::Or(gained));
    }
    changes.extend([Change::AtMost(most), Change::AtLeast(least)]);
    // A clamped offset shows where nothing is clamped.
    let free = wrong.iter().find(|pair| pair.1 > 0.0 && pair.1 < 255.0);
    changes.extend(free.map(|pair| Change::OffsetClamped(pair.1 - pair.0)));
    let factors = [
        2.0,
        0.5,
        0.25,
        4.0,
        255.0 / 256.0,
        256.0 / 255.0,
        0.75,
        1.5,
        100.0 / 255.0,
    ];
    changes.extend(factors.map(Change::Factor));
    changes.extend(POWERS.map(Change::Power));
    changes.extend([Change::SrgbEncoded, Change::SrgbDecoded]);
    changes
}

fn of_reals(pairs: &[(f64, f64)], wrong: &[(f64, f64)]) -> Vec<Change> {
    let first = wrong[0];
    let most = pairs.iter().map(|pair| pair.1).fold(f64::MIN, f64::max);
    let least = pairs.iter().map(|pair| pair.1).fold(f64::MAX, f64::min);
    let mut changes = vec![
        Change::Constant(first.1),
        Change::Offset(first.1 - first.0),
        Change::Truncated,
        Change::Floored,
        Change::Rounded,
        Change::Absolute,
        Change::Signed,
        Change::Wrapped,
        Change::AtMost(most),
        Change::AtLeast(least),
        Change::Within(least, most),
        Change::HalfPrecision,
        Change::Inverted,
    ];
    if first.0 != 0.0 && first.1 != 0.0 {
        changes.push(Change::Factor(first.1 / first.0));
    }
    let other = wrong.iter().find(|pair| (pair.0 - first.0).abs() > 1e-6);
    if let Some(&(right, got)) = other {
        let factor = (got - first.1) / (right - first.0);
        changes.push(Change::Line(factor, first.1 - factor * first.0));
    }
    changes
}

fn of_colors(pairs: &[(f64, f64)], wrong: &[(f64, f64)]) -> Vec<Change> {
    let most = pairs.iter().map(|pair| pair.1).fold(f64::MIN, f64::max);
    let least = pairs.iter().map(|pair| pair.1).fold(f64::MAX, f64::min);
    let mut changes = vec![
        Change::Constant(wrong[0].1),
        Change::Inverted,
        Change::SrgbEncoded,
        Change::SrgbDecoded,
        Change::AtMost(most),
        Change::AtLeast(least),
        Change::And(0xfc),
        Change::And(0xf8),
        Change::And(0xf0),
        Change::And(0x7f),
    ];
    changes.extend(POWERS.map(Change::Power));
    // What is limited to 0 or 255 may have been anything.
    if wrong.iter().all(|pair| pair.1 <= 0.0 || pair.1 >= 255.0) {
        changes.retain(|change| matches!(change, Change::Constant(_)));
    }
    // From the two right values that are farthest from each other, where nothing is clamped.
    let free = || {
        let inside = |pair: &&(f64, f64)| pair.1 > 0.0 && pair.1 < 255.0;
        pairs.iter().filter(inside)
    };
    let low = free().min_by(|a, b| a.0.total_cmp(&b.0));
    let high = free().max_by(|a, b| a.0.total_cmp(&b.0));
    if let (Some(low), Some(high)) = (low, high)
        && high.0 - low.0 > 64.0
    {
        let factor = (high.1 - low.1) / (high.0 - low.0);
        for known in color_factors() {
            if (factor - known).abs() < 0.02 {
                changes.push(Change::Factor(known));
            }
        }
        let offset = (low.1 - low.0).round();
        changes.push(Change::OffsetClamped(offset));
    }
    changes
}

/// What one of two numbers for the largest color, or for their count, is times another.
fn color_factors() -> impl Iterator<Item = f64> {
    let numbers = [
        255.0, 256.0, 250.0, 254.0, 240.0, 200.0, 128.0, 127.0, 100.0,
    ];
    let pairs = numbers
        .into_iter()
        .flat_map(move |a| numbers.map(|b| a / b));
    let plain = [2.0, 0.5, 1.0 / 255.0];
    plain
        .into_iter()
        .chain(pairs.filter(|&factor| factor != 1.0))
}

/// A few right values that become others, where all the rest is right.
fn points(pairs: &[(f64, f64)]) -> Option<Change> {
    let table = known_table(pairs)?;
    let points: Vec<(u8, u8)> = table
        .iter()
        .enumerate()
        .filter_map(|(from, to)| Some((from as u8, to.filter(|&to| usize::from(to) != from)?)))
        .collect();
    let known = table.iter().flatten().count();
    (points.len() <= 4 && known > points.len() * 4).then_some(Change::Points(points))
}

/// A table, if values that occur twice always become the same.
fn table(pairs: &[(f64, f64)]) -> Option<Change> {
    let table = known_table(pairs)?;
    let known = table.iter().flatten().count();
    (known >= 8 && pairs.len() >= known + 12).then_some(Change::Table(table))
}

fn known_table(pairs: &[(f64, f64)]) -> Option<Vec<Option<u8>>> {
    let mut table: Vec<Option<u8>> = vec![None; 256];
    for &(right, got) in pairs {
        let entry = &mut table[right as usize];
        if entry.is_some_and(|known| f64::from(known) != got) {
            return None;
        }
        *entry = Some(got as u8);
    }
    Some(table)
}

/// What two tables say together, unless they contradict each other.
pub(in crate::diagnose) fn merged(a: &[Option<u8>], b: &[Option<u8>]) -> Option<Vec<Option<u8>>> {
    let pairs = a.iter().zip(b);
    pairs
        .map(|(a, b)| match (a, b) {
            (Some(a), Some(b)) if a != b => None,
            _ => Some(a.or(*b)),
        })
        .collect()
}

fn srgb_encoded(x: f64) -> f64 {
    if x <= 0.003_130_8 {
        12.92 * x
    } else {
        1.055 * x.powf(1.0 / 2.4) - 0.055
    }
}

fn srgb_decoded(x: f64) -> f64 {
    if x <= 0.040_45 {
        x / 12.92
    } else {
        ((x + 0.055) / 1.055).powf(2.4)
    }
}

/// The nearest number of half precision: eleven significant bits, steps of 2⁻²⁴ at the least, and infinity over 65504.
pub(in crate::diagnose) fn half(value: f64) -> f64 {
    if value == 0.0 {
        return 0.0;
    }
    let exponent = value.abs().log2().floor().max(-14.0);
    let unit = exponent.exp2() / 1024.0;
    let nearest = (value / unit).round_ties_even() * unit;
    match nearest.abs() > 65504.0 {
        true => f64::INFINITY.copysign(value),
        false => nearest,
    }
}

/// A number with at most four decimals.
pub(in crate::diagnose) fn short(value: f64) -> String {
    compare::short(value, 4)
}

#[cfg(test)]
mod tests {
    use super::{Change, Values, half};

    fn told(of: Values, change: fn(f64) -> f64, right: &[f64]) -> Vec<Change> {
        let pairs: Vec<(f64, f64)> = right.iter().map(|&right| (right, change(right))).collect();
        Change::fitting(&pairs, of)
    }

    #[test]
    fn half_precision_has_eleven_bits_a_largest_number_and_a_smallest_step() {
        assert_eq!(half(0.1), 0.099_975_585_937_5);
        assert_eq!(half(-2049.0), -2048.0);
        assert_eq!(half(65_519.0), 65_504.0);
        assert_eq!(half(-70_000.0), f64::NEG_INFINITY);
        assert_eq!(half(2f64.powi(-25)), 0.0);
        assert_eq!(half(3.0 * 2f64.powi(-25)), 2f64.powi(-23));
    }

    #[test]
    fn limits_on_both_sides_and_half_precision_are_told() {
        let right = [-70_000.5, -40_000.0, -3.25, 0.0, 8.5, 40_000.0, 90_000.0];
        let limited = told(
            Values::Reals,
            |value| value.clamp(-32768.0, 32767.0),
            &right,
        );
        assert!(limited.contains(&Change::Within(-32768.0, 32767.0)));
        let right = [0.1, 0.2, 0.3, 1000.7, -4097.9];
        assert!(told(Values::Reals, half, &right).contains(&Change::HalfPrecision));
    }

    #[test]
    fn one_value_that_always_becomes_another_is_told_where_it_is_seen_twice() {
        let change = |value: f64| if value == 255.0 { 254.0 } else { value };
        let right = [255.0, 0.0, 3.0, 7.0, 255.0, 9.0, 200.0];
        let points = vec![(255, 254)];
        assert_eq!(
            told(Values::Bytes, change, &right),
            [Change::Points(points)]
        );
        assert_eq!(told(Values::Bytes, change, &right[..4]), []);
    }
}
