//! Asks a decoder what it can do: `DECODER capabilities`.

use crate::protocol::capabilities::Capabilities;
use crate::runner::run::Decoder;
use crate::runner::scratch::Scratch;

/// Most bytes of an answer that are read.
const LONGEST: usize = 16 * 1024;

impl Decoder {
    /// Asks for the capabilities. The error says why there are none that count; it is no fault, because the program never
    /// promised to know the question.
    ///
    /// # Errors
    /// A sentence that says what came instead.
    pub fn capabilities(&self, scratch: &Scratch) -> Result<Capabilities, String> {
        Capabilities::read(&self.print_out("capabilities", LONGEST, scratch)?)
    }
}
