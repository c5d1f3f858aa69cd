//! `ptm-conform reference`: the reference decoder in one-shot and serve mode, and its capabilities. Reads no cases and no YAML.

use std::io::{self, BufRead, Write};
use std::path::{Path, PathBuf};

use ptm::Format;
use ptm::error::Class;
use ptm_suite::protocol::frame::{EXIT_MALFORMED, EXIT_UNSUPPORTED, Frame, View, write_view};
use ptm_writers::fitting::optimum::optimum;
use ptm_writers::fitting::photographs::{FORMATS, FitRequest, ImageSet};
use ptm_writers::reference::{self, NotWritten};
use ptm_writers::request::{RequestHeader, WriteRequest};

use super::{CommandError, CommandResult, files};

/// Decode FILE with the reference decoder, and print the frame as the decoder protocol specifies.
///
/// `reference serve` answers requests "SEQ VIEW PATH" on standard input. `reference capabilities` lists the supported views and
/// formats. `reference texture FILE` answers a texture mapping question in JSON. `reference write REQUEST OUT` writes the file
/// for a check-writer request, and `reference fit REQUEST OUT` writes the best fit to images.
///
/// Exit status: 0 success, 65 the file is malformed, 69 it is not supported.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  ptm-conform reference raw coin.ptm > coin.frame\n  ptm-conform reference rgb:0.3,0.4 coin.ptm > coin.frame"
)]
pub struct Args {
    /// raw, coef or rgb:LU,LV; or serve, capabilities, texture, write or fit
    view: String,
    /// A PTM file; for texture, a question in JSON; for write and fit, a request in JSON.
    file: Option<PathBuf>,
    /// The file to write; for write and fit only.
    out: Option<PathBuf>,
}

/// Answers the request in `args` and returns the exit status.
pub fn run(args: &Args) -> CommandResult {
    let usage_error = |message: &str| Err(message.to_owned().into());
    match (args.view.as_str(), &args.file, &args.out) {
        ("write", Some(request), Some(out)) => write(request, out),
        ("write", Some(_), None) => usage_error("write needs a request and the file to write"),
        ("fit", Some(request), Some(out)) => fit(request, out),
        ("fit", Some(_), None) => usage_error("fit needs a request and the file to write"),
        (_, Some(_), Some(_)) => usage_error("a view takes only one file"),
        ("serve", None, _) => status(serve(io::stdin().lock(), io::stdout().lock())),
        ("capabilities", None, _) => status(io::stdout().write_all(capabilities().as_bytes())),
        (_, None, _) => usage_error("a view needs a file"),
        #[cfg(unix)]
        ("texture", Some(file), None) => super::texture::answer(file),
        (view, Some(file), None) => match view.parse::<View>() {
            Ok(view) => print_view(&view, file),
            Err(error) => {
                let status = EXIT_UNSUPPORTED as u8;
                Err(CommandError::refused(file, status, &error.to_string()))
            }
        },
    }
}

fn status(outcome: io::Result<()>) -> CommandResult {
    match outcome {
        // A closed pipe is not an error.
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(error.to_string().into()),
        _ => Ok(0),
    }
}

fn print_view(view: &View, path: &Path) -> CommandResult {
    let file = files::read(path)?;
    let map = ptm::decode::open(&file)
        .map_err(|error| CommandError::refused(path, files::status(&error), &error.to_string()))?;
    // Standard output is line-buffered, so add a larger buffer.
    let mut out = io::BufWriter::with_capacity(1 << 18, io::stdout().lock());
    let written = write_view(&map, view, &mut out);
    status(written.and_then(|()| out.flush()))
}

/// Answers `reference write REQUEST OUT`.
fn write(path: &Path, out: &Path) -> CommandResult {
    let request = files::read(path).and_then(|json| {
        let header = RequestHeader::read(&json)?;
        let planes = files::read(Path::new(&header.planes))?;
        header.with_planes(&planes)
    });
    write_request(path, out, &request.map_err(malformed(path))?)
}

/// Answers `reference fit REQUEST OUT`.
fn fit(path: &Path, out: &Path) -> CommandResult {
    let request = files::read(path).and_then(|json| FitRequest::read(&json));
    let (format, request) = request.map_err(malformed(path))?;
    if !FORMATS.contains(&format) {
        let status = EXIT_UNSUPPORTED as u8;
        return Err(CommandError::refused(path, status, "fits are LRGB or RGB"));
    }
    let set = ImageSet::read(Path::new(&request.lp)).map_err(malformed(path))?;
    write_request(path, out, &WriteRequest::from_ptm(&optimum(&set, format)))
}

fn malformed(path: &Path) -> impl Fn(String) -> CommandError + '_ {
    |error| CommandError::refused(path, EXIT_MALFORMED as u8, &error)
}

/// Writes the requested file, or returns an error that states why it cannot be written.
fn write_request(path: &Path, out: &Path, request: &WriteRequest) -> CommandResult {
    let (status, says) = match reference::write_requested_file(request) {
        Ok(bytes) => return Ok(files::write_atomically(out, bytes).map(|()| 0)?),
        Err(NotWritten::Impossible(says)) => (EXIT_MALFORMED, says),
        Err(NotWritten::Unsupported(says)) => (EXIT_UNSUPPORTED, says),
    };
    Err(CommandError::refused(path, status as u8, &says))
}

/// Answers requests until the input ends.
fn serve(requests: impl BufRead, mut answers: impl Write) -> io::Result<()> {
    for line in requests.split(b'\n') {
        answers.write_all(&answer_line(&line?)?)?;
        answers.flush()?;
    }
    Ok(())
}

fn answer_line(line: &[u8]) -> io::Result<Vec<u8>> {
    let words: Vec<&[u8]> = line.splitn(3, |&byte| byte == b' ').collect();
    let [sequence, view, path] = words[..] else {
        let shown = line.escape_ascii();
        return Err(io::Error::other(format!(
            "expected \"SEQ VIEW PATH\", found \"{shown}\""
        )));
    };
    let with_number = |words: String| [sequence, b" ", words.as_bytes(), b"\n"].concat();
    let view = std::str::from_utf8(view).ok();
    let Some(view) = view.and_then(|view| view.parse::<View>().ok()) else {
        return Ok(with_number("unsupported view".to_owned()));
    };
    let file = files::read(&files::path_from_bytes(path.to_vec())).map_err(io::Error::other)?;
    Ok(match ptm::decode(&file) {
        Ok(ptm) => {
            let mut frame = Vec::new();
            Frame::render(&ptm, &view).write(&mut frame)?;
            [with_number(format!("ok {}", frame.len())), frame].concat()
        }
        Err(error) if error.class() == Class::Malformed => {
            with_number(format!("reject {EXIT_MALFORMED}"))
        }
        Err(error) => with_number(format!("unsupported {error}").replace('\n', " ")),
    })
}

fn capabilities() -> String {
    let formats = Format::ALL.map(Format::name).join(", ");
    format!(
        "protocol: 1\nname: ptm-conform reference\nversion: \"{}\"\nviews: [raw, coef, rgb]\nformats: [{formats}]\nmodes: [one-shot, serve]\npipelined: true\nreject_exit: {EXIT_MALFORMED}\n",
        env!("CARGO_PKG_VERSION")
    )
}
