//! The serve mode, which nobody needs and everybody gains from: one process for all files.
//!
//! `DECODER serve` reads lines `SEQ VIEW PATH` and answers each with `SEQ ok NBYTES` and a frame, `SEQ reject CODE` or
//! `SEQ unsupported FEATURE`, at once.

use std::fs;
use std::io::{Read, Write};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process_group};

use crate::harness::frames;
use crate::harness::probe::{Checklist, Companion, Sample};
use crate::harness::processes;
use crate::harness::protocol::View;

/// Takes the steps of serve mode: two frames and a refusal, each answered before the next is asked for, then the end.
pub(super) fn look(companion: &Companion, sample: &Sample, view: &View, list: &mut Checklist) {
    let Ok(place) = Place::new(companion.scratch.works()) else {
        return;
    };
    let Ok(mut dialog) = Dialog::start(companion, &place) else {
        return list.absent("serve: not offered, and not needed");
    };
    let whole = place.lay_down("one file.ptm", &sample.file);
    let broken = place.lay_down("broken.ptm", b"PTM_1.2\n");
    let patience = companion.limits.timeout;
    match dialog.ask(1, view, &whole, patience) {
        Said::Answer(answer) => match judge(&answer, sample, view) {
            Ok(()) => {
                list.good("serve: the first request is answered at once, with the right frame");
            }
            Err((says, next)) => return list.bad(format!("serve: {says}"), next),
        },
        Said::Nothing => {
            // Some programs take the word for a view and wait; some answer when their input ends.
            return match dialog.end(patience) {
                Said::Answer(answer) if answer.first.starts_with("1 ") => list.bad(
                    "serve: it answers only when its standard input ends",
                    "flush standard output after each answer, and read line by line: in Python sys.stdout.flush() and \
                     for line in sys.stdin.buffer; in C fflush(stdout)",
                ),
                _ => list.absent("serve: not offered, and not needed"),
            };
        }
        Said::Gone(_) => return list.absent("serve: not offered, and not needed"),
        Said::Wrong((says, next)) => return list.bad(format!("serve: {says}"), next),
    }
    match dialog.ask(2, view, &broken, patience) {
        Said::Answer(answer) if answer.first.starts_with("2 reject") => {
            list.good("serve: a malformed file is refused");
        }
        Said::Answer(answer) => {
            return list.bad(
                format!("serve: a malformed file is answered {:?}", answer.first),
                "the answer is: SEQ reject 65",
            );
        }
        Said::Gone(_) => {
            return list.bad(
                "serve: it ends at a malformed file",
                "answer SEQ reject 65 and go on with the next line",
            );
        }
        _ => {
            return list.bad(
                "serve: a malformed file is not answered",
                "the answer is: SEQ reject 65",
            );
        }
    }
    match dialog.ask(3, view, &whole, patience) {
        Said::Answer(answer)
            if judge(&answer, sample, view).is_ok() && answer.first.starts_with("3 ") =>
        {
            list.good("serve: what was refused leaves no trace");
        }
        Said::Answer(_) => {
            return list.bad(
                "serve: after a refusal the first file is answered otherwise than before",
                "begin every request anew: no state may pass from one file to the next",
            );
        }
        _ => {
            return list.bad(
                "serve: it answers no third request",
                "go on until standard input ends",
            );
        }
    }
    match dialog.end(patience) {
        Said::Gone(true) => list.good("serve: it ends when its input ends"),
        _ => list.bad(
            "serve: it does not end with status 0 when its standard input ends",
            "leave the loop at the end of standard input",
        ),
    }
}

/// One answer: its line, and the bytes it announces.
struct Answer {
    first: String,
    bytes: Vec<u8>,
}

/// What came of waiting for an answer.
enum Said {
    Answer(Answer),
    /// Nothing whole within the time.
    Nothing,
    /// The process has ended; whether with status 0.
    Gone(bool),
    /// Something else.
    Wrong((String, String)),
}

/// Whether an answer is the right frame.
fn judge(answer: &Answer, sample: &Sample, view: &View) -> Result<(), (String, String)> {
    let frame = frames::read(&answer.bytes, view, answer.bytes.len().max(1 << 16)).map_err(|error| {
        let short = answer.bytes.iter().position(|&byte| byte == b'\n');
        let next = match short {
            Some(_) => "NBYTES counts the PTM1 line as well as the samples",
            None => "after SEQ ok NBYTES and a line feed comes the frame as in one-shot mode, PTM1 line and samples",
        };
        (format!("answered {:?}, and then no frame: {error}", answer.first), next.to_owned())
    })?;
    match sample.expected(view).compare(&frame) {
        None => Ok(()),
        Some(difference) => Err((
            format!("the picture is not that of one-shot mode: {difference}"),
            "both modes should share all but the reading of the request".to_owned(),
        )),
    }
}

/// A directory for files to be asked for.
struct Place(PathBuf);

