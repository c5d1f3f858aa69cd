//! A call that writes a file: its inputs are a request and attachments, its output is a file.
//!
//! The limits are those of every call. The file is expected in the working directory, opened without following links, and read
//! only up to the maximum size of a correct file.

use std::ffi::OsString;
use std::path::PathBuf;

use crate::protocol::frame::Answer;
use crate::runner::run::{CallResult, Decoder, Failure, INPUT_CHANGED_MESSAGE};
use crate::runner::scratch::{Scratch, is_untouched};
use crate::runner::template::Template;

/// A file that a request names.
#[derive(Clone, Debug)]
pub struct Attachment {
    /// Its name in a template and in the request's text, where it is in braces.
    pub name: String,
    /// The name of the file.
    pub file_name: String,
    /// Its contents.
    pub bytes: Vec<u8>,
}

/// A request to write one file.
#[derive(Clone, Debug)]
pub struct WriteCall<'a> {
    /// The request in JSON. A string `"{name}"` in it stands for the path of the attachment of that name.
    pub request: &'a str,
    /// The files that it names.
    pub attachments: &'a [Attachment],
    /// Values that a template may name.
    pub values: &'a [(&'static str, String)],
    /// Maximum size of the written file, in bytes.
    pub most: usize,
    /// Factor for the timeout.
    pub timeout_factor: u32,
}

impl Decoder {
    /// Returns the same program, called as `program args… VERB REQUEST OUT` unless a template calls it.
    #[must_use]
    pub fn as_writer(&self, verb: &str) -> Decoder {
        let words = [verb, "{in}", "{out}"].map(OsString::from);
        let command = [self.command(), &words].concat();
        match self.template {
            Some(_) => self.clone(),
            None => self.program_from_template(Template::of_words(&command)),
        }
    }

    /// Requests a file; the output of the call is the file.
    ///
    /// # Panics
    /// If the program is not called [as a writer](Decoder::as_writer).
    #[must_use]
    pub fn write(&self, call: &WriteCall, scratch: &Scratch) -> CallResult {
        self.retry(|| self.attempt_to_write(call, scratch))
    }

    fn attempt_to_write(
        &self,
        order: &WriteCall,
        scratch: &Scratch,
    ) -> Result<CallResult, Failure> {
        let template = self
            .template
            .as_ref()
            .expect("a writer is called by a template");
        let mut workspace = scratch.workspace()?;
        let mut inputs: Vec<(PathBuf, &[u8])> = Vec::new();
        let mut request = order.request.to_owned();
        let values = order.values.iter();
        let mut values: Vec<(&str, OsString)> =
            values.map(|(name, value)| (*name, value.into())).collect();
        for attachment in order.attachments {
            let path = workspace.lay_down(&attachment.file_name, &attachment.bytes)?;
            let name = format!("\"{{{}}}\"", attachment.name);
            request = request.replace(&name, &in_json(&path.to_string_lossy()));
            values.push((&attachment.name, path.clone().into()));
            inputs.push((path, &attachment.bytes));
        }
        let input = workspace.lay_down("request.json", request.as_bytes())?;
        let workplace = workspace.workplace.clone();
        let output = template.output_file(&workplace)?;
        let output = output.expect("a writer's template names its output");
        let words = template.words_of_values(&input, &workplace, &values);
        let time = self.timeout.saturating_mul(order.timeout_factor);
        let mut result = self.call(&words, 1 << 20, time, &workplace)?;
        result.stderr = workspace.without_directories(&result.stderr);
        if output.is_longer_than(order.most) {
            let says = format!("more than {} bytes in its output file", order.most);
            result.output = Err(Answer::Flooded(says));
        } else if let Ok(stdout) = &mut result.output {
            result.stdout = std::mem::take(stdout);
            result.output = output.read(order.most)?;
        }
        inputs.push((input, request.as_bytes()));
        for (path, bytes) in inputs {
            if !is_untouched(&path, bytes)? {
                result.output = Err(Answer::Tampered(INPUT_CHANGED_MESSAGE.to_owned()));
            }
        }
        Ok(result)
    }
}

/// Returns text as a JSON string.
fn in_json(text: &str) -> String {
    serde_json::to_string(text).expect("text is JSON")
}
