//! First contact: requests for the first files in every view, and the features that the decoder offers.

use std::collections::BTreeSet;
use std::sync::Mutex;

use crate::session::asking::{Session, serve_mode_failure};
use crate::session::{plan::Repeat, remark::Remark, tally::TimeoutWatch};
use ptm_suite::cases::{Case, Expect, Suite, TableSpelling};
use ptm_suite::protocol::frame::{Answer, Frame, View};
use ptm_suite::protocol::request::{AttemptKind, Reply};
use ptm_suite::verdicts::observation::Response;
use ptm_suite::verdicts::offer::Offer;
use ptm_suite::{compare::Expected, dialect::RightDialects};
use ptm_suite::{features::Feature, test_case::TestCase};

/// A first file of a suite of cases.
type FirstFileOf<C> = FirstFile<<C as TestCase>::View, <C as TestCase>::Output>;

/// A first file that was requested in one view, and the reply of the decoder.
#[derive(Clone, Debug)]
pub struct FirstFile<V = View, T = Frame> {
    /// Index of the requested case in the suite.
    pub case: usize,
    /// The view in which the file was requested.
    pub view: V,
    /// The reply.
    pub reply: Reply<T>,
    /// The kind of attempt that resulted in this reply.
    pub attempt: AttemptKind,
}

