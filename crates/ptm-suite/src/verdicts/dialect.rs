//! The decoder's dialect (its readings of open questions), derived from observations.

use std::cell::RefCell;
use std::collections::HashMap;

use crate::cases::{Suite, TableSpelling};
use crate::dialect::{Axis, Choices, Dialect, RightDialects};
use crate::test_case::TestCase;
use crate::verdicts::observation::{ObservationOf, Response};

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

/// The images of a run whose correctness depends on the dialect. Whether one is right in a dialect is computed when it matters,
/// and then remembered.
pub struct DependentAnswers<'a, C: TestCase> {
    pub(super) suite: &'a Suite<C>,
    observations: &'a [Option<ObservationOf<C>>],
    files: RefCell<HashMap<usize, C::Built>>,
    known: RefCell<HashMap<(usize, usize), bool>>,
}

impl<'a, C: TestCase> DependentAnswers<'a, C> {
    /// Creates the answers of a run. `observations` has a slot for each case of the suite.
    pub fn new(suite: &'a Suite<C>, observations: &'a [Option<ObservationOf<C>>]) -> Self {
        DependentAnswers {
            suite,
            observations,
            files: RefCell::default(),
            known: RefCell::default(),
        }
    }

    /// Returns true if the response to a case is an image.
    pub fn is_image(&self, case: usize) -> bool {
        let response = self.observations[case].as_ref().map(|seen| &seen.response);
        matches!(response, Some(Response::Image { .. }))
    }

    /// Returns true if the response to a case is an image that is right in a dialect.
    pub fn is_right(&self, case: usize, dialect: &Dialect) -> bool {
        let Some(Response::Image { right, .. }) =
            self.observations[case].as_ref().map(|seen| &seen.response)
        else {
            return false;
        };
        let index = C::CHOICES.combination_index(dialect, right.axes());
        if index == 0 {
            return right.is_right_in_reference();
        }
        if let Some(&is_right) = self.known.borrow().get(&(case, index)) {
            return is_right;
        }
        // Dialects are compared again and again, so the file is kept.
        let mut files = self.files.borrow_mut();
        let make = || self.suite.cases[case].make(TableSpelling::default());
        let built = files.entry(case).or_insert_with(make);
        let is_right = self.difference_in(case, built, dialect).is_none();
        self.known.borrow_mut().insert((case, index), is_right);
        is_right
    }

    /// Returns the difference between the image for a case and the correct image in a dialect, if any.
    pub fn difference(&self, case: usize, dialect: &Dialect) -> Option<C::Difference> {
        let built = self.suite.cases[case].make(TableSpelling::default());
        self.difference_in(case, &built, dialect)
    }

    fn difference_in(
        &self,
        case: usize,
        built: &C::Built,
        dialect: &Dialect,
    ) -> Option<C::Difference> {
        let observation = self.observations[case].as_ref()?;
        let Response::Image { frame, .. } = &observation.response else {
            return None;
        };
        let (view, case) = (&observation.view, &self.suite.cases[case]);
        match frame {
            Some(frame) => case.difference_in(built, view, frame, dialect),
            // An output that equals the reference's answer is not kept.
            None => case.difference_in(built, view, &case.expected_output(view)?, dialect),
        }
    }

    /// Returns the cases whose images depend on the dialect, with the choices that affect them. Nondeterministic responses are
    /// left out.
    fn dependent(&self) -> Vec<DependentAnswer<'a>> {
        let dependent = |(case, seen): (usize, &'a Option<ObservationOf<C>>)| {
            let seen = seen.as_ref().filter(|seen| seen.nondeterminism.is_none())?;
            match &seen.response {
                Response::Image {
                    right: RightDialects::Depends { axes, .. },
                    ..
                } => Some((case, &axes[..])),
                _ => None,
            }
        };
        self.observations
            .iter()
            .enumerate()
            .filter_map(dependent)
            .collect()
    }
}

/// The number of an answer, and the choices that affect it.
type DependentAnswer<'a> = (usize, &'a [Axis]);

