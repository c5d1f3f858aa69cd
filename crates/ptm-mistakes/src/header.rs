//! §2.0–2.3: mistakes in reading the header, and in parsing the numbers of §2.4

use super::anatomy::{ANY, Anatomy, EditedFile};
use super::change::{Change, Changes};

const SIZE: &str = "2.3/1";
const SCALE: &str = "2.4/3";
const BIAS: &str = "2.4/4";

pub const CHANGES: Changes = |slug| {
    let edit: fn(&Anatomy) -> EditedFile = match slug {
        "greedy-whitespace" => |f| skip_payload_bytes(f, |b| matches!(b, b'\t'..=b'\r' | b' ')),
        "greedy-line-feeds" => |f| skip_payload_bytes(f, |b| b == b'\n'),
        "greedy-line-ends" => |f| skip_payload_bytes(f, |b| matches!(b, b'\n' | b'\r')),
        "greedy-blanks" => |f| skip_payload_bytes(f, |b| matches!(b, b' ' | b'\t')),
        "carriage-return-skipped" => |f| match f.payload() {
            [b'\r', rest @ ..] => f.with_payload(rest),
            _ => f.unchanged(),
        },
        "no-space-before-newline" => |f| f.refuse_if(header_contains(f, b" \n")),
        "names-compared-with-their-space" => {
            |f| f.refuse_if(ends_with_space(f, "2.1/1", 0) || ends_with_space(f, "2.2/1", 0))
        }
        "no-space-behind-the-size" => {
            |f| f.refuse_if(ends_with_space(f, SIZE, 0) || ends_with_space(f, SIZE, 1))
        }
        "no-space-behind-scale-and-bias" => {
            |f| f.refuse_if(ends_with_space(f, SCALE, 5) || ends_with_space(f, BIAS, 5))
        }
        "version-with-space-is-1.1" => |f| {
            if ends_with_space(f, "2.1/1", 0) {
                deinterleave_payload(f)
            } else {
                f.unchanged()
            }
        },
        "payload-offset-by-line-lengths" => |f| {
            let ends = f.header().windows(2).filter(|pair| *pair == b" \n");
            f.with_payload(&f.file[f.payload_offset() - ends.count()..])
        },
        "text-mode" => |f| EditedFile::File(without_carriage_returns(f.file)),
        "text-mode-end-of-file" => |f| {
            let end = f.file.iter().position(|&byte| byte == 0x1a);
            EditedFile::File(f.file[..end.unwrap_or(f.file.len())].to_vec())
        },
        "text-mode-universal" => |f| {
            let mut bytes = without_carriage_returns(f.file);
            let other_ends = bytes.iter_mut().filter(|byte| **byte == b'\r');
            other_ends.for_each(|byte| *byte = b'\n');
            EditedFile::File(bytes)
        },
        "white-space-at-the-end-stripped" => |f| EditedFile::File(f.file.trim_ascii_end().to_vec()),
        "zeros-at-the-end-trimmed" => |f| {
            let end = f.file.iter().rposition(|&byte| byte != 0);
            EditedFile::File(f.file[..end.map_or(0, |last| last + 1)].to_vec())
        },
        "version-unchecked" => |f| f.respell(&["2.1/1"], |_| Some("PTM_1.2".to_owned())),
        "version-by-prefix" => |f| f.respell(&["2.1/1"], |text| shorten(text, "PTM_1.2")),
        "version-1.x-accepted" => |f| {
            f.respell(&["2.1/1"], |text| {
                text.starts_with("PTM_1.").then(|| "PTM_1.2".to_owned())
            })
        },
        "format-by-beginning" => |f| f.respell(&["2.2/1"], |text| shorten(text, "PTM_FORMAT_LRGB")),
        "format-in-any-case" => |f| f.respell(&["2.2/1"], |text| Some(text.to_uppercase())),
        "size-two-lines-only" => |f| f.refuse_if(!f.bytes_after(SIZE, 0).contains(&b'\n')),
        "size-one-line-only" => |f| f.refuse_if(f.bytes_after(SIZE, 0).contains(&b'\n')),
        "scale-bias-two-lines-only" => |f| f.refuse_if(!f.bytes_after(SCALE, 5).contains(&b'\n')),
        "scale-bias-one-line-only" => |f| f.refuse_if(f.bytes_after(SCALE, 5).contains(&b'\n')),
        "double-space-dies" => |f| f.refuse_if(header_contains(f, b"  ")),
        "double-space-is-zero" => |f| {
            if header_contains(f, b"  ") {
                f.respell(&[SCALE, BIAS], |_| Some("0".to_owned()))
            } else {
                f.unchanged()
            }
        },
        "last-number-needs-space" => |f| {
            let mut bytes = f.file.to_vec();
            // Change the biases first, so that the offsets of the scales stay valid.
            for clause in [BIAS, SCALE] {
                if let (Some(field), b"\n") = (f.nth_field(clause, 5), f.bytes_after(clause, 5)) {
                    bytes.splice(field.range.clone(), *b"0");
                }
            }
            EditedFile::File(bytes)
        },
        "line-buffer" => |f| f.refuse_if(longest_line(f) > 255),
        "short-line-buffer" => |f| f.refuse_if(longest_line(f) > 79),
        "sizes-of-four-digits" => |f| f.respell(&[SIZE], |text| text.get(..4).map(str::to_owned)),
        "leading-zero-is-octal" => |f| {
            f.respell(&[SIZE, BIAS], |text| {
                let octal = || i64::from_str_radix(text, 8).map(|value| value.to_string());
                has_leading_zero(text).then(|| octal().unwrap_or_default())
            })
        },
        "leading-zeros-refused" => |f| f.refuse_text(&[SIZE, BIAS], has_leading_zero),
        "sign-ignored-in-sizes" => |f| {
            f.respell(&[SIZE], |text| {
                Some(text.trim_start_matches('-').to_owned())
            })
        },
        "sizes-wrap-at-32-bits" => |f| {
            f.respell(&[SIZE], |text| {
                let value: u64 = text.parse().ok()?;
                Some((value as u32).to_string()).filter(|_| value > u32::MAX.into())
            })
        },
        "sizes-wrap-at-64-bits" => |f| {
            f.respell(&[SIZE], |text| {
                let value: u128 = text.parse().ok()?;
                Some((value as u64).to_string()).filter(|_| value > u64::MAX.into())
            })
        },
        "exponent-ignored" => |f| f.respell(&[SCALE], |text| text_before(text, &['e', 'E'])),
        "exponent-refused" => |f| f.refuse_text(&[SCALE], |text| text.contains(['e', 'E'])),
        "capital-exponent-refused" => |f| f.refuse_text(&[SCALE], |text| text.contains('E')),
        "plus-sign-refused" => |f| f.refuse_text(&[SCALE, BIAS], |text| text.starts_with('+')),
        "leading-point-refused" => |f| {
            f.refuse_text(&[SCALE], |text| {
                text.trim_start_matches(['+', '-']).starts_with('.')
            })
        },
        "trailing-point-refused" => |f| f.refuse_text(&[SCALE], |text| text.ends_with('.')),
        "scale-needs-a-point" => |f| f.refuse_text(&[SCALE], |text| !text.contains('.')),
        "numbers-as-integers" => |f| f.respell(&[SCALE, "2.6/2"], as_integer),
        "scale-to-the-point" => |f| {
            f.respell(&[SCALE], |text| {
                let whole = text_before(text, &['.'])?;
                let is_zero = whole.trim_start_matches(['+', '-']).is_empty();
                Some(if is_zero { "0".to_owned() } else { whole })
            })
        },
        "scale-with-six-characters" => {
            |f| f.respell(&[SCALE], |text| text.get(..6).map(str::to_owned))
        }
        "negative-scale-refused" => |f| f.refuse_text(&[SCALE], |text| text.starts_with('-')),
        "zero-scale-refused" => |f| f.refuse_text(&[SCALE], |text| text.parse() == Ok(0.0)),
        "negative-bias-refused" => |f| f.refuse_text(&[BIAS], |text| text.starts_with('-')),
        "large-bias-refused" => |f| {
            f.refuse_text(&[BIAS], |text| {
                text.parse().is_ok_and(|bias: f64| bias > 255.0)
            })
        },
        "bias-fraction-cut" => |f| f.respell(&[BIAS], |text| text_before(text, &['.'])),
        "numbers-by-prefix" => |f| {
            f.respell(&[SIZE, SCALE, BIAS, "2.6/2", "2.5/2"], |text| {
                text.parse::<f64>().is_err().then(|| number_prefix(text))
            })
        },
        "numbers-left-unread" => leave_numbers_unread,
        "not-a-number-accepted" => {
            |f| f.respell(ANY, |text| (text == "nan").then(|| "0".to_owned()))
        }
        "infinity-accepted" => |f| {
            f.respell(ANY, |text| {
                let is_infinite = text.trim_start_matches('-').starts_with("inf");
                is_infinite.then(|| "1e300".to_owned())
            })
        },
        "overflow-accepted" => |f| {
            f.respell(&[SCALE], |text| {
                (text == "1e400").then(|| "1e300".to_owned())
            })
        },
        "hexadecimal-accepted" => |f| {
            f.respell(ANY, |text| {
                let value = || u32::from_str_radix(text.strip_prefix("0x")?, 16).ok();
                let half = (text == "0x1p-1").then(|| "0.5".to_owned());
                half.or_else(|| Some(value()?.to_string()))
            })
        },
        "short-payload-padded" => {
            |f| EditedFile::File([f.file, &vec![0; f.file.len() + 4096]].concat())
        }
        "header-ends-at-its-last-space" => |f| match f.header().strip_suffix(b" \n") {
            Some(header) => EditedFile::File([header, b"\n", &f.file[header.len() + 1..]].concat()),
            None => f.unchanged(),
        },
        _ => return None,
    };
    Some(Change::Bytes(edit))
};

