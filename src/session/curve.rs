//! One function over all values of all pictures: a factor, or the curve of a picture library.

use crate::protocol::frame::{Frame, Samples, ViewKind};
use crate::suite::compare::Expected;

/// What is expected, and what came.
type Pairs<'a> = [(&'a Expected, &'a Frame)];

/// A curve over bytes.
#[derive(Clone, Debug)]
pub(super) struct Curve {
    /// What it does to all pictures.
    pub(super) says: String,
    /// What to do about it.
    pub(super) next: &'static str,
    /// What becomes of each right value.
    table: Vec<f64>,
    /// How far a right value may be from the reference's: colors may be rounded in any way.
    slack: u8,
}

/// Curves by name: what becomes of a value from 0 to 1.
const NAMED: [(&str, fn(f64) -> f64); 8] = [
    ("the curve of sRGB is over all values", |v| {
        match v <= 0.003_130_8 {
            true => 12.92 * v,
            false => 1.055 * v.powf(1.0 / 2.4) - 0.055,
        }
    }),
    ("the curve of sRGB is taken off all values", |v| {
        match v <= 0.040_45 {
            true => v / 12.92,
            false => ((v + 0.055) / 1.055).powf(2.4),
        }
    }),
    ("a gamma of 1/2.2 is over all values", |v| v.powf(1.0 / 2.2)),
    ("a gamma of 2.2 is over all values", |v| v.powf(2.2)),
    ("a gamma of 1/1.8 is over all values", |v| v.powf(1.0 / 1.8)),
    ("values run from 16 to 235, as in video", |v| {
        (16.0 + 219.0 * v) / 255.0
    }),
    ("values from 16 to 235 are stretched, as of video", |v| {
        (255.0 * v - 16.0) / 219.0
    }),
    ("each value is 255 minus the right one", |v| 1.0 - v),
];

const NO_CURVE: &str =
    "a color is a linear number from 0 to 255: no gamma, no color management, no auto-contrast";

impl Curve {
    /// Curves that these pictures may be under: of colors those with a name, and the one that they follow.
    pub(super) fn candidates(view: ViewKind, pairs: &Pairs) -> Vec<Curve> {
        let points = points(pairs);
        let slack = u8::from(view == ViewKind::Rgb);
        let mut curves = Vec::new();
        if let Some(factor) = slope(&points) {
            curves.push(Curve {
                says: scale_in_words(factor),
                next: "send the values as they are, from 0 to 255",
                table: (0..256).map(|v| f64::from(v) * factor).collect(),
                slack,
            });
        }
        if view != ViewKind::Rgb {
            return curves;
        }
        curves.extend(NAMED.into_iter().map(|(says, curve)| {
            Curve {
                says: says.to_owned(),
                next: NO_CURVE,
                table: (0..256)
                    .map(|v| 255.0 * curve(f64::from(v) / 255.0))
                    .collect(),
                slack,
            }
        }));
        curves.extend(followed(points));
        curves
    }

    /// The values before the curve: the right ones where they explain what came.
    pub(super) fn undo(&self, frame: &Frame, right: Option<&Frame>) -> Frame {
        let Samples::U8(bytes) = &frame.samples else {
            return frame.clone();
        };
        let expected = right.and_then(|right| match &right.samples {
            Samples::U8(right) if right.len() == bytes.len() => Some(right),
            _ => None,
        });
        let nearest: Vec<u8> = (0..=255).map(|byte| self.before(byte)).collect();
        let undone = bytes.iter().enumerate().map(|(i, &byte)| {
            let right = expected.map(|right| right[i]);
            let explains = |right: &u8| self.explains(*right, byte);
            right.filter(explains).unwrap_or(nearest[usize::from(byte)])
        });
        Frame {
            samples: Samples::U8(undone.collect()),
            ..frame.clone()
        }
    }

    /// Whether a right value, or one as good, becomes this one.
    fn explains(&self, right: u8, received: u8) -> bool {
        let near = right.saturating_sub(self.slack)..=right.saturating_add(self.slack);
        let values = near.map(|v| self.table[usize::from(v)].clamp(0.0, 255.0));
        let (least, most) = values.fold((256.0, -1.0), |(least, most): (f64, f64), value| {
            (least.min(value), most.max(value))
        });
        (least - 1.0..=most + 1.0).contains(&f64::from(received))
    }

