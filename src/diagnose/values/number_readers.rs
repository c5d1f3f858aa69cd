//! Numbers of the header read otherwise than as decimal numbers: what parsers of one's own make of them.

use super::changes::half;
use super::numbers::Used;
use crate::diagnose::witness::Witness;
use crate::protocol::frame::Light;
use crate::ptm::{Ptm, ScaleBias, Shape};
use crate::suite::compare::{apart, is_close};

/// A number as it is written: sign, whole part, fraction and exponent.
struct Written<'a> {
    text: &'a str,
    negative: bool,
    whole: &'a str,
    fraction: &'a str,
    exponent: i32,
}

impl<'a> Written<'a> {
    fn of(text: &'a str) -> Written<'a> {
        let (mantissa, exponent) = match text.split_once(['e', 'E']) {
            Some((mantissa, exponent)) => (mantissa, exponent.parse().unwrap_or_default()),
            None => (text, 0),
        };
        let digits = mantissa.trim_start_matches(['+', '-']);
        let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
        Written {
            text,
            negative: mantissa.starts_with('-'),
            whole,
            fraction,
            exponent,
        }
    }

    fn whole(&self) -> f64 {
        self.whole.parse().unwrap_or_default()
    }

    /// 0.5 of "5", and of "05" 0.05.
    fn fraction(&self) -> f64 {
        format!("0.{}", self.fraction).parse().unwrap_or_default()
    }

    /// With this whole part and this fraction, and with sign and exponent as they are.
    fn with(&self, whole: f64, fraction: f64) -> f64 {
        let value = (whole + fraction) * 10f64.powi(self.exponent);
        if self.negative { -value } else { value }
    }

    fn value(&self) -> f64 {
        self.with(self.whole(), self.fraction())
    }

    /// To the nearest so manieth part.
    fn rounded(&self, part: f64) -> f64 {
        (self.value() * part).round() / part
    }

    /// To so many parts of one, towards zero.
    fn cut(&self, part: f64) -> f64 {
        (self.value() * part).trunc() / part
    }

    /// To so many parts of one, never more than it is.
    fn floored(&self, part: f64) -> f64 {
        (self.value() * part).floor() / part
    }

    /// With so many digits of the fraction.
    fn digits(&self, most: usize) -> f64 {
        let kept = &self.fraction[..self.fraction.len().min(most)];
        self.with(
            self.whole(),
            format!("0.{kept}").parse().unwrap_or_default(),
        )
    }

    /// Of the first characters only.
    fn characters(&self, most: usize) -> f64 {
        let kept = self.text.get(..most).unwrap_or(self.text);
        kept.trim_end_matches(['e', 'E', '-', '+'])
            .parse()
            .unwrap_or_default()
    }
}

/// What is made of a number, in words and as a function.
type Reader = (&'static str, fn(&Written) -> f64);

const READERS: &[Reader] = &[
    (
        "loses the sign of numbers between −1 and 0 (0.5 for −0.5)",
        |n| {
            let value = n.value();
            if n.whole() == 0.0 { value.abs() } else { value }
        },
    ),
    (
        "adds the fraction of negative numbers (−0.5 for −1.5, and 0.5 for −0.5)",
        |n| {
            let sign = if n.negative { -1.0 } else { 1.0 };
            (sign * n.whole() + n.fraction()) * 10f64.powi(n.exponent)
        },
    ),
    (
        "adds the fraction of negative numbers without an exponent (−0.5 for −1.5, and 0.5 for −0.5)",
        |n| match n.negative && n.exponent == 0 {
            true => n.fraction() - n.whole(),
            false => n.value(),
        },
    ),
    ("loses zeros behind the decimal point (0.5 for 0.05)", |n| {
        let digits = n.fraction.trim_start_matches('0');
        n.with(n.whole(), format!("0.{digits}").parse().unwrap_or_default())
    }),
    ("divides every fraction by 10 (1.025 for 1.25)", |n| {
        let digits: f64 = n.fraction.parse().unwrap_or_default();
        n.with(
            n.whole(),
            if digits < 10.0 {
                digits / 10.0
            } else {
                digits / 1000.0
            },
        )
    }),
    ("keeps the whole part of a number only (1 for 1.5)", |n| {
        n.with(n.whole(), 0.0)
    }),
    ("keeps the fraction of a number only (0.5 for 1.5)", |n| {
        n.with(0.0, n.fraction())
    }),
    ("keeps one digit behind the decimal point", |n| n.digits(1)),
    ("keeps two digits behind the decimal point", |n| n.digits(2)),
    ("rounds numbers to one decimal", |n| n.rounded(10.0)),
    ("rounds numbers to two decimals", |n| n.rounded(100.0)),
    ("rounds numbers to three decimals", |n| n.rounded(1000.0)),
    ("rounds numbers to four decimals", |n| n.rounded(10_000.0)),
    ("cuts numbers to multiples of 1/16", |n| n.cut(16.0)),
    ("cuts numbers to multiples of 1/64", |n| n.cut(64.0)),
    ("cuts numbers to multiples of 1/256", |n| n.cut(256.0)),
    ("cuts numbers to multiples of 1/1024", |n| n.cut(1024.0)),
    ("cuts numbers to multiples of 1/4096", |n| n.cut(4096.0)),
    ("cuts numbers to multiples of 1/65536", |n| n.cut(65536.0)),
    ("rounds numbers down to multiples of 1/256", |n| {
        n.floored(256.0)
    }),
    ("rounds numbers down to multiples of 1/1024", |n| {
        n.floored(1024.0)
    }),
    ("rounds numbers down to multiples of 1/65536", |n| {
        n.floored(65536.0)
    }),
    (
        "keeps numbers in half precision, eleven significant bits",
        |n| half(n.value()),
    ),
    ("keeps three digits behind the decimal point", |n| {
        n.digits(3)
    }),
    ("keeps four digits behind the decimal point", |n| {
        n.digits(4)
    }),
    ("keeps five digits behind the decimal point", |n| {
        n.digits(5)
    }),
    ("keeps six digits behind the decimal point", |n| n.digits(6)),
    ("keeps four characters of a number", |n| n.characters(4)),
    ("keeps five characters of a number", |n| n.characters(5)),
    ("keeps six characters of a number", |n| n.characters(6)),
    ("keeps seven characters of a number", |n| n.characters(7)),
    ("keeps eight characters of a number", |n| n.characters(8)),
    ("reads numbers with leading zeros as octal", |n| {
        let is_octal = n.whole.len() > 1 && n.whole.starts_with('0') && n.fraction.is_empty();
        let octal = n.whole.chars().map_while(|digit| digit.to_digit(8));
        let octal = octal.fold(0, |value: u32, digit| {
            value.wrapping_mul(8).wrapping_add(digit)
        });
        n.with(
            if is_octal {
                f64::from(octal)
            } else {
                n.whole()
            },
            n.fraction(),
        )
    }),
    ("loses the sign of an exponent", |n| {
        n.value() * 10f64.powi(n.exponent.abs() - n.exponent)
    }),
    ("turns the sign of an exponent round", |n| {
        n.value() * 10f64.powi(-2 * n.exponent)
    }),
    ("keeps one digit of an exponent", |n| {
        let kept = n.exponent / 10f64.powi(n.exponent.abs().max(1).ilog10() as i32) as i32;
        n.value() * 10f64.powi(kept - n.exponent)
    }),
    ("takes an exponent for a power of two", |n| {
        n.value() * 0.2f64.powi(n.exponent)
    }),
    ("ignores the exponent", |n| {
        n.value() * 10f64.powi(-n.exponent)
    }),
    (
        "ignores the exponent of a number without a point (5 for 5e-1)",
        |n| {
            let has_point = n.text.contains('.');
            n.value()
                * if has_point {
                    1.0
                } else {
                    10f64.powi(-n.exponent)
                }
        },
    ),
    ("takes the exponent one too large", |n| {
        n.value() * if n.exponent == 0 { 1.0 } else { 10.0 }
    }),
    ("reads numbers without a whole part (.5) as 0", |n| {
        if n.whole.is_empty() { 0.0 } else { n.value() }
    }),
    ("reads numbers with a plus sign as 0", |n| {
        if n.text.starts_with('+') {
            0.0
        } else {
            n.value()
        }
    }),
    ("reads negative numbers as 0", |n| {
        if n.negative { 0.0 } else { n.value() }
    }),
    ("loses the minus sign of a number", |n| n.value().abs()),
    ("keeps numbers in a byte (236 for −20)", |n| {
        n.value().trunc().rem_euclid(256.0)
    }),
    ("keeps whole numbers in a byte (236 for −20)", |n| {
        let value = n.value();
        if n.fraction.is_empty() && value.fract() == 0.0 {
            value.rem_euclid(256.0)
        } else {
            value
        }
    }),
    ("takes −1 for numbers below it", |n| n.value().max(-1.0)),
    ("takes 1 for numbers above it", |n| n.value().min(1.0)),
];

/// The lists of numbers in a header: their clauses and their names.
const LISTS: [(&str, &str); 3] = [
    ("2.4/3", "scales"),
    ("2.4/4", "biases"),
    ("2.6/2", "elements of the matrix"),
];

/// Which numbers are read so.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Of {
    /// All of the header.
    Header,
    /// A list of the header, by its place in [`LISTS`].
    List(usize),
    /// u and v of the light that was asked for.
    Light,
    HeaderAndLight,
}

/// Numbers read otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnose) struct NumberReader {
    reader: usize,
    of: Of,
}

