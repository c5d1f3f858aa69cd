//! What a decoder multiplies the six coefficients of a polynomial by, solved from colors.
//!
//! Least squares over the texels of a file say what each stored coefficient was multiplied by under its light. Files have
//! different lights: only what a slip may put there under all of them is left.

use super::formulas::weights;
use super::powers::{POWERS, Powers};
use crate::diagnose::search::{Search, Set};
use crate::diagnose::solved::Act;
use crate::misreadings::misread;
use crate::protocol::frame::{Samples, View};
use crate::ptm::Ptm;
use crate::session::observation::Response;

/// Samples of all files that are asked.
const SAMPLES: usize = 1 << 17;
/// Fewest files whose colors tell something.
const FEWEST: usize = 4;

/// The polynomial that `pictures` show, made with the mistakes of `set`; nothing where it is the right one.
pub(in crate::diagnose) fn candidate(
    search: &Search,
    set: &Set,
    pictures: &[usize],
) -> Option<Act> {
    let sample = search.smallest(pictures, SAMPLES);
    let fitting = search.each(&sample, |&w| fitting(search, set, w));
    let fitting: Vec<[Vec<bool>; 6]> = fitting.into_iter().flatten().collect();
    if fitting.len() < FEWEST {
        return None;
    }
    let best = |i: usize| {
        let count = |power: &usize| fitting.iter().filter(|of| of[i][*power]).count();
        let others = (0..POWERS.len()).filter(|&power| power != i);
        // Of those that fit as many files the last is taken, the right one rather than another.
        let powers = others.rev().chain([i]);
        powers
            .max_by_key(count)
            .filter(|power| count(power) * 10 >= fitting.len() * 9)
    };
    let powers = [best(0)?, best(1)?, best(2)?, best(3)?, best(4)?, best(5)?];
    (powers != [0, 1, 2, 3, 4, 5]).then_some(Act::Powers(Powers(powers)))
}

/// For each coefficient, whether each of [`POWERS`] may stand beside it in this file.
fn fitting(search: &Search, set: &Set, w: usize) -> Option<[Vec<bool>; 6]> {
    let witness = &search.witnesses[w];
    let (
        View::Rgb(light),
        Response::Picture {
            frame: Some(received),
            ..
        },
    ) = (&witness.observation.view, &witness.observation.response)
    else {
        return None;
    };
    let mistakes = search.mistakes_of(set);
    let listed: Vec<_> = mistakes.iter().filter_map(|one| one.listed()).collect();
    let reading = misread(&listed, witness.reading);
    let ptm: Ptm = witness.planes(&mistakes).ok()?;
    let Samples::U8(bytes) = &received.samples else {
        return None;
    };
    if bytes.len() != ptm.planes.size.texels() * 3 {
        return None;
    }
    let (weights, errors) = weights(&ptm, bytes)?;
    let (u, v) = (reading.light)(light.lu, light.lv);
    let scale = ptm.header.scale_bias.scale;
    Some([0, 1, 2, 3, 4, 5].map(|i| {
        let made = POWERS.iter().map(|(_, power)| power(u, v) * scale[i]);
        made.map(|made| (made - weights[i]).abs() <= 5.0 * errors[i] + 1e-4)
            .collect()
    }))
}

#[cfg(test)]
mod tests {
    use crate::diagnose::tests::first_cause;
    use crate::reading::Reading;

    #[test]
    fn a_polynomial_with_several_slips_is_told_as_one_expression() {
        let reading = Reading {
            polynomial: |a, u, v| {
                a[1] * u * u + a[0] * v * v + a[2] * u * u + a[3] * u + a[4] * v.abs() + a[5]
            },
            ..Reading::SPEC
        };
        let told = first_cause(reading, |case| !case.format().is_compressed());
        let says = "C = a0·v² + a1·u² + a2·u² + a3·u + a4·|v| + a5";
        assert!(told.contains(says), "{told}");
    }
}
