//! Thresholds, weights and budgets of the diagnosis, with a reason for each.

// Score of a response that a mistake reproduces
/// Score of an explained image. Equal bytes are not a coincidence.
pub(super) const IMAGE_SCORE: i64 = 16;
/// Score of an explained refusal. Many mistakes cause refusals, so a refusal counts half as much as an image.
pub(super) const REFUSAL_SCORE: i64 = 8;
/// Score of a crash on a file that a decoder with the mistake would refuse. This is also the minimum score of a reported mistake.
pub(super) const CRASH_SCORE: i64 = 3;
/// Maximum score of a partially explained image. It is less than the score of a refusal, because other channels remain wrong.
pub(super) const PARTIAL_IMAGE_SCORE: usize = 6;
/// Score of an image of a file that a decoder with the mistake would refuse. The decoder evidently does not make this mistake.
pub(super) const REFUSED_IMAGE_SCORE: i64 = -8;
/// Score of a passing case that a decoder with the mistake would fail: the negative of `IMAGE_SCORE`.
pub(super) const CONTRADICTION_SCORE: i64 = -16;
/// Score of a correct response to a lenient case, if it differs from the answer of a decoder with the mistake.
pub(super) const OTHER_LENIENT_ANSWER_SCORE: i64 = -1;

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
/// Maximum number of misreadings that are tried on a subset of the files.
pub(super) const MAX_SCOPED_MISREADINGS: usize = 12;

// Evidence
/// Minimum number of failures that support an edit, a scope, a different choice or a statement about a format. Also the minimum
/// number of samples or texels that support a statement about an image.
pub(super) const MIN_SUPPORT: usize = 4;
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

/// Returns true if the part is more than half of `whole`.
pub(super) fn is_most(part: usize, whole: usize) -> bool {
    part * 2 > whole
}

/// Returns true if the part is positive and its share is at least [`NEARLY_ALL_RATIO`].
pub(super) fn is_nearly_all(part: usize, whole: usize) -> bool {
    let [numerator, denominator] = NEARLY_ALL_RATIO;
    part > 0 && part * denominator >= whole * numerator
}
