//! Objects that can be relit in the page, alone or side by side under one dial.
//!
//! Each object is a file with the images of the scene under a grid of lights. The script of the site blends the images of the
//! nearest lights. Without scripts, the page shows the image under one light.

use std::collections::{BTreeMap, HashMap};

use image::codecs::jpeg::JpegEncoder;
use image::{RgbImage, imageops};
use maud::{Markup, html};

use super::page::{PageContext, SiteFile};
use super::texture_objects::TextureObjects;
use ptm::decode::decode;
use ptm::reading::Reading;
use ptm::{Format, Ptm};
use ptm_files::render::render_lit;
use ptm_harness::diagnose::can_affect_file;
use ptm_harness::session::lit_scene::{self, SceneFile, ball, differ_visibly};
use ptm_mistakes::Misreading;
use ptm_suite::choices::CHOICES;
use ptm_suite::kit::digest::sha256;
use ptm_suite::kit::parallel::map_in_parallel;
use ptm_suite::protocol::frame::{Answer, Samples, View};

/// Number of lights in each row and column of the grid. The script of the site uses the same number.
pub(super) const GRID: usize = 5;
/// Length of the longest light vectors. The script of the site uses the same number.
const MAX_LENGTH: f64 = 0.98;
/// Light of the still image, from the upper left: its index in the grid, row by row.
pub(super) const UPPER_LEFT: usize = GRID + 1;
/// Lights under which a mistake is searched for. A mistake that swaps or negates u and v is visible under one of them.
const SEARCHED: [usize; 3] = [UPPER_LEFT, 2 * GRID + 4, 3 * GRID + 2];
/// Width and height of the object on the home page, in texels.
const HOME_SIDE: u32 = 160;
/// Quality of the JPEG files.
const QUALITY: u8 = 75;
/// Side of a JPEG block. Images start at multiples of it, so that they do not affect each other.
const BLOCK: u32 = 8;

/// Returns light `index` of the grid. The grid is a square that is mapped to the unit disk.
pub(super) fn light(index: usize) -> (f64, f64) {
    let place = |i: usize| 2.0 * i as f64 / (GRID - 1) as f64 - 1.0;
    let (s, t) = (place(index % GRID), -place(index / GRID));
    let along = |a: f64, b: f64| MAX_LENGTH * a * (1.0 - b * b / 2.0).sqrt();
    (along(s, t), along(t, s))
}

fn view(index: usize) -> View {
    let (lu, lv) = light(index);
    format!("rgb:{lu:.4},{lv:.4}").parse().expect("a light")
}

/// The objects of the site.
pub(super) struct Objects {
    /// Files of the objects, by path.
    files: BTreeMap<String, Vec<u8>>,
    scenes: Vec<Scene>,
    home: [String; 2],
    misreadings: HashMap<&'static str, Comparison>,
    readers: HashMap<String, Comparison>,
    /// For each ruling of kind choice, its readings that visibly change the object.
    choices: HashMap<&'static str, Vec<(&'static str, Comparison)>>,
    pub(super) textures: TextureObjects,
}

/// A file of the scene, and its correct images.
struct Scene {
    file: SceneFile,
    bytes: Vec<u8>,
    images: Vec<Vec<u8>>,
    path: String,
}

/// An object as a decoder with mistakes shows it.
struct Comparison {
    /// Index of the scene.
    scene: usize,
    /// Path of the file with the images.
    path: String,
    /// Index of the light of the still image.
    still: usize,
}

impl Comparison {
    /// Adds the file of a comparison.
    fn new(files: &mut BTreeMap<String, Vec<u8>>, compared: Compared) -> Comparison {
        let Compared {
            scene,
            still,
            sprite,
        } = compared;
        let path = put(files, sprite);
        Comparison { scene, path, still }
    }
}

/// A visible difference: the index of the scene, the index of the light that shows it, and the file with the images.
struct Compared {
    scene: usize,
    still: usize,
    sprite: Vec<u8>,
}

/// A reader whose images are rendered.
pub(super) struct ShownReader {
    pub name: String,
    /// Mistakes, and readings of open questions.
    pub behaviors: Vec<&'static Misreading>,
    /// Formats that the reader supports.
    pub formats: Vec<Format>,
}

