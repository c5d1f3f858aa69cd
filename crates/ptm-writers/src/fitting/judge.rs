//! Compares a fitted map with the photographs.
//!
//! Under each light, the root-mean-square error is compared with the error of the least-squares optimum, quantized to the same
//! format. A tolerance allows for different rounding, and for fits that are better under one light and worse under another.

use crate::fitting::{photographs::ImageSet, polynomials::Polynomials};
use crate::judge::{check_lint, compare_map, refusal};
use crate::test_case::ComparedFrames;
use crate::{
    fault::WriterFault,
    fitting::optimum::{is_determined, optimum},
};
use ptm::Format;
use ptm::decode::decode;
use ptm_suite::protocol::frame::{Frame, ViewKind};

/// Tolerance for the error: a factor, and an additional number of 8-bit levels.
const FIT_TOLERANCE: (f64, f64) = (1.25, 1.0);

/// Reason why a fit may have failed.
const UNDETERMINED: &str = "; the lights do not determine all coefficients, so the smallest of the possible coefficients are needed";

/// Returns the maximum allowed error, given the error of the optimum.
pub(super) fn max_error(best: f64) -> f64 {
    best * FIT_TOLERANCE.0 + FIT_TOLERANCE.1
}

/// Judges a file that was fitted to `set`.
///
/// # Errors
/// Returns the fault of the file.
pub fn judge(set: &ImageSet, format: Format, file: &[u8]) -> Result<(), WriterFault> {
    let ptm = decode(file).map_err(|error| refusal(file, &error))?;
    compare_map(format, set.size, &ptm)?;
    let found = Polynomials::new(&ptm).expect("the format is not LUM");
    compare_errors(set, format, &found)?;
    check_lint(file)
}

/// Returns the photograph under whose light a map exceeds the allowed error most. `best` are the errors of the optimum.
fn worst_light(errors: &[f64], best: &[f64]) -> usize {
    let excess = |k: &usize| errors[*k] - max_error(best[*k]);
    let worst = (0..errors.len()).max_by(|i, j| excess(i).total_cmp(&excess(j)));
    worst.expect("there are photographs")
}

/// Returns the images of a map and of the optimum under the light for which the map is worst.
pub(super) fn compare_worst_light(
    set: &ImageSet,
    format: Format,
    file: &[u8],
) -> Option<ComparedFrames> {
    let ptm = decode(file).ok()?;
    compare_map(format, set.size, &ptm).ok()?;
    let (found, best) = (
        Polynomials::new(&ptm)?,
        Polynomials::new(&optimum(set, format))?,
    );
    let worst = worst_light(&found.errors(set), &best.errors(set));
    let light = set.photographs[worst].direction();
    let shape = [set.size.width, set.size.height, 3];
    let image = |map: &Polynomials| {
        let colors: Vec<f64> = map.evaluate(light).collect();
        Frame::exact(ViewKind::Rgb, shape, ViewKind::Rgb.samples(&colors))
    };
    let ([u, v], name) = (light, &set.photographs[worst].name);
    Some(ComparedFrames {
        caption: format!(
            "Under the light of {name} ({u:.3}, {v:.3}): the best possible map and the fitted one"
        ),
        expected: image(&best),
        written: image(&found),
    })
}

/// Compares the error under each light with the error of the optimum.
fn compare_errors(set: &ImageSet, format: Format, found: &Polynomials) -> Result<(), WriterFault> {
    let best = Polynomials::new(&optimum(set, format)).expect("the format is not LUM");
    let (errors, best) = (found.errors(set), best.errors(set));
    let excess = |k: usize| errors[k] - max_error(best[k]);
    let worst = worst_light(&errors, &best);
    if excess(worst) <= 0.0 {
        return Ok(());
    }
    let [u, v] = set.photographs[worst].direction();
    let over = (0..errors.len()).filter(|&k| excess(k) > 0.0).count();
    let (name, lights) = (&set.photographs[worst].name, errors.len());
    let (error, best) = (errors[worst], best[worst]);
    let allowed = max_error(best);
    let reason = match is_determined(set) {
        true => "",
        false => UNDETERMINED,
    };
    let says = format!(
        "under light {u:.3}, {v:.3} ({name}), the RMS error of the map is {error:.2}, but at most {allowed:.2} is \
         allowed (the least-squares optimum has {best:.2}); the error is too large under {over} of {lights} lights{reason}"
    );
    Err(WriterFault::new("1.0/1", says))
}
