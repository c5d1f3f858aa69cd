//! First contact: requests for the first files in every view, and the features that the decoder offers.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Mutex;

use crate::protocol::frame::{Answer, Frame, View};
use crate::runner::run::Reply;
use crate::session::asking::{ReplyTo, Session, is_hang, serve_mode_failure};
use crate::session::observation::Response;
use crate::session::{offer::Offer, plan::Repeat, remark::Remark, tally::HangWatch};
use crate::suite::cases::{Case, Expect, Suite, TableSpelling};
use crate::suite::{compare::Expected, dialect::RightDialects, test_case::TestCase};

/// A first file that was requested in one view, and the reply of the decoder.
#[derive(Clone, Debug)]
pub struct FirstFile<C: TestCase = Case> {
    /// Index of the requested case in the suite.
    pub case: usize,
    /// The view in which the file was requested.
    pub view: C::View,
    /// The reply.
    pub reply: ReplyTo<C>,
}

impl<C: TestCase> FirstFile<C> {
    fn is_decoded(&self) -> bool {
        matches!(self.reply.answer, Answer::Decoded(_))
    }

    fn is_unsupported(&self) -> bool {
        matches!(self.reply.answer, Answer::Unsupported)
    }
}

/// A reply to a first file, and the answer of a correct decoder.
pub(super) struct FirstReply<'a> {
    pub(super) case: &'a Case,
    pub(super) view: &'a View,
    pub(super) file: Vec<u8>,
    pub(super) expected: Expected,
    pub(super) reply: &'a Reply,
}

impl FirstReply<'_> {
    pub(super) fn frame(&self) -> Option<&Frame> {
        match &self.reply.answer {
            Answer::Decoded(frame) => Some(frame),
            _ => None,
        }
    }

    pub(super) fn is_right(&self) -> bool {
        (self.frame()).is_some_and(|frame| self.expected.compare(frame).is_none())
    }
}

impl Contact {
    /// Returns the replies to those first files whose correct answers are known.
    pub(super) fn replies<'a>(&'a self, suite: &'a Suite) -> Vec<FirstReply<'a>> {
        let reply = |first: &'a FirstFile| {
            let case = &suite.cases[first.case];
            let built = case.build(TableSpelling::default());
            Some(FirstReply {
                case,
                view: &first.view,
                file: built.file.clone(),
                expected: Expected::new(&built.values, &first.view)?,
                reply: &first.reply,
            })
        };
        self.first.iter().filter_map(reply).collect()
    }
}

/// The result of first contact: facts about a decoder that are known before any case is judged.
#[derive(Clone, Debug)]
pub struct Contact<C: TestCase = Case> {
    /// Replies to the first files.
    pub first: Vec<FirstFile<C>>,
    /// Views and formats that the decoder offers.
    pub offer: Offer<C>,
    /// Spelling in which tables are sent.
    pub table: TableSpelling,
    /// Remarks on the decoder.
    pub remarks: Vec<Remark>,
    /// The reason why the program is not a decoder, if it is not one.
    pub not_a_decoder: Option<String>,
    /// Reason why no case is requested, if something must be fixed first.
    pub end_reason: Option<&'static str>,
}

impl<C: TestCase> Contact<C> {
    /// Returns true if cases can be requested.
    pub(crate) fn is_ready(&self) -> bool {
        self.not_a_decoder.is_none() && self.end_reason.is_none()
    }
}