impl Place {
    fn new(scratch: &Path) -> std::io::Result<Place> {
        let path = scratch.join("serve");
        fs::create_dir_all(path.join("work"))?;
        Ok(Place(path))
    }

    fn lay_down(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.join(name);
        // A file that cannot be written is found missing by the decoder.
        let _ = fs::write(&path, bytes);
        path
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        processes::kill_orphans(&self.0.join("work"));
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// A process in serve mode.
struct Dialog {
    child: Child,
    input: Option<ChildStdin>,
    output: Receiver<Vec<u8>>,
    unread: Vec<u8>,
}

/// The most that is kept of what it says.
const MOST: usize = 1 << 20;

impl Dialog {
    fn start(companion: &Companion, place: &Place) -> std::io::Result<Dialog> {
        let workplace = place.0.join("work");
        let command = companion.limits.command();
        let mut serving = Command::new(&command[0]);
        serving
            .args(&command[1..])
            .arg("serve")
            .current_dir(&workplace)
            .env("LC_ALL", "C")
            .env("TZ", "UTC")
            .env("TMPDIR", &workplace)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .process_group(0);
        let mut child = processes::start(&mut serving)?;
        let input = child.stdin.take();
        let (sender, output) = channel();
        if let Some(mut stdout) = child.stdout.take() {
            // It ends with the pipe, or with this dialog.
            std::thread::spawn(move || {
                let mut buffer = [0; 65_536];
                let mut kept = 0;
                while let Ok(count @ 1..) = stdout.read(&mut buffer) {
                    kept += count;
                    if kept > MOST || sender.send(buffer[..count].to_vec()).is_err() {
                        break;
                    }
                }
            });
        }
        Ok(Dialog {
            child,
            input,
            output,
            unread: Vec::new(),
        })
    }

    fn ask(&mut self, sequence: u32, view: &View, path: &Path, patience: Duration) -> Said {
        let request = format!("{sequence} {view} {}\n", path.display());
        if let Some(input) = &mut self.input {
            // A process that has gone is found gone below.
            let _ = input
                .write_all(request.as_bytes())
                .and_then(|()| input.flush());
        }
        let said = self.wait(patience);
        match said {
            Said::Answer(answer) if !answer.first.starts_with(&format!("{sequence} ")) => {
                Said::Wrong((
                    format!("request {sequence} is answered {:?}", answer.first),
                    "an answer begins with the SEQ of its request".to_owned(),
                ))
            }
            said => said,
        }
    }

    /// Closes its input and waits for what it still says, or for its end.
    fn end(&mut self, patience: Duration) -> Said {
        self.input = None;
        self.wait(patience)
    }

    fn wait(&mut self, patience: Duration) -> Said {
        let deadline = Instant::now() + patience;
        loop {
            if let Some(said) = self.whole_answer() {
                return said;
            }
            match self
                .output
                .recv_timeout(deadline.saturating_duration_since(Instant::now()))
            {
                Ok(bytes) => self.unread.extend(bytes),
                Err(RecvTimeoutError::Timeout) => return Said::Nothing,
                Err(RecvTimeoutError::Disconnected) => {
                    while Instant::now() < deadline {
                        if let Ok(Some(status)) = self.child.try_wait() {
                            return Said::Gone(status.success());
                        }
                        std::thread::sleep(Duration::from_millis(5));
                    }
                    return Said::Nothing;
                }
            }
        }
    }

    /// An answer, if all of it is there.
    fn whole_answer(&mut self) -> Option<Said> {
        let end = self.unread.iter().position(|&byte| byte == b'\n')?;
        let first = String::from_utf8_lossy(&self.unread[..end]).into_owned();
        let words: Vec<&str> = first.split(' ').collect();
        let size = match words[..] {
            [_, "ok", size] => match size.parse::<usize>() {
                Ok(size) if size <= MOST => size,
                _ => {
                    return Some(Said::Wrong((
                        format!("it answers {first:?}"),
                        "after ok stands the number of bytes of the frame".to_owned(),
                    )));
                }
            },
            [_, "reject" | "unsupported", ..] => 0,
            _ => {
                return Some(Said::Wrong((
                    format!("it answers {first:?}"),
                    "answers are SEQ ok NBYTES, SEQ reject CODE and SEQ unsupported FEATURE"
                        .to_owned(),
                )));
            }
        };
        if self.unread.len() < end + 1 + size {
            return None;
        }
        let bytes = self.unread[end + 1..end + 1 + size].to_vec();
        self.unread.drain(..end + 1 + size);
        Some(Said::Answer(Answer { first, bytes }))
    }
}

impl Drop for Dialog {
    fn drop(&mut self) {
        // An error means that nobody is left.
        let _ = kill_process_group(Pid::from_child(&self.child), Signal::KILL);
        let _ = self.child.kill();
        let _ = self.child.wait();
        processes::has_been_waited_for(self.child.id());
    }
}
