//! Walks the author of a decoder through the contract, one step after the other.
//!
//! `check` judges; this explains. Each step asks one thing of the decoder and says in words what is wrong and what to do
//! about it. A wrong answer is not only told from a right one: it is repaired in all the ways in which wrappers go wrong
//! (text before the frame, line ends, byte order, planes side by side, rows upside down …), and the repair that makes it
//! right is what has to be mended.

use std::ffi::OsString;
use std::fmt;

use crate::generate::{Model, Recipe, write};
use crate::harness::cases::Values;
use crate::harness::compare::Expected;
use crate::harness::protocol::{Answer, View};
use crate::harness::run::{Decoder, Reply, Request};
use crate::harness::scratch::Scratch;
use crate::harness::template::Template;
use crate::ptm::{Format, Size};

mod answer;

mod command;

mod serve;

/// How a step ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// As it should be.
    Good,
    /// To be mended.
    Bad,
    /// Not there, and not needed.
    Absent,
}

/// One step of the walk.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Step {
    /// How it ended.
    pub mark: Mark,
    /// What was found.
    pub says: String,
    /// What to do next, where there is something to do.
    pub next: Option<String>,
}

/// The steps that were taken.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Checklist {
    /// In the order in which they were taken.
    pub steps: Vec<Step>,
    /// Whether any first file gave a well-formed frame.
    pub answers: bool,
}

impl Checklist {
    fn good(&mut self, says: impl Into<String>) {
        self.add(Mark::Good, says, None);
    }

    fn bad(&mut self, says: impl Into<String>, next: impl Into<String>) {
        self.add(Mark::Bad, says, Some(next.into()));
    }

    fn absent(&mut self, says: impl Into<String>) {
        self.add(Mark::Absent, says, None);
    }

    fn add(&mut self, mark: Mark, says: impl Into<String>, next: Option<String>) {
        let says = says.into();
        self.steps.push(Step { mark, says, next });
    }

    /// 0 if the decoder is ready for `check`, 3 if it is no decoder yet, 1 otherwise.
    #[must_use]
    pub fn exit_status(&self) -> u8 {
        match (self.answers, self.is_ready()) {
            (false, _) => 3,
            (true, false) => 1,
            (true, true) => 0,
        }
    }

    fn is_ready(&self) -> bool {
        self.steps.iter().all(|step| step.mark != Mark::Bad)
    }
}

impl fmt::Display for Checklist {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for step in &self.steps {
            let mark = match step.mark {
                Mark::Good => '✓',
                Mark::Bad => '✗',
                Mark::Absent => '–',
            };
            writeln!(f, "{mark} {}", step.says.replace('\n', "\n  "))?;
            if let Some(next) = &step.next {
                writeln!(f, "  → {}", next.replace('\n', "\n    "))?;
            }
        }
        Ok(())
    }
}

/// The decoder that is walked with, and where it works.
pub(super) struct Companion<'a> {
    command: &'a [OsString],
    limits: &'a Decoder,
    scratch: &'a Scratch,
}

/// A file, and what a right decoder makes of it.
struct Sample {
    format: Format,
    file: Vec<u8>,
    values: Values,
    size: Size,
}

impl Sample {
    fn new(format: Format, size: &str) -> Sample {
        let size: Size = size.parse().expect("a constant size");
        // Text mode shows where there is a line feed to be spoiled.
        let tells = |model: &Model| {
            model.samples.contains(&b'\n') && !model.samples.windows(2).any(|pair| pair == b"\r\n")
        };
        let (recipe, model) = (1..=1000)
            .map(|seed| {
                let recipe = Recipe {
                    seed,
                    ..Recipe::ordinary(format, size)
                };
                let model = Model::paint(&recipe);
                (recipe, model)
            })
            .find(|(_, model)| size.texels() > 100 || tells(model))
            .expect("one of a thousand files of noise has a line feed in it");
        Sample {
            format,
            file: write(&recipe, &model).bytes,
            values: Values::Painted(model),
            size,
        }
    }

