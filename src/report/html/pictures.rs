//! Planes side by side: expected, received, and their difference.
//!
//! - raw shows samples as gray levels, coef each plane from its minimum to its maximum, and rgb the colors.
//! - The difference is: raw, modulo 256; rgb, absolute; coef, as a fraction of the range of the plane.
//!   Differences within the tolerance are blank.

use maud::{Markup, html};

use crate::protocol::frame::{Frame, ViewKind};
use crate::ptm::channel_name;
use crate::report::html::compare::{Compared, png};
use crate::suite::compare::Expected;

/// Maximum number of columns and rows of a plane that are shown.
const MAX_SIDE: usize = 48;

/// The texels that are shown: columns and rows from `x` and `y`.
struct Window {
    x: usize,
    y: usize,
    width: usize,
    height: usize,
}

/// Two frames of one shape, compared sample by sample.
struct Pair<'a> {
    expected: &'a Expected,
    frame: &'a Frame,
    window: Window,
    /// For coef, the minimum and maximum of each plane in both frames.
    spans: Vec<(f64, f64)>,
}

/// Returns the images of a frame that differs from the expected one, first at texel and channel `spot`. None if the two cannot
/// be shown side by side.
pub(super) fn figure(
    expected: &Expected,
    frame: &Frame,
    spot: (usize, usize, usize),
) -> Option<Markup> {
    let channels = expected.channels;
    let pair = Pair::new(expected, frame, (spot.0, spot.1))?;
    if frame.view == ViewKind::Rgb && channels == 3 {
        return Some(pair.colored(spot));
    }
    let groups = match channels {
        18 => [0..6, 6..12, 12..18].to_vec(),
        _ => std::iter::once(0..channels).collect(),
    };
    let wrong: Vec<usize> = (0..channels).map(|channel| pair.wrong(channel)).collect();
    let (shown, equal): (Vec<_>, Vec<_>) = groups
        .into_iter()
        .partition(|group| wrong[group.clone()].iter().any(|&wrong| wrong > 0));
    let texels = expected.size.texels();
    let equal: Vec<&str> = equal
        .iter()
        .map(|group| ["red", "green", "blue"][group.start / 6 % 3])
        .collect();
    Some(html! {
        figure.planes {
            @for group in shown {
                (pair.table(group, &wrong, texels, spot))
            }
            (scale_of(frame.view))
            figcaption {
                (pair.part())
                @if !equal.is_empty() { "Every plane of " (equal.join(" and ")) " is as it should be. " }
                "The frame marks texel (" (spot.0) ", " (spot.1) "), the first that differs."
            }
        }
    })
}

