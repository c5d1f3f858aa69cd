//! Tables and indices written in another way.

use std::collections::HashMap;

use crate::parts::Block;
use crate::ptm::Format;
use crate::writers::request::WriteRequest;
use crate::writers::wrong::samples::laid_out;

/// A file with a table, in the making.
struct TableFile<'a> {
    request: &'a WriteRequest,
    entry_size: usize,
    entries: Vec<&'a [u8]>,
    /// Of each stored texel, the bottom row first.
    indices: Vec<usize>,
}

/// How indices are written.
#[derive(Clone, Copy)]
struct Indexing {
    width: usize,
    low_first: bool,
    first: usize,
}

impl<'a> TableFile<'a> {
    fn of(request: &'a WriteRequest) -> Option<TableFile<'a>> {
        let entry_size = match request.format {
            Format::PtmLut => 6,
            Format::PtmCLut => 9,
            _ => return None,
        };
        let row = request.header.width as usize * 9;
        let mut known: HashMap<&[u8], usize> = HashMap::new();
        let (mut entries, mut indices) = (Vec::new(), Vec::new());
        for texel in request
            .samples
            .chunks_exact(row)
            .rev()
            .flat_map(|row| row.chunks_exact(9))
        {
            let entry = &texel[..entry_size];
            let index = *known.entry(entry).or_insert_with(|| {
                entries.push(entry);
                entries.len() - 1
            });
            indices.push(index);
        }
        Some(TableFile {
            request,
            entry_size,
            entries,
            indices,
        })
    }

    /// Its header, with another count.
    fn header(&self, count: usize) -> Vec<u8> {
        let words = |numbers: &[f64]| {
            let numbers: Vec<String> = numbers.iter().map(f64::to_string).collect();
            numbers.join(" ")
        };
        let header = &self.request.header;
        let bias = header.bias.map(|bias| bias as f64);
        format!(
            "PTM_1.2\n{}\n{}\n{}\n{}\n{}\n{count} N_LUT_ENTRIES\n",
            header.format,
            header.width,
            header.height,
            words(&header.scale),
            words(&bias)
        )
        .into_bytes()
    }

    fn indexing(&self) -> Indexing {
        Indexing {
            width: if self.entries.len() > 256 { 2 } else { 1 },
            low_first: true,
            first: 0,
        }
    }

    fn index_bytes(&self, how: Indexing) -> Vec<u8> {
        let bytes = self.indices.iter().flat_map(|index| {
            let mut bytes = (index + how.first).to_le_bytes()[..how.width].to_vec();
            if !how.low_first {
                bytes.reverse();
            }
            bytes
        });
        bytes.collect()
    }

    /// The colors of `PTM_LUT`, texel by texel.
    fn colors(&self) -> Vec<u8> {
        match self.request.format {
            Format::PtmLut => laid_out(self.request, &[COLORS]),
            _ => Vec::new(),
        }
    }

    fn whole(&self, count: usize, parts: &[&[u8]]) -> Vec<u8> {
        [self.header(count), parts.concat()].concat()
    }
}

const COLORS: Block = Block {
    channel: 6,
    channels: 3,
};

/// A file whose colors lie in other blocks.
pub(super) fn with_blocks(
    request: &WriteRequest,
    blocks: fn(Format) -> &'static [Block],
) -> Vec<Vec<u8>> {
    let Some(file) = TableFile::of(request) else {
        return Vec::new();
    };
    let table = file.entries.concat();
    let indices = file.index_bytes(file.indexing());
    let colors = laid_out(request, blocks(request.format));
    // Colors behind the indices of a table that has them already.
    let again = laid_out(request, &[COLORS]);
    [colors, again]
        .map(|colors| file.whole(file.entries.len(), &[&table, &indices, &colors]))
        .to_vec()
}

/// Variants of the right file.
pub(super) fn candidates(request: &WriteRequest) -> Vec<Vec<u8>> {
    match TableFile::of(request) {
        Some(file) => [
            file.other_tables(),
            file.other_indices(),
            file.other_orders(),
        ]
        .concat(),
        None => Vec::new(),
    }
}

impl TableFile<'_> {
    /// Other layouts of the table.
    fn other_tables(&self) -> Vec<Vec<u8>> {
        let (size, count) = (self.entry_size, self.entries.len());
        let right = self.entries.concat();
        let each = |edit: &dyn Fn(&[u8]) -> Vec<u8>| -> Vec<u8> {
            self.entries.iter().flat_map(|entry| edit(entry)).collect()
        };
        let rotated = |entry: &[u8]| [&entry[6..], &entry[..6]].concat();
        let reversed = |entry: &[u8]| {
            entry[..6]
                .iter()
                .rev()
                .chain(&entry[6..])
                .copied()
                .collect()
        };
        let planes = (0..size).flat_map(|i| self.entries.iter().map(move |entry| entry[i]));
        let backwards: Vec<u8> = self
            .entries
            .iter()
            .rev()
            .copied()
            .flatten()
            .copied()
            .collect();
        let tables: Vec<(usize, Vec<u8>)> = vec![
            (
                count,
                [
                    &right[..],
                    &vec![0; (size * 256).saturating_sub(right.len())],
                ]
                .concat(),
            ),
            (count.saturating_sub(1), right.clone()),
            (count + 1, right.clone()),
            (count, self.entries.join(&b'\n')),
            (count, self.entries.join(&b' ')),
            (count, each(&|entry| [entry, &[0]].concat())),
            (count, each(&|entry| [entry, b"\n"].concat())),
            (count, planes.collect()),
            (count, backwards),
            (count, each(&reversed)),
            (count, each(&rotated)),
        ];
        let (indices, colors) = (self.index_bytes(self.indexing()), self.colors());
        let files = tables
            .iter()
            .map(|(count, table)| self.whole(*count, &[table, &indices, &colors]));
        // A count that stands for itself and the entries after it.
        files.collect()
    }

