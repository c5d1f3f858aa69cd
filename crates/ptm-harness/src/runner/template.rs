//! Command lines for programs that do not implement the decoder protocol: `viewer -u {lu} -v {lv} {in} -o {out}.png`.
//!
//! The text is split into words as in a shell, but no shell is run. Placeholders may be anywhere in a word. They are replaced
//! after the text is split, so paths with spaces remain one word. `{{` and `}}` are literal braces.

use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io::Read;
use std::os::fd::OwnedFd;
use std::path::Path;

use rustix::fs::{AtFlags, FileType, Mode, OFlags};
use rustix::io::Errno;

use crate::runner::start::find_in_path;
use crate::runner::trouble::{Trouble, is_shortage};
use ptm_suite::protocol::frame::Answer;

/// A command line with placeholders for values that differ between calls.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Template {
    words: Vec<Vec<TemplatePiece>>,
}

/// A piece of a word in a template.
#[derive(Clone, Debug, PartialEq, Eq)]
enum TemplatePiece {
    Text(OsString),
    In,
    /// The output file, with this extension. Viewers choose the format by extension.
    Out(String),
    Lu,
    Lv,
    View,
    /// A named value from the request.
    Value(String),
}

/// Name of the output file, without its extension.
const OUTPUT_NAME: &str = "image";

impl Template {
    /// Parses a template. Words that name existing files become absolute paths, because each call runs in a separate directory.
    ///
    /// # Errors
    /// Returns a message that describes the error in the template.
    pub fn parse(text: &str) -> Result<Template, String> {
        let template = Template::split(text, &[])?;
        if !template.pieces().any(|piece| *piece == TemplatePiece::In) {
            return Err("the command has no {in}, the placeholder for the PTM file".to_owned());
        }
        if template.outputs().count() > 1 {
            return Err("the command contains {out} more than once".to_owned());
        }
        Ok(template)
    }

    /// Parses a template for a program that writes `{out}`. The other placeholders are `{in}` and those in `names`.
    ///
    /// # Errors
    /// Returns a message that describes the error in the template.
    pub fn parse_for_writer(text: &str, names: &[&str]) -> Result<Template, String> {
        let template = Template::split(text, names)?;
        if template.outputs().count() != 1 {
            return Err(
                "the command needs exactly one {out}, the placeholder for the output file"
                    .to_owned(),
            );
        }
        let is_input =
            |piece: &TemplatePiece| matches!(piece, TemplatePiece::In | TemplatePiece::Value(_));
        if !template.pieces().any(is_input) {
            return Err(format!(
                "the command needs a placeholder for the request: {{in}}, {{{}}}",
                names.join("}, {")
            ));
        }
        if template.has_view()
            || template
                .pieces()
                .any(|piece| matches!(piece, TemplatePiece::Lu | TemplatePiece::Lv))
        {
            return Err("a writer has no view and no light".to_owned());
        }
        Ok(template)
    }

    /// Splits a template into words, the first of which must be a program.
    fn split(text: &str, names: &[&str]) -> Result<Template, String> {
        let words = shlex::split(text)
            .ok_or("the command has an unclosed quotation mark or ends in a backslash")?;
        let words: Vec<Vec<TemplatePiece>> = words
            .iter()
            .enumerate()
            .map(|(i, word)| pieces(word, i == 0, names))
            .collect::<Result<_, _>>()?;
        match words.first().map(Vec::as_slice) {
            None => Err("the command is empty".to_owned()),
            Some([TemplatePiece::Text(_)]) => Ok(Template { words }),
            Some(_) => Err("the first word must be the program, without placeholders".to_owned()),
        }
    }

    /// Creates a template from the words of `command`. A word that equals a placeholder becomes that placeholder.
    pub(crate) fn from_words(command: &[OsString]) -> Template {
        let piece = |word: &OsString| match word.to_str() {
            Some("{in}") => TemplatePiece::In,
            Some("{out}") => TemplatePiece::Out(String::new()),
            Some("{view}") => TemplatePiece::View,
            _ => TemplatePiece::Text(word.clone()),
        };
        Template {
            words: command.iter().map(|word| vec![piece(word)]).collect(),
        }
    }

    /// Returns true if the command line contains the view, which means that a call can request any view.
    #[must_use]
    pub fn has_view(&self) -> bool {
        self.pieces().any(|piece| *piece == TemplatePiece::View)
    }

