//! Comparison of the images that a reader shows with the correct images.

use ptm::reading::Reading;
use ptm::{Planes, Ptm, Size};
use ptm_mistakes::formula::{self, Edits};

/// Lights under which images are compared. All are inside the unit circle; the first is vertical.
pub const LIGHTS: [(f64, f64); 9] = [
    (0.0, 0.0),
    (0.3125, -0.4375),
    (-0.625, 0.5),
    (0.5, 0.0),
    (-0.5, 0.0),
    (0.0, 0.5),
    (0.0, -0.5),
    (0.625, 0.625),
    (-0.5, -0.6875),
];
/// Tolerance for the rounding of colors. The same tolerance applies to decoders.
const ROUNDING_TOLERANCE: f64 = 1.0 + 1.0 / 64.0;
/// Largest color difference that is invisible, of 255.
pub const MAX_INVISIBLE_DIFFERENCE: u8 = 2;

/// Number of texels that are compared at most. Of larger maps, evenly spaced rows are compared.
const MAX_COMPARED_TEXELS: usize = 1 << 17;

/// A map, and the way in which it is evaluated.
#[derive(Clone, Copy)]
pub(super) struct EvaluatedMap<'a> {
    pub(super) ptm: &'a Ptm,
    pub(super) reading: &'a Reading,
    pub(super) edits: Edits<'a>,
}

/// Differences between the correct images of a map and those of a reader, over [`LIGHTS`].
pub(super) struct ImageDifference {
    /// True if the images have different sizes.
    sizes_differ: bool,
    /// True if final coefficients differ.
    coefficients_differ: bool,
    /// True if a color differs by more than rounding can explain.
    colors_differ: bool,
    /// For each light, the largest difference between two bytes of the images.
    largest_by_light: [u8; LIGHTS.len()],
    /// Share of the texels whose color differs by more than [`MAX_INVISIBLE_DIFFERENCE`] under any light.
    pub(super) visible_share: f64,
}

impl ImageDifference {
    /// Renders both maps under the lights and compares the images. If `are_evaluated_alike` is true, only the stored values of the
    /// maps differ, so equal rows need no comparison.
    pub(super) fn new(
        truth: EvaluatedMap,
        other: EvaluatedMap,
        are_evaluated_alike: bool,
    ) -> ImageDifference {
        let [planes, others] = [truth, other].map(|map| &map.ptm.planes);
        let sizes_differ = planes.size != others.size;
        let mut difference = ImageDifference {
            sizes_differ,
            coefficients_differ: planes.shape.channels() != others.shape.channels(),
            colors_differ: sizes_differ,
            largest_by_light: [if sizes_differ { u8::MAX } else { 0 }; LIGHTS.len()],
            visible_share: if sizes_differ { 1.0 } else { 0.0 },
        };
        if sizes_differ {
            return difference;
        }
        let height = planes.size.height as usize;
        let may_differ = |&row: &usize| {
            !are_evaluated_alike || row_samples(truth.ptm, row) != row_samples(other.ptm, row)
        };
        let rows: Vec<usize> = (0..height).filter(may_differ).collect();
        let width = planes.size.width as usize;
        let step = (rows.len() * width).div_ceil(MAX_COMPARED_TEXELS).max(1);
        let (mut visible, mut compared) = (0, 0);
        // Row by row, because coefficients and colors need far more memory than stored values.
        for &row in rows.iter().step_by(step) {
            visible += difference.add_row(truth, other, row);
            compared += width;
        }
        let share = visible as f64 / compared.max(1) as f64;
        difference.visible_share = share * rows.len() as f64 / height as f64;
        difference
    }

    /// Compares the images of a row. Returns the number of visibly different texels.
    fn add_row(&mut self, truth: EvaluatedMap, other: EvaluatedMap, row: usize) -> usize {
        let rows = [truth, other].map(|map| extract_row(map.ptm, row));
        let [Some(ours), Some(theirs)] = &rows else {
            self.colors_differ = true;
            self.largest_by_light = [u8::MAX; LIGHTS.len()];
            return truth.ptm.planes.size.width as usize;
        };
        let finals = [(ours, truth), (theirs, other)]
            .map(|(row, map)| formula::final_values(row, map.reading, map.edits));
        let mut pairs = finals[0].values.iter().zip(&finals[1].values);
        self.coefficients_differ |=
            pairs.any(|(a, b)| (a - b).abs() > 1e-5 * a.abs().max(b.abs()) + 1e-6);
        let mut is_visible = vec![false; truth.ptm.planes.size.width as usize];
        for (light, &(lu, lv)) in LIGHTS.iter().enumerate() {
            let [ours, theirs] = [(&finals[0], truth), (&finals[1], other)]
                .map(|(finals, map)| formula::image(finals, lu, lv, map.reading, map.edits));
            let mut pairs = ours.values.iter().zip(&theirs.values);
            self.colors_differ |= pairs.any(|(a, b)| (a - b).abs() > ROUNDING_TOLERANCE);
            let (ours, theirs) = (ours.to_bytes(), theirs.to_bytes());
            let texels = ours.chunks(3).zip(theirs.chunks(3));
            for (is_visible, (a, b)) in is_visible.iter_mut().zip(texels) {
                let difference = largest_difference(a, b);
                self.largest_by_light[light] = self.largest_by_light[light].max(difference);
                *is_visible |= difference > MAX_INVISIBLE_DIFFERENCE;
            }
        }
        is_visible.iter().filter(|&&is_visible| is_visible).count()
    }

