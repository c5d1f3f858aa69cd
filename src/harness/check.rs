//! One run: first files, the spelling of tables, then every case once, and failures once more.
//!
//! The decoder is a closure from request to reply, so that a misreading inside this program and a program outside it
//! are asked, compared and judged in the same way.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use serde::{Deserialize, Serialize};

use crate::generate::spelling::Count;
use crate::harness::baseline::News;
use crate::harness::capabilities::Capabilities;
use crate::harness::cases::{Case, Expect, Feature, Suite, TableSpelling, Values};
use crate::harness::choices;
use crate::harness::compare::Expected;
use crate::harness::judge::{Finding, Judgement, Offer, Outcome, Right, Shown, Unsteady, judge};
use crate::harness::protocol::{Answer, View};
use crate::harness::run::{Reply, Request};
use crate::harness::tally::Tally;
use crate::ptm::Format;

/// What of a suite is run, and how.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Which cases are judged, a place for each case of the suite.
    pub selected: Vec<bool>,
    /// Requests at a time, at least 1.
    pub jobs: usize,
    /// Views to ask for; all that the decoder offers if empty.
    pub views: Vec<&'static str>,
    /// What the decoder says of itself.
    pub declared: Capabilities,
    /// What is asked again.
    pub repeat: Repeat,
    /// Why a case is not asked, a place for each case of the suite; nothing for those that are. Empty if all are.
    pub withheld: Vec<Option<String>>,
    /// Whether the answers were made before the run: there are no first files, and tables stand in the ordinary spelling.
    pub made_before: bool,
    /// Set when the user wants the run to end.
    pub stop: Arc<AtomicBool>,
}

/// Which cases are asked again, of a process of its own, to find answers that differ.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Repeat {
    /// None: the decoder is a function.
    #[default]
    Nothing,
    /// Those that failed: it may answer differently each time.
    Failures,
    /// Those that failed, and one in [`SAMPLE`] of the others: it serves, and may carry something from file to file.
    FailuresAndSample,
}

/// Of so many cases that did not fail, one is asked again.
pub const SAMPLE: usize = 100;

/// What the decoder did with a first file.
#[derive(Clone, Debug)]
pub struct First {
    /// Its place in the suite.
    pub case: usize,
    /// The view it was asked in.
    pub view: View,
    /// What came.
    pub reply: Reply,
}

/// Something to say of a run as a whole.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Remark {
    /// Whether the decoder fails because of it.
    pub failure: bool,
    /// A sentence.
    pub says: String,
}

impl Remark {
    /// A reason to fail.
    #[must_use]
    pub fn failure(says: String) -> Remark {
        Remark {
            failure: true,
            says,
        }
    }

    /// Something to know.
    #[must_use]
    pub fn note(says: String) -> Remark {
        Remark {
            failure: false,
            says,
        }
    }
}

