//! Randomly generated files, described like cases.
//!
//! A file is generated as the `make` record of a case, not as bytes. A finding is therefore a complete case, and every
//! minimization step removes or simplifies one word. The expected result is known by construction and depends on no lenient
//! ruling.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use arbitrary::{Result, Unstructured};

use ptm::{Coding, Format, Storage};
use ptm_suite::cases::{Case, Expect, Suite};

/// A generated file: the parts of its case record that differ from those of the default file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Draft {
    /// The format of the file.
    pub format: Format,
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// Values in `make` and in its parts, by key.
    pub words: BTreeMap<DraftKey, String>,
    /// Views, in order of preference.
    pub views: Vec<String>,
    /// Damage to the file, if any.
    pub damage: Option<DraftDamage>,
}

/// Damage to a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DraftDamage {
    /// Name of the damage in `spec-cases/`.
    pub name: &'static str,
    /// Expected result: [`Expect::Reject`] or [`Expect::Refuse`].
    pub expect: Expect,
}

/// The part of `make` that contains a word (`compression`, `spelling` or an empty string), and the key of that word.
pub type DraftKey = (&'static str, &'static str);

impl Draft {
    /// Generates a legal file.
    ///
    /// # Errors
    /// Returns an error if `u` has no bytes left.
    pub fn draw(u: &mut Unstructured) -> Result<Draft> {
        let format = *u.choose(&Format::ALL)?;
        let (width, height) = draw_size(format, u)?;
        let mut draft = Draft {
            format,
            width,
            height,
            words: BTreeMap::new(),
            views: Vec::new(),
            damage: None,
        };
        draft.set("", "seed", u.int_in_range(0..=9999)?);
        draft.draw_spelling(u)?;
        draft.draw_numbers(u)?;
        if format.coding().is_some() {
            draft.draw_compression(u)?;
        } else {
            draft.draw_payload(u)?;
        }
        draft.draw_views(u)?;
        Ok(draft)
    }

    fn texels(&self) -> u32 {
        self.width * self.height
    }

