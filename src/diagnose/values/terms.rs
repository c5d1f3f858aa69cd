//! Other numbers in (raw − bias) · scale.

use crate::ptm::{Planes, ScaleBias, channel_name};

/// Where a number comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnose) enum Source {
    Own,
    Scale(usize),
    Bias(usize),
    Fixed(f64),
    Times(f64),
    Plus(f64),
    Inverse,
    Square,
    Absolute,
    Whole,
    /// A bias that is subtracted after scaling.
    OverScale,
    /// A bias in one byte.
    Byte,
}

const OF_SCALES: &[Source] = &[
    Source::Own,
    Source::Fixed(1.0),
    Source::Absolute,
    Source::Times(-1.0),
    Source::Inverse,
    Source::Square,
    Source::Whole,
    Source::Fixed(0.0),
    Source::Times(2.0),
    Source::Times(0.5),
    Source::Times(1.0 / 255.0),
    Source::Times(1.0 / 256.0),
    Source::Times(255.0 / 256.0),
    Source::Times(256.0 / 255.0),
    Source::Plus(1.0),
    Source::Plus(-1.0),
    Source::Scale(0),
    Source::Scale(1),
    Source::Scale(2),
    Source::Scale(3),
    Source::Scale(4),
    Source::Scale(5),
    Source::Bias(0),
    Source::Bias(1),
    Source::Bias(2),
    Source::Bias(3),
    Source::Bias(4),
    Source::Bias(5),
];

const OF_BIASES: &[Source] = &[
    Source::Own,
    Source::Fixed(0.0),
    Source::Absolute,
    Source::Times(-1.0),
    Source::Times(2.0),
    Source::Times(0.5),
    Source::Plus(1.0),
    Source::Plus(-1.0),
    Source::Plus(128.0),
    Source::Plus(-128.0),
    Source::Byte,
    Source::OverScale,
    Source::Fixed(128.0),
    Source::Bias(0),
    Source::Bias(1),
    Source::Bias(2),
    Source::Bias(3),
    Source::Bias(4),
    Source::Bias(5),
    Source::Scale(0),
    Source::Scale(1),
    Source::Scale(2),
    Source::Scale(3),
    Source::Scale(4),
    Source::Scale(5),
];

impl Source {
    fn of(self, own: f64, i: usize, numbers: &ScaleBias) -> f64 {
        match self {
            Source::Own => own,
            Source::Scale(j) => numbers.scale[j],
            Source::Bias(j) => numbers.bias[j],
            Source::Fixed(value) => value,
            Source::Times(factor) => own * factor,
            Source::Plus(offset) => own + offset,
            Source::Inverse => 1.0 / own,
            Source::Square => own * own,
            Source::Absolute => own.abs(),
            Source::Whole => own.trunc(),
            Source::OverScale => own / numbers.scale[i],
            Source::Byte => own.rem_euclid(256.0),
        }
    }

    /// In words, of "scale" or "bias".
    fn says(self, own: &str) -> String {
        match self {
            Source::Own => format!("its {own}"),
            Source::Scale(j) => format!("the scale of a{j}"),
            Source::Bias(j) => format!("the bias of a{j}"),
            Source::Fixed(value) => format!("{value}"),
            Source::Times(-1.0) => format!("its {own} with the opposite sign"),
            Source::Times(2.0) => format!("twice its {own}"),
            Source::Times(0.5) => format!("half its {own}"),
            Source::Times(factor) if factor < 0.1 => {
                format!("its {own} divided by {}", (1.0 / factor).round())
            }
            Source::Times(factor) if factor < 1.0 => format!("its {own} times 255 / 256"),
            Source::Times(_) => format!("its {own} times 256 / 255"),
            Source::Plus(offset) if offset < 0.0 => format!("its {own} less {}", -offset),
            Source::Plus(offset) => format!("its {own} plus {offset}"),
            Source::Inverse => format!("1 divided by its {own}"),
            Source::Square => format!("the square of its {own}"),
            Source::Absolute => format!("its {own} without the sign"),
            Source::Whole => format!("its {own} without the fraction"),
            Source::OverScale => "its bias after scaling".to_owned(),
            Source::Byte => format!("its {own} modulo 256"),
        }
    }
}

/// Scale and bias of each coefficient: of a0 … a5, or of a0 of red to a5 of blue.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::diagnose) struct Terms(pub Vec<(Source, Source)>);

impl Terms {
    /// The six scales and then the six biases, taken for six pairs of a scale and a bias.
    fn pairs() -> Terms {
        let listed = |place: usize| match place {
            0..6 => Source::Scale(place),
            _ => Source::Bias(place - 6),
        };
        let pair = |i: usize| (listed(2 * i), listed(2 * i + 1));
        let mut terms: Vec<(Source, Source)> = (0..6).map(pair).collect();
        // The first and the last of them stand where they belong.
        (terms[0].0, terms[5].1) = (Source::Own, Source::Own);
        Terms(terms)
    }

