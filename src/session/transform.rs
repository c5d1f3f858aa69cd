//! First files that are all wrong in one and the same way: turned over, channels exchanged, scaled, under a curve.
//!
//! Such a mistake fails hundreds of cases and is one mistake. It is said once, and undone in every picture before that is
//! compared, so that the other mistakes show. What is undone has to put nearly all first files of a view right, by the
//! ordinary tolerances, and none of them may be right as it is.

use std::sync::Arc;

use crate::protocol::frame::{Answer, Frame, Samples, ViewKind};
use crate::ptm::Format;
use crate::session::asking::Undo;
use crate::session::contact::Contact;
use crate::session::curve::{Curve, factor};
use crate::session::probe::Arrangement;
use crate::session::remark::Remark;
use crate::suite::cases::{Case, Suite};
use crate::suite::compare::Expected;
use crate::suite::test_case::TestCase;

/// A change of all pictures of a view.
pub struct CommonTransform {
    /// What is to be done to every picture of the view before it is compared.
    pub undo: Undo<Case>,
    /// What it does, and of how many of how many first files.
    says: String,
    /// What to do about it.
    next: String,
}

/// A first file: what is expected, and what came.
struct Picture<'a> {
    format: Format,
    expected: Expected,
    frame: &'a Frame,
    /// What the reference shows.
    right: Option<Frame>,
}

impl Picture<'_> {
    fn is_right(&self) -> bool {
        self.expected.compare(self.frame).is_none()
    }

    fn is_put_right_by(&self, undo: impl Fn(&Frame, Option<&Frame>) -> Frame) -> bool {
        let undone = undo(self.frame, self.right.as_ref());
        self.expected.compare(&undone).is_none()
    }
}

/// What the pictures of all first files have in common, view by view, where none of them is right and one change explains
/// them.
#[must_use]
pub fn common(suite: &Suite, contact: &Contact) -> Vec<CommonTransform> {
    let of_view = |view| in_common(view, &pictures(suite, contact, view));
    ViewKind::ALL.into_iter().filter_map(of_view).collect()
}

/// The same in words, what is the same in several views once.
#[must_use]
pub fn in_words(transforms: &[CommonTransform]) -> Vec<Remark> {
    let mut said: Vec<(Vec<&str>, &CommonTransform)> = Vec::new();
    for transform in transforms {
        let same = |(_, of): &&mut (Vec<&str>, &CommonTransform)| of.says == transform.says;
        match said.iter_mut().find(same) {
            Some((views, _)) => views.push(transform.undo.view),
            None => said.push((vec![transform.undo.view], transform)),
        }
    }
    let words = |(views, transform): (Vec<&str>, &CommonTransform)| {
        let CommonTransform { says, next, .. } = transform;
        Remark::failure(format!(
            "{}: {says}; all cases are judged with this undone\n→ {next}",
            views.join(", ")
        ))
    };
    said.into_iter().map(words).collect()
}

fn pictures<'a>(suite: &Suite, contact: &'a Contact, view: ViewKind) -> Vec<Picture<'a>> {
    let of_view = contact
        .first
        .iter()
        .filter(|first| first.view.kind() == view);
    let decoded = of_view.filter_map(|first| {
        let Answer::Decoded(frame) = &first.reply.answer else {
            return None;
        };
        let case = &suite.cases[first.case];
        let built = case.build(contact.table);
        Some(Picture {
            format: case.format(),
            expected: Expected::of(&built.values, &first.view)?,
            frame,
            right: case.expected_output(&first.view),
        })
    });
    decoded.collect()
}

fn in_common(view: ViewKind, pictures: &[Picture]) -> Option<CommonTransform> {
    let (right, wrong): (Vec<&Picture>, Vec<&Picture>) =
        pictures.iter().partition(|picture| picture.is_right());
    // Of the wrong ones it must explain nearly all; one picture may be like a mistake by chance.
    let enough = |count: usize| count >= 2 && 4 * count >= 3 * wrong.len();
    if !enough(wrong.len()) {
        return None;
    }
    // What is right must look the same either way.
    let explained = |undo: &Undo<Case>| {
        let explains =
            |picture: &&&Picture| picture.is_put_right_by(|frame, right| (undo.undo)(frame, right));
        let (explained, open): (Vec<&Picture>, Vec<&Picture>) = wrong
            .iter()
            .copied()
            .partition(|picture| explains(&picture));
        // Of a format it explains all sizes or none: what small pictures undergo, larger ones do too.
        let is_whole = |picture: &&Picture| open.iter().all(|other| other.format != picture.format);
        // What one format of several undergoes is a mistake about that format.
        let is_common = || {
            let of_another = |picture: &&Picture| picture.format != explained[0].format;
            right.is_empty() || explained.iter().any(of_another)
        };
        let is_said = enough(explained.len())
            && is_common()
            && explained.iter().all(is_whole)
            && right.iter().all(|picture| explains(&picture));
        is_said.then_some(right.len() + explained.len())
    };
    let (count, says, next, undo) = candidates(view, pictures)
        .into_iter()
        .find_map(|(says, next, undo)| Some((explained(&undo)?, says, next, undo)))?;
    let says = match count == pictures.len() {
        true => format!("{says}, in all first files"),
        false => format!("{says}, in {count} of {} first files", pictures.len()),
    };
    Some(CommonTransform { undo, says, next })
}

/// Changes that all pictures may have undergone: what to say, what to do, and how to undo each.
fn candidates(view: ViewKind, pictures: &[Picture]) -> Vec<(String, String, Undo<Case>)> {
    let arrangements = Arrangement::all().into_iter().skip(1);
    let mut all: Vec<_> = arrangements
        .map(|arrangement| {
            let mistakes = arrangement.mistakes();
            let joined = |words: Vec<&str>, between| words.join(between);
            let says = mistakes.iter().map(|mistake| &*mistake.says).collect();
            let next = mistakes.iter().map(|mistake| mistake.next).collect();
            let undo = Undo {
                view: view.name(),
                undo: Arc::new(move |frame: &Frame, _| arrangement.undo(frame)),
            };
            (joined(says, "; and "), joined(next, "\n  "), undo)
        })
        .collect();
    // The fewest mistakes first.
    all.sort_by_key(|(says, ..)| says.matches("; and ").count());
    let pairs: Vec<(&Expected, &Frame)> = pictures
        .iter()
        .map(|picture| (&picture.expected, picture.frame))
        .collect();
    if let Some((factor, says)) = factor(&pairs) {
        let undo = Undo {
            view: view.name(),
            undo: Arc::new(move |frame: &Frame, _| divided(frame, factor)),
        };
        all.push((says, "send the values as they are".to_owned(), undo));
    }
    for curve in Curve::candidates(view, &pairs) {
        let (says, next) = (curve.says.clone(), curve.next.to_owned());
        let undo = Undo {
            view: view.name(),
            undo: Arc::new(move |frame: &Frame, right| curve.undo(frame, right)),
        };
        all.push((says, next, undo));
    }
    all
}

fn divided(frame: &Frame, factor: f64) -> Frame {
    let samples = match &frame.samples {
        Samples::U8(bytes) => Samples::U8(bytes.clone()),
        Samples::F32(values) => {
            let divided = values
                .iter()
                .map(|&value| (f64::from(value) / factor) as f32);
            Samples::F32(divided.collect())
        }
    };
    Frame {
        samples,
        ..frame.clone()
    }
}
