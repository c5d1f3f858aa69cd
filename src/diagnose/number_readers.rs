//! Numbers of the header read otherwise than as decimal numbers: what parsers of one's own make of them.

use super::witness::Witness;
use crate::ptm::{Ptm, Shape};

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
];

/// The lists of numbers in a header: their clauses and their names.
const LISTS: [(&str, &str); 3] = [
    ("2.4/3", "scales"),
    ("2.4/4", "biases"),
    ("2.6/2", "elements of the matrix"),
];

/// Numbers of one list, or of all, read otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct NumberReader {
    reader: usize,
    /// Of which list; of all without it.
    list: Option<usize>,
}

impl NumberReader {
    /// All of them.
    pub fn all() -> impl Iterator<Item = NumberReader> {
        let lists = [None, Some(0), Some(1), Some(2)].into_iter();
        lists.flat_map(|list| (0..READERS.len()).map(move |reader| NumberReader { reader, list }))
    }

    /// The header with the numbers that such a reader finds in it.
    pub fn apply(self, ptm: &mut Ptm, witness: &Witness) {
        let file = &witness.built.file;
        let lists = (0..LISTS.len()).filter(|&list| self.list.is_none_or(|only| only == list));
        for list in lists {
            let of = witness
                .fields()
                .iter()
                .filter(|field| field.clause == LISTS[list].0);
            let texts =
                of.filter_map(|field| std::str::from_utf8(file.get(field.range.clone())?).ok());
            let values = texts.map(|text| READERS[self.reader].1(&Written::of(text)));
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
        match self.list {
            Some(list) => format!("{says}, in {}", LISTS[list].1),
            None => says.to_owned(),
        }
    }

    pub fn clause(self) -> &'static str {
        LISTS[self.list.unwrap_or_default()].0
    }
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
    }
}
