//! Command lines for programs that do not speak the decoder protocol: `viewer -u {lu} -v {lv} {in} -o {out}.png`.
//!
//! The text is split as a shell splits it, and no shell sees it. A placeholder may stand anywhere in a word, so paths with
//! spaces stay one word. `{{` and `}}` are braces.

use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io::{self, Read};
use std::os::fd::OwnedFd;
use std::path::Path;

use rustix::fs::{Mode, OFlags};

use crate::harness::protocol::{Answer, View};

/// A command line with places for what changes from call to call.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Template {
    words: Vec<Vec<Part>>,
}

/// A piece of a word.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Part {
    Text(OsString),
    In,
    /// The file to be written, with what follows in the word: viewers go by the suffix.
    Out(String),
    Lu,
    Lv,
    View,
}

/// The name of the file to be written, without its suffix.
const OUTPUT: &str = "picture";

impl Template {
    /// Reads a template. Words that name existing files are made absolute, because calls run in directories of their own.
    ///
    /// # Errors
    /// A sentence that says what is wrong with it.
    pub fn parse(text: &str) -> Result<Template, String> {
        let words =
            shlex::split(text).ok_or("a quotation in it has no end, or a backslash ends it")?;
        let words: Vec<Vec<Part>> = words
            .iter()
            .enumerate()
            .map(|(i, word)| parts(word, i == 0))
            .collect::<Result<_, _>>()?;
        let template = Template { words };
        match template.words.first().map(Vec::as_slice) {
            None => return Err("it is empty".to_owned()),
            Some([Part::Text(_)]) => {}
            Some(_) => return Err("its first word is the program, without placeholders".to_owned()),
        }
        if !template.parts().any(|part| *part == Part::In) {
            return Err("it has no {in}, the place for the PTM file".to_owned());
        }
        if template.outputs().count() > 1 {
            return Err("it has {out} more than once".to_owned());
        }
        Ok(template)
    }

    /// The words of `command`, each as it is; a placeholder is a word by itself.
    #[must_use]
    pub fn of_words(command: &[OsString]) -> Template {
        let part = |word: &OsString| match word.to_str() {
            Some("{in}") => Part::In,
            Some("{view}") => Part::View,
            _ => Part::Text(word.clone()),
        };
        Template {
            words: command.iter().map(|word| vec![part(word)]).collect(),
        }
    }

    /// Whether the view is a word of the call, so that a call can ask for any.
    #[must_use]
    pub fn names_view(&self) -> bool {
        self.parts().any(|part| *part == Part::View)
    }

    /// Whether both directions of the light are there.
    #[must_use]
    pub fn names_light(&self) -> bool {
        [Part::Lu, Part::Lv]
            .iter()
            .all(|wanted| self.parts().any(|part| part == wanted))
    }

    /// The words of a call that reads `input` and works in `workplace`. A view without a light has the light 0, 0.
    pub(crate) fn words(&self, view: &View, input: &Path, workplace: &Path) -> Vec<OsString> {
        let light = |direction: usize| {
            let text = view.to_string();
            let light = text.strip_prefix("rgb:").unwrap_or("0,0");
            light.split(',').nth(direction).unwrap_or("0").to_owned()
        };
        let filled = |part: &Part| match part {
            Part::Text(text) => text.clone(),
            Part::In => input.into(),
            Part::Out(suffix) => workplace.join(format!("{OUTPUT}{suffix}")).into(),
            Part::Lu => light(0).into(),
            Part::Lv => light(1).into(),
            Part::View => view.to_string().into(),
        };
        let joined = |parts: &Vec<Part>| parts.iter().map(filled).collect();
        self.words.iter().map(joined).collect()
    }

    /// The file that a call writes, if it writes one. To be asked before the call: `workplace` is opened and kept, so
    /// that what the program puts in its place meets nobody.
    pub(crate) fn output(&self, workplace: &Path) -> io::Result<Option<Output>> {
        let Some(suffix) = self.outputs().next() else {
            return Ok(None);
        };
        let flags = OFlags::RDONLY | OFlags::DIRECTORY | OFlags::CLOEXEC;
        Ok(Some(Output {
            directory: rustix::fs::open(workplace, flags, Mode::empty())?,
            name: format!("{OUTPUT}{suffix}"),
        }))
    }