    /// Returns true if the command line contains both coordinates of the light.
    #[must_use]
    pub fn has_light(&self) -> bool {
        [TemplatePiece::Lu, TemplatePiece::Lv]
            .iter()
            .all(|wanted| self.pieces().any(|piece| piece == wanted))
    }

    /// Returns the command line of a call that requests `view`, reads `file` and runs in `work_dir`. For a view
    /// without a light, the light is 0, 0.
    pub(crate) fn command_words(&self, view: &str, file: &Path, work_dir: &Path) -> Vec<OsString> {
        let light = view.strip_prefix("rgb:").unwrap_or("0,0");
        let (lu, lv) = light.split_once(',').unwrap_or((light, "0"));
        self.fill_placeholders(file, work_dir, &|piece| match piece {
            TemplatePiece::Lu => lu.into(),
            TemplatePiece::Lv => lv.into(),
            _ => view.into(),
        })
    }

    /// Returns the command line of a call that executes the request in `input`. Fills in named placeholders from `values`.
    pub(crate) fn command_words_with_values(
        &self,
        input: &Path,
        work_dir: &Path,
        values: &[(&str, OsString)],
    ) -> Vec<OsString> {
        self.fill_placeholders(input, work_dir, &|piece| {
            let of_name = values
                .iter()
                .find(|(name, _)| matches!(piece, TemplatePiece::Value(of) if of == name));
            of_name.map(|(_, value)| value.clone()).unwrap_or_default()
        })
    }

    fn fill_placeholders(
        &self,
        input: &Path,
        work_dir: &Path,
        other: &dyn Fn(&TemplatePiece) -> OsString,
    ) -> Vec<OsString> {
        let filled = |piece: &TemplatePiece| match piece {
            TemplatePiece::Text(text) => text.clone(),
            TemplatePiece::In => input.into(),
            TemplatePiece::Out(suffix) => work_dir.join(format!("{OUTPUT_NAME}{suffix}")).into(),
            piece => other(piece),
        };
        let joined = |pieces: &Vec<TemplatePiece>| pieces.iter().map(filled).collect();
        self.words.iter().map(joined).collect()
    }

    /// Returns the output file of a call, if the template has one. Must be called before the program starts. The method opens
    /// `work_dir`, so replacing the directory later has no effect.
    pub(crate) fn output_file(&self, work_dir: &Path) -> Result<Option<OutputFile>, Trouble> {
        let Some(suffix) = self.outputs().next() else {
            return Ok(None);
        };
        let flags = OFlags::RDONLY | OFlags::DIRECTORY | OFlags::CLOEXEC;
        let directory = rustix::fs::open(work_dir, flags, Mode::empty())
            .map_err(|error| Trouble::new("open a working directory", &error.into()))?;
        Ok(Some(OutputFile {
            directory,
            name: format!("{OUTPUT_NAME}{suffix}"),
        }))
    }

    fn pieces(&self) -> impl Iterator<Item = &TemplatePiece> {
        self.words.iter().flatten()
    }

    fn outputs(&self) -> impl Iterator<Item = &String> {
        self.pieces().filter_map(|piece| match piece {
            TemplatePiece::Out(suffix) => Some(suffix),
            _ => None,
        })
    }
}

/// Splits a word into pieces.
fn pieces(word: &str, is_program: bool, names: &[&str]) -> Result<Vec<TemplatePiece>, String> {
    let mut pieces = Vec::new();
    let mut text = String::new();
    let mut rest = word;
    while let Some(first) = rest.chars().next() {
        if let Some(after) = rest.strip_prefix("{{").or(rest.strip_prefix("}}")) {
            text.push(first);
            rest = after;
        } else if let Some((name, after)) = placeholder(rest) {
            rest = after;
            let piece = match name {
                "in" => TemplatePiece::In,
                "lu" => TemplatePiece::Lu,
                "lv" => TemplatePiece::Lv,
                "view" => TemplatePiece::View,
                "out" => {
                    let suffix: String = rest
                        .chars()
                        .take_while(|c| c.is_ascii_alphanumeric() || *c == '.')
                        .collect();
                    rest = &rest[suffix.len()..];
                    TemplatePiece::Out(suffix)
                }
                value if names.contains(&value) => TemplatePiece::Value(value.to_owned()),
                other if !names.is_empty() => {
                    return Err(format!(
                        "unknown placeholder {{{other}}}; placeholders are {{in}}, {{out}}, {{{}}}",
                        names.join("}, {")
                    ));
                }
                other => {
                    return Err(format!(
                        "unknown placeholder {{{other}}}; placeholders are {{in}}, {{out}}, {{lu}}, {{lv}} and \
                         {{view}}; write {{{{{other}}}}} for the word in braces"
                    ));
                }
            };
            if !text.is_empty() {
                pieces.push(TemplatePiece::Text(std::mem::take(&mut text).into()));
            }
            pieces.push(piece);
        } else {
            text.push(first);
            rest = &rest[first.len_utf8()..];
        }
    }
    if pieces.is_empty() {
        return Ok(vec![TemplatePiece::Text(make_absolute(
            OsStr::new(&text),
            is_program,
        )?)]);
    }
    if !text.is_empty() {
        pieces.push(TemplatePiece::Text(text.into()));
    }
    Ok(pieces)
}

