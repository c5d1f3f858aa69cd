//! A mistake that a decoder may make: a misreading or an edit of a formula, in all formats or in some of them.

use ptm::Format;
use ptm_mistakes::formula::Edit;
use ptm_mistakes::{Change, Misreading};
use ptm_suite::protocol::frame::{Answer, Samples};

/// A mistake, and the files and channels that it affects.
pub(super) struct Mistake {
    /// The misreading. Its slug is empty if the mistake is an edit of a formula outside the catalog.
    pub misreading: &'static Misreading,
    /// The formats that the mistake affects, or `None` for all formats.
    pub formats: Option<Vec<Format>>,
    pub channels: ChannelSubset,
}

impl Mistake {
    /// Creates a mistake that affects all channels of all files.
    pub const fn unrestricted(misreading: &'static Misreading) -> Mistake {
        Mistake {
            misreading,
            formats: None,
            channels: ChannelSubset::All,
        }
    }

    /// Returns the misreading if it is in the catalog.
    pub const fn catalog_misreading(&self) -> Option<&'static Misreading> {
        match self.misreading.slug.is_empty() {
            true => None,
            false => Some(self.misreading),
        }
    }

    /// Returns the section of the misread clause and the number of the clause: 2, 9, 4 and 2 for 2.9.4/2.
    pub fn section(&self) -> Vec<u32> {
        let numbers = self.misreading.clause.split(['.', '/']);
        numbers.filter_map(|number| number.parse().ok()).collect()
    }

    /// Returns true if the mistake affects files in this format.
    pub fn affects(&self, format: Format) -> bool {
        let formats = self.formats.as_ref();
        formats.is_none_or(|formats| formats.contains(&format))
    }

    /// Returns the misreading if it is in the catalog and affects all channels of all files.
    pub fn unrestricted_misreading(&self) -> Option<&'static Misreading> {
        let is_unrestricted = self.formats.is_none() && self.channels == ChannelSubset::All;
        self.catalog_misreading().filter(|_| is_unrestricted)
    }
}

/// Names of the colors.
pub(super) const COLORS: [&str; 3] = ["red", "green", "blue"];

/// A subset of the channels of an image, independent of the number of channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ChannelSubset {
    All,
    /// One of the coefficients a0 … a5, in every polynomial.
    Coefficient(usize),
    /// Red, green or blue: a color, or the polynomial of that color.
    Color(usize),
    /// Channels after a5: R, G and B, or Cr and Cb.
    Chroma,
    /// A coefficient of the polynomial of red, green or blue.
    ColorCoefficient(usize, usize),
}

impl ChannelSubset {
    fn contains(self, count: usize, channel: usize) -> bool {
        match (self, count) {
            (ChannelSubset::All, _) => true,
            (ChannelSubset::Coefficient(i), 18) => channel % 6 == i,
            (ChannelSubset::Coefficient(i), 8 | 9) => channel == i,
            (ChannelSubset::Color(c), 18) => channel / 6 == c,
            (ChannelSubset::Color(c), 9) => channel == 6 + c,
            (ChannelSubset::Chroma, 8 | 9) => channel >= 6,
            (ChannelSubset::ColorCoefficient(i, c), 18) => channel == 6 * c + i,
            (
                ChannelSubset::Coefficient(_)
                | ChannelSubset::ColorCoefficient(..)
                | ChannelSubset::Chroma,
                _,
            ) => false,
            (ChannelSubset::Color(c), _) => count == 3 && channel == c,
        }
    }

    /// Returns the smallest subset that contains all wrong channels.
    pub fn smallest_containing(wrong: &[bool]) -> ChannelSubset {
        let coefficients = (0..6).map(ChannelSubset::Coefficient);
        let colors = (0..3).map(ChannelSubset::Color);
        let single =
            (0..18).map(|channel| ChannelSubset::ColorCoefficient(channel % 6, channel / 6));
        let all = single
            .chain(coefficients)
            .chain(colors)
            .chain([ChannelSubset::Chroma]);
        let covers = |channels: &ChannelSubset| {
            (0..wrong.len())
                .all(|channel| !wrong[channel] || channels.contains(wrong.len(), channel))
        };
        all.into_iter().find(covers).unwrap_or(ChannelSubset::All)
    }

    /// Returns a phrase that names the channels, such as ", only in a3".
    pub fn describe(self) -> String {
        match self {
            ChannelSubset::All => String::new(),
            ChannelSubset::Coefficient(i) => format!(", only in a{i}"),
            ChannelSubset::Color(c) => format!(", only in {}", COLORS[c]),
            ChannelSubset::ColorCoefficient(i, c) => {
                format!(", only in a{i} of {}", COLORS[c])
            }
            ChannelSubset::Chroma => ", only in the channels after a5".to_owned(),
        }
    }

    /// Replaces these channels of `image` with those of `other`, an image of the same shape.
    pub fn replace_in_image(self, image: &mut Answer, other: &Answer) {
        let (Answer::Decoded(image), Answer::Decoded(other)) = (image, other) else {
            return;
        };
        let count = image.channels as usize;
        match (&mut image.samples, &other.samples) {
            (Samples::U8(image), Samples::U8(other)) => self.replace(count, image, other),
            (Samples::F32(image), Samples::F32(other)) => self.replace(count, image, other),
            _ => {}
        }
    }

    /// Replaces these channels of `image`, which has `count` channels, with those of `other`.
    pub fn replace<T: Copy>(self, count: usize, image: &mut [T], other: &[T]) {
        let channels: Vec<usize> = (0..count).filter(|&i| self.contains(count, i)).collect();
        for (texel, other) in image.chunks_exact_mut(count).zip(other.chunks_exact(count)) {
            for &i in &channels {
                texel[i] = other[i];
            }
        }
    }
}

/// Returns a misreading that consists of these edits and has no slug.
pub(super) fn edits_as_misreading(edits: &'static [Edit]) -> Misreading {
    Misreading::unlisted(edits[0].formula.stated().clause, Change::Edits(edits))
}
