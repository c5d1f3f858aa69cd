//! Final values that are right for other numbers than those of the header: the scale or the bias that a decoder used,
//! solved from its picture.

use crate::diagnose::pair::Pair;
use crate::diagnose::witness::Witness;
use crate::ptm::{Ptm, ScaleBias};
use crate::suite::compare::{apart, is_close};

/// What may be said of several files: of which number it is.
pub(in crate::diagnose) const OTHER_BIAS: &str =
    "final values as of another bias than the header's";
/// As above.
pub(in crate::diagnose) const OTHER_SCALE: &str =
    "final values as of another scale than the header's";

/// A number of the header, as it was used.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::diagnose) struct Used {
    /// [`OTHER_BIAS`] or [`OTHER_SCALE`].
    pub says: &'static str,
    /// Of which of a0 … a5.
    pub coefficient: usize,
    pub value: f64,
    right: f64,
}

impl Used {
    pub fn is_bias(&self) -> bool {
        self.says == OTHER_BIAS
    }

    /// ", as if the bias of a3 were -21 and not -214".
    pub fn in_words(&self) -> String {
        let name = if self.is_bias() { "bias" } else { "scale" };
        let [used, right] = apart(self.value, self.right, 8);
        format!(
            ", as if the {name} of a{} were {used} and not {right}",
            self.coefficient
        )
    }
}

/// The number with which all wrong values of one coefficient come out, if it is one number: that of the first wrong one.
pub(in crate::diagnose) fn used(pair: &Pair, witness: &Witness) -> Option<Used> {
    let ptm = witness.decoded().as_ref().ok()?;
    let wrong = wrong_coefficients(pair, ptm)?;
    of_coefficient(pair, ptm, wrong.iter().position(|is| *is)?)
}

/// The same of each of a0 … a5 that is wrong.
pub(in crate::diagnose) fn all_used(pair: &Pair, witness: &Witness) -> Option<Vec<Used>> {
    let ptm = witness.decoded().as_ref().ok()?;
    let wrong = wrong_coefficients(pair, ptm)?;
    let wrong = (0..6).filter(|&coefficient| wrong[coefficient]);
    wrong
        .map(|coefficient| of_coefficient(pair, ptm, coefficient))
        .collect()
}

/// Which of a0 … a5 are wrong, where nothing else is.
fn wrong_coefficients(pair: &Pair, ptm: &Ptm) -> Option<[bool; 6]> {
    let coefficients = ptm.planes.shape.coefficients();
    let wrong = pair.wrong_channels();
    let is_final = pair.view == "coef" && ptm.planes.samples.len() == pair.got.len();
    if !is_final || wrong[coefficients..].contains(&true) {
        return None;
    }
    Some([0, 1, 2, 3, 4, 5].map(|a| wrong[a..coefficients].iter().step_by(6).any(|is| *is)))
}

fn of_coefficient(pair: &Pair, ptm: &Ptm, coefficient: usize) -> Option<Used> {
    let coefficients = ptm.planes.shape.coefficients();
    let of: Vec<(f64, f64)> = (0..pair.got.len())
        .filter(|i| i % pair.channels < coefficients && i % pair.channels % 6 == coefficient)
        .map(|i| (f64::from(ptm.planes.samples[i]), pair.got[i]))
        .collect();
    solved(&of, coefficient, &ptm.header.scale_bias)
}

/// From raw values and final ones: (raw − bias) · scale with another bias, or with another scale.
fn solved(of: &[(f64, f64)], coefficient: usize, numbers: &ScaleBias) -> Option<Used> {
    let (scale, bias) = (numbers.scale[coefficient], numbers.bias[coefficient]);
    let &(raw, value) = of.iter().find(|(raw, _)| *raw != bias)?;
    if of.iter().all(|other| other.0 == raw) {
        return None;
    }
    let fits = |scale: f64, bias: f64| {
        of.iter()
            .all(|(raw, value)| is_close((raw - bias) * scale, *value, 0.0))
    };
    let other_bias = raw - value / scale;
    let near = (other_bias * 1024.0).round() / 1024.0;
    if scale != 0.0 && fits(scale, near) {
        return Some(Used {
            says: OTHER_BIAS,
            coefficient,
            value: near,
            right: bias,
        });
    }
    let other_scale = value / (raw - bias);
    // What overflows comes out the same with many scales.
    let is_known = other_scale.is_finite() && fits(other_scale, bias);
    is_known.then_some(Used {
        says: OTHER_SCALE,
        coefficient,
        value: other_scale,
        right: scale,
    })
}

#[cfg(test)]
mod tests {
    use super::{OTHER_BIAS, OTHER_SCALE, solved};
    use crate::ptm::ScaleBias;

    /// A bias of −214 that was cut to −21, and a scale of 0.5 that was taken for 0.25.
    #[test]
    fn one_number_is_solved_and_two_are_not() {
        let numbers = ScaleBias {
            scale: [0.5; 6],
            bias: [-214.0; 6],
        };
        let values = |scale: f64, bias: f64| -> Vec<(f64, f64)> {
            let raw = [3.0, 77.0, 254.0];
            raw.map(|raw| (raw, (raw - bias) * scale)).to_vec()
        };
        let used = solved(&values(0.5, -21.0), 3, &numbers).expect("a bias");
        assert_eq!((used.says, used.value), (OTHER_BIAS, -21.0));
        assert_eq!(
            used.in_words(),
            ", as if the bias of a3 were -21 and not -214"
        );
        let used = solved(&values(0.25, -214.0), 0, &numbers).expect("a scale");
        assert_eq!((used.says, used.value), (OTHER_SCALE, 0.25));
        assert_eq!(solved(&values(0.25, -21.0), 0, &numbers), None);
    }
}
