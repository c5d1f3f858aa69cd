//! What lint can report: a stable code for each problem, the damages and cases that provoke it, and what to fix.
//!
//! Codes are permanent. E: the file breaks a rule, or the reference cannot read it. W: the reference reads it, and some
//! readers refuse it or show another picture. I: it is in order; for information.

use serde::{Deserialize, Serialize};

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// The file breaks a rule, or the reference cannot read it.
    Error,
    /// Some readers refuse it or show another picture.
    Warning,
    /// For information.
    Info,
}

impl Severity {
    /// In a word.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Info => "info",
        }
    }
}

/// A problem that lint can report.
#[derive(Debug, PartialEq, Eq)]
pub struct Code {
    /// `PTM-E001`; permanent.
    pub id: &'static str,
    /// How bad it is.
    pub severity: Severity,
    /// The clause it is about.
    pub clause: &'static str,
    /// The problem in a sentence.
    pub says: &'static str,
    /// What a writer does about it; empty where there is nothing to do.
    pub fix: &'static str,
    /// Names of damages, and ids of cases, of which every one provokes it. A damage stands at one error code only: it is
    /// the code of each must-reject case that is made by it.
    pub provoked_by: &'static [&'static str],
}

const fn code(
    severity: Severity,
    id: &'static str,
    clause: &'static str,
    says: &'static str,
    fix: &'static str,
    provoked_by: &'static [&'static str],
) -> Code {
    Code {
        id,
        severity,
        clause,
        says,
        fix,
        provoked_by,
    }
}

macro_rules! codes {
    ($($name:ident = $severity:ident $id:literal $clause:literal $says:literal $fix:literal $provoked_by:expr;)*) => {
        $(
            #[allow(clippy::doc_markdown, reason = "what lint says is no Markdown")]
            #[doc = $says]
            pub static $name: Code = code(Severity::$severity, $id, $clause, $says, $fix, &$provoked_by);
        )*

        /// All codes, errors first, in the order of the text.
        pub static ALL: &[&Code] = &[$(&$name),*];
    };
}

