//! One run: first files, the spelling of tables, then every case once.
//!
//! The decoder is a closure from request to reply, so that a misreading inside this program and a program outside it
//! are asked, compared and judged in the same way.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use crate::harness::cases::{Case, Expect, Feature, Suite, TableSpelling, Values};
use crate::harness::choices;
use crate::harness::compare::Expected;
use crate::harness::judge::{Finding, Judgement, Outcome, Right, Shown, judge};
use crate::harness::protocol::{Answer, View};
use crate::harness::run::{Reply, Request};

/// What of a suite is run, and how.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Which cases are judged, a place for each case of the suite.
    pub selected: Vec<bool>,
    /// Requests at a time, at least 1.
    pub jobs: usize,
    /// Views to ask for; all that the decoder offers if empty.
    pub views: Vec<&'static str>,
    /// Set when the user wants the run to end.
    pub stop: Arc<AtomicBool>,
}

/// What a run showed.
#[derive(Clone, Debug)]
pub struct Run {
    /// What was found, a place for each case of the suite.
    pub findings: Vec<Option<Finding>>,
    /// The verdicts.
    pub judgement: Judgement,
    /// The views the decoder offers.
    pub views: Vec<&'static str>,
    /// How the tables' counts were spelled for it.
    pub table: TableSpelling,
    /// How many requests were sent.
    pub asked: usize,
    /// How many of them ended in neither a frame nor a refusal.
    pub misconduct: usize,
    /// Why the run ended before all cases were asked, if it did.
    pub ended_early: Option<&'static str>,
    /// Why the program is no decoder, if it is none.
    pub not_a_decoder: Option<String>,
}

/// So many hangs in a row end a run.
const HANGS: usize = 3;

/// Runs `suite` against a decoder. `progress` is told of each case as it is done: what was found, and how many of how
/// many are done.
pub fn check(
    suite: &Suite,
    plan: &Plan,
    ask: &(impl Fn(&Request, usize) -> Reply + Sync),
    progress: &(impl Fn(&Case, &Finding, usize, usize) + Sync),
) -> Run {
    let asked = Asked {
        ask,
        count: AtomicUsize::new(0),
        misconduct: AtomicUsize::new(0),
        hangs: AtomicUsize::new(0),
        stop: &plan.stop,
    };
    let mut run = Run {
        findings: vec![None; suite.cases.len()],
        judgement: judge(
            suite,
            &vec![false; suite.cases.len()],
            &vec![None; suite.cases.len()],
        ),
        views: Vec::new(),
        table: TableSpelling::default(),
        asked: 0,
        misconduct: 0,
        ended_early: None,
        not_a_decoder: None,
    };
    let first = first_files(suite, plan, &asked);
    run.views = offered(&first);
    // A decoder of tables only may refuse all first files because it knows another spelling of the count.
    let answers = first
        .iter()
        .any(|(_, reply)| matches!(reply.answer, Answer::Decoded(_) | Answer::Rejected));
    let table = if answers {
        table_spelling(suite, &run.views, &asked)
    } else {
        None
    };
    run.not_a_decoder = if table.is_some() {
        None
    } else {
        no_decoder(&first)
    };
    if run.not_a_decoder.is_none() {
        run.table = table.unwrap_or_default();
        let wanted = with_twins(suite, &plan.selected);
        run.findings = all_cases(
            suite, &wanted, plan.jobs, &run.views, run.table, &asked, progress,
        );
        run.judgement = judge(suite, &plan.selected, &run.findings);
        run.ended_early = asked.why_over();
        say_what_was_not_run(suite, &mut run);
        run.not_a_decoder = nothing_decoded(suite, &run.findings);
    }
    run.asked = asked.count.into_inner();
    run.misconduct = asked.misconduct.into_inner();
    run
}

/// The decoder, and a count of what it was asked.
struct Asked<'a, F> {
    ask: &'a F,
    count: AtomicUsize,
    misconduct: AtomicUsize,
    /// Hangs in a row.
    hangs: AtomicUsize,
    stop: &'a AtomicBool,
}

