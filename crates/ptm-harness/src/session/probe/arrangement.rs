//! Common mistakes in the order of samples.

use ptm_suite::compare::Expected;
use ptm_suite::protocol::frame::{Frame, Samples};

use super::body::Interpretation;
use super::message::{ProbeFault, fault};

/// Names of the possible sample orders. The empty name stands for the correct order.
const LAYOUTS: [&str; 4] = ["", "planar", "planar-rows", "column-major"];

/// Names of the possible channel orders. The empty name stands for the correct order.
const ORDERS: [&str; 7] = [
    "",
    "bgr",
    "cb-first",
    "chroma-first",
    "color-first",
    "coefficients-backward",
    "by-coefficient",
];

/// Order of the channels of an image whose samples are written from the last to the first.
const REVERSED: &str = "reversed";

/// An order of samples for images with any number of channels.
#[derive(Clone, Copy, Debug)]
pub(in crate::session) struct Arrangement {
    layout: &'static str,
    order: &'static str,
    upside_down: bool,
    mirrored: bool,
}

impl Arrangement {
    /// Returns all arrangements, the correct one first. The last one reverses all samples.
    pub(in crate::session) fn all() -> impl Iterator<Item = Arrangement> {
        let count = LAYOUTS.len() * ORDERS.len() * 4;
        let all = (0..count).map(|i| Arrangement {
            layout: LAYOUTS[i / 4 / ORDERS.len()],
            order: ORDERS[i / 4 % ORDERS.len()],
            upside_down: i & 2 != 0,
            mirrored: i & 1 != 0,
        });
        all.chain(std::iter::once(Arrangement {
            layout: "",
            order: REVERSED,
            upside_down: true,
            mirrored: true,
        }))
    }

    /// Returns the index of each sample in an image with this arrangement. The indices are in the order of the samples of a
    /// correct image.
    fn sample_indices(&self, (width, height, channels): (usize, usize, usize)) -> Vec<usize> {
        let order = channel_order(self.order, channels);
        let order = order.unwrap_or_else(|| (0..channels).collect());
        let mut places = Vec::with_capacity(width * height * channels);
        for y in 0..height {
            for x in 0..width {
                let y = if self.upside_down { height - 1 - y } else { y };
                let x = if self.mirrored { width - 1 - x } else { x };
                places.extend(order.iter().map(|&channel| match self.layout {
                    "planar" => (channel * height + y) * width + x,
                    "planar-rows" => (y * channels + channel) * width + x,
                    "column-major" => (x * height + y) * channels + channel,
                    _ => (y * width + x) * channels + channel,
                }));
            }
        }
        places
    }

    /// Returns `frame` with its samples in the correct order.
    pub(in crate::session) fn undo(&self, frame: &Frame) -> Frame {
        let [width, height, channels] =
            [frame.width, frame.height, frame.channels].map(|count| count as usize);
        let places = self.sample_indices((width, height, channels)).into_iter();
        let samples = match &frame.samples {
            Samples::U8(bytes) => Samples::U8(places.map(|place| bytes[place]).collect()),
            Samples::F32(values) => Samples::F32(places.map(|place| values[place]).collect()),
        };
        Frame {
            samples,
            ..frame.clone()
        }
    }

    /// Returns the mistakes that lead to this arrangement; empty for the correct arrangement.
    pub(in crate::session) fn mistakes(&self) -> Vec<ProbeFault> {
        if self.order == REVERSED {
            return vec![fault(REVERSED, &[])];
        }
        let upside_down = if self.upside_down { "upside-down" } else { "" };
        let mirrored = if self.mirrored { "mirrored" } else { "" };
        let names = [self.layout, self.order, upside_down, mirrored].into_iter();
        let wrong = names.filter(|name| !name.is_empty());
        wrong.map(|name| fault(name, &[])).collect()
    }
}

/// Undoes every possible arrangement of `values`. Each result contains the reordered values and the mistakes that were undone.
pub(super) fn arrangements(values: &[f64], expected: &Expected) -> Vec<Interpretation> {
    let (width, height) = (expected.size.width as usize, expected.size.height as usize);
    let channels = expected.channels;
    if values.len() != width * height * channels {
        return Vec::new();
    }
    let is_order = |one: &Arrangement| channel_order(one.order, channels).is_some();
    let ordered = |one: Arrangement| {
        let places = one.sample_indices((width, height, channels)).into_iter();
        (places.map(|place| values[place]).collect(), one.mistakes())
    };
    Arrangement::all().filter(is_order).map(ordered).collect()
}

/// Returns the position of each channel in the order `name`, or `None` if this number of channels has no such order.
fn channel_order(name: &str, channels: usize) -> Option<Vec<usize>> {
    let list = |place: fn(usize, usize) -> usize| (0..18).map(|c| place(c / 6, c % 6)).collect();
    Some(match (channels, name) {
        (_, "") => (0..channels).collect(),
        (_, REVERSED) => (0..channels).rev().collect(),
        (3, "bgr") => vec![2, 1, 0],
        (8, "cb-first") => vec![0, 1, 2, 3, 4, 5, 7, 6],
        (8, "chroma-first") => vec![2, 3, 4, 5, 6, 7, 0, 1],
        (9, "bgr") => vec![0, 1, 2, 3, 4, 5, 8, 7, 6],
        (9, "color-first") => vec![3, 4, 5, 6, 7, 8, 0, 1, 2],
        (8 | 9, "coefficients-backward") => (0..6).rev().chain(6..channels).collect(),
        (18, "bgr") => list(|color, a| (2 - color) * 6 + a),
        (18, "by-coefficient") => list(|color, a| a * 3 + color),
        (18, "coefficients-backward") => list(|color, a| color * 6 + 5 - a),
        _ => return None,
    })
}