/// What a run showed.
#[derive(Clone, Debug)]
pub struct Run {
    /// What was found, a place for each case of the suite.
    pub findings: Vec<Option<Finding>>,
    /// The verdicts.
    pub judgement: Judgement,
    /// What the decoder did with the first files.
    pub first: Vec<First>,
    /// What the decoder offers.
    pub offer: Offer,
    /// How the tables' counts were spelled for it.
    pub table: TableSpelling,
    /// What is to be said of the run as a whole.
    pub remarks: Vec<Remark>,
    /// How many requests were sent, those that were asked again not counted.
    pub asked: usize,
    /// How many of them ended in neither a frame nor a refusal.
    pub misconduct: usize,
    /// Why the run ended before all cases were asked, if it did.
    pub ended_early: Option<&'static str>,
    /// Why the program is no decoder, if it is none.
    pub not_a_decoder: Option<String>,
    /// Set when the user wants the search for causes to end.
    pub stop: Arc<AtomicBool>,
}

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
        tally: Tally::new(&plan.stop),
    };
    let nothing = vec![None; suite.cases.len()];
    let mut run = Run {
        judgement: judge(
            suite,
            &vec![false; suite.cases.len()],
            &nothing,
            &Offer::default(),
        ),
        findings: nothing,
        first: first_files(suite, plan, &asked),
        offer: Offer::default(),
        table: TableSpelling::default(),
        remarks: Vec::new(),
        asked: 0,
        misconduct: 0,
        ended_early: None,
        not_a_decoder: None,
        stop: Arc::clone(&plan.stop),
    };
    run.remarks.extend(first_trouble(suite, &run.first));
    run.offer = offered(suite, plan, &run.first, &asked, &mut run.remarks);
    // Where no first file could be asked, the views are those that were asked for.
    if run.first.is_empty() {
        run.offer.views.clone_from(&plan.views);
    }
    // A decoder of tables only may refuse all first files because it knows another spelling of the count.
    let answers = run.first.is_empty()
        || run
            .first
            .iter()
            .any(|first| matches!(first.reply.answer, Answer::Decoded(_) | Answer::Rejected));
    let table = if answers {
        table_spelling(suite, plan, &run.offer, &asked)
    } else {
        None
    };
    run.not_a_decoder = if table.is_some() {
        None
    } else {
        no_decoder(&run.first)
    };
    if run.not_a_decoder.is_none() {
        let likely = || match plan.made_before {
            true => None,
            false => likely_spelling(suite, &run.offer, &asked),
        };
        run.table = table.or_else(likely).unwrap_or_default();
        let withheld = withheld(suite, plan, run.table);
        let mut wanted = with_twins(suite, &plan.selected);
        for (wanted, why) in wanted.iter_mut().zip(&withheld) {
            *wanted &= why.is_none();
        }
        run.findings = all_cases(
            suite, &wanted, plan, &run.offer, run.table, &asked, progress,
        );
        run.judgement = judge(suite, &plan.selected, &run.findings, &run.offer);
        run.ended_early = asked.tally.why_over();
        if run.ended_early.is_none() && ask_again(suite, plan, &mut run, &asked) {
            run.judgement = judge(suite, &plan.selected, &run.findings, &run.offer);
        }
        say_what_was_not_run(suite, &withheld, &mut run);
        run.not_a_decoder = nothing_decoded(suite, &run.findings);
    }
    (run.asked, run.misconduct) = asked.tally.counts();
    run
}

/// The decoder, and a count of what it was asked.
struct Asked<'a, F> {
    ask: &'a F,
    tally: Tally<'a>,
}

impl<F: Fn(&Request, usize) -> Reply + Sync> Asked<'_, F> {
    fn is_over(&self) -> bool {
        self.tally.why_over().is_some()
    }

    /// Asks for `case` in `view` and holds the answer against what is expected. `worker` numbers those who ask at once.
    fn find(
        &self,
        case: &Case,
        view: &View,
        table: TableSpelling,
        worker: usize,
    ) -> (Finding, Reply) {
        let patience = self.tally.call();
        let (finding, reply) = self.ask(case, view, table, worker, patience, false);
        let is_hang = |answer: &Answer| matches!(answer, Answer::Hung(_));
        self.tally.came_to(
            reply.answer.misconduct().is_some() || reply.served.is_some(),
            is_hang(&reply.answer) || reply.served.as_ref().is_some_and(is_hang),
        );
        (finding, reply)
    }

    /// The same without counting; `alone` asks a process of its own.
    fn ask(
        &self,
        case: &Case,
        view: &View,
        table: TableSpelling,
        worker: usize,
        patience: u32,
        alone: bool,
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
        let request = Request {
            name: &case.id,
            view,
            file: &built.file,
            largest_frame: texels * 18 * 4,
            patience,
            alone,
        };
        let reply = (self.ask)(&request, worker);
        let shown = match &reply.answer {
            Answer::Rejected => Shown::Rejected,
            Answer::Unsupported => Shown::Unsupported,
            Answer::Decoded(frame) => {
                let expected = Expected::of(&built.values, view);
                let difference = expected
                    .as_ref()
                    .and_then(|expected| expected.compare(frame));
                let another_transform = expected
                    .as_ref()
                    .is_some_and(|expected| expected.is_another_transform(frame));
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
                    another_transform,
                    frame,
                }
            }
            _ => Shown::Misconduct(reply.answer.clone()),
        };
        (
            Finding {
                view: view.clone(),
                shown,
                weak: reply.is_weak(),
                stderr: reply.stderr.clone(),
                after: reply.after.clone(),
                unsteady: trouble_of_serving(&reply),
            },
            reply,
        )
    }
}