impl<F: Fn(&Request, usize) -> Reply + Sync> Asked<'_, F> {
    /// Why the run should not go on, if it should not.
    fn why_over(&self) -> Option<&'static str> {
        if self.stop.load(Ordering::Relaxed) {
            Some("the run was ended by its user")
        } else if self.hangs.load(Ordering::Relaxed) >= HANGS {
            Some("the run ended after three hangs in a row")
        } else {
            None
        }
    }

    fn is_over(&self) -> bool {
        self.why_over().is_some()
    }

    /// Asks for `case` in `view` and holds the answer against what is expected. `worker` numbers those who ask at once.
    fn find(
        &self,
        case: &Case,
        view: &View,
        table: TableSpelling,
        worker: usize,
    ) -> (Finding, Reply) {
        let built = case.build(table);
        // An f32 for each of 18 channels is the most a frame can have for a texel.
        let texels = match &built.values {
            Values::Painted(model) => model.size.texels(),
            _ => case
                .recipe()
                .map_or(built.file.len(), |recipe| recipe.size.texels())
                .max(built.file.len()),
        };
        let calls = self.count.fetch_add(1, Ordering::Relaxed);
        let patience = if calls == 0 { 3 } else { 1 };
        let request = Request {
            name: &case.id,
            view,
            file: &built.file,
            largest_frame: texels * 18 * 4,
            patience,
        };
        let reply = (self.ask)(&request, worker);
        if reply.answer.misconduct().is_some() {
            self.misconduct.fetch_add(1, Ordering::Relaxed);
        }
        if matches!(reply.answer, Answer::Hung(_)) {
            self.hangs.fetch_add(1, Ordering::Relaxed);
        } else if !self.is_over() {
            self.hangs.store(0, Ordering::Relaxed);
        }
        let shown = match &reply.answer {
            Answer::Rejected => Shown::Rejected,
            Answer::Unsupported => Shown::Unsupported,
            Answer::Decoded(frame) => {
                let expected = Expected::of(&built.values, view);
                let difference = expected
                    .as_ref()
                    .and_then(|expected| expected.compare(frame));
                let axes = choices::concerned(case, view);
                let right = match expected {
                    Some(expected) if !axes.is_empty() => {
                        let pictures = choices::pictures(&built, view, expected, &axes);
                        let shown = |picture: &Option<Expected>| {
                            picture
                                .as_ref()
                                .is_some_and(|picture| picture.compare(frame).is_none())
                        };
                        Right::In {
                            axes,
                            combinations: pictures.iter().map(shown).collect(),
                        }
                    }
                    expected => Right::Anyway(
                        matches!(built.values, Values::Any)
                            || expected.is_some() && difference.is_none(),
                    ),
                };
                let frame =
                    (right != Right::Anyway(true) && difference.is_some()).then(|| frame.clone());
                Shown::Picture {
                    right,
                    difference,
                    frame,
                }
            }
            _ => Shown::Misconduct(reply.answer.clone()),
        };
        (
            Finding {
                view: view.clone(),
                shown,
                stderr: reply.stderr.clone(),
            },
            reply,
        )
    }
}

/// The first files in every view that may be asked for.
fn first_files(
    suite: &Suite,
    plan: &Plan,
    asked: &Asked<impl Fn(&Request, usize) -> Reply + Sync>,
) -> Vec<(View, Reply)> {
    let mut replies = Vec::new();
    for case in suite.cases.iter().filter(|case| case.first) {
        for view in &case.views {
            if plan.views.is_empty() || plan.views.contains(&view.name()) {
                let (_, reply) = asked.find(case, view, TableSpelling::default(), 0);
                let hopeless = matches!(reply.answer, Answer::NotStarted(_)) || asked.is_over();
                replies.push((view.clone(), reply));
                if hopeless {
                    return replies;
                }
            }
        }
    }
    replies
}

