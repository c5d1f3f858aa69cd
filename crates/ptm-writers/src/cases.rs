//! Cases of the writer suite: requests with expected results.

use std::collections::BTreeMap;

use serde::Deserialize;

use crate::reference::write_requested_file;
use crate::request::{PredictionAdvice, RequestHeader, WriteRequest};
use crate::test_case::{BuiltRequest, ComparedFrames, FileCase, RequestValues};
use crate::{diagnose::diagnose, fault::WriterFault, judge::judge};
use ptm::decode::decode;
use ptm::{Coding, Format, ScaleBias};
use ptm_files::join_texts;
use ptm_generate::{Model, Recipe, plan::Residuals, recipe::Indices};
use ptm_harness::diagnose::Diagnosis;
use ptm_harness::runner::write::Attachment;
use ptm_harness::session::run::RunOf;
use ptm_mistakes::Misreading;
use ptm_suite::cases::{Expect, Suite};
use ptm_suite::kit::yaml::records;
use ptm_suite::protocol::frame::{Frame, Samples, ViewKind};
use ptm_suite::{name::SuiteName, recipes::MakeRecord, words::Words};

/// YAML source of the embedded requests.
const REQUESTS: &str = ptm_spec_cases::writers::REQUESTS;

/// Case of the writer suite: a request whose values are the requested contents of the file.
pub type WriterCase = FileCase<Recipe>;

/// Request as written in YAML. With `for_each`, it expands to one case for every combination of the listed words.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RequestRecord {
    id: String,
    clauses: Vec<String>,
    because: String,
    #[serde(default)]
    for_each: BTreeMap<String, Vec<String>>,
    make: MakeRecord,
    expect: Expect,
    #[serde(default)]
    first: bool,
    /// Ids of expanded cases in the smoke subset, or `[all]` for all of them.
    #[serde(default)]
    smoke: Vec<String>,
}

/// Loads the embedded suite of requests.
///
/// # Errors
/// Returns a message that names the invalid line or request.
pub fn load_writer_requests() -> Result<Suite<WriterCase>, String> {
    let records = records(REQUESTS).map_err(|error| format!("requests.yaml: {error}"))?;
    let mut cases: Vec<WriterCase> = Vec::new();
    for (line, record) in records {
        let record: RequestRecord = record;
        for words in Words::combinations(&record.for_each) {
            let id = words.id(&record.id);
            let locate = |error| format!("requests.yaml: line {line}: {id}: {error}");
            if cases.iter().any(|case| case.id == id) {
                return Err(locate("duplicate request".to_owned()));
            }
            cases.push(record.case(&words).map_err(locate)?);
        }
    }
    Ok(Suite { cases })
}

impl RequestRecord {
    fn case(&self, words: &Words) -> Result<WriterCase, String> {
        let mut recipe = self.make.recipe(words)?;
        if recipe.format.has_table() {
            // Use every entry in the planes if there are enough texels.
            recipe.indices = Indices::List((0..recipe.entries).collect());
        }
        recipe.compression.residuals = Residuals::Natural;
        let id = words.id(&self.id);
        Ok(WriterCase {
            smoke: self.first || self.smoke.contains(&id) || self.smoke == ["all"],
            id,
            clauses: self.clauses.clone(),
            because: words.fill(&self.because),
            expect: self.expect,
            first: self.first,
            format: recipe.format,
            values: recipe,
        })
    }
}

impl WriterCase {
    /// Returns the request, with the placeholder `{planes}` for the path of the planes.
    #[must_use]
    pub fn request(&self) -> WriteRequest {
        self.values.build(self.format).request
    }
}

impl RequestValues for Recipe {
    type Request = WriteRequest;

