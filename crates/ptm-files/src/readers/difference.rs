//! Descriptions of the visible difference between a wrong image and the correct one.

use ptm::reading::Reading;
use ptm::{Planes, Ptm, Size};
use ptm_mistakes::formula::{self, Edits};

/// Lights under which images are compared: one vertical and two oblique.
const LIGHTS: [(f64, f64); 3] = [(0.0, 0.0), (0.3125, -0.4375), (-0.625, 0.5)];
/// Tolerance for the rounding of colors. The same tolerance applies to decoders.
const ROUNDING_TOLERANCE: f64 = 1.0 + 1.0 / 64.0;
/// Largest color difference that is invisible.
const MAX_INVISIBLE_DIFFERENCE: u8 = 2;

/// Renderings of a map: the correct ones and those of a reader.
pub(super) struct ReaderImages {
    /// Width and height of the correct image and of the reader's image.
    sizes: [Size; 2],
    /// For each light, the correct image and the reader's image.
    images: Vec<[Vec<u8>; 2]>,
    /// True for each light under which a color differs by more than rounding can explain.
    colors_differ: [bool; LIGHTS.len()],
    /// True if final coefficients differ.
    coefficients_differ: bool,
}

impl ReaderImages {
    /// Renders both maps under the lights. Evaluates the reader's map with `reading` and `edits`.
    pub(super) fn new(truth: &Ptm, other: &Ptm, reading: &Reading, edits: Edits) -> ReaderImages {
        let sizes = [truth, other].map(|ptm| ptm.planes.size);
        let channels = [truth, other].map(|ptm| ptm.planes.shape.channels());
        let same = sizes[0] == sizes[1] && channels[0] == channels[1];
        let mut images = vec![[Vec::new(), Vec::new()]; LIGHTS.len()];
        let mut colors_differ = [!same; LIGHTS.len()];
        let mut coefficients_differ = !same;
        // Row by row, because coefficients and colors need far more memory than stored values.
        for row in 0..sizes[0].height.max(sizes[1].height) as usize {
            let readers = [(truth, &Reading::SPEC, Edits(&[])), (other, reading, edits)];
            let rows = readers.map(|(ptm, reading, edits)| {
                let row = Ptm {
                    planes: extract_row(ptm, row)?,
                    header: ptm.header,
                };
                Some((formula::final_values(&row, reading, edits), reading, edits))
            });
            if let [Some((ours, ..)), Some((theirs, ..))] = &rows {
                let mut pairs = ours.values.iter().zip(&theirs.values);
                coefficients_differ |=
                    pairs.any(|(a, b)| (a - b).abs() > 1e-5 * a.abs().max(b.abs()) + 1e-6);
            }
            for (light, &(lu, lv)) in LIGHTS.iter().enumerate() {
                let colors = rows.each_ref().map(|row| {
                    let render = |(row, reading, edits): &(_, &Reading, Edits)| {
                        formula::image(row, lu, lv, reading, *edits)
                    };
                    row.as_ref().map(render)
                });
                if let [Some(ours), Some(theirs)] = &colors {
                    let mut pairs = ours.values.iter().zip(&theirs.values);
                    colors_differ[light] |= pairs.any(|(a, b)| (a - b).abs() > ROUNDING_TOLERANCE);
                }
                for (image, row) in images[light].iter_mut().zip(colors) {
                    image.extend(row.map(|row| row.to_bytes()).unwrap_or_default());
                }
            }
        }
        ReaderImages {
            sizes,
            images,
            colors_differ,
            coefficients_differ,
        }
    }

    /// Describes the visible fault of the reader's image, or returns `None` if the image is correct.
    pub(super) fn difference(&self) -> Option<String> {
        let Some(light) = self.colors_differ.iter().position(|&differs| differs) else {
            let fault =
                "coefficients differ; the difference is visible only under some lights, if at all";
            return self.coefficients_differ.then(|| fault.to_owned());
        };
        if self.sizes[0] != self.sizes[1] {
            let Size { width, height } = self.sizes[1];
            return Some(format!("an image of {width} x {height}"));
        }
        let [truth, other] = &self.images[light];
        let fault = self
            .orientation_fault(truth, other)
            .or_else(|| swapped_channels(truth, other));
        let fault = fault.unwrap_or_else(|| visible_properties(truth, other));
        Some(match light {
            0 => fault,
            _ => format!("wrong when the light moves: {fault}"),
        })
    }

