//! Asks a decoder what it can do: `DECODER capabilities`.

use crate::protocol::capabilities::Capabilities;
use crate::runner::run::Decoder;
use crate::runner::scratch::Scratch;

/// Maximum number of bytes of an answer.
const MAX_ANSWER_BYTES: usize = 16 * 1024;

impl Decoder {
    /// Asks for the capabilities. An error is not a failure of the decoder, because the command is optional.
    ///
    /// # Errors
    /// A sentence that says what came instead of capabilities.
    pub fn capabilities(&self, scratch: &Scratch) -> Result<Capabilities, String> {
        Capabilities::read(&self.print_out("capabilities", MAX_ANSWER_BYTES, scratch)?)
    }
}
