//! §2.0–2.3: mistakes with the header, and with the spelling of numbers in §2.4

use super::anatomy::{Anatomy, EditedFile};
use super::at::At;

const SCALE: &str = "2.4/3";
const BIAS: &str = "2.4/4";

pub(super) const CHANGES: &[(&str, At)] = &[
    (
        "greedy-whitespace",
        At::Bytes(|file| skip_payload_bytes(file, |byte| matches!(byte, b'\t'..=b'\r' | b' '))),
    ),
    (
        "greedy-line-feeds",
        At::Bytes(|file| skip_payload_bytes(file, |byte| byte == b'\n')),
    ),
    (
        "greedy-line-ends",
        At::Bytes(|file| skip_payload_bytes(file, |byte| matches!(byte, b'\n' | b'\r'))),
    ),
    (
        "greedy-blanks",
        At::Bytes(|file| skip_payload_bytes(file, |byte| matches!(byte, b' ' | b'\t'))),
    ),
    (
        "carriage-return-skipped",
        At::Bytes(|file| match file.file.get(file.payload_offset()) {
            Some(b'\r') => remove_payload_bytes(file, 1),
            _ => file.unchanged(),
        }),
    ),
    (
        "no-space-before-newline",
        At::Bytes(|file| file.refuse_if(file.header().windows(2).any(|pair| pair == b" \n"))),
    ),
    (
        "names-compared-with-their-space",
        At::Bytes(|file| {
            file.refuse_if(
                file.bytes_after("2.1/1", 0) == b" \n" || file.bytes_after("2.2/1", 0) == b" \n",
            )
        }),
    ),
    (
        "no-space-behind-the-size",
        At::Bytes(|file| {
            file.refuse_if(
                file.bytes_after("2.3/1", 0) == b" \n" || file.bytes_after("2.3/1", 1) == b" \n",
            )
        }),
    ),
    (
        "no-space-behind-scale-and-bias",
        At::Bytes(|file| {
            file.refuse_if(
                file.bytes_after(SCALE, 5) == b" \n" || file.bytes_after(BIAS, 5) == b" \n",
            )
        }),
    ),
    (
        "version-with-space-is-1.1",
        At::Bytes(|file| {
            if file.bytes_after("2.1/1", 0) == b" \n" {
                deinterleave_payload(file)
            } else {
                file.unchanged()
            }
        }),
    ),
    (
        "payload-offset-by-line-lengths",
        At::Bytes(|file| {
            let spaces = file
                .header()
                .windows(2)
                .filter(|pair| *pair == b" \n")
                .count();
            let payload = file.payload_offset();
            EditedFile::File([file.header(), &file.file[payload - spaces..]].concat())
        }),
    ),
    (
        "text-mode",
        At::Bytes(|file| {
            let mut bytes = Vec::new();
            for (i, &byte) in file.file.iter().enumerate() {
                if byte != b'\r' || file.file.get(i + 1) != Some(&b'\n') {
                    bytes.push(byte);
                }
            }
            EditedFile::File(bytes)
        }),
    ),
    (
        "text-mode-end-of-file",
        At::Bytes(|file| {
            EditedFile::File(
                file.file
                    .split(|&byte| byte == 0x1a)
                    .next()
                    .unwrap_or_default()
                    .to_vec(),
            )
        }),
    ),
    (
        "text-mode-universal",
        At::Bytes(|file| {
            let mut bytes = Vec::new();
            for (i, &byte) in file.file.iter().enumerate() {
                match byte {
                    b'\r' if file.file.get(i + 1) == Some(&b'\n') => {}
                    b'\r' => bytes.push(b'\n'),
                    _ => bytes.push(byte),
                }
            }
            EditedFile::File(bytes)
        }),
    ),
    (
        "white-space-at-the-end-stripped",
        At::Bytes(|file| EditedFile::File(file.file.trim_ascii_end().to_vec())),
    ),
    (
        "zeros-at-the-end-trimmed",
        At::Bytes(|file| {
            let end = file.file.iter().rposition(|&byte| byte != 0);
            EditedFile::File(file.file[..end.map_or(0, |last| last + 1)].to_vec())
        }),
    ),
    (
        "version-unchecked",
        At::Bytes(|file| {
            file.respell(|clause, _| (clause == "2.1/1").then(|| "PTM_1.2".to_owned()))
        }),
    ),
    (
        "version-by-prefix",
        At::Bytes(|file| {
            file.respell(|clause, text| {
                (clause == "2.1/1" && text.starts_with("PTM_1.2")).then(|| "PTM_1.2".to_owned())
            })
        }),
    ),
    (
        "version-1.x-accepted",
        At::Bytes(|file| {
            file.respell(|clause, text| {
                (clause == "2.1/1" && text.starts_with("PTM_1.")).then(|| "PTM_1.2".to_owned())
            })
        }),
    ),
    (
        "format-by-beginning",
        At::Bytes(|file| {
            file.respell(|clause, text| {
                (clause == "2.2/1" && text.starts_with("PTM_FORMAT_LRGB"))
                    .then(|| "PTM_FORMAT_LRGB".to_owned())
            })
        }),
    ),
    (
        "format-in-any-case",
        At::Bytes(|file| {
            file.respell(|clause, text| (clause == "2.2/1").then(|| text.to_uppercase()))
        }),
    ),
    (
        "size-two-lines-only",
        At::Bytes(|file| file.refuse_if(!file.bytes_after("2.3/1", 0).contains(&b'\n'))),
    ),
    (
        "size-one-line-only",
        At::Bytes(|file| file.refuse_if(file.bytes_after("2.3/1", 0).contains(&b'\n'))),
    ),
    (
        "scale-bias-two-lines-only",
        At::Bytes(|file| file.refuse_if(!file.bytes_after(SCALE, 5).contains(&b'\n'))),
    ),
    (
        "scale-bias-one-line-only",
        At::Bytes(|file| file.refuse_if(file.bytes_after(SCALE, 5).contains(&b'\n'))),
    ),
    (
        "double-space-dies",
        At::Bytes(|file| file.refuse_if(file.header().windows(2).any(|pair| pair == b"  "))),
    ),
    (
        "double-space-is-zero",
        At::Bytes(|file| {
            if !file.header().windows(2).any(|pair| pair == b"  ") {
                return file.unchanged();
            }
            file.respell(|clause, _| (clause == SCALE || clause == BIAS).then(|| "0".to_owned()))
        }),
    ),
    (
        "last-number-needs-space",
        At::Bytes(|file| {
            let mut bytes = file.file.to_vec();
            // Change the biases first, so that the offsets of the scales stay valid.
            for clause in [BIAS, SCALE] {
                if let (Some(field), b"\n") =
                    (file.nth_field(clause, 5), file.bytes_after(clause, 5))
                {
                    bytes.splice(field.range.clone(), *b"0");
                }
            }
            EditedFile::File(bytes)
        }),
    ),
    (
        "line-buffer",
        At::Bytes(|file| {
            file.refuse_if(
                file.header()
                    .split(|&byte| byte == b'\n')
                    .any(|line| line.len() > 255),
            )
        }),
    ),
    (
        "short-line-buffer",
        At::Bytes(|file| {
            file.refuse_if(
                file.header()
                    .split(|&byte| byte == b'\n')
                    .any(|line| line.len() > 79),
            )
        }),
    ),
    (
        "sizes-of-four-digits",
        At::Bytes(|file| {
            file.respell(|clause, text| {
                text.get(..4)
                    .filter(|_| clause == "2.3/1")
                    .map(str::to_owned)
            })
        }),
    ),
    (
        "leading-zero-is-octal",
        At::Bytes(|file| {
            file.respell(|clause, text| {
                let octal =
                    matches!(clause, "2.3/1" | BIAS) && text.len() > 1 && text.starts_with('0');
                octal
                    .then(|| {
                        i64::from_str_radix(text, 8)
                            .map(|value| value.to_string())
                            .unwrap_or_default()
                    })
                    .filter(|t| t != text)
            })
        }),
    ),
    (
        "leading-zeros-refused",
        At::Bytes(|file| {
            file.refuse_if(
                file.field_texts(&["2.3/1", BIAS])
                    .iter()
                    .any(|text| text.len() > 1 && text.starts_with('0')),
            )
        }),
    ),
    (
        "sign-ignored-in-sizes",
        At::Bytes(|file| {
            file.respell(|clause, text| {
                (clause == "2.3/1").then(|| text.trim_start_matches('-').to_owned())
            })
        }),
    ),
    (
        "sizes-wrap-at-32-bits",
        At::Bytes(|file| {
            file.respell(|clause, text| {
                let value = text
                    .parse::<u64>()
                    .ok()
                    .filter(|value| clause == "2.3/1" && *value > u64::from(u32::MAX));
                value.map(|value| (value as u32).to_string())
            })
        }),
    ),
    (
        "sizes-wrap-at-64-bits",
        At::Bytes(|file| {
            file.respell(|clause, text| {
                let value = text
                    .parse::<u128>()
                    .ok()
                    .filter(|value| clause == "2.3/1" && *value > u128::from(u64::MAX));
                value.map(|value| (value as u64).to_string())
            })
        }),
    ),
    (
        "exponent-ignored",
        At::Bytes(|file| {
            file.respell(|clause, text| {
                text.split_once(['e', 'E'])
                    .filter(|_| clause == SCALE)
                    .map(|(m, _)| m.to_owned())
            })
        }),
    ),
    (
        "exponent-refused",
        At::Bytes(|file| {
            file.refuse_if(
                file.field_texts(&[SCALE])
                    .iter()
                    .any(|text| text.contains(['e', 'E'])),
            )
        }),
    ),
    (
        "capital-exponent-refused",
        At::Bytes(|file| {
            file.refuse_if(
                file.field_texts(&[SCALE])
                    .iter()
                    .any(|text| text.contains('E')),
            )
        }),
    ),
    (
        "plus-sign-refused",
        At::Bytes(|file| {
            file.refuse_if(
                file.field_texts(&[SCALE, BIAS])
                    .iter()
                    .any(|text| text.starts_with('+')),
            )
        }),
    ),
    (
        "leading-point-refused",
        At::Bytes(|file| {
            file.refuse_if(
                file.field_texts(&[SCALE])
                    .iter()
                    .any(|text| text.trim_start_matches(['+', '-']).starts_with('.')),
            )
        }),
    ),
    (
        "trailing-point-refused",
        At::Bytes(|file| {
            file.refuse_if(
                file.field_texts(&[SCALE])
                    .iter()
                    .any(|text| text.ends_with('.')),
            )
        }),
    ),
    (
        "scale-needs-a-point",
        At::Bytes(|file| {
            file.refuse_if(
                file.field_texts(&[SCALE])
                    .iter()
                    .any(|text| !text.contains('.')),
            )
        }),
    ),
    (
        "scale-to-the-point",
        At::Bytes(|file| {
            file.respell(|clause, text| {
                let (whole, _) = text.split_once('.').filter(|_| clause == SCALE)?;
                Some(if whole.trim_start_matches(['+', '-']).is_empty() {
                    "0".to_owned()
                } else {
                    whole.to_owned()
                })
            })
        }),
    ),
    (
        "scale-with-six-characters",
        At::Bytes(|file| {
            file.respell(|clause, text| {
                text.get(..6).filter(|_| clause == SCALE).map(str::to_owned)
            })
        }),
    ),
    (
        "negative-scale-refused",
        At::Bytes(|file| {
            file.refuse_if(
                file.field_texts(&[SCALE])
                    .iter()
                    .any(|text| text.starts_with('-')),
            )
        }),
    ),
    (
        "zero-scale-refused",
        At::Bytes(|file| {
            file.refuse_if(
                file.field_texts(&[SCALE])
                    .iter()
                    .any(|text| text.parse() == Ok(0.0)),
            )
        }),
    ),
    (
        "negative-bias-refused",
        At::Bytes(|file| {
            file.refuse_if(
                file.field_texts(&[BIAS])
                    .iter()
                    .any(|text| text.starts_with('-')),
            )
        }),
    ),
    (
        "large-bias-refused",
        At::Bytes(|file| {
            file.refuse_if(
                file.field_texts(&[BIAS])
                    .iter()
                    .any(|text| text.parse::<f64>().is_ok_and(|bias| bias > 255.0)),
            )
        }),
    ),
    (
        "bias-fraction-cut",
        At::Bytes(|file| {
            file.respell(|clause, text| {
                text.split_once('.')
                    .filter(|_| clause == BIAS)
                    .map(|(whole, _)| whole.to_owned())
            })
        }),
    ),
    (
        "numbers-by-prefix",
        At::Bytes(|file| {
            file.respell(|clause, text| {
                let numeric = matches!(clause, "2.3/1" | SCALE | BIAS | "2.6/2" | "2.5/2")
                    && text.parse::<f64>().is_err();
                numeric.then(|| number_prefix(text))
            })
        }),
    ),
    (
        "not-a-number-accepted",
        At::Bytes(|file| file.respell(|_, text| (text == "nan").then(|| "0".to_owned()))),
    ),
    (
        "infinity-accepted",
        At::Bytes(|file| {
            file.respell(|_, text| {
                text.trim_start_matches('-')
                    .starts_with("inf")
                    .then(|| "1e300".to_owned())
            })
        }),
    ),
    (
        "overflow-accepted",
        At::Bytes(|file| {
            file.respell(|clause, text| {
                (clause == SCALE && text == "1e400").then(|| "1e300".to_owned())
            })
        }),
    ),
    (
        "hexadecimal-accepted",
        At::Bytes(|file| {
            file.respell(|_, text| match text {
                "0x1p-1" => Some("0.5".to_owned()),
                _ => text
                    .strip_prefix("0x")
                    .and_then(|hex| u32::from_str_radix(hex, 16).ok())
                    .map(|value| value.to_string()),
            })
        }),
    ),
    (
        "short-payload-padded",
        At::Bytes(|file| EditedFile::File([file.file, &vec![0; file.file.len() + 4096]].concat())),
    ),
    (
        "header-ends-at-its-last-space",
        At::Bytes(|file| {
            let payload = file.payload_offset();
            if file.header().ends_with(b" \n") {
                EditedFile::File(
                    [&file.file[..payload - 2], b"\n", &file.file[payload - 1..]].concat(),
                )
            } else {
                file.unchanged()
            }
        }),
    ),
];

