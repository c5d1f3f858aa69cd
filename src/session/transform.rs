//! First files that are all wrong in the same way: turned over, channels exchanged, scaled, under a curve.
//!
//! Such a mistake fails hundreds of cases but is a single mistake. It is reported once, and undone in every image before
//! comparison, so that other mistakes become visible. Undoing it must correct nearly all first files of a view, within the
//! default tolerances, and none of them may be right without it.

use std::sync::Arc;

use crate::protocol::frame::{Frame, ViewKind};
use crate::session::asking::{Undo, Undoing};
use crate::session::contact::{Contact, FirstReply};
use crate::session::curve;
use crate::session::probe::{Arrangement, ProbeFault, join_texts};
use crate::session::remark::Remark;
use crate::suite::cases::{Case, Suite};

/// A change of all images of a view.
pub struct CommonTransform {
    /// The function that undoes it in every image of the view before comparison.
    pub undo: Undo<Case>,
    /// Its effect, and the number of affected first files.
    says: String,
    /// The suggested fix.
    next: String,
}

/// A reply to a first file, and the frame in it.
type FirstImage<'a> = (&'a FirstReply<'a>, &'a Frame);

fn is_explained_by(undo: &Undo<Case>, (reply, frame): &FirstImage) -> bool {
    let undone = (undo.undo)(frame, Some(&reply.expected.frame()));
    reply.expected.compare(&undone).is_none()
}

/// Returns the changes that the images of all first files have in common, view by view, if none of them is right and one change
/// explains them.
#[must_use]
pub fn common(suite: &Suite, contact: &Contact) -> Vec<CommonTransform> {
    let replies = contact.replies(suite);
    let decoded = |reply| Some((reply, FirstReply::frame(reply)?));
    let decoded: Vec<FirstImage> = replies.iter().filter_map(decoded).collect();
    let of_view = |view| {
        let mut pictures = decoded.clone();
        pictures.retain(|(reply, _)| reply.view.kind() == view);
        in_common(view, &pictures)
    };
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
            "{}: {says}; all cases are judged after undoing this\n→ {next}",
            views.join(", ")
        ))
    };
    said.into_iter().map(words).collect()
}

fn in_common(view: ViewKind, pictures: &[FirstImage]) -> Option<CommonTransform> {
    let (right, wrong): (Vec<&FirstImage>, Vec<&FirstImage>) =
        pictures.iter().partition(|(reply, _)| reply.is_right());
    // It must explain nearly all wrong images; one image may match a mistake by chance.
    let enough = |count: usize| count >= 2 && 4 * count >= 3 * wrong.len();
    if !enough(wrong.len()) {
        return None;
    }
    let explained = |undo: &Undo<Case>| {
        let is_explained = |picture: &&&FirstImage| is_explained_by(undo, picture);
        let (explained, open): (Vec<&FirstImage>, Vec<&FirstImage>) =
            wrong.iter().partition(is_explained);
        let format = |picture: &FirstImage| picture.0.case.format();
        // A format is explained in all sizes or in none: a change of small images also applies to larger ones.
        let is_whole =
            |picture: &&FirstImage| open.iter().all(|other| format(other) != format(picture));
        // A change of one format out of several is a mistake about that format.
        let is_common = || {
            let of_another = |picture: &&FirstImage| format(picture) != format(explained[0]);
            right.is_empty() || explained.iter().any(of_another)
        };
        // A right image must look the same with and without it.
        let is_said = enough(explained.len())
            && is_common()
            && explained.iter().all(is_whole)
            && right.iter().all(|picture| is_explained_by(undo, picture));
        is_said.then_some(right.len() + explained.len())
    };
    let mut changes = candidates(view, pictures).into_iter();
    let (count, change) = changes.find_map(|of| Some((explained(&of.undo)?, of)))?;
    let (says, all) = (change.says, pictures.len());
    let says = match count == all {
        true => format!("{says}, in all first files"),
        false => format!("{says}, in {count} of {all} first files"),
    };
    Some(CommonTransform { says, ..change })
}

/// Returns the possible changes of all images, those with the fewest mistakes first.
fn candidates(view: ViewKind, pictures: &[FirstImage]) -> Vec<CommonTransform> {
    let change = |(says, next): ProbeFault, undo: Arc<Undoing<Frame>>| {
        let view = view.name();
        CommonTransform {
            undo: Undo { view, undo },
            says,
            next,
        }
    };
    let mut arrangements: Vec<Arrangement> = Arrangement::all().skip(1).collect();
    arrangements.sort_by_key(|arrangement| arrangement.mistakes().len());
    let arrangements = arrangements.into_iter().map(|arrangement| {
        let mistakes = join_texts(arrangement.mistakes(), "\n  ");
        change(mistakes, Arc::new(move |frame, _| arrangement.undo(frame)))
    });
    let pairs = pictures.iter();
    let pairs: Vec<_> = pairs.map(|&(of, frame)| (&of.expected, frame)).collect();
    let curves = curve::candidates(view, &pairs).into_iter();
    let curves = curves.map(|(fault, curve)| {
        let undo = Arc::new(move |frame: &Frame, right: Option<&Frame>| curve.undo(frame, right));
        change(fault, undo)
    });
    arrangements.chain(curves).collect()
}
