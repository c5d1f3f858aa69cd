//! Why a command does not run, where it is more than its program: its other words, and what it calls itself.

use std::ffi::OsString;
use std::path::Path;

use crate::protocol::frame::Answer;
use crate::runner::run::Reply;
use crate::runner::start::{self, Obstacle, is_script_name};

/// Looks at the command before it is run.
pub(super) fn look(command: &[OsString]) -> Result<(), Obstacle> {
    let Some(word) = command.first() else {
        return Err((
            "there is no command".to_owned(),
            "name your decoder".to_owned(),
        ));
    };
    start::look(word, &word.to_string_lossy())?;
    for word in &command[1..] {
        let text = word.to_string_lossy();
        let is_script = is_script_name(&text) && !text.starts_with('-');
        if is_script && !Path::new(word).exists() {
            return Err((
                format!("{text}: no such file in this directory"),
                "name the script by a path that leads to it from here".to_owned(),
            ));
        }
    }
    Ok(())
}

/// Why the system or a shell did not run the command; nothing if it did.
pub(super) fn not_run(command: &[OsString], reply: &Reply) -> Option<Obstacle> {
    command.first()?;
    let last = reply.stderr.lines().last().unwrap_or_default();
    match (&reply.answer, reply.exit) {
        (Answer::NotStarted(why), _) => Some((
            format!("it cannot be started: {why}"),
            "run it by hand from another directory".to_owned(),
        )),
        (Answer::Crashed(_), Some(127)) => Some((
            format!("exit status 127: something that it calls is not found\n{last}"),
            "name what it calls by absolute paths, or relative to the script: \"$(dirname \"$0\")/…\"".to_owned(),
        )),
        (Answer::Crashed(_), Some(126)) => Some((
            format!("exit status 126: something that it calls cannot be run\n{last}"),
            "make it executable: chmod +x".to_owned(),
        )),
        _ => None,
    }
}