    fn parts(&self) -> impl Iterator<Item = &Part> {
        self.words.iter().flatten()
    }

    fn outputs(&self) -> impl Iterator<Item = &String> {
        self.parts().filter_map(|part| match part {
            Part::Out(suffix) => Some(suffix),
            _ => None,
        })
    }
}

/// The pieces of a word.
fn parts(word: &str, is_program: bool) -> Result<Vec<Part>, String> {
    let mut parts = Vec::new();
    let mut text = String::new();
    let mut rest = word;
    while let Some(first) = rest.chars().next() {
        if let Some(after) = rest.strip_prefix("{{").or(rest.strip_prefix("}}")) {
            text.push(first);
            rest = after;
        } else if let Some((name, after)) = placeholder(rest) {
            rest = after;
            let part = match name {
                "in" => Part::In,
                "lu" => Part::Lu,
                "lv" => Part::Lv,
                "view" => Part::View,
                "out" => {
                    let suffix: String = rest
                        .chars()
                        .take_while(|c| c.is_ascii_alphanumeric() || *c == '.')
                        .collect();
                    rest = &rest[suffix.len()..];
                    Part::Out(suffix)
                }
                other => {
                    return Err(format!(
                        "unknown placeholder {{{other}}}; placeholders are {{in}}, {{out}}, {{lu}}, {{lv}} and \
                         {{view}}, and {{{{{other}}}}} is the word in braces"
                    ));
                }
            };
            if !text.is_empty() {
                parts.push(Part::Text(std::mem::take(&mut text).into()));
            }
            parts.push(part);
        } else {
            text.push(first);
            rest = &rest[first.len_utf8()..];
        }
    }
    if parts.is_empty() {
        return Ok(vec![Part::Text(absolute(OsStr::new(&text), is_program)?)]);
    }
    if !text.is_empty() {
        parts.push(Part::Text(text.into()));
    }
    Ok(parts)
}

/// The name of the placeholder at the beginning of `text`, and what follows it.
fn placeholder(text: &str) -> Option<(&str, &str)> {
    let (name, after) = text.strip_prefix('{')?.split_once('}')?;
    let is_name = !name.is_empty()
        && name
            .bytes()
            .all(|byte| byte.is_ascii_alphanumeric() || byte == b'_');
    is_name.then_some((name, after))
}

/// A word of a command; if it names an existing file, from the root on. A bare program name is looked up in PATH and
/// nowhere else.
pub(crate) fn absolute(word: &OsStr, is_program: bool) -> Result<OsString, String> {
    let path = Path::new(word);
    let names_file = path.exists() && (!is_program || path.components().count() > 1);
    if names_file {
        let path =
            std::path::absolute(path).map_err(|error| format!("{}: {error}", word.display()))?;
        Ok(path.into_os_string())
    } else {
        Ok(word.to_owned())
    }
}

/// The file that a call writes.
pub(crate) struct Output {
    directory: OwnedFd,
    name: String,
}

impl Output {
    /// What is in it, at most `most` bytes. No link is followed and nothing but a plain file opened.
    pub(crate) fn read(&self, most: usize) -> Result<Vec<u8>, Answer> {
        let fault = |what: &str| Answer::ProtocolError(format!("its output file {what}"));
        let flags = OFlags::RDONLY | OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::CLOEXEC;
        let file = rustix::fs::openat(&self.directory, &self.name, flags, Mode::empty());
        let file = file.map(File::from).map_err(|error| match error {
            rustix::io::Errno::NOENT => fault("is not there, though it exits with 0"),
            rustix::io::Errno::LOOP => fault("is a link"),
            error => fault(&format!("cannot be read: {error}")),
        })?;
        let kind = file
            .metadata()
            .map_err(|error| fault(&format!("cannot be read: {error}")))?;
        if !kind.is_file() {
            return Err(fault("is no plain file"));
        }
        let mut bytes = Vec::new();
        file.take(most as u64 + 1)
            .read_to_end(&mut bytes)
            .map_err(|error| fault(&format!("cannot be read: {error}")))?;
        if bytes.len() > most {
            return Err(Answer::Flooded(format!(
                "more than {most} bytes in its output file"
            )));
        }
        if bytes.is_empty() {
            return Err(fault("is empty"));
        }
        Ok(bytes)
    }
}
