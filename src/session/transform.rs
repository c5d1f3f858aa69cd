//! First files that are all wrong in the same way: turned over, channels exchanged, scaled, under a curve.
//!
//! Such a mistake fails hundreds of cases but is a single mistake. It is reported once, and undone in every image before
//! comparison, so that other mistakes become visible. Undoing it must correct nearly all first files of a view, within the
//! default tolerances, and none of them may be right without it.

use std::sync::Arc;

use crate::protocol::frame::{Answer, Frame, ViewKind};
use crate::ptm::Format;
use crate::session::asking::{Undo, Undoing};
use crate::session::contact::{Contact, First};
use crate::session::curve;
use crate::session::probe::{Arrangement, ProbeFault, joined};
use crate::session::remark::Remark;
use crate::suite::cases::{Case, Suite};
use crate::suite::compare::Expected;
use crate::suite::test_case::TestCase;

/// A change of all images of a view.
pub struct CommonTransform {
    /// The function that undoes it in every image of the view before comparison.
    pub undo: Undo<Case>,
    /// Its effect, and the number of affected first files.
    says: String,
    /// The suggested fix.
    next: String,
}

/// A first file: the expected image and the received one.
struct FirstImage<'a> {
    format: Format,
    expected: Expected,
    frame: &'a Frame,
    /// The image of the reference.
    right: Option<Frame>,
}

impl FirstImage<'_> {
    fn is_right(&self) -> bool {
        self.expected.compare(self.frame).is_none()
    }

    fn is_explained_by(&self, undo: &Undo<Case>) -> bool {
        let undone = (undo.undo)(self.frame, self.right.as_ref());
        self.expected.compare(&undone).is_none()
    }
}

/// Returns the changes that the images of all first files have in common, view by view, if none of them is right and one change
/// explains them.
#[must_use]
pub fn common(suite: &Suite, contact: &Contact) -> Vec<CommonTransform> {
    let of_view = |view| in_common(view, &pictures(suite, contact, view));
    ViewKind::ALL.into_iter().filter_map(of_view).collect()
}

/// Describes the changes, and those of several views only once.
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

fn pictures<'a>(suite: &Suite, contact: &'a Contact, view: ViewKind) -> Vec<FirstImage<'a>> {
    let decoded = |first: &'a First| {
        let Answer::Decoded(frame) = &first.reply.answer else {
            return None;
        };
        let case = &suite.cases[first.case];
        let built = case.build(contact.table);
        Some(FirstImage {
            format: case.format(),
            expected: Expected::new(&built.values, &first.view)?,
            frame,
            right: case.expected_output(&first.view),
        })
    };
    let first = contact.first.iter();
    let of_view = first.filter(|first| first.view.kind() == view);
    of_view.filter_map(decoded).collect()
}

fn in_common(view: ViewKind, pictures: &[FirstImage]) -> Option<CommonTransform> {
    let (right, wrong): (Vec<&FirstImage>, Vec<&FirstImage>) =
        pictures.iter().partition(|picture| picture.is_right());
    // It must explain nearly all wrong images; one image may match a mistake by chance.
    let enough = |count: usize| count >= 2 && 4 * count >= 3 * wrong.len();
    if !enough(wrong.len()) {
        return None;
    }
    let explained = |undo: &Undo<Case>| {
        let (explained, open): (Vec<&FirstImage>, Vec<&FirstImage>) = wrong
            .iter()
            .partition(|picture| picture.is_explained_by(undo));
        // A format is explained in all sizes or in none: a change of small images also applies to larger ones.
        let is_whole =
            |picture: &&FirstImage| open.iter().all(|other| other.format != picture.format);
        // A change of one format out of several is a mistake about that format.
        let is_common = || {
            let of_another = |picture: &&FirstImage| picture.format != explained[0].format;
            right.is_empty() || explained.iter().any(of_another)
        };
        // A right image must look the same with and without it.
        let is_said = enough(explained.len())
            && is_common()
            && explained.iter().all(is_whole)
            && right.iter().all(|picture| picture.is_explained_by(undo));
        is_said.then_some(right.len() + explained.len())
    };
    let (count, change) = candidates(view, pictures)
        .into_iter()
        .find_map(|change| Some((explained(&change.undo)?, change)))?;
    let (says, all) = (change.says, pictures.len());
    let says = match count == all {
        true => format!("{says}, in all first files"),
        false => format!("{says}, in {count} of {all} first files"),
    };
    Some(CommonTransform { says, ..change })
}

/// Returns the possible changes of all images, those with the fewest mistakes first.
fn candidates(view: ViewKind, pictures: &[FirstImage]) -> Vec<CommonTransform> {
    let change = |(says, next): ProbeFault, undo: Arc<Undoing<Frame>>| CommonTransform {
        undo: Undo {
            view: view.name(),
            undo,
        },
        says,
        next,
    };
    let mut arrangements: Vec<Arrangement> = Arrangement::all().skip(1).collect();
    arrangements.sort_by_key(|arrangement| arrangement.mistakes().len());
    let arrangements = arrangements.into_iter().map(|arrangement| {
        let mistakes = joined(arrangement.mistakes(), "\n  ");
        change(mistakes, Arc::new(move |frame, _| arrangement.undo(frame)))
    });
    let pairs = pictures.iter();
    let pairs: Vec<_> = pairs.map(|one| (&one.expected, one.frame)).collect();
    let curves = curve::candidates(view, &pairs).into_iter();
    let curves = curves.map(|(fault, curve)| {
        change(
            fault,
            Arc::new(move |frame, right| curve.undo(frame, right)),
        )
    });
    arrangements.chain(curves).collect()
}
