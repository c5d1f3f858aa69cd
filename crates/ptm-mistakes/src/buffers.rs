//! §2.0–2.9: mistakes in handling strings, buffers and short integers

use super::anatomy::{Anatomy, EditedFile};
use super::change::{Change, Changes};
use ptm::decode::{indices, planes};

pub const CHANGES: Changes = |slug| {
    Some(match slug {
        // Strings
        "nul-ends-the-payload" => Change::Bytes(|file| {
            let mut payload = file.payload().to_vec();
            let end = payload.iter().position(|&byte| byte == 0);
            payload[end.unwrap_or(file.payload().len())..].fill(0);
            file.with_payload(&payload)
        }),
        "byte-255-is-the-end" => Change::Bytes(|file| {
            let mut parts = file.payload().split(|&byte| byte == 255);
            file.with_payload(parts.next().unwrap_or_default())
        }),
        "byte-order-mark-skipped" => Change::Bytes(|file| {
            let rest = file.payload().strip_prefix(b"\xef\xbb\xbf");
            file.with_payload(rest.unwrap_or(file.payload()))
        }),
        "comment-skipped" => Change::Bytes(|file| {
            let mut lines = file.payload().splitn(2, |&byte| byte == b'\n');
            match file.payload() {
                [b'#', ..] => file.with_payload(lines.nth(1).unwrap_or_default()),
                _ => file.unchanged(),
            }
        }),
        "version-anywhere" => {
            Change::Bytes(|file| replace_start(file, b"XPTM_1.2\n", b"PTM_1.2\n"))
        }
        "version-by-number" => Change::Bytes(|file| replace_start(file, b"PTM_1.20", b"PTM_1.2")),
        "format-by-its-end" => {
            Change::Bytes(|file| replace_start(file, b"PTM_1.2\nXPTM_", b"PTM_1.2\nPTM_"))
        }
        "format-without-its-beginning" => {
            Change::Bytes(|file| match file.file.strip_prefix(b"PTM_1.2\n") {
                Some(rest)
                    if !rest.to_ascii_uppercase().starts_with(b"PTM_")
                        && !rest.starts_with(b"X") =>
                {
                    EditedFile::File([b"PTM_1.2\nPTM_FORMAT_", rest].concat())
                }
                _ => file.unchanged(),
            })
        }
        // Buffers
        "line-of-1024" => Change::Bytes(|file| {
            let mut lines = file.header().split(|&byte| byte == b'\n');
            file.refuse_if(lines.any(|line| line.len() > 1023))
        }),
        "header-of-4096" => Change::Bytes(|file| file.refuse_if(file.header().len() > 4096)),
        "extra-scales-ignored" => Change::Bytes(|file| limit_words(file, 4..6, 6)),
        "extra-sizes-ignored" => Change::Bytes(|file| limit_words(file, 2..4, 1)),
        // Short integers
        "count-in-15-bits" => Change::Bytes(|file| {
            file.refuse_text(&["2.5/2"], |text| {
                text.parse().is_ok_and(|count: u64| count & 0xffff > 0x7fff)
            })
        }),
        "stream-sizes-in-16-bits" => Change::Bytes(|file| {
            file.respell(&["2.9.6/1"], |text| {
                let size: u64 = text.parse().ok()?;
                (size > 0xffff).then(|| (size & 0xffff).to_string())
            })
        }),
        "side-sizes-in-8-bits" => Change::Bytes(|file| {
            file.respell(&["2.9.7/1"], |text| {
                let size: u64 = text.parse().ok()?;
                (size > 0xff).then(|| (size & 0xff).to_string())
            })
        }),
        "side-records-counted-in-8-bits" => Change::Reading(|r| {
            r.records = |block, at, texels| {
                let mut records = planes::parse_records(block, at, texels)?;
                records.truncate(255);
                Ok(records)
            };
        }),
        "last-entry-refused" => Change::Reading(|r| {
            r.entry = |index, entries| indices::valid_entry(index, entries.saturating_sub(1));
        }),
        // Loops
        "last-texel-lost" => Change::Map(|ptm| {
            // The top row is stored last.
            let channels = ptm.planes.shape.channels();
            let width = ptm.planes.size.width as usize;
            ptm.planes.samples[(width - 1) * channels..width * channels].fill(0);
        }),
        "odd-column-lost" => Change::Map(|ptm| {
            let channels = ptm.planes.shape.channels();
            let width = ptm.planes.size.width as usize;
            if width % 2 == 1 && width > 1 {
                for row in ptm.planes.samples.chunks_exact_mut(width * channels) {
                    row[(width - 1) * channels..].fill(0);
                }
            }
        }),
        "odd-row-lost" => Change::Map(|ptm| {
            let row = ptm.planes.size.width as usize * ptm.planes.shape.channels();
            if ptm.planes.size.height % 2 == 1 && ptm.planes.size.height > 1 {
                ptm.planes.samples[..row].fill(0);
            }
        }),
        _ => return None,
    })
};

/// Replaces `known` at the start of a file with `start`. Other files remain unchanged.
fn replace_start(file: &Anatomy, known: &[u8], start: &[u8]) -> EditedFile {
    match file.file.strip_prefix(known) {
        Some(rest) => EditedFile::File([start, rest].concat()),
        None => file.unchanged(),
    }
}

/// Limits these header lines to `count` words each, if the size, the scales and the biases are on their default lines.
fn limit_words(file: &Anatomy, lines: std::ops::Range<usize>, count: usize) -> EditedFile {
    let mut parts = file.file.splitn(7, |&byte| byte == b'\n');
    let head: Vec<&[u8]> = parts.by_ref().take(6).collect();
    let Some(rest) = parts.next() else {
        return file.unchanged();
    };
    let words = |line: &[u8]| line.split(|&byte| byte == b' ').count();
    // A size on one line, or twelve numbers on one line, is a different spelling.
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
    EditedFile::File(bytes)
}
