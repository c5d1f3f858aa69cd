//! How the wrong samples of a picture differ from what they should be: all that is true of every one of them.

use super::changes::{Change, Values};
use super::pair::Pair;

type Relation = (&'static str, fn(&Pair, &[(f64, f64)]) -> bool);

/// What may be true of wrong samples: of the picture, and of each expected value and the received one.
const RELATIONS: &[Relation] = &[
    (
        "values that are no numbers (NaN or infinite)",
        |_, pairs| pairs.iter().all(|(_, got)| !got.is_finite()),
    ),
    ("colors that are a unit or two too large", |pair, pairs| {
        pair.view == "rgb" && by_two(pairs) && pairs.iter().all(|(want, got)| got > want)
    }),
    ("colors that are a unit or two too small", |pair, pairs| {
        pair.view == "rgb" && by_two(pairs) && pairs.iter().all(|(want, got)| got < want)
    }),
    ("values that are off by two at most", |_, pairs| {
        by_two(pairs)
    }),
    ("gray: one value for red, green and blue", |pair, pairs| {
        let is_gray = |rgb: &[f64]| rgb[0] == rgb[1] && rgb[1] == rgb[2];
        pair.view == "rgb" && pairs.len() > 2 && pair.got.chunks_exact(3).all(is_gray)
    }),
    ("the right values in wrong places", |pair, pairs| {
        let sorted = |values: &[f64]| {
            let mut values: Vec<u64> = values.iter().map(|value| value.to_bits()).collect();
            values.sort_unstable();
            values
        };
        pairs.len() > 2 && sorted(&pair.want) == sorted(&pair.got)
    }),
];

fn by_two(pairs: &[(f64, f64)]) -> bool {
    pairs.iter().all(|(want, got)| (got - want).abs() <= 2.0)
}

/// All that is true, the most telling first.
pub(super) fn relations(pair: &Pair) -> Vec<String> {
    let wrong = pair.wrong();
    let pairs: Vec<(f64, f64)> = wrong.iter().map(|&i| (pair.want[i], pair.got[i])).collect();
    let values = match pair.view {
        "raw" => Values::Bytes,
        "coef" => Values::Reals,
        _ => Values::Colors,
    };
    let changes = Change::fitting(&pairs, values).into_iter();
    let named = changes.filter(|change| !matches!(change, Change::Table(_) | Change::Points(_)));
    let mut says: Vec<String> = named.map(|change| change.says(values)).collect();
    let holding = RELATIONS.iter().filter(|(_, holds)| holds(pair, &pairs));
    says.extend(holding.map(|(words, _)| (*words).to_owned()));
    says
}