    #[expect(
        clippy::needless_pass_by_value,
        reason = "callers pass numbers and strings by value"
    )]
    fn set(&mut self, part: &'static str, key: &'static str, word: impl ToString) {
        self.words.insert((part, key), word.to_string());
    }

    /// Generates scale, bias, matrix and scene.
    fn draw_numbers(&mut self, u: &mut Unstructured) -> Result<()> {
        if u.ratio(2, 3)? {
            self.set("", "scale", draw_list(6, u, draw_scale)?);
        }
        if u.ratio(2, 3)? {
            self.set("", "bias", draw_list(6, u, draw_bias)?);
        }
        if self.format == Format::Lum && u.ratio(1, 2)? {
            // In column-major order. The last row is 0 0 0 1: no translation, because its position is an open question.
            let mut matrix = Vec::new();
            for _ in 0..3 {
                matrix.push(draw_list(3, u, draw_factor)? + " 0");
            }
            let matrix = format!("{} 0 0 0 1", matrix.join(" "));
            self.set("", "matrix", matrix);
        }
        if u.ratio(1, 2)? {
            let mut scenes = "extremes ramp stripes soft columns rows diagonals unlit".split(' ');
            let scene = match scenes.nth(u.int_in_range(0..=9)?) {
                Some(scene) => scene.to_owned(),
                None => format!("flat-{}", u.choose(&[0, 1, 127, 128, 129, 254, 255])?),
            };
            self.set("", "scene", scene);
        }
        Ok(())
    }

    /// Generates the table size, indices, and the byte after the header.
    fn draw_payload(&mut self, u: &mut Unstructured) -> Result<()> {
        if self.format.has_table() {
            let entries = match u.int_in_range(0..=19)? {
                0 => 65_536,
                1 => 65_535,
                2..=5 => *u.choose(&[255, 256, 257, 258, 511, 512, 513])?,
                6..=9 => u.int_in_range(259..=1500)?,
                _ => u.int_in_range(1..=40)?,
            };
            self.set("", "entries", entries);
            match u.int_in_range(0..=9)? {
                0 if entries > 2 => self.set("", "indices", "bytes-differ"),
                1 => self.set("", "indices", "below-256"),
                2 => self.set("", "indices", entries - 1),
                3 => self.set("", "indices", u.int_in_range(0..=entries - 1)?),
                _ => {}
            }
        }
        if u.ratio(1, 3)? {
            let byte = *u.choose(&[
                0x00, 0x09, 0x0a, 0x0d, 0x1a, 0x20, 0x23, 0x2d, 0x30, 0x39, 0x7f, 0x80, 0xfe, 0xff,
            ])?;
            self.set("", "first_byte", format!("{byte:#04x}"));
        }
        Ok(())
    }

    fn draw_compression(&mut self, u: &mut Unstructured) -> Result<()> {
        let jpeg = self.format.coding() == Some(Coding::Jpeg);
        let lossy = jpeg || u.ratio(1, 3)?;
        if jpeg {
            let quality = *u.choose(&[1, 10, 20, 23, 24, 25, 50, 75, 90, 95, 99, 100])?;
            self.set("compression", "parameter", quality);
        } else if lossy {
            self.set("compression", "parameter", u.int_in_range(1..=10)?);
        }
        self.draw_forest(u)?;
        let moves = self.draw_transforms(u)?;
        let residuals = match u.int_in_range(0..=9)? {
            // Planes whose samples depend on the inverse DCT are requested only as raw values, and are never displaced.
            0..=2 if !(jpeg && moves) => "natural",
            3 => "wraps",
            4 => "framed",
            5 => "gray",
            _ => "blocks",
        };
        self.set("compression", "residuals", residuals);
        self.draw_records(u)?;
        self.draw_stream(jpeg, u)
    }

    /// Generates references and ranks: a named structure or a random forest.
    fn draw_forest(&mut self, u: &mut Unstructured) -> Result<()> {
        const STRUCTURES: &str =
            "intra chain star deep two-trees shared-reference upward rotated tablet";
        if u.ratio(1, 2)? {
            let structure = choose_word(STRUCTURES, u)?;
            self.set("compression", "structure", structure);
            return Ok(());
        }
        let count = self.format.channels();
        let mut by_rank: Vec<usize> = (0..count).collect();
        for last in (1..count).rev() {
            by_rank.swap(last, u.int_in_range(0..=last)?);
        }
        let (mut references, mut order) = (vec![-1i64; count], vec![0usize; count]);
        for (rank, &plane) in by_rank.iter().enumerate() {
            order[plane] = rank;
            if rank > 0 && u.ratio(2, 3)? {
                references[plane] = by_rank[u.int_in_range(0..=rank - 1)?] as i64;
            }
        }
        self.set("compression", "references", join(&references));
        self.set("compression", "order", join(&order));
        Ok(())
    }

    /// Generates transforms and vectors. Returns true if references may be displaced.
    fn draw_transforms(&mut self, u: &mut Unstructured) -> Result<bool> {
        if u.ratio(1, 3)? {
            return Ok(false);
        }
        let with_motion = u.ratio(1, 2)?;
        let pool: &[u32] = if with_motion { &[0, 1, 2, 3] } else { &[0, 1] };
        let length = u.int_in_range(1..=5)?;
        let transforms = draw_list(length, u, |u| Ok(u.choose(pool)?.to_string()))?;
        self.set("compression", "transforms", transforms);
        if u.ratio(1, 5)? {
            self.set("compression", "everywhere", true);
        }
        for axis in ["motion_x", "motion_y"] {
            if with_motion && u.ratio(3, 4)? {
                let length = u.int_in_range(1..=5)?;
                let vectors = draw_list(length, u, |u| {
                    // Some vectors point outside the plane or exceed a byte.
                    let limit = *u.choose(&[7, 7, 7, 7, 7, 7, 7, 7, 7, 80, 300])?;
                    Ok(u.int_in_range(-limit..=limit)?.to_string())
                })?;
                self.set("compression", axis, vectors);
            }
        }
        Ok(with_motion)
    }

    fn draw_records(&mut self, u: &mut Unstructured) -> Result<()> {
        if u.ratio(1, 2)? {
            return Ok(());
        }
        let count = self.format.channels();
        let mut records = Vec::new();
        for _ in 0..u.int_in_range(1..=3)? {
            let planes = match u.int_in_range(0..=5)? {
                0 => "all".to_owned(),
                1 => "predicted".to_owned(),
                2 => "intra".to_owned(),
                _ => u.int_in_range(0..=count - 1)?.to_string(),
            };
            let texels = match u.int_in_range(0..=5)? {
                0 => "first".to_owned(),
                1 => "last".to_owned(),
                2 if self.texels() <= 64 => "all".to_owned(),
                3 if self.texels() <= 400 => "border".to_owned(),
                _ => {
                    let last = self.texels() - 1;
                    draw_list(u.int_in_range(1..=3)?, u, |u| {
                        Ok(u.int_in_range(0..=last)?.to_string())
                    })?
                    .replace(' ', "+")
                }
            };
            records.push(format!("{planes}:{texels}"));
        }
        self.set("compression", "records", records.join(" "));
        Ok(())
    }

    /// Generates the options of the stream encoder.
    fn draw_stream(&mut self, jpeg: bool, u: &mut Unstructured) -> Result<()> {
        if u.ratio(1, 2)? {
            return Ok(());
        }
        if jpeg {
            let interval = u.choose(&[0, 0, 1, 2, 3, 7])?;
            self.set("compression", "restart_interval", interval);
            self.set("compression", "optimized_tables", u.arbitrary::<bool>()?);
            let sampling = u.choose(&["1x1", "2x1", "1x2", "2x2", "4x1", "3x2"])?;
            self.set("compression", "sampling", sampling);
            if u.ratio(1, 3)? {
                self.set("compression", "jfif", false);
            }
        } else if !self.words.contains_key(&("compression", "parameter")) {
            let presets = u.choose(&["3 7 21 64", "2 5 9 31", "10 40 90 255", "2 2 2 3"])?;
            self.set("compression", "presets", format!("255 {presets}"));
        }
        if u.ratio(1, 4)? {
            self.set("compression", "alternates", true);
        }
        Ok(())
    }

    fn draw_spelling(&mut self, u: &mut Unstructured) -> Result<()> {
        const SECTION_ENDS: &str = "version format height scale bias matrix";
        if u.ratio(1, 4)? {
            let length = u.int_in_range(1..=3)?;
            let lines = draw_list(length, u, |u| choose_word(SECTION_ENDS, u))?;
            self.set("spelling", "space_before_newline", lines);
        }
        for key in ["size_lines", "scale_bias_lines"] {
            if u.ratio(1, 3)? {
                self.set("spelling", key, 1);
            }
        }
        if u.ratio(1, 6)? {
            self.set("spelling", "leading_zeros", u.choose(&[1, 2, 10, 90])?);
        }
        Ok(())
    }

    fn draw_views(&mut self, u: &mut Unstructured) -> Result<()> {
        let mut views = vec!["raw".to_owned()];
        let residuals = self.words.get(&("compression", "residuals"));
        let needs_exact_dct = residuals.is_some_and(|word| word == "natural")
            && self.format.coding() == Some(Coding::Jpeg);
        if !needs_exact_dct {
            let (lu, lv) = (u.int_in_range(-65..=65)?, u.int_in_range(-65..=65)?);
            let light = format!("rgb:{},{}", f64::from(lu) / 100.0, f64::from(lv) / 100.0);
            views.extend(["coef".to_owned(), light]);
            let preferred = u.int_in_range(0..=2)?;
            views.swap(0, preferred);
        }
        self.views = views;
        Ok(())
    }

    /// Returns the case of the file. For a damaged file, the case of its undamaged twin, `ID-whole`, comes first.
    ///
    /// # Errors
    /// Returns the reason why the file cannot be written.
    pub fn cases(&self, id: &str) -> std::result::Result<Vec<Case>, String> {
        let suite = Suite::from_files(&[(id, &self.to_yaml(id, "randomly generated", None))])?;
        Ok(suite.cases)
    }

    /// Formats the case as in `spec-cases/`, about the misread clause or, if it is unknown, about the data of the format.
    #[must_use]
    pub fn to_yaml(&self, id: &str, because: &str, misread: Option<&str>) -> String {
        let clause = misread.unwrap_or(payload_clause(self.format));
        let legal_id = match self.damage {
            Some(_) => format!("{id}-whole"),
            None => id.to_owned(),
        };
        let mut out = format!(
            "- id: {legal_id}\n  clauses: [{clause}]\n  because: {because:?}\n  make:\n    format: {}\n    size: {}x{}\n",
            self.format.short_name(),
            self.width,
            self.height
        );
        let mut last = "";
        for (&(part, key), word) in &self.words {
            if part != last {
                let _ = writeln!(out, "    {part}:");
            }
            last = part;
            let indent = if part.is_empty() { "    " } else { "      " };
            let _ = writeln!(out, "{indent}{key}: {word:?}");
        }
        let views: Vec<String> = self.views.iter().map(|view| format!("{view:?}")).collect();
        let _ = writeln!(out, "  expect: decode\n  views: [{}]", views.join(", "));
        if let Some(damage) = self.damage {
            let _ = write!(
                out,
                "- id: {id}\n  clauses: [{clause}]\n  because: {because:?}\n  twin_of: {legal_id}\n  damage: {}\n  expect: {}\n",
                damage.name,
                damage.expect.name()
            );
        }
        out
    }
}

