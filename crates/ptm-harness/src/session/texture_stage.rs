//! Sends texture questions to a program.

use serde_json::Value;

use crate::runner::run::Decoder;
use crate::runner::scratch::Scratch;
use ptm_suite::protocol::request::{Reply, Request};
use ptm_suite::texture::cases::TextureView;

/// Sends a file with a question and reads a JSON object from standard output.
#[must_use]
pub fn send_question(
    decoder: &Decoder,
    request: &Request<'_, TextureView>,
    scratch: &Scratch,
) -> Reply<Value> {
    let result = decoder.invoke(request, "case.json", request.max_frame_bytes, scratch);
    result.into_reply(|bytes| match serde_json::from_slice::<Value>(bytes) {
        Ok(value) if value.is_object() => Ok(value),
        Ok(other) => Err(format!("expected a JSON object, found {other}")),
        Err(error) => Err(format!("expected a JSON object: {error}")),
    })
}