fn header_contains(file: &Anatomy, bytes: &[u8]) -> bool {
    file.header().windows(2).any(|pair| pair == bytes)
}

/// Returns true if a space and a line feed follow the `n`th field with this clause.
fn ends_with_space(file: &Anatomy, clause: &str, n: usize) -> bool {
    file.bytes_after(clause, n) == b" \n"
}

fn longest_line(file: &Anatomy) -> usize {
    let lines = file.header().split(|&byte| byte == b'\n').map(<[u8]>::len);
    lines.max().unwrap_or_default()
}

fn has_leading_zero(text: &str) -> bool {
    text.len() > 1 && text.starts_with('0')
}

fn shorten(text: &str, known: &str) -> Option<String> {
    text.starts_with(known).then(|| known.to_owned())
}

/// Returns the part of `text` before the first character that is in `ends`, if there is such a character.
fn text_before(text: &str, ends: &[char]) -> Option<String> {
    Some(text.split_once(ends)?.0.to_owned())
}

/// Removes carriage returns before line feeds.
fn without_carriage_returns(bytes: &[u8]) -> Vec<u8> {
    let is_kept = |i: &usize| !bytes[*i..].starts_with(b"\r\n");
    (0..bytes.len()).filter(is_kept).map(|i| bytes[i]).collect()
}

