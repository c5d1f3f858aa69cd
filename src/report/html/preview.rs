//! Interactive preview: the expected and received maps under a movable light.
//!
//! The script of the page evaluates the polynomial (1.0): with the stored values for the expected image, and with the
//! decoder's values for the received image.

use data_encoding::BASE64;
use maud::{Markup, html};

use ptm::decode::decode;
use ptm::{ColorMatrix, Ptm, Shape};
use ptm_suite::protocol::frame::{Frame, Samples, View, ViewKind};
use ptm_suite::{cases::Built, compare::Expected};

/// Maximum number of samples in a map with a preview. Larger maps have no preview.
const MAX_SAMPLES: usize = 24 << 10;

/// Renders a preview of `frame` and the expected map, unless the frame has a fixed light or a different shape or is too large.
pub(super) fn figure(built: &Built, frame: &Frame) -> Option<Markup> {
    let expected = Expected::new(&built.values, &View::Raw)?;
    let Samples::U8(stored) = expected.frame().samples else {
        return None;
    };
    let size = expected.size;
    let shape = (size.width, size.height, expected.channels as u32);
    if shape != (frame.width, frame.height, frame.channels) || stored.len() > MAX_SAMPLES {
        return None;
    }
    let Ptm { header, planes } = decode(&built.file).ok()?;
    let matrix = match planes.shape {
        Shape::Lum(ColorMatrix(elements)) => join_numbers(&elements),
        _ => String::new(),
    };
    let received = match &frame.samples {
        Samples::U8(samples) if frame.view == ViewKind::Raw => BASE64.encode(samples),
        Samples::U8(_) => return None,
        Samples::F32(samples) => {
            let bytes = samples.iter().flat_map(|value| value.to_le_bytes());
            BASE64.encode(&bytes.collect::<Vec<u8>>())
        }
    };
    Some(html! {
        figure.preview data-width=(frame.width) data-height=(frame.height) data-channels=(frame.channels)
            data-scale=(join_numbers(&header.scale_bias.scale)) data-bias=(join_numbers(&header.scale_bias.bias))
            data-matrix=(matrix) data-expected=(BASE64.encode(&stored)) data-kind=(frame.view) data-received=(received) {
            figcaption { "To move the light, drag over an image or use the sliders." }
        }
    })
}

fn join_numbers(values: &[f64]) -> String {
    let words: Vec<String> = values.iter().map(f64::to_string).collect();
    words.join(" ")
}
