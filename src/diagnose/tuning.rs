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
/// A misreading that explains one in so many failures is named before edits are tried.
pub(super) const MUCH: usize = 4;
/// Failures that an edit, a scope, or another reading of the open questions must explain to be believed.
pub(super) const MIN_FAILURES_OF_A_READING: usize = 4;

// Edits of formulas
/// Times that every edit is tried: beside nothing, and beside the first mistakes that were found.
pub(super) const MAX_EDIT_PASSES: usize = 2;
/// Failing files of one format and view on which every edit is tried.
pub(super) const MAX_PROBES: usize = 2;
/// Texels along each axis that separate rows, columns and texels.
pub(super) const MIN_PROBE_SIZE: u32 = 3;
/// Edits that are held against every case.
pub(super) const MAX_EDITS: usize = 24;
/// Misreadings for which the files in which they are made are looked for.
pub(super) const MAX_SCOPED_MISREADINGS: usize = 12;
/// A value changes in a learned table if one in so many of its texels says so; lossy planes differ by one in a few.
pub(super) const MIN_SHARE_OF_A_TABLE: usize = 5;

// Coincidences
/// A property is named if at most one in so many suites would have it by chance.
pub(super) const CHANCE_OF_A_PROPERTY: f64 = 50.0;
/// Files that share a property.
pub(super) const MIN_SHARING_FILES: usize = 2;
/// Files of one size that bound those of others.
pub(super) const MIN_FILES_OF_A_SIZE: usize = 3;
/// A mistake that explains one in so many failures, none about its clause, agrees with them by chance.
pub(super) const STRAY_SHARE: usize = 12;
/// One image among so many refusals agrees by chance.
pub(super) const REFUSALS_PER_CHANCE_IMAGE: usize = 12;
/// A property is named if it explains one in so many of the failures that nothing else explains.
pub(super) const MIN_SHARE_OF_A_PROPERTY: usize = 5;

#[cfg(test)]
mod tests {
    /// Prints the table, and bounds its length: each number is one more thing to get wrong.
    #[test]
    fn at_most_thirty_numbers_decide() {
        let source = include_str!("tuning.rs");
        let mut rows = 0;
        let mut reason = "";
        for line in source.lines() {
            if let Some(text) = line.strip_prefix("/// ") {
                reason = text;
            } else if let Some((name, value)) = line
                .strip_prefix("pub(super) const ")
                .or_else(|| line.strip_prefix("pub const "))
                .and_then(|rest| rest.split_once(": "))
            {
                let value = value.split_once("= ").map_or("", |parts| parts.1);
                println!("{name:<34} {:<10} {reason}", value.trim_end_matches(';'));
                rows += 1;
            }
        }
        assert!((1..=30).contains(&rows), "{rows} numbers");
    }
}
