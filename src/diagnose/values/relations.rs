//! How the wrong samples of a picture differ from what they should be: all that is true of every one of them.

use super::changes::{Change, Values, short};
use crate::diagnose::pair::Pair;

/// Rows or columns of which is told which one they show.
const LINES: usize = 8;
/// In pictures of more or fewer of them it is not asked.
const COUNTS: std::ops::RangeInclusive<usize> = 3..=64;

/// How far the nearest whole number may be, and a little more.
const NEAREST: f64 = 0.52;

pub(in crate::diagnose) const ROWS: &str = "right rows in wrong places";

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
    ("values that are off by less than one", |_, pairs| {
        pairs.iter().all(|(want, got)| (want - got).abs() < 1.0)
    }),
    ("values that are off by two at most", |_, pairs| {
        by_two(pairs)
    }),
    ("gray: one value for red, green and blue", |pair, _| {
        let is_gray = |rgb: &[f64]| rgb[0] == rgb[1] && rgb[1] == rgb[2];
        // What is limited to 0 or 255 is gray anyhow, and so is what should be.
        let texels = pair.want.chunks_exact(3).zip(pair.got.chunks_exact(3));
        let telling = texels.filter(|(want, got)| !is_gray(want) && !is_limit(got[0]));
        pair.view == "rgb" && telling.count() > 1 && pair.got.chunks_exact(3).all(is_gray)
    }),
    (ROWS, |pair, pairs| {
        pairs.len() > 2 && elsewhere(pair, pair.height, row).is_some_and(|rows| moves(&rows))
    }),
    ("right columns in wrong places", |pair, pairs| {
        pairs.len() > 2
            && elsewhere(pair, pair.width, column).is_some_and(|columns| moves(&columns))
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

/// The samples of a row or of a column.
type Line = fn(pair: &Pair, values: &[f64], place: usize) -> Vec<f64>;

fn row(pair: &Pair, values: &[f64], y: usize) -> Vec<f64> {
    let length = pair.width * pair.channels;
    values[y * length..(y + 1) * length].to_vec()
}

fn column(pair: &Pair, values: &[f64], x: usize) -> Vec<f64> {
    let texels = values
        .chunks_exact(pair.channels)
        .skip(x)
        .step_by(pair.width);
    texels.flatten().copied().collect()
}

/// Which of the right lines stands in the place of each, if all that are shown are right ones.
fn elsewhere(pair: &Pair, count: usize, line: Line) -> Option<Vec<usize>> {
    if !COUNTS.contains(&count) {
        return None;
    }
    // Colors are rounded.
    let slack = if pair.view == "rgb" { 1.5 } else { 0.0 };
    let is_near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= slack);
    let right: Vec<Vec<f64>> = (0..count)
        .map(|place| line(pair, &pair.want, place))
        .collect();
    let source = |place: usize| {
        let shown = line(pair, &pair.got, place);
        right.iter().position(|right| is_near(right, &shown))
    };
    (0..count).map(source).collect()
}

/// Whether some line stands in another's place.
fn moves(sources: &[usize]) -> bool {
    (sources.iter().enumerate()).any(|(place, &source)| place != source)
}

/// ": rows 0, 1, 2 show rows 2, 1, 0, counted from the top"; nothing where no line is another.
pub(in crate::diagnose) fn in_words(pair: &Pair) -> Option<String> {
    let lines: [(&str, usize, Line); 2] =
        [("rows", pair.height, row), ("columns", pair.width, column)];
    let (name, sources) = lines
        .into_iter()
        .find_map(|(name, count, line)| Some((name, elsewhere(pair, count, line)?)))
        .filter(|(_, sources)| moves(sources))?;
    let few = |places: &mut dyn Iterator<Item = usize>| {
        let places: Vec<String> = places.take(LINES).map(|place| place.to_string()).collect();
        places.join(", ")
    };
    let from = if name == "rows" {
        "the top"
    } else {
        "the left"
    };
    Some(format!(
        "; {name} {} show {name} {}, counted from {from}",
        few(&mut (0..sources.len())),
        few(&mut sources.iter().copied()),
    ))
}

/// "other values where 0 belongs", if one value is expected wherever a wrong one stands.
fn one_expected(pairs: &[(f64, f64)]) -> Option<String> {
    let (first, _) = pairs.first()?;
    let is_first = |(want, _): &(f64, f64)| want == first;
    (pairs.iter().all(is_first)).then(|| format!("other values where {} belongs", short(*first)))
}

/// Whether a color may be one beyond the limits.
fn is_limit(color: f64) -> bool {
    color <= 0.0 || color >= 255.0
}

fn by_two(pairs: &[(f64, f64)]) -> bool {
    pairs.iter().all(|(want, got)| (got - want).abs() <= 2.0)
}

/// All that is true, the most telling first.
pub(in crate::diagnose) fn relations(pair: &Pair) -> Vec<String> {
    let wrong = pair.wrong();
    let pairs: Vec<(f64, f64)> = wrong.iter().map(|&i| (pair.want[i], pair.got[i])).collect();
    let values = match pair.view {
        "raw" => Values::Bytes,
        "coef" => Values::Reals,
        _ => Values::Colors,
    };
    let changes = Change::fitting(&pairs, values).into_iter();
    // Colors are whole numbers: by an offset they are off to the nearest one.
    let is_exact = |change: &Change| {
        let mut pairs = pairs.iter();
        values != Values::Colors
            || !matches!(change, Change::Offset(_) | Change::OffsetClamped(_))
            || pairs.all(|&(want, got)| (change.apply(want, values) - got).abs() <= NEAREST)
    };
    let named = changes
        .filter(|change| !matches!(change, Change::Table(_) | Change::Points(_)))
        .filter(is_exact);
    let mut says: Vec<String> = named.map(|change| change.says(values)).collect();
    let holding = RELATIONS.iter().filter(|(_, holds)| holds(pair, &pairs));
    says.extend(holding.map(|(words, _)| (*words).to_owned()));
    says.extend(one_expected(&pairs));
    says
}

#[cfg(test)]
mod tests {
    use super::relations;
    use crate::diagnose::pair::Pair;

    fn colors(want: &[[f64; 3]], got: &[[f64; 3]]) -> Vec<String> {
        relations(&Pair {
            width: want.len(),
            height: 1,
            channels: 3,
            want: want.concat(),
            got: got.concat(),
            view: "rgb",
        })
    }

    #[test]
    fn colors_at_a_limit_are_neither_gray_nor_inverted() {
        let want = [[250.0, 0.0, 9.0], [10.0, 255.0, 255.0], [255.0, 3.0, 255.0]];
        let limits = [[0.0; 3], [255.0; 3], [0.0; 3]];
        let says = colors(&want, &limits);
        assert!(
            !says
                .iter()
                .any(|says| says.contains("gray") || says.contains("inverted")),
            "{says:?}"
        );
        let says = colors(&want, &[[80.0; 3], [170.0; 3], [90.0; 3]]);
        assert!(says.iter().any(|says| says.contains("gray")), "{says:?}");
    }
}
