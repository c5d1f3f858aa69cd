//! Requests to writers.

use crate::test_case::{FileCase, RequestValues, WrittenFile};
use ptm::Size;
use ptm_harness::runner::run::Decoder;
use ptm_harness::runner::{scratch::Scratch, write::WriteCall};
use ptm_suite::protocol::frame::Answer;
use ptm_suite::protocol::request::{AttemptKind, Reply};
use ptm_suite::{cases::TableSpelling, test_case::TestCase};

/// Requests the file of a case. `attempt` determines the time limit.
pub fn request_file<V: RequestValues>(
    writer: &Decoder,
    case: &FileCase<V>,
    attempt: AttemptKind,
    scratch: &Scratch,
) -> Reply<WrittenFile> {
    let built = case.make(TableSpelling::default());
    let mut values = V::template_values(&built.request);
    let Size { width, height } = built.size;
    values.push(("format", case.format.name().to_owned()));
    values.extend([("width", width.to_string()), ("height", height.to_string())]);
    let call = WriteCall {
        request: &built.json,
        attachments: &V::attachments(&built),
        values: &values,
        max_bytes: case.max_output_bytes(&built),
        attempt,
    };
    let result = writer.write(&call, scratch);
    let answer = result.output.map_or_else(
        |answer| (answer.decoded()).expect_err("only a written file counts as decoded"),
        |bytes| Answer::Decoded(WrittenFile(bytes)),
    );
    Reply {
        stderr: result.stderr,
        exit: result.exit,
        stdout: result.stdout,
        ..answer.into()
    }
}
