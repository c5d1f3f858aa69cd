//! Images of planes side by side: the expected one, the received one, and the difference between the two.
//!
//! - The raw view is displayed as gray levels, rgb in color, and coef as gray levels scaled to the range of each plane.
//! - The difference is modulo 256 for raw, absolute for rgb, and a fraction of the range of the plane for coef. Differences
//!   within the tolerance are blank.

use std::ops::Range;

use maud::{Markup, html};

use crate::report::html::compare::{ComparedImages, png_data_url};
use ptm::channel_name;
use ptm_suite::compare::Expected;
use ptm_suite::protocol::frame::{Frame, ViewKind};

/// Maximum number of displayed columns and rows of a plane.
const MAX_SIDE: usize = 48;

/// Position of a sample: column, row and channel.
pub(super) type Position = (usize, usize, usize);

/// Two frames of the same shape that are compared sample by sample.
struct ImageComparison<'a> {
    expected: &'a Expected,
    received: Vec<f64>,
    /// Position of the first difference.
    position: Position,
    /// Columns that are displayed.
    columns: Range<usize>,
    /// Rows that are displayed.
    rows: Range<usize>,
    /// Minimum and maximum of each plane over both frames, for views with real-valued samples.
    spans: Vec<(f64, f64)>,
}

/// Renders the images of a frame whose first difference from the expected frame is at `position`. Returns `None` if the shapes
/// differ.
pub(super) fn figure(expected: &Expected, frame: &Frame, position: Position) -> Option<Markup> {
    let (width, height, channels) = (frame.width, frame.height, frame.channels as usize);
    let received = frame.samples.to_reals();
    if (width, height, channels) != (expected.size.width, expected.size.height, expected.channels)
        || received.len() != expected.values.len()
    {
        return None;
    }
    // Center the texel as far as the edges allow.
    let shown = |center: usize, all: u32| {
        let (start, all) = (center.saturating_sub(MAX_SIDE / 2), all as usize);
        let from = start.min(all.saturating_sub(MAX_SIDE));
        from..all.min(from + MAX_SIDE)
    };
    let mut pair = ImageComparison {
        expected,
        received,
        position,
        columns: shown(position.0, width),
        rows: shown(position.1, height),
        spans: Vec::new(),
    };
    if expected.view.sample_type() == "f32" {
        pair.spans = (0..channels).map(|channel| pair.span(channel)).collect();
    }
    Some(match expected.view {
        ViewKind::Rgb if channels == 3 => pair.color_images(),
        _ => pair.planes(),
    })
}

