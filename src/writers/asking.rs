//! Requests to writers.

use crate::protocol::frame::Answer;
use crate::ptm::Format;
use crate::report::reported::Reported;
use crate::runner::run::{Decoder, Reply};
use crate::runner::scratch::Scratch;
use crate::runner::write::{Attachment, WriteCall};
use crate::session::run::Run;
use crate::suite::cases::TableSpelling;
use crate::tools::join_texts;
use crate::writers::cases::WriterCase;
use crate::writers::request::RequestHeader;
use crate::writers::test_case::{BuiltRequest, WriteView, WrittenFile};

/// Names of request values that a template can refer to, in addition to `{in}` and `{out}`.
pub const VALUES: [&str; 10] = [
    "planes", "format", "width", "height", "scale", "bias", "matrix", "quality", "near", "lp",
];

/// Case whose answer is a file.
pub trait WritingCase: Reported<View = WriteView, Output = WrittenFile> {
    /// Verb on the command line of the program.
    const VERB: &'static str;

    /// Returns the requested format.
    fn format(&self) -> Format;
    /// Returns true if the case is in the smoke subset.
    fn is_smoke(&self) -> bool {
        true
    }
    /// Returns the input for the program.
    fn sent(built: &Self::Built) -> RequestInput;
}

/// Input for a writer or fitter.
pub struct RequestInput {
    /// Request in JSON, with names in braces as placeholders for the paths of attachments.
    pub json: String,
    /// Files that the request refers to, directly or indirectly.
    pub attachments: Vec<Attachment>,
    /// Values that a template can refer to.
    pub values: Vec<(&'static str, String)>,
}

impl WritingCase for WriterCase {
    const VERB: &'static str = "write";

    fn format(&self) -> Format {
        WriterCase::format(self)
    }

    fn is_smoke(&self) -> bool {
        self.smoke
    }

    fn sent(built: &BuiltRequest) -> RequestInput {
        RequestInput {
            json: String::from_utf8_lossy(&built.json).into_owned(),
            attachments: vec![Attachment {
                name: "planes".to_owned(),
                file_name: "planes.npy".to_owned(),
                bytes: built.request.to_npy(),
            }],
            values: values(&built.request.header),
        }
    }
}

/// Requests the file of a case. The timeout is multiplied by `timeout_factor`.
#[must_use]
pub fn ask<C: WritingCase>(
    writer: &Decoder,
    case: &C,
    timeout_factor: u32,
    scratch: &Scratch,
) -> Reply<WrittenFile> {
    let built = case.make(TableSpelling::default());
    let mut sent = C::sent(&built);
    let format = case.format().name().to_owned();
    sent.values.push(("format", format));
    let call = WriteCall {
        request: &sent.json,
        attachments: &sent.attachments,
        values: &sent.values,
        max_bytes: case.largest_answer(&built),
        timeout_factor,
    };
    let result = writer.write(&call, scratch);
    let answer = match result.output {
        Ok(bytes) => Answer::Decoded(WrittenFile(bytes)),
        Err(answer) => {
            (answer.decoded()).expect_err("the decoded values are those of the file it wrote")
        }
    };
    Reply {
        stderr: result.stderr,
        exit: result.exit,
        stdout: result.stdout,
        ..answer.into()
    }
}

/// Formats the values of a header for a command line. Elements of lists are separated by commas.
fn values(header: &RequestHeader) -> Vec<(&'static str, String)> {
    let list = |numbers: &[f64]| join_texts(numbers, ",");
    let matrix = header.matrix.map_or(String::new(), |matrix| list(&matrix));
    let number = |number: Option<u8>| number.map_or(String::new(), |number| number.to_string());
    vec![
        ("width", header.width.to_string()),
        ("height", header.height.to_string()),
        ("scale", list(&header.scale)),
        ("bias", list(&header.bias.map(|bias| bias as f64))),
        ("matrix", matrix),
        ("quality", number(header.quality)),
        ("near", number(header.near)),
    ]
}

/// Rewords the reason why a program is not a writer, so that it describes writers instead of decoders.
pub fn reword<C: WritingCase>(run: &mut Run<C>) {
    let Some(reason) = &run.not_a_decoder else {
        return;
    };
    let mut first = run.first.iter().map(|first| &first.reply);
    let is_unsupported = |reply: &Reply<_>| matches!(reply.answer, Answer::Unsupported);
    let says = match first
        .clone()
        .find(|first| first.answer.violation().is_some())
    {
        _ if reason.contains("cannot be") => return,
        _ if first.all(is_unsupported) => {
            "it answers every first request with 69 (unsupported)".to_owned()
        }
        None => "it writes none of the first files, and refuses them".to_owned(),
        Some(Reply { answer, stderr, .. }) => {
            let what = answer.violation().unwrap_or_default();
            let stderr = match stderr.is_empty() {
                true => String::new(),
                false => format!("\nits standard error begins:\n{stderr}"),
            };
            format!(
                "it writes none of the first files; the first of its answers: {}: {what}{stderr}",
                answer.name()
            )
        }
    };
    run.not_a_decoder = Some(says);
}
