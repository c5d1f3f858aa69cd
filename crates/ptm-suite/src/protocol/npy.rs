//! NumPy arrays: `\x93NUMPY`, a version, the length of the header, and the header, which is a Python dictionary with `descr`,
//! `fortran_order` and `shape`. The shape is (height, width, channels), the type is `u1` or `<f4`, and the order is C order.

use crate::error::{Error, Result};
use crate::protocol::frame::{Frame, Samples, ViewKind};
use ptm::error::byte_count;

/// Parses a complete `.npy` file as a frame of `view`.
///
/// # Errors
/// Returns the reason why the array is not a frame.
pub fn read(bytes: &[u8], view: ViewKind) -> Result<Frame> {
    let (header, data) = split(bytes)?;
    let NpyHeader {
        descr,
        fortran_order,
        shape,
    } = NpyHeader::parse(header)?;
    if fortran_order {
        return Error::invalid("the samples are in Fortran order; save numpy.ascontiguousarray(a)");
    }
    let is_float = match descr.as_str() {
        "|u1" | "<u1" | "u1" | "|B" => false,
        "<f4" => true,
        ">f4" => {
            return Error::invalid(
                "the samples are f32 with the high byte first; save a.astype('<f4')",
            );
        }
        "<f8" | ">f8" => {
            let wanted = if view == ViewKind::Coef { "<f4" } else { "u1" };
            return Error::invalid(format!("the samples are f64; save a.astype('{wanted}')"));
        }
        other => {
            return Error::invalid(format!(
                "the type is {other:?}; expected '|u1' for raw and rgb, or '<f4' for coef"
            ));
        }
    };
    let [height, width, channels] = shape[..] else {
        return Error::invalid(format!(
            "the shape has {} numbers; expected (height, width, channels)",
            shape.len()
        ));
    };
    let shape = [width, height, channels];
    let samples = Samples::parse(is_float, shape, data).map_err(|needed| {
        format!(
            "shape ({height}, {width}, {channels}) of {descr} needs {}, {} follow",
            byte_count(needed),
            data.len()
        )
    })?;
    Ok(Frame::exact(view, shape, samples))
}

fn split(bytes: &[u8]) -> Result<(&str, &[u8])> {
    let truncated = || "the file ends within its header".to_owned();
    let version = bytes.get(6..8).ok_or_else(truncated)?;
    let (length, start) = match (version, bytes.get(8..10), bytes.get(8..12)) {
        ([1, 0], Some(length), _) => (usize::from(u16::from_le_bytes([length[0], length[1]])), 10),
        ([2 | 3, 0], _, Some(length)) => {
            let length = [length[0], length[1], length[2], length[3]];
            (u32::from_le_bytes(length) as usize, 12)
        }
        ([1..=3, 0], ..) => return Err(truncated().into()),
        _ => {
            return Error::invalid(format!(
                "the version is {}.{}; supported versions are 1.0, 2.0 and 3.0",
                version[0], version[1]
            ));
        }
    };
    let end = start + length;
    let header = bytes.get(start..end).ok_or_else(truncated)?;
    let header = std::str::from_utf8(header).map_err(|_| "the header is not text")?;
    let header = header
        .strip_suffix('\n')
        .ok_or("the header does not end in a line feed")?;
    Ok((header, &bytes[end..]))
}

struct NpyHeader {
    descr: String,
    fortran_order: bool,
    shape: Vec<u32>,
}

impl NpyHeader {
    fn parse(text: &str) -> Result<NpyHeader> {
        let mut rest = DictionaryText(text);
        let (mut descr, mut fortran_order, mut shape) = (None, None, None);
        rest.expect("{")?;
        while !rest.accept("}") {
            let key = rest.parse_string()?;
            rest.expect(":")?;
            let is_new = match key {
                "descr" => descr.replace(rest.parse_string()?.to_owned()).is_none(),
                "fortran_order" => fortran_order.replace(rest.boolean()?).is_none(),
                "shape" => shape.replace(rest.tuple()?).is_none(),
                other => return Error::invalid(format!("the header has an unknown key {other:?}")),
            };
            if !is_new {
                return Error::invalid(format!("the header has {key:?} twice"));
            }
            if !rest.accept(",") {
                rest.expect("}")?;
                break;
            }
        }
        if !rest.0.trim_start_matches(' ').is_empty() {
            return Error::invalid(format!("the header continues after the dictionary: {rest}"));
        }
        match (descr, fortran_order, shape) {
            (Some(descr), Some(fortran_order), Some(shape)) => Ok(NpyHeader {
                descr,
                fortran_order,
                shape,
            }),
            _ => Error::invalid("the header lacks one of descr, fortran_order and shape"),
        }
    }
}

/// The unread part of the header dictionary.
struct DictionaryText<'a>(&'a str);

impl<'a> DictionaryText<'a> {
    fn accept(&mut self, token: &str) -> bool {
        let text = self.0.trim_start_matches(' ');
        let rest = text.strip_prefix(token);
        self.0 = rest.unwrap_or(text);
        rest.is_some()
    }

    fn expect(&mut self, token: &str) -> Result<()> {
        if self.accept(token) {
            Ok(())
        } else {
            Error::invalid(format!("expected {token:?} before {self} in the header"))
        }
    }

    /// Parses a quoted string without escapes.
    fn parse_string(&mut self) -> Result<&'a str> {
        let quote = ["'", "\""].into_iter().find(|quote| self.accept(quote));
        let quote =
            quote.ok_or_else(|| format!("expected a string in the header, found {self}"))?;
        let (string, rest) = self
            .0
            .split_once(quote)
            .ok_or_else(|| format!("the header has a string without an end: {self}"))?;
        self.0 = rest;
        Ok(string)
    }

    fn boolean(&mut self) -> Result<bool> {
        match (self.accept("False"), self.accept("True")) {
            (true, false) => Ok(false),
            (false, true) => Ok(true),
            _ => Error::invalid(format!("fortran_order is neither True nor False: {self}")),
        }
    }

    fn tuple(&mut self) -> Result<Vec<u32>> {
        let mut numbers = Vec::new();
        self.expect("(")?;
        while !self.accept(")") {
            let digits = self.0.bytes().take_while(u8::is_ascii_digit).count();
            let (word, rest) = self.0.split_at(digits);
            let number = word
                .parse()
                .map_err(|_| format!("expected a number before {self} in the shape"))?;
            numbers.push(number);
            self.0 = rest;
            if !self.accept(",") {
                self.expect(")")?;
                break;
            }
        }
        Ok(numbers)
    }
}

impl std::fmt::Display for DictionaryText<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let beginning: String = self.0.chars().take(24).collect();
        write!(f, "{beginning:?}")
    }
}