    const SUITE: SuiteName = SuiteName::Writers;
    const VERB: &'static str = "write";
    const EXPECTED: &'static str = "a file";
    const PLACEHOLDERS: &'static [&'static str] = &[
        "planes", "format", "width", "height", "scale", "bias", "matrix", "quality", "near",
    ];

    fn entries(&self) -> Option<u32> {
        self.format.has_table().then_some(self.entries)
    }

    fn build(&self, format: Format) -> BuiltRequest<WriteRequest> {
        let mut plain = self.clone();
        let plan = &self.compression;
        let set = ScaleBias {
            scale: self.scale.values,
            bias: self.bias.values,
        };
        let mut header = RequestHeader::new(format, self.size, &set);
        match format.coding() {
            Some(Coding::Jpeg) => header.quality = Some(plan.parameter),
            Some(Coding::JpegLs) => header.near = Some(plan.parameter),
            None => header.matrix = (format == Format::Lum).then_some(self.matrix.values),
        }
        if format.coding().is_some() {
            plain.format = format.uncompressed();
            header.prediction = plan.predicts().then(|| PredictionAdvice {
                references: plan.references.clone(),
                order: plan.order.clone(),
                transforms: plan.transforms.clone(),
                motion_x: plan.motion_x.clone(),
                motion_y: plan.motion_y.clone(),
            });
        }
        let (json, samples) = (header.to_json(), Model::paint(&plain).samples);
        BuiltRequest {
            json,
            size: self.size,
            request: WriteRequest {
                header,
                format,
                samples,
            },
        }
    }

    fn attachments(built: &BuiltRequest<WriteRequest>) -> Vec<Attachment> {
        vec![Attachment {
            name: "planes".to_owned(),
            file_name: "planes.npy".to_owned(),
            bytes: built.request.to_npy(),
        }]
    }

    fn template_values(request: &WriteRequest) -> Vec<(&'static str, String)> {
        let header = &request.header;
        let list = |numbers: &[f64]| join_texts(numbers, ",");
        let matrix = header.matrix.map_or(String::new(), |matrix| list(&matrix));
        let number = |number: Option<u8>| number.map_or(String::new(), |number| number.to_string());
        vec![
            ("scale", list(&header.scale)),
            ("bias", join_texts(header.bias, ",")),
            ("matrix", matrix),
            ("quality", number(header.quality)),
            ("near", number(header.near)),
        ]
    }

    fn judge(request: &WriteRequest, _: Format, file: &[u8]) -> Result<(), WriterFault> {
        judge(request, file)
    }

    fn reference_file(request: &WriteRequest, _: Format) -> Option<Vec<u8>> {
        write_requested_file(request).ok()
    }

    /// Compares all planes, unless they may differ because of lossy compression.
    fn images(request: &WriteRequest, format: Format, file: &[u8]) -> Option<ComparedFrames> {
        let ptm = decode(file).ok()?;
        let channels = format.channels();
        let is_comparable = ptm.planes.samples.len() == request.samples.len()
            && (ptm.header.size.width, ptm.header.size.height)
                == (request.header.width, request.header.height);
        let shape = [request.header.width, request.header.height, channels as u32];
        let frame =
            |samples: &[u8]| Frame::exact(ViewKind::Raw, shape, Samples::U8(samples.to_vec()));
        (is_comparable && !request.is_lossy()).then(|| ComparedFrames {
            caption: "The planes: requested and written".to_owned(),
            expected: frame(&request.samples),
            written: frame(&ptm.planes.samples),
        })
    }

    fn to_bytes(built: &BuiltRequest<WriteRequest>) -> Vec<u8> {
        [built.json.as_bytes(), &built.request.samples].concat()
    }

    fn describe(built: &BuiltRequest<WriteRequest>) -> (&'static str, String) {
        ("The request", built.json.clone())
    }

    fn diagnose(
        suite: &Suite<WriterCase>,
        run: &RunOf<WriterCase>,
        threads: usize,
    ) -> Vec<Diagnosis<&'static Misreading>> {
        diagnose(suite, run, threads)
    }
}