impl<C: TestCase> Session<'_, C> {
    /// Requests the first files to determine whether the program is a decoder, what it offers, and which table spelling it reads.
    #[must_use]
    pub fn first_contact(&self) -> Contact<C> {
        let first = self.first_files();
        // Report the first file that was not answered in serve mode.
        let trouble = first.iter().find_map(|FirstFile { case, view, reply }| {
            let (case, failure) = (&self.suite.cases[*case], serve_mode_failure(reply)?);
            let says = format!("{} in {view}, {}", case.id(), failure.message);
            Some(Remark::failure(says))
        });
        let mut remarks: Vec<Remark> = trouble.into_iter().collect();
        let mut contact = Contact {
            offer: self.derive_offer(&first, &mut remarks),
            first,
            table: TableSpelling::default(),
            remarks,
            not_a_decoder: None,
            end_reason: None,
        };
        // If no first file could be requested, use the views that the user names.
        if contact.first.is_empty() {
            let is_wanted = |view: &&&str| self.plan.views.iter().any(|wanted| wanted == *view);
            contact.offer.views = C::VIEWS.iter().filter(is_wanted).copied().collect();
        }
        if self.is_over() {
            contact.not_a_decoder = non_decoder_reason(&contact.first);
            return contact;
        }
        // A decoder that supports only tables may refuse all first files because it expects a different spelling of the count.
        let is_answer = |first: &FirstFile<C>| {
            matches!(first.reply.answer, Answer::Decoded(_) | Answer::Rejected)
        };
        let (offer, first) = (&contact.offer, &contact.first);
        let spelling = (first.is_empty() || first.iter().any(is_answer)).then(|| {
            self.table_spelling(offer)
                .or_else(|| self.likely_spelling(offer))
        });
        match spelling.flatten() {
            Some(table) => contact.table = table,
            None => contact.not_a_decoder = non_decoder_reason(&contact.first),
        }
        contact
    }

    /// Requests the first files in all possible views: one after another until a file is decoded, then with all jobs in parallel.
    /// A serving process receives all requests in order. After a timeout, the other views of the same file are requested last.
    fn first_files(&self) -> Vec<FirstFile<C>> {
        let (suite, plan) = (self.suite, self.plan);
        let cases = suite.cases.iter().enumerate();
        let first =
            cases.filter(|&(i, case)| case.is_first() && plan.is_requested(i) && !plan.precomputed);
        let in_views = first.flat_map(|(i, case)| case.views().iter().map(move |view| (i, view)));
        let mut work: Vec<(usize, &C::View)> = in_views.collect();
        work.retain(|(_, view)| plan.allows_view(C::view_name(view)));
        let mut cases: Vec<usize> = work.iter().map(|&(case, _)| case).collect();
        cases.dedup();
        let watch = HangWatch::new(cases);
        let ask = |(case, view): (usize, &C::View), worker| {
            let (_, reply) =
                self.observe(&suite.cases[case], view, TableSpelling::default(), worker);
            watch.record_answer(case, is_hang(&reply), &self.tally);
            let view = view.clone();
            FirstFile { case, view, reply }
        };
        let in_order = plan.repeat == Repeat::FailuresAndSample;
        let mut replies: Vec<FirstFile<C>> = Vec::new();
        let mut left = Vec::new();
        for (case, view) in work {
            let hung = |first: &FirstFile<C>| first.case == case && is_hang(&first.reply);
            let decoded = replies.iter().any(FirstFile::is_decoded);
            if decoded && !in_order || replies.last().is_some_and(hung) {
                left.push((case, view));
                continue;
            }
            let first = ask((case, view), 0);
            let hopeless = matches!(first.reply.answer, Answer::NotStarted(_)) || self.is_over();
            replies.push(first);
            if hopeless {
                return replies;
            }
        }
        let others = Mutex::new(BTreeMap::new());
        self.run_in_parallel(left.len(), |place, worker| {
            let first = ask(left[place], worker);
            let mut others = others.lock().expect("no worker panics");
            others.insert(place, first);
            !self.is_over()
        });
        replies.extend(others.into_inner().expect("no worker panics").into_values());
        replies
    }

    /// Returns the offer of the decoder. A view is offered if the decoder decoded a first file in it. An offered view is missing
    /// for a kind of case if the decoder exited with 69 for all requested files of that kind in that view, but not in every view.
    fn derive_offer(&self, first: &[FirstFile<C>], remarks: &mut Vec<Remark>) -> Offer<C> {
        let (suite, plan) = (self.suite, self.plan);
        let declares = |view: &str| plan.declared_views.iter().any(|declared| declared == view);
        let asked_for = |view: &str| first.iter().any(|first| C::view_name(&first.view) == view);
        let mut offer = Offer {
            declared: plan.declared_kinds.clone(),
            ..Offer::default()
        };
        let is_decoded = first.iter().any(FirstFile::is_decoded);
        // Returns true if a first file in this view (and of this kind, if one is given) was answered with anything but 69.
        let answered = |view: &str, kind: Option<&C::Feature>| {
            first.iter().any(|first| {
                C::view_name(&first.view) == view
                    && kind.is_none_or(|kind| suite.cases[first.case].kind() == *kind)
                    && !first.is_unsupported()
            })
        };
        for &view in C::VIEWS {
            let in_view = |one: &&FirstFile<C>| C::view_name(&one.view) == view;
            let mut in_view = first.iter().filter(in_view);
            // A view in which everything is refused is not offered. If no first file is decoded in any view, every view with an
            // answer other than 69 is offered, so that the run can report the errors.
            let is_offered = match is_decoded {
                true => in_view.any(FirstFile::is_decoded),
                false => !in_view.all(FirstFile::is_unsupported),
            };
            if is_offered {
                offer.views.push(view);
            } else if answered(view, None) {
                remarks.push(Remark::failure(format!(
                    "it decodes none of the first files in view {view}, but decodes them in another view, so {view} is not requested"
                )));
            } else if declares(view) && asked_for(view) {
                remarks.push(Remark::failure(format!(
                    "its capabilities declare view {view}, but it exits with 69 (unsupported) on all of the first files in that view"
                )));
            }
        }
        if self.is_over() {
            return offer;
        }
        let kinds = suite.cases.iter().filter(|case| case.is_first());
        let kinds: BTreeSet<C::Feature> = kinds.map(C::kind).collect();
        for kind in kinds {
            let has = |view: &&str| answered(view, Some(&kind));
            if !offer.views.iter().any(has) {
                let is_of_kind = |one: &FirstFile<C>| suite.cases[one.case].kind() == kind;
                if !C::VIEWS.iter().any(has) && first.iter().any(is_of_kind) {
                    offer.unsupported.push(kind);
                }
                continue;
            }
            for view in offer.views.clone() {
                if has(&view) || self.answers_other_case(view, &kind) {
                    continue;
                }
                if declares(view) && offer.declared.contains(&kind.to_string()) {
                    remarks.push(Remark::failure(format!(
                        "its capabilities declare view {view} and {kind}, but it exits with 69 (unsupported) on files of this kind in that view"
                    )));
                }
                offer.missing_views.push((view, kind.clone()));
            }
        }
        offer
    }

    /// Requests a few other cases of this kind in this view. Returns true if any response is not exit status 69.
    fn answers_other_case(&self, view: &str, kind: &C::Feature) -> bool {
        let is_other =
            |case: &&C| case.expect() == Expect::Decode && !case.is_first() && case.kind() == *kind;
        let others = self.suite.cases.iter().filter(is_other).filter_map(|case| {
            let mut views = case.views().iter();
            Some((case, views.find(|of| C::view_name(of) == view)?))
        });
        others.take(3).any(|(case, view)| {
            let (observation, _) = self.observe(case, view, TableSpelling::default(), 0);
            !matches!(observation.response, Response::Unsupported)
        })
    }

    /// Returns the first table spelling that the decoder reads correctly.
    pub(super) fn table_spelling(&self, offer: &Offer<C>) -> Option<TableSpelling> {
        let cases = self.suite.cases.iter().enumerate();
        let mut asked = cases.filter(|&(i, _)| self.plan.is_requested(i));
        asked.find_map(|(_, case)| {
            let (spelling, view) = (case.spelling()?, offer.chosen_view(case)?);
            let (observation, _) = self.observe(case, view, TableSpelling::default(), 0);
            let right = RightDialects::Regardless(true);
            matches!(observation.response, Response::Image { right: shown, .. } if shown == right)
                .then_some(spelling)
        })
    }

    /// Returns the table spelling in which the decoder reads small tables best, or `None` if the evidence is weak. This is for
    /// decoders that read no `spelling` case correctly.
    pub(super) fn likely_spelling(&self, offer: &Offer<C>) -> Option<TableSpelling> {
        const PROBES: usize = 4;
        if self.plan.precomputed {
            return None;
        }
        let cases = self.suite.cases.iter();
        let is_table = |case: &&C| case.expect() == Expect::Decode && case.has_table();
        let mut probes: Vec<&C> = cases.filter(is_table).collect();
        // The cached key generates each file only once.
        probes.sort_by_cached_key(|case| C::file(&case.make(TableSpelling::default())).len());
        probes.truncate(PROBES);
        let mut scores: Vec<(f64, TableSpelling)> = Vec::new();
        for table in TableSpelling::all() {
            let (mut score, mut silent) = (0.0, 0);
            for case in &probes {
                let view = offer.chosen_view(case);
                let Some(view) = view else { continue };
                let (observation, _) = self.observe(case, view, table, 0);
                if self.is_over() {
                    return None;
                }
                match observation.response {
                    Response::Unsupported | Response::Violation(Answer::Hung(_)) => silent += 1,
                    // A wrong image is better evidence than no image: its values may be wrong for a different reason.
                    Response::Image { difference, .. } => {
                        score += 1.0 + difference.map_or(1.0, |of| C::similarity(&of));
                    }
                    _ => {}
                }
            }
            if silent == probes.len() {
                return None;
            }
            scores.push((score, table));
        }
        let &(ordinary, _) = scores.first()?;
        let best = scores.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
        (best.0 > ordinary + PROBES as f64 / 4.0).then_some(best.1)
    }
}

