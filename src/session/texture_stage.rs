//! A texture question put to a program.

use serde_json::Value;

use crate::protocol::frame::Answer;
use crate::runner::run::{Decoder, Invocation, Reply, Request};
use crate::runner::scratch::Scratch;
use crate::suite::texture::test_case::TextureView;

/// Asks once: a file with the question, and a JSON object on standard output.
#[must_use]
pub fn ask(
    decoder: &Decoder,
    request: &Request<'_, TextureView>,
    scratch: &Scratch,
) -> Reply<Value> {
    let result = decoder.invoke(
        &Invocation {
            view: &request.view.to_string(),
            file_name: "case.json",
            file: request.file,
            most: request.largest_frame,
            timeout_factor: request.timeout_factor,
        },
        scratch,
    );
    let answer = match result.output {
        Ok(bytes) => match serde_json::from_slice::<Value>(&bytes) {
            Ok(value) if value.is_object() => Answer::Decoded(value),
            Ok(other) => Answer::ProtocolError(format!("expected a JSON object, found {other}")),
            Err(error) => Answer::ProtocolError(format!("expected a JSON object: {error}")),
        },
        Err(answer) => match answer.decoded() {
            Err(answer) => answer,
            Ok(_) => unreachable!("what was decoded is what it said"),
        },
    };
    Reply {
        stderr: result.stderr,
        exit: result.exit,
        stdout: result.stdout,
        ..answer.into()
    }
}
