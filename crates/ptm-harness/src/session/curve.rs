//! Tone curves. A tone curve is one function that is applied to all values of all images.

use ptm_suite::compare::Expected;
use ptm_suite::protocol::frame::{Frame, Samples, ViewKind};

/// A curve for bytes, or a factor for real numbers.
#[derive(Clone, Debug)]
pub(super) struct Curve {
    /// Result of the curve for each correct byte.
    table: Vec<f64>,
    /// Tolerance for the correct byte, because colors may be rounded in any way.
    slack: u8,
}

/// A curve with a description of its effect and the suggested fix.
type Candidate = ((String, String), Curve);

/// Returns the names of all curves and their results for a value from 0 to 1.
fn curves(v: f64) -> [(&'static str, f64); 8] {
    let srgb = match v <= 0.003_130_8 {
        true => 12.92 * v,
        false => 1.055 * v.powf(1.0 / 2.4) - 0.055,
    };
    let linear = match v <= 0.040_45 {
        true => v / 12.92,
        false => ((v + 0.055) / 1.055).powf(2.4),
    };
    let [dark, light, lighter] = [2.2, 1.0 / 2.2, 1.0 / 1.8].map(|gamma| v.powf(gamma));
    let (limited, full) = ((16.0 + 219.0 * v) / 255.0, (255.0 * v - 16.0) / 219.0);
    let stretched = "the range 16 to 235 is stretched to 0 to 255, as in video";
    [
        ("the sRGB curve is applied to all values", srgb),
        ("the sRGB curve is removed from all values", linear),
        ("a gamma of 1/2.2 is applied to all values", light),
        ("a gamma of 2.2 is applied to all values", dark),
        ("a gamma of 1/1.8 is applied to all values", lighter),
        ("values run from 16 to 235, as in video", limited),
        (stretched, full),
        ("each value is 255 minus the correct one", 1.0 - v),
    ]
}

const NO_CURVE: &str = "write colors as linear numbers from 0 to 255, without gamma, color management or auto-contrast";

fn candidate(says: &str, next: &str, slack: u8, curve: impl Fn(f64) -> f64) -> Candidate {
    let table = (0..256).map(|v| curve(f64::from(v))).collect();
    ((says.to_owned(), next.to_owned()), Curve { table, slack })
}

/// Returns the candidate curves for these images: a factor and, for colors, the named curves and a fitted curve.
pub(super) fn candidates(view: ViewKind, pairs: &[(&Expected, &Frame)]) -> Vec<Candidate> {
    let mut points: Vec<(f64, f64)> = Vec::new();
    for (expected, frame) in pairs {
        let received = frame.samples.to_reals();
        if expected.values.len() == received.len() {
            points.extend(expected.values.iter().copied().zip(received));
        }
    }
    let mut list: Vec<Candidate> = factor(view, &points).into_iter().collect();
    if view == ViewKind::Rgb {
        for (i, (says, _)) in curves(0.0).into_iter().enumerate() {
            list.push(candidate(says, NO_CURVE, 1, |v| {
                255.0 * curves(v / 255.0)[i].1
            }));
        }
        list.extend(fit_monotonic_curve(points));
    }
    list
}

impl Curve {
    /// Returns the frame without the effect of the curve. Uses the correct value if the curve maps it to the received value.
    pub(super) fn undo(&self, frame: &Frame, right: Option<&Frame>) -> Frame {
        let samples = match &frame.samples {
            Samples::F32(values) => {
                // Real values are only multiplied, so the factor is the result for 1.
                let divided = |&v: &f32| (f64::from(v) / self.table[1]) as f32;
                Samples::F32(values.iter().map(divided).collect())
            }
            Samples::U8(bytes) => {
                let source = |received: u8| {
                    let off = |v: &u8| (self.table[usize::from(*v)] - f64::from(received)).abs();
                    let nearest = (0..=255).min_by(|a, b| off(a).total_cmp(&off(b)));
                    nearest.expect("there are 256 values")
                };
                let nearest: Vec<u8> = (0..=255).map(source).collect();
                let right = match right.map(|right| &right.samples) {
                    Some(Samples::U8(right)) if right.len() == bytes.len() => &right[..],
                    _ => &[],
                };
                let undone = bytes.iter().enumerate().map(|(i, &byte)| {
                    let right = right.get(i).filter(|right| self.explains(**right, byte));
                    *right.unwrap_or(&nearest[usize::from(byte)])
                });
                Samples::U8(undone.collect())
            }
        };
        Frame {
            samples,
            ..frame.clone()
        }
    }

    /// Returns true if the curve maps the correct value to the received value, within the tolerance.
    fn explains(&self, right: u8, received: u8) -> bool {
        let near = right.saturating_sub(self.slack)..=right.saturating_add(self.slack);
        let values = near.map(|v| self.table[usize::from(v)].clamp(0.0, 255.0));
        let apart: Vec<f64> = values.map(|value| f64::from(received) - value).collect();
        apart.iter().any(|apart| *apart >= -1.0) && apart.iter().any(|apart| *apart <= 1.0)
    }
}

/// Returns the least-squares factor from expected to received values if it differs enough from 1. Ignores the bytes 0 and 255.
fn factor(view: ViewKind, points: &[(f64, f64)]) -> Option<Candidate> {
    let is_real = view == ViewKind::Coef;
    let is_evidence = |received: f64| is_real || received > 0.0 && received < 255.0;
    let evidence = points.iter().filter(|point| is_evidence(point.1));
    let (sum, square) = evidence.fold((0.0, 0.0), |(sum, square), (expected, received)| {
        (sum + expected * received, square + expected * expected)
    });
    let factor = sum / square;
    let least = if is_real { 1e-3 } else { 0.02 };
    if !factor.is_finite() || factor <= 0.0 || (factor - 1.0).abs() < least {
        return None;
    }
    let says = match factor < 1.0 {
        true => format!("all values are divided by about {:.3}", 1.0 / factor),
        false => format!("all values are multiplied by about {factor:.3}"),
    };
    let next = match is_real {
        true => "write the values unchanged",
        false => "write the values unchanged, from 0 to 255",
    };
    let slack = u8::from(view == ViewKind::Rgb);
    Some(candidate(&says, next, slack, |v| v * factor))
}

/// Returns the monotonic curve that all colors follow, or `None` if there is none or the evidence is weak.
fn fit_monotonic_curve(mut points: Vec<(f64, f64)>) -> Option<Candidate> {
    const MIN_INNER_STEPS: usize = 24;
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let steps = isotonic_regression(&points);
    let inner = steps.iter().filter(|step| step.1 > 1.0 && step.1 < 254.0);
    let off = points.iter().filter(|(e, r)| (e - r).abs() > 4.0).count();
    if inner.count() < MIN_INNER_STEPS || 4 * off < points.len() {
        return None;
    }
    let shown = [32.0, 64.0, 128.0, 192.0].map(|v| format!("{v} → {:.0}", interpolate(&steps, v)));
    let says = format!("one curve is applied to all values: {}", shown.join(", "));
    Some(candidate(&says, NO_CURVE, 1, |v| interpolate(&steps, v)))
}

/// Returns the monotonic steps that best fit `points`, which are sorted by their first coordinate. Adjacent points with
/// decreasing values are averaged.
fn isotonic_regression(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    // Each step has the sums of both numbers and their count.
    let mut steps: Vec<(f64, f64, f64)> = Vec::new();
    for &(at, value) in points {
        let mut step = (at, value, 1.0);
        while let Some(last) = steps.pop_if(|last| last.1 / last.2 >= step.1 / step.2) {
            step = (step.0 + last.0, step.1 + last.1, step.2 + last.2);
        }
        steps.push(step);
    }
    let means = steps.iter().map(|(at, value, n)| (at / n, value / n));
    means.collect()
}

/// Interpolates between the two steps on either side of a position.
fn interpolate(steps: &[(f64, f64)], at: f64) -> f64 {
    let next = steps.partition_point(|step| step.0 < at);
    match (next.checked_sub(1).map(|last| steps[last]), steps.get(next)) {
        (Some(low), Some(high)) => low.1 + (high.1 - low.1) * (at - low.0) / (high.0 - low.0),
        (Some(end), None) | (None, Some(&end)) => end.1,
        (None, None) => at,
    }
}
