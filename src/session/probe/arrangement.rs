//! The orders in which wrappers are known to send samples, other than the right one.

use crate::protocol::frame::{Frame, Samples};
use crate::suite::compare::Expected;

use super::mistake::{Interpretation, Mistake, mistake};

/// Where the sample of (x, y, channel) stands in a raster of (width, height, channels).
type Position = fn((usize, usize, usize), (usize, usize, usize)) -> usize;

/// How samples follow each other: what to say, and where each stands.
const LAYOUTS: [(Option<&str>, Position); 4] = [
    (None, |(x, y, c), (w, _, n)| (y * w + x) * n + c),
    (
        Some("its channels follow each other as whole planes"),
        |(x, y, c), (w, h, _)| (c * h + y) * w + x,
    ),
    (
        Some("its channels follow each other within each row"),
        |(x, y, c), (w, _, n)| (y * n + c) * w + x,
    ),
    (
        Some("its texels run column by column"),
        |(x, y, c), (_, h, n)| (x * h + y) * n + c,
    ),
];

const BGR: &str = "red and blue are exchanged (BGR)";
const CB_FIRST: &str = "Cb stands before Cr";
const CHROMA_FIRST: &str = "Cr and Cb stand before the coefficients";
const COLOR_FIRST: &str = "the color stands before the coefficients";
const COEFFICIENTS_BACKWARD: &str = "the coefficients run from a5 to a0";
const BY_COEFFICIENT: &str = "the three colors of a coefficient stand together";

/// Orders of channels: what to say of each but the right one.
const ORDERS: [Option<&str>; 7] = [
    None,
    Some(BGR),
    Some(CB_FIRST),
    Some(CHROMA_FIRST),
    Some(COLOR_FIRST),
    Some(COEFFICIENTS_BACKWARD),
    Some(BY_COEFFICIENT),
];

/// Where samples stand, for pictures of every number of channels.
#[derive(Clone, Copy, Debug)]
pub(in crate::session) struct Arrangement {
    layout: (Option<&'static str>, Position),
    order: Option<&'static str>,
    upside_down: bool,
    mirrored: bool,
}

impl Arrangement {
    /// All of them, the right one first.
    pub(in crate::session) fn all() -> Vec<Arrangement> {
        let mut all = Vec::new();
        for layout in LAYOUTS {
            for order in ORDERS {
                for flip in 0..4 {
                    all.push(Arrangement {
                        layout,
                        order,
                        upside_down: flip & 2 != 0,
                        mirrored: flip & 1 != 0,
                    });
                }
            }
        }
        all
    }

    /// For each sample of a right picture, from the top left on, where it stands in one that is arranged like this.
    fn places(&self, (width, height, channels): (usize, usize, usize)) -> Vec<usize> {
        let in_texel: Vec<usize> = (0..channels).collect();
        let order = (self.order).and_then(|name| channel_order(name, channels));
        let order = order.unwrap_or(in_texel);
        let mut places = Vec::with_capacity(width * height * channels);
        for y in 0..height {
            for x in 0..width {
                let y = if self.upside_down { height - 1 - y } else { y };
                let x = if self.mirrored { width - 1 - x } else { x };
                let place = |&c: &usize| (self.layout.1)((x, y, c), (width, height, channels));
                places.extend(order.iter().map(place));
            }
        }
        places
    }

    /// The same picture with its samples in the right order.
    pub(in crate::session) fn undo(&self, frame: &Frame) -> Frame {
        let shape = (frame.width, frame.height, frame.channels);
        let places = self.places((shape.0 as usize, shape.1 as usize, shape.2 as usize));
        let samples = match &frame.samples {
            Samples::U8(bytes) => Samples::U8(places.iter().map(|&place| bytes[place]).collect()),
            Samples::F32(values) => {
                Samples::F32(places.iter().map(|&place| values[place]).collect())
            }
        };
        Frame {
            samples,
            ..frame.clone()
        }
    }

    /// What is wrong with it; nothing with the right one.
    pub(in crate::session) fn mistakes(&self) -> Vec<Mistake> {
        let named = [
            (
                self.layout.0,
                "texel after texel, all channels of a texel side by side: array index [y][x][channel]",
            ),
            (
                self.order,
                "channels in the order of the text: r a0…a5, g a0…a5, b a0…a5; a0…a5, R, G, B; a0…a5, Cr, Cb; red, green, blue",
            ),
            (
                self.upside_down.then_some("its rows are upside down"),
                "files store the bottom row first; frames have the top row first",
            ),
            (
                self.mirrored.then_some("its rows run from right to left"),
                "texels run from left to right, as they are stored",
            ),
        ];
        let present = named
            .into_iter()
            .filter_map(|(says, next)| Some((says?, next)));
        let order = |(says, next)| Mistake {
            is_order: true,
            ..mistake(says, next)
        };
        present.map(order).collect()
    }
}

/// The same values in every order in which they may stand.
pub(super) fn arrangements(values: &[f64], expected: &Expected) -> Vec<Interpretation> {
    let (width, height) = (expected.size.width as usize, expected.size.height as usize);
    let channels = expected.channels;
    if values.len() != width * height * channels {
        return Vec::new();
    }
    let is_order =
        |of: &Arrangement| (of.order).is_none_or(|name| channel_order(name, channels).is_some());
    let ordered = |of: Arrangement| {
        let places = of.places((width, height, channels));
        let ordered = places.into_iter().map(|place| values[place]).collect();
        (ordered, of.mistakes())
    };
    let all = Arrangement::all().into_iter();
    all.filter(is_order).map(ordered).collect()
}

/// For each right channel where it stands; nothing where so many channels have no such order.
fn channel_order(name: &str, channels: usize) -> Option<Vec<usize>> {
    let at = |place: fn(usize, usize) -> usize| {
        let colors = (0..3).flat_map(|color| (0..6).map(move |a| (color, a)));
        colors.map(|(color, a)| place(color, a)).collect::<Vec<_>>()
    };
    Some(match (channels, name) {
        (3, BGR) => vec![2, 1, 0],
        (8, CB_FIRST) => vec![0, 1, 2, 3, 4, 5, 7, 6],
        (8, CHROMA_FIRST) => vec![2, 3, 4, 5, 6, 7, 0, 1],
        (9, BGR) => vec![0, 1, 2, 3, 4, 5, 8, 7, 6],
        (9, COLOR_FIRST) => vec![3, 4, 5, 6, 7, 8, 0, 1, 2],
        (8 | 9, COEFFICIENTS_BACKWARD) => (0..6).rev().chain(6..channels).collect(),
        (18, BGR) => at(|color, a| (2 - color) * 6 + a),
        (18, BY_COEFFICIENT) => at(|color, a| a * 3 + color),
        (18, COEFFICIENTS_BACKWARD) => at(|color, a| color * 6 + 5 - a),
        _ => return None,
    })
}