/// Returns the dialect in which most answers are right and the certainty of its reading of each choice. Ties go to the dialect
/// closest to the reference's.
pub fn dialect_of<C: TestCase>(answers: &DependentAnswers<C>) -> (Dialect, Vec<Certainty>) {
    let is_right = |case: usize, dialect: &Dialect| answers.is_right(case, dialect);
    dialect_in(&C::CHOICES, &answers.dependent(), is_right)
}

/// Returns the dialect in which most of these answers are right, and the certainty of its reading of each choice.
pub(crate) fn dialect_in<R>(
    choices: &Choices<R>,
    answers: &[DependentAnswer],
    is_right: impl Fn(usize, &Dialect) -> bool,
) -> (Dialect, Vec<Certainty>) {
    let mut dialect = choices.reference();
    let mut certain = vec![Certainty::Open; dialect.0.len()];
    // Choices that no case shows together are independent: the number of right answers in a dialect is the sum over the groups,
    // so it is largest if it is largest in every group.
    for axes in group_axes(choices.len(), answers.iter().map(|&(_, axes)| axes)) {
        for (axis, reading, certainty) in evidence(choices, &axes, answers, &is_right) {
            (dialect.0[axis], certain[axis]) = (reading, certainty);
        }
    }
    (dialect, certain)
}

/// Returns, for each of these axes, the reading under which most of the answers are right, and the certainty of that reading.
/// Considers only answers that depend on at least one of the axes.
fn evidence<R>(
    choices: &Choices<R>,
    axes: &[Axis],
    answers: &[DependentAnswer],
    is_right: &impl Fn(usize, &Dialect) -> bool,
) -> Vec<(Axis, usize, Certainty)> {
    let is_about = |(_, shown): &&DependentAnswer| shown.iter().any(|axis| axes.contains(axis));
    let mut about: Vec<DependentAnswer> = answers.iter().filter(is_about).copied().collect();
    // The dialects in which most answers are right; the first is the closest to the reference.
    let (mut best, mut most) = (Vec::new(), 0);
    for dialect in choices.combinations(axes) {
        let max_wrong = about.len() - most;
        let mut wrong = 0;
        for i in 0..about.len() {
            if is_right(about[i].0, &dialect) {
                continue;
            }
            wrong += 1;
            // An answer that contradicts one dialect often contradicts the next, so it is looked at first.
            about[..=i].rotate_right(1);
            if wrong > max_wrong {
                break;
            }
        }
        if wrong > max_wrong {
            continue;
        }
        if about.len() - wrong > most {
            most = about.len() - wrong;
            best.clear();
        }
        best.push(dialect);
    }
    let certainty = |&axis: &Axis| {
        let taken = best[0].0[axis];
        if most == 0 || best.iter().any(|other| other.0[axis] != taken) {
            return (axis, taken, Certainty::Open);
        }
        if taken == 0 {
            return (axis, taken, Certainty::Settled);
        }
        let mut plain = best[0].clone();
        plain.0[axis] = 0;
        let of_axis = || about.iter().filter(|(_, shown)| shown.contains(&axis));
        let against = of_axis().filter(|one| !is_right(one.0, &best[0])).count();
        let alone = of_axis().filter(|one| is_right(one.0, &best[0]) && !is_right(one.0, &plain));
        if alone.count() >= MIN_RIGHT_PER_WRONG * against {
            (axis, taken, Certainty::Settled)
        } else {
            (axis, taken, Certainty::Likely)
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
    use crate::choices::CHOICES;

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
        let shown = images.iter().enumerate().map(|(i, (axes, _))| (i, &**axes));
        let is_right = |i: usize, dialect: &Dialect| {
            let (axes, right) = &images[i];
            right[CHOICES.combination_index(dialect, axes)]
        };
        let (dialect, certain) = dialect_in(&CHOICES, &shown.collect::<Vec<_>>(), is_right);
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
        let other = |ruling| dialect[CHOICES.axes(&[ruling])[0]];
        assert_eq!(rulings.map(other), [1, 2, 1]);
        assert_eq!(dialect.iter().filter(|&&reading| reading > 0).count(), 3);
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