impl<V, T> FirstFile<V, T> {
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

/// First contact with a decoder of a suite of cases.
pub type ContactOf<C> = Contact<<C as TestCase>::View, <C as TestCase>::Output>;

/// The result of first contact: facts about a decoder that are known before any case is judged.
#[derive(Clone, Debug)]
pub struct Contact<V = View, T = Frame, F = Feature> {
    /// Replies to the first files.
    pub first: Vec<FirstFile<V, T>>,
    /// Views and formats that the decoder offers.
    pub offer: Offer<F>,
    /// Spelling in which tables are sent.
    pub table: TableSpelling,
    /// Remarks on the decoder.
    pub remarks: Vec<Remark>,
    /// The reason why the program is not a decoder, if it is not one.
    pub not_a_decoder: Option<String>,
    /// Reason why no case is requested, if something must be fixed first.
    pub end_reason: Option<String>,
}

impl<V, T, F> Contact<V, T, F> {
    /// Returns true if cases can be requested.
    pub(crate) fn is_ready(&self) -> bool {
        self.not_a_decoder.is_none() && self.end_reason.is_none()
    }
}

impl<C: TestCase> Session<'_, C> {
    /// Requests the first files to determine whether the program is a decoder, what it offers, and which table spelling it reads.
    #[must_use]
    pub fn first_contact(&self) -> ContactOf<C> {
        let first = self.first_files();
        // Report the first file that was not answered in serve mode.
        let trouble = first.iter().find_map(|first| {
            let (case, failure) = (
                &self.suite.cases[first.case],
                serve_mode_failure(&first.reply)?,
            );
            let says = format!("{} in {}, {}", case.id(), first.view, failure.message);
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
            let is_wanted =
                |view: &&&str| self.plan.views.iter().any(|wanted| wanted.name() == **view);
            contact.offer.views = C::VIEWS.iter().filter(is_wanted).copied().collect();
        }
        if self.is_over() {
            contact.not_a_decoder = non_decoder_reason(&contact.first);
            return contact;
        }
        // A decoder that supports only tables may refuse all first files because it expects a different spelling of the count.
        let is_answer = |first: &FirstFileOf<C>| {
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
    /// A serving process receives all requests in order. Until the decoder has answered once, it may have to warm up, so requests
    /// have the higher time limit. If a file exceeds the limit, its other views are requested last.
    ///
    /// After three consecutive files that exceed the limit, one of them after the other is requested alone until one is answered.
    /// If none is, the run ends. At the end, all requests that exceeded the usual limit are repeated alone.
    fn first_files(&self) -> Vec<FirstFileOf<C>> {
        let requests = self.first_requests();
        let mut cases: Vec<usize> = requests.iter().map(|&(case, _)| case).collect();
        cases.dedup();
        let mut watch = TimeoutWatch::new(cases.clone());
        let in_order = self.plan.repeat == Repeat::FailuresAndSample;
        let mut replies: Vec<FirstFileOf<C>> = Vec::new();
        let mut left = Vec::new();
        for (case, view) in requests {
            let is_slow = |first: &FirstFileOf<C>| first.case == case && first.reply.is_timeout();
            let decoded = replies.iter().any(FirstFile::is_decoded);
            if decoded && !in_order || replies.last().is_some_and(is_slow) {
                left.push((case, view));
                continue;
            }
            let attempt = match replies.iter().all(|first| first.reply.is_timeout()) {
                true => AttemptKind::Alone,
                false => AttemptKind::Usual,
            };
            let first = self.request_first_file(case, view, 0, attempt);
            watch.record(case, first.reply.is_timeout());
            let is_hopeless = matches!(first.reply.answer, Answer::NotStarted(_));
            replies.push(first);
            if is_hopeless || self.is_interrupted() {
                return replies;
            }
            if let Some(slow) = watch.consecutive() {
                if !self.any_is_answered(slow, &mut replies.iter_mut().collect::<Vec<_>>()) {
                    return replies;
                }
                let last = slow[slow.len() - 1];
                cases.retain(|&case| case > last);
                watch = TimeoutWatch::new(cases.clone());
            }
        }
        self.request_other_views(&left, &watch, &mut replies);
        replies
    }

    /// Returns the first files and the views in which they are requested.
    fn first_requests(&self) -> Vec<(usize, &C::View)> {
        let cases = self.suite.cases.iter().enumerate();
        let is_requested = |i| self.plan.is_requested(i) && !self.plan.precomputed;
        let first = cases.filter(|&(i, case)| case.is_first() && is_requested(i));
        first
            .flat_map(|(i, case)| case.views().iter().map(move |view| (i, view)))
            .filter(|(_, view)| self.plan.allows_view(C::view_name(view)))
            .collect()
    }

    /// Sends the remaining requests in parallel, and repeats all that exceeded the usual time limit.
    fn request_other_views(
        &self,
        requests: &[(usize, &C::View)],
        watch: &TimeoutWatch,
        replies: &mut Vec<FirstFileOf<C>>,
    ) {
        let mut others: Vec<Option<FirstFileOf<C>>> = requests.iter().map(|_| None).collect();
        self.request_first_files(requests, &mut others, Some(watch));
        if let Some(slow) = watch.consecutive() {
            let known = replies.iter_mut().chain(others.iter_mut().flatten());
            if self.any_is_answered(slow, &mut known.collect::<Vec<_>>()) {
                self.request_first_files(requests, &mut others, None);
            }
        }
        replies.extend(others.into_iter().flatten());
        if self.is_over() {
            return;
        }
        let open = replies.iter().filter(|first| first.reply.is_timeout());
        let open: BTreeSet<usize> = open.map(|first| first.case).collect();
        for case in open {
            self.repeat_first_file(case, &mut replies.iter_mut().collect::<Vec<_>>());
        }
    }

    fn request_first_file(
        &self,
        case: usize,
        view: &C::View,
        worker: usize,
        attempt: AttemptKind,
    ) -> FirstFileOf<C> {
        let (table, view) = (TableSpelling::default(), view.clone());
        let (_, reply) = self.observe(&self.suite.cases[case], &view, table, worker, attempt);
        FirstFile {
            case,
            view,
            reply,
            attempt,
        }
    }

    /// Requests first files in parallel, except those that already have a reply, until `watch` finds consecutive files that exceed
    /// the time limit.
    fn request_first_files(
        &self,
        requests: &[(usize, &C::View)],
        replies: &mut [Option<FirstFileOf<C>>],
        watch: Option<&TimeoutWatch>,
    ) {
        let replies = Mutex::new(replies);
        self.plan.run_in_parallel(requests.len(), |place, worker| {
            let lock = || replies.lock().expect("no worker panics");
            let (case, view) = requests[place];
            if lock()[place].is_some() {
                return true;
            }
            if self.is_interrupted() || watch.is_some_and(|watch| watch.is_after(case)) {
                return false;
            }
            let first = self.request_first_file(case, view, worker, AttemptKind::Usual);
            if let Some(watch) = watch {
                watch.record(case, first.reply.is_timeout());
            }
            lock()[place] = Some(first);
            true
        });
    }

    /// Repeats requests for these files alone, one file after the other, until one is answered. If none is, the run ends.
    fn any_is_answered(&self, slow: &[usize], replies: &mut [&mut FirstFileOf<C>]) -> bool {
        let mut files = slow.iter();
        let is_answered = files.any(|&case| self.repeat_first_file(case, replies) == Some(true));
        if !is_answered && !self.is_interrupted() {
            let of_file = replies.iter().filter(|first| slow.contains(&first.case));
            let limits = of_file.filter_map(|first| match first.reply.answer {
                Answer::TimedOut(limit) => Some(limit),
                _ => None,
            });
            let limit = limits.min().expect("the files exceeded a time limit");
            let _ = self.tally.exceeded_limit.set(limit);
        }
        is_answered
    }

    /// Repeats the requests for a file that exceeded the usual time limit, each alone and with a higher limit. Returns true if all
    /// were answered, false after the first that exceeds this limit, too, and `None` if no request may be repeated.
    fn repeat_first_file(&self, case: usize, replies: &mut [&mut FirstFileOf<C>]) -> Option<bool> {
        for first in replies {
            if first.case != case || !first.reply.is_timeout() {
                continue;
            }
            if first.attempt == AttemptKind::Usual {
                let (file, table) = (&self.suite.cases[case], TableSpelling::default());
                (_, first.reply) = self.observe_alone(file, &first.view, table)?;
                first.attempt = AttemptKind::Alone;
            }
            if first.reply.is_timeout() {
                return Some(false);
            }
        }
        Some(true)
    }

    /// Returns the offer of the decoder. A view is offered if the decoder decoded a first file in it. An offered view is missing
    /// for a kind of case if the decoder exited with 69 for all requested files of that kind in that view, but not in every view.
    fn derive_offer(&self, first: &[FirstFileOf<C>], remarks: &mut Vec<Remark>) -> Offer {
        let (suite, plan) = (self.suite, self.plan);
        let declares = |view: &str| {
            plan.declared_views
                .iter()
                .any(|declared| declared.name() == view)
        };
        let asked_for = |view: &str| first.iter().any(|first| C::view_name(&first.view) == view);
        let mut offer = Offer {
            declared: plan.declared_kinds.clone(),
            ..Offer::default()
        };
        let is_decoded = first.iter().any(FirstFile::is_decoded);
        // Returns true if a first file in this view (and of this kind, if one is given) was answered with anything but 69.
        let answered = |view: &str, kind: Option<&Feature>| {
            first.iter().any(|first| {
                C::view_name(&first.view) == view
                    && kind.is_none_or(|kind| suite.cases[first.case].kind() == *kind)
                    && !first.is_unsupported()
            })
        };
        for &view in C::VIEWS {
            let in_view = |one: &&FirstFileOf<C>| C::view_name(&one.view) == view;
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
        let kinds: BTreeSet<Feature> = kinds.map(C::kind).collect();
        for kind in kinds {
            let has = |view: &&str| answered(view, Some(&kind));
            if !offer.views.iter().any(has) {
                let is_of_kind = |one: &FirstFileOf<C>| suite.cases[one.case].kind() == kind;
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
    fn answers_other_case(&self, view: &str, kind: &Feature) -> bool {
        let is_other =
            |case: &&C| case.expect() == Expect::Decode && !case.is_first() && case.kind() == *kind;
        let others = self.suite.cases.iter().filter(is_other).filter_map(|case| {
            let mut views = case.views().iter();
            Some((case, views.find(|of| C::view_name(of) == view)?))
        });
        others.take(3).any(|(case, view)| {
            let observation = self.observe_patiently(case, view, TableSpelling::default());
            !matches!(observation.response, Response::Unsupported)
        })
    }

    /// Returns the first table spelling that the decoder reads correctly.
    pub(super) fn table_spelling(&self, offer: &Offer) -> Option<TableSpelling> {
        let cases = self.suite.cases.iter().enumerate();
        let mut asked = cases.filter(|&(i, _)| self.plan.is_requested(i));
        asked.find_map(|(_, case)| {
            let (spelling, view) = (case.spelling()?, offer.chosen_view(case)?);
            let observation = self.observe_patiently(case, view, TableSpelling::default());
            let right = RightDialects::Regardless(true);
            matches!(observation.response, Response::Image { right: shown, .. } if shown == right)
                .then_some(spelling)
        })
    }

    /// Returns the table spelling in which the decoder reads small tables best, or `None` if the evidence is weak. This is for
    /// decoders that read no `spelling` case correctly.
    pub(super) fn likely_spelling(&self, offer: &Offer) -> Option<TableSpelling> {
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
            for &case in &probes {
                let view = offer.chosen_view(case);
                let Some(view) = view else { continue };
                let observation = self.observe_patiently(case, view, table);
                if self.is_over() {
                    return None;
                }
                match observation.response {
                    Response::Unsupported | Response::Violation(Answer::TimedOut(_)) => silent += 1,
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
pub(super) fn non_decoder_reason<V, T>(first: &[FirstFile<V, T>]) -> Option<String> {
    let decoded = first.iter().any(FirstFile::is_decoded);
    let is_refused = |first: &&FirstFile<V, T>| matches!(first.reply.answer, Answer::Rejected);
    let refused = first.iter().filter(is_refused).count();
    let is_violation = |first: &&FirstFile<V, T>| first.reply.answer.violation().is_some();
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
        (Answer::Rejected | Answer::Unsupported, _) if refused == first.len() => {
            format!("it refuses all of the {refused} first files (exit status 65)")
        }
        (Answer::Rejected | Answer::Unsupported, _) => format!(
            "it decodes none of the {} first files: it refuses {refused} (exit status 65), and exits with 69 (unsupported) on the others",
            first.len()
        ),
        (Answer::TimedOut(limit), _) => format!("it {limit} and decodes none of the first files"),
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
