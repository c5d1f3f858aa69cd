//! Requests to a program to write a file.

use crate::protocol::frame::Answer;
use crate::ptm::Format;
use crate::report::reported::Reported;
use crate::runner::run::{Decoder, Reply};
use crate::runner::scratch::Scratch;
use crate::runner::write::{Attachment, WriteCall};
use crate::session::run::Run;
use crate::suite::cases::TableSpelling;
use crate::writers::cases::WriterCase;
use crate::writers::request::RequestHeader;
use crate::writers::test_case::{BuiltRequest, WriteView, WrittenFile};

/// Values of a request that a template can name, in addition to `{in}` and `{out}`.
pub const VALUES: [&str; 10] = [
    "planes", "format", "width", "height", "scale", "bias", "matrix", "quality", "near", "lp",
];

/// A case whose answer is a file.
pub trait WritingCase: Reported<View = WriteView, Output = WrittenFile> {
    /// The verb of the command line.
    const VERB: &'static str;

    /// Returns the requested format.
    fn format(&self) -> Format;
    /// Returns true if it is in the smoke subset.
    fn is_smoke(&self) -> bool;
    /// Returns the input of the program.
    fn sent(built: &Self::Built) -> Sent;
}

/// The input of a program.
pub struct Sent {
    /// The request, in which paths of attachments are names in braces.
    pub json: String,
    /// The files that it names, and the files that these name.
    pub attachments: Vec<Attachment>,
    /// Values that a template can name.
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

    fn sent(built: &BuiltRequest) -> Sent {
        Sent {
            json: String::from_utf8_lossy(&built.json).into_owned(),
            attachments: vec![Attachment {
                name: "planes".to_owned(),
                file_name: "planes.npy".to_owned(),
                bytes: built.request.array(),
            }],
            values: values(&built.request.header),
        }
    }
}

/// Sends one request for the file of a case; the timeout is multiplied by `timeout_factor`.
#[must_use]
pub fn ask<C: WritingCase>(
    writer: &Decoder,
    case: &C,
    timeout_factor: u32,
    scratch: &Scratch,
) -> Reply<WrittenFile> {
    let built = case.make(TableSpelling::default());
    let sent = C::sent(&built);
    let call = WriteCall {
        request: &sent.json,
        attachments: &sent.attachments,
        values: &[
            sent.values,
            vec![("format", case.format().name().to_owned())],
        ]
        .concat(),
        max_bytes: case.largest_answer(&built),
        timeout_factor,
    };
    let result = writer.write(&call, scratch);
    let answer = match result.output {
        Ok(bytes) => Answer::Decoded(WrittenFile(bytes)),
        Err(answer) => match answer.decoded() {
            Err(answer) => answer,
            Ok(_) => unreachable!("the decoded values are those of the file it wrote"),
        },
    };
    Reply {
        stderr: result.stderr,
        exit: result.exit,
        stdout: result.stdout,
        ..answer.into()
    }
}

/// Returns the values of a header as words of a command line; elements of lists are separated by commas.
fn values(header: &RequestHeader) -> Vec<(&'static str, String)> {
    let list = |numbers: &[f64]| {
        let numbers: Vec<String> = numbers.iter().map(f64::to_string).collect();
        numbers.join(",")
    };
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

/// Rewords the remarks on a program that is not a writer, so that they describe writers instead of decoders.
pub fn reword<C: WritingCase>(run: &mut Run<C>) {
    let Some(reason) = &run.not_a_decoder else {
        return;
    };
    let answers = || run.first.iter().map(|first| &first.reply.answer);
    let only = |wanted: fn(&Answer<WrittenFile>) -> bool| answers().all(wanted);
    let first = run
        .first
        .iter()
        .find(|first| first.reply.answer.violation().is_some());
    let says = match first {
        _ if reason.contains("cannot be") => return,
        _ if only(|answer| matches!(answer, Answer::Unsupported)) => {
            "it answers every first request with 69 (unsupported)".to_owned()
        }
        None => "it writes none of the first files, and refuses them".to_owned(),
        Some(first) => {
            let answer = &first.reply.answer;
            let what = answer.violation().unwrap_or_default();
            let stderr = match first.reply.stderr.is_empty() {
                true => String::new(),
                false => format!("\nits standard error begins:\n{}", first.reply.stderr),
            };
            format!(
                "it writes none of the first files; the first of its answers: {}: {what}{stderr}",
                answer.name()
            )
        }
    };
    run.not_a_decoder = Some(says);
}
