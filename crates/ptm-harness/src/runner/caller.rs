//! Sends requests to a function in the parent process, which listens on a Unix socket.
//!
//! ```text
//! to the caller      NAME VIEW NBYTES, a line feed and the PTM file
//! from the caller    WORD NBYTES, a line feed and NBYTES bytes
//! ```
//!
//! WORD is `ok` before an answer (a frame, an array or an image), and `reject`, `unsupported`, `crash` or `error` before a
//! message. `error` means that the answer has a type other than the requested one. There is no timeout, because a function cannot
//! be stopped without ending its process. The caller can exit at any time.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use ptm_suite::kit::last_message::last_message;
use ptm_suite::protocol::request::{Reply, Request};
use ptm_suite::protocol::{forms, frame::Answer};

/// Maximum length of the first line of an answer, in bytes.
const MAX_LINE_LENGTH: u64 = 100;
/// Maximum number of bytes in a message.
const MAX_MESSAGE_LENGTH: u64 = 4096;

/// A parent process that answers requests with one of its functions.
pub struct Caller {
    stream: Mutex<BufReader<UnixStream>>,
    /// Flag that stops the run. It is set when the connection is lost.
    stop: Arc<AtomicBool>,
}

impl Caller {
    /// Connects to the process that listens on `socket`. `stop` is set when that process closes the connection.
    ///
    /// # Errors
    /// Returns an error if no process listens on `socket`.
    pub fn connect(socket: &Path, stop: &Arc<AtomicBool>) -> io::Result<Caller> {
        Ok(Caller {
            stream: Mutex::new(BufReader::new(UnixStream::connect(socket)?)),
            stop: Arc::clone(stop),
        })
    }

    /// Requests a view of a file.
    ///
    /// # Panics
    /// Panics only if another thread panicked during a request, which would be a bug.
    #[must_use]
    pub fn ask(&self, request: &Request) -> Reply {
        let mut stream = self.stream.lock().expect("no request panics");
        exchange(&mut stream, request).unwrap_or_else(|error| {
            self.stop.store(true, Ordering::Relaxed);
            Reply::from(Answer::NotAsked(format!(
                "the caller does not answer: {error}"
            )))
        })
    }
}

/// Sends a request and reads the answer.
fn exchange(stream: &mut BufReader<UnixStream>, request: &Request) -> io::Result<Reply> {
    let Request {
        name, view, file, ..
    } = request;
    let line = format!("{name} {view} {}\n", file.len());
    let connection = stream.get_mut();
    connection.write_all(&[line.as_bytes(), file].concat())?;
    let (word, length) = read_first_line(stream)?;
    let max_bytes = match word.as_str() {
        "ok" => request.max_answer_bytes() as u64,
        _ => MAX_MESSAGE_LENGTH,
    };
    let mut bytes = Vec::new();
    let read = stream
        .by_ref()
        .take(length.min(max_bytes))
        .read_to_end(&mut bytes)? as u64;
    let rest = io::copy(&mut stream.by_ref().take(length - read), &mut io::sink())?;
    if read + rest != length {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    let message = || String::from_utf8_lossy(&bytes).into_owned();
    let answer = match word.as_str() {
        "ok" if length > max_bytes => {
            Answer::Flooded(format!("{length} bytes exceed the limit of {max_bytes}"))
        }
        "ok" => forms::read(&bytes, request.view, request.max_answer_bytes()).map_or_else(
            |error| Answer::ProtocolError(error.to_string()),
            Answer::Decoded,
        ),
        "reject" => Answer::Rejected,
        "unsupported" => Answer::Unsupported,
        "crash" => Answer::Crashed(last_message(&message()).unwrap_or_default().to_owned()),
        "error" => Answer::ProtocolError(message()),
        _ => return Err(io::Error::other(format!("unexpected word {word:?}"))),
    };
    let stderr = if word == "ok" {
        String::new()
    } else {
        message()
    };
    let reply = Reply::from(answer);
    Ok(Reply { stderr, ..reply })
}

/// Reads the word of an answer and the number of bytes that follow.
fn read_first_line(stream: &mut BufReader<UnixStream>) -> io::Result<(String, u64)> {
    let mut line = String::new();
    stream.by_ref().take(MAX_LINE_LENGTH).read_line(&mut line)?;
    if line.is_empty() {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    let words = line
        .strip_suffix('\n')
        .and_then(|line| line.split_once(' '));
    let words = words.and_then(|(word, length)| Some((word.to_owned(), length.parse().ok()?)));
    words.ok_or_else(|| io::Error::other(format!("expected WORD NBYTES, found {line:?}")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use ptm_suite::protocol::frame::Samples;
    use ptm_suite::protocol::request::AttemptKind;

    /// Returns the reply to a request for a map of one texel, answered with `answer`, and whether the run was stopped.
    fn reply_to(answer: &[u8]) -> (Reply, bool) {
        let (ours, mut theirs) = UnixStream::pair().expect("a pair of sockets");
        theirs.write_all(answer).expect("the answer fits");
        theirs
            .shutdown(std::net::Shutdown::Write)
            .expect("nothing more comes");
        let caller = Caller {
            stream: Mutex::new(BufReader::new(ours)),
            stop: Arc::default(),
        };
        let view = "raw".parse().expect("a view");
        let reply = caller.ask(&Request {
            name: "a",
            view: &view,
            file: b"PTM",
            max_frame_bytes: 30,
            attempt: AttemptKind::Usual,
        });
        let mut asked = [0; 11];
        theirs.read_exact(&mut asked).expect("a request");
        assert_eq!(&asked, b"a raw 3\nPTM");
        (reply, caller.stop.load(Ordering::Relaxed))
    }

    #[test]
    fn caller_responses_become_answers() {
        let (reply, _) = reply_to(b"ok 27\nPTM1 raw 1 1 9 u8\n123456789");
        let Answer::Decoded(frame) = reply.answer else {
            panic!("{reply:?}")
        };
        assert_eq!(frame.samples, Samples::U8(b"123456789".to_vec()));
        assert_eq!(reply_to(b"reject 3\nbad").0.answer, Answer::Rejected);
        assert_eq!(reply_to(b"unsupported 0\n").0.answer, Answer::Unsupported);
        let (reply, _) = reply_to(b"crash 3\nbad");
        assert_eq!(reply.answer, Answer::Crashed("bad".to_owned()));
        assert_eq!(reply.stderr, "bad");
    }

    #[test]
    fn silent_caller_ends_the_run() {
        for answer in [&b""[..], b"ok 27\nPTM1", b"ok\n", b"yes 0\n", b"ok -1\n"] {
            let (reply, stopped) = reply_to(answer);
            assert!(matches!(reply.answer, Answer::NotAsked(_)), "{reply:?}");
            assert!(stopped);
        }
    }
}
