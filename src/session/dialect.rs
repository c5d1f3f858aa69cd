//! From observations to the dialect: how a decoder reads the open questions.

use crate::session::observation::{Observation, Response};
use crate::suite::dialect::{Axis, Dialect, Right};
use crate::suite::test_case::TestCase;

/// How well the answers tell how a decoder reads an open question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Certainty {
    /// They do not tell its reading from every other.
    Open,
    /// They do, but not few are wrong in it: a mistake may make it look so.
    Likely,
    /// They do.
    Settled,
}

/// What the answers show of choices that some case shows together: an answer for these axes and for no other.
struct Evidence {
    axes: Vec<Axis>,
    /// The combinations of these axes in which most answers are right, the nearest to the reference's first; all of them
    /// where there is no evidence.
    best: Vec<Dialect>,
    /// Whether there is any.
    any: bool,
    /// Of each of the axes, whether the reading of it in the first of these combinations is believed.
    believed: Vec<bool>,
}

/// A reading other than the reference's is believed where so many answers speak for it to each that is wrong in it: where a
/// decoder is mistaken, some come out as in another reading.
const FEW: usize = 8;

/// The dialect in which most answers are right, among equals the one nearest to the reference's; and of each choice how well
/// the evidence tells its reading from every other.
pub(super) fn dialect_of<C: TestCase>(
    observations: &[Option<Observation<C>>],
) -> (Dialect, Vec<Certainty>) {
    let mut dialect = C::CHOICES.reference();
    let mut certain = vec![Certainty::Open; dialect.0.len()];
    for group in evidence(observations) {
        for (axis, is_believed) in group.axes.into_iter().zip(group.believed) {
            let taken = group.best[0].0[axis];
            dialect.0[axis] = taken;
            let is_alone = group.best.iter().all(|other| other.0[axis] == taken);
            certain[axis] = match group.any && is_alone {
                false => Certainty::Open,
                true if is_believed => Certainty::Settled,
                true => Certainty::Likely,
            };
        }
    }
    (dialect, certain)
}

/// The evidence of the dialect, group by group.
///
/// Choices that no case shows together are independent: the answers right in a dialect are the sum over the groups, so
/// most are right where most are right in every group, and nobody has to look at all dialects.
fn evidence<C: TestCase>(observations: &[Option<Observation<C>>]) -> Vec<Evidence> {
    let shown: Vec<(&[Axis], &[bool])> = observations
        .iter()
        .flatten()
        .filter(|observation| observation.nondeterminism.is_none())
        .filter_map(|observation| match &observation.response {
            Response::Picture {
                right: Right::In { axes, combinations },
                ..
            } => Some((&axes[..], &combinations[..])),
            _ => None,
        })
        .collect();
    groups(C::CHOICES.len(), shown.iter().map(|&(axes, _)| axes))
        .into_iter()
        .map(|axes| weighed::<C>(axes, &shown))
        .collect()
}

/// In which combinations of `axes` most of the answers that show any of them are right.
fn weighed<C: TestCase>(axes: Vec<Axis>, shown: &[(&[Axis], &[bool])]) -> Evidence {
    let all = C::CHOICES.combinations(&axes);
    let about: Vec<_> = shown
        .iter()
        .filter(|(of, _)| of.iter().any(|axis| axes.contains(axis)))
        .collect();
    let right_in = |dialect: &Dialect| {
        let right = about.iter();
        right
            .filter(|(of, right)| right[C::CHOICES.place(dialect, of)])
            .count()
    };
    let counts: Vec<usize> = all.iter().map(right_in).collect();
    let most = counts.iter().max().copied().unwrap_or_default();
    let best: Vec<Dialect> = (all.into_iter().zip(counts))
        .filter_map(|(dialect, count)| (count == most).then_some(dialect))
        .collect();
    let is_believed = |&axis: &Axis| {
        let mut plain = best[0].clone();
        plain.0[axis] = 0;
        let of_axis = || about.iter().filter(|(of, _)| of.contains(&axis));
        let is_right = |dialect: &Dialect, (of, right): &(&[Axis], &[bool])| {
            right[C::CHOICES.place(dialect, of)]
        };
        let against = of_axis().filter(|one| !is_right(&best[0], one)).count();
        let alone = of_axis().filter(|one| is_right(&best[0], one) && !is_right(&plain, one));
        best[0].0[axis] == 0 || alone.count() >= FEW * against
    };
    Evidence {
        any: most > 0,
        believed: axes.iter().map(is_believed).collect(),
        axes,
        best,
    }
}