/// Why the program behind these replies is no decoder, if it is none.
fn no_decoder(first: &[(View, Reply)]) -> Option<String> {
    let decoded = first
        .iter()
        .any(|(_, reply)| matches!(reply.answer, Answer::Decoded(_)));
    let refused = first
        .iter()
        .any(|(_, reply)| matches!(reply.answer, Answer::Rejected));
    let (_, reply) = first
        .iter()
        .find(|(_, reply)| reply.answer.misconduct().is_some())
        .or(first.first())?;
    let why = match (&reply.answer, reply.exit) {
        (Answer::NotStarted(why), _) => format!("it cannot be started: {why}"),
        (_, Some(status @ (126 | 127))) if !decoded => {
            format!("its command cannot be run: exit status {status}")
        }
        _ if decoded => return None,
        (Answer::Unsupported, _) if !refused => {
            "it answers every first file with 69 (unsupported) in every view".to_owned()
        }
        (Answer::Rejected | Answer::Unsupported, _) => {
            "it decodes no first file in any view".to_owned()
        }
        (answer, _) => format!(
            "it answers no first file with a well-formed frame, in any view; the first of its answers: {}: {}",
            answer.name(),
            answer.misconduct().unwrap_or_default()
        ),
    };
    Some(if reply.stderr.is_empty() {
        why
    } else {
        format!("{why}\nits standard error begins:\n{}", reply.stderr)
    })
}

/// The views that are offered: all but those in which every first file was answered 69.
fn offered(first: &[(View, Reply)]) -> Vec<&'static str> {
    let offers = |name: &&str| {
        first
            .iter()
            .any(|(view, reply)| view.name() == *name && reply.answer != Answer::Unsupported)
    };
    ["raw", "coef", "rgb"].into_iter().filter(offers).collect()
}

/// The first spelling of a table in which the decoder shows the right picture.
fn table_spelling(
    suite: &Suite,
    views: &[&str],
    asked: &Asked<impl Fn(&Request, usize) -> Reply + Sync>,
) -> Option<TableSpelling> {
    for case in suite
        .cases
        .iter()
        .filter(|case| case.expect == Expect::Spelling)
    {
        let (Some(view), Some(recipe)) = (chosen_view(case, views), case.recipe()) else {
            continue;
        };
        let (finding, _) = asked.find(case, view, TableSpelling::default(), 0);
        if matches!(
            finding.shown,
            Shown::Picture {
                right: Right::Anyway(true),
                ..
            }
        ) {
            return Some(TableSpelling {
                count: recipe.spelling.count,
                newline: recipe.spelling.newline_after_table,
            });
        }
    }
    None
}

/// The first of the case's views that is offered.
fn chosen_view<'a>(case: &'a Case, views: &[&str]) -> Option<&'a View> {
    case.views.iter().find(|view| views.contains(&view.name()))
}

/// The selected cases and the twins they stand on.
fn with_twins(suite: &Suite, selected: &[bool]) -> Vec<bool> {
    let mut wanted = selected.to_vec();
    for (case, _) in suite
        .cases
        .iter()
        .zip(selected)
        .filter(|&(_, &selected)| selected)
    {
        if let Some(twin) = case
            .twin_of
            .as_ref()
            .and_then(|twin| suite.cases.iter().position(|case| case.id == *twin))
        {
            wanted[twin] = true;
        }
    }
    wanted
}

