//! §2.0–2.9: mistakes with strings, buffers and short integers

use super::anatomy::{Anatomy, EditedFile};
use super::at::At;
use crate::decode::{indices, planes};

pub(super) const CHANGES: &[(&str, At)] = &[
    // Strings
    (
        "nul-ends-the-payload",
        At::Bytes(|file| {
            let payload = &file.file[file.payload_offset()..];
            let end = payload.iter().position(|&byte| byte == 0);
            let mut copied = payload.to_vec();
            copied[end.unwrap_or(payload.len())..].fill(0);
            EditedFile::File([file.header(), &copied].concat())
        }),
    ),
    (
        "byte-255-is-the-end",
        At::Bytes(|file| {
            let payload = &file.file[file.payload_offset()..];
            let end = payload.iter().position(|&byte| byte == 255);
            let end = end.unwrap_or(payload.len());
            EditedFile::File([file.header(), &payload[..end]].concat())
        }),
    ),
    (
        "byte-order-mark-skipped",
        At::Bytes(|file| {
            let payload = &file.file[file.payload_offset()..];
            let payload = payload.strip_prefix(b"\xef\xbb\xbf").unwrap_or(payload);
            EditedFile::File([file.header(), payload].concat())
        }),
    ),
    (
        "comment-skipped",
        At::Bytes(|file| {
            let payload = &file.file[file.payload_offset()..];
            let is_comment = payload.first() == Some(&b'#');
            let length = payload.iter().position(|&byte| byte == b'\n');
            let skipped = if is_comment {
                length.map_or(payload.len(), |length| length + 1)
            } else {
                0
            };
            EditedFile::File([file.header(), &payload[skipped..]].concat())
        }),
    ),
    (
        "version-anywhere",
        At::Bytes(|file| match file.file.strip_prefix(b"XPTM_1.2\n") {
            Some(rest) => EditedFile::File([b"PTM_1.2\n", rest].concat()),
            None => file.unchanged(),
        }),
    ),
    (
        "version-by-number",
        At::Bytes(|file| match file.file.strip_prefix(b"PTM_1.20") {
            Some(rest) => EditedFile::File([b"PTM_1.2", rest].concat()),
            None => file.unchanged(),
        }),
    ),
    (
        "format-by-its-end",
        At::Bytes(|file| match file.file.strip_prefix(b"PTM_1.2\nXPTM_") {
            Some(rest) => EditedFile::File([b"PTM_1.2\nPTM_", rest].concat()),
            None => file.unchanged(),
        }),
    ),
    (
        "format-without-its-beginning",
        At::Bytes(|file| match file.file.strip_prefix(b"PTM_1.2\n") {
            Some(rest)
                if !rest.to_ascii_uppercase().starts_with(b"PTM_") && !rest.starts_with(b"X") =>
            {
                EditedFile::File([b"PTM_1.2\nPTM_FORMAT_", rest].concat())
            }
            _ => file.unchanged(),
        }),
    ),
    // Buffers
    (
        "line-of-1024",
        At::Bytes(|file| {
            let mut lines = file.header().split(|&byte| byte == b'\n');
            file.refuse_if(lines.any(|line| line.len() > 1023))
        }),
    ),
    (
        "header-of-4096",
        At::Bytes(|file| file.refuse_if(file.header().len() > 4096)),
    ),
    (
        "extra-scales-ignored",
        At::Bytes(|file| limit_words(file, 4..6, 6)),
    ),
    (
        "extra-sizes-ignored",
        At::Bytes(|file| limit_words(file, 2..4, 1)),
    ),
    // Short integers
    (
        "count-in-15-bits",
        At::Bytes(|file| {
            let counts = file.field_texts(&["2.5/2"]);
            let mut numbers = counts.iter().filter_map(|text| text.parse::<u64>().ok());
            file.refuse_if(numbers.any(|count| count & 0xffff > 0x7fff))
        }),
    ),
    (
        "stream-sizes-in-16-bits",
        At::Bytes(|file| {
            file.respell(|clause, text| {
                let size: u64 = text.parse().ok()?;
                (clause == "2.9.6/1" && size > 0xffff).then(|| (size & 0xffff).to_string())
            })
        }),
    ),
    (
        "side-sizes-in-8-bits",
        At::Bytes(|file| {
            file.respell(|clause, text| {
                let size: u64 = text.parse().ok()?;
                (clause == "2.9.7/1" && size > 0xff).then(|| (size & 0xff).to_string())
            })
        }),
    ),
    (
        "side-records-counted-in-8-bits",
        At::Records(|block, at, texels| {
            let mut records = planes::parse_records(block, at, texels)?;
            records.truncate(255);
            Ok(records)
        }),
    ),
    (
        "last-entry-refused",
        At::Entry(|index, entries| indices::valid_entry(index, entries.saturating_sub(1))),
    ),
    // Loops
    (
        "last-texel-lost",
        At::Planes(|ptm| {
            // The top row is stored last.
            let channels = ptm.planes.shape.channels();
            let width = ptm.planes.size.width as usize;
            ptm.planes.samples[(width - 1) * channels..width * channels].fill(0);
        }),
    ),
    (
        "odd-column-lost",
        At::Planes(|ptm| {
            let channels = ptm.planes.shape.channels();
            let width = ptm.planes.size.width as usize;
            if width % 2 == 1 && width > 1 {
                for row in ptm.planes.samples.chunks_exact_mut(width * channels) {
                    row[(width - 1) * channels..].fill(0);
                }
            }
        }),
    ),
    (
        "odd-row-lost",
        At::Planes(|ptm| {
            let row = ptm.planes.size.width as usize * ptm.planes.shape.channels();
            if ptm.planes.size.height % 2 == 1 && ptm.planes.size.height > 1 {
                ptm.planes.samples[..row].fill(0);
            }
        }),
    ),
];

/// Limits these lines of the header to `count` words, if the size, the scales and the biases are on the usual lines.
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
