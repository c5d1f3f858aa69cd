//! A recognizable map as the decoder displays it: a glossy checkered ball, lit from the upper left, with a red corner at the top
//! left and other colors in the other corners. It is requested for the HTML report and never judged.
//!
//! Every coefficient is visible in it: the gloss makes a0, a1 and a2 differ, and the light has u·v ≠ 0 and u² ≠ v². Each
//! coefficient has its own scale and bias.

use std::collections::BTreeSet;

use crate::session::asking::DecoderFn;
use ptm::decode::decode;
use ptm::evaluate::{Coefficients, polynomial};
use ptm::{Coding, Format, Ptm, Shape, Size};
use ptm_generate::plan::{Residuals, Structure};
use ptm_generate::{INVERSION, MOTION, Model, Recipe, spelling::Count, write};
use ptm_suite::features::Feature;
use ptm_suite::protocol::frame::{Answer, Frame, Samples, View, ViewKind};
use ptm_suite::protocol::request::Request;
use ptm_suite::verdicts::offer::Offer;

/// Width and height in texels.
pub const SIDE: u32 = 65;
/// The light, from the upper left.
pub const LIGHT: (f64, f64) = (-0.625, 0.375);

/// Images of the scene under its light: red, green and blue of every texel, top row first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LitScene {
    /// The requested file.
    pub file: SceneFile,
    /// The view in which the file was requested.
    pub view: ViewKind,
    /// Correct image.
    pub correct: Vec<u8>,
    /// Received image.
    pub received: Vec<u8>,
}

/// An encoding of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SceneFile {
    /// The format.
    pub format: Format,
    /// How the number of table entries is written.
    pub count: Count,
    /// True if planes are predicted from inverted and displaced planes. Always false in uncompressed formats.
    pub is_predicted: bool,
}

/// Smallest difference of a color, of 255, that is visible.
const VISIBLE_DIFFERENCE: u8 = 16;

/// Share of the texels that must differ visibly: one in this many.
const VISIBLE_SHARE: usize = 100;

impl LitScene {
    /// Renders the correct scene under the light (`lu`, `lv`).
    #[must_use]
    pub fn render(&self, lu: f64, lv: f64) -> Vec<u8> {
        let ptm = decode(&self.file.bytes()).expect("the scene is a legal file");
        ptm.coefficients().evaluate(lu, lv).to_bytes()
    }

    /// Returns true if the received image is visibly wrong: a color of at least 1 % of the texels is off by at least 16 of 255.
    #[must_use]
    pub fn is_visibly_wrong(&self) -> bool {
        differ_visibly(&self.correct, &self.received)
    }
}

/// Returns true if a color of at least 1 % of the texels of two images differs by at least 16 of 255.
#[must_use]
pub fn differ_visibly(a: &[u8], b: &[u8]) -> bool {
    let texels = || a.chunks(3).zip(b.chunks(3));
    let is_visible = |(a, b): &(&[u8], &[u8])| {
        let mut colors = a.iter().zip(*b);
        colors.any(|(a, b)| a.abs_diff(*b) >= VISIBLE_DIFFERENCE)
    };
    texels().filter(is_visible).count() * VISIBLE_SHARE >= texels().count()
}

/// Returns all formats. Formats with the colors of the scene come first, then lossless ones, then ones without table or compression.
#[must_use]
pub fn formats_by_fidelity() -> Vec<Format> {
    let mut formats = Format::ALL.to_vec();
    formats.sort_by_key(|&format| {
        let (is_lum, is_lossy) = (format == Format::Lum, format.coding() == Some(Coding::Jpeg));
        let is_encoded = (format.has_table(), format.coding().is_some());
        (is_lum, is_lossy, is_encoded, format.channels())
    });
    formats
}

/// Requests the scene in every supported format until it is visibly wrong. Returns the first visibly wrong scene, or the first scene
/// if none is. Returns `None` if no format or no view is supported, or if every request fails.
#[must_use]
pub fn request(offer: &Offer, decoded: &BTreeSet<Feature>, ask: &DecoderFn) -> Option<LitScene> {
    let mut formats = formats_by_fidelity();
    formats.retain(|format| decoded.contains(&Feature::Format(*format)));
    let mut views = [ViewKind::Rgb, ViewKind::Coef, ViewKind::Raw].into_iter();
    let view = views.find(|view| offer.views.contains(&view.name()))?;
    let asked = match view {
        ViewKind::Rgb => format!("rgb:{},{}", LIGHT.0, LIGHT.1),
        _ => view.name().to_owned(),
    };
    let asked: View = asked.parse().expect("a view");
    let mut first = None;
    for format in formats {
        for files in SceneFile::all(format) {
            let mut spelled = files.iter();
            let Some(scene) = spelled.find_map(|&file| request_file(file, &asked, ask)) else {
                continue;
            };
            if scene.is_visibly_wrong() {
                return Some(scene);
            }
            first.get_or_insert(scene);
        }
    }
    first
}

