//! A recognizable map as the decoder displays it: a checkered ball, lit from the upper left, with a red corner at the top left
//! and other colors in the other corners. It is requested for the HTML report and never judged.

use std::collections::BTreeSet;

use crate::session::asking::DecoderFn;
use ptm::decode::decode;
use ptm::evaluate::{Coefficients, polynomial};
use ptm::{Coding, Format, Ptm, Shape, Size};
use ptm_generate::{Model, Recipe, plan::Residuals, spelling::Count, write};
use ptm_suite::features::Feature;
use ptm_suite::protocol::frame::{Answer, Frame, Samples, View, ViewKind};
use ptm_suite::protocol::request::Request;
use ptm_suite::verdicts::offer::Offer;

/// Width and height in texels.
pub const SIDE: u32 = 64;
/// The light, from the upper left.
pub const LIGHT: (f64, f64) = (-0.5, 0.5);

/// Images of the scene under its light: red, green and blue of every texel, top row first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LitScene {
    /// The format of the requested file.
    pub format: Format,
    /// The view in which the file was requested.
    pub view: ViewKind,
    /// Correct image.
    pub correct: Vec<u8>,
    /// Received image.
    pub received: Vec<u8>,
}

impl LitScene {
    /// Renders the correct scene under the light (`lu`, `lv`).
    #[must_use]
    pub fn render(&self, lu: f64, lv: f64) -> Vec<u8> {
        let ptm = decode(&file(self.format, Count::default())).expect("the scene is a legal file");
        ptm.coefficients().evaluate(lu, lv).to_bytes()
    }
}

/// Requests the scene in a supported format and view. Returns `None` if no format or no view is supported, or if the request
/// fails.
#[must_use]
pub fn request(offer: &Offer, decoded: &BTreeSet<Feature>, ask: &DecoderFn) -> Option<LitScene> {
    let mut formats = Format::ALL.to_vec();
    formats.retain(|format| decoded.contains(&Feature::Format(*format)));
    // Prefer formats with the colors of the scene, then lossless ones, then ones without table or compression.
    let format = formats.into_iter().min_by_key(|&format| {
        let (is_lum, is_lossy) = (format == Format::Lum, format.coding() == Some(Coding::Jpeg));
        let is_encoded = (format.has_table(), format.coding().is_some());
        (is_lum, is_lossy, is_encoded, format.channels())
    })?;
    let mut views = [ViewKind::Rgb, ViewKind::Coef, ViewKind::Raw].into_iter();
    let view = views.find(|view| offer.views.contains(&view.name()))?;
    let asked = match view {
        ViewKind::Rgb => format!("rgb:{},{}", LIGHT.0, LIGHT.1),
        _ => view.name().to_owned(),
    };
    let asked: View = asked.parse().expect("a view");
    // lut-count: a decoder may support only one spelling of the count.
    let all = Count::ALL.len();
    let spellings = if format.has_table() { all } else { 1 };
    Count::ALL[..spellings].iter().find_map(|&count| {
        let file = file(format, count);
        let max_frame_bytes = (SIDE * SIDE) as usize * 18 * 4;
        let request = Request::new("lit-scene", &asked, &file, max_frame_bytes);
        let Answer::Decoded(frame) = ask(&request, 0).answer else {
            return None;
        };
        Some(LitScene {
            format,
            view,
            correct: render_scene(&decode(&file).ok()?.coefficients()),
            received: frame_to_image(&file, &frame)?,
        })
    })
}

fn render_scene(coefficients: &Coefficients) -> Vec<u8> {
    coefficients.evaluate(LIGHT.0, LIGHT.1).to_bytes()
}

/// Converts a frame of the scene's `file` to an image under the light, or returns `None` if the frame has a different shape.
#[must_use]
pub fn frame_to_image(file: &[u8], frame: &Frame) -> Option<Vec<u8>> {
    let Ptm { header, mut planes } = decode(file).ok()?;
    let channels = frame.view.channels(planes.shape.channels());
    if (frame.width, frame.height, frame.channels as usize) != (SIDE, SIDE, channels) {
        return None;
    }
    match &frame.samples {
        Samples::U8(bytes) if frame.view == ViewKind::Rgb => Some(bytes.clone()),
        Samples::U8(bytes) => {
            planes.samples.clone_from(bytes);
            Some(render_scene(&Ptm { header, planes }.coefficients()))
        }
        Samples::F32(values) => {
            let mut scene = Ptm { header, planes }.coefficients();
            scene.values = values.iter().map(|&value| value.into()).collect();
            Some(render_scene(&scene))
        }
    }
}

