//! Executable mistakes: each a plausible misreading of one clause, at the one place where it acts.
//!
//! The same catalogue names the mistake of a failing decoder, measures the suite (every misreading must be caught, every
//! pair told apart), and proves that each clause is really tested.

mod arithmetic;
mod codecs;
mod compressed;
mod evaluation;
mod header;
mod layout;
mod lookup;
mod luminance;
mod side_information;

use crate::decode::{Limits, Ptm, decode_as, fields};
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
    let mut seen = file.to_vec();
    let mut reading = reading;
    for misreading in misreadings {
        match misreading.at {
            At::Bytes(edit) => match edit(&Anatomy::of(&seen)) {
                Seen::Refused => return Answer::Rejected,
                Seen::File(bytes) => seen = bytes,
            },
            At::Reading(_, change) => reading = change(reading),
            At::Planes(_) => {}
        }
    }
    let mut ptm = match decode_as(&seen, &reading, &Limits::default()) {
        Ok(ptm) => ptm,
        Err(error) if error.class() == Class::Malformed => return Answer::Rejected,
        Err(_) => return Answer::Unsupported,
    };
    for misreading in misreadings {
        if let At::Planes(edit) = misreading.at {
            edit(&mut ptm);
        }
    }
    Answer::Decoded(Frame::under(&ptm, view, &reading))
}

/// A file and its header's parts, for mistakes that act on bytes.
pub struct Anatomy<'a> {
    /// The file.
    pub file: &'a [u8],
    /// Its fields as far as they can be read.
    pub fields: Vec<Field>,
}

impl<'a> Anatomy<'a> {
    /// Takes `file` apart.
    #[must_use]
    pub fn of(file: &'a [u8]) -> Anatomy<'a> {
        Anatomy { file, fields: fields(file).0 }
    }

    /// The file, unchanged.
    #[must_use]
    pub fn unchanged(&self) -> Seen {
        Seen::File(self.file.to_vec())
    }

    /// Refused if `refused`, else unchanged.
    #[must_use]
    pub fn refused_if(&self, refused: bool) -> Seen {
        if refused { Seen::Refused } else { self.unchanged() }
    }

    /// The header's fields: all before the first byte of the payload.
    fn tokens(&self) -> impl Iterator<Item = &Field> {
        self.fields.iter().take_while(|field| !matches!(field.clause, "2.5/3" | "2.7/1" | "2.8.1/1" | "2.9.8/2" | "2.9.8/4"))
    }

    /// The text of the fields of these clauses.
    pub fn texts(&self, clauses: &[&str]) -> Vec<&'a str> {
        let chosen = self.tokens().filter(|field| clauses.contains(&field.clause));
        chosen.filter_map(|field| std::str::from_utf8(&self.file[field.range.clone()]).ok()).collect()
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
        let mut from = self.tokens().skip_while(|field| field.clause != clause).skip(n);
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
            let anatomy = Anatomy::of(&file);
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