fn request_file(file: SceneFile, view: &View, ask: &DecoderFn) -> Option<LitScene> {
    let bytes = file.bytes();
    let max_frame_bytes = (SIDE * SIDE) as usize * 18 * 4;
    let request = Request::new("lit-scene", view, &bytes, max_frame_bytes);
    let Answer::Decoded(frame) = ask(&request, 0).answer else {
        return None;
    };
    Some(LitScene {
        file,
        view: view.kind(),
        correct: render_scene(&decode(&bytes).ok()?.coefficients()),
        received: frame_to_image(&bytes, &frame)?,
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

impl SceneFile {
    /// Returns the files of a format. Each group contains one encoding, in every spelling that a decoder may choose to support.
    #[must_use]
    pub fn all(format: Format) -> Vec<Vec<SceneFile>> {
        // lut-count: a decoder may support only one spelling of the count.
        let spellings = if format.has_table() {
            &Count::ALL[..]
        } else {
            &Count::ALL[..1]
        };
        let predicted: &[bool] = if format.coding().is_some() {
            &[false, true]
        } else {
            &[false]
        };
        let group = |&is_predicted: &bool| {
            let file = |&count: &Count| SceneFile {
                format,
                count,
                is_predicted,
            };
            spellings.iter().map(file).collect()
        };
        predicted.iter().map(group).collect()
    }

    /// Encodes the scene.
    #[must_use]
    pub fn bytes(&self) -> Vec<u8> {
        let (format, map) = (self.format, ball(SIDE));
        let mut recipe = Recipe::default_for(format, map.size);
        let written = |numbers: &[f64]| {
            numbers
                .iter()
                .map(f64::to_string)
                .collect::<Vec<_>>()
                .join(" ")
        };
        recipe.scale = written(&SCALE).parse().expect("numbers");
        recipe.bias = written(&BIAS).parse().expect("numbers");
        recipe.spelling.count = self.count;
        recipe.compression.residuals = Residuals::Natural;
        if format.coding() == Some(Coding::Jpeg) {
            recipe.compression.parameter = 95;
        }
        if self.is_predicted {
            let plan = &mut recipe.compression;
            plan.set_structure(Structure::Upward);
            // Lossy residuals allow no displacement (motion-half).
            let transforms = match plan.coding {
                Coding::Jpeg => [INVERSION, 0, INVERSION],
                Coding::JpegLs => [INVERSION, MOTION, INVERSION | MOTION],
            };
            plan.transforms = plan.cycle(&transforms, false);
            if plan.coding == Coding::JpegLs {
                (plan.motion_x, plan.motion_y) =
                    (plan.cycle(&[9, -7], false), plan.cycle(&[-5, 6], false));
            }
        }
        recipe.matrix = written(&MATRIX).parse().expect("numbers");
        let stored = |channel: usize, coefficient: f64| {
            (coefficient / SCALE[channel] + BIAS[channel]).round() as u8
        };
        let mut samples: Vec<u8> = Vec::new();
        for texel in map.values.chunks_exact(9) {
            let (coefficients, color) = texel.split_first_chunk::<6>().expect("nine values");
            let by_channel =
                |color: f64| (0..6).map(move |i| stored(i, coefficients[i] * color / 255.0));
            match format.channels() {
                18 => samples.extend(color.iter().flat_map(|&color| by_channel(color))),
                8 => {
                    // The luminance of LUM is the green value under the light of the scene; Cr and Cb are the excess of red and blue
                    // over green, minus the translation of the matrix, divided by its element. LUM has fewer colors than other formats,
                    // because the excess cannot be negative.
                    let light =
                        polynomial(coefficients, LIGHT.0, LIGHT.1).clamp(0.0, 255.0) / 255.0;
                    let tint = |more: f64, element: f64, translation: f64| {
                        ((more.max(0.0) * light - translation) / element).round() as u8
                    };
                    samples.extend(by_channel(color[1]));
                    samples.extend([
                        tint(color[0] - color[1], MATRIX[4], MATRIX[12]),
                        tint(color[2] - color[1], MATRIX[10], MATRIX[14]),
                    ]);
                }
                _ => {
                    samples.extend(by_channel(255.0));
                    samples.extend(color.iter().map(|&color| color as u8));
                }
            }
        }
        let model = Model::new(&recipe, &samples).expect("no table is needed");
        write(&recipe, &model).bytes
    }

    /// Returns the format, and that planes are predicted if they are.
    #[must_use]
    pub fn name(&self) -> String {
        let predicted = if self.is_predicted {
            " with predicted planes"
        } else {
            ""
        };
        format!("{}{predicted}", self.format.short_name())
    }
}

/// Scales of the coefficients. No two adjacent ones are equal.
const SCALE: [f64; 6] = [2.0, 2.25, 2.0, 2.5, 2.75, 2.25];

/// Biases of the coefficients.
const BIAS: [f64; 6] = [140.0, 120.0, 128.0, 125.0, 131.0, 20.0];

/// Color matrix of LUM: luminance plus Cr in red, luminance in green, and luminance plus Cb in blue, with translations.
const MATRIX: [f64; 16] = [
    1.0, 1.0, 1.0, 0.0, 0.75, 0.0, 0.0, 0.0, 0.0, 0.0, 0.75, 0.0, -30.0, 0.0, -20.0, 1.0,
];

/// Returns the coefficients of the scene: four colored corners, and a checkered ball. Its luminance is that of a matte and glossy
/// surface: a sum of the dot product of the normal and the light, and of the square of this product.
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

/// Brightness of the matte part of the surface.
const MATTE: f64 = 130.0;

/// Brightness of the gloss.
const GLOSS: f64 = 180.0;

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
    // The height of the light is √(1 − u² − v²). It is approximately 1 − (u² + v²) / 2 in the dot product, and 1 in the square's
    // linear terms.
    let curve = |along: f64| GLOSS * (along * along - z * z) - MATTE * z / 2.0;
    let slope = |along: f64| MATTE * along + 2.0 * GLOSS * along * z;
    let height = 20.0 + MATTE * z + GLOSS * z * z;
    [
        curve(x),
        curve(y),
        2.0 * GLOSS * x * y,
        slope(x),
        slope(y),
        height,
        red,
        green,
        blue,
    ]
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
                assert_eq!((scene.file.format, scene.view), (format, view));
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