impl NumberReader {
    /// All of them.
    pub fn all() -> impl Iterator<Item = NumberReader> {
        let lists = (0..LISTS.len()).map(Of::List);
        let of = [Of::Header, Of::Light, Of::HeaderAndLight];
        of.into_iter()
            .chain(lists)
            .flat_map(|of| (0..READERS.len()).map(move |reader| NumberReader { reader, of }))
    }

    /// Whether numbers of the header are among those.
    pub fn is_of_header(self) -> bool {
        self.of != Of::Light
    }

    /// The light that such a reader finds in a request.
    pub fn light(self, light: &Light) -> (f64, f64) {
        let read = |text: &str| READERS[self.reader].1(&Written::of(text));
        match (self.of, light.texts()) {
            (Of::Light | Of::HeaderAndLight, [u, v]) => (read(u), read(v)),
            _ => (light.lu, light.lv),
        }
    }

    /// The header with the numbers that such a reader finds in it.
    pub fn apply(self, ptm: &mut Ptm, witness: &Witness) {
        let lists = (0..LISTS.len()).filter(|&list| match self.of {
            Of::Header | Of::HeaderAndLight => true,
            Of::List(only) => only == list,
            Of::Light => false,
        });
        for list in lists {
            let values =
                texts(witness, list).map(|text| READERS[self.reader].1(&Written::of(text)));
            let numbers: &mut [f64] = match (list, &mut ptm.planes.shape) {
                (0, _) => &mut ptm.header.scale_bias.scale,
                (1, _) => &mut ptm.header.scale_bias.bias,
                (_, Shape::Lum(matrix)) => &mut matrix.0,
                _ => continue,
            };
            for (number, value) in numbers.iter_mut().zip(values) {
                *number = value;
            }
        }
    }