impl Objects {
    /// Renders the scene as shown by a decoder with each misreading. Misreadings that do not visibly change the scene are omitted.
    pub(super) fn render(jobs: usize) -> Objects {
        let mut files = BTreeMap::new();
        let map = ball(HOME_SIDE);
        let home = [1.0, -1.0].map(|sign| {
            let images = (0..GRID * GRID).map(|index| {
                let (lu, lv) = light(index);
                render_lit(&map, lu, sign * lv).into_raw()
            });
            put(&mut files, sprite(HOME_SIDE, &images.collect::<Vec<_>>()))
        });
        let scene_files: Vec<SceneFile> = lit_scene::formats_by_fidelity()
            .into_iter()
            .flat_map(SceneFile::all)
            .map(|spellings| spellings[0])
            .collect();
        let rendered = map_in_parallel(scene_files.len(), jobs, &|_, _| (), &|i| {
            let bytes = scene_files[i].bytes();
            let ptm = decode(&bytes).expect("the scene is a legal file");
            let images = render_all(&[], &Reading::SPEC, &ptm).expect("the scene has colors");
            let sprite = sprite(lit_scene::SIDE, &images);
            (bytes, images, sprite)
        });
        let scenes: Vec<Scene> = scene_files
            .into_iter()
            .zip(rendered)
            .map(|(file, (bytes, images, sprite))| Scene {
                file,
                bytes,
                images,
                path: put(&mut files, sprite),
            })
            .collect();
        let all: Vec<&'static Misreading> = ptm_mistakes::all().collect();
        let compared = map_in_parallel(all.len(), jobs, &|_, _| (), &|i| {
            compare(&scenes, &[all[i]], Reading::SPEC, |scene| {
                can_affect_file(all[i], &scene.bytes)
            })
        });
        let misreadings = all
            .iter()
            .zip(compared)
            .filter_map(|(misreading, compared)| {
                Some((misreading.slug, Comparison::new(&mut files, compared?)))
            })
            .collect();
        let readings: Vec<_> = CHOICES
            .iter()
            .flat_map(|choice| {
                choice.readings[1..]
                    .iter()
                    .map(|reading| (choice.ruling, reading))
            })
            .collect();
        let compared = map_in_parallel(readings.len(), jobs, &|_, _| (), &|i| {
            let (_, change) = readings[i].1;
            let mut reading = Reading::SPEC;
            change(&mut reading);
            compare(&scenes, &[], reading, |_| true)
        });
        let mut choices: HashMap<_, Vec<_>> = HashMap::new();
        for ((ruling, (words, _)), compared) in readings.into_iter().zip(compared) {
            if let Some(compared) = compared {
                let compared = (*words, Comparison::new(&mut files, compared));
                choices.entry(ruling).or_default().push(compared);
            }
        }
        let textures = TextureObjects::render(&mut files, jobs);
        Objects {
            files,
            scenes,
            home,
            misreadings,
            readers: HashMap::new(),
            choices,
            textures,
        }
    }

    /// Renders the scene as shown by readers. Readers that do not visibly change the scene are omitted.
    pub(super) fn render_readers(&mut self, readers: Vec<ShownReader>, jobs: usize) {
        let compared = map_in_parallel(readers.len(), jobs, &|_, _| (), &|i| {
            compare(
                &self.scenes,
                &readers[i].behaviors,
                Reading::SPEC,
                |scene| readers[i].formats.contains(&scene.file.format),
            )
        });
        for (reader, compared) in readers.into_iter().zip(compared) {
            if let Some(compared) = compared {
                let comparison = Comparison::new(&mut self.files, compared);
                self.readers.insert(reader.name, comparison);
            }
        }
    }

    pub(super) fn files(&self) -> impl Iterator<Item = SiteFile> {
        let files = self.files.iter();
        files.map(|(path, bytes)| SiteFile::new(path, bytes.clone()))
    }
}

/// Adds a file under a name that is derived from its contents. Returns its path relative to the root of the site.
pub(super) fn put(files: &mut BTreeMap<String, Vec<u8>>, bytes: Vec<u8>) -> String {
    let path = format!("objects/{}.jpg", &sha256(&bytes)[..16]);
    files.insert(path.clone(), bytes);
    path
}

