//! Failures of this program to do its part of a call, such as a full disk or too many open files or processes.
//!
//! These failures say nothing about the decoder. The call is repeated, and if the trouble persists, the run ends.

use std::io;

use rustix::io::Errno;

/// A failure of this program, with a remedy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Trouble(String);

/// Remedies for known resource shortages.
const REMEDIES: [(&[Errno], &str); 6] = [
    (
        &[Errno::NOSPC, Errno::DQUOT],
        "set TMPDIR to a directory with more space",
    ),
    (
        &[Errno::ROFS, Errno::ACCESS, Errno::PERM],
        "set TMPDIR to a writable directory",
    ),
    (&[Errno::FBIG], "raise the limit on file sizes (ulimit -f)"),
    (
        &[Errno::MFILE, Errno::NFILE],
        "raise the limit on open files (ulimit -n) or lower --jobs",
    ),
    (
        &[Errno::AGAIN],
        "raise the limit on processes (ulimit -u) or lower --jobs",
    ),
    (&[Errno::NOMEM], "free memory or lower --jobs"),
];

impl Trouble {
    /// Creates the message for `task`, which failed because of `error`.
    pub(crate) fn new(task: &str, error: &io::Error) -> Trouble {
        let known = Errno::from_io_error(error).and_then(|error| {
            let mut remedies = REMEDIES.iter();
            remedies.find(|(errors, _)| errors.contains(&error))
        });
        let remedy = known.map_or(String::new(), |(_, remedy)| format!("; {remedy}"));
        Trouble(format!("cannot {task}: {error}{remedy}"))
    }

    /// Returns the message for the user.
    pub(crate) fn into_text(self) -> String {
        self.0
    }
}

/// Returns true if a program could not be started because of a shortage that affects every program.
pub fn is_shortage(error: &io::Error) -> bool {
    let shortages = [
        Errno::AGAIN,
        Errno::NOMEM,
        Errno::MFILE,
        Errno::NFILE,
        Errno::NOSPC,
        Errno::IO,
    ];
    Errno::from_io_error(error).is_some_and(|error| shortages.contains(&error))
}

/// Returns true if the file system prevented a write: it is full, over quota, read-only or failing. Another file system may work.
pub fn is_file_system_error(error: &io::Error) -> bool {
    let errors = [Errno::NOSPC, Errno::DQUOT, Errno::ROFS, Errno::IO];
    Errno::from_io_error(error).is_some_and(|error| errors.contains(&error))
}