impl ImageComparison<'_> {
    fn color_images(&self) -> Markup {
        let row = |y| self.columns.clone().map(move |x| (x, y));
        let positions = || self.rows.clone().flat_map(row);
        let image = |row: &str| -> Vec<u8> {
            let color = |(x, y)| [0, 1, 2].map(|channel| self.texel_color(row, x, y, channel)[0]);
            positions().flat_map(color).collect()
        };
        let worst = |(x, y)| {
            let difference = (0..3).map(|channel| self.difference_at(x, y, channel));
            heat_color(difference.fold(0.0, f64::max))
        };
        let images = ComparedImages {
            width: self.columns.len(),
            height: self.rows.len(),
            expected: &image(EXPECTED),
            received: &image(RECEIVED),
            difference: Some(&positions().flat_map(worst).collect::<Vec<u8>>()),
        };
        html! {
            figure.colors {
                (images.markup(RECEIVED))
                (self.color_scale())
                figcaption {
                    (self.cropped_area())
                    @for (channel, name) in COLORS.into_iter().enumerate() {
                        @if channel > 0 { ", " } (name) " differs in " (self.wrong_count(channel))
                    }
                    " of " (self.expected.size.texels()) " texels; the first is (" (self.position.0) ", " (self.position.1) ")."
                }
            }
        }
    }

    /// Renders the planes, one table per color. Colors without a difference are only named in the caption.
    fn planes(&self) -> Markup {
        let channels = self.expected.channels;
        let wrong: Vec<usize> = ((0..channels).map(|channel| self.wrong_count(channel))).collect();
        let each = if channels == 18 { 6 } else { channels };
        let groups = (0..channels).step_by(each).map(|from| from..from + each);
        let (shown, equal): (Vec<_>, Vec<_>) =
            groups.partition(|group| wrong[group.clone()].iter().any(|&wrong| wrong > 0));
        let color = |group: &Range<usize>| COLORS[group.start / 6 % 3];
        let equal: Vec<&str> = equal.iter().map(color).collect();
        html! {
            figure.planes {
                @for group in shown { (self.table(&group, &wrong)) }
                (self.color_scale())
                figcaption {
                    (self.cropped_area())
                    @if !equal.is_empty() { "Every plane of " (equal.join(" and ")) " is correct. " }
                    "The frame marks texel (" (self.position.0) ", " (self.position.1) "), the first texel that differs."
                }
            }
        }
    }

    /// Describes the displayed part of the image if the image is cropped.
    fn cropped_area(&self) -> Markup {
        let ImageComparison { columns, rows, .. } = self;
        html! {
            @if columns.len() * rows.len() < self.expected.size.texels() {
                "Columns " (columns.start) "–" (columns.end - 1) " and rows " (rows.start) "–" (rows.end - 1) " of " (self.expected.size) ". "
            }
        }
    }

    /// Renders the legend of the difference colors.
    fn color_scale(&self) -> Markup {
        let (least, most) = match self.expected.view {
            ViewKind::Raw => ("1", "128, modulo 256"),
            view if view.sample_type() == "u8" => ("1", "255"),
            _ => ("small", "the range of the plane"),
        };
        html! { p.heat { "difference " (least) " " i {} " " (most) "; blank: within the tolerance" } }
    }

    fn plane_indices(&self, channel: usize) -> impl Iterator<Item = usize> {
        (channel..self.received.len()).step_by(self.expected.channels)
    }

    /// Returns the number of wrong samples in a plane.
    fn wrong_count(&self, channel: usize) -> usize {
        let is_wrong = |&i: &usize| !self.expected.is_near(i, self.received[i]);
        self.plane_indices(channel).filter(is_wrong).count()
    }

    /// Returns the minimum and maximum finite values of a plane over both frames.
    fn span(&self, channel: usize) -> (f64, f64) {
        let values = |i: usize| [self.expected.values[i], self.received[i]];
        let both = self.plane_indices(channel).flat_map(values);
        let nothing = (f64::INFINITY, f64::NEG_INFINITY);
        both.filter(|value| value.is_finite())
            .fold(nothing, |(low, high), value| {
                (low.min(value), high.max(value))
            })
    }

    fn sample_index(&self, x: usize, y: usize, channel: usize) -> usize {
        (y * self.expected.size.width as usize + x) * self.expected.channels + channel
    }

    /// Returns the relative difference of a sample, from 0 (within tolerance) to 1.
    fn difference_at(&self, x: usize, y: usize, channel: usize) -> f64 {
        let i = self.sample_index(x, y, channel);
        let (expected, received) = (self.expected.values[i], self.received[i]);
        if self.expected.is_near(i, received) {
            return 0.0;
        }
        let apart = (expected - received).abs();
        let part = match self.spans.get(channel) {
            Some((low, high)) => apart / (high - low),
            None if self.expected.view == ViewKind::Raw => apart.min(256.0 - apart) / 128.0,
            None => apart / 255.0,
        };
        // Keep small differences visible, and treat NaN as the largest difference.
        let part = if part.is_finite() { part } else { 1.0 };
        part.clamp(0.02, 1.0)
    }

    /// Returns the RGBA color of a sample in the given row of the table.
    fn texel_color(&self, row: &str, x: usize, y: usize, channel: usize) -> [u8; 4] {
        let i = self.sample_index(x, y, channel);
        let value = match row {
            EXPECTED => self.expected.values[i],
            RECEIVED => self.received[i],
            _ => return heat_color(self.difference_at(x, y, channel)),
        };
        let gray = match self.spans.get(channel) {
            Some((low, high)) if high > low => ((value - low) / (high - low) * 255.0) as u8,
            Some(_) => 128,
            None => value.round() as u8,
        };
        [gray, gray, gray, 255]
    }

    /// Renders a table with one column per plane of `group`.
    fn table(&self, group: &Range<usize>, wrong: &[usize]) -> Markup {
        let (x, y, channel) = self.position;
        let (width, height) = (self.columns.len(), self.rows.len());
        let scale = (52 / width).min(96 / height).clamp(1, 22);
        let pitch = (width + 1) * scale;
        let total = group.len() * (width + 1) - 1;
        let name = |channel| channel_name(self.expected.channels, channel);
        let (first, last) = (name(group.start), name(group.end - 1));
        html! {
            table style={ "--pitch:" (pitch) "px" } {
                thead { tr {
                    @if let Some((_, of)) = first.rsplit_once(" of ") { th scope="colgroup" { (of) } } @else { td {} }
                    @for channel in group.clone() {
                        @let (name, count) = (name(channel), wrong[channel]);
                        th scope="col" .wrong[count > 0] title={ (name) ": " (count) " of " (self.expected.size.texels()) " samples differ" } {
                            (name.split(' ').next().unwrap_or_default())
                            small { @if count > 0 { "≠ " (count) } @else { "=" } }
                        }
                    }
                } }
                tbody {
                    @for row in [EXPECTED, RECEIVED, DIFFERENCE] {
                        tr {
                            th scope="row" { (row) }
                            td colspan=(group.len()) { span.strip {
                                img width=(total * scale) height=(height * scale)
                                    alt={ (row) ", " (first) " to " (last) }
                                    src=(png_data_url(total, height, &self.strip(row, group)));
                                @if group.contains(&channel) {
                                    @let column = (channel - group.start) * (width + 1) + x - self.columns.start;
                                    i.spot style={
                                        "left:" (column * scale) "px;top:" ((y - self.rows.start) * scale) "px;width:"
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

    /// Returns the RGBA texels of the planes in `group`, placed side by side with an empty column between neighbors.
    fn strip(&self, row: &str, group: &Range<usize>) -> Vec<u8> {
        let mut pixels = Vec::new();
        for y in self.rows.clone() {
            for channel in group.clone() {
                if channel > group.start {
                    pixels.extend([0; 4]);
                }
                let texel = |x| self.texel_color(row, x, y, channel);
                pixels.extend(self.columns.clone().flat_map(texel));
            }
        }
        pixels
    }
}

const COLORS: [&str; 3] = ["red", "green", "blue"];

const EXPECTED: &str = "expected";
const RECEIVED: &str = "received";
const DIFFERENCE: &str = "difference";

/// Maps a difference to an RGBA color: transparent for 0, then amber, red and violet, which are visible in light and dark mode.
fn heat_color(difference: f64) -> [u8; 4] {
    if difference <= 0.0 {
        return [0; 4];
    }
    let stops = [[250, 178, 60], [226, 62, 48], [124, 30, 150]];
    let stop = usize::from(difference >= 0.5);
    let part = difference * 2.0 - stop as f64;
    let [from, to] = [stops[stop], stops[stop + 1]].map(|color| color.map(f64::from));
    let mix = |i: usize| (from[i] + (to[i] - from[i]) * part) as u8;
    [mix(0), mix(1), mix(2), 255]
}
