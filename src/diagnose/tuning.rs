//! The thresholds, weights and budgets of the diagnosis: one constant per line, with its reason above it.

// Worth of a response that a mistake reproduces
/// An image that is equal to the byte is no coincidence.
pub(super) const WORTH_OF_AN_IMAGE: i64 = 16;
/// Many mistakes end in a refusal, so it counts half as much as an image.
pub(super) const WORTH_OF_A_REFUSAL: i64 = 8;
/// A crash instead of a refusal counts less; it is the minimum worth of a named mistake.
pub(super) const WORTH_OF_A_CRASH: i64 = 3;
/// Part of an image counts less than a refusal if other channels stay wrong.
pub(super) const WORTH_OF_PART_OF_AN_IMAGE: usize = 6;
/// A refusal instead of an image: the decoder does not make the mistake.
pub(super) const WORTH_OF_A_REFUSAL_OF_AN_IMAGE: i64 = -8;
/// A passing case that the mistake would fail counts against it as much as an image counts for it.
pub(super) const WORTH_OF_A_CONTRADICTION: i64 = -16;
/// Both responses to a lenient file are correct, but the decoder gave the other one.
pub(super) const WORTH_OF_ANOTHER_LENIENT_ANSWER: i64 = -1;

// Extent of the search
/// Real readers make up to ten mistakes that show.
pub(super) const MAX_MISTAKES: usize = 12;
/// Failing cases unlike each other on which every mistake is first tried.
pub(super) const MAX_SAMPLE: usize = 40;
/// Mistakes that are compared with every case: dozens may look equally promising.
pub(super) const MAX_FINALISTS: usize = 32;
/// Samples of an image on which no mistake need be tried if smaller files fail alike.
pub(super) const MAX_SAMPLES_OF_A_SMALL_IMAGE: usize = 1 << 13;
/// Samples of an image that are as much work as one small file.
pub(super) const SAMPLES_OF_A_UNIT_OF_WORK: usize = 512;
/// Pairs of mistakes that are compared with every case.
pub(super) const MAX_PAIRS: usize = 3;
/// Units of work after which no further mistake is looked for.
pub const MAX_WORK: usize = 400_000;
/// Units of work in search of two mistakes that hide each other.
pub(super) const MAX_WORK_ON_PAIRS: usize = 8_000;
/// Failing cases on which a mistake is tried if it explains none of the sample.
pub(super) const MAX_AFFORDABLE: usize = 160;
/// Samples of the images on which every mistake is tried.
pub(super) const MAX_SAMPLES_TRIED: usize = 1 << 20;

// Edits of formulas
/// Times that every edit is tried: alone, and together with the first mistakes that were found.
pub(super) const MAX_EDIT_PASSES: usize = 2;
/// Failing files of one format and view on which every edit is tried.
pub(super) const MAX_PROBES: usize = 2;
/// Texels along each axis that separate rows, columns and texels.
pub(super) const MIN_PROBE_SIZE: u32 = 3;
/// Edits that are compared with every case.
pub(super) const MAX_EDITS: usize = 24;
/// Misreadings that are tried on part of the files.
pub(super) const MAX_SCOPED_MISREADINGS: usize = 12;

// Evidence
/// Failures that support an edit, a scope, a statement about a format, or another reading of the open questions; samples or texels
/// that support a statement about an image.
pub(super) const MIN_SUPPORT: usize = 4;
/// Files that share a property.
pub(super) const MIN_SHARING_FILES: usize = 2;
/// Files that the decoder must read before refused files without a common property mean anything.
pub(super) const MIN_READ_FILES: usize = 20;
/// A property is named if the probability of a coincidence is less than one in this number.
pub(super) const CHANCE_OF_A_PROPERTY: f64 = 50.0;
/// A share of less than one in this number may be a coincidence.
pub(super) const COINCIDENCE_DIVISOR: usize = 12;
/// A share of one in this number is a substantial part.
pub(super) const SUBSTANTIAL_DIVISOR: usize = 4;
/// A share, as numerator and denominator: the rest of a view may have a second cause.
pub(super) const NEARLY_ALL_RATIO: [usize; 2] = [3, 4];
/// The largest rounding error of colors that are computed in single precision.
pub(super) const ROUNDING_SLACK: f64 = 0.02;

/// Returns true if the part is so small that it may be chance: less than one in [`COINCIDENCE_DIVISOR`].
pub(super) fn is_few(part: usize, all: usize) -> bool {
    part * COINCIDENCE_DIVISOR < all
}

/// Returns true if the part is at least one in [`SUBSTANTIAL_DIVISOR`].
pub(super) fn is_much(part: usize, all: usize) -> bool {
    part * SUBSTANTIAL_DIVISOR >= all
}

/// Returns true if the part is more than half.
pub(super) fn is_most(part: usize, all: usize) -> bool {
    part * 2 > all
}

/// Returns true if the part is at least the share [`NEARLY_ALL_RATIO`], and not 0.
pub(super) fn is_nearly_all(part: usize, all: usize) -> bool {
    let [least, of] = NEARLY_ALL_RATIO;
    part > 0 && part * of >= all * least
}

#[cfg(test)]
mod tests {
    /// Each number is one more thing to get wrong.
    #[test]
    fn there_are_at_most_thirty_tuning_constants() {
        let is_number = |line: &&str| line.starts_with("pub") && line.contains(" const ");
        let count = include_str!("tuning.rs").lines().filter(is_number).count();
        assert!((1..=30).contains(&count), "{count} numbers");
    }
}