    /// As a sentence without its subject.
    pub fn says(self) -> String {
        let says = READERS[self.reader].0;
        match self.of {
            Of::Header => says.to_owned(),
            Of::List(list) => format!("{says}, in {}", LISTS[list].1),
            Of::Light => format!("{says}, in the light that was asked for"),
            Of::HeaderAndLight => {
                format!("{says}, in the header and in the light that was asked for")
            }
        }
    }

    pub fn clause(self) -> &'static str {
        match self.of {
            Of::Header | Of::HeaderAndLight => LISTS[0].0,
            Of::List(list) => LISTS[list].0,
            Of::Light => "1.0/2",
        }
    }
}

/// Texts of numbers, and which other numbers are read in their places.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::diagnose) struct OtherNumbers(Vec<(usize, String, f64)>);

/// Decimals of another number: those of numbers cut off would be shown cut off twice.
const DIGITS: usize = 8;
/// How many of them are listed.
const LISTED: usize = 4;

impl OtherNumbers {
    /// What was used for scales and biases of these files: nothing where a text stood for different numbers.
    pub fn of<'w>(used: impl Iterator<Item = (&'w Witness<'w>, Used)>) -> Option<OtherNumbers> {
        let mut all = Vec::new();
        for (witness, used) in used {
            let list = usize::from(used.is_bias());
            let text = texts(witness, list).nth(used.coefficient)?;
            let same = |(of, known, _): &&(usize, String, f64)| *of == list && *known == text;
            match all.iter().find(same) {
                Some((_, _, known)) if !is_close(*known, used.value, 0.0) => return None,
                Some(_) => {}
                None => all.push((list, text.to_owned(), used.value)),
            }
        }
        (!all.is_empty()).then_some(OtherNumbers(all))
    }

    /// The header with these numbers.
    pub fn apply(&self, ptm: &mut Ptm, witness: &Witness) {
        let ScaleBias { scale, bias } = &mut ptm.header.scale_bias;
        for (list, numbers) in [scale, bias].into_iter().enumerate() {
            for (number, text) in numbers.iter_mut().zip(texts(witness, list)) {
                let same = |(of, known, _): &&(usize, String, f64)| *of == list && known == text;
                if let Some((_, _, other)) = self.0.iter().find(same) {
                    *number = *other;
                }
            }
        }
    }

    /// As a sentence without its subject.
    pub fn says(&self) -> String {
        let lists = [0, 1].map(|list| {
            let of = self.0.iter().filter(|(of, ..)| *of == list);
            let some = of.map(|(_, text, value)| {
                let right = text.parse().unwrap_or_default();
                format!("{} for {text}", apart(*value, right, DIGITS)[0])
            });
            let some: Vec<String> = some.take(LISTED).collect();
            (!some.is_empty()).then(|| {
                format!(
                    "other {} than the header's: {}",
                    LISTS[list].1,
                    some.join(", ")
                )
            })
        });
        let lists: Vec<String> = lists.into_iter().flatten().collect();
        format!("uses {}", lists.join("; and "))
    }

    pub fn clause(&self) -> &'static str {
        let first = self.0.iter().map(|(list, ..)| *list).min();
        LISTS[first.unwrap_or_default()].0
    }
}

