//! Thresholds, weights and budgets of the diagnosis, with a reason for each.

// Weights of reproduced responses, which decide which mistake is tried first
/// Weight of an image. Equal bytes are not a coincidence.
pub(super) const IMAGE_WEIGHT: i64 = 16;
/// Weight of a refusal. Many mistakes cause refusals, so a refusal counts half as much as an image.
pub(super) const REFUSAL_WEIGHT: i64 = 8;
/// Weight of a crash on a file that a decoder with the mistake would refuse.
pub(super) const NO_IMAGE_WEIGHT: i64 = 3;
/// Minimum weight of the failures that a mistake reproduces.
pub(super) const MIN_WEIGHT: i64 = NO_IMAGE_WEIGHT;

// Extent of the search
/// Maximum number of mistakes in a result. The known decoders have at most ten detectable mistakes.
pub(super) const MAX_MISTAKES: usize = 12;
/// Maximum size of the diverse sample of failing cases on which every mistake is tried first.
pub(super) const MAX_SAMPLE: usize = 40;
/// Maximum number of mistakes that are compared with every case. Dozens may look equally promising.
pub(super) const MAX_FINALISTS: usize = 32;
/// Maximum number of samples in a small image. Larger images are skipped unless only larger images are left.
pub(super) const MAX_SMALL_IMAGE_SAMPLES: usize = 1 << 13;
/// Number of image samples that cost as much as one small file.
pub(super) const SAMPLES_PER_WORK_UNIT: usize = 512;
/// Maximum number of pairs of mistakes that are compared with every case.
pub(super) const MAX_PAIRS: usize = 3;
/// Units of work after which the search stops.
pub const MAX_WORK: usize = 400_000;
/// Maximum number of units of work for finding a pair of mistakes that mask each other.
pub(super) const MAX_PAIR_WORK: usize = 8_000;
/// Maximum number of failing cases on which every mistake is tried if no mistake explains enough of the sample.
pub(super) const MAX_FALLBACK_CASES: usize = 160;
/// Maximum total number of samples in the images on which every mistake is tried.
pub(super) const MAX_TRIED_SAMPLES: usize = 1 << 20;

// Edits of formulas
/// Maximum number of passes over the edits. The first pass tries each edit alone. The second pass tries each edit together with
/// the mistakes already found.
pub(super) const MAX_EDIT_PASSES: usize = 2;
/// Maximum number of failing files per format and view on which every edit is tried.
pub(super) const MAX_PROBES: usize = 2;
/// Minimum width and height, in texels, of an image that distinguishes mistakes about rows, columns and texels from each other.
pub(super) const MIN_PROBE_SIZE: u32 = 3;
/// Maximum number of edits that are compared with every case.
pub(super) const MAX_EDITS: usize = 24;
/// Maximum number of misreadings that are tried on some formats only.
pub(super) const MAX_RESTRICTED_MISREADINGS: usize = 12;

// Evidence
/// Minimum number of failures that support an edit, a scope, a different choice or a statement about a format. Also the minimum
/// number of samples or texels that support a statement about an image.
pub(super) const MIN_SUPPORT: usize = 4;
/// Minimum number of images that support an edit that is limited to some channels in some formats, or of failures that support a
/// mistake in the first view that it changes, whatever it does in later views.
pub(super) const MIN_TWICE_LIMITED_IMAGES: usize = 16;
/// Minimum number of files that share a reported property.
pub(super) const MIN_SHARING_FILES: usize = 2;
/// Minimum number of files that the decoder must read before a property that the refused files share is considered significant.
pub(super) const MIN_READ_FILES: usize = 20;
/// A property is reported if the probability of a coincidence is less than one in this many.
pub(super) const COINCIDENCE_ODDS: f64 = 50.0;
/// A share of less than one in this many may be a coincidence.
pub(super) const COINCIDENCE_DIVISOR: usize = 12;
/// A share of at least one in this many is substantial.
pub(super) const SUBSTANTIAL_DIVISOR: usize = 4;
/// Minimum share (numerator and denominator) that counts as nearly all. The remaining cases may have a different cause.
pub(super) const NEARLY_ALL_RATIO: [usize; 2] = [3, 4];
/// Maximum rounding error of colors computed in single precision.
pub(super) const ROUNDING_SLACK: f64 = 0.02;

/// Returns true if the part is small enough to be a coincidence: less than one in [`COINCIDENCE_DIVISOR`].
pub(super) fn is_few(part: usize, whole: usize) -> bool {
    part * COINCIDENCE_DIVISOR < whole
}

/// Returns true if the part is substantial: at least one in [`SUBSTANTIAL_DIVISOR`].
pub(super) fn is_substantial(part: usize, whole: usize) -> bool {
    part * SUBSTANTIAL_DIVISOR >= whole
}

/// Returns true if the part is at least one in three.
pub(super) fn is_third(part: usize, whole: usize) -> bool {
    part * 3 >= whole
}

/// Returns true if the part is more than half of `whole`.
pub(super) fn is_most(part: usize, whole: usize) -> bool {
    part * 2 > whole
}

/// Returns true if the part is positive and its share is at least [`NEARLY_ALL_RATIO`].
pub(super) fn is_nearly_all(part: usize, whole: usize) -> bool {
    let [numerator, denominator] = NEARLY_ALL_RATIO;
    part > 0 && part * denominator >= whole * numerator
}