/// Encodes the scene as a file; `count` determines how the number of table entries is written.
#[must_use]
pub fn file(format: Format, count: Count) -> Vec<u8> {
    let map = ball(SIDE);
    let mut recipe = Recipe::default_for(format, map.size);
    recipe.scale = "2 2 2 2 2 2".parse().expect("numbers");
    recipe.bias = "128 128 128 128 128 128".parse().expect("numbers");
    recipe.spelling.count = count;
    recipe.compression.residuals = Residuals::Natural;
    if format.coding() == Some(Coding::Jpeg) {
        recipe.compression.parameter = 95;
    }
    recipe.matrix = "1 1 1 0 1 0 0 0 0 0 1 0 0 0 0 1".parse().expect("numbers");
    let stored = |coefficient: f64| (coefficient / 2.0 + 128.0).round() as u8;
    let mut samples: Vec<u8> = Vec::new();
    for texel in map.values.chunks_exact(9) {
        let (coefficients, color) = texel.split_first_chunk::<6>().expect("nine values");
        let by_channel = |color: &f64| coefficients.map(|a| stored(a * color / 255.0));
        match format.channels() {
            18 => samples.extend(color.iter().flat_map(by_channel)),
            8 => {
                // The luminance of LUM is the green value under the light of the scene; Cr and Cb are the excess of red and blue
                // over green. It has fewer colors than other formats, because these differences cannot be negative.
                let light = polynomial(coefficients, LIGHT.0, LIGHT.1).clamp(0.0, 255.0) / 255.0;
                let tint = |more: f64| (more.max(0.0) * light).round() as u8;
                samples.extend(by_channel(&color[1]));
                samples.extend([color[0], color[2]].map(|tinted| tint(tinted - color[1])));
            }
            _ => {
                samples.extend(coefficients.map(stored));
                samples.extend(color.iter().map(|&color| color as u8));
            }
        }
    }
    let model = Model::new(&recipe, &samples).expect("no table is needed");
    write(&recipe, &model).bytes
}

/// Returns the coefficients of the scene: four colored corners, and a checkered ball whose luminance is that of a matte surface,
/// based on the dot product of the normal and the light.
#[must_use]
pub fn ball(side: u32) -> Coefficients {
    let place = |at: u32| (f64::from(at) + 0.5) / f64::from(side) * 2.2 - 1.1;
    let texels = (0..side * side).flat_map(|i| texel(place(i % side), -place(i / side)));
    let (width, height) = (side, side);
    let (size, values) = (Size { width, height }, texels.collect());
    Coefficients {
        size,
        shape: Shape::Lrgb,
        values,
    }
}

fn texel(x: f64, y: f64) -> [f64; 9] {
    let above = 1.0 - x * x - y * y;
    if above < 0.0 {
        let (luminance, [red, green, blue]) = match x.abs() + y.abs() > 1.65 {
            false => (40.0, [90.0, 96.0, 104.0]),
            true if x < 0.0 && y > 0.0 => (230.0, [235.0, 40.0, 40.0]),
            true if y > 0.0 => (230.0, [60.0, 190.0, 80.0]),
            true if x > 0.0 => (230.0, [60.0, 100.0, 235.0]),
            true => (230.0, [240.0, 240.0, 240.0]),
        };
        return [0.0, 0.0, 0.0, 0.0, 0.0, luminance, red, green, blue];
    }
    let z = above.sqrt();
    let is_even = ((x * 5.0).floor() as i32 + (y * 5.0).floor() as i32) % 2 == 0;
    let [red, green, blue] = match is_even {
        true => [235.0, 150.0, 90.0],
        false => [120.0, 165.0, 210.0],
    };
    // The height of the light is √(1 − u² − v²), which is approximately 1 − (u² + v²) / 2.
    let (curve, height) = (-115.0 * z, 22.0 + 230.0 * z);
    let (across, up) = (230.0 * x, 230.0 * y);
    [curve, curve, 0.0, across, up, height, red, green, blue]
}

#[cfg(test)]
mod tests {
    use super::*;
    use ptm::Reading;
    use ptm_mistakes::answer;
    use ptm_suite::protocol::request::Reply;

    fn scene(view: ViewKind, format: Format, decoder: &DecoderFn) -> Option<LitScene> {
        let offer = Offer {
            views: vec![view.name()],
            ..Offer::default()
        };
        request(&offer, &BTreeSet::from([Feature::Format(format)]), decoder)
    }

    #[test]
    fn scene_is_equal_in_every_format_and_view() {
        let wanted = render_scene(&ball(SIDE));
        let reference = |request: &Request<'_>, _: usize| {
            Reply::from(answer(&[], Reading::SPEC, request.file, request.view))
        };
        for format in Format::ALL {
            for view in ViewKind::ALL {
                let scene = scene(view, format, &reference).expect("a scene");
                assert_eq!((scene.format, scene.view), (format, view));
                assert_eq!(scene.correct, scene.received);
                let pairs = wanted.iter().zip(&scene.correct);
                let far: u32 = pairs.map(|(a, b)| u32::from(a.abs_diff(*b))).sum();
                // LUM has no green corner, and bluish squares are brighter.
                let room = if format == Format::Lum { 24 } else { 6 };
                assert!(far / (3 * SIDE * SIDE) < room, "{format}: {far}");
            }
        }
    }

    #[test]
    fn refusals_and_wrong_shapes_give_no_scene() {
        let refusing = |_: &Request<'_>, _: usize| Reply::from(Answer::Rejected);
        assert_eq!(scene(ViewKind::Raw, Format::Lrgb, &refusing), None);
        let frame: Frame = Frame::read(b"PTM1 raw 1 1 9 u8\n123456789").expect("a frame");
        let small = move |_: &Request<'_>, _: usize| Answer::Decoded(frame.clone()).into();
        assert_eq!(scene(ViewKind::Raw, Format::Lrgb, &small), None);
        assert_eq!(request(&Offer::default(), &BTreeSet::new(), &small), None);
    }
}
