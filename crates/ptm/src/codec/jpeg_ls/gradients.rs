//! T.87 A.3.2 – A.3.4: local gradients, and the context that they select
//!
//! The gradients d − b, b − c and c − a measure the slope of the neighborhood. Each is quantized to one of nine regions, −4 … 4,
//! by the thresholds T1, T2, T3 and NEAR. A neighborhood and its mirror image (with all signs inverted) share a context, with
//! errors of opposite sign. One of the 9³ = 729 triples is flat, and the others form 364 pairs.
//!
//! Worked example: lossless coding with the thresholds 3, 7, 21.
//!
//! ```text
//! c b d    10 12 40    gradients  28   2   5    regions  4  1  2    context 81·4 + 9·1 + 2 = 335
//! a x       5  x
//! ```

use super::{parameters::Parameters, template::Neighbors};

/// Returns the index of the context, negated if the neighborhood is mirrored. Index 0 is the flat neighborhood, which run mode
/// handles. The standard does not specify the numbering.
#[inline]
pub(super) fn context_number(parameters: &Parameters, neighbors: Neighbors) -> i32 {
    let Neighbors { a, b, c, d } = neighbors;
    let region = |gradient| region(parameters, gradient);
    81 * region(d - b) + 9 * region(b - c) + region(c - a)
}

/// Returns the region of a gradient (A.3.3). The flat region extends from −NEAR to NEAR, and T1, T2 and T3 separate the others.
#[inline]
fn region(parameters: &Parameters, gradient: i32) -> i32 {
    let [t1, t2, t3] = parameters.thresholds;
    let magnitude = gradient.abs();
    let reached = |threshold: i32| i32::from(magnitude >= threshold);
    let region = reached(parameters.near + 1) + reached(t1) + reached(t2) + reached(t3);
    region * gradient.signum()
}

#[cfg(test)]
mod tests {
    use super::super::parameters::{Parameters, PresetParameters};
    use super::{Neighbors, context_number};

    /// Checks the worked example of this module.
    #[test]
    fn mirrored_neighborhoods_share_a_context() {
        let parameters =
            Parameters::new(8, &PresetParameters::default(), 0, 0, 0).expect("defaults");
        let number = |a, b, c, d| context_number(&parameters, Neighbors { a, b, c, d });
        assert_eq!(number(5, 12, 10, 40), 335);
        assert_eq!(number(255 - 5, 255 - 12, 255 - 10, 255 - 40), -335);
        assert_eq!(number(9, 9, 9, 9), 0);
    }
}