/// Returns the reason why the program that sent these replies is not a decoder or writer, if it is not one.
fn non_decoder_reason<C: TestCase>(first: &[FirstFile<C>]) -> Option<String> {
    let decoded = first.iter().any(FirstFile::is_decoded);
    let is_refused = |first: &&FirstFile<C>| matches!(first.reply.answer, Answer::Rejected);
    let refused = first.iter().filter(is_refused).count();
    let is_violation = |first: &&FirstFile<C>| first.reply.answer.violation().is_some();
    let FirstFile { reply, .. } = first.iter().find(is_violation).or(first.first())?;
    let why = match (&reply.answer, reply.exit) {
        (Answer::NotStarted(why), _) => format!("it cannot be started: {why}"),
        (_, Some(status @ (126 | 127))) if !decoded => {
            format!("its command cannot be run: exit status {status}")
        }
        _ if decoded => return None,
        (Answer::Unsupported, _) if refused == 0 => {
            "it exits with 69 (unsupported) on all of the first requests".to_owned()
        }
        (Answer::Rejected | Answer::Unsupported, _) => format!(
            "it produces no output for the first requests, and refuses {refused} of {} (exit status 65)",
            first.len()
        ),
        (answer, _) => format!(
            "none of its first responses is well-formed; the first: {}",
            answer.describe()
        ),
    };
    Some(match reply.stderr.as_str() {
        "" => why,
        stderr => format!("{why}\nits standard error begins:\n{stderr}"),
    })
}