/// What a serving process did instead of answering, where another answered.
fn trouble_of_serving(reply: &Reply) -> Option<Unsteady> {
    let served = reply.served.as_ref()?;
    let says = format!(
        "in serve mode{}: {}: {}; asked alone it answers ({})",
        behind(reply.after.as_ref()),
        served.name(),
        served.misconduct().unwrap_or_default(),
        reply.answer.name()
    );
    Some(Unsteady { served: true, says })
}

fn behind(after: Option<&String>) -> String {
    match after {
        Some(case) => format!(", after {case}"),
        None => ", as the first request".to_owned(),
    }
}

/// The first files in every view that may be asked for.
fn first_files(
    suite: &Suite,
    plan: &Plan,
    asked: &Asked<impl Fn(&Request, usize) -> Reply + Sync>,
) -> Vec<First> {
    let mut replies = Vec::new();
    if plan.made_before {
        return replies;
    }
    let is_asked = |i: usize| plan.withheld.get(i).is_none_or(Option::is_none);
    for (i, case) in (suite.cases.iter().enumerate()).filter(|&(i, case)| case.first && is_asked(i))
    {
        for view in &case.views {
            if plan.may_ask(view.name()) {
                let (_, reply) = asked.find(case, view, TableSpelling::default(), 0);
                let hopeless = matches!(reply.answer, Answer::NotStarted(_)) || asked.is_over();
                replies.push(First {
                    case: i,
                    view: view.clone(),
                    reply,
                });
                if hopeless {
                    return replies;
                }
            }
        }
    }
    replies
}

impl Plan {
    /// Everything is asked once, of a decoder that says nothing of itself.
    #[must_use]
    pub fn of(suite: &Suite, jobs: usize) -> Plan {
        Plan {
            selected: vec![true; suite.cases.len()],
            jobs,
            views: Vec::new(),
            withheld: Vec::new(),
            made_before: false,
            declared: Capabilities::default(),
            repeat: Repeat::Nothing,
            stop: Arc::default(),
        }
    }

    /// Whether a view is asked for at all: if the user wants it and the decoder does not say that it has others.
    fn may_ask(&self, view: &'static str) -> bool {
        let declared = self.declared.views.as_ref();
        let declared = declared.filter(|views| !views.is_empty());
        (self.views.is_empty() || self.views.contains(&view))
            && declared.is_none_or(|views| views.contains(&view))
    }
}

/// The first of the first files that was not answered in serve mode.
fn first_trouble(suite: &Suite, first: &[First]) -> Option<Remark> {
    first.iter().find_map(|first| {
        let id = &suite.cases[first.case].id;
        let what = trouble_of_serving(&first.reply)?;
        Some(Remark::failure(format!(
            "{id} in {}, {}",
            first.view, what.says
        )))
    })
}