impl<'a> Pair<'a> {
    fn new(expected: &'a Expected, frame: &'a Frame, spot: (usize, usize)) -> Option<Pair<'a>> {
        let (width, height) = (expected.size.width as usize, expected.size.height as usize);
        let alike = (frame.width, frame.height, frame.channels as usize)
            == (expected.size.width, expected.size.height, expected.channels);
        if !alike || frame.samples.len() != expected.size.texels() * expected.channels {
            return None;
        }
        // The texel in question is in the middle, as far as the edges allow.
        let from = |spot: usize, all: usize| {
            spot.saturating_sub(MAX_SIDE / 2)
                .min(all.saturating_sub(MAX_SIDE))
        };
        let mut pair = Pair {
            expected,
            frame,
            window: Window {
                x: from(spot.0, width),
                y: from(spot.1, height),
                width: width.min(MAX_SIDE),
                height: height.min(MAX_SIDE),
            },
            spans: Vec::new(),
        };
        if frame.view.sample_type() == "f32" {
            pair.spans = (0..expected.channels)
                .map(|channel| pair.span(channel))
                .collect();
        }
        Some(pair)
    }

    /// Returns the images in color.
    fn colored(&self, (x, y, _): (usize, usize, usize)) -> Markup {
        let Window { width, height, .. } = self.window;
        let texels = self.expected.size.texels();
        let places = (0..width * height).map(|i| (i % width, i / width));
        let color = |x: usize, y: usize, row: &str| {
            [0, 1, 2].map(|channel| self.texel(row, x, y, channel)[0])
        };
        let picture =
            |row: &str| -> Vec<u8> { places.clone().flat_map(|(x, y)| color(x, y, row)).collect() };
        let worst = |x: usize, y: usize| {
            let apart =
                (0..3).map(|channel| self.difference_at(self.place(x, y, channel), channel));
            heat(apart.fold(0.0, f64::max))
        };
        let pictures = Compared {
            width,
            height,
            expected: &picture(EXPECTED),
            received: &picture(RECEIVED),
            difference: Some(
                &places
                    .clone()
                    .flat_map(|(x, y)| worst(x, y))
                    .collect::<Vec<u8>>(),
            ),
        };
        html! {
            figure.colors {
                (pictures.markup(RECEIVED))
                (scale_of(ViewKind::Rgb))
                figcaption {
                    (self.part())
                    @for (channel, name) in ["red", "green", "blue"].into_iter().enumerate() {
                        @if channel > 0 { ", " } (name) " differs in " (self.wrong(channel))
                    }
                    " of " (texels) " texels; the first is (" (x) ", " (y) ")."
                }
            }
        }
    }

    /// Names the part of the image that is shown, if it is not all of it.
    fn part(&self) -> Markup {
        let Window {
            x,
            y,
            width,
            height,
        } = self.window;
        html! {
            @if width * height < self.expected.size.texels() {
                "Columns " (x) "–" (x + width - 1) " and rows " (y) "–" (y + height - 1) " of " (self.expected.size) ". "
            }
        }
    }

    fn received(&self, i: usize) -> f64 {
        self.frame.samples.real(i)
    }

    /// Returns the number of wrong samples in the whole plane.
    fn wrong(&self, channel: usize) -> usize {
        (0..self.expected.size.texels())
            .map(|texel| texel * self.expected.channels + channel)
            .filter(|&i| !self.expected.is_near(i, self.received(i)))
            .count()
    }

    /// Returns the index of the sample of a channel at a place in the window.
    fn place(&self, x: usize, y: usize, channel: usize) -> usize {
        let (x, y) = (self.window.x + x, self.window.y + y);
        (y * self.expected.size.width as usize + x) * self.expected.channels + channel
    }

    /// Returns the minimum and maximum finite value of a plane in both frames.
    fn span(&self, channel: usize) -> (f64, f64) {
        let texels = 0..self.expected.size.texels();
        let both = texels.flat_map(|texel| {
            let i = texel * self.expected.channels + channel;
            [self.expected.values[i], self.received(i)]
        });
        both.filter(|value| value.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                (low.min(value), high.max(value))
            })
    }

    fn gray(&self, value: f64, channel: usize) -> u8 {
        match self.spans.get(channel) {
            Some((low, high)) if high > low => ((value - low) / (high - low) * 255.0) as u8,
            Some(_) => 128,
            None => value.round() as u8,
        }
    }

    /// Returns the difference, from 0 (within tolerance) to 1.
    fn difference_at(&self, i: usize, channel: usize) -> f64 {
        let (expected, received) = (self.expected.values[i], self.received(i));
        if self.expected.is_near(i, received) {
            return 0.0;
        }
        let apart = (expected - received).abs();
        let part = match self.spans.get(channel) {
            Some((low, high)) => apart / (high - low),
            None if self.frame.view == ViewKind::Raw => apart.min(256.0 - apart) / 128.0,
            None => apart / 255.0,
        };
        // The smallest difference is visible, and a NaN has the largest one.
        if part.is_finite() {
            part.clamp(0.02, 1.0)
        } else {
            1.0
        }
    }

    /// Returns the color of a channel at a place in the window, in a row of the table.
    fn texel(&self, row: &str, x: usize, y: usize, channel: usize) -> [u8; 4] {
        let i = self.place(x, y, channel);
        let gray = |value: f64| {
            let gray = self.gray(value, channel);
            [gray, gray, gray, 255]
        };
        match row {
            EXPECTED => gray(self.expected.values[i]),
            RECEIVED => gray(self.received(i)),
            _ => heat(self.difference_at(i, channel)),
        }
    }

    /// Returns a table with a column for each plane of `group`.
    fn table(
        &self,
        group: std::ops::Range<usize>,
        wrong: &[usize],
        texels: usize,
        (x, y, channel): (usize, usize, usize),
    ) -> Markup {
        let Window { width, height, .. } = self.window;
        let scale = (52 / width).min(96 / height).clamp(1, 22);
        let pitch = (width + 1) * scale;
        let total = group.len() * (width + 1) - 1;
        let names: Vec<String> = group
            .clone()
            .map(|channel| channel_name(self.expected.channels, channel))
            .collect();
        let (first, last) = (&names[0], &names[names.len() - 1]);
        html! {
            table style={ "--pitch:" (pitch) "px" } {
                thead { tr {
                    @if let Some((_, of)) = first.rsplit_once(" of ") { th scope="colgroup" { (of) } } @else { td {} }
                    @for (name, channel) in names.iter().zip(group.clone()) {
                        @let count = wrong[channel];
                        th scope="col" .wrong[count > 0] title={ (name) ": " (count) " of " (texels) " samples differ" } {
                            (name.split(' ').next().unwrap_or_default())
                            small { @if count > 0 { "≠ " (count) } @else { "=" } }
                        }
                    }
                } }
                tbody {
                    @for row in [EXPECTED, RECEIVED, DIFFERENCE] {
                        @let pixels = self.strip(row, group.clone());
                        tr {
                            th scope="row" { (row) }
                            td colspan=(group.len()) { span.strip {
                                img width=(total * scale) height=(height * scale)
                                    alt={ (row) ", " (first) " to " (last) }
                                    src=(png(total, height, &pixels));
                                @if group.contains(&channel) {
                                    @let column = (channel - group.start) * (width + 1) + x - self.window.x;
                                    i.spot style={
                                        "left:" (column * scale) "px;top:" ((y - self.window.y) * scale) "px;width:"
                                        (scale) "px;height:" (scale) "px"
                                    } {}
                                }
                            } }
                        }
                    }
                }
            }
        }
    }

    /// Returns planes side by side, separated by an empty column, four bytes per texel.
    fn strip(&self, row: &str, group: std::ops::Range<usize>) -> Vec<u8> {
        let mut pixels = Vec::new();
        for y in 0..self.window.height {
            for channel in group.clone() {
                if channel > group.start {
                    pixels.extend([0; 4]);
                }
                for x in 0..self.window.width {
                    pixels.extend(self.texel(row, x, y, channel));
                }
            }
        }
        pixels
    }
}

const EXPECTED: &str = "expected";
const RECEIVED: &str = "received";
const DIFFERENCE: &str = "difference";

/// Explains the colors of a difference.
fn scale_of(view: ViewKind) -> Markup {
    let (least, most) = match view {
        ViewKind::Raw => ("1", "128, around the circle of 256 values"),
        _ if view.sample_type() == "u8" => ("1", "255"),
        _ => ("a little", "all that the plane spans"),
    };
    html! { p.heat { "difference " (least) " " i {} " " (most) "; blank: near enough" } }
}

/// Returns transparent for 0, then from amber over red to violet, which is visible in light and dark mode.
fn heat(apart: f64) -> [u8; 4] {
    if apart <= 0.0 {
        return [0; 4];
    }
    let stops = [
        [250.0, 178.0, 60.0],
        [226.0, 62.0, 48.0],
        [124.0, 30.0, 150.0],
    ];
    let (from, to, part) = if apart < 0.5 {
        (stops[0], stops[1], apart * 2.0)
    } else {
        (stops[1], stops[2], apart * 2.0 - 1.0)
    };
    let mix = |i: usize| (from[i] + (to[i] - from[i]) * part) as u8;
    [mix(0), mix(1), mix(2), 255]
}
