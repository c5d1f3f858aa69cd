//! Image at the top of the page: a lit ball as rendered by the decoder, with a description of the visible mistake.

use maud::{Markup, html};

use crate::report::html::compare::ComparedImages;
use ptm_harness::session::lit_scene::{LIGHT, LitScene, SIDE, differ_visibly};

/// Renders the received scene next to the correct one.
pub(super) fn figure(scene: &LitScene) -> Markup {
    let side = SIDE as usize;
    let images = ComparedImages {
        width: side,
        height: side,
        expected: &scene.correct,
        received: &scene.received,
        difference: None,
    };
    html! {
        figure.scene {
            (images.markup("this decoder"))
            figcaption {
                b { (describe_fault(scene)) } " The scene is a ball that is lit from the upper left, in " (scene.file.name())
                ", requested as " code { (scene.view) } ". The scene is for illustration and is not judged."
            }
        }
    }
}

/// Index of the last row and column.
const LAST_INDEX: usize = SIDE as usize - 1;

/// Common transforms of the image, each with the source of every column, row and channel, and a description.
const IMAGE_TRANSFORMS: &str = "\
x -y rgb: The image is upside down.
-x y rgb: The image is mirrored.
-x -y rgb: The image is rotated by 180°.
y x rgb: Rows and columns are swapped.
x y bgr: Red and blue are swapped.
x y grb: Red and green are swapped.
x y rbg: Green and blue are swapped.
x -y bgr: The image is upside down, and red and blue are swapped.
";

/// Common changes to the light direction, each with the new u and v, and a description.
const LIGHT_CHANGES: &str = "\
u -v: The image is lit from below, so v points down.
-u v: The image is lit from the right, so u points to the left.
-u -v: The image is lit from the lower right, so u and v are both negated.
";

/// Describes the visible mistake in the received image.
fn describe_fault(scene: &LitScene) -> &'static str {
    let (right, received) = (&scene.correct, &scene.received);
    if right == received {
        return "This decoder shows the scene correctly.";
    }
    if !scene.is_visibly_wrong() {
        return "This decoder shows the scene almost correctly.";
    }
    let side = SIDE as usize;
    for line in IMAGE_TRANSFORMS.lines().chain(LIGHT_CHANGES.lines()) {
        let (from, says) = line.split_once(": ").expect("every line has a description");
        let words: Vec<&str> = from.split(' ').collect();
        let byte = |i: usize| {
            let place = |word: &str| match word.trim_start_matches('-') {
                "x" => i / 3 % side,
                _ => i / 3 / side,
            };
            let source = |word: &str| match word.starts_with('-') {
                true => LAST_INDEX - place(word),
                false => place(word),
            };
            let channel = words[2].as_bytes()[i % 3];
            let channel = b"rgb".iter().position(|name| *name == channel);
            right[3 * (source(words[1]) * side + source(words[0])) + channel.unwrap_or_default()]
        };
        let sign = |word: &str| if word.starts_with('-') { -1.0 } else { 1.0 };
        let image: Vec<u8> = match words.len() {
            2 => scene.render(sign(words[0]) * LIGHT.0, sign(words[1]) * LIGHT.1),
            _ => (0..right.len()).map(byte).collect(),
        };
        if !differ_visibly(&image, received) {
            return says;
        }
    }
    let mean = |image: &[u8]| image.iter().map(|&byte| f64::from(byte)).sum::<f64>();
    match mean(received) / mean(right) {
        ..0.85 => "The image is too dark, at least in part.",
        1.15.. => "The image is too bright, at least in part.",
        _ => "The image is wrong.",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ptm::Format;
    use ptm_harness::session::lit_scene::SceneFile;
    use ptm_suite::protocol::frame::ViewKind;

    #[test]
    fn visible_faults_are_described() {
        fn times(scene: &LitScene, factor: f64) -> Vec<u8> {
            let times = |&byte: &u8| (f64::from(byte) * factor) as u8;
            scene.correct.iter().map(times).collect()
        }
        let changes: [(&str, fn(&LitScene) -> Vec<u8>); 6] = [
            ("correctly.", |scene| scene.correct.clone()),
            ("upside down.", |scene| {
                let rows = scene.correct.chunks(3 * SIDE as usize).rev();
                rows.flatten().copied().collect()
            }),
            ("Red and blue", |scene| {
                let texels = scene.correct.chunks(3);
                texels.flat_map(|rgb| [rgb[2], rgb[1], rgb[0]]).collect()
            }),
            ("lit from below", |scene| scene.render(LIGHT.0, -LIGHT.1)),
            ("too dark", |scene| times(scene, 0.5)),
            ("too bright", |scene| times(scene, 2.0)),
        ];
        for format in [Format::Lrgb, Format::Lum, Format::PtmCLut, Format::JpegRgb] {
            for (says, change) in changes {
                let mut scene = LitScene {
                    file: SceneFile::all(format)[0][0],
                    view: ViewKind::Rgb,
                    correct: Vec::new(),
                    received: Vec::new(),
                };
                scene.correct = scene.render(LIGHT.0, LIGHT.1);
                scene.received = change(&scene);
                let text = describe_fault(&scene);
                assert!(text.contains(says), "{format}: {says}: {text}");
            }
        }
    }
}