/// Removes the bytes at the start of the payload that `skip` accepts as white space.
fn skip_payload_bytes(file: &Anatomy, skip: fn(u8) -> bool) -> EditedFile {
    let count = file.file[file.payload_offset()..]
        .iter()
        .take_while(|&&byte| skip(byte))
        .count();
    remove_payload_bytes(file, count)
}

/// Removes the first `count` bytes of the payload.
fn remove_payload_bytes(file: &Anatomy, count: usize) -> EditedFile {
    EditedFile::File([file.header(), &file.file[file.payload_offset() + count..]].concat())
}

/// Rearranges an LRGB payload so that a correct decoder finds the values that a decoder for nine interleaved bytes would find.
fn deinterleave_payload(file: &Anatomy) -> EditedFile {
    if file.field_texts(&["2.2/1"]) != ["PTM_FORMAT_LRGB"] {
        return file.unchanged();
    }
    let texels = || file.file[file.payload_offset()..].chunks_exact(9);
    let blocks = texels()
        .flat_map(|texel| &texel[..6])
        .chain(texels().flat_map(|texel| &texel[6..]));
    EditedFile::File(file.header().iter().chain(blocks).copied().collect())
}

/// Returns the longest prefix that is a number, or "0".
fn number_prefix(text: &str) -> String {
    let ends = (1..=text.len())
        .rev()
        .filter(|&end| text.is_char_boundary(end));
    let numbers = ends
        .map(|end| &text[..end])
        .filter(|beginning| beginning.parse::<f64>().is_ok_and(f64::is_finite));
    numbers
        .map(str::to_owned)
        .next()
        .unwrap_or_else(|| "0".to_owned())
}
