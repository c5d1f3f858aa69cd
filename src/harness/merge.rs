//! Parts of a run put together: the decoder that the merged run asks is the answers that the parts kept.
//!
//! So everything that a whole run finds out is found out again by the same code: first files, spelling of tables, verdicts,
//! dialect, diagnoses. A decoder that answers the same to the same request gets the report of the whole run, byte for
//! byte.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::harness::capabilities::Capabilities;
use crate::harness::cases::{Case, Suite, TableSpelling};
use crate::harness::check::{Plan, Remark, Repeat, Run, check};
use crate::harness::compare::Expected;
use crate::harness::corpus;
use crate::harness::diagnose::{assume, diagnose};
use crate::harness::judge::Finding;
use crate::harness::misreadings::{self, Misreading};
use crate::harness::protocol::{Answer, View};
use crate::harness::report::{self, Report};
use crate::harness::run::{Reply, Request};
use crate::harness::shards::{self, Circumstances, End, Kept, Line, Part};
use crate::harness::transform;

/// The report of a run: with the remarks that are not made of answers, the diagnoses, and what the decoder says of itself.
///
/// # Errors
/// Those of [`named`].
pub fn conclude(
    suite: &Suite,
    run: &mut Run,
    circumstances: &Circumstances,
    (before, after): &(Vec<Remark>, Vec<Remark>),
    jobs: usize,
) -> Result<Report, String> {
    let assumed = named(&circumstances.assumed)?;
    run.remarks.splice(0..0, before.iter().cloned());
    run.remarks.extend(after.iter().cloned());
    // What is assumed is said.
    let common = match assumed.is_empty() {
        true => transform::common(suite, run),
        false => Vec::new(),
    };
    run.remarks
        .splice(0..0, common.into_iter().map(Remark::failure));
    assume(suite, run, &assumed, jobs);
    let diagnoses = diagnose(suite, run, &assumed, jobs);
    if run.stop.load(Ordering::Relaxed) {
        let says = "the search for causes was interrupted: failures stand without one";
        run.remarks.push(Remark::note(says.to_owned()));
    }
    let capabilities = Capabilities {
        name: circumstances.name.clone(),
        version: circumstances.version.clone(),
        ..Capabilities::default()
    };
    let mode = if circumstances.serves {
        "serve"
    } else {
        "one-shot"
    };
    let limits = circumstances.limits.clone();
    let report = Report::new(suite, run, &diagnoses, &circumstances.command, limits);
    Ok(report.about(&capabilities, mode))
}

/// The misreadings of these names.
///
/// # Errors
/// A sentence with the first that is none.
pub fn named(slugs: &[String]) -> Result<Vec<&'static Misreading>, String> {
    let one = |slug: &String| {
        misreadings::named(slug)
            .ok_or_else(|| format!("--assume {slug}: no misreading is called so"))
    };
    slugs.iter().map(one).collect()
}

/// What the parts of a run kept.
pub struct Answers {
    /// By file, view, and whether a process of its own was asked.
    known: HashMap<(String, String, bool), Kept>,
    circumstances: Circumstances,
    remarks: (Vec<Remark>, Vec<Remark>),
    selected: Vec<String>,
}

impl Answers {
    /// Reads the answers beside these reports.
    ///
    /// # Errors
    /// A sentence: a file is damaged or of another run, suite or version, or a part is missing, there twice or not ended.
    pub fn read(suite: &Suite, reports: &[PathBuf]) -> Result<Answers, String> {
        let mut known = HashMap::new();
        let mut ends: Vec<(&Path, End)> = Vec::new();
        for report in reports {
            let (kept, end) = read(&shards::beside(report))
                .map_err(|error| format!("{}: {error}", shards::beside(report).display()))?;
            known.extend(kept.into_iter().map(|kept| {
                let key = (kept.file.clone(), kept.view.clone(), kept.alone);
                (key, kept)
            }));
            ends.push((report, end));
        }
        check_parts(&ends)?;
        ends.sort_by_key(|(_, end)| end.part.number);
        let (
            first,
            End {
                corpus,
                circumstances,
                ..
            },
        ) = ends.first().ok_or("no reports")?;
        if *corpus != report::digest(suite) {
            return Err(format!(
                "{}: its suite is not that of this program",
                first.display()
            ));
        }
        let mut remarks: (Vec<Remark>, Vec<Remark>) = Default::default();
        for (
            _,
            End {
                remarks: (before, after),
                ..
            },
        ) in &ends
        {
            add_new(&mut remarks.0, before);
            add_new(&mut remarks.1, after);
        }
        Ok(Answers {
            known,
            circumstances: circumstances.clone(),
            remarks,
            selected: ends
                .iter()
                .flat_map(|(_, end)| end.selected.clone())
                .collect(),
        })
    }

