//! Reasons why a command of several words does not run.

use std::ffi::OsString;
use std::path::Path;

use crate::protocol::frame::Answer;
use crate::runner::run::Reply;
use crate::runner::start::{self, is_script_name};

use super::message::{ProbeFault, fault};

/// Checks the command before it is run.
pub(super) fn look(command: &[OsString]) -> Result<(), ProbeFault> {
    let Some(word) = command.first() else {
        return Err(fault("no-command", &[]));
    };
    start::check_program(word, &word.to_string_lossy())?;
    for word in &command[1..] {
        let text = word.to_string_lossy();
        let is_script = is_script_name(&text) && !text.starts_with('-');
        if is_script && !Path::new(word).exists() {
            return Err(fault("no-script", &[("word", &text)]));
        }
    }
    Ok(())
}

/// Returns the reason why the system or a shell did not run the command; `None` if it did.
pub(super) fn not_run(command: &[OsString], reply: &Reply) -> Option<ProbeFault> {
    command.first()?;
    let last = reply.stderr.lines().last().unwrap_or_default();
    match (&reply.answer, reply.exit) {
        (Answer::NotStarted(why), _) => Some(fault("not-started", &[("why", why)])),
        (Answer::Crashed(_), Some(127)) => Some(fault("status-127", &[("last", &last)])),
        (Answer::Crashed(_), Some(126)) => Some(fault("status-126", &[("last", &last)])),
        _ => None,
    }
}
