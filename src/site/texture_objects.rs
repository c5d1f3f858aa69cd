//! Objects of the texture chapter: a lit PTM on a surface, correct and as a stage with a misreading shows it.

use std::collections::BTreeMap;

use maud::{Markup, html};

use super::objects::{GRID, UPPER_LEFT, light, markup, most_telling_light, put, sprite};
use super::page::PageContext;
use ptm_harness::session::lit_scene::{ball, differ_visibly};
use ptm_mistakes::Misreading;
use ptm_mistakes::texture::Change;
use ptm_suite::kit::parallel::map_in_parallel;
use ptm_suite::kit::yaml::from_yaml;
use ptm_suite::texture::question::GivenEntry;
use ptm_texture::{Preview, PreviewShape, Rounding, Rules, TextureMap, preview};

/// Width and height of an image, in pixels.
const SIDE: u32 = 40;
/// Width and height of the images in which a misreading is searched for.
const SEARCHED_SIDE: u32 = 24;
/// Width and height of the PTM, in texels.
const MAP_SIDE: u32 = 24;

/// A way to apply the PTM to a shape.
struct Setting {
    shape: PreviewShape,
    /// The entry of the table, as in `texture render --entry`.
    entry: &'static str,
    /// Margin around the map, in texture coordinates.
    margin: f64,
}

/// Settings in which a misreading is searched for, in this order.
const SETTINGS: [Setting; 7] = [
    Setting {
        shape: PreviewShape::Plane,
        entry: "{parameterization: FloatData, boundary: [Wrap, Mirror, Wrap], mag_sample: WeightedBase, min_sample: WeightedBase}",
        margin: 0.4,
    },
    Setting {
        shape: PreviewShape::Plane,
        entry: "{parameterization: FloatData, boundary: [ClampExplicit, ClampBorder, Wrap], clamp_method: Color, clamp_color: [0.2, 0.3, 0.6], composition: Modulate}",
        margin: 0.4,
    },
    Setting {
        shape: PreviewShape::Plane,
        entry: "{parameterization: FloatData, boundary: [ClampExplicit, Wrap, Wrap], composition: BlendEnvColor, channel: Green, env_color: [0.9, 0.8, 0.2], rendering_control: PreLight, orientation_matrix: [[0.8, 0.6, 0, 0], [-0.6, 0.8, 0, 0.3], [0, 0, 1, 0], [0, 0, 0, 1]]}",
        margin: 0.4,
    },
    Setting {
        shape: PreviewShape::Plane,
        entry: "{parameterization: FloatData, min_sample: WeightedBetweenMipmaps, mag_sample: WeightedBetweenMipmaps, depth_bias: 0.5}",
        margin: 3.0,
    },
    Setting {
        shape: PreviewShape::Plane,
        entry: "{parameterization: FloatData, min_sample: SingleInMipmap, mag_sample: SingleBase, frequency: [0.5, 1, 1]}",
        margin: 3.0,
    },
    Setting {
        shape: PreviewShape::Sphere,
        entry: "{composition: Modulate}",
        margin: 0.0,
    },
    Setting {
        shape: PreviewShape::Sphere,
        entry: "{parameterization: ReflectionSphereWC, composition: Decal, reflection_matrix: [[0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]]}",
        margin: 0.0,
    },
];

/// The objects by slug of the misreading, and the correct ones.
pub(super) struct TextureObjects {
    /// Paths of the correct objects, one for each setting.
    correct: Vec<Option<String>>,
    misreadings: BTreeMap<&'static str, Shown>,
}

/// A setting in which a misreading is visible.
struct Shown {
    setting: usize,
    /// Index of the light of the still image.
    still: usize,
    path: String,
}

impl TextureObjects {
    /// Renders the PTM as shown by a stage with each misreading, and adds the files. Misreadings that do not visibly change it are
    /// omitted.
    pub(super) fn render(files: &mut BTreeMap<String, Vec<u8>>, jobs: usize) -> TextureObjects {
        let ptm = ball(MAP_SIDE);
        let draw = |setting: &Setting, rules: &Rules, side: u32, index: usize| {
            let (lu, lv) = light(index);
            let entry: GivenEntry = from_yaml(setting.entry).expect("an entry");
            let scene = Preview {
                shape: setting.shape,
                map: TextureMap::from_ptm(&ptm, lu, lv, Rounding::None, rules).with_box_levels(),
                entry: entry.entry(rules),
                light: (lu, lv),
                color: [0.8, 0.75, 0.7],
                margin: setting.margin,
            };
            preview(&scene, side as usize, rules).ok()
        };
        let draw_all = |setting: &Setting, rules: &Rules| -> Option<Vec<Vec<u8>>> {
            (0..GRID * GRID)
                .map(|index| draw(setting, rules, SIDE, index))
                .collect()
        };
        let correct = map_in_parallel(SETTINGS.len(), jobs, &|_, _| (), &|i| {
            draw_all(&SETTINGS[i], &Rules::SPEC).expect("the reference draws every setting")
        });
        let search =
            |setting: &Setting, rules: &Rules| draw(setting, rules, SEARCHED_SIDE, UPPER_LEFT);
        let expected = SETTINGS
            .each_ref()
            .map(|setting| search(setting, &Rules::SPEC));
        let all: Vec<_> = ptm_mistakes::texture::all().collect();
        let found = map_in_parallel(all.len(), jobs, &|_, _| (), &|i| {
            let rules = all[i].apply_to(Rules::SPEC);
            let setting = (0..SETTINGS.len()).find(|&setting| {
                let images = expected[setting]
                    .as_ref()
                    .zip(search(&SETTINGS[setting], &rules));
                images.is_some_and(|(expected, image)| differ_visibly(expected, &image))
            })?;
            let images = draw_all(&SETTINGS[setting], &rules)?;
            let still = most_telling_light(&correct[setting], &images, UPPER_LEFT);
            differ_visibly(&correct[setting][still], &images[still])
                .then(|| (setting, still, sprite(SIDE, &images)))
        });
        let mut misreadings = BTreeMap::new();
        for (misreading, found) in all.iter().zip(found) {
            if let Some((setting, still, sprite)) = found {
                let path = put(files, sprite);
                let shown = Shown {
                    setting,
                    still,
                    path,
                };
                misreadings.insert(misreading.slug, shown);
            }
        }
        let is_shown = |i: usize| misreadings.values().any(|shown| shown.setting == i);
        let correct = correct.iter().enumerate();
        let correct =
            correct.map(|(i, images)| is_shown(i).then(|| put(files, sprite(SIDE, images))));
        TextureObjects {
            correct: correct.collect(),
            misreadings,
        }
    }

    /// Renders the object correctly and with the misreading, if the difference is visible.
    pub(super) fn misreading(
        &self,
        context: PageContext,
        misreading: &Misreading<Change>,
    ) -> Option<Markup> {
        let shown = self.misreadings.get(misreading.slug)?;
        let correct = self.correct[shown.setting].as_deref()?;
        let objects = [(correct, "correct"), (&*shown.path, "with the mistake")];
        let objects = objects.map(|(path, caption)| {
            let alt = format!("a PTM as a texture: {caption}");
            (path, alt, html! { (caption) })
        });
        let setting = &SETTINGS[shown.setting];
        let shape = match setting.shape {
            PreviewShape::Plane => "a plane",
            PreviewShape::Sphere => "a sphere",
        };
        Some(html! {
            (markup(context, shown.still, &objects, SIDE))
            p.quiet { "A PTM on " (shape) ", with the entry " code { (setting.entry) } }
        })
    }
}
