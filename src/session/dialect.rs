//! The decoder's dialect (its readings of open questions), derived from observations.

use crate::session::observation::{Observation, Response};
use crate::suite::dialect::{Axis, Dialect, RightDialects};
use crate::suite::test_case::TestCase;

/// The certainty of the decoder's reading of an open question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Certainty {
    /// The answers do not distinguish the reading from every other reading.
    Open,
    /// The answers distinguish the reading, but too many are wrong under it, so the apparent reading may be due to a mistake.
    Likely,
    /// The answers distinguish the reading.
    Settled,
}

/// Minimum ratio of answers that support an alternative reading to answers that contradict it. By chance, a few answers of a
/// faulty decoder may be right under another reading.
const MIN_RIGHT_PER_WRONG: usize = 8;

/// The choices that affect an answer and, for each combination of their readings, a flag that is true if the answer is right.
type ShownChoices<'a> = (&'a [Axis], &'a [bool]);

/// Returns the dialect in which most answers are right and the certainty of its reading of each choice. Ties go to the dialect
/// closest to the reference's.
pub fn dialect_of<C: TestCase>(
    observations: &[Option<Observation<C>>],
) -> (Dialect, Vec<Certainty>) {
    let observed = observations.iter().flatten();
    let settled = observed.filter(|observation| observation.nondeterminism.is_none());
    let shown = settled.filter_map(|observation| match &observation.response {
        Response::Image {
            right: RightDialects::In { axes, combinations },
            ..
        } => Some((&axes[..], &combinations[..])),
        _ => None,
    });
    dialect_in::<C>(&shown.collect::<Vec<_>>())
}

fn dialect_in<C: TestCase>(shown: &[ShownChoices]) -> (Dialect, Vec<Certainty>) {
    let mut dialect = C::CHOICES.reference();
    let mut certain = vec![Certainty::Open; dialect.0.len()];
    // Choices that no case shows together are independent: the number of right answers in a dialect is the sum over the groups,
    // so it is largest if it is largest in every group.
    for axes in group_axes(C::CHOICES.len(), shown.iter().map(|&(axes, _)| axes)) {
        for (axis, reading, certainty) in evidence::<C>(&axes, shown) {
            (dialect.0[axis], certain[axis]) = (reading, certainty);
        }
    }
    (dialect, certain)
}

/// Returns, for each of these axes, the reading under which most of the answers are right, and the certainty of that reading.
/// Considers only answers that depend on at least one of the axes.
fn evidence<C: TestCase>(axes: &[Axis], shown: &[ShownChoices]) -> Vec<(Axis, usize, Certainty)> {
    let is_about = |(shown, _): &&ShownChoices| shown.iter().any(|axis| axes.contains(axis));
    let about: Vec<&ShownChoices> = shown.iter().filter(is_about).collect();
    let is_right = |dialect: &Dialect, shown: &ShownChoices| {
        shown.1[C::CHOICES.combination_index(dialect, shown.0)]
    };
    let all = C::CHOICES.combinations(axes);
    let right_in = |dialect| about.iter().filter(|one| is_right(dialect, one)).count();
    let counts: Vec<usize> = all.iter().map(right_in).collect();
    let most = counts.iter().max().copied().unwrap_or_default();
    // The first is the closest to the reference.
    let best = all.iter().zip(counts).filter(|(_, count)| *count == most);
    let best: Vec<&Dialect> = best.map(|(dialect, _)| dialect).collect();
    let certainty = |&axis: &Axis| {
        let taken = best[0].0[axis];
        if most == 0 || best.iter().any(|other| other.0[axis] != taken) {
            return (axis, taken, Certainty::Open);
        }
        let mut plain = best[0].clone();
        plain.0[axis] = 0;
        let of_axis = || about.iter().filter(|(shown, _)| shown.contains(&axis));
        let against = of_axis().filter(|one| !is_right(best[0], one)).count();
        let alone = of_axis().filter(|one| is_right(best[0], one) && !is_right(&plain, one));
        match taken == 0 || alone.count() >= MIN_RIGHT_PER_WRONG * against {
            true => (axis, taken, Certainty::Settled),
            false => (axis, taken, Certainty::Likely),
        }
    };
    axes.iter().map(certainty).collect()
}

