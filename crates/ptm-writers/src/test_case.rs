//! Test cases whose answer is a file: requests to writers and fitters, including the parts that are used only in reports.

use std::collections::BTreeSet;
use std::fmt;

use data_encoding::BASE64;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use crate::fault::WriterFault;
use ptm::decode::decode;
use ptm::{Format, Size};
use ptm_harness::diagnose::Diagnosis;
use ptm_harness::pipeline::{Checkable, FoundCauses};
use ptm_harness::runner::write::Attachment;
use ptm_harness::session::run::RunOf;
use ptm_mistakes::Misreading;
use ptm_suite::cases::{Expect, Suite, TableSpelling};
use ptm_suite::dialect::{Choices, RightDialects};
use ptm_suite::kit::digest::sha256;
use ptm_suite::protocol::frame::Frame;
use ptm_suite::test_case::{Allowance, Comparison, Listed, Output, TestCase};
use ptm_suite::verdicts::observation::{Observation, Response};
use ptm_suite::{features::Feature, name::SuiteName};

/// The only view of a writer: `write`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WriteView;

impl fmt::Display for WriteView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("write")
    }
}

/// File written by the program under test.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WrittenFile(pub Vec<u8>);

impl Serialize for WrittenFile {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&BASE64.encode(&self.0))
    }
}

impl<'de> Deserialize<'de> for WrittenFile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<WrittenFile, D::Error> {
        let text = String::deserialize(deserializer)?;
        let bytes = BASE64.decode(text.as_bytes()).map_err(de::Error::custom)?;
        Ok(WrittenFile(bytes))
    }
}

impl Output for WrittenFile {
    /// Returns true if both files decode to the same values, or if neither can be decoded.
    fn is_equivalent(&self, other: &WrittenFile) -> bool {
        self == other || decode(&self.0).ok() == decode(&other.0).ok()
    }
}

/// Request for a file, with the expected result.
#[derive(Clone, Debug)]
pub struct FileCase<V> {
    /// Permanent slug of the case.
    pub id: String,
    /// Clauses that the case tests.
    pub clauses: Vec<String>,
    /// Purpose of the case, in a sentence.
    pub because: String,
    /// Expected result: a file with the values, or a refusal.
    pub expect: Expect,
    /// True if the case runs before all other cases.
    pub first: bool,
    /// True if the case is in the smoke subset.
    pub smoke: bool,
    /// Requested format.
    pub format: Format,
    /// Values of the request.
    pub values: V,
}

/// Request in the form in which the program receives it.
pub struct BuiltRequest<R> {
    /// Request with all values.
    pub request: R,
    /// JSON of the request. Names in braces are placeholders for the paths of attachments.
    pub json: String,
    /// Size of the requested map.
    pub size: Size,
}

/// Images of what was requested and of what a file contains.
pub struct ComparedFrames {
    /// What the images show.
    pub caption: String,
    /// Requested values, or the best possible ones.
    pub expected: Frame,
    /// Values of the file.
    pub written: Frame,
}

/// Values from which a file is written: a map, or photographs.
pub trait RequestValues: Clone + fmt::Debug + Send + Sync + 'static {
    /// Request with all values.
    type Request;

    /// Name of the suite.
    const SUITE: SuiteName;
    /// Verb on the command line of the program.
    const VERB: &'static str;
    /// Description of the expected result, unless it is a refusal.
    const EXPECTED: &'static str;
    /// Names of the placeholders of a template, in addition to `{in}` and `{out}`.
    const PLACEHOLDERS: &'static [&'static str];

    /// Returns the number of distinct polynomials for formats with a table, or `None` for other formats.
    fn entries(&self) -> Option<u32> {
        None
    }
    /// Creates the request for a file in the given format.
    fn build(&self, format: Format) -> BuiltRequest<Self::Request>;
    /// Returns the files that the request refers to, directly or indirectly.
    fn attachments(built: &BuiltRequest<Self::Request>) -> Vec<Attachment>;
    /// Returns the values that a template can refer to, other than the format and the size.
    #[must_use]
    fn template_values(_: &Self::Request) -> Vec<(&'static str, String)> {
        Vec::new()
    }
    /// Judges a file in the given format.
    ///
    /// # Errors
    /// Returns the fault of the file.
    fn judge(request: &Self::Request, format: Format, file: &[u8]) -> Result<(), WriterFault>;
    /// Returns the file that the reference writes, if it can.
    fn reference_file(request: &Self::Request, format: Format) -> Option<Vec<u8>>;
    /// Returns images of the requested and of the written values, if a file can be compared in this way.
    fn images(request: &Self::Request, format: Format, file: &[u8]) -> Option<ComparedFrames>;
    /// Returns all values as bytes, for the digest of the suite.
    fn to_bytes(built: &BuiltRequest<Self::Request>) -> Vec<u8>;
    /// Returns a caption, and text that describes the request on a page.
    fn describe(built: &BuiltRequest<Self::Request>) -> (&'static str, String);
    /// Returns the causes of the failures of `run`.
    fn diagnose(
        suite: &Suite<FileCase<Self>>,
        run: &RunOf<FileCase<Self>>,
        threads: usize,
    ) -> Vec<Diagnosis<&'static Misreading>>;
}

