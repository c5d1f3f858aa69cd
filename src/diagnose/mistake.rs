//! A mistake that a decoder may make: a misreading of the catalog or an edit of a formula, everywhere or in part.

use super::scope::FileScope;
use crate::formula::Edit;
use crate::misreadings::{At, Misreading, Symptom};
use crate::protocol::frame::{Answer, Samples};

/// A mistake, and the files and channels in which it is made.
pub(super) struct Mistake {
    /// The misreading. An edit of a formula that the catalog lacks has no slug.
    pub misreading: &'static Misreading,
    pub scope: FileScope,
    pub channels: ChannelSubset,
}

impl Mistake {
    /// Returns a mistake that is made everywhere.
    pub const fn everywhere(misreading: &'static Misreading) -> Mistake {
        Mistake {
            misreading,
            scope: FileScope::All,
            channels: ChannelSubset::All,
        }
    }

    /// Returns the misreading if the catalog has it.
    pub const fn listed(&self) -> Option<&'static Misreading> {
        match self.misreading.slug.is_empty() {
            true => None,
            false => Some(self.misreading),
        }
    }

    /// Returns the misreading if it is one of the catalog and made everywhere.
    pub fn of_catalog(&self) -> Option<&'static Misreading> {
        let is_everywhere = self.scope == FileScope::All && self.channels == ChannelSubset::All;
        self.listed().filter(|_| is_everywhere)
    }
}

/// Channels of an image, in every shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ChannelSubset {
    All,
    /// One of a0 … a5, of every polynomial.
    Coefficient(usize),
    /// Red, green or blue: a color, or the polynomial of one.
    Color(usize),
    /// The channels after a5: R, G and B, or Cr and Cb.
    Chroma,
}

impl ChannelSubset {
    fn holds(self, count: usize, channel: usize) -> bool {
        match (self, count) {
            (ChannelSubset::All, _) => true,
            (ChannelSubset::Coefficient(i), 18) => channel % 6 == i,
            (ChannelSubset::Coefficient(i), 8 | 9) => channel == i,
            (ChannelSubset::Color(c), 18) => channel / 6 == c,
            (ChannelSubset::Color(c), 9) => channel == 6 + c,
            (ChannelSubset::Chroma, 8 | 9) => channel >= 6,
            (ChannelSubset::Coefficient(_) | ChannelSubset::Chroma, _) => false,
            (ChannelSubset::Color(c), _) => count == 3 && channel == c,
        }
    }

    /// Returns the narrowest set that has all these channels.
    pub fn narrowest(wrong: &[bool]) -> ChannelSubset {
        let coefficients = (0..6).map(ChannelSubset::Coefficient);
        let colors = (0..3).map(ChannelSubset::Color);
        let all = coefficients.chain(colors).chain([ChannelSubset::Chroma]);
        let has_all = |channels: &ChannelSubset| {
            (0..wrong.len()).all(|channel| !wrong[channel] || channels.holds(wrong.len(), channel))
        };
        all.into_iter().find(has_all).unwrap_or(ChannelSubset::All)
    }

    /// Returns the channels in words: ", only in a3".
    pub fn describe(self) -> String {
        match self {
            ChannelSubset::All => String::new(),
            ChannelSubset::Coefficient(i) => format!(", only in a{i}"),
            ChannelSubset::Color(c) => format!(", only in {}", ["red", "green", "blue"][c]),
            ChannelSubset::Chroma => ", only in the channels after a5".to_owned(),
        }
    }

    /// Replaces these channels of an image by those of another of the same shape.
    pub fn replace(self, image: &mut Answer, other: &Answer) {
        let (Answer::Decoded(image), Answer::Decoded(other)) = (image, other) else {
            return;
        };
        let count = image.channels as usize;
        match (&mut image.samples, &other.samples) {
            (Samples::U8(image), Samples::U8(other)) => self.replace_samples(count, image, other),
            (Samples::F32(image), Samples::F32(other)) => self.replace_samples(count, image, other),
            _ => {}
        }
    }

    fn replace_samples<T: Copy>(self, count: usize, image: &mut [T], other: &[T]) {
        for (at, (one, other)) in image.iter_mut().zip(other).enumerate() {
            if self.holds(count, at % count) {
                *one = *other;
            }
        }
    }
}

/// Returns a misreading without a slug that makes one edit.
pub(super) fn misreading_of(edit: &'static Edit) -> Misreading {
    Misreading {
        slug: "",
        clause: edit.formula.stated().clause,
        effect: "",
        fix: "",
        shows: Symptom::Values,
        seen: Vec::new(),
        at: At::Edits(std::slice::from_ref(edit)),
    }
}