/// Finds the first scene that is visibly different with the mistakes and under the reading. Scenes for which `is_relevant` is false
/// are skipped.
fn compare(
    scenes: &[Scene],
    mistakes: &[&Misreading],
    reading: Reading,
    is_relevant: impl Fn(&Scene) -> bool,
) -> Option<Compared> {
    let mut relevant = scenes
        .iter()
        .enumerate()
        .filter(|(_, scene)| is_relevant(scene));
    relevant.find_map(|(index, scene)| {
        let (ptm, reading) = ptm_mistakes::read(mistakes, reading, &scene.bytes).ok()?;
        let still = SEARCHED.into_iter().find(|&light| {
            let image = render(mistakes, &reading, &ptm, light);
            image.is_some_and(|image| differ_visibly(&scene.images[light], &image))
        })?;
        let images = render_all(mistakes, &reading, &ptm)?;
        Some(Compared {
            scene: index,
            still: most_telling_light(&scene.images, &images, still),
            sprite: sprite(lit_scene::SIDE, &images),
        })
    })
}

/// Returns the light under which wrong images differ most from the correct ones, or `preferred` if it is nearly as good.
pub(super) fn most_telling_light(
    correct: &[Vec<u8>],
    wrong: &[Vec<u8>],
    preferred: usize,
) -> usize {
    let difference = |light: usize| -> u64 {
        let pairs = correct[light].iter().zip(&wrong[light]);
        pairs.map(|(a, b)| u64::from(a.abs_diff(*b))).sum()
    };
    let best = (0..correct.len()).max_by_key(|&light| difference(light));
    best.filter(|&best| difference(best) > 3 * difference(preferred))
        .unwrap_or(preferred)
}

/// Renders the scene under a light of the grid. Returns `None` if the image is not the size of the scene.
fn render(mistakes: &[&Misreading], reading: &Reading, ptm: &Ptm, light: usize) -> Option<Vec<u8>> {
    let Answer::Decoded(frame) = ptm_mistakes::render(mistakes, reading, ptm, &view(light)) else {
        return None;
    };
    match frame.samples {
        Samples::U8(colors)
            if (frame.width, frame.height) == (lit_scene::SIDE, lit_scene::SIDE) =>
        {
            Some(colors)
        }
        _ => None,
    }
}

fn render_all(mistakes: &[&Misreading], reading: &Reading, ptm: &Ptm) -> Option<Vec<Vec<u8>>> {
    let mut lights = 0..GRID * GRID;
    lights.try_fold(Vec::new(), |mut images, light| {
        images.push(render(mistakes, reading, ptm, light)?);
        Some(images)
    })
}

/// Returns the distance between images of this width in a file.
fn pitch(side: u32) -> u32 {
    side.next_multiple_of(BLOCK)
}

/// Joins the images under all lights of the grid to one JPEG file.
pub(super) fn sprite(side: u32, images: &[Vec<u8>]) -> Vec<u8> {
    let pitch = pitch(side);
    let mut joined = RgbImage::new(pitch * GRID as u32, pitch * GRID as u32);
    for (i, image) in images.iter().enumerate() {
        let image = RgbImage::from_raw(side, side, image.clone()).expect("three bytes per texel");
        let image = RgbImage::from_fn(pitch, pitch, |x, y| {
            *image.get_pixel(x.min(side - 1), y.min(side - 1))
        });
        let place = |i: usize| i as i64 * i64::from(pitch);
        imageops::replace(&mut joined, &image, place(i % GRID), place(i / GRID));
    }
    let mut bytes = Vec::new();
    let encoder = JpegEncoder::new_with_quality(&mut bytes, QUALITY);
    joined
        .write_with_encoder(encoder)
        .expect("the image is small enough to encode");
    bytes
}

/// Renders the object of the home page.
pub(super) fn home(context: PageContext) -> Markup {
    let [correct, wrong] = &context.library.objects.home;
    let objects = [
        (
            correct.as_str(),
            "a checkered ball, lit from the upper left".to_owned(),
            html! { "a correct decoder" },
        ),
        (
            wrong.as_str(),
            "the same ball, lit from the lower left".to_owned(),
            html! { "a decoder with the mistake " (context.link("v-negated")) },
        ),
    ];
    markup(context, UPPER_LEFT, &objects, HOME_SIDE)
}