    fn expected(&self, view: &View) -> Expected {
        Expected::of(&self.values, view).expect("a painted map has every view")
    }
}

/// Takes all steps with `decoder`, which was made of `command`.
#[must_use]
pub fn probe(command: &[OsString], decoder: &Decoder, scratch: &Scratch) -> Checklist {
    let companion = Companion {
        command,
        limits: decoder,
        scratch,
    };
    let mut list = Checklist::default();
    if let Err((says, next)) = command::look(command) {
        list.bad(says, next);
        return list;
    }
    let Some((sample, views)) = companion.first_frame(&mut list) else {
        return list;
    };
    list.answers = true;
    companion.large_frame(sample.format, &views, &mut list);
    companion.refusals(&sample, &views[0], &mut list);
    companion.other_views(&sample, &mut list);
    companion.capabilities(&mut list);
    serve::look(&companion, &sample, &views[0], &mut list);
    list
}

/// Formats by how many readers know them.
const FORMATS: [Format; 9] = [
    Format::Lrgb,
    Format::Rgb,
    Format::PtmCLut,
    Format::PtmLut,
    Format::Lum,
    Format::JpegRgb,
    Format::JpegLrgb,
    Format::JpeglsRgb,
    Format::JpeglsLrgb,
];

fn is_frame(answer: &Answer) -> bool {
    matches!(answer, Answer::Decoded(_))
}

/// Says whether a frame is right, and if not, what would make it right.
fn judge(sample: &Sample, view: &View, reply: &Reply, list: &mut Checklist) {
    let name = sample.format.short_name();
    let Answer::Decoded(frame) = &reply.answer else {
        return;
    };
    let Some(difference) = sample.expected(view).compare(frame) else {
        return list.good(format!("{name} {view}: decoded, and the picture is right"));
    };
    match answer::repair(&reply.stdout, sample, view) {
        Some(trouble) => list.bad(format!("{name} {view}: {}", trouble.says()), trouble.next()),
        None => list.bad(
            format!("{name} {view}: the frame is well-formed, but the picture is wrong: {difference}"),
            "the mistake is not one of wrappers; ptm-conform check names the clause that is misread",
        ),
    }
}