/// Why the program behind these replies is no decoder, if it is none.
fn no_decoder(first: &[First]) -> Option<String> {
    let answers = || first.iter().map(|first| &first.reply.answer);
    let decoded = answers().any(|answer| matches!(answer, Answer::Decoded(_)));
    let refused = answers().any(|answer| matches!(answer, Answer::Rejected));
    let First { reply, .. } = first
        .iter()
        .find(|first| first.reply.answer.misconduct().is_some())
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
            let refusals = answers().filter(|answer| matches!(answer, Answer::Rejected));
            format!(
                "it decodes no first file in any view: of {} requests for ordinary files it refuses {} with 65",
                first.len(),
                refusals.count()
            )
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

/// What is offered: all views but those in which every first file was answered 69, and of each format all but those in
/// which every first file of it was.
fn offered(
    suite: &Suite,
    plan: &Plan,
    first: &[First],
    asked: &Asked<impl Fn(&Request, usize) -> Reply + Sync>,
    remarks: &mut Vec<Remark>,
) -> Offer {
    let declared = plan.declared.views.clone().unwrap_or_default();
    let answered = |view: &str, format: Option<Format>| {
        first.iter().any(|first| {
            first.view.name() == view
                && format.is_none_or(|format| suite.cases[first.case].format() == format)
                && first.reply.answer != Answer::Unsupported
        })
    };
    let asked_for = |view: &str| first.iter().any(|first| first.view.name() == view);
    let mut offer = Offer {
        declared: plan.declared.formats.clone().unwrap_or_default(),
        ..Offer::default()
    };
    for view in ["raw", "coef", "rgb"] {
        if answered(view, None) {
            offer.views.push(view);
        } else if declared.contains(&view) && asked_for(view) {
            remarks.push(Remark::failure(format!(
                "its capabilities declare the view {view}, and it answers 69 (unsupported) to every first file in it"
            )));
        }
    }
    if asked.is_over() {
        return offer;
    }
    for format in Format::ALL {
        let has = |view: &&str| answered(view, Some(format));
        if !offer.views.iter().any(has) {
            continue;
        }
        for view in offer.views.clone() {
            if has(&view) || shows_others(suite, view, format, asked) {
                continue;
            }
            offer.lacking.push((view, format));
            if declared.contains(&view) && plan.declared.declares(format) {
                remarks.push(Remark::failure(format!(
                    "its capabilities declare the view {view} and {format}, and it answers 69 (unsupported) to such files in that view"
                )));
            }
        }
    }
    offer
}

/// Whether it shows a file of this format in this view although it did not show the first: a view is lacking as a whole.
fn shows_others(
    suite: &Suite,
    view: &str,
    format: Format,
    asked: &Asked<impl Fn(&Request, usize) -> Reply + Sync>,
) -> bool {
    let others = suite
        .cases
        .iter()
        .filter(|case| case.expect == Expect::Decode && !case.first && case.format() == format)
        .filter_map(|case| Some((case, case.views.iter().find(|of| of.name() == view)?)));
    others.take(3).any(|(case, view)| {
        let (finding, _) = asked.find(case, view, TableSpelling::default(), 0);
        !matches!(finding.shown, Shown::Unsupported)
    })
}

/// The first spelling of a table in which the decoder shows the right picture.
fn table_spelling(
    suite: &Suite,
    plan: &Plan,
    offer: &Offer,
    asked: &Asked<impl Fn(&Request, usize) -> Reply + Sync>,
) -> Option<TableSpelling> {
    let is_asked = |i: usize| plan.withheld.get(i).is_none_or(Option::is_none);
    for (_, case) in (suite.cases.iter().enumerate())
        .filter(|&(i, case)| case.expect == Expect::Spelling && is_asked(i))
    {
        let (Some(view), Some(recipe)) = (offer.chosen_view(case), case.recipe()) else {
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

/// The spelling of tables in which a decoder that shows none of the spelling's own cases rightly comes nearest: by small
/// tables, of which it may show some rightly. None if that says little.
fn likely_spelling(
    suite: &Suite,
    offer: &Offer,
    asked: &Asked<impl Fn(&Request, usize) -> Reply + Sync>,
) -> Option<TableSpelling> {
    const PROBES: usize = 4;
    let mut probes: Vec<&Case> = suite
        .cases
        .iter()
        .filter(|case| case.expect == Expect::Decode && case.format().has_table())
        .collect();
    probes.sort_by_key(|case| case.build(TableSpelling::default()).file.len());
    probes.truncate(PROBES);
    let spellings = Count::ALL
        .into_iter()
        .flat_map(|count| [false, true].map(|newline| TableSpelling { count, newline }));
    let mut scores: Vec<(f64, TableSpelling)> = Vec::new();
    for table in spellings {
        let mut score = 0.0;
        for case in &probes {
            let Some(view) = offer.chosen_view(case) else {
                continue;
            };
            let (finding, _) = asked.find(case, view, table, 0);
            if asked.is_over() {
                return None;
            }
            score += match finding.shown {
                Shown::Unsupported => return None,
                // A wrong picture tells more of the spelling than none: its values may be wrong for another reason.
                Shown::Picture { difference, .. } => {
                    1.0 + difference.map_or(1.0, |difference| difference.likeness())
                }
                _ => 0.0,
            };
        }
        scores.push((score, table));
    }
    let &(ordinary, _) = scores.first()?;
    let best = scores.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    (best.0 > ordinary + PROBES as f64 / 4.0).then_some(best.1)
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
    plan: &Plan,
    offer: &Offer,
    table: TableSpelling,
    asked: &Asked<impl Fn(&Request, usize) -> Reply + Sync>,
    progress: &(impl Fn(&Case, &Finding, usize, usize) + Sync),
) -> Vec<Option<Finding>> {
    let work: Vec<(usize, &View)> = (0..suite.cases.len())
        .filter(|&i| wanted[i])
        .filter_map(|i| Some((i, offer.chosen_view(&suite.cases[i])?)))
        .collect();
    let done = AtomicUsize::new(0);
    let findings = Mutex::new(vec![None; suite.cases.len()]);
    side_by_side(plan, work.len(), |place, worker| {
        let (i, view) = work[place];
        let (finding, _) = asked.find(&suite.cases[i], view, table, worker);
        if plan.stop.load(Ordering::Relaxed) {
            return false;
        }
        progress(
            &suite.cases[i],
            &finding,
            done.fetch_add(1, Ordering::Relaxed) + 1,
            work.len(),
        );
        findings.lock().expect("no worker panics")[i] = Some(finding);
        !asked.is_over()
    });
    findings.into_inner().expect("no worker panics")
}

/// Does `count` things, as many at a time as there are jobs; a worker stops where one says that it should not go on.
fn side_by_side(plan: &Plan, count: usize, one: impl Fn(usize, usize) -> bool + Sync) {
    let (next, one) = (&AtomicUsize::new(0), &one);
    // A serving process gets the same files in the same order in every run, so that what it carries over is found again.
    let fixed = plan.repeat == Repeat::FailuresAndSample;
    std::thread::scope(|scope| {
        for worker in 0..plan.jobs {
            scope.spawn(move || {
                let mut mine = (worker..count).step_by(plan.jobs);
                let any =
                    || Some(next.fetch_add(1, Ordering::Relaxed)).filter(|&place| place < count);
                while let Some(place) = if fixed { mine.next() } else { any() } {
                    if !one(place, worker) {
                        break;
                    }
                }
            });
        }
    });
}

/// Asks again what failed, and a sample of the rest, of processes of their own; says whether an answer was otherwise.
fn ask_again(
    suite: &Suite,
    plan: &Plan,
    run: &mut Run,
    asked: &Asked<impl Fn(&Request, usize) -> Reply + Sync>,
) -> bool {
    let is_wanted = |i: &usize| {
        let (Some(finding), Some(judged)) = (&run.findings[*i], &run.judgement.cases[*i]) else {
            return false;
        };
        // Who hangs once hangs again, and that takes time; of two answers that differ already the case is settled.
        let is_settled = finding.unsteady.is_some()
            || matches!(finding.shown, Shown::Misconduct(Answer::Hung(_)));
        let sampled = plan.repeat == Repeat::FailuresAndSample
            && (i % SAMPLE == SAMPLE / 2 || is_first_unsupported(suite, &run.judgement, *i));
        !is_settled && (judged.outcome == Outcome::Fail || sampled)
    };
    let again: Vec<usize> = match plan.repeat {
        Repeat::Nothing => Vec::new(),
        _ => (0..suite.cases.len()).filter(is_wanted).collect(),
    };
    let differences = Mutex::new(Vec::new());
    let words = Mutex::new(Vec::new());
    side_by_side(plan, again.len(), |place, worker| {
        let i = again[place];
        let finding = run.findings[i]
            .as_ref()
            .expect("only findings are looked at again");
        let (alone, _) = asked.ask(&suite.cases[i], &finding.view, run.table, worker, 1, true);
        if asked.is_over() {
            return false;
        }
        // A serving process may have said nothing of it yet.
        if finding.stderr.is_empty() && !alone.stderr.is_empty() {
            words
                .lock()
                .expect("no worker panics")
                .push((i, alone.stderr.clone()));
        }
        if !alone.shown.is_like(&finding.shown) {
            let how = difference(plan.repeat, finding, &alone);
            differences.lock().expect("no worker panics").push((i, how));
        }
        true
    });
    for (i, stderr) in words.into_inner().expect("no worker panics") {
        if let Some(finding) = &mut run.findings[i] {
            finding.stderr = stderr;
        }
    }
    let differences = differences.into_inner().expect("no worker panics");
    let any = !differences.is_empty();
    for (i, how) in differences {
        if let Some(finding) = &mut run.findings[i] {
            finding.unsteady = Some(how);
        }
    }
    any
}

/// Whether a case is the first of its format that is called unsupported.
fn is_first_unsupported(suite: &Suite, judgement: &Judgement, i: usize) -> bool {
    let format = suite.cases[i].format();
    let mut judged = suite.cases.iter().zip(&judgement.cases);
    let first = judged.position(|(case, judged)| {
        let outcome = judged.as_ref().map(|judged| judged.outcome);
        case.format() == format && outcome == Some(Outcome::Unsupported)
    });
    first == Some(i)
}

/// How two answers to one request differ.
fn difference(repeat: Repeat, finding: &Finding, alone: &Finding) -> Unsteady {
    let (first, second) = (finding.shown.describe(), alone.shown.describe());
    let served = matches!(repeat, Repeat::FailuresAndSample);
    let says = if served {
        format!(
            "in serve mode{}, it answers with {first}; asked alone with {second}: state leaks between files",
            behind(finding.after.as_ref())
        )
    } else {
        format!("answers differently each time: first with {first}, asked again with {second}")
    };
    Unsteady { served, says }
}

/// Why a case is not asked, a place for each case of the suite.
fn withheld(suite: &Suite, plan: &Plan, table: TableSpelling) -> Vec<Option<String>> {
    let mut withheld = plan.withheld.clone();
    withheld.resize(suite.cases.len(), None);
    if plan.made_before && table != TableSpelling::default() {
        for (case, why) in suite.cases.iter().zip(&mut withheld) {
            if case.format().has_table() && case.expect != Expect::Spelling {
                why.get_or_insert_with(|| {
                    "its table is spelled in a way that the decoder does not know".to_owned()
                });
            }
        }
    }
    withheld
}

/// Cases that were not asked: on purpose, or because the run ended before.
fn say_what_was_not_run(suite: &Suite, withheld: &[Option<String>], run: &mut Run) {
    for (((case, finding), judged), why) in suite
        .cases
        .iter()
        .zip(&run.findings)
        .zip(&mut run.judgement.cases)
        .zip(withheld)
    {
        if let (Some(judged), Some(why)) = (judged.as_mut(), why) {
            judged.outcome = Outcome::NotJudged;
            judged.says.clone_from(why);
        } else if let (None, Some(judged), Some(_)) = (finding, judged, run.offer.chosen_view(case))
        {
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
    /// Features decoded, of those in the cases selected.
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
            .zip(&self.judgement.cases)
            .filter(|(_, judged)| judged.is_some())
            .flat_map(|(case, _)| case.views.iter().flat_map(|view| case.features(view)))
            .collect();
        let decoded = self.judgement.decoded.intersection(&features).count();
        Scores {
            correctness: (passed, judged.count()),
            breadth: (decoded, features.len()),
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
        self.status(failed)
    }

    /// The exit status where some failures are known: 0, 1, 3 or 4.
    #[must_use]
    pub fn exit_status_with(&self, news: &News) -> u8 {
        match self.status(!news.new.is_empty()) {
            0 if !news.stale.is_empty() => 4,
            status => status,
        }
    }

    fn status(&self, failed: bool) -> u8 {
        match self.not_a_decoder {
            Some(_) => 3,
            None => u8::from(
                failed
                    || self.ended_early.is_some()
                    || self.remarks.iter().any(|remark| remark.failure)
                    || !self.decoded_something(),
            ),
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
