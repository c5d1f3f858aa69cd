//! Mistakes that change the images of nearly all first files in the same way: flipped images, swapped channels, a factor, or a
//! tone curve.
//!
//! A common transform makes hundreds of cases fail, but it is a single mistake. It is reported once, and undone in every image
//! before comparison, so that other mistakes become visible. Undoing a transform must correct nearly all wrong images of first
//! files in a view, within the default tolerances, and leave the other images correct.

use std::sync::Arc;

use crate::session::asking::{UndoFn, UndoneTransform};
use crate::session::contact::{Contact, FirstReply};
use crate::session::curve;
use crate::session::probe::{Arrangement, ProbeFault, join_texts};
use crate::session::remark::Remark;
use ptm_suite::cases::{Case, Suite};
use ptm_suite::protocol::frame::{Frame, ViewKind};

/// A change that affects all images of a view.
pub struct CommonTransform {
    /// The view, and the function that undoes the change in all images of the view before comparison.
    pub undo: UndoneTransform<Case>,
    /// The effect of the change, and the number of affected first files.
    effect: String,
    /// The suggested fix.
    next: String,
}

/// A reply to a first file, and the frame in it.
type FirstImage<'a> = (&'a FirstReply<'a>, &'a Frame);

fn is_explained_by(undo: &UndoneTransform<Case>, (reply, frame): &FirstImage) -> bool {
    let undone = (undo.undo)(frame, Some(&reply.expected.frame()));
    reply.expected.compare(&undone).is_none()
}

/// Returns, for each view, the change that explains nearly all wrong images of the first files, if there is one.
pub(crate) fn common_transforms(suite: &Suite, contact: &Contact) -> Vec<CommonTransform> {
    let replies = contact.replies(suite);
    let decoded = |reply| Some((reply, FirstReply::frame(reply)?));
    let decoded: Vec<FirstImage> = replies.iter().filter_map(decoded).collect();
    let of_view = |view| {
        let mut images = decoded.clone();
        images.retain(|(reply, _)| reply.view.kind() == view);
        common_transform(view, &images)
    };
    ViewKind::ALL.into_iter().filter_map(of_view).collect()
}

/// Returns a remark for each change. A change that affects several views is described only once.
#[must_use]
pub fn remarks(transforms: &[CommonTransform]) -> Vec<Remark> {
    let mut groups: Vec<(Vec<&str>, &CommonTransform)> = Vec::new();
    for transform in transforms {
        let same = |(_, of): &&mut (Vec<&str>, &CommonTransform)| of.effect == transform.effect;
        match groups.iter_mut().find(same) {
            Some((views, _)) => views.push(transform.undo.view),
            None => groups.push((vec![transform.undo.view], transform)),
        }
    }
    let remark = |(views, transform): (Vec<&str>, &CommonTransform)| {
        let (says, next) = (&transform.effect, &transform.next);
        Remark::failure(format!(
            "{}: {says}; all cases are judged after undoing this\n→ {next}",
            views.join(", ")
        ))
    };
    groups.into_iter().map(remark).collect()
}

fn common_transform(view: ViewKind, images: &[FirstImage]) -> Option<CommonTransform> {
    let (right, wrong): (Vec<&FirstImage>, Vec<&FirstImage>) =
        images.iter().partition(|(reply, _)| reply.is_right());
    // A change must explain nearly all wrong images; one image may match a mistake by chance.
    let enough = |count: usize| count >= 2 && 4 * count >= 3 * wrong.len();
    if !enough(wrong.len()) {
        return None;
    }
    let explained = |undo: &UndoneTransform<Case>| {
        let is_explained = |image: &&&FirstImage| is_explained_by(undo, image);
        let (explained, open): (Vec<&FirstImage>, Vec<&FirstImage>) =
            wrong.iter().partition(is_explained);
        let format = |image: &FirstImage| image.0.case.format();
        // A format is explained in all sizes or in none: a change of small images also applies to larger ones.
        let is_whole =
            |image: &&FirstImage| open.iter().all(|other| format(other) != format(image));
        // A change of one format out of several is a mistake about that format.
        let is_common = || {
            let of_another = |image: &&FirstImage| format(image) != format(explained[0]);
            right.is_empty() || explained.iter().any(of_another)
        };
        // A correct image must look the same with and without the change.
        let is_valid = enough(explained.len())
            && is_common()
            && explained.iter().all(is_whole)
            && right.iter().all(|image| is_explained_by(undo, image));
        is_valid.then_some(right.len() + explained.len())
    };
    let mut changes = candidates(view, images).into_iter();
    let (count, change) = changes.find_map(|one| Some((explained(&one.undo)?, one)))?;
    let (says, all) = (change.effect, images.len());
    let effect = match count == all {
        true => format!("{says}, in all of the first files"),
        false => format!("{says}, in {count} of the first {all} files"),
    };
    Some(CommonTransform { effect, ..change })
}

/// Returns all candidate changes: first the arrangements, in ascending order of the number of mistakes, and then the curves.
fn candidates(view: ViewKind, images: &[FirstImage]) -> Vec<CommonTransform> {
    let change = |(says, next): ProbeFault, undo: Arc<UndoFn<Frame>>| {
        let view = view.name();
        CommonTransform {
            undo: UndoneTransform { view, undo },
            effect: says,
            next,
        }
    };
    let mut arrangements: Vec<Arrangement> = Arrangement::all().skip(1).collect();
    arrangements.sort_by_key(|arrangement| arrangement.mistakes().len());
    let arrangements = arrangements.into_iter().map(|arrangement| {
        let mistakes = join_texts(arrangement.mistakes(), "\n  ");
        change(mistakes, Arc::new(move |frame, _| arrangement.undo(frame)))
    });
    let pairs = images.iter();
    let pairs: Vec<_> = pairs.map(|&(of, frame)| (&of.expected, frame)).collect();
    let curves = curve::candidates(view, &pairs).into_iter();
    let curves = curves.map(|(fault, curve)| {
        let undo = Arc::new(move |frame: &Frame, right: Option<&Frame>| curve.undo(frame, right));
        change(fault, undo)
    });
    arrangements.chain(curves).collect()
}
