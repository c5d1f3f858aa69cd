//! Executable mistakes: each a plausible misreading of one clause, at the one place where it acts.
//!
//! The same catalogue names the mistake of a failing decoder, measures the suite (every misreading must be caught, every
//! pair told apart), and proves that each clause is really tested.

mod arithmetic;
mod buffers;
mod codecs;
mod compressed;
mod evaluation;
mod header;
mod layout;
mod lookup;
mod luminance;
mod side_information;

use std::borrow::Cow;

use crate::decode::{Limits, Ptm, decode_as, examine_as};
use crate::error::Class;
use crate::harness::protocol::{Answer, Frame, View};
use crate::ptm::Field;
use crate::reading::Reading;

/// One mistake.
pub struct Misreading {
    /// A permanent name.
    pub slug: &'static str,
    /// The clause it misreads.
    pub clause: &'static str,
    /// What a decoder with this mistake does, as a sentence without its subject: "reads …".
    pub effect: &'static str,
    /// What to do about it.
    pub mend: &'static str,
    /// Where it acts.
    pub at: At,
}

/// The one place where a mistake acts.
pub enum At {
    /// The file as such a reader sees it.
    Bytes(fn(&Anatomy) -> Seen),
    /// A decision of [`Reading`].
    Reading(Decision, fn(Reading) -> Reading),
    /// What it makes of the result.
    Planes(fn(&mut Ptm)),
}

/// Which decision of [`Reading`] a mistake changes. Two mistakes can be made at once if these differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // each is a field of Reading
pub enum Decision {
    Light,
    Polynomial,
    FinalCoefficient,
    FinalOther,
    AfterTable,
    LumVector,
    LumMatrix,
    LumTranslation,
    Blocks,
    StoredRow,
    Modulate,
    Clamp,
    IndexWidth,
    Index,
    Entry,
    Plan,
    Predictor,
    Invert,
    MotionHalf,
    Predict,
    Reconstruct,
    Stream,
    SideCounts,
    Records,
    Mend,
}

/// What a reader with a mistake makes of the bytes.
pub enum Seen {
    /// It refuses them.
    Refused,
    /// It reads them as if they were these.
    File(Vec<u8>),
}

/// All misreadings, section after section.
pub fn all() -> impl Iterator<Item = &'static Misreading> {
    [
        header::ALL,
        buffers::ALL,
        arithmetic::ALL,
        lookup::ALL,
        luminance::ALL,
        layout::ALL,
        compressed::ALL,
        side_information::ALL,
        codecs::ALL,
        evaluation::ALL,
    ]
    .into_iter()
    .flatten()
}

/// The misreading of that name.
#[must_use]
pub fn named(slug: &str) -> Option<&'static Misreading> {
    all().find(|misreading| misreading.slug == slug)
}

/// How a decoder with these mistakes answers, if it reads the open questions as `reading` does.
#[must_use]
pub fn answer(misreadings: &[&Misreading], reading: Reading, file: &[u8], view: &View) -> Answer {
    let reading = misread(misreadings, reading);
    let mut seen = file.to_vec();
    for misreading in misreadings {
        if let At::Bytes(edit) = misreading.at {
            match edit(&Anatomy::of(&seen, &reading)) {
                Seen::Refused => return Answer::Rejected,
                Seen::File(bytes) => seen = bytes,
            }
        }
    }
    match decode_as(&seen, &reading, &Limits::default()) {
        Ok(ptm) => show(misreadings, &reading, &ptm, view),
        Err(error) if error.class() == Class::Malformed => Answer::Rejected,
        Err(_) => Answer::Unsupported,
    }
}

/// `reading` with these mistakes in its decisions.
pub(crate) fn misread(misreadings: &[&Misreading], reading: Reading) -> Reading {
    misreadings
        .iter()
        .fold(reading, |reading, misreading| match misreading.at {
            At::Reading(_, change) => change(reading),
            _ => reading,
        })
}