/// The choices, grouped so that those which stand together in any of `together` stand together.
fn groups<'a>(choices: usize, together: impl Iterator<Item = &'a [Axis]>) -> Vec<Vec<Axis>> {
    let mut groups: Vec<Vec<Axis>> = (0..choices).map(|axis| vec![axis]).collect();
    for axes in together {
        let (joined, apart): (Vec<_>, Vec<_>) = groups
            .into_iter()
            .partition(|group| group.iter().any(|axis| axes.contains(axis)));
        let mut joined = joined.concat();
        joined.sort_unstable();
        groups = apart;
        groups.extend((!joined.is_empty()).then_some(joined));
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::protocol::frame::View;
    use crate::suite::cases::Case;
    use crate::suite::choices::CHOICES;
    use crate::suite::test_case::Allowance;

    /// A picture that is right in the combinations of `rulings` that `right` names, by its readings on them.
    #[expect(
        clippy::unnecessary_wraps,
        reason = "others of its type return nothing"
    )]
    fn shown(rulings: &[&str], right: impl Fn(&[usize]) -> bool) -> Option<Observation> {
        let axes = CHOICES.axes(rulings);
        let on = |dialect: &Dialect| {
            right(&axes.iter().map(|&axis| dialect.0[axis]).collect::<Vec<_>>())
        };
        let combinations = CHOICES.combinations(&axes).iter().map(on).collect();
        let right = Right::In { axes, combinations };
        Some(Observation {
            view: View::Raw,
            response: Response::Picture {
                right,
                difference: None,
                allowance: Allowance::None,
                frame: None,
            },
            weak: false,
            stderr: String::new(),
            after: None,
            nondeterminism: None,
        })
    }

    fn settled(observations: &[Option<Observation>]) -> Vec<(&'static str, usize)> {
        let (dialect, certain) = dialect_of::<Case>(observations);
        let readings = CHOICES.iter().zip(dialect.0).zip(certain);
        readings
            .filter(|(_, certain)| *certain == Certainty::Settled)
            .map(|((choice, reading), _)| (choice.ruling, reading))
            .collect()
    }

    #[test]
    fn without_evidence_the_dialect_is_the_references() {
        assert_eq!(dialect_of::<Case>(&[]).0, CHOICES.reference());
        assert_eq!(settled(&[]), []);
    }

    #[test]
    fn groups_that_no_file_joins_are_settled_independently() {
        let observations = [
            shown(&["motion-sign", "motion-border"], |of| of == [1, 2]),
            shown(&["side-lossless"], |of| of == [1]),
            None,
        ];
        assert_eq!(
            settled(&observations),
            [
                ("motion-sign", 1),
                ("motion-border", 2),
                ("side-lossless", 1)
            ]
        );
        assert_eq!(
            dialect_of(&observations).0.0,
            [0, 0, 0, 0, 1, 0, 0, 2, 0, 1]
        );
    }

    #[test]
    fn files_that_share_a_choice_join_their_groups() {
        // Alone, the first says that one of both is read as the reference does not; the second says which.
        let observations = [
            shown(&["motion-sign", "jpeg-ls-offset"], |of| {
                of.iter().sum::<usize>() == 1
            }),
            shown(&["jpeg-ls-offset", "side-lossless"], |of| of[0] == 0),
        ];
        assert_eq!(settled(&observations[..1]), []);
        assert_eq!(
            settled(&observations),
            [("motion-sign", 1), ("jpeg-ls-offset", 0)]
        );
    }

    #[test]
    fn the_reading_of_most_pictures_counts_and_ties_go_to_the_references() {
        let other = || shown(&["motion-half"], |of| of == [1]);
        let reference = || shown(&["motion-half"], |of| of == [0]);
        let mut all: Vec<_> = (0..8).map(|_| other()).collect();
        all.push(reference());
        assert_eq!(settled(&all), [("motion-half", 1)]);
        // Where several are otherwise it is no reading.
        assert_eq!(settled(&all[4..]), []);
        assert_eq!(dialect_of(&all[4..]).0.0, dialect_of(&all).0.0);
        let tie = [other(), reference()];
        assert_eq!(settled(&tie), []);
        assert_eq!(dialect_of(&tie).0, CHOICES.reference());
    }
}
