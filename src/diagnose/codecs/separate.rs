//! What the places have in common at which streams first come out wrong, and few of those have that come out right.
//!
//! A place is a block of JPEG or a sample of JPEG-LS. Of each it is known which of its codec's features it has. The feature
//! is said that divides right from wrong best, if so many places would not have it by chance. Where bits are left over or
//! missing, the place after it is the first that shows it; so each feature is looked for there, too.

use std::collections::HashMap;

/// Room for features: each is a bit. So many are of the place itself, and as many of the place or the one before it.
const WORDS: usize = 5;
const ROOM: usize = 64 * WORDS;
/// For one refused file that lacks the feature there must be so many that have it, and for one wrong place so many: what goes
/// wrong may show later.
const NEARLY_ALL: usize = 20;
const MOST: usize = 4;
/// For one wrong place that has it there may be so many right ones; more would be no rule.
const OFTEN: usize = 4;
/// So much rarer has a feature to be in refused files to be said before one that divides as well.
const RARER: usize = 2;
/// A feature is said where one in so many suites would have such a one by chance.
const CHANCE: f64 = 50.0;
/// Fewer wrong places tell nothing.
const FEWEST: usize = 2;

/// Which features a place has, or some place of a file.
#[derive(Clone, Copy, Default, PartialEq, Eq, Hash)]
pub(in crate::diagnose) struct Features([u64; 2 * WORDS]);

/// A feature of places of one kind.
pub(in crate::diagnose) struct Feature<P: 'static> {
    /// Completes "blocks …", "samples …".
    pub says: String,
    pub holds: Box<dyn Fn(&P) -> bool + Send + Sync>,
}

impl Features {
    /// The features of each place.
    pub fn of_all<P>(places: &[P], all: &[Feature<P>]) -> Vec<Features> {
        places
            .iter()
            .map(|place| Features::of(place, all))
            .collect()
    }

    fn of<P>(place: &P, all: &[Feature<P>]) -> Features {
        debug_assert!(all.len() <= ROOM, "{} features", all.len());
        let mut features = Features::default();
        for (i, feature) in all.iter().enumerate().take(ROOM) {
            features.0[i / 64] |= u64::from((feature.holds)(place)) << (i % 64);
        }
        features
    }

    /// The same, where that place stands before it in the stream.
    pub fn after(mut self, before: Features) -> Features {
        for word in 0..WORDS {
            self.0[WORDS + word] = self.0[word] | before.0[word];
        }
        self
    }

    fn has(self, one: usize) -> bool {
        self.0[one / 64] >> (one % 64) & 1 == 1
    }

    /// What this place or the other has.
    pub fn add(&mut self, other: Features) {
        for (word, other) in self.0.iter_mut().zip(other.0) {
            *word |= other;
        }
    }
}

/// What is known of the streams of one codec.
#[derive(Default)]
pub(in crate::diagnose) struct Evidence {
    /// The first wrong place of each plane.
    pub wrong: Vec<Features>,
    /// How many places came out right, those before the first wrong one and those of right planes.
    pub right: HashMap<Features, usize>,
    /// All that occurs in each file that was refused.
    pub refused: Vec<Features>,
    /// How many places these files have in all.
    pub unknown: HashMap<Features, usize>,
    /// All that occurs in each file whose planes are right.
    pub read: Vec<Features>,
}

/// A feature that divides right from wrong, and how well.
pub(in crate::diagnose) struct Separation {
    /// Its place in the list of features.
    pub feature: usize,
    /// Whether the place before may have it instead.
    is_after: bool,
    /// Wrong places, right ones, refused files and files that were read: those that have it, and the others.
    pub wrong: [usize; 2],
    pub right: [usize; 2],
    pub refused: [usize; 2],
    pub read: [usize; 2],
    /// Places of refused files that have it.
    unknown: usize,
}

/// The feature of `count` that divides best, if one does.
pub(in crate::diagnose) fn separate(evidence: &Evidence, count: usize) -> Option<Separation> {
    let places = [false, true]
        .into_iter()
        .flat_map(|is_after| (0..count).map(move |i| (i, is_after)));
    let separations = places.map(|(feature, is_after)| Separation::by(feature, is_after, evidence));
    let telling = separations.filter(|separation| separation.is_telling(2 * count));
    let likely = telling.map(|separation| (separation.likelihood(), separation));
    // Among equals what refused files have in fewer places, and then the first.
    let best = likely.reduce(|best, other| match other.0 - best.0 {
        more if more > 1e-9 => other,
        less if less < -1e-9 => best,
        _ if other.1.unknown * RARER < best.1.unknown => other,
        _ => best,
    });
    best.map(|(_, separation)| separation)
}

impl Separation {
    fn by(feature: usize, is_after: bool, evidence: &Evidence) -> Separation {
        let one = if is_after { ROOM + feature } else { feature };
        let split = |of: &[Features]| {
            let with = of.iter().filter(|features| features.has(one)).count();
            [with, of.len() - with]
        };
        let mut right = [0; 2];
        for (features, count) in &evidence.right {
            right[usize::from(!features.has(one))] += count;
        }
        let unknown = (evidence.unknown.iter()).filter(|(features, _)| features.has(one));
        Separation {
            unknown: unknown.map(|(_, count)| count).sum(),
            feature,
            is_after,
            right,
            wrong: split(&evidence.wrong),
            refused: split(&evidence.refused),
            read: split(&evidence.read),
        }
    }