fn payload_clause(format: Format) -> &'static str {
    match format.storage() {
        Storage::Texels => "2.7/1",
        Storage::Table | Storage::ColorTable => "2.8/1",
        Storage::Streams(_) => "2.9/1",
    }
}

/// Generates a size: usually small, and sometimes elongated, with a side near 256, or with more than 65,535 texels. No width
/// exceeds 65,500, the limit of libjpeg, because a decoder may have the same limit.
fn draw_size(format: Format, u: &mut Unstructured) -> Result<(u32, u32)> {
    Ok(match u.int_in_range(0..=99)? {
        0 => *u.choose(&[(257, 256), (300, 220), (65_500, 2), (2, 32_769)])?,
        1..=4 if format.coding().is_none() => (u.int_in_range(100..=600)?, 1),
        5..=8 if format.coding().is_none() => (1, u.int_in_range(100..=600)?),
        9..=14 => (*u.choose(&[255, 256, 257])?, u.int_in_range(1..=3)?),
        15..=18 => (u.int_in_range(1..=3)?, *u.choose(&[255, 256, 257])?),
        19..=30 => (u.int_in_range(1..=40)?, u.int_in_range(1..=40)?),
        31..=40 => (*u.choose(&[8, 16, 24])?, *u.choose(&[8, 16])?),
        _ => (u.int_in_range(1..=9)?, u.int_in_range(1..=9)?),
    })
}