codes! {
    NOT_A_PTM = Error "PTM-E001" "2.1/1"
        "the file does not begin with PTM_1.2"
        "begin the file with the line PTM_1.2, in capitals and with nothing before it"
        ["file-empty", "not-a-ptm", "byte-order-mark", "version-lower-case", "version-behind-a-letter"];
    OTHER_VERSION = Error "PTM-E002" "2.1/1"
        "the file is of another version of the format"
        "write version 1.2; the payload of 1.1 interleaves coefficients and colors"
        ["version-1.1", "version-1.3", "version-2.0", "version-longer", "version-1.0", "version-of-three-parts", "version-with-a-letter", "version-without-its-part"];
    UNKNOWN_FORMAT = Error "PTM-E003" "2.2/1"
        "no format has that name"
        "write one of the nine names of 2.2, such as PTM_FORMAT_LRGB"
        ["format-unknown", "format-cut", "format-lower-case", "format-with-a-letter-behind", "format-with-a-word-behind", "format-behind-a-letter", "format-without-its-last-letter", "format-without-its-beginning", "format-in-mixed-case", "format-with-its-end-in-lower-case"];
    CARRIAGE_RETURN = Error "PTM-E005" "2.0/1"
        "the header contains a carriage return"
        "open the file in binary mode and end lines with a line feed alone"
        ["cr-lf", "cr-alone"];
    TAB = Error "PTM-E006" "2.0/1"
        "the header contains a tab"
        "separate numbers with spaces"
        ["tabs"];
    LAYOUT = Error "PTM-E007" "2.0/1"
        "the header has blanks, an empty line or extra words where none are allowed"
        "begin lines with their first word, and write at most one space before the line feed"
        ["two-spaces-before-newline", "leading-blank", "leading-blank-before-scale", "empty-line", "size-of-three-numbers", "size-and-a-word", "bias-seven", "bias-and-a-word"];
    HEADER_ENDS = Error "PTM-E008" "2.0/1"
        "the file ends within its header"
        "write the header to its end; was the file cut?"
        ["header-ends-in-scales", "header-ends-before-biases", "header-ends-in-references"];

    SIZE_NOT_A_NUMBER = Error "PTM-E010" "2.3/1"
        "width or height is not a whole number"
        "write both sides as decimal digits"
        ["width-no-number", "width-with-a-letter", "width-hexadecimal", "width-fraction", "height-with-a-letter",
         "height-hexadecimal", "height-missing"];
    SIZE_OUT_OF_RANGE = Error "PTM-E011" "2.3/3"
        "width or height is zero, negative or beyond 32 bits"
        "write sides of at least 1"
        ["width-zero", "height-zero", "both-sizes-zero", "width-negative", "height-negative", "both-sizes-negative",
         "width-beyond-64-bits", "width-beyond-32-bits", "width-double-zero", "height-beyond-32-bits"];
    TOO_LARGE = Error "PTM-E012" "2.3/3"
        "the planes need more memory than this program allows"
        "split the map; few readers take planes of more than 1 GiB"
        ["product-beyond-32-bits", "absurdly-large"];

    SCALE = Error "PTM-E020" "2.4/3"
        "a scale is not a finite decimal number"
        "write scales as decimal numbers, with a point whatever the locale"
        ["scale-nan", "scale-inf", "scale-infinity", "scale-hexadecimal", "scale-overflows", "scale-no-number",
         "scale-decimal-comma", "scale-two-points", "scale-only-a-point", "scale-exponent-empty", "scale-letter-behind",
         "first-scale-letter-behind", "scale-underscore"];
    BIAS = Error "PTM-E021" "2.4/4"
        "a bias is not an integer"
        "write biases as decimal integers; put fractions into the coefficients"
        ["bias-nan", "bias-no-number", "bias-fraction", "bias-letter-behind", "bias-hexadecimal", "bias-inf",
         "bias-overflows", "bias-underscore", "last-bias-fraction"];
    TOO_FEW_NUMBERS = Error "PTM-E022" "2.4/2"
        "there are not six scales and six biases"
        "write six scales, then six biases, whatever the format"
        ["scale-missing", "bias-missing", "scale-seven"];

    ENTRY_COUNT = Error "PTM-E030" "2.5/2"
        "the number of table entries is not a whole number"
        "write the number of entries in decimal digits"
        ["entries-negative", "entries-no-number", "entries-with-a-letter", "entries-fraction", "entries-beyond-64-bits"];
    MATRIX = Error "PTM-E040" "2.6/2"
        "a matrix element is not a finite decimal number"
        "write sixteen decimal numbers, columns first"
        ["matrix-no-number", "matrix-letter-behind", "matrix-inf", "matrix-overflows", "matrix-decimal-comma", "matrix-nan"];
    MATRIX_SHORT = Error "PTM-E041" "2.6/1"
        "the color matrix has fewer than sixteen elements"
        "write sixteen numbers after the biases of a PTM_FORMAT_LUM file"
        ["matrix-missing-an-element", "matrix-missing"];

    LISTS_SHORT = Error "PTM-E050" "2.9/3"
        "a list of a compressed file has too few numbers"
        "write a number for every plane in each list, two in the motion vectors, and the parameter before them"
        ["parameter-missing", "transform-missing", "motion-x-missing", "motion-y-missing", "motion-y-line-missing",
         "order-missing", "references-missing", "compressed-size-missing", "side-size-missing"];
    LIST_NUMBER = Error "PTM-E051" "2.9/3"
        "an element of a list is not a whole number that fits 64 bits"
        "write decimal integers"
        ["transform-no-number", "motion-no-number", "order-no-number", "references-no-number", "compressed-size-no-number",
         "compressed-size-beyond-64-bits", "parameter-fraction"];
    TRANSFORM = Error "PTM-E052" "2.9.2/5"
        "a transform has undefined bits"
        "use 0, 1 (inversion), 2 (motion) or 3 (both)"
        ["transform-4", "transform-5", "transform-256", "transform-negative"];
    NOT_A_PLANE = Error "PTM-E053" "2.9.5/3"
        "a plane is predicted from one that does not exist"
        "count planes from 0; write -1 for a plane that is not predicted"
        ["refers-past-the-last-plane", "refers-far-past-the-last-plane", "refers-to-a-plane-of-another-format"];
    NOT_CAUSAL = Error "PTM-E054" "2.9.4/2"
        "a plane is predicted from one that is not decoded before it"
        "give every plane a higher rank than its reference; the order list holds ranks, plane by plane"
        ["rank-of-the-reference", "rank-below-the-reference", "plane-0-comes-late", "refers-to-itself",
         "refers-in-a-cycle", "intra-refers-to-itself"];
    NEGATIVE_SIZE = Error "PTM-E055" "2.9.6/2"
        "a plane or its side information has a negative size"
        "write how many bytes there are"
        ["compressed-size-negative", "side-size-negative"];

    INDEX = Error "PTM-E060" "2.8/1"
        "an index points past the last entry of the table"
        "count entries from 0, and write the number of entries that there are"
        ["entries-zero", "index-past-the-last-entry", "index-first-past-the-last-entry",
         "index-in-the-middle-past-the-last-entry", "index-largest"];
    PAYLOAD_ENDS = Error "PTM-E070" "2.7/3"
        "the file has fewer bytes than its header announces"
        "check sizes and counts against what is written; was the file cut, or written in text mode?"
        ["no-payload", "one-byte-short", "two-bytes-short", "last-texel-missing", "last-row-missing", "half-payload",
         "colors-missing", "blue-missing", "table-cut", "entries-beyond-the-file", "no-planes", "last-plane-missing",
         "last-plane-cut", "last-side-information-cut", "compressed-size-one-more", "last-compressed-size-one-more",
         "compressed-size-near-31-bits", "compressed-sizes-beyond-31-bits-together", "compressed-size-beyond-32-bits",
         "compressed-size-near-63-bits", "side-size-beyond-the-file", "side-size-near-31-bits", "side-size-beyond-32-bits"];

    NOT_A_STREAM = Error "PTM-E080" "2.9.8/3"
        "a plane is not a stream of the file's codec"
        "write a whole stream from SOI to EOI for each plane, of the codec that the format names"
        ["compressed-size-zero", "stream-empty", "stream-without-soi", "stream-of-a-png", "stream-without-markers",
         "stream-of-the-other-codec"];
    OTHER_PICTURE = Error "PTM-E081" "2.9.8/3"
        "a stream has another size than the map, or more than one component"
        "compress each plane as a gray picture of the map's width and height"
        ["stream-wider", "stream-higher", "stream-of-exchanged-sides", "stream-of-three-components",
         "all-streams-of-three-components"];
    STREAM_DAMAGED = Error "PTM-E082" "2.9.8/3"
        "a stream is damaged or ends early"
        "check the compressed sizes, and that the whole stream is written"
        ["compressed-size-one-less", "stream-ends-in-its-header", "stream-missing-eoi", "stream-cut",
         "stream-with-another-marker-in-its-data", "stream-without-tables", "stream-data-of-zeros"];
    STREAM_KIND = Error "PTM-E083" "2.9.8/3"
        "a stream is of a kind that the reference does not read"
        "use sequential JPEG with Huffman coding, or JPEG-LS, of 8 bits"
        ["stream-says-progressive", "stream-of-twelve-bits", "stream-of-no-rows"];
    RECORD_CUT = Error "PTM-E090" "2.9.8/5"
        "side information is no whole number of records"
        "write five bytes a record: the position, high byte first, and the value"
        ["side-size-1", "side-size-4", "side-size-6"];
    POSITION = Error "PTM-E091" "2.9.8/6"
        "a record corrects a texel that does not exist"
        "count positions from 0 along the stored rows, high byte first"
        ["position-past-the-last-texel", "position-near-31-bits", "position-with-the-highest-bit", "position-near-32-bits"];

    SPACE_AFTER_NAME = Warning "PTM-W101" "2.0/2"
        "a space precedes the line feed of the version or of the format"
        "omit the space; it is legal, but many readers then do not recognize the file as a PTM"
        ["space-behind-version-rgb", "space-behind-format-lrgb"];
    SIZE_ON_ONE_LINE = Warning "PTM-W102" "2.3/2"
        "width and height are on one line"
        "write two lines, as HP's programs do; many readers read nothing else"
        ["size-on-one-line-lum", "size-on-one-line-ptm-lut"];
    SCALE_BIAS_ON_ONE_LINE = Warning "PTM-W103" "2.4/6"
        "scales and biases are on one line"
        "write two lines, as HP's programs do; many readers read nothing else"
        ["scale-and-bias-on-one-line-rgb", "scale-and-bias-on-one-line-lum"];
    WIDE_GAP = Warning "PTM-W104" "2.4/5"
        "several spaces separate two numbers"
        "write one space; some readers fail on two"
        ["gap-of-2-spaces-rgb", "gap-of-5-spaces-lrgb"];
    LIST_LAYOUT = Warning "PTM-W105" "2.9/2"
        "the lists of a compressed file do not have a line each"
        "write a line for each list and two for the motion vectors, as HP's encoder does"
        ["lists-in-layout-one-line-jpeg-lrgb", "lists-in-layout-number-per-line-jpegls-rgb",
         "lists-in-layout-motion-on-one-line-jpeg-rgb"];
    MATRIX_LAYOUT = Warning "PTM-W106" "2.6/2"
        "the color matrix is on several lines"
        "write its sixteen numbers on one line"
        ["lum-matrix-in-lines-of-1", "lum-matrix-in-lines-of-4"];
    BIAS_AS_FLOAT = Warning "PTM-W107" "2.4/4"
        "a bias is written with a point or an exponent"
        "write integers; readers that scan for an integer stop at the point"
        ["bias-as-float"];
    BIAS_BEYOND_16_BITS = Warning "PTM-W108" "2.4/4"
        "a bias is beyond 16 bits"
        "keep biases between -32768 and 32767"
        ["bias-beyond-16-bits-lrgb", "bias-beyond-16-bits-rgb"];
    TRAILING = Warning "PTM-W110" "2.7/3"
        "bytes follow the last value"
        "end the file there; readers that compare its length with its header refuse it"
        ["newline-behind", "bytes-behind"];
    HUGE_TABLE = Warning "PTM-W111" "2.8.1/3"
        "the table has more than 65,536 entries, which two bytes cannot name"
        "write the entries that are used, at most 65,536"
        ["table-of-65537-entries-ptm-lut", "table-of-70000-entries-ptm-c-lut"];
    MATRIX_LAST_ROW = Warning "PTM-W112" "2.6/3"
        "the last row of the color matrix is not 0 0 0 1"
        "write 0 0 0 1 as elements 3, 7, 11 and 15; is the matrix transposed?"
        ["lum-last-row-53"];
    RANKS = Warning "PTM-W120" "2.9.4/3"
        "ranks repeat, leave gaps or do not begin at 0, or a reference is below -1"
        "number the planes from 0 in the order in which they are decoded; write -1 for none"
        ["ranks-below-minus-one-jpeg-lrgb", "ranks-equal-ranks-jpeg-lrgb", "ranks-gaps-jpegls-lrgb",
         "ranks-no-rank-zero-jpegls-lrgb"];
    PARAMETER = Warning "PTM-W121" "2.9.1/2"
        "the compression parameter is out of its range"
        "write the JPEG quality, 20 to 100, or the largest loss of JPEG-LS, 0 to 127"
        ["parameter-0", "parameter-19", "parameter-101", "parameter-300", "parameter-negative"];
    NEAR = Warning "PTM-W122" "2.9.1/2"
        "a JPEG-LS stream has another NEAR than the parameter says"
        "write the NEAR of the encoder as the parameter"
        ["parameter-3-jpegls-lrgb"];
    RECORD_TWICE = Warning "PTM-W123" "2.9.8/8"
        "two records correct one texel"
        "write one; readers may take either"
        ["record-twice-jpeg-lrgb", "record-twice-jpegls-lrgb"];

    CHOICE_LUT_COUNT = Warning "PTM-W301" "2.5/2"
        "no spelling of the number of entries is known to all readers (ruling lut-count)"
        ""
        ["table-spelled-256-false-ptm-lut", "table-spelled-nentries-256-false-ptm-c-lut"];
    CHOICE_LUT_NEWLINE = Warning "PTM-W302" "2.5/3"
        "readers that expect a line feed between table and indices refuse the file or show another picture (ruling lut-newline)"
        ""
        ["table-spelled-256-false-ptm-lut"];
    CHOICE_LUM_VECTOR = Warning "PTM-W303" "2.6/4"
        "readers whose matrix multiplies (Cr, Y, Cb, 1) show other colors (ruling lum-vector)"
        "use PTM_FORMAT_LRGB, whose colors all readers agree on"
        ["first-lum"];
    CHOICE_LUM_MAJOR = Warning "PTM-W304" "2.6/3"
        "readers that take the matrix row by row show other colors (ruling lum-major)"
        "use PTM_FORMAT_LRGB, whose colors all readers agree on"
        ["first-lum"];
    CHOICE_LUM_RANGE = Warning "PTM-W305" "2.6/5"
        "readers whose colors run from 0 to 1 show other colors (ruling lum-range)"
        "write a matrix without a translation"
        ["lum-translated-0-0"];
    CHOICE_JPEG_LS_OFFSET = Warning "PTM-W306" "2.9.5/5"
        "readers that do not subtract 128 from JPEG-LS residuals show other values (ruling jpeg-ls-offset)"
        "do not predict planes of JPEG-LS files"
        ["planes-in-structure-chain-jpegls-rgb", "planes-in-structure-star-jpegls-rgb"];
    CHOICE_MOTION_SIGN = Warning "PTM-W307" "2.9.3/3"
        "readers whose vectors point from the predictor to the texel show other values (ruling motion-sign)"
        "do not use motion compensation; no public reader implements it"
        ["motion-along-rows-9x7-jpeg-rgb", "motion-along-rows-by-minus-one-texel-jpeg-lrgb"];
    CHOICE_MOTION_VERTICAL = Warning "PTM-W308" "2.9.3/4"
        "readers whose y grows downwards in the picture show other values (ruling motion-vertical)"
        "do not use motion compensation; no public reader implements it"
        ["motion-along-diagonals-jpeg-rgb", "motion-across-rows-by-one-texel-jpeg-lrgb"];
    CHOICE_MOTION_HALF = Warning "PTM-W309" "2.9.3/5"
        "readers that round means down show other values (ruling motion-half)"
        "use whole displacements"
        ["motion-by-half-a-texel-between-columns-jpeg-rgb", "motion-between-texels-of-noise-jpeg-rgb"];
    CHOICE_MOTION_BORDER = Warning "PTM-W310" "2.9.3/6"
        "readers that do not repeat the edge of a plane show other values (ruling motion-border)"
        "do not use motion compensation; no public reader implements it"
        ["motion-far-beyond-the-right-jpeg-rgb", "motion-far-beyond-a-corner-jpeg-lrgb"];
    CHOICE_MOTION_INVERSION = Warning "PTM-W311" "2.9.2/6"
        "readers that invert after motion compensation show other values (ruling motion-inversion)"
        "use inversion or motion compensation, not both"
        ["motion-inverted-between-columns-jpeg-rgb", "motion-in-structure-deep-jpeg-lrgb"];
    CHOICE_SIDE_LOSSLESS = Warning "PTM-W312" "2.9.8/10"
        "readers that skip the side information of lossless files show other values (ruling side-lossless)"
        "write no side information where the parameter is 0"
        ["record-although-lossless-jpegls-rgb", "record-although-lossless-in-a-reference-jpegls-lrgb"];

    STREAM_EXTRAS = Warning "PTM-W401" "2.9.8/3"
        "a stream has application data, comments or fill bytes that no encoder of planes writes"
        "omit them; readers with a minimal codec may fail"
        ["stream-application-data", "stream-comments", "stream-fill-bytes"];
    STREAM_TRAILING = Warning "PTM-W402" "2.9.8/3"
        "bytes follow the end of a stream within its plane"
        "count the stream's bytes in its compressed size, and no more"
        ["stream-bytes-behind"];
    STREAM_MAXVAL = Warning "PTM-W403" "2.9.8/3"
        "a JPEG-LS stream has samples of fewer than 256 values"
        "write MAXVAL 255, or no preset parameters at all"
        ["presets-with-a-smaller-largest-sample-jpegls-lrgb"];
    OTHER_TRANSFORM = Warning "PTM-W404" "2.9.8/11"
        "a reader with another inverse DCT may show 255 for 0 or 0 for 255"
        "write side information for texels so close to 0 or 255"
        ["overflows-corrected-at-quality-60-chain-jpeg-lrgb"];

    SPACE_BEFORE_NEWLINE = Info "PTM-I101" "2.0/2"
        "a space precedes a line feed of the header"
        ""
        ["space-behind-width-rgb", "space-behind-scale-lrgb", "space-behind-the-matrix", "space-behind-the-count-ptm-lut"];
    SCALE_ZERO = Info "PTM-I201" "2.4/3"
        "a scale is 0: its coefficient has no effect"
        ""
        ["scale-zero-lrgb", "scale-zero-rgb"];
    ENTRIES_UNUSED = Info "PTM-I202" "2.5/2"
        "entries of the table are not used"
        "omit them; with at most 256 entries an index takes one byte"
        ["first-ptm-lut", "first-ptm-c-lut"];
    PREDICTION_UNUSED = Info "PTM-I203" "2.9.2/1"
        "a transform or a vector has no effect, because its plane is not predicted or its transform lacks the bit"
        "write 0"
        ["intra-planes-have-transforms-jpeg-lrgb"];
    RESTARTS = Info "PTM-I204" "2.9.8/3"
        "a stream has a restart interval"
        "omit it; readers with a minimal codec may fail"
        ["stream-restart-interval-unused"];
}