    /// Whether most wrong places have it, and would not by chance, being drawn like the right ones.
    fn is_telling(&self, count: usize) -> bool {
        let share =
            |[with, without]: [usize; 2]| (with as f64 + 0.5) / ((with + without) as f64 + 1.0);
        let chance = share(self.right).powi(self.wrong[0] as i32)
            * share(self.read).powi(self.refused[0] as i32);
        let is_of_places = self.wrong[0] >= FEWEST && self.wrong[0] * OFTEN >= self.right[0];
        let is_of_files = self.refused[0] >= FEWEST && self.read[0] <= self.refused[0] / 2;
        (is_of_places || is_of_files)
            && self.wrong[1] * MOST <= self.wrong[0]
            && self.refused[1] * NEARLY_ALL <= self.refused[0]
            && chance * count as f64 * CHANCE < 1.0
    }

    /// The logarithm of how likely it is that just these are wrong, if all with the feature are so with one probability and
    /// all others with another.
    fn likelihood(&self) -> f64 {
        let of = |wrong: usize, right: usize| {
            let part = |count: usize| match count {
                0 => 0.0,
                _ => count as f64 * (count as f64 / (wrong + right) as f64).ln(),
            };
            part(wrong) + part(right)
        };
        of(self.wrong[0], self.right[0])
            + of(self.wrong[1], self.right[1])
            + of(self.refused[0], self.read[0])
            + of(self.refused[1], self.read[1])
    }

    /// "first at blocks …: of 57 such blocks 57 are wrong, of 412 others none".
    pub fn says(&self, places: &str, feature: &str) -> String {
        let first = self.first(places, feature);
        let (sign, what) = match (self.wrong[0], feature.strip_prefix("of streams")) {
            (0, Some(rest)) => (",", format!("streams{rest}")),
            (0, None) => (",", format!("{places} {feature}")),
            _ => (";", format!("such {places}")),
        };
        match self.refused[0] {
            0 => first,
            with => format!(
                "{first}{sign} {with} of the {} refused files have {what}, and {} of {} that are read",
                with + self.refused[1],
                count(self.read[0]),
                self.read[0] + self.read[1],
            ),
        }
    }

    /// ", first at blocks …", where some are wrong.
    fn first(&self, places: &str, feature: &str) -> String {
        match self.wrong[0] {
            0 => String::new(),
            _ => format!(
                ", first at {}{places} {feature}: of {} such {places} {} are the first wrong ones of their planes, of {} others {}",
                if self.is_after { "or right after " } else { "" },
                self.wrong[0] + self.right[0],
                self.wrong[0],
                self.wrong[1] + self.right[1],
                count(self.wrong[1]),
            ),
        }
    }
}

fn count(number: usize) -> String {
    match number {
        0 => "none".to_owned(),
        number => number.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::{Evidence, Feature, Features, separate};

    fn features() -> Vec<Feature<u32>> {
        let multiple = |divisor: u32| Feature {
            says: format!("divisible by {divisor}"),
            holds: Box::new(move |place: &u32| place.is_multiple_of(divisor)),
        };
        [1, 2, 3, 6].map(multiple).into()
    }

    fn evidence(is_wrong: fn(u32) -> bool) -> Evidence {
        let all = features();
        let mut evidence = Evidence::default();
        for place in 1..=60 {
            let features = Features::of(&place, &all);
            match is_wrong(place) {
                true => evidence.wrong.push(features),
                false => *evidence.right.entry(features).or_default() += 1,
            }
        }
        evidence
    }

    #[test]
    fn the_feature_is_said_that_all_wrong_places_have_and_no_right_one() {
        let found = separate(&evidence(|place| place % 3 == 0), 4).expect("a feature");
        let says = found.says("blocks", &features()[found.feature].says);
        assert_eq!(
            says,
            ", first at blocks divisible by 3: of 20 such blocks 20 are the first wrong ones of their planes, of 40 others none"
        );
    }

    #[test]
    fn a_place_may_be_wrong_because_of_the_one_before() {
        let all = features();
        let mut evidence = Evidence::default();
        for place in 1..=60 {
            let features = Features::of(&place, &all).after(Features::of(&(place - 1), &all));
            match place % 6 == 1 {
                true => evidence.wrong.push(features),
                false => *evidence.right.entry(features).or_default() += 1,
            }
        }
        let found = separate(&evidence, 4).expect("a feature");
        let says = found.says("blocks", &all[found.feature].says);
        let words = ", first at or right after blocks divisible by 6: of 20 such blocks 10 are";
        assert!(says.starts_with(words), "{says}");
    }

    #[test]
    fn nothing_is_said_where_right_places_are_as_the_wrong_ones() {
        assert!(separate(&evidence(|place| place % 7 == 0), 4).is_none());
    }

    #[test]
    fn files_without_a_picture_tell_by_what_occurs_in_them() {
        let all = features();
        let of = |place: u32| Features::of(&place, &all);
        let evidence = Evidence {
            refused: [2, 4, 8, 10, 14, 16, 20, 22, 26, 28].map(of).into(),
            read: [1, 3, 5, 7, 9, 11].map(of).into(),
            ..Evidence::default()
        };
        let found = separate(&evidence, 4).expect("a feature");
        let says = found.says("blocks", &all[found.feature].says);
        assert_eq!(
            says,
            ", 10 of the 10 refused files have blocks divisible by 2, and none of 6 that are read"
        );
    }
}
