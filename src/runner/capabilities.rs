//! Queries the capabilities of a decoder with `DECODER capabilities`.

use crate::protocol::capabilities::Capabilities;
use crate::runner::{run::Decoder, scratch::Scratch};

/// Maximum number of bytes in an answer.
const MAX_ANSWER_BYTES: usize = 16 * 1024;

impl Decoder {
    /// Queries the capabilities of the decoder. An error is not a failure of the decoder, because the command is optional.
    ///
    /// # Errors
    /// Returns a message that describes the response if it is not a list of capabilities.
    pub fn capabilities(&self, scratch: &Scratch) -> Result<Capabilities, String> {
        Capabilities::read(&self.run_with_argument("capabilities", MAX_ANSWER_BYTES, scratch)?)
    }
}