/// The texts of a list of numbers in a header.
fn texts<'w>(witness: &'w Witness, list: usize) -> impl Iterator<Item = &'w str> {
    let file = &witness.built.file;
    let of = witness
        .fields()
        .iter()
        .filter(move |field| field.clause == LISTS[list].0);
    of.filter_map(|field| std::str::from_utf8(file.get(field.range.clone())?).ok())
}

#[cfg(test)]
mod tests {
    use super::{READERS, Written};

    #[test]
    fn each_reader_makes_of_its_example_what_it_says() {
        let read = |says: &str, text: &str| {
            let reader = READERS.iter().find(|(known, _)| known.starts_with(says));
            reader.expect("a reader").1(&Written::of(text))
        };
        assert_eq!(read("loses the sign of numbers between", "-0.5"), 0.5);
        assert_eq!(read("loses the sign of numbers between", "-1.5"), -1.5);
        assert_eq!(read("adds the fraction of negative", "-1.5"), -0.5);
        assert_eq!(read("loses zeros behind", "0.05"), 0.5);
        assert_eq!(read("keeps the whole part", "1.5"), 1.0);
        assert_eq!(read("keeps six characters", "1.234567"), 1.2345);
        assert_eq!(read("reads numbers with leading zeros", "010"), 8.0);
        assert_eq!(read("loses the sign of an exponent", "1e-2"), 100.0);
        assert_eq!(read("takes the exponent one too large", "1e2"), 1000.0);
        assert_eq!(read("takes the exponent one too large", "12"), 12.0);
        assert_eq!(read("rounds numbers to two", "0.015625"), 0.02);
        assert_eq!(
            read("cuts numbers to multiples of 1/256", "-0.1"),
            -25.0 / 256.0
        );
        assert_eq!(read("keeps numbers in half", "0.1"), 0.099_975_585_937_5);
        assert_eq!(
            read("ignores the exponent of a number without", "5e-1"),
            5.0
        );
        assert_eq!(
            read("ignores the exponent of a number without", "5.0e-1"),
            0.5
        );
    }
}