/// How a decoder with these mistakes, which `reading` has in it, shows what it found in a file.
pub(crate) fn show(
    misreadings: &[&Misreading],
    reading: &Reading,
    ptm: &Ptm,
    view: &View,
) -> Answer {
    let mut ptm = Cow::Borrowed(ptm);
    for misreading in misreadings {
        if let At::Planes(edit) = misreading.at {
            edit(ptm.to_mut());
        }
    }
    Answer::Decoded(Frame::under(&ptm, view, reading))
}

/// A file and its header's parts, for mistakes that act on bytes.
pub struct Anatomy<'a> {
    /// The file.
    pub file: &'a [u8],
    /// Its fields as far as they can be read.
    pub fields: Vec<Field>,
}

impl<'a> Anatomy<'a> {
    /// Takes `file` apart under a reading of the open points.
    #[must_use]
    pub fn of(file: &'a [u8], reading: &Reading) -> Anatomy<'a> {
        Anatomy {
            file,
            fields: examine_as(file, reading).0,
        }
    }

    /// The file, unchanged.
    #[must_use]
    pub fn unchanged(&self) -> Seen {
        Seen::File(self.file.to_vec())
    }

    /// Refused if `refused`, else unchanged.
    #[must_use]
    pub fn refused_if(&self, refused: bool) -> Seen {
        if refused {
            Seen::Refused
        } else {
            self.unchanged()
        }
    }

    /// The header's fields: all before the first byte of the payload.
    fn tokens(&self) -> impl Iterator<Item = &Field> {
        self.fields.iter().take_while(|field| {
            !matches!(
                field.clause,
                "2.5/3" | "2.7/1" | "2.8.1/1" | "2.9.8/2" | "2.9.8/4"
            )
        })
    }

    /// The text of the fields of these clauses.
    pub fn texts(&self, clauses: &[&str]) -> Vec<&'a str> {
        let chosen = self
            .tokens()
            .filter(|field| clauses.contains(&field.clause));
        chosen
            .filter_map(|field| std::str::from_utf8(&self.file[field.range.clone()]).ok())
            .collect()
    }

    /// Where the payload starts: after the line feed that ends the last line of the header.
    pub fn payload(&self) -> usize {
        let end = self.tokens().last().map_or(0, |field| field.range.end);
        let line_feed = self.file[end..].iter().position(|&byte| byte == b'\n');
        line_feed.map_or(self.file.len(), |length| end + length + 1)
    }