/// Every wanted case, asked once in the first of its views that is offered.
fn all_cases(
    suite: &Suite,
    wanted: &[bool],
    jobs: usize,
    views: &[&'static str],
    table: TableSpelling,
    asked: &Asked<impl Fn(&Request, usize) -> Reply + Sync>,
    progress: &(impl Fn(&Case, &Finding, usize, usize) + Sync),
) -> Vec<Option<Finding>> {
    let work: Vec<(usize, &View)> = (0..suite.cases.len())
        .filter(|&i| wanted[i])
        .filter_map(|i| Some((i, chosen_view(&suite.cases[i], views)?)))
        .collect();
    let next = AtomicUsize::new(0);
    let done = AtomicUsize::new(0);
    let findings = Mutex::new(vec![None; suite.cases.len()]);
    std::thread::scope(|scope| {
        for worker in 0..jobs {
            let (work, next, done, findings) = (&work, &next, &done, &findings);
            scope.spawn(move || {
                while let Some(&(i, view)) = work.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let (finding, _) = asked.find(&suite.cases[i], view, table, worker);
                    if asked.stop.load(Ordering::Relaxed) {
                        break;
                    }
                    progress(
                        &suite.cases[i],
                        &finding,
                        done.fetch_add(1, Ordering::Relaxed) + 1,
                        work.len(),
                    );
                    findings.lock().expect("no worker panics")[i] = Some(finding);
                    if asked.is_over() {
                        break;
                    }
                }
            });
        }
    });
    findings.into_inner().expect("no worker panics")
}

/// Cases that could have been asked and were not, because the run ended before.
fn say_what_was_not_run(suite: &Suite, run: &mut Run) {
    for ((case, finding), judged) in suite
        .cases
        .iter()
        .zip(&run.findings)
        .zip(&mut run.judgement.cases)
    {
        if let (None, Some(judged), Some(_)) = (finding, judged, chosen_view(case, &run.views)) {
            judged.outcome = Outcome::NotRun;
            judged.says = run.ended_early.map(str::to_owned).unwrap_or_default();
        }
    }
}

/// Whether every must-accept file was answered 69.
fn nothing_decoded(suite: &Suite, findings: &[Option<Finding>]) -> Option<String> {
    let mut accepted = suite
        .cases
        .iter()
        .zip(findings)
        .filter(|(case, _)| case.expect == Expect::Decode);
    let all = accepted.clone().any(|(_, finding)| finding.is_some())
        && accepted.all(|(_, finding)| {
            finding
                .as_ref()
                .is_none_or(|finding| matches!(finding.shown, Shown::Unsupported))
        });
    all.then(|| "it answers every file that it should decode with 69 (unsupported)".to_owned())
}

/// The three scores; never one percentage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scores {
    /// Cases passed, of those judged among the required ones of supported features.
    pub correctness: (usize, usize),
    /// Features decoded, of all in the suite.
    pub breadth: (usize, usize),
    /// Calls that ended in a frame or a refusal, of all calls.
    pub robustness: (usize, usize),
}

impl Run {
    /// The scores of this run.
    #[must_use]
    pub fn scores(&self, suite: &Suite) -> Scores {
        let judged = self
            .judgement
            .cases
            .iter()
            .flatten()
            .filter(|judged| matches!(judged.outcome, Outcome::Pass | Outcome::Fail));
        let passed = judged
            .clone()
            .filter(|judged| judged.outcome == Outcome::Pass)
            .count();
        let features: std::collections::BTreeSet<Feature> = suite
            .cases
            .iter()
            .flat_map(|case| case.views.iter().flat_map(|view| case.features(view)))
            .collect();
        Scores {
            correctness: (passed, judged.count()),
            breadth: (self.judgement.decoded.len(), features.len()),
            robustness: (self.asked - self.misconduct, self.asked),
        }
    }

    /// The exit status of `check`: 0, 1 or 3.
    #[must_use]
    pub fn exit_status(&self) -> u8 {
        let failed = self
            .judgement
            .cases
            .iter()
            .flatten()
            .any(|judged| judged.outcome == Outcome::Fail);
        match self.not_a_decoder {
            Some(_) => 3,
            None => u8::from(failed || self.ended_early.is_some() || !self.decoded_something()),
        }
    }

    /// Whether a picture came of any file.
    fn decoded_something(&self) -> bool {
        self.findings
            .iter()
            .flatten()
            .any(|finding| matches!(finding.shown, Shown::Picture { .. }))
    }
}