/// Groups `count` choices so that all choices of a set in `sets` are in the same group.
fn group_axes<'a>(count: usize, sets: impl Iterator<Item = &'a [Axis]>) -> Vec<Vec<Axis>> {
    let mut groups: Vec<Vec<Axis>> = (0..count).map(|axis| vec![axis]).collect();
    for axes in sets {
        let is_joined = |group: &mut Vec<Axis>| group.iter().any(|axis| axes.contains(axis));
        let joined: Vec<_> = groups.extract_if(.., is_joined).collect();
        let mut joined = joined.concat();
        joined.sort_unstable();
        groups.extend((!joined.is_empty()).then_some(joined));
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::suite::cases::Case;
    use crate::suite::choices::CHOICES;

    type Image = (Vec<Axis>, Vec<bool>);

    /// Returns an image that is right if `right` accepts the combination of readings of `rulings`.
    fn image_from_readings(rulings: &[&str], right: impl Fn(&[usize]) -> bool) -> Image {
        let axes = CHOICES.axes(rulings);
        let is_right = |dialect: &Dialect| {
            let readings: Vec<usize> = axes.iter().map(|&axis| dialect.0[axis]).collect();
            right(&readings)
        };
        let combinations = CHOICES.combinations(&axes).iter().map(is_right).collect();
        (axes, combinations)
    }

    /// Returns the dialect, and each settled reading with its ruling.
    fn settled(images: &[Image]) -> (Vec<usize>, Vec<(&'static str, usize)>) {
        let shown = images.iter().map(|(axes, right)| (&**axes, &**right));
        let (dialect, certain) = dialect_in::<Case>(&shown.collect::<Vec<_>>());
        let axes = (0..CHOICES.len()).filter(|&axis| certain[axis] == Certainty::Settled);
        let settled = axes.map(|axis| (CHOICES[axis].ruling, dialect.0[axis]));
        (dialect.0.clone(), settled.collect())
    }

    #[test]
    fn unrelated_groups_are_decided_independently() {
        let (dialect, settled) = settled(&[
            image_from_readings(&["motion-sign", "motion-border"], |one| one == [1, 2]),
            image_from_readings(&["side-lossless"], |one| one == [1]),
        ]);
        let rulings = ["motion-sign", "motion-border", "side-lossless"];
        assert!(settled.into_iter().eq(rulings.into_iter().zip([1, 2, 1])));
        assert_eq!(dialect, [0, 0, 0, 0, 1, 0, 0, 2, 0, 1]);
    }

    #[test]
    fn shared_choices_join_groups() {
        // The first image shows that one of two choices is read differently from the reference; the second shows which one.
        let images = [
            image_from_readings(&["motion-sign", "jpeg-ls-offset"], |of| of[0] + of[1] == 1),
            image_from_readings(&["jpeg-ls-offset", "side-lossless"], |of| of[0] == 0),
        ];
        assert_eq!(settled(&images[..1]).1, []);
        let readings = [("motion-sign", 1), ("jpeg-ls-offset", 0)];
        assert_eq!(settled(&images).1, readings);
    }

    #[test]
    fn majority_decides_and_ties_go_to_the_reference() {
        let image =
            |reading: usize| image_from_readings(&["motion-half"], move |one| one == [reading]);
        let mut all = vec![image(1); 8];
        all.push(image(0));
        assert_eq!(settled(&all).1, [("motion-half", 1)]);
        // A reading is not settled if too many answers contradict it.
        assert_eq!(settled(&all[4..]), (settled(&all).0, vec![]));
        for without_evidence in [&[][..], &[image(1), image(0)]] {
            assert_eq!(settled(without_evidence), (CHOICES.reference().0, vec![]));
        }
    }
}