/// Generates a small scale in one of several spellings.
fn draw_scale(u: &mut Unstructured) -> Result<String> {
    let hundredths = u.int_in_range(1..=240)?;
    Ok(match u.int_in_range(0..=9)? {
        0 => "1".to_owned(),
        1 => format!("-{}", f64::from(hundredths) / 100.0),
        2 => format!("{hundredths}e-2"),
        3 => format!(".{hundredths:03}"),
        4 => format!("{}.", hundredths % 4),
        5 => format!("+{}E+0", f64::from(hundredths) / 100.0),
        6 => format!("{:.12}", f64::from(hundredths) / 97.0),
        7 => format!("00{}", f64::from(hundredths) / 100.0),
        _ => (f64::from(hundredths) / 100.0).to_string(),
    })
}

fn draw_bias(u: &mut Unstructured) -> Result<String> {
    Ok(match u.int_in_range(0..=9)? {
        0 => "0".to_owned(),
        1 => u.choose(&[127, 128, 255, 256, 257, -1, -128])?.to_string(),
        2 => u.int_in_range(-214..=460)?.to_string(),
        3 => format!("+{}", u.int_in_range(0..=255)?),
        4 => format!("0{}", u.int_in_range(0..=255)?),
        _ => u.int_in_range(0..=255)?.to_string(),
    })
}

/// Generates an element of the color matrix.
fn draw_factor(u: &mut Unstructured) -> Result<String> {
    let factor = f64::from(u.int_in_range(-150..=150)?) / 128.0;
    Ok(match u.int_in_range(0..=5)? {
        0 => format!("{factor:e}"),
        1 => format!("{factor:+}"),
        _ => factor.to_string(),
    })
}

/// Generates `count` numbers separated by spaces.
fn draw_list(
    count: usize,
    u: &mut Unstructured,
    mut draw: impl FnMut(&mut Unstructured) -> Result<String>,
) -> Result<String> {
    let words: Result<Vec<String>> = (0..count).map(|_| draw(u)).collect();
    Ok(words?.join(" "))
}

fn choose_word(words: &str, u: &mut Unstructured) -> Result<String> {
    let words: Vec<&str> = words.split(' ').collect();
    Ok((*u.choose(&words)?).to_owned())
}

fn join(numbers: &[impl ToString]) -> String {
    let words: Vec<String> = numbers.iter().map(ToString::to_string).collect();
    words.join(" ")
}