/// Removes the bytes at the start of the payload that `skip` accepts as whitespace, unless the header is malformed.
fn skip_payload_bytes(file: &Anatomy, skip: fn(u8) -> bool) -> EditedFile {
    if file.nth_field(BIAS, 5).is_none() {
        return file.unchanged();
    }
    let skipped = file.payload().iter().take_while(|&&byte| skip(byte));
    file.with_payload(&file.payload()[skipped.count()..])
}

/// Converts an LRGB payload from interleaved texels to blocks, so that a correct decoder reads the payload as interleaved.
fn deinterleave_payload(file: &Anatomy) -> EditedFile {
    if file.field_texts(&["2.2/1"]) != ["PTM_FORMAT_LRGB"] {
        return file.unchanged();
    }
    let texels = || file.payload().chunks_exact(9);
    let (first, second) = (
        texels().flat_map(|texel| &texel[..6]),
        texels().flat_map(|texel| &texel[6..]),
    );
    EditedFile::File(
        file.header()
            .iter()
            .chain(first)
            .chain(second)
            .copied()
            .collect(),
    )
}

/// Rewrites an uncompressed file as `fscanf` reads it if its result is ignored: the first text that is no number, and everything
/// after it, is the payload. The numbers that are not read are 0. Whitespace after a number is skipped.
fn leave_numbers_unread(file: &Anatomy) -> EditedFile {
    let Some(format) = file.nth_field("2.2/1", 0) else {
        return file.unchanged();
    };
    let name = &file.file[format.range.clone()];
    let channels = match name {
        b"PTM_FORMAT_RGB" => 18,
        b"PTM_FORMAT_LRGB" => 9,
        b"PTM_FORMAT_LUM" => 8,
        _ => return file.unchanged(),
    };
    let mut rest = file.file[format.range.end..].trim_ascii_start();
    let mut numbers = Vec::new();
    for i in 0..14 {
        let is_integer = !(2..8).contains(&i);
        let Some((number, length)) = scan_number(rest, is_integer) else {
            break;
        };
        numbers.push(number);
        rest = rest[length..].trim_ascii_start();
    }
    let size: Vec<usize> = numbers
        .iter()
        .take(2)
        .filter_map(|text| text.parse().ok())
        .collect();
    let ([width, height], true) = (&size[..], numbers.len() < 14) else {
        return file.unchanged();
    };
    let payload = width.saturating_mul(*height).saturating_mul(channels);
    let is_lum = channels == 8;
    numbers.resize(if is_lum { 30 } else { 14 }, "0".to_owned());
    let lines = [
        &numbers[..1],
        &numbers[1..2],
        &numbers[2..8],
        &numbers[8..14],
        &numbers[14..],
    ];
    let mut header = file.file[..format.range.end].to_vec();
    for line in lines.iter().filter(|line| !line.is_empty()) {
        header.extend_from_slice(b"\n");
        header.extend_from_slice(line.join(" ").as_bytes());
    }
    header.extend_from_slice(b"\n");
    let payload = &rest[..rest.len().min(payload)];
    EditedFile::File([&header, payload].concat())
}