    /// The value that comes nearest to becoming this one.
    fn before(&self, received: u8) -> u8 {
        let off = |v: &u8| (self.table[usize::from(*v)] - f64::from(received)).abs();
        let nearest = (0..=255).min_by(|a, b| off(a).total_cmp(&off(b)));
        nearest.expect("there are 256 values")
    }
}

/// Expected and received values, one beside the other; none where a picture has another shape.
fn points(pairs: &Pairs) -> Vec<(f64, f64)> {
    let mut points = Vec::new();
    for (expected, frame) in pairs {
        let Samples::U8(received) = &frame.samples else {
            continue;
        };
        if expected.values.len() == received.len() {
            let values = expected.values.iter().copied();
            points.extend(values.zip(received.iter().copied().map(f64::from)));
        }
    }
    points
}

/// The factor between what was expected and what came, by least squares, where it is far enough from 1 to matter. Values at
/// the ends of the range tell nothing of it.
fn slope(points: &[(f64, f64)]) -> Option<f64> {
    let told = points
        .iter()
        .filter(|&&(_, received)| received > 0.0 && received < 255.0);
    let (sum, square) = told.fold((0.0, 0.0), |(sum, square), (expected, received)| {
        (sum + expected * received, square + expected * expected)
    });
    let factor = sum / square;
    (factor.is_finite() && factor > 0.0 && (factor - 1.0).abs() >= 0.02).then_some(factor)
}

fn scale_in_words(factor: f64) -> String {
    match factor < 1.0 {
        true => format!("all values are divided by about {:.3}", 1.0 / factor),
        false => format!("all values are multiplied by about {factor:.3}"),
    }
}

/// The factor between real values, and what to say of it.
pub(super) fn factor(pairs: &Pairs) -> Option<(f64, String)> {
    let (mut sum, mut square) = (0.0, 0.0);
    for (expected, frame) in pairs {
        let Samples::F32(received) = &frame.samples else {
            return None;
        };
        for (value, &received) in expected.values.iter().zip(received) {
            sum += value * f64::from(received);
            square += value * value;
        }
    }
    let factor = sum / square;
    let is_known = factor.is_finite() && factor > 0.0 && (factor - 1.0).abs() >= 1e-3;
    is_known.then(|| (factor, scale_in_words(factor)))
}

/// The monotone curve that all colors follow, whatever it is: nothing where they follow none, or too few tell.
fn followed(mut points: Vec<(f64, f64)>) -> Option<Curve> {
    const FEW: usize = 24;
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let steps = rising_steps(&points);
    let is_inner = |value: f64| value > 1.0 && value < 254.0;
    let inner = steps.iter().filter(|step| is_inner(step.1)).count();
    let off = points.iter().filter(|(e, r)| (e - r).abs() > 4.0).count();
    if inner < FEW || 4 * off < points.len() {
        return None;
    }
    let table: Vec<f64> = (0..256).map(|v| between(&steps, f64::from(v))).collect();
    let shown = [32, 64, 128, 192].map(|v: usize| format!("{v} → {:.0}", table[v]));
    Some(Curve {
        says: format!("one curve is over all values: {}", shown.join(", ")),
        next: NO_CURVE,
        table,
        slack: 1,
    })
}

/// The rising steps that come nearest to points in order of their first number: neighbors that fall are one step, at their
/// mean.
fn rising_steps(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    // Sums of both numbers, and how many.
    let mut steps: Vec<(f64, f64, f64)> = Vec::new();
    for &(at, value) in points {
        let mut step = (at, value, 1.0);
        while let Some(last) = steps.pop_if(|last| last.1 / last.2 >= step.1 / step.2) {
            step = (step.0 + last.0, step.1 + last.1, step.2 + last.2);
        }
        steps.push(step);
    }
    let means = steps
        .iter()
        .map(|(at, value, count)| (at / count, value / count));
    means.collect()
}

/// What steps say of a place between two of them.
fn between(steps: &[(f64, f64)], at: f64) -> f64 {
    let next = steps.partition_point(|step| step.0 < at);
    match (next.checked_sub(1).map(|last| steps[last]), steps.get(next)) {
        (Some(low), Some(high)) => low.1 + (high.1 - low.1) * (at - low.0) / (high.0 - low.0),
        (Some(end), None) => end.1,
        (None, Some(end)) => end.1,
        (None, None) => at,
    }
}