/// Returns the name of the placeholder at the start of `text`, and the rest of `text`.
fn placeholder(text: &str) -> Option<(&str, &str)> {
    let (name, after) = text.strip_prefix('{')?.split_once('}')?;
    let is_name = !name.is_empty()
        && name
            .bytes()
            .all(|byte| byte.is_ascii_alphanumeric() || byte == b'_');
    is_name.then_some((name, after))
}

/// Converts a word of a command to an absolute path if the word names an existing file. A program name without a directory is
/// looked up only in PATH, and so is another word that names both a program in PATH and a directory, such as `node` after `env`.
pub(crate) fn make_absolute(word: &OsStr, is_program: bool) -> Result<OsString, String> {
    let path = Path::new(word);
    let is_bare = path.components().count() == 1;
    let is_command = is_bare && (is_program || path.is_dir() && find_in_path(word).is_some());
    let names_file = path.exists() && !is_command;
    if names_file {
        let path =
            std::path::absolute(path).map_err(|error| format!("{}: {error}", word.display()))?;
        Ok(path.into_os_string())
    } else {
        Ok(word.to_owned())
    }
}

/// The output file of a call.
pub(crate) struct OutputFile {
    directory: OwnedFd,
    name: String,
}

impl OutputFile {
    /// Returns true if the file is a regular file of more than `max_bytes` bytes.
    pub(crate) fn is_longer_than(&self, max_bytes: usize) -> bool {
        let about = rustix::fs::statat(&self.directory, &self.name, AtFlags::SYMLINK_NOFOLLOW);
        about.is_ok_and(|about| {
            FileType::from_raw_mode(about.st_mode) == FileType::RegularFile
                && u64::try_from(about.st_size).is_ok_and(|size| size > max_bytes as u64)
        })
    }

    /// Reads at most `max_bytes` bytes of the file that a program has written. `exit` is the exit status of the program. Follows
    /// no links, and opens only regular files.
    pub(crate) fn read(
        &self,
        max_bytes: usize,
        exit: Option<i32>,
    ) -> Result<Result<Vec<u8>, Answer>, Trouble> {
        let fault = |why: &str| Ok(Err(Answer::ProtocolError(format!("the output file {why}"))));
        let flags = OFlags::RDONLY | OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::CLOEXEC;
        let file = match rustix::fs::openat(&self.directory, &self.name, flags, Mode::empty()) {
            Ok(file) => File::from(file),
            Err(Errno::NOENT) => {
                let status = exit.unwrap_or_default();
                return fault(&format!(
                    "is missing, although the program exited with {status}"
                ));
            }
            Err(Errno::LOOP) => return fault("is a link"),
            Err(error) if is_shortage(&error.into()) => {
                return Err(Trouble::new("read an output file", &error.into()));
            }
            Err(error) => return fault(&format!("cannot be read: {error}")),
        };
        match file.metadata() {
            Ok(about) if about.is_file() => {}
            _ => return fault("is not a regular file"),
        }
        let mut bytes = Vec::new();
        if let Err(error) = file.take(max_bytes as u64 + 1).read_to_end(&mut bytes) {
            return fault(&format!("cannot be read: {error}"));
        }
        if bytes.len() > max_bytes {
            let says = format!("more than {max_bytes} bytes in the output file");
            return Ok(Err(Answer::Flooded(says)));
        }
        match bytes.is_empty() {
            true => fault("is empty"),
            false => Ok(Ok(bytes)),
        }
    }
}
