//! Descriptions of the visible difference between a wrong image and the correct one.

use crate::formula::{self, Edits};
use crate::ptm::{Planes, Ptm};
use crate::reading::Reading;

/// Lights under which images are compared: one vertical, two oblique.
const LIGHTS: [(f64, f64); 3] = [(0.0, 0.0), (0.3125, -0.4375), (-0.625, 0.5)];
/// Tolerance for the rounding of colors, the same as for decoders.
const ROUNDING_TOLERANCE: f64 = 1.0 + 1.0 / 64.0;
/// Largest color difference that is invisible.
const MAX_INVISIBLE_DIFFERENCE: u8 = 2;

/// Renderings of a map: the correct ones and those of a reader.
pub(super) struct ReaderImages {
    /// Width and height of the correct image and of the reader's image.
    sizes: [(usize, usize); 2],
    /// For each light, the correct image and the reader's image.
    lit: Vec<[Vec<u8>; 2]>,
    /// True for each light under which a color differs by more than rounding.
    differ: [bool; LIGHTS.len()],
    /// True if final coefficients differ.
    coefficients_differ: bool,
}

impl ReaderImages {
    /// Renders both maps under the lights; evaluates the reader's map with `reading` and `edits`.
    pub(super) fn new(truth: &Ptm, other: &Ptm, reading: &Reading, edits: Edits) -> ReaderImages {
        let size = |ptm: &Ptm| {
            (
                ptm.planes.size.width as usize,
                ptm.planes.size.height as usize,
            )
        };
        let sizes = [size(truth), size(other)];
        let same =
            sizes[0] == sizes[1] && truth.planes.shape.channels() == other.planes.shape.channels();
        let mut lit = vec![[Vec::new(), Vec::new()]; LIGHTS.len()];
        let mut differ = [!same; LIGHTS.len()];
        let mut coefficients_differ = !same;
        // Row by row, because coefficients and colors need far more memory than stored values.
        for row in 0..sizes[0].1.max(sizes[1].1) {
            let readers = [(truth, &Reading::SPEC, Edits(&[])), (other, reading, edits)];
            let rows = readers.map(|(ptm, reading, edits)| {
                let row = Ptm {
                    planes: row_of(ptm, row)?,
                    header: ptm.header,
                };
                Some((formula::finals(&row, reading, edits), reading, edits))
            });
            if let [Some((ours, ..)), Some((theirs, ..))] = &rows {
                let mut pairs = ours.values.iter().zip(&theirs.values);
                coefficients_differ |=
                    pairs.any(|(a, b)| (a - b).abs() > 1e-5 * a.abs().max(b.abs()) + 1e-6);
            }
            for (light, &(lu, lv)) in LIGHTS.iter().enumerate() {
                let colors = rows.each_ref().map(|row| {
                    let lit = |(row, reading, edits): &(_, &Reading, Edits)| {
                        formula::image(row, lu, lv, reading, *edits)
                    };
                    row.as_ref().map(lit)
                });
                if let [Some(ours), Some(theirs)] = &colors {
                    let mut pairs = ours.values.iter().zip(&theirs.values);
                    differ[light] |= pairs.any(|(a, b)| (a - b).abs() > ROUNDING_TOLERANCE);
                }
                for (picture, row) in lit[light].iter_mut().zip(colors) {
                    picture.extend(row.map(|row| row.to_bytes()).unwrap_or_default());
                }
            }
        }
        ReaderImages {
            sizes,
            lit,
            differ,
            coefficients_differ,
        }
    }

    /// Describes the visible fault of the reader's image, or returns `None` if the image is correct.
    pub(super) fn difference(&self) -> Option<String> {
        let Some(light) = self.differ.iter().position(|&differs| differs) else {
            return self.coefficients_differ.then(|| {
                "coefficients differ; the difference is visible under some lights at most"
                    .to_owned()
            });
        };
        if self.sizes[0] != self.sizes[1] {
            let (width, height) = self.sizes[1];
            return Some(format!("an image of {width} x {height}"));
        }
        let [truth, other] = &self.lit[light];
        let words = self
            .orientation_fault(truth, other)
            .or_else(|| exchanged_channels(truth, other));
        let words = words.unwrap_or_else(|| visible_properties(truth, other));
        Some(match light {
            0 => words,
            _ => format!("wrong as the light moves: {words}"),
        })
    }

