//! §2.0–2.3, and the spelling of 2.4's numbers

use super::{Anatomy, At, Misreading, Seen};

const SCALE: &str = "2.4/3";
const BIAS: &str = "2.4/4";

pub(super) const ALL: &[Misreading] = &[
    Misreading {
        slug: "greedy-whitespace",
        clause: "2.0/2",
        effect: "skips every white space byte after the header, payload bytes among them",
        mend: "take exactly one line feed after the last number, then the payload, whatever its first byte is",
        at: At::Bytes(|file| skipped(file, |byte| matches!(byte, b'\t'..=b'\r' | b' '))),
    },
    Misreading {
        slug: "greedy-line-feeds",
        clause: "2.0/2",
        effect: "skips every line feed after the header, payload bytes among them",
        mend: "take exactly one line feed after the last number",
        at: At::Bytes(|file| skipped(file, |byte| byte == b'\n')),
    },
    Misreading {
        slug: "greedy-line-ends",
        clause: "2.0/2",
        effect: "skips every line feed and carriage return after the header, payload bytes among them",
        mend: "take exactly one line feed after the last number",
        at: At::Bytes(|file| skipped(file, |byte| matches!(byte, b'\n' | b'\r'))),
    },
    Misreading {
        slug: "greedy-blanks",
        clause: "2.0/2",
        effect: "skips every space and tab after the header, payload bytes among them",
        mend: "the payload follows the line feed at once",
        at: At::Bytes(|file| skipped(file, |byte| matches!(byte, b' ' | b'\t'))),
    },
    Misreading {
        slug: "carriage-return-skipped",
        clause: "2.0/2",
        effect: "skips a carriage return at the beginning of the payload",
        mend: "a payload may begin with any byte, 0x0D too",
        at: At::Bytes(|file| match file.file.get(file.payload()) {
            Some(b'\r') => without(file, 1),
            _ => file.unchanged(),
        }),
    },
    Misreading {
        slug: "no-space-before-newline",
        clause: "2.0/2",
        effect: "refuses a space before a line feed",
        mend: "every header line may end in one space",
        at: At::Bytes(|file| file.refused_if(file.header().windows(2).any(|pair| pair == b" \n"))),
    },
    Misreading {
        slug: "names-compared-with-their-space",
        clause: "2.0/2",
        effect: "refuses a space behind the version or the name of the format",
        mend: "take the optional space off before comparing",
        at: At::Bytes(|file| {
            file.refused_if(file.after("2.1/1", 0) == b" \n" || file.after("2.2/1", 0) == b" \n")
        }),
    },
    Misreading {
        slug: "no-space-behind-the-size",
        clause: "2.0/2",
        effect: "refuses a space behind width or height",
        mend: "every header line may end in one space",
        at: At::Bytes(|file| {
            file.refused_if(file.after("2.3/1", 0) == b" \n" || file.after("2.3/1", 1) == b" \n")
        }),
    },
    Misreading {
        slug: "no-space-behind-scale-and-bias",
        clause: "2.4/7",
        effect: "refuses a space behind the scales or the biases",
        mend: "both lines may end in one space; HP's own files do",
        at: At::Bytes(|file| {
            file.refused_if(file.after(SCALE, 5) == b" \n" || file.after(BIAS, 5) == b" \n")
        }),
    },
    Misreading {
        slug: "version-with-space-is-1.1",
        clause: "2.0/2",
        effect: "takes \"PTM_1.2 \" for an older version and reads nine interleaved bytes for each texel",
        mend: "take the optional space off before comparing the version",
        at: At::Bytes(|file| {
            if file.after("2.1/1", 0) == b" \n" {
                as_interleaved(file)
            } else {
                file.unchanged()
            }
        }),
    },
    Misreading {
        slug: "payload-offset-by-line-lengths",
        clause: "2.0/2",
        effect: "adds up the lengths of trimmed lines to find the payload, and is short by every optional space",
        mend: "keep the place where reading the header ended",
        at: At::Bytes(|file| {
            let spaces = file
                .header()
                .windows(2)
                .filter(|pair| *pair == b" \n")
                .count();
            let payload = file.payload();
            Seen::File([file.header(), &file.file[payload - spaces..]].concat())
        }),
    },
    Misreading {
        slug: "text-mode",
        clause: "2.0/2",
        effect: "reads the file in text mode: CR LF within the payload becomes LF",
        mend: "open the file in binary mode",
        at: At::Bytes(|file| {
            let mut bytes = Vec::new();
            for (i, &byte) in file.file.iter().enumerate() {
                if byte != b'\r' || file.file.get(i + 1) != Some(&b'\n') {
                    bytes.push(byte);
                }
            }
            Seen::File(bytes)
        }),
    },
    Misreading {
        slug: "text-mode-end-of-file",
        clause: "2.7/1",
        effect: "takes a byte 0x1A for the end of the file",
        mend: "open the file in binary mode",
        at: At::Bytes(|file| {
            Seen::File(
                file.file
                    .split(|&byte| byte == 0x1a)
                    .next()
                    .unwrap_or_default()
                    .to_vec(),
            )
        }),
    },
    Misreading {
        slug: "text-mode-universal",
        clause: "2.0/2",
        effect: "reads the file in text mode: CR LF and CR alone within the payload become LF",
        mend: "open the file in binary mode",
        at: At::Bytes(|file| {
            let mut bytes = Vec::new();
            for (i, &byte) in file.file.iter().enumerate() {
                match byte {
                    b'\r' if file.file.get(i + 1) == Some(&b'\n') => {}
                    b'\r' => bytes.push(b'\n'),
                    _ => bytes.push(byte),
                }
            }
            Seen::File(bytes)
        }),
    },
    Misreading {
        slug: "white-space-at-the-end-stripped",
        clause: "2.7/1",
        effect: "strips white space from the end of the file, payload bytes among them",
        mend: "take the payload as it is, byte by byte",
        at: At::Bytes(|file| Seen::File(file.file.trim_ascii_end().to_vec())),
    },
    Misreading {
        slug: "zeros-at-the-end-trimmed",
        clause: "2.7/1",
        effect: "trims zero bytes from the end of the file, payload bytes among them",
        mend: "take the payload as it is, byte by byte",
        at: At::Bytes(|file| {
            let end = file.file.iter().rposition(|&byte| byte != 0);
            Seen::File(file.file[..end.map_or(0, |last| last + 1)].to_vec())
        }),
    },
    Misreading {
        slug: "version-unchecked",
        clause: "2.1/1",
        effect: "reads any version as 1.2",
        mend: "compare the first line with PTM_1.2",
        at: At::Bytes(|file| {
            file.respelled(|clause, _| (clause == "2.1/1").then(|| "PTM_1.2".to_owned()))
        }),
    },
    Misreading {
        slug: "version-by-prefix",
        clause: "2.1/1",
        effect: "compares only the first seven bytes of the version",
        mend: "the line is PTM_1.2 and nothing more",
        at: At::Bytes(|file| {
            file.respelled(|clause, text| {
                (clause == "2.1/1" && text.starts_with("PTM_1.2")).then(|| "PTM_1.2".to_owned())
            })
        }),
    },
    Misreading {
        slug: "version-1.x-accepted",
        clause: "2.1/1",
        effect: "reads every PTM_1.x as 1.2",
        mend: "PTM_1.1 interleaves its bytes; refuse it or read it so",
        at: At::Bytes(|file| {
            file.respelled(|clause, text| {
                (clause == "2.1/1" && text.starts_with("PTM_1.")).then(|| "PTM_1.2".to_owned())
            })
        }),
    },
    Misreading {
        slug: "format-by-beginning",
        clause: "2.2/1",
        effect: "compares only the beginning of the format's name",
        mend: "the nine names are whole lines",
        at: At::Bytes(|file| {
            file.respelled(|clause, text| {
                (clause == "2.2/1" && text.starts_with("PTM_FORMAT_LRGB"))
                    .then(|| "PTM_FORMAT_LRGB".to_owned())
            })
        }),
    },
    Misreading {
        slug: "format-in-any-case",
        clause: "2.2/1",
        effect: "accepts the format's name in lower case",
        mend: "the nine names are in upper case",
        at: At::Bytes(|file| {
            file.respelled(|clause, text| (clause == "2.2/1").then(|| text.to_uppercase()))
        }),
    },
    Misreading {
        slug: "size-two-lines-only",
        clause: "2.3/1",
        effect: "refuses width and height on one line",
        mend: "one line is the text's first form; read both",
        at: At::Bytes(|file| file.refused_if(!file.after("2.3/1", 0).contains(&b'\n'))),
    },
    Misreading {
        slug: "size-one-line-only",
        clause: "2.3/2",
        effect: "refuses width and height on two lines",
        mend: "a line feed may stand between them; HP's own files have it",
        at: At::Bytes(|file| file.refused_if(file.after("2.3/1", 0).contains(&b'\n'))),
    },
    Misreading {
        slug: "scale-bias-two-lines-only",
        clause: "2.4/6",
        effect: "refuses scales and biases on one line",
        mend: "the line feed between them is optional",
        at: At::Bytes(|file| file.refused_if(!file.after(SCALE, 5).contains(&b'\n'))),
    },
    Misreading {
        slug: "scale-bias-one-line-only",
        clause: "2.4/6",
        effect: "refuses scales and biases on two lines",
        mend: "a line feed may stand between them; HP's own files have it",
        at: At::Bytes(|file| file.refused_if(file.after(SCALE, 5).contains(&b'\n'))),
    },
    Misreading {
        slug: "double-space-dies",
        clause: "2.4/5",
        effect: "refuses more than one space between numbers",
        mend: "split at runs of spaces",
        at: At::Bytes(|file| file.refused_if(file.header().windows(2).any(|pair| pair == b"  "))),
    },
    Misreading {
        slug: "double-space-is-zero",
        clause: "2.4/5",
        effect: "reads a zero between two spaces, and loses the numbers at the end",
        mend: "split at runs of spaces",
        at: At::Bytes(|file| {
            if !file.header().windows(2).any(|pair| pair == b"  ") {
                return file.unchanged();
            }
            file.respelled(|clause, _| (clause == SCALE || clause == BIAS).then(|| "0".to_owned()))
        }),
    },
    Misreading {
        slug: "last-number-needs-space",
        clause: "2.4/7",
        effect: "loses the last scale and the last bias where no space follows them",
        mend: "a number ends at the end of its line too",
        at: At::Bytes(|file| match (file.after(SCALE, 5), file.after(BIAS, 5)) {
            (scale, bias) if scale == b"\n" || bias == b"\n" => {
                let mut bytes = file.file.to_vec();
                for clause in [BIAS, SCALE] {
                    let field = file
                        .fields
                        .iter()
                        .filter(|field| field.clause == clause)
                        .nth(5);
                    if let Some(field) = field.filter(|field| bytes[field.range.end] == b'\n') {
                        bytes.splice(field.range.clone(), *b"0");
                    }
                }
                Seen::File(bytes)
            }
            _ => file.unchanged(),
        }),
    },
    Misreading {
        slug: "line-buffer",
        clause: "2.0/1",
        effect: "refuses header lines of more than 255 bytes",
        mend: "no length is given for a line",
        at: At::Bytes(|file| {
            file.refused_if(
                file.header()
                    .split(|&byte| byte == b'\n')
                    .any(|line| line.len() > 255),
            )
        }),
    },
    Misreading {
        slug: "short-line-buffer",
        clause: "2.0/1",
        effect: "refuses header lines of more than 79 bytes",
        mend: "no length is given for a line",
        at: At::Bytes(|file| {
            file.refused_if(
                file.header()
                    .split(|&byte| byte == b'\n')
                    .any(|line| line.len() > 79),
            )
        }),
    },
    Misreading {
        slug: "sizes-of-four-digits",
        clause: "2.3/1",
        effect: "reads at most four digits of a size",
        mend: "no length is given for a number",
        at: At::Bytes(|file| {
            file.respelled(|clause, text| {
                (clause == "2.3/1" && text.len() > 4).then(|| text[..4].to_owned())
            })
        }),
    },
    Misreading {
        slug: "leading-zero-is-octal",
        clause: "2.3/1",
        effect: "reads numbers with a leading zero as octal",
        mend: "all numbers are decimal",
        at: At::Bytes(|file| {
            file.respelled(|clause, text| {
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
    },
    Misreading {
        slug: "leading-zeros-refused",
        clause: "2.3/1",
        effect: "refuses integers with leading zeros",
        mend: "leading zeros mean nothing",
        at: At::Bytes(|file| {
            file.refused_if(
                file.texts(&["2.3/1", BIAS])
                    .iter()
                    .any(|text| text.len() > 1 && text.starts_with('0')),
            )
        }),
    },
    Misreading {
        slug: "sign-ignored-in-sizes",
        clause: "2.3/3",
        effect: "ignores the sign of a size",
        mend: "refuse negative sizes",
        at: At::Bytes(|file| {
            file.respelled(|clause, text| {
                (clause == "2.3/1").then(|| text.trim_start_matches('-').to_owned())
            })
        }),
    },
    Misreading {
        slug: "sizes-wrap-at-32-bits",
        clause: "2.3/3",
        effect: "keeps only the low 32 bits of a size",
        mend: "refuse sizes that do not fit",
        at: At::Bytes(|file| {
            file.respelled(|clause, text| {
                let value = text
                    .parse::<u64>()
                    .ok()
                    .filter(|value| clause == "2.3/1" && *value > u64::from(u32::MAX));
                value.map(|value| (value as u32).to_string())
            })
        }),
    },
    Misreading {
        slug: "sizes-wrap-at-64-bits",
        clause: "2.3/3",
        effect: "keeps only the low 64 bits of a size",
        mend: "refuse sizes that do not fit",
        at: At::Bytes(|file| {
            file.respelled(|clause, text| {
                let value = text
                    .parse::<u128>()
                    .ok()
                    .filter(|value| clause == "2.3/1" && *value > u128::from(u64::MAX));
                value.map(|value| (value as u64).to_string())
            })
        }),
    },
    Misreading {
        slug: "exponent-ignored",
        clause: "2.4/3",
        effect: "stops reading a scale at its exponent",
        mend: "scales may be written 5e-1",
        at: At::Bytes(|file| {
            file.respelled(|clause, text| {
                text.split_once(['e', 'E'])
                    .filter(|_| clause == SCALE)
                    .map(|(m, _)| m.to_owned())
            })
        }),
    },
    Misreading {
        slug: "exponent-refused",
        clause: "2.4/3",
        effect: "refuses scales with an exponent",
        mend: "scales may be written 5e-1",
        at: At::Bytes(|file| {
            file.refused_if(
                file.texts(&[SCALE])
                    .iter()
                    .any(|text| text.contains(['e', 'E'])),
            )
        }),
    },
    Misreading {
        slug: "capital-exponent-refused",
        clause: "2.4/3",
        effect: "refuses scales with an exponent after a capital E",
        mend: "scales may be written 5E-1",
        at: At::Bytes(|file| {
            file.refused_if(file.texts(&[SCALE]).iter().any(|text| text.contains('E')))
        }),
    },
    Misreading {
        slug: "plus-sign-refused",
        clause: "2.4/3",
        effect: "refuses numbers with a plus sign",
        mend: "a sign may be + or −",
        at: At::Bytes(|file| {
            file.refused_if(
                file.texts(&[SCALE, BIAS])
                    .iter()
                    .any(|text| text.starts_with('+')),
            )
        }),
    },
    Misreading {
        slug: "leading-point-refused",
        clause: "2.4/3",
        effect: "refuses scales such as .5",
        mend: "digits may be missing before the point",
        at: At::Bytes(|file| {
            file.refused_if(
                file.texts(&[SCALE])
                    .iter()
                    .any(|text| text.trim_start_matches(['+', '-']).starts_with('.')),
            )
        }),
    },
    Misreading {
        slug: "trailing-point-refused",
        clause: "2.4/3",
        effect: "refuses scales such as 5.",
        mend: "digits may be missing after the point",
        at: At::Bytes(|file| {
            file.refused_if(file.texts(&[SCALE]).iter().any(|text| text.ends_with('.')))
        }),
    },
    Misreading {
        slug: "scale-needs-a-point",
        clause: "2.4/3",
        effect: "refuses scales without a decimal point",
        mend: "a whole number is a number",
        at: At::Bytes(|file| {
            file.refused_if(file.texts(&[SCALE]).iter().any(|text| !text.contains('.')))
        }),
    },
    Misreading {
        slug: "scale-to-the-point",
        clause: "2.4/3",
        effect: "reads only the digits before the decimal point of a scale",
        mend: "scales are floating point numbers",
        at: At::Bytes(|file| {
            file.respelled(|clause, text| {
                let (whole, _) = text.split_once('.').filter(|_| clause == SCALE)?;
                Some(if whole.trim_start_matches(['+', '-']).is_empty() {
                    "0".to_owned()
                } else {
                    whole.to_owned()
                })
            })
        }),
    },
    Misreading {
        slug: "scale-with-six-characters",
        clause: "2.4/3",
        effect: "reads only six characters of a scale",
        mend: "no length is given for a number",
        at: At::Bytes(|file| {
            file.respelled(|clause, text| {
                (clause == SCALE && text.len() > 6).then(|| text[..6].to_owned())
            })
        }),
    },
    Misreading {
        slug: "negative-scale-refused",
        clause: "2.4/3",
        effect: "refuses negative scales",
        mend: "a scale may be any real number",
        at: At::Bytes(|file| {
            file.refused_if(
                file.texts(&[SCALE])
                    .iter()
                    .any(|text| text.starts_with('-')),
            )
        }),
    },
    Misreading {
        slug: "zero-scale-refused",
        clause: "2.4/3",
        effect: "refuses a scale of zero",
        mend: "a scale may be any real number",
        at: At::Bytes(|file| {
            file.refused_if(
                file.texts(&[SCALE])
                    .iter()
                    .any(|text| text.parse() == Ok(0.0)),
            )
        }),
    },
    Misreading {
        slug: "negative-bias-refused",
        clause: "2.4/4",
        effect: "refuses negative biases",
        mend: "biases below 0 occur in real files",
        at: At::Bytes(|file| {
            file.refused_if(file.texts(&[BIAS]).iter().any(|text| text.starts_with('-')))
        }),
    },
    Misreading {
        slug: "large-bias-refused",
        clause: "2.4/4",
        effect: "refuses biases above 255",
        mend: "biases above 255 occur in real files",
        at: At::Bytes(|file| {
            file.refused_if(
                file.texts(&[BIAS])
                    .iter()
                    .any(|text| text.parse::<f64>().is_ok_and(|bias| bias > 255.0)),
            )
        }),
    },
    Misreading {
        slug: "bias-fraction-cut",
        clause: "2.4/4",
        effect: "cuts the fraction off a bias",
        mend: "refuse a bias that is not an integer",
        at: At::Bytes(|file| {
            file.respelled(|clause, text| {
                text.split_once('.')
                    .filter(|_| clause == BIAS)
                    .map(|(whole, _)| whole.to_owned())
            })
        }),
    },
    Misreading {
        slug: "numbers-by-prefix",
        clause: "2.4/3",
        effect: "reads the digits at the beginning of a number and ignores what follows, as atof does",
        mend: "refuse what is not a number",
        at: At::Bytes(|file| {
            file.respelled(|clause, text| {
                let numeric = matches!(clause, "2.3/1" | SCALE | BIAS | "2.6/2" | "2.5/2")
                    && text.parse::<f64>().is_err();
                numeric.then(|| prefix(text))
            })
        }),
    },
    Misreading {
        slug: "not-a-number-accepted",
        clause: "2.4/3",
        effect: "accepts nan",
        mend: "refuse what is not a finite number",
        at: At::Bytes(|file| file.respelled(|_, text| (text == "nan").then(|| "0".to_owned()))),
    },
    Misreading {
        slug: "infinity-accepted",
        clause: "2.4/3",
        effect: "accepts inf and infinity",
        mend: "refuse what is not a finite number",
        at: At::Bytes(|file| {
            file.respelled(|_, text| {
                text.trim_start_matches('-')
                    .starts_with("inf")
                    .then(|| "1e300".to_owned())
            })
        }),
    },
    Misreading {
        slug: "overflow-accepted",
        clause: "2.4/3",
        effect: "lets a scale overflow to infinity",
        mend: "refuse what is not a finite number",
        at: At::Bytes(|file| {
            file.respelled(|clause, text| {
                (clause == SCALE && text == "1e400").then(|| "1e300".to_owned())
            })
        }),
    },
    Misreading {
        slug: "hexadecimal-accepted",
        clause: "2.4/3",
        effect: "accepts hexadecimal numbers, as strtod does",
        mend: "all numbers are decimal",
        at: At::Bytes(|file| {
            file.respelled(|_, text| match text {
                "0x1p-1" => Some("0.5".to_owned()),
                _ => text
                    .strip_prefix("0x")
                    .and_then(|hex| u32::from_str_radix(hex, 16).ok())
                    .map(|value| value.to_string()),
            })
        }),
    },
    Misreading {
        slug: "short-payload-padded",
        clause: "2.7/3",
        effect: "fills what is missing at the end of the file with zeros",
        mend: "refuse a file that is too short",
        at: At::Bytes(|file| Seen::File([file.file, &vec![0; file.file.len() + 4096]].concat())),
    },
    Misreading {
        slug: "header-ends-at-its-last-space",
        clause: "2.0/2",
        effect: "ends the header at the space before its last line feed",
        mend: "the optional space and the line feed both belong to the header",
        at: At::Bytes(|file| {
            let payload = file.payload();
            if file.header().ends_with(b" \n") {
                Seen::File([&file.file[..payload - 2], b"\n", &file.file[payload - 1..]].concat())
            } else {
                file.unchanged()
            }
        }),
    },
];

/// Without the bytes at the beginning of the payload that `skip` takes for white space.
fn skipped(file: &Anatomy, skip: fn(u8) -> bool) -> Seen {
    let count = file.file[file.payload()..]
        .iter()
        .take_while(|&&byte| skip(byte))
        .count();
    without(file, count)
}

/// Without the first bytes of the payload.
fn without(file: &Anatomy, count: usize) -> Seen {
    Seen::File([file.header(), &file.file[file.payload() + count..]].concat())
}

/// An LRGB payload sorted so that a reader of two blocks finds what a reader of nine interleaved bytes would.
fn as_interleaved(file: &Anatomy) -> Seen {
    if file.texts(&["2.2/1"]) != ["PTM_FORMAT_LRGB"] {
        return file.unchanged();
    }
    let texels = || file.file[file.payload()..].chunks_exact(9);
    let blocks = texels()
        .flat_map(|texel| &texel[..6])
        .chain(texels().flat_map(|texel| &texel[6..]));
    Seen::File(file.header().iter().chain(blocks).copied().collect())
}

/// The longest beginning that is a number; 0 if there is none.
fn prefix(text: &str) -> String {
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
