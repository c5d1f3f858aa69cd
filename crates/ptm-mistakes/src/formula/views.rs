//! Views of a decoded map, computed with edited formulas.

use super::stages::{Edits, final_values, floats, image, stored_values};
use ptm::Ptm;
use ptm::reading::Reading;
use ptm_suite::protocol::frame::{Frame, Light, Samples, View};

/// Returns the values of all samples of `ptm` in `view` under a reading, with some formulas edited. Colors are not rounded.
pub fn values(ptm: &Ptm, view: &View, reading: &Reading, edits: Edits) -> Vec<f64> {
    let ptm = &*stored_values(ptm, edits);
    let finals = || final_values(ptm, reading, edits);
    match view {
        View::Raw => ptm.planes.samples.iter().copied().map(f64::from).collect(),
        View::Coef => floats(finals().values, edits),
        View::Rgb(Light { lu, lv, .. }) => image(&finals(), *lu, *lv, reading, edits).values,
    }
}

/// Renders `ptm` in `view` under a reading, with some formulas edited.
#[must_use]
pub fn render(ptm: &Ptm, view: &View, reading: &Reading, edits: Edits) -> Frame {
    let samples = match view {
        // Bytes are copied without a conversion to real numbers.
        View::Raw => Samples::U8(stored_values(ptm, edits).planes.samples.clone()),
        _ => view.kind().samples(&values(ptm, view, reading, edits)),
    };
    Frame::of_map(ptm, view, samples)
}
