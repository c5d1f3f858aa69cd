//! Test case implementation for requests to writers. The answer to a request is a file.

use std::collections::BTreeSet;
use std::fmt;

use data_encoding::BASE64;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use crate::decode::decode;
use crate::session::observation::{Observation, Response};
use crate::suite::cases::{Expect, TableSpelling};
use crate::suite::dialect::{Choices, Right};
use crate::suite::features::Feature;
use crate::suite::test_case::{Allowance, Comparison, TestCase};
use crate::writers::cases::WriterCase;
use crate::writers::fault::WriterFault;
use crate::writers::judge::judge;
use crate::writers::request::WriteRequest;

/// The only view of a writer: `write`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WriteView;

impl fmt::Display for WriteView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("write")
    }
}

/// File that a writer wrote.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WrittenFile(pub Vec<u8>);

impl WrittenFile {
    /// Returns true if both files decode to the same values, or neither can be decoded.
    pub(super) fn decodes_equally(&self, other: &WrittenFile) -> bool {
        self == other || decode(&self.0).ok() == decode(&other.0).ok()
    }
}

/// Returns the wrong file in an observation and its fault, if there is one.
pub(super) fn wrong_file<C>(observation: Option<&Observation<C>>) -> Option<(&[u8], &WriterFault)>
where
    C: TestCase<Output = WrittenFile, Difference = WriterFault>,
{
    match &observation?.response {
        Response::Image {
            frame: Some(file),
            difference: Some(fault),
            ..
        } => Some((&file.0, fault)),
        _ => None,
    }
}

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

/// Request in the form in which it is sent.
pub struct BuiltRequest {
    /// Request with all values.
    pub request: WriteRequest,
    /// JSON of the request, with a placeholder as the path of the planes.
    pub json: Vec<u8>,
}

impl TestCase for WriterCase {
    type View = WriteView;
    type Output = WrittenFile;
    type Difference = WriterFault;
    type Feature = Feature;
    type Built = BuiltRequest;
    type Decisions = ();

    const VIEWS: &'static [&'static str] = &["write"];
    const CHOICES: Choices<()> = Choices(&[]);
    const ACCEPTED_MESSAGE: &'static str = "wrote a file although no legal file exists";
    const UNSUPPORTED_MESSAGE: &'static str =
        "exited with 69 (unsupported), but writes other files of this kind";

    fn id(&self) -> &str {
        &self.id
    }

    fn clauses(&self) -> &[String] {
        &self.clauses
    }

    fn because(&self) -> String {
        self.because.clone()
    }

    fn expect(&self) -> Expect {
        self.expect
    }

    fn expectation(&self) -> &'static str {
        match self.expect {
            Expect::Refuse => "refuse",
            _ => "write",
        }
    }

    fn is_first(&self) -> bool {
        self.first
    }

    fn views(&self) -> &[WriteView] {
        &[WriteView]
    }

    fn kind(&self) -> Feature {
        Feature::Format(self.format())
    }

    fn features(&self, _: &WriteView) -> BTreeSet<Feature> {
        let mut features = BTreeSet::from([self.kind()]);
        if self.entries().is_some_and(|entries| entries > 256) {
            features.insert(Feature::LargeTables);
        }
        features
    }

    fn make(&self, _: TableSpelling) -> BuiltRequest {
        let request = self.request();
        BuiltRequest {
            json: request.header.to_json().into_bytes(),
            request,
        }
    }

    fn file(built: &BuiltRequest) -> &[u8] {
        &built.json
    }

    /// Returns twice the size of the planes plus the maximum size of a header.
    fn largest_answer(&self, built: &BuiltRequest) -> usize {
        2 * built.request.samples.len() + 65_536
    }

    fn compare(
        &self,
        built: &BuiltRequest,
        _: &WriteView,
        file: &WrittenFile,
    ) -> Comparison<WriterCase> {
        let difference = match self.expect {
            Expect::Refuse => Some(WriterFault::new(&self.clauses[0], self.fault())),
            _ => judge(&built.request, &file.0).err(),
        };
        Comparison {
            right: Right::InAll(difference.is_none()),
            difference,
            allowance: Allowance::None,
        }
    }

    fn is_equivalent(one: &WrittenFile, other: &WrittenFile) -> bool {
        one.decodes_equally(other)
    }

    fn expected_text(&self) -> Option<String> {
        (self.expect == Expect::Decode).then(|| "a file".to_owned())
    }

    fn fault(&self) -> String {
        match self.entries() {
            Some(entries) => {
                format!("{entries} distinct polynomials are more than two bytes can index")
            }
            None => "no legal file has these values".to_owned(),
        }
    }
}