/// Returns the number at the start of a text, as `fscanf` reads it, and its length.
fn scan_number(text: &[u8], is_integer: bool) -> Option<(String, usize)> {
    let number = |length: usize| {
        let text = std::str::from_utf8(&text[..length]).ok()?;
        let hexadecimal = || u32::from_str_radix(text.strip_prefix("0x")?, 16).ok();
        let has_no_exponent = || {
            let digits = text.strip_suffix('e');
            digits.is_some_and(|digits| digits.parse::<f64>().is_ok())
        };
        let value = if is_integer {
            text.parse::<i64>().ok()?;
            text.to_owned()
        } else if text.parse::<f64>().is_ok_and(f64::is_finite) {
            text.to_owned()
        } else if text.parse::<f64>().is_ok_and(f64::is_infinite) {
            "1e300".to_owned()
        } else if text == "nan" || text == "." || has_no_exponent() {
            // Part of a number is consumed although it has no value.
            "0".to_owned()
        } else if text == "0x1p-1" {
            "0.5".to_owned()
        } else {
            hexadecimal()?.to_string()
        };
        Some((value, length))
    };
    let word = text.iter().position(u8::is_ascii_whitespace);
    (1..=word.unwrap_or(text.len())).rev().find_map(number)
}

/// Returns a number as `atoi` reads it, unless it is an integer.
fn as_integer(text: &str) -> Option<String> {
    text.parse::<f64>()
        .ok()
        .filter(|number| number.is_finite())?;
    let (sign, digits) = match text.split_at_checked(1)? {
        ("-", digits) => ("-", digits),
        ("+", digits) => ("", digits),
        _ => ("", text),
    };
    let end = digits.find(|c: char| !c.is_ascii_digit());
    let digits = &digits[..end.unwrap_or(digits.len())];
    let integer = if digits.is_empty() {
        "0".to_owned()
    } else {
        format!("{sign}{digits}")
    };
    (integer != text).then_some(integer)
}

/// Returns the longest prefix that is a number, or "0".
fn number_prefix(text: &str) -> String {
    let mut prefixes = (1..=text.len()).rev().filter_map(|end| text.get(..end));
    let number = prefixes.find(|prefix| prefix.parse::<f64>().is_ok_and(f64::is_finite));
    number.unwrap_or("0").to_owned()
}