/// The code of each ruling of kind *choice* that changes a picture.
pub static RULINGS: &[(&str, &Code)] = &[
    ("lum-vector", &CHOICE_LUM_VECTOR),
    ("lum-major", &CHOICE_LUM_MAJOR),
    ("lum-range", &CHOICE_LUM_RANGE),
    ("jpeg-ls-offset", &CHOICE_JPEG_LS_OFFSET),
    ("motion-sign", &CHOICE_MOTION_SIGN),
    ("motion-vertical", &CHOICE_MOTION_VERTICAL),
    ("motion-half", &CHOICE_MOTION_HALF),
    ("motion-border", &CHOICE_MOTION_BORDER),
    ("motion-inversion", &CHOICE_MOTION_INVERSION),
    ("side-lossless", &CHOICE_SIDE_LOSSLESS),
];

impl Code {
    /// The code of that id.
    #[must_use]
    pub fn named(id: &str) -> Option<&'static Code> {
        ALL.iter().find(|code| code.id == id).copied()
    }

    /// The code of a must-reject file made by this damage, or of the must-reject case of this id.
    #[must_use]
    pub fn of(damage_or_case: &str) -> Option<&'static Code> {
        ALL.iter()
            .find(|code| {
                code.severity == Severity::Error && code.provoked_by.contains(&damage_or_case)
            })
            .copied()
    }
}