/// Returns the wrong file in an observation and the fault of this file. Returns `None` if there is no wrong file.
#[must_use]
pub fn wrong_file(
    observation: Option<&Observation<WriteView, WrittenFile, WriterFault>>,
) -> Option<(&[u8], &WriterFault)> {
    match &observation?.response {
        Response::Image {
            frame: Some(file),
            difference: Some(fault),
            ..
        } => Some((&file.0, fault)),
        _ => None,
    }
}

impl<V: RequestValues> Listed for FileCase<V> {
    const SUITE: SuiteName = V::SUITE;

    fn digest(suite: &Suite<FileCase<V>>) -> String {
        let digests = suite.cases.iter().map(|case| {
            let built = case.values.build(case.format);
            sha256(&V::to_bytes(&built))
        });
        sha256(digests.collect::<String>().as_bytes())
    }

    fn id(&self) -> &str {
        &self.id
    }

    fn clauses(&self) -> &[String] {
        &self.clauses
    }

    fn because(&self) -> String {
        self.because.clone()
    }

    fn expectation_name(&self) -> &'static str {
        match self.expect {
            Expect::Refuse => "refuse",
            Expect::Lenient => "lenient",
            _ => "write",
        }
    }
}

impl<V: RequestValues> TestCase for FileCase<V> {
    type View = WriteView;
    type Output = WrittenFile;
    type Difference = WriterFault;
    type Built = BuiltRequest<V::Request>;
    type Decisions = ();

    const VIEWS: &'static [&'static str] = &["write"];
    const CHOICES: Choices<()> = Choices(&[]);
    const ACCEPTED_MESSAGE: &'static str = "wrote a file, although no legal file has these values";
    const UNSUPPORTED_MESSAGE: &'static str =
        "exited with 69 (unsupported), but writes other files of this kind";

    fn expect(&self) -> Expect {
        self.expect
    }

    fn is_first(&self) -> bool {
        self.first
    }

    fn views(&self) -> &[WriteView] {
        &[WriteView]
    }

    fn kind(&self) -> Feature {
        Feature::Format(self.format)
    }

    fn features(&self, _: &WriteView) -> BTreeSet<Feature> {
        let is_large = self.values.entries().is_some_and(|entries| entries > 256);
        let large = is_large.then_some(Feature::LargeTables);
        [self.kind()].into_iter().chain(large).collect()
    }

    /// A case that must be refused depends on all other cases of its format.
    fn twins(cases: &[FileCase<V>]) -> Vec<Vec<usize>> {
        let is_refused = |case: &FileCase<V>| case.expect == Expect::Refuse;
        let is_twin = |one: &FileCase<V>, of: &FileCase<V>| {
            is_refused(of) && !is_refused(one) && one.format == of.format
        };
        let twins = |case: &FileCase<V>| -> Vec<usize> {
            (0..cases.len())
                .filter(|&i| is_twin(&cases[i], case))
                .collect()
        };
        cases.iter().map(twins).collect()
    }

    fn make(&self, _: TableSpelling) -> BuiltRequest<V::Request> {
        self.values.build(self.format)
    }

    fn file(built: &BuiltRequest<V::Request>) -> &[u8] {
        built.json.as_bytes()
    }

    /// Returns twice the size of the planes plus the maximum size of a header.
    fn max_output_bytes(&self, built: &BuiltRequest<V::Request>) -> usize {
        2 * built.size.texels() * self.format.channels() + 65_536
    }

    fn compare(
        &self,
        built: &BuiltRequest<V::Request>,
        _: &WriteView,
        file: &WrittenFile,
    ) -> Comparison<FileCase<V>> {
        let difference = match self.expect {
            Expect::Refuse => Some(WriterFault::new(&self.clauses[0], self.fault())),
            _ => V::judge(&built.request, self.format, &file.0).err(),
        };
        Comparison {
            right: RightDialects::Regardless(difference.is_none()),
            difference,
            allowance: Allowance::None,
        }
    }

    fn expected_text(&self) -> Option<String> {
        (self.expect == Expect::Decode).then(|| V::EXPECTED.to_owned())
    }

    fn fault(&self) -> String {
        let Some(entries) = self.values.entries() else {
            return "no legal file has these values".to_owned();
        };
        format!("{entries} distinct polynomials are more than two bytes can index")
    }
}

impl<V: RequestValues> Checkable for FileCase<V> {
    fn find_causes(
        suite: &Suite<FileCase<V>>,
        run: &RunOf<FileCase<V>>,
        _: &[String],
        jobs: usize,
    ) -> FoundCauses {
        FoundCauses::new(suite, &V::diagnose(suite, run, jobs).into())
    }
}