    /// Returns true if no final coefficient differs, and no color by more than rounding can explain.
    pub(super) fn is_none(&self) -> bool {
        !self.colors_differ && !self.coefficients_differ
    }

    /// Returns true if a person can see the difference.
    pub(super) fn is_visible(&self) -> bool {
        self.largest() > MAX_INVISIBLE_DIFFERENCE
    }

    /// Returns the largest difference of two colors, of 255.
    pub(super) fn largest(&self) -> u8 {
        self.largest_by_light.into_iter().max().unwrap_or(0)
    }

    /// Describes the fault of the reader's images. Returns an empty string if they are correct.
    pub(super) fn describe(&self, truth: EvaluatedMap, other: EvaluatedMap) -> String {
        if self.is_none() {
            return String::new();
        }
        if self.sizes_differ {
            let Size { width, height } = other.ptm.planes.size;
            return format!("an image of {width} x {height}");
        }
        let mut lights = self.largest_by_light.iter();
        let visible = lights.position(|&largest| largest > MAX_INVISIBLE_DIFFERENCE);
        let Some(light) = visible else {
            return match self.largest() {
                0 => "coefficients differ, but no color under the tested lights".to_owned(),
                largest => format!("colors differ by at most {largest} of 255"),
            };
        };
        let images = ImagePair::render(truth, other, LIGHTS[light]);
        match light {
            0 => images.fault(),
            _ => format!("wrong when the light moves: {}", images.fault()),
        }
    }
}

/// The correct image and a reader's image of the same size under one light.
struct ImagePair {
    size: Size,
    truth: Vec<u8>,
    other: Vec<u8>,
}

impl ImagePair {
    fn render(truth: EvaluatedMap, other: EvaluatedMap, (lu, lv): (f64, f64)) -> ImagePair {
        let size = truth.ptm.planes.size;
        let [truth, other] = [truth, other].map(|map| {
            let rows = (0..size.height as usize).map_while(|row| extract_row(map.ptm, row));
            let images = rows.map(|row| {
                let finals = formula::final_values(&row, map.reading, map.edits);
                formula::image(&finals, lu, lv, map.reading, map.edits).to_bytes()
            });
            images.flatten().collect()
        });
        ImagePair { size, truth, other }
    }

    /// Describes the visible fault of the reader's image.
    fn fault(&self) -> String {
        let (truth, other) = (&self.truth, &self.other);
        self.orientation_fault(truth, other)
            .or_else(|| swapped_channels(truth, other))
            .unwrap_or_else(|| visible_properties(truth, other))
    }

    /// Describes the orientation of an image that is upside down, mirrored, or both.
    fn orientation_fault(&self, truth: &[u8], other: &[u8]) -> Option<String> {
        let Size { width, height } = self.size;
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

/// Returns the stored values of a row. Rows are counted from the top.
fn row_samples(ptm: &Ptm, row: usize) -> Option<&[u8]> {
    let Planes { shape, size, .. } = ptm.planes;
    let length = size.width as usize * shape.channels();
    ptm.planes.samples.get(row * length..(row + 1) * length)
}

/// Returns a row of a map as a map of height 1. Rows are counted from the top.
fn extract_row(ptm: &Ptm, row: usize) -> Option<Ptm> {
    let Planes { shape, size, .. } = ptm.planes;
    let planes = Planes {
        shape,
        size: Size { height: 1, ..size },
        samples: row_samples(ptm, row)?.to_vec(),
    };
    let header = ptm.header;
    Some(Ptm { header, planes })
}

/// Returns the largest difference between two colors.
fn largest_difference(a: &[u8], b: &[u8]) -> u8 {
    let differences = a.iter().zip(b).map(|(a, b)| a.abs_diff(*b));
    differences.max().unwrap_or(0)
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
    let (mut differing, mut sum_where_differing) = (0.0, 0.0);
    for (a, b) in truth.chunks(3).zip(other.chunks(3)) {
        let gray = |texel: &[u8]| texel.iter().map(|&value| f64::from(value)).sum::<f64>() / 3.0;
        let (x, y) = (gray(a), gray(b));
        for (sum, term) in moments.iter_mut().zip([x, y, x * x, y * y, x * y]) {
            *sum += term;
        }
        if largest_difference(a, b) > 0 {
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