    /// The header.
    pub fn header(&self) -> &'a [u8] {
        &self.file[..self.payload()]
    }

    /// The bytes between the `n`th field of a clause and the one after it.
    pub fn after(&self, clause: &str, n: usize) -> &'a [u8] {
        let mut from = self
            .tokens()
            .skip_while(|field| field.clause != clause)
            .skip(n);
        match (from.next(), from.next()) {
            (Some(field), Some(next)) => &self.file[field.range.end..next.range.start],
            (Some(field), None) => &self.file[field.range.end..self.payload()],
            _ => &[],
        }
    }

    /// The file with its header spelled anew: `spell` gives another text for a field, or none.
    ///
    /// A field that cannot be read ends the taking apart, so it goes on until nothing changes any more.
    pub fn respelled(&self, spell: fn(clause: &str, text: &str) -> Option<String>) -> Seen {
        let mut file = self.file.to_vec();
        for _ in 0..40 {
            let anatomy = Anatomy::of(&file, &Reading::SPEC);
            let mut bytes = Vec::new();
            let mut at = 0;
            for field in anatomy.tokens() {
                let text = std::str::from_utf8(&file[field.range.clone()]).unwrap_or_default();
                if let Some(text) = spell(field.clause, text) {
                    bytes.extend_from_slice(&file[at..field.range.start]);
                    bytes.extend_from_slice(text.as_bytes());
                    at = field.range.end;
                }
            }
            bytes.extend_from_slice(&file[at..]);
            if bytes == file {
                break;
            }
            file = bytes;
        }
        Seen::File(file)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::codec::{jpeg, jpeg_ls};
    use crate::decode::by_hand::ByHand;
    use crate::ptm::Format;

    /// Numbers without a pattern, the same everywhere.
    struct Draws(u32);

    impl Draws {
        fn byte(&mut self) -> u8 {
            self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (self.0 >> 24) as u8
        }

        fn plane(&mut self, texels: usize) -> Vec<u8> {
            (0..texels).map(|_| self.byte()).collect()
        }
    }

    /// A JPEG-LS file of noise that predicts, displaces and mends.
    fn predicting(format: Format, width: u32, height: u32, parameter: i64) -> ByHand {
        let mut draws = Draws(width * height + format.channels() as u32);
        let mut file = ByHand::new(format, width, height);
        let texels = file.size.texels();
        file.parameter = parameter;
        let order: [i64; 9] = [4, 8, 3, 0, 1, 7, 5, 2, 6];
        let references = [-1, 5, 0, -1, 3, 0, 7, 3, 7];
        for plane in 0..9 {
            let rank = if plane == 2 { 9 } else { order[plane] };
            let transform = [1, 1, 3, 2, 2, 3, 1, 2, 0][plane];
            file.predicted(
                plane,
                rank,
                references[plane],
                transform,
                &draws.plane(texels),
            );
        }
        for plane in 9..format.channels() {
            let transform = [0, 1, 2, 3][plane % 4];
            file.predicted(
                plane,
                plane as i64 + 9,
                plane as i64 - 7,
                transform,
                &draws.plane(texels),
            );
        }
        let vectors = [
            (3, 5),
            (2, 2),
            (3, 3),
            (1, 0),
            (-1, 2),
            (1, -3),
            (6, 6),
            (5, -2),
            (1, 1),
            (-3, -1),
            (0, 1),
            (2, -5),
        ];
        for plane in 0..format.channels() {
            let (mx, my) = vectors[plane % vectors.len()];
            file.moved(plane, mx, my);
        }
        let last = texels as u32 - 1;
        for plane in [0, 3, 5, 7] {
            file.record(plane, 0, 200);
            file.record(plane, last, 130 + plane as u8);
            file.record(plane, last / 3, 3);
            file.record(plane, last / 2, 17);
        }
        file.record(2, 2, 99);
        file.record(8, 3, 98);
        file
    }

    /// Files that show mistakes in 2.9, and what each is there for.
    fn witnesses() -> Vec<(&'static str, Vec<u8>)> {
        let mut files = Vec::new();
        for format in [Format::JpeglsLrgb, Format::JpeglsRgb] {
            files.push(("prediction", predicting(format, 7, 5, 2).bytes()));
            files.push(("parameter 40", predicting(format, 5, 6, 40).bytes()));
        }

        let mut intra = ByHand::new(Format::JpeglsLrgb, 3, 3);
        intra.parameter = 30;
        files.push(("equal planes", intra.bytes()));
        intra.transforms = vec![1, 2, 3, 0, 0, 0, 0, 0, 0];
        files.push(("transforms of intra planes", intra.bytes()));
        let mut reversed = ByHand::new(Format::JpeglsLrgb, 3, 3);
        reversed.order = vec![8, 7, 6, 5, 4, 3, 2, 1, 0];
        reversed.parameter = 30;
        files.push(("ranks without references", reversed.bytes()));

        // Half vectors and what they do, one plane each, so that one mistake does not hide the next.
        let mut draws = Draws(3);
        for (transform, mx, my) in [
            (0, 2, 2),
            (1, 1, 1),
            (2, 0, 0),
            (2, 1, 0),
            (2, 0, 1),
            (2, 1, 1),
            (2, -1, 0),
            (2, 4, 0),
            (2, -2, 4),
            (2, -3, -5),
            (2, 130, 0),
            (2, 65_536, 0),
            (3, 2, 0),
            (3, 1, 1),
        ] {
            let mut file = ByHand::new(Format::JpeglsLrgb, 6, 4);
            file.parameter = 30;
            file.stream(0, &draws.plane(24));
            file.predicted(4, 1, 0, transform, &draws.plane(24));
            file.moved(4, mx, my);
            files.push(("one transform", file.bytes()));
        }

        // Sums at the edges, and no side information.
        let mut sums = ByHand::new(Format::JpeglsLrgb, 4, 1);
        sums.stream(1, &[255, 0, 200, 200]);
        sums.predicted(3, 1, 1, 0, &[255, 0, 183, 184]);
        sums.predicted(5, 1, 1, 1, &[0, 255, 100, 7]);
        files.push(("sums", sums.bytes()));
        let mut below = ByHand::new(Format::JpeglsLrgb, 2, 1);
        below.stream(1, &[20, 90]);
        below.predicted(3, 1, 1, 0, &[100, 3]);
        files.push(("sums below 0", below.bytes()));
        let mut zero = ByHand::new(Format::JpeglsLrgb, 1, 1);
        zero.stream(1, &[200]);
        zero.predicted(3, 1, 1, 0, &[0]);
        files.push(("residual 0", zero.bytes()));

        // Side information.
        let mut side = ByHand::new(Format::JpeglsLrgb, 300, 260);
        side.parameter = 30;
        for (position, value) in [
            (0, 9),
            (1, 8),
            (255, 7),
            (256, 6),
            (65_535, 5),
            (65_536, 4),
            (70_000, 203),
            (77_999, 2),
        ] {
            side.record(1, position, value);
        }
        files.push(("far records", side.bytes()));
        for parameter in [0, 30] {
            let mut side = ByHand::new(Format::JpeglsLrgb, 3, 5);
            side.parameter = parameter;
            side.record(7, 4, 200);
            files.push(("one record", side.bytes()));
            side.record(7, 4, 100);
            files.push(("two records for a texel", side.bytes()));
        }
        let mut last = ByHand::new(Format::JpeglsLrgb, 3, 5);
        last.parameter = 30;
        last.record(2, 14, 200);
        files.push(("last texel", last.bytes()));
        // Side information of the last plane alone, with bytes behind it that look like more of it.
        let mut behind = ByHand::new(Format::JpeglsLrgb, 3, 5);
        behind.parameter = 30;
        behind.record(8, 4, 200);
        files.push(("the last plane mended", behind.bytes()));
        files.push((
            "bytes behind the last record",
            [behind.bytes(), vec![0; 20]].concat(),
        ));
        behind.streams[8].extend([0, 0, 0, 6, 101]);
        files.push(("bytes between a stream and a record", behind.bytes()));
        for block in [
            vec![0; 4],
            vec![0, 0, 0, 0, 7, 1],
            vec![0, 0, 0, 15, 7],
            vec![0, 0, 1, 0, 7],
        ] {
            let mut side = ByHand::new(Format::JpeglsLrgb, 3, 5);
            side.sides[8] = block;
            files.push(("malformed side information", side.bytes()));
        }

        // Files that are refused.
        let plain = ByHand::new(Format::JpeglsLrgb, 3, 5);
        let mut lists = plain.lists();
        lists[7] = "-5 0 0 0 0 0 0 0 0".to_owned();
        files.push(("negative side size", plain.with(&plain.header(), &lists)));
        for (plane, reference, rank) in [(1, 9, 1), (1, 1, 1), (1, 2, 1), (1, 0, 0)] {
            let mut file = plain.clone();
            file.references[plane] = reference;
            file.order[plane] = rank;
            file.order[2] = 5;
            files.push(("references", file.bytes()));
        }
        let mut undefined = plain.clone();
        undefined.transforms[1] = 4;
        files.push(("an undefined transform", undefined.bytes()));
        let mut empty = plain.clone();
        empty.streams[3].clear();
        files.push(("empty stream", empty.bytes()));
        for (width, height) in [(2, 5), (3, 6), (5, 3)] {
            let mut other = plain.clone();
            let options = jpeg_ls::Options {
                near: 0,
                presets: None,
            };
            other.streams[3] =
                jpeg_ls::encode(&vec![7; (width * height) as usize], width, height, &options)
                    .stream;
            files.push(("another size", other.bytes()));
        }
        let mut other = plain.clone();
        other.streams[3] = jpeg::encode(&[9; 15], 3, 5, &jpeg::Options::new(90)).stream;
        files.push(("another codec", other.bytes()));

        // JPEG-LS as it may be.
        let smooth: Vec<u8> = (0..40u32 * 30)
            .map(|i| (i % 40 * 3 + i / 40 * 2 + i * i / 97 % 11) as u8)
            .collect();
        let presets = jpeg_ls::Presets::default();
        for (near, presets) in [
            (3, None),
            (
                0,
                Some(jpeg_ls::Presets {
                    reset: 20,
                    ..presets
                }),
            ),
            (
                0,
                Some(jpeg_ls::Presets {
                    t1: 5,
                    t2: 12,
                    t3: 40,
                    ..presets
                }),
            ),
            (
                2,
                Some(jpeg_ls::Presets {
                    t1: 9,
                    t2: 15,
                    t3: 30,
                    reset: 31,
                    ..presets
                }),
            ),
        ] {
            let mut file = ByHand::new(Format::JpeglsLrgb, 40, 30);
            file.parameter = 30;
            file.streams[2] =
                jpeg_ls::encode(&smooth, 40, 30, &jpeg_ls::Options { near, presets }).stream;
            files.push(("JPEG-LS parameters", file.bytes()));
            file.stream(3, &smooth);
            files.push(("a plane without them behind it", file.bytes()));
        }

        let dark: Vec<u8> = smooth.iter().map(|&value| value / 2).collect();
        let mut file = ByHand::new(Format::JpeglsLrgb, 40, 30);
        let options = jpeg_ls::Options {
            near: 0,
            presets: Some(jpeg_ls::Presets {
                maxval: 120,
                ..presets
            }),
        };
        file.streams[2] = jpeg_ls::encode(&dark, 40, 30, &options).stream;
        files.push(("a smaller MAXVAL", file.bytes()));

        let mut file = ByHand::new(Format::JpeglsLrgb, 4, 3);
        let options = jpeg_ls::Options {
            near: 0,
            presets: Some(jpeg_ls::Presets {
                reset: 20,
                ..presets
            }),
        };
        file.streams[2] = jpeg_ls::encode(&[20; 12], 4, 3, &options).stream;
        files.push(("presets that do not matter", file.bytes()));

        // JPEG as it may be.
        let mut draws = Draws(77);
        let noise = draws.plane(13 * 9);
        let plain = jpeg::Options::new(90);
        for options in [
            plain,
            jpeg::Options {
                optimised: true,
                ..plain
            },
            jpeg::Options {
                restart_interval: 1,
                ..plain
            },
            jpeg::Options {
                sampling: (2, 2),
                ..plain
            },
            jpeg::Options {
                quality: 20,
                baseline: true,
                ..plain
            },
            jpeg::Options {
                quality: 5,
                baseline: false,
                ..plain
            },
        ] {
            let mut file = ByHand::new(Format::JpegLrgb, 13, 9);
            file.streams[6] = jpeg::encode(&noise, 13, 9, &options).stream;
            files.push(("JPEG options", file.bytes()));
        }
        let mut file = ByHand::new(Format::JpegLrgb, 13, 9);
        let restarting = jpeg::Options {
            restart_interval: 1,
            ..plain
        };
        file.streams[8] = jpeg::encode(&noise, 13, 9, &restarting).stream;
        files.push(("restart markers in the last plane", file.bytes()));
        let mut file = ByHand::new(Format::JpegLrgb, 12, 9);
        file.streams[6] = jpeg::encode(&noise[..12 * 9], 12, 9, &plain).stream;
        files.push(("rows of twelve", file.bytes()));
        // A comment in place of the JFIF segment, and nothing at all in its place; SOF1 with narrow tables.
        let stream = jpeg::encode(&noise, 13, 9, &plain).stream;
        let without = [&stream[..2], &stream[20..]].concat();
        let comment = [&stream[..2], &[0xFF, 0xFE, 0, 4, b'h', b'i'], &stream[2..]].concat();
        let mut sof1 = stream.clone();
        let sof = sof1
            .windows(2)
            .position(|pair| pair == [0xFF, 0xC0])
            .unwrap();
        sof1[sof + 1] = 0xC1;
        for stream in [without, comment, sof1] {
            let mut file = ByHand::new(Format::JpegLrgb, 13, 9);
            file.streams[6] = stream;
            files.push(("JPEG segments", file.bytes()));
        }
        let mut side = ByHand::new(Format::JpegRgb, 8, 16);
        side.record(4, 70, 70);
        side.stream(2, &[[10; 64], [20; 64]].concat());
        side.stream(9, &[[10; 64], [20; 64]].concat());
        side.predicted(3, 1, 2, 1, &[140; 128]);
        files.push(("JPEG of quality 100 with side information", side.bytes()));
        files.push(("a small JPEG", ByHand::new(Format::JpegLrgb, 3, 2).bytes()));
        files
    }

    /// What a decoder answers to each of the witnesses, in short.
    fn answers(misreadings: &[&Misreading], files: &[(&str, Vec<u8>)]) -> Vec<Answer> {
        files
            .iter()
            .map(|(_, file)| answer(misreadings, Reading::SPEC, file, &View::Raw))
            .collect()
    }

    fn of_2_9() -> impl Iterator<Item = &'static Misreading> {
        all().filter(|misreading| misreading.clause.starts_with("2.9"))
    }

    #[test]
    fn there_are_misreadings_enough_of_2_9() {
        assert!(of_2_9().count() >= 60, "{}", of_2_9().count());
    }

    #[test]
    fn slugs_are_told_apart() {
        let mut slugs: Vec<&str> = all().map(|misreading| misreading.slug).collect();
        slugs.sort_unstable();
        let twice: Vec<_> = slugs.windows(2).filter(|pair| pair[0] == pair[1]).collect();
        assert!(twice.is_empty(), "{twice:?}");
    }

    #[test]
    fn every_misreading_of_2_9_shows_in_some_file_and_each_in_its_own_way() {
        let files = witnesses();
        let right = answers(&[], &files);
        let mut seen: BTreeMap<String, &str> = BTreeMap::new();
        let mut wrong = Vec::new();
        // These need a file that must be refused, or a list on another line; the suite's cases show them.
        let elsewhere = [
            "missing-records-forgiven",
            "compressed-size-sign-ignored",
            "motion-on-one-line-only",
            // These need larger files than the witnesses are.
            "stream-sizes-in-16-bits",
            "side-sizes-in-8-bits",
            "side-records-counted-in-8-bits",
        ];
        for misreading in of_2_9().filter(|misreading| !elsewhere.contains(&misreading.slug)) {
            let shown = answers(&[misreading], &files);
            if shown == right {
                wrong.push(format!("{} shows in no file", misreading.slug));
            } else if let Some(other) = seen.insert(format!("{shown:?}"), misreading.slug) {
                wrong.push(format!("{} and {other} show alike", misreading.slug));
            }
        }
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    }

    #[test]
    fn every_misreading_survives_every_compressed_file_cut_anywhere() {
        let file = predicting(Format::JpeglsLrgb, 3, 2, 2).bytes();
        for cut in (0..file.len()).step_by(7) {
            for misreading in all() {
                let _ = answer(&[misreading], Reading::SPEC, &file[..cut], &View::Raw);
            }
        }
        for (_, file) in witnesses() {
            for misreading in all() {
                let _ = answer(&[misreading], Reading::SPEC, &file, &View::Raw);
            }
        }
    }
}