    /// The whole run and its report. `progress` is told as by [`check`].
    ///
    /// # Errors
    /// A sentence, if no part asked for something that the whole needs.
    pub fn merge(
        &self,
        suite: &Suite,
        jobs: usize,
        progress: &(impl Fn(&Case, &Finding, usize, usize) + Sync),
    ) -> Result<(Run, Report), String> {
        let selected = suite
            .cases
            .iter()
            .map(|case| self.selected.contains(&case.id));
        let Circumstances {
            declared_views,
            declared_formats,
            serves,
            views,
            withheld,
            ..
        } = &self.circumstances;
        let why_withheld: HashMap<&str, &String> = withheld
            .iter()
            .map(|(id, why)| (id.as_str(), why))
            .collect();
        let why = |case: &Case| why_withheld.get(case.id.as_str()).map(|&why| why.clone());
        let known = |views: &Vec<String>| {
            let known = ["raw", "coef", "rgb"].into_iter();
            known
                .filter(|&view| views.iter().any(|asked| asked == view))
                .collect::<Vec<_>>()
        };
        let plan = Plan {
            selected: selected.collect(),
            jobs,
            views: known(views),
            withheld: match withheld.is_empty() {
                true => Vec::new(),
                false => suite.cases.iter().map(why).collect(),
            },
            made_before: false,
            declared: Capabilities {
                views: declared_views.as_ref().map(known),
                formats: declared_formats.as_ref().map(|formats| {
                    formats
                        .iter()
                        .filter_map(|name| name.parse().ok())
                        .collect()
                }),
                ..Capabilities::default()
            },
            repeat: if *serves {
                Repeat::FailuresAndSample
            } else {
                Repeat::Failures
            },
            stop: Arc::new(AtomicBool::new(false)),
        };
        let missing = Mutex::new(None);
        let ask = |request: &Request<'_>, _: usize| {
            self.reply(suite, request).unwrap_or_else(|| {
                let what = format!("{} in {}", request.name, request.view);
                missing
                    .lock()
                    .expect("no worker panics")
                    .get_or_insert(what);
                Answer::NotStarted("no part of the run asked for this".to_owned()).into()
            })
        };
        let mut run = check(suite, &plan, &ask, progress);
        if let Some(what) = missing.into_inner().expect("no worker panics") {
            return Err(format!(
                "no part of the run asked for {what}: does the decoder answer differently each time?"
            ));
        }
        let report = conclude(suite, &mut run, &self.circumstances, &self.remarks, jobs)?;
        Ok((run, report))
    }

    /// What was answered. What no part asked for twice, because its own verdict gave no reason to, is taken to be steady.
    fn reply(&self, suite: &Suite, request: &Request) -> Option<Reply> {
        let key = |alone| {
            (
                shards::digest(request.file),
                request.view.to_string(),
                alone,
            )
        };
        let again = self.known.get(&key(true)).filter(|_| request.alone);
        let kept = again.or_else(|| self.known.get(&key(false)))?;
        let answer = match &kept.answer {
            Some(answer) => answer.clone(),
            None => expected(suite, &kept.case, request.view)?,
        };
        Some(Reply {
            stderr: kept.stderr.clone(),
            exit: kept.exit,
            after: kept.after.clone(),
            served: kept.served.clone(),
            ..answer.into()
        })
    }
}

/// The picture that a case expects.
fn expected(suite: &Suite, id: &str, view: &View) -> Option<Answer> {
    let built = suite.case(id)?.build(TableSpelling::default());
    let expected = Expected::of(&built.values, view)?;
    Some(Answer::Decoded(corpus::picture(&expected, view)))
}

fn add_new(remarks: &mut Vec<Remark>, more: &[Remark]) {
    for remark in more {
        if !remarks.contains(remark) {
            remarks.push(remark.clone());
        }
    }
}

/// The answers of one part, and the line that ends them.
fn read(path: &Path) -> Result<(Vec<Kept>, End), String> {
    let file = File::open(path).map_err(|error| error.to_string())?;
    let mut answers = Vec::new();
    for (number, line) in BufReader::new(file).lines().enumerate() {
        let line = line.map_err(|error| error.to_string())?;
        match serde_json::from_str(&line) {
            Ok(Line::Answer(kept)) => answers.push(*kept),
            Ok(Line::End(end)) => return Ok((answers, *end)),
            Err(error) => return Err(format!("line {}: {error}", number + 1)),
        }
    }
    Err("it has no last line; did the run not end?".to_owned())
}

/// Whether these are the parts of one run, all of them.
fn check_parts(ends: &[(&Path, End)]) -> Result<(), String> {
    let Some((first_path, first)) = ends.first() else {
        return Err("no reports to merge".to_owned());
    };
    for (path, end) in ends {
        let named = |what: &str| Err(format!("{}: {what}", path.display()));
        if end.version != env!("CARGO_PKG_VERSION") {
            return named(&format!(
                "written by version {} of this program",
                end.version
            ));
        }
        if (end.part.of, &end.corpus, &end.circumstances)
            != (first.part.of, &first.corpus, &first.circumstances)
        {
            return named(&format!("not of the same run as {}", first_path.display()));
        }
        if let Some(why) = &end.ended_early {
            return named(&format!(
                "part {} did not end: {why}; run it again",
                end.part
            ));
        }
    }
    for number in 1..=first.part.of {
        let part = Part {
            number,
            ..first.part
        };
        match ends.iter().filter(|(_, end)| end.part == part).count() {
            1 => {}
            0 => return Err(format!("part {part} is missing")),
            _ => return Err(format!("part {part} is there twice")),
        }
    }
    Ok(())
}
