//! §2.0–2.9: what strings, buffers and short integers make of a file

use super::{Anatomy, At, Decision, Misreading, Seen};
use crate::decode::{indices, planes};
use crate::reading::Reading;

const LENGTH: &str = "no length is given for a line or a header";
const BINARY: &str = "the payload is bytes, each from 0 to 255, and follows the header at once";
const NAMES: &str = "compare the whole line with the whole name";

pub(super) const ALL: &[Misreading] = &[
    // Strings
    Misreading {
        slug: "nul-ends-the-payload",
        clause: "2.7/1",
        effect: "copies the payload as a string, up to its first byte of 0",
        mend: BINARY,
        at: At::Bytes(|file| {
            let payload = &file.file[file.payload()..];
            let end = payload.iter().position(|&byte| byte == 0);
            let mut copied = payload.to_vec();
            copied[end.unwrap_or(payload.len())..].fill(0);
            Seen::File([file.header(), &copied].concat())
        }),
    },
    Misreading {
        slug: "byte-255-is-the-end",
        clause: "2.7/1",
        effect: "takes the byte 255 for the end of the file",
        mend: BINARY,
        at: At::Bytes(|file| {
            let payload = &file.file[file.payload()..];
            let end = payload.iter().position(|&byte| byte == 255);
            let end = end.unwrap_or(payload.len());
            Seen::File([file.header(), &payload[..end]].concat())
        }),
    },
    Misreading {
        slug: "byte-order-mark-skipped",
        clause: "2.0/2",
        effect: "skips EF BB BF at the beginning of the payload",
        mend: BINARY,
        at: At::Bytes(|file| {
            let payload = &file.file[file.payload()..];
            let payload = payload.strip_prefix(b"\xef\xbb\xbf").unwrap_or(payload);
            Seen::File([file.header(), payload].concat())
        }),
    },
    Misreading {
        slug: "comment-skipped",
        clause: "2.0/2",
        effect: "skips a line that begins with # at the beginning of the payload, as in other formats",
        mend: BINARY,
        at: At::Bytes(|file| {
            let payload = &file.file[file.payload()..];
            let is_comment = payload.first() == Some(&b'#');
            let length = payload.iter().position(|&byte| byte == b'\n');
            let skipped = if is_comment {
                length.map_or(payload.len(), |length| length + 1)
            } else {
                0
            };
            Seen::File([file.header(), &payload[skipped..]].concat())
        }),
    },
    Misreading {
        slug: "version-anywhere",
        clause: "2.1/1",
        effect: "finds the version anywhere in the first line",
        mend: NAMES,
        at: At::Bytes(|file| match file.file.strip_prefix(b"XPTM_1.2\n") {
            Some(rest) => Seen::File([b"PTM_1.2\n", rest].concat()),
            None => file.unchanged(),
        }),
    },
    Misreading {
        slug: "version-by-number",
        clause: "2.1/1",
        effect: "reads the version as a number, so that 1.20 is 1.2",
        mend: NAMES,
        at: At::Bytes(|file| match file.file.strip_prefix(b"PTM_1.20") {
            Some(rest) => Seen::File([b"PTM_1.2", rest].concat()),
            None => file.unchanged(),
        }),
    },
    Misreading {
        slug: "format-by-its-end",
        clause: "2.2/1",
        effect: "knows a format by the end of its line",
        mend: NAMES,
        at: At::Bytes(|file| match file.file.strip_prefix(b"PTM_1.2\nXPTM_") {
            Some(rest) => Seen::File([b"PTM_1.2\nPTM_", rest].concat()),
            None => file.unchanged(),
        }),
    },
    Misreading {
        slug: "format-without-its-beginning",
        clause: "2.2/1",
        effect: "knows a format without PTM_FORMAT_",
        mend: NAMES,
        at: At::Bytes(|file| match file.file.strip_prefix(b"PTM_1.2\n") {
            Some(rest)
                if !rest.to_ascii_uppercase().starts_with(b"PTM_") && !rest.starts_with(b"X") =>
            {
                Seen::File([b"PTM_1.2\nPTM_FORMAT_", rest].concat())
            }
            _ => file.unchanged(),
        }),
    },
    // Buffers
    Misreading {
        slug: "line-of-1024",
        clause: "2.0/1",
        effect: "refuses header lines of more than 1,023 bytes",
        mend: LENGTH,
        at: At::Bytes(|file| {
            let mut lines = file.header().split(|&byte| byte == b'\n');
            file.refused_if(lines.any(|line| line.len() > 1023))
        }),
    },
    Misreading {
        slug: "header-of-4096",
        clause: "2.0/1",
        effect: "looks for the header in the first 4,096 bytes",
        mend: LENGTH,
        at: At::Bytes(|file| file.refused_if(file.header().len() > 4096)),
    },
    Misreading {
        slug: "extra-scales-ignored",
        clause: "2.4/2",
        effect: "ignores what follows six numbers on the line of scales or biases",
        mend: "there are six scales and six biases",
        at: At::Bytes(|file| with_words(file, 4..6, 6)),
    },
    Misreading {
        slug: "extra-sizes-ignored",
        clause: "2.3/1",
        effect: "ignores what follows a size on its line",
        mend: "a size is a width and a height",
        at: At::Bytes(|file| with_words(file, 2..4, 1)),
    },
    // Short integers
    Misreading {
        slug: "count-in-15-bits",
        clause: "2.5/2",
        effect: "keeps the number of entries in a signed integer of 16 bits, and refuses what is then negative",
        mend: "65,536 entries are legal",
        at: At::Bytes(|file| {
            let counts = file.texts(&["2.5/2"]);
            let mut numbers = counts.iter().filter_map(|text| text.parse::<u64>().ok());
            file.refused_if(numbers.any(|count| count & 0xffff > 0x7fff))
        }),
    },
    Misreading {
        slug: "stream-sizes-in-16-bits",
        clause: "2.9.6/1",
        effect: "keeps compressed sizes in 16 bits",
        mend: "a stream may have more than 65,535 bytes",
        at: At::Bytes(|file| {
            file.respelled(|clause, text| {
                let size: u64 = text.parse().ok()?;
                (clause == "2.9.6/1" && size > 0xffff).then(|| (size & 0xffff).to_string())
            })
        }),
    },
    Misreading {
        slug: "side-sizes-in-8-bits",
        clause: "2.9.7/1",
        effect: "keeps side information sizes in 8 bits",
        mend: "side information may have any number of records",
        at: At::Bytes(|file| {
            file.respelled(|clause, text| {
                let size: u64 = text.parse().ok()?;
                (clause == "2.9.7/1" && size > 0xff).then(|| (size & 0xff).to_string())
            })
        }),
    },
    Misreading {
        slug: "side-records-counted-in-8-bits",
        clause: "2.9.7/1",
        effect: "reads at most 255 records of side information",
        mend: "side information may have any number of records",
        at: At::Reading(Decision::Records, |r| Reading {
            records: |block, at, texels| {
                let mut records = planes::records(block, at, texels)?;
                records.truncate(255);
                Ok(records)
            },
            ..r
        }),
    },
    Misreading {
        slug: "last-entry-refused",
        clause: "2.8/1",
        effect: "refuses an index that names the last entry",
        mend: "the last index is the number of entries minus one",
        at: At::Reading(Decision::Entry, |r| Reading {
            entry: |index, entries| indices::entry(index, entries.saturating_sub(1)),
            ..r
        }),
    },
    // Loops
    Misreading {
        slug: "last-texel-lost",
        clause: "2.7/1",
        effect: "leaves the last stored texel empty",
        mend: "a map has width times height texels",
        at: At::Planes(|ptm| {
            // The top row is stored last.
            let channels = ptm.planes.shape.channels();
            let width = ptm.planes.size.width as usize;
            ptm.planes.samples[(width - 1) * channels..width * channels].fill(0);
        }),
    },
    Misreading {
        slug: "odd-column-lost",
        clause: "2.3/1",
        effect: "leaves the last column of an odd number of columns empty",
        mend: "a width may be odd",
        at: At::Planes(|ptm| {
            let channels = ptm.planes.shape.channels();
            let width = ptm.planes.size.width as usize;
            if width % 2 == 1 && width > 1 {
                for row in ptm.planes.samples.chunks_exact_mut(width * channels) {
                    row[(width - 1) * channels..].fill(0);
                }
            }
        }),
    },
    Misreading {
        slug: "odd-row-lost",
        clause: "2.3/1",
        effect: "leaves the last stored row of an odd number of rows empty",
        mend: "a height may be odd",
        at: At::Planes(|ptm| {
            let row = ptm.planes.size.width as usize * ptm.planes.shape.channels();
            if ptm.planes.size.height % 2 == 1 && ptm.planes.size.height > 1 {
                ptm.planes.samples[..row].fill(0);
            }
        }),
    },
];

/// The file with at most `count` words on these of its lines, where size, scales and biases have the lines of the plain
/// spelling.
fn with_words(file: &Anatomy, lines: std::ops::Range<usize>, count: usize) -> Seen {
    let mut parts = file.file.splitn(7, |&byte| byte == b'\n');
    let head: Vec<&[u8]> = parts.by_ref().take(6).collect();
    let Some(rest) = parts.next() else {
        return file.unchanged();
    };
    let words = |line: &[u8]| line.split(|&byte| byte == b' ').count();
    // A size on one line, or twelve numbers on one, is another spelling.
    let plain = head[2..4].iter().all(|line| line.len() < 20) && words(head[4]) < 9;
    if !plain || words(head[2]) > 1 {
        return file.unchanged();
    }
    let mut bytes = Vec::new();
    for (i, line) in head.into_iter().enumerate() {
        let kept: Vec<&[u8]> = line.split(|&byte| byte == b' ').take(count).collect();
        let kept = kept.join(&b' ');
        bytes.extend_from_slice(if lines.contains(&i) { &kept } else { line });
        bytes.push(b'\n');
    }
    bytes.extend_from_slice(rest);
    Seen::File(bytes)
}