    /// Recognizes an image that is upside down, mirrored, or both.
    fn orientation_fault(&self, truth: &[u8], other: &[u8]) -> Option<String> {
        let (width, height) = self.sizes[0];
        let is = |place: &dyn Fn(usize, usize) -> (usize, usize)| {
            (0..height).all(|y| {
                (0..width).all(|x| {
                    let (there, here) = (place(x, y), 3 * (y * width + x));
                    let there = 3 * (there.1 * width + there.0);
                    truth[there..there + 3] == other[here..here + 3]
                })
            })
        };
        let turns: [(&str, &dyn Fn(usize, usize) -> (usize, usize)); 3] = [
            ("upside down", &|x, y| (x, height - 1 - y)),
            ("mirrored", &|x, y| (width - 1 - x, y)),
            ("turned by 180 degrees", &|x, y| {
                (width - 1 - x, height - 1 - y)
            }),
        ];
        let turn = turns.iter().find(|(_, place)| is(place));
        turn.map(|(words, _)| (*words).to_owned())
    }
}

/// Returns a row of a map as a map, counted from the top.
fn row_of(ptm: &Ptm, row: usize) -> Option<Planes> {
    let length = ptm.planes.size.width as usize * ptm.planes.shape.channels();
    let samples = ptm.planes.samples.get(row * length..(row + 1) * length)?;
    let mut size = ptm.planes.size;
    size.height = 1;
    Some(Planes {
        size,
        shape: ptm.planes.shape,
        samples: samples.to_vec(),
    })
}

/// Recognizes exchanged color channels.
fn exchanged_channels(truth: &[u8], other: &[u8]) -> Option<String> {
    let orders = [
        ([2, 1, 0], "red and blue exchanged"),
        ([1, 0, 2], "red and green exchanged"),
        ([0, 2, 1], "green and blue exchanged"),
        (
            [1, 2, 0],
            "colors shifted: green for red, blue for green, red for blue",
        ),
        (
            [2, 0, 1],
            "colors shifted: blue for red, red for green, green for blue",
        ),
    ];
    let is = |order: &[usize; 3]| {
        let mut texels = truth.chunks(3).zip(other.chunks(3));
        texels.all(|(a, b)| (0..3).all(|channel| b[channel] == a[order[channel]]))
    };
    let found = orders.iter().find(|(order, _)| is(order));
    found.map(|(_, words)| (*words).to_owned())
}

/// Sums over the texels of a correct image and a reader's image.
#[derive(Default)]
struct Sums {
    texels: f64,
    /// Sums of the correct brightness, the reader's brightness, their squares and their product.
    moments: [f64; 5],
    differing: f64,
    /// Sum of the correct brightness over the differing texels.
    where_differing: f64,
    largest: u8,
}

/// Describes other visible faults: the affected part of the image, its brightness, and noise.
fn visible_properties(truth: &[u8], other: &[u8]) -> String {
    let mut sums = Sums::default();
    for (a, b) in truth.chunks(3).zip(other.chunks(3)) {
        let light = |texel: &[u8]| texel.iter().map(|&value| f64::from(value)).sum::<f64>() / 3.0;
        let (x, y) = (light(a), light(b));
        sums.texels += 1.0;
        for (sum, term) in sums.moments.iter_mut().zip([x, y, x * x, y * y, x * y]) {
            *sum += term;
        }
        let largest = a
            .iter()
            .zip(b)
            .map(|(a, b)| a.abs_diff(*b))
            .max()
            .unwrap_or(0);
        sums.largest = sums.largest.max(largest);
        if largest > 0 {
            sums.differing += 1.0;
            sums.where_differing += x;
        }
    }
    sums.words()
}

impl Sums {
    fn words(&self) -> String {
        let [x, y, xx, yy, xy] = self.moments.map(|sum| sum / self.texels.max(1.0));
        let share = self.differing / self.texels.max(1.0);
        let percent = format!("{:.0} % of the image", (100.0 * share).max(1.0));
        let spread = |mean: f64, square: f64| (square - mean * mean).max(0.0).sqrt();
        let likeness = (xy - x * y) / (spread(x, xx) * spread(y, yy)).max(1e-9);
        if self.largest <= MAX_INVISIBLE_DIFFERENCE {
            return format!(
                "off by at most {} of 255, which is hardly visible",
                self.largest
            );
        }
        if share < 0.5 {
            let there = self.where_differing / self.differing.max(1.0);
            let place = match () {
                () if there < 0.6 * x => " in dark parts",
                () if there > 1.4 * x => " in bright parts",
                () => "",
            };
            return format!("noise{place}: {percent}");
        }
        let words = match () {
            () if y < 0.9 * x && (likeness > 0.8 || y < 0.3 * x) => "too dark",
            () if y > 1.1 * x && likeness > 0.8 => "too bright",
            () if likeness > 0.8 => "wrong colors or shading",
            () => "an image that resembles noise",
        };
        format!("{words}: {percent}")
    }
}