/// Renders the object correctly and as shown by a decoder with the misreading, if the difference is visible.
pub(super) fn misreading(context: PageContext, misreading: &Misreading) -> Option<Markup> {
    let objects = &context.library.objects;
    let comparison = objects.misreadings.get(misreading.slug)?;
    Some(pair(context, comparison, ["correct", "with the mistake"]))
}

/// Renders the object correctly and with the known mistakes and readings of the reader, if the difference is visible.
pub(super) fn reader(context: PageContext, reader: &str) -> Option<Markup> {
    let comparison = context.library.objects.readers.get(reader)?;
    let captions = [
        "as the reference shows it",
        "computed with the known mistakes and readings of this reader",
    ];
    Some(html! {
        (pair(context, comparison, captions))
        p.quiet { "Readings of open questions are no mistakes, but they may look different." }
    })
}

/// Renders the object under each reading of a ruling of kind choice, if a difference is visible. Readings that are visible in the
/// same scene have one dial.
pub(super) fn choice(context: PageContext, ruling: &str) -> Option<Markup> {
    let readings = context.library.objects.choices.get(ruling)?;
    let choice = CHOICES.iter().find(|choice| choice.ruling == ruling)?;
    let (reference, _) = choice.readings[0];
    Some(html! {
        @for readings in readings.chunk_by(|(_, a), (_, b)| a.scene == b.scene) {
            @let others: Vec<_> = readings.iter().map(|(words, comparison)| (*words, comparison)).collect();
            (compared(context, reference, &others))
        }
    })
}

fn pair(context: PageContext, comparison: &Comparison, [first, second]: [&str; 2]) -> Markup {
    compared(context, first, &[(second, comparison)])
}

/// Renders the object as the reference shows it, and as in comparisons of the same scene, with these captions.
fn compared(context: PageContext, reference: &str, others: &[(&str, &Comparison)]) -> Markup {
    let first = others[0].1;
    let scene = &context.library.objects.scenes[first.scene];
    let others = others
        .iter()
        .map(|(caption, comparison)| (&*comparison.path, *caption));
    let objects: Vec<(&str, String, Markup)> = std::iter::once((&*scene.path, reference))
        .chain(others)
        .map(|(path, caption)| (path, format!("the object: {caption}"), html! { (caption) }))
        .collect();
    html! {
        (markup(context, first.still, &objects, lit_scene::SIDE))
        p.quiet { "The same object, stored as " (scene.file.name()) "." }
    }
}

/// Renders objects with one dial: for each object, the path of its file, the alternative text and the caption.
pub(super) fn markup(
    context: PageContext,
    still: usize,
    objects: &[(&str, String, Markup)],
    side: u32,
) -> Markup {
    let (lu, lv) = light(still);
    let size = pitch(side) * GRID as u32;
    let pitch = f64::from(pitch(side)) / f64::from(side);
    let place = format!(
        "--pitch:{pitch:.5};--column:{};--row:{}",
        still % GRID,
        still / GRID
    );
    html! {
        div.object data-side=(side) data-u={ (format!("{lu:.2}")) } data-v={ (format!("{lv:.2}")) } {
            @for (path, alt, caption) in objects {
                figure {
                    div.frames style=(place) { img src={ (context.root) (path) } width=(size) height=(size) alt=(alt) loading="lazy"; }
                    figcaption { (caption) }
                }
            }
            div.light hidden {
                div.dial role="slider" tabindex="0" aria-label="direction of the light: arrow keys move it, Home moves it to the zenith" aria-valuemin="0" aria-valuemax="1" aria-valuenow="0" {}
                output {}
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_are_in_the_unit_disk_and_start_at_the_upper_left() {
        let lights = (0..GRID * GRID).map(light);
        assert!(lights.clone().all(|(u, v)| u.hypot(v) <= 1.0));
        let (u, v) = light(UPPER_LEFT);
        assert!(u < 0.0 && v > 0.0);
        assert_eq!(light(GRID * GRID / 2), (0.0, 0.0));
    }
}