impl Companion<'_> {
    /// Asks with the ordinary words.
    fn ask(&self, view: &View, file: &[u8]) -> Reply {
        self.ask_by(None, view, file)
    }

    /// Asks with other words.
    fn ask_by(&self, template: Option<Template>, view: &View, file: &[u8]) -> Reply {
        let request = Request {
            name: "probe",
            view,
            file,
            // Whatever it prints is looked at: an f64 for each byte of the file, and more.
            largest_frame: file.len().max(1 << 12) * 18,
            patience: 1,
            alone: true,
        };
        match template {
            None => self.limits.ask(&request, self.scratch),
            Some(template) => (self.limits.called_by(template)).ask(&request, self.scratch),
        }
    }

    /// A template of `words` around the command.
    fn around(&self, before: &[&str], after: &[&str]) -> Template {
        let before = before.iter().map(OsString::from);
        let after = after.iter().map(OsString::from);
        let command = self.limits.command().iter().cloned();
        Template::of_words(&before.chain(command).chain(after).collect::<Vec<_>>())
    }

    /// Looks for a format and views that it decodes; judges the pictures.
    fn first_frame(&self, list: &mut Checklist) -> Option<(Sample, Vec<View>)> {
        let views: [View; 3] = [
            View::Raw,
            View::Coef,
            View::ORDINARY_LIGHT.parse().expect("a view"),
        ];
        let mut troubled = None;
        let mut lacking = Vec::new();
        for format in FORMATS {
            let sample = Sample::new(format, "5x3");
            let replies: Vec<Reply> = views
                .iter()
                .map(|view| self.ask(view, &sample.file))
                .collect();
            if replies.iter().any(|reply| is_frame(&reply.answer)) {
                Self::judge_views(&sample, &views, &replies, list);
                if !lacking.is_empty() {
                    list.absent(format!("not decoded: {}", lacking.join(", ")));
                }
                let decoded = views.into_iter().zip(&replies);
                let offered = decoded.filter(|(_, reply)| is_frame(&reply.answer));
                return Some((sample, offered.map(|(view, _)| view).collect()));
            }
            lacking.push(format.short_name());
            let hopeless = replies.iter().any(|reply| {
                matches!(reply.answer, Answer::NotStarted(_) | Answer::Hung(_))
                    || reply.stdout.windows(5).any(|bytes| bytes == b"PTM1 ")
            });
            let bad = views
                .iter()
                .zip(replies)
                .find(|(_, reply)| reply.answer != Answer::Unsupported);
            if let (None, Some((view, reply))) = (&troubled, bad) {
                troubled = Some((sample, view.clone(), reply));
            }
            if hopeless {
                break;
            }
        }
        match troubled {
            Some((sample, view, reply)) => {
                let (says, next) = self.trouble(&sample, &view, &reply);
                list.bad(format!("{} {view}: {says}", sample.format.short_name()), next);
            }
            None => list.bad(
                "it answers 69 (unsupported) to an ordinary file of every format, in every view",
                "start with one format, for example LRGB, and one view, for example raw; 69 is for the rest",
            ),
        }
        None
    }

    /// The answers to one file of which some are frames.
    fn judge_views(sample: &Sample, views: &[View], replies: &[Reply], list: &mut Checklist) {
        for (view, reply) in views.iter().zip(replies) {
            let name = sample.format.short_name();
            match &reply.answer {
                Answer::Decoded(_) => judge(sample, view, reply, list),
                Answer::Unsupported => list.absent(format!(
                    "{name} {view}: answered 69, so this view is not offered, and not needed"
                )),
                answer => match answer::repair(&reply.stdout, sample, view) {
                    Some(trouble) => list.bad(format!("{name} {view}: {}", trouble.says()), trouble.next()),
                    None => list.bad(
                        format!("{name} {view}: {}", answer::briefly(answer)),
                        "if it lacks this view, exit with 69; if not, mend what standard error says",
                    ),
                },
            }
        }
    }

    /// What is wrong with an answer that is no frame, and what to do.
    fn trouble(&self, sample: &Sample, view: &View, reply: &Reply) -> (String, String) {
        if let Some(trouble) = answer::repair(&reply.stdout, sample, view) {
            return (trouble.says(), trouble.next());
        }
        if let Some(found) = command::not_run(self.command, reply) {
            return found;
        }
        self.otherwise(sample, view)
            .unwrap_or_else(|| answer::explain(reply))
    }

    /// Other ways to call that give a frame where the right way gives none.
    fn otherwise(&self, sample: &Sample, view: &View) -> Option<(String, String)> {
        let here = std::env::current_dir().ok()?;
        let here = here.to_string_lossy();
        let stdin = "exec \"$@\" < \"$0\"";
        let home = "cd \"$0\" && exec \"$@\"";
        let ways: [(Template, &str, &str); 6] = [
            (
                self.around(&["sh", "-c", home, &here], &["{view}", "{in}"]),
                "it works in your directory only: calls run in an empty directory of their own",
                "let it find its own files beside itself and not in the working directory; words of the command that name \
                 existing files are made absolute, but not paths within words such as --lib=path",
            ),
            (
                self.around(&["sh", "-c", stdin, "{in}"], &["{view}", "{in}"]),
                "it reads the PTM from standard input, which is empty",
                "open the file whose path is the last argument",
            ),
            (
                self.around(&["sh", "-c", stdin, "{in}"], &["{view}"]),
                "it reads the PTM from standard input and takes no FILE",
                "open the file whose path is the last argument",
            ),
            (
                self.around(&[], &["{in}", "{view}"]),
                "it takes its arguments the other way round",
                "the first is the VIEW, the second the FILE",
            ),
            (
                self.around(&[], &["{in}"]),
                "it takes no VIEW",
                "take VIEW (raw, coef or rgb:LU,LV) and FILE, and answer 69 to a view that it lacks",
            ),
            (
                self.around(&["sh", "-c", stdin, "{in}"], &[]),
                "it reads the PTM from standard input and takes no arguments",
                "take VIEW and FILE, and open the file",
            ),
        ];
        let found = ways.into_iter().find(|(template, ..)| {
            let reply = self.ask_by(Some(template.clone()), view, &sample.file);
            matches!(reply.answer, Answer::Decoded(_))
                || answer::repair(&reply.stdout, sample, view).is_some()
        });
        found.map(|(_, says, next)| (says.to_owned(), next.to_owned()))
    }

    /// A frame that does not fit into a pipe at once.
    fn large_frame(&self, format: Format, views: &[View], list: &mut Checklist) {
        let sample = Sample::new(format, "201x149");
        for view in views {
            let reply = self.ask(view, &sample.file);
            let what = format!("a frame of {} texels in {view}", sample.size.texels());
            match &reply.answer {
                Answer::Decoded(frame)
                    if (frame.width, frame.height) == (sample.size.width, sample.size.height) =>
                {
                    list.good(format!("{what}: complete"));
                }
                Answer::Decoded(frame) => list.bad(
                    format!(
                        "{what}: the frame says {} x {} instead of {}",
                        frame.width, frame.height, sample.size
                    ),
                    "width and height are those of the file",
                ),
                _ => {
                    let (says, next) = answer::explain(&reply);
                    list.bad(format!("{what}: {says}"), next);
                }
            }
        }
    }

    /// Files that every decoder must refuse.
    fn refusals(&self, sample: &Sample, view: &View, list: &mut Checklist) {
        let broken: [(&str, Vec<u8>); 3] = [
            ("an empty file", Vec::new()),
            (
                "a file that is no PTM",
                b"\x89PNG\r\n\x1a\n, which this is not either".to_vec(),
            ),
            (
                "a PTM that ends too soon",
                sample.file[..sample.file.len() - 7].to_vec(),
            ),
        ];
        for (what, file) in broken {
            let reply = self.ask(view, &file);
            match &reply.answer {
                Answer::Rejected => list.good(format!("{what}: refused with 65")),
                answer => {
                    let (says, next) = answer::not_refused(answer, &reply);
                    list.bad(format!("{what}: {says}"), next);
                }
            }
        }
    }

    /// A view that nobody has.
    fn other_views(&self, sample: &Sample, list: &mut Checklist) {
        let words = self.around(&[], &["no-such-view", "{in}"]);
        let reply = self.ask_by(Some(words), &View::Raw, &sample.file);
        match &reply.answer {
            Answer::Unsupported => list.good("an unknown view: answered 69"),
            Answer::Decoded(_) => list.bad(
                "an unknown view: it prints a frame all the same",
                "look at VIEW, and answer 69 to one that it lacks",
            ),
            answer => list.bad(
                format!("an unknown view: {}", answer::briefly(answer)),
                "exit with 69 where VIEW is one that it lacks",
            ),
        }
    }

    /// What it says of itself.
    fn capabilities(&self, list: &mut Checklist) {
        let words = self.around(&[], &["capabilities"]);
        let reply = self.ask_by(Some(words), &View::Raw, b"");
        let text = String::from_utf8_lossy(&reply.stdout);
        let says_so = text.lines().any(|line| line.trim_end() == "protocol: 1");
        if reply.exit == Some(0) && says_so {
            list.good("capabilities: told");
        } else {
            list.absent("capabilities: not told, and not needed");
        }
    }
}