    /// Exchanges scales, biases or both as a slip in an index does.
    pub fn exchanges() -> Vec<Terms> {
        let mut orders: Vec<[usize; 6]> = (1..6)
            .map(|by| [0, 1, 2, 3, 4, 5].map(|i| (i + by) % 6))
            .collect();
        orders.push([5, 4, 3, 2, 1, 0]);
        orders.extend((0..6).map(|one| [one; 6]));
        for a in 0..6 {
            for b in a + 1..6 {
                let mut order = [0, 1, 2, 3, 4, 5];
                order.swap(a, b);
                orders.push(order);
            }
        }
        let term = |i: usize, from: usize, which: usize| {
            let moved =
                |source: Source, is: bool| if is && i != from { source } else { Source::Own };
            (
                moved(Source::Scale(from), which != 1),
                moved(Source::Bias(from), which != 0),
            )
        };
        let of = |order: [usize; 6]| {
            (0..3).map(move |which| Terms((0..6).map(|i| term(i, order[i], which)).collect()))
        };
        let all = orders.into_iter().flat_map(of);
        std::iter::once(Terms::pairs()).chain(all).collect()
    }

    /// Whether maps with so many coefficients can be computed so.
    fn holds(&self, coefficients: usize) -> bool {
        self.0.len() == 6 || self.0.len() == coefficients
    }

    /// Computes the coefficients among `values` anew.
    pub fn apply(&self, values: &mut [f64], planes: &Planes, numbers: &ScaleBias) {
        let (count, coefficients) = (planes.shape.channels(), planes.shape.coefficients());
        if !self.holds(coefficients) {
            return;
        }
        for (i, value) in values.iter_mut().enumerate() {
            let channel = i % count;
            let term = self.0[channel % self.0.len()];
            if channel < coefficients && term != (Source::Own, Source::Own) {
                *value = final_value(planes.samples[i], channel % 6, term, numbers);
            }
        }
    }

    /// As a sentence without its subject.
    pub fn says(&self) -> String {
        if *self == Terms::pairs() {
            return "takes the six scales and six biases for six pairs of a scale and a bias"
                .to_owned();
        }
        let scales = list(
            "scale",
            &self.0.iter().map(|term| term.0).collect::<Vec<_>>(),
        );
        let biases = list(
            "bias",
            &self.0.iter().map(|term| term.1).collect::<Vec<_>>(),
        );
        let both: Vec<String> = scales.into_iter().chain(biases).collect();
        format!(
            "computes final values with wrong numbers: {}",
            both.join("; ")
        )
    }
}

/// What is taken for the scales or biases; nothing if these are right.
fn list(own: &str, sources: &[Source]) -> Option<String> {
    let all = sources.len();
    if let Some(by) = (1..6).find(|by| {
        let moved = |i: usize| match own {
            "scale" => Source::Scale((i + by) % 6),
            _ => Source::Bias((i + by) % 6),
        };
        all == 6 && (0..6).all(|i| sources[i] == moved(i))
    }) {
        let way = match by {
            5 => "i − 1 (for a0 that of a5)".to_owned(),
            _ => format!("i + {by} (for a5 that of a{})", by - 1),
        };
        return Some(format!("for coefficient i the {own} of coefficient {way}"));
    }
    let mut groups: Vec<(Source, Vec<String>)> = Vec::new();
    for (i, &source) in sources
        .iter()
        .enumerate()
        .filter(|(_, source)| **source != Source::Own)
    {
        let name = channel_name(if all == 6 { 9 } else { all }, i);
        match groups.iter_mut().find(|(known, _)| *known == source) {
            Some((_, names)) => names.push(name),
            None => groups.push((source, vec![name])),
        }
    }
    let says = |(source, names): &(Source, Vec<String>)| {
        let of = match names.len() == all {
            true => "of every coefficient".to_owned(),
            false => format!("of {}", names.join(", ")),
        };
        format!("{} as the {own} {of}", source.says(own))
    };
    (!groups.is_empty()).then(|| groups.iter().map(says).collect::<Vec<_>>().join(", "))
}

/// One coefficient with these numbers.
pub(in crate::diagnose) fn final_value(
    raw: u8,
    i: usize,
    term: (Source, Source),
    numbers: &ScaleBias,
) -> f64 {
    let scale = term.0.of(numbers.scale[i], i, numbers);
    let bias = term.1.of(numbers.bias[i], i, numbers);
    (f64::from(raw) - bias) * scale
}

/// Every scale with every bias, the simplest first.
pub(in crate::diagnose) fn all_terms() -> Vec<(Source, Source)> {
    let with = |&scale: &Source| OF_BIASES.iter().map(move |&bias| (scale, bias));
    let mut all: Vec<_> = OF_SCALES.iter().flat_map(with).collect();
    let is_wrong = |source: Source| usize::from(source != Source::Own);
    all.sort_by_key(|&(scale, bias)| is_wrong(scale) + is_wrong(bias));
    all
}