    /// Describes the orientation of an image that is upside down, mirrored, or both.
    fn orientation_fault(&self, truth: &[u8], other: &[u8]) -> Option<String> {
        let Size { width, height } = self.sizes[0];
        let (width, height) = (width as usize, height as usize);
        let equals = |mirrored: bool, upside_down: bool| {
            (0..width * height).all(|texel| {
                let (x, y) = (texel % width, texel / width);
                let x = if mirrored { width - 1 - x } else { x };
                let y = if upside_down { height - 1 - y } else { y };
                truth[3 * (y * width + x)..][..3] == other[3 * texel..][..3]
            })
        };
        let fault = match () {
            () if equals(false, true) => "upside down",
            () if equals(true, false) => "mirrored",
            () if equals(true, true) => "rotated by 180 degrees",
            () => return None,
        };
        Some(fault.to_owned())
    }
}

/// Returns a row of a map as planes of height 1. Rows are counted from the top.
fn extract_row(ptm: &Ptm, row: usize) -> Option<Planes> {
    let Planes {
        shape, mut size, ..
    } = ptm.planes;
    let length = size.width as usize * shape.channels();
    let samples = ptm.planes.samples.get(row * length..(row + 1) * length)?;
    let samples = samples.to_vec();
    size.height = 1;
    Some(Planes {
        size,
        shape,
        samples,
    })
}

const GREEN_FOR_RED: &str = "colors shifted: red shows green, green shows blue, blue shows red";
const BLUE_FOR_RED: &str = "colors shifted: red shows blue, green shows red, blue shows green";

/// Describes the order of swapped color channels.
fn swapped_channels(truth: &[u8], other: &[u8]) -> Option<String> {
    let orders = [
        ([2, 1, 0], "red and blue swapped"),
        ([1, 0, 2], "red and green swapped"),
        ([0, 2, 1], "green and blue swapped"),
        ([1, 2, 0], GREEN_FOR_RED),
        ([2, 0, 1], BLUE_FOR_RED),
    ];
    let has_order = |order: [usize; 3]| {
        let mut texels = truth.chunks(3).zip(other.chunks(3));
        texels.all(|(a, b)| (0..3).all(|channel| b[channel] == a[order[channel]]))
    };
    let found = orders.into_iter().find(|(order, _)| has_order(*order));
    found.map(|(_, fault)| fault.to_owned())
}

/// Describes any other visible fault, such as noise or wrong brightness, and the affected share of the image.
fn visible_properties(truth: &[u8], other: &[u8]) -> String {
    // Sums of the correct brightness, the reader's brightness, their squares and their product.
    let mut moments = [0.0; 5];
    // `sum_where_differing` is the sum of the correct brightness over the differing texels.
    let (mut differing, mut sum_where_differing, mut largest) = (0.0, 0.0, 0);
    for (a, b) in truth.chunks(3).zip(other.chunks(3)) {
        let gray = |texel: &[u8]| texel.iter().map(|&value| f64::from(value)).sum::<f64>() / 3.0;
        let (x, y) = (gray(a), gray(b));
        for (sum, term) in moments.iter_mut().zip([x, y, x * x, y * y, x * y]) {
            *sum += term;
        }
        let differences = a.iter().zip(b).map(|(a, b)| a.abs_diff(*b));
        let difference = differences.max().unwrap_or(0);
        largest = largest.max(difference);
        if difference > 0 {
            differing += 1.0;
            sum_where_differing += x;
        }
    }
    let texels = (truth.len().min(other.len()).div_ceil(3) as f64).max(1.0);
    let [x, y, xx, yy, xy] = moments.map(|sum| sum / texels);
    let share = differing / texels;
    let percent = format!("{:.0} % of the image", (100.0 * share).max(1.0));
    let deviation = |mean: f64, square: f64| (square - mean * mean).max(0.0).sqrt();
    let correlation = (xy - x * y) / (deviation(x, xx) * deviation(y, yy)).max(1e-9);
    let mean = sum_where_differing / f64::max(differing, 1.0);
    let fault = match () {
        () if largest <= MAX_INVISIBLE_DIFFERENCE => {
            return format!("off by at most {largest} of 255, which is barely visible");
        }
        () if share < 0.5 && mean < 0.6 * x => "noise in dark parts",
        () if share < 0.5 && mean > 1.4 * x => "noise in bright parts",
        () if share < 0.5 => "noise",
        () if y < 0.9 * x && (correlation > 0.8 || y < 0.3 * x) => "too dark",
        () if y > 1.1 * x && correlation > 0.8 => "too bright",
        () if correlation > 0.8 => "wrong colors or shading",
        () => "an image that resembles noise",
    };
    format!("{fault}: {percent}")
}