    /// Other indices.
    fn other_indices(&self) -> Vec<Vec<u8>> {
        let (count, right) = (self.entries.len(), self.indexing());
        let mut ways = vec![
            Indexing { first: 1, ..right },
            Indexing {
                low_first: false,
                ..right
            },
        ];
        ways.extend([1, 2, 4].map(|width| Indexing { width, ..right }));
        ways.extend([
            Indexing {
                first: count,
                ..right
            },
            Indexing {
                first: 0x1000,
                ..right
            },
        ]);
        let (table, colors) = (self.entries.concat(), self.colors());
        let files = ways
            .iter()
            .map(|&way| self.whole(count, &[&table, &self.index_bytes(way), &colors]));
        // The last entry, or the first, by an index past the table.
        let past = [0, count - 1].map(|entry| {
            let indices = self
                .indices
                .iter()
                .map(|&index| if index == entry { count } else { index });
            let other = TableFile {
                indices: indices.collect(),
                entries: self.entries.clone(),
                ..*self
            };
            self.whole(count, &[&table, &other.index_bytes(right), &colors])
        });
        files.chain(past).collect()
    }

    /// Indices and colors in another order.
    fn other_orders(&self) -> Vec<Vec<u8>> {
        let (count, table) = (self.entries.len(), self.entries.concat());
        let way = self.indexing();
        let (indices, colors) = (self.index_bytes(way), self.colors());
        let side_by_side = indices.chunks(way.width).zip(colors.chunks(3));
        let side_by_side: Vec<u8> = side_by_side
            .flat_map(|(index, color)| [index, color].concat())
            .collect();
        vec![
            self.whole(count, &[&table, &colors, &indices]),
            self.whole(count, &[&table, &side_by_side]),
            self.whole(count, &[&indices, &table, &colors]),
            self.whole(count, &[&indices, &colors]),
        ]
    }
}
