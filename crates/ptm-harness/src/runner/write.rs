//! Calls that write a file. The inputs are a request and attachments, and the output is a file.
//!
//! These calls have the same limits as all others. The output file must be in the working directory. It is opened without
//! following links, and read only up to the maximum size of a correct file.

use std::ffi::OsString;
use std::path::PathBuf;

use crate::runner::run::{CallFailure, CallResult, Decoder, INPUT_CHANGED_MESSAGE};
use crate::runner::scratch::{Scratch, is_unchanged};
use crate::runner::template::Template;
use ptm_suite::protocol::frame::Answer;
use ptm_suite::protocol::request::AttemptKind;

/// A file that a request refers to.
#[derive(Clone, Debug)]
pub struct Attachment {
    /// Name of the placeholder for the file. The placeholder appears in braces in a template and in the text of the request.
    pub name: String,
    /// Name of the file.
    pub file_name: String,
    /// Contents of the file.
    pub bytes: Vec<u8>,
}

/// A request to write a file.
#[derive(Clone, Debug)]
pub struct WriteCall<'a> {
    /// Request in JSON. Each string `"{name}"` in it is replaced with the path of the attachment called `name`.
    pub request: &'a str,
    /// Files that the request refers to.
    pub attachments: &'a [Attachment],
    /// Values that a template may refer to.
    pub values: &'a [(&'static str, String)],
    /// Maximum size of the written file, in bytes.
    pub max_bytes: usize,
    /// The kind of attempt, which determines the time limit.
    pub attempt: AttemptKind,
}

impl Decoder {
    /// Returns a copy of this decoder that is called as `program args… VERB REQUEST OUT`, or through its template if it has one.
    #[must_use]
    pub fn as_writer(&self, verb: &str) -> Decoder {
        let words = [verb, "{in}", "{out}"].map(OsString::from);
        let command = [self.command(), &words].concat();
        match self.template {
            Some(_) => self.clone(),
            None => self.with_command_line(Template::from_words(&command)),
        }
    }

    /// Requests a file. [`CallResult::output`] holds the contents of the file, or the failure.
    ///
    /// # Panics
    /// Panics if the program is not called [as a writer](Decoder::as_writer).
    #[must_use]
    pub fn write(&self, call: &WriteCall, scratch: &Scratch) -> CallResult {
        self.retry(|| self.try_to_write(call, scratch))
    }

    fn try_to_write(&self, call: &WriteCall, scratch: &Scratch) -> Result<CallResult, CallFailure> {
        let template = self
            .template
            .as_ref()
            .expect("a writer is called through a template");
        let mut workspace = scratch.workspace()?;
        let mut inputs: Vec<(PathBuf, &[u8])> = Vec::new();
        let mut request = call.request.to_owned();
        let values = call.values.iter();
        let mut values: Vec<(&str, OsString)> =
            values.map(|(name, value)| (*name, value.into())).collect();
        for attachment in call.attachments {
            let path = workspace.write_input(&attachment.file_name, &attachment.bytes)?;
            let name = format!("\"{{{}}}\"", attachment.name);
            let text = serde_json::Value::from(path.to_string_lossy()).to_string();
            request = request.replace(&name, &text);
            values.push((&attachment.name, path.clone().into()));
            inputs.push((path, &attachment.bytes));
        }
        let input = workspace.write_input("request.json", request.as_bytes())?;
        let work_dir = workspace.work_dir.clone();
        let output = template.output_file(&work_dir)?;
        let output = output.expect("a writer's template names the output file");
        let words = template.command_words_with_values(&input, &work_dir, &values);
        let time = call.attempt.time_limit(self.timeout);
        let mut result = self.run_command(&words, 1 << 20, time, &work_dir)?;
        result.stderr = workspace.strip_directories(&result.stderr);
        if output.is_longer_than(call.max_bytes) {
            let says = format!("more than {} bytes in the output file", call.max_bytes);
            result.output = Err(Answer::Flooded(says));
        } else if let Ok(stdout) = &mut result.output {
            result.stdout = std::mem::take(stdout);
            result.output = output.read(call.max_bytes, result.exit)?;
        }
        inputs.push((input, request.as_bytes()));
        for (path, bytes) in inputs {
            if !is_unchanged(&path, bytes)? {
                result.output = Err(Answer::Tampered(INPUT_CHANGED_MESSAGE.to_owned()));
            }
        }
        Ok(result)
    }
}
