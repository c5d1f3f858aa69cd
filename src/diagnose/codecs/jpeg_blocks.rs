//! What can be said of a block of a JPEG stream, so that blocks which a decoder gets wrong can be described.

use std::f64::consts::{PI, SQRT_2};
use std::sync::LazyLock;

use super::separate::Feature;
use crate::codec::jpeg::{BlockTrace, trace};
use crate::generate::plan::Stream;

/// A block, and where it stands.
pub(super) struct Block {
    trace: BlockTrace,
    /// Dequantized coefficients in row order.
    coefficients: [i32; 64],
    /// The largest quantization step of a coefficient that is not 0.
    largest_step: u16,
    /// The largest magnitude between the two passes of the inverse DCT, columns first, in units of coefficients.
    half: f64,
    /// The smallest and the largest sample before samples are limited, those outside the picture included.
    extremes: [f64; 2],
    column: usize,
    row: usize,
    /// Whether a byte of its bits is FF.
    is_stuffed: bool,
    size: (usize, usize),
    stream: Stream,
    /// Whether the frame begins with SOF1: the extended sequential process.
    is_extended: bool,
}

/// All features of blocks, the plainer ones first.
pub(super) static FEATURES: LazyLock<Vec<Feature<Block>>> = LazyLock::new(all_features);

/// The blocks of a stream in their order, where it is one.
pub(super) fn blocks(bytes: &[u8], (width, height): (usize, usize), stream: Stream) -> Vec<Block> {
    let Ok((traced, steps)) = trace(bytes, width as u32, height as u32) else {
        return Vec::new();
    };
    let columns = width.div_ceil(8);
    let is_extended = is_extended(bytes);
    let traced = traced.into_iter().enumerate();
    let block = |(i, trace): (usize, BlockTrace)| {
        let mut coefficients = [0; 64];
        for (k, place) in zigzag().into_iter().enumerate() {
            coefficients[place] = trace.coefficients[k] * i32::from(steps[k]);
        }
        let (half, extremes) = extremes(&coefficients);
        let used = (0..64).filter(|&k| trace.coefficients[k] != 0);
        Block {
            largest_step: used.map(|k| steps[k]).max().unwrap_or_default(),
            half,
            extremes,
            column: i % columns,
            row: i / columns,
            is_stuffed: bytes[trace.bytes.clone()].contains(&0xff),
            size: (width, height),
            coefficients,
            trace,
            stream,
            is_extended,
        }
    };
    traced.map(block).collect()
}

/// Whether the frame header of a stream is SOF1 (B.2.2); SOF0 is the other one that there may be.
fn is_extended(bytes: &[u8]) -> bool {
    let mut at = 2;
    while let [0xff, marker, high, low] =
        bytes[at.min(bytes.len())..][..4.min(bytes.len() - at.min(bytes.len()))]
    {
        match marker {
            0xc0 | 0xc1 => return marker == 0xc1,
            _ => at += 2 + usize::from(u16::from_be_bytes([high, low])),
        }
    }
    false
}

/// Where the coefficients stand in their block, by their place in the stream: along the antidiagonals, up and down in turn.
fn zigzag() -> [usize; 64] {
    let mut places: Vec<(usize, usize)> = (0..64).map(|i| (i / 8, i % 8)).collect();
    places.sort_by_key(|&(y, x)| (x + y, if (x + y) % 2 == 0 { x } else { y }));
    std::array::from_fn(|k| 8 * places[k].0 + places[k].1)
}

/// The inverse DCT of eight coefficients (T.81 A.3.3), times √8.
fn inverse_dct_of_8(c: [f64; 8]) -> [f64; 8] {
    std::array::from_fn(|x| {
        let part = |u: usize| {
            let scale = if u == 0 { 1.0 } else { SQRT_2 };
            scale * c[u] * ((2 * x + 1) as f64 * u as f64 * PI / 16.0).cos()
        };
        (0..8).map(part).sum()
    })
}

/// The largest magnitude after the columns are transformed, and the smallest and the largest sample, not limited.
fn extremes(coefficients: &[i32; 64]) -> (f64, [f64; 2]) {
    let columns: [[f64; 8]; 8] = std::array::from_fn(|x| {
        inverse_dct_of_8(std::array::from_fn(|y| f64::from(coefficients[8 * y + x])))
    });
    let half = columns
        .iter()
        .flatten()
        .fold(0.0_f64, |most, value| most.max(value.abs()));
    let rows = (0..8).map(|y| inverse_dct_of_8(std::array::from_fn(|x| columns[x][y])));
    let samples = rows.flatten().map(|value| value / 8.0 + 128.0);
    let extremes = samples.fold([f64::MAX, f64::MIN], |[least, most], sample| {
        [least.min(sample), most.max(sample)]
    });
    (half, extremes)
}

impl Block {
    /// The coefficients other than DC as they are stored, by their place in the stream.
    fn ac(&self) -> &[i32] {
        &self.trace.coefficients[1..]
    }

    /// The numbers that stand behind codes: the DC difference and the AC coefficients.
    fn numbers(&self) -> impl Iterator<Item = i32> {
        let ac = self.ac().iter().copied();
        std::iter::once(self.trace.dc_difference)
            .chain(ac)
            .filter(|&number| number != 0)
    }

    /// Whether a line of `step`, `across` the block, has its last AC coefficient alone.
    fn ends_alone(&self, first: usize, step: usize) -> bool {
        let at = |i: usize| self.coefficients[first + i * step];
        (1..7).all(|i| at(i) == 0) && at(7) != 0
    }

    fn is_last_of_row(&self) -> bool {
        self.column == (self.size.0 - 1) / 8
    }
}

/// How many bits a number needs.
fn bits(number: i32) -> u32 {
    32 - number.unsigned_abs().leading_zeros()
}

type Row = (&'static str, fn(&Block) -> bool);

/// What is so of whole streams.
const STREAM_ROWS: &[Row] = &[
    ("of streams with a frame of SOF1", |b| b.is_extended),
    (
        "of streams with a frame of SOF1 and more than one row of blocks",
        |b| b.is_extended && b.size.1 > 8,
    ),
    (
        "of streams with a frame of SOF1 and more than one block in a row",
        |b| b.is_extended && b.size.0 > 8,
    ),
    ("of streams with restart markers", |b| {
        b.stream.restart_interval > 0
    }),
    ("of streams with 16-bit quantization tables", |b| {
        b.stream.step.is_some_and(|step| step > 255) || !b.stream.baseline
    }),
    (
        "of streams with Huffman tables other than those of Annex K",
        |b| b.stream.optimized,
    ),
    ("of streams with sampling factors other than 1x1", |b| {
        b.stream.sampling != (1, 1)
    }),
    (
        "of streams with a restart interval of more than 255 blocks",
        |b| b.stream.restart_interval > 255,
    ),
    (
        "of streams whose component has another number than 1",
        |b| b.stream.component != 1,
    ),
    (
        "of streams whose frame header stands before the tables",
        |b| b.stream.frame_moved,
    ),
    ("of streams without JFIF", |b| !b.stream.jfif),
    ("of streams with several tables in one segment", |b| {
        b.stream.tables_together
    }),
    ("of streams with tables that nothing uses", |b| {
        b.stream.table_numbers.is_some()
    }),
    (
        "of streams whose quantization table has another number than 0",
        |b| b.stream.table_numbers.is_some_and(|[q, _, _]| q > 0),
    ),
    (
        "of streams that use a Huffman table with another number than 0",
        |b| (b.stream.table_numbers).is_some_and(|[_, dc, ac]| dc.max(ac) > 0),
    ),
    (
        "of streams that use a Huffman table with the number 2 or 3",
        |b| (b.stream.table_numbers).is_some_and(|[_, dc, ac]| dc.max(ac) > 1),
    ),
    (
        "of streams whose Huffman tables for DC and AC have different numbers",
        |b| b.stream.table_numbers.is_some_and(|[_, dc, ac]| dc != ac),
    ),
];

/// How many of [`FEATURES`], the first ones, are of whole streams.
pub(super) const OF_STREAMS: usize = STREAM_ROWS.len();

const ROWS: &[Row] = &[
    ("that have AC coefficients", |b| {
        b.ac().iter().any(|&c| c != 0)
    }),
    ("that have a DC coefficient only", |b| {
        b.ac().iter().all(|&c| c == 0)
    }),
    ("with a DC difference other than 0", |b| {
        b.trace.dc_difference != 0
    }),
    ("with a DC difference below 0", |b| {
        b.trace.dc_difference < 0
    }),
    ("with an AC coefficient below 0", |b| {
        b.ac().iter().any(|&c| c < 0)
    }),
    (
        "with a number that is the smallest positive one of its size (1, 2, 4, 8 …)",
        |b| {
            b.numbers()
                .any(|number| number > 0 && number.count_ones() == 1)
        },
    ),
    (
        "with a DC difference that is the smallest positive one of its size (1, 2, 4, 8 …)",
        |b| b.trace.dc_difference > 0 && b.trace.dc_difference.count_ones() == 1,
    ),
    (
        "with a number that is the smallest of its size, bits all 0 (−1, −3, −7 …)",
        |b| {
            b.numbers()
                .any(|number| number < 0 && (1 - number).count_ones() == 1)
        },
    ),
    (
        "with a number that is the largest of its size, bits all 1 (1, 3, 7 …)",
        |b| {
            b.numbers()
                .any(|number| number > 0 && (number + 1).count_ones() == 1)
        },
    ),
    ("with an AC coefficient in the last row of the block", |b| {
        b.coefficients[56..].iter().any(|&c| c != 0)
    }),
    (
        "with an AC coefficient in the last column of the block",
        |b| b.coefficients.iter().skip(7).step_by(8).any(|&c| c != 0),
    ),
    (
        "with a column whose only AC coefficient is in the last row",
        |b| (0..8).any(|x| b.ends_alone(x, 8)),
    ),
    (
        "with a row whose only AC coefficient is in the last column",
        |b| (0..8).any(|y| b.ends_alone(8 * y, 1)),
    ),
    ("with a run of 16 zeros or more (ZRL)", |b| {
        b.trace.codes[1..].iter().any(|&(symbol, _)| symbol == 0xf0)
    }),
    (
        "with a coefficient at zigzag place 63, and so without an end of block",
        |b| b.trace.coefficients[63] != 0,
    ),
    (
        "with a byte FF, and so the stuffed byte 00, in their bits",
        |b| b.is_stuffed,
    ),
    ("with a sample that has to be limited at 0", |b| {
        b.extremes[0] < -0.5
    }),
    ("with a sample that has to be limited at 255", |b| {
        b.extremes[1] > 255.5
    }),
    ("with a sample that has to be limited at 0 or at 255", |b| {
        b.extremes[0] < -0.5 || b.extremes[1] > 255.5
    }),
    ("at the beginning of a row, but not of the first", |b| {
        b.column == 0 && b.row > 0
    }),
    ("in a row that is not the first", |b| b.row > 0),
    ("that are not the first of their stream", |b| {
        b.row + b.column > 0
    }),
    ("of planes whose width is a multiple of 8", |b| {
        b.size.0.is_multiple_of(8)
    }),
    ("at the end of a row", Block::is_last_of_row),
    (
        "at the end of a row, of planes whose width is a multiple of 8",
        |b| b.is_last_of_row() && b.size.0.is_multiple_of(8),
    ),
    ("of planes whose height is a multiple of 8", |b| {
        b.size.1.is_multiple_of(8)
    }),
    (
        "of planes of more than one row of blocks whose width is a multiple of 8",
        |b| b.size.0.is_multiple_of(8) && b.size.1 > 8,
    ),
    ("that extend past the right edge", |b| {
        8 * b.column + 8 > b.size.0
    }),
    ("that extend past the last row", |b| {
        8 * b.row + 8 > b.size.1
    }),
    ("right after a restart marker", |b| b.trace.is_restarted),
    ("after a restart marker", |b| b.trace.markers > 0),
];

/// A feature for each number from `from` to `to`, which stands for {} in the words.
fn counted(
    from: usize,
    to: usize,
    words: &str,
    holds: fn(&Block, usize) -> bool,
) -> impl Iterator<Item = Feature<Block>> {
    (from..=to).map(move |number| Feature {
        says: words.replace("{}", &number.to_string()),
        holds: Box::new(move |block| holds(block, number)),
    })
}

fn all_features() -> Vec<Feature<Block>> {
    let rows = STREAM_ROWS.iter().chain(ROWS);
    let rows = rows.map(|&(says, holds)| Feature {
        says: says.to_owned(),
        holds: Box::new(holds) as Box<dyn Fn(&Block) -> bool + Send + Sync>,
    });
    let mut all: Vec<Feature<Block>> = rows.collect();
    all.extend(counted(
        2,
        11,
        "with a DC difference of {} bits or more",
        |b, n| bits(b.trace.dc_difference) as usize >= n,
    ));
    all.extend(counted(
        6,
        10,
        "with a DC coefficient of more than {} bits",
        |b, n| bits(b.trace.coefficients[0]) as usize > n,
    ));
    all.extend(counted(
        2,
        10,
        "with an AC coefficient of {} bits or more",
        |b, n| b.ac().iter().any(|&c| bits(c) as usize >= n),
    ));
    // Most tables have no codes of some lengths: the longest says most.
    let long = counted(9, 16, "with a Huffman code of {} bits or more", |b, n| {
        let mut codes = b.trace.codes.iter();
        codes.any(|&(_, length)| length as usize >= n)
    });
    let long: Vec<Feature<Block>> = long.collect();
    all.extend(long.into_iter().rev());
    all.extend(counted(2, 9, "after {} or more restart markers", |b, n| {
        b.trace.markers >= n
    }));
    for step in [128, 256] {
        all.extend(counted(
            step,
            step,
            "with a coefficient whose quantization step is {} or more",
            |b, n| usize::from(b.largest_step) >= n,
        ));
    }
    for limit in [255, 511, 1023, 2047] {
        all.extend(counted(
            limit,
            limit,
            "with a dequantized coefficient beyond ±{}",
            |b, n| b.coefficients.iter().any(|c| c.unsigned_abs() as usize > n),
        ));
    }
    all.extend(counted(
        1023,
        1023,
        "with a value beyond ±{} between the two passes of the inverse DCT",
        |b, n| b.half > n as f64,
    ));
    all.extend(counted(
        2,
        62,
        "with a coefficient at zigzag place {} or later",
        |b, k| b.trace.coefficients[k..].iter().any(|&c| c != 0),
    ));
    all.extend(counted(
        1,
        62,
        "with a coefficient at zigzag place {}",
        |b, k| b.trace.coefficients[k] != 0,
    ));
    all.extend(counted(
        1,
        62,
        "with a coefficient at zigzag place {} or the one after it",
        |b, k| b.trace.coefficients[k..=k + 1].iter().any(|&c| c != 0),
    ));
    all
}

#[cfg(test)]
mod tests {
    use super::{FEATURES, blocks, zigzag};
    use crate::codec::jpeg::{JpegOptions, encode};
    use crate::generate::plan::Stream;

    #[track_caller]
    fn says(samples: &[u8; 128], quality: u8, place: usize) -> Vec<&'static str> {
        let stream = encode(samples, 16, 8, &JpegOptions::new(quality)).stream;
        let blocks = blocks(&stream, (16, 8), Stream::PLAIN);
        let holds = FEATURES.iter().filter(|one| (one.holds)(&blocks[place]));
        holds.map(|one| one.says.as_str()).collect()
    }

    #[test]
    fn features_follow_from_the_coefficients_of_a_block() {
        let gray = says(&[128; 128], 100, 1);
        assert!(
            gray.contains(&"that have a DC coefficient only"),
            "{gray:?}"
        );
        assert!(gray.contains(&"at the end of a row"), "{gray:?}");
        let columns = std::array::from_fn(|i| (i % 2 * 255) as u8);
        let columns = says(&columns, 20, 0);
        for wanted in [
            "that have AC coefficients",
            "with a row whose only AC coefficient is in the last column",
            "with a dequantized coefficient beyond ±511",
            "with a coefficient at zigzag place 28",
            "with a coefficient whose quantization step is 128 or more",
        ] {
            let holds = columns.contains(&wanted);
            assert_eq!(
                holds,
                !wanted.starts_with("with a row"),
                "{wanted}: {columns:?}"
            );
        }
    }

    #[test]
    fn the_order_of_coefficients_is_that_of_the_standard() {
        assert_eq!(zigzag()[..10], [0, 1, 8, 16, 9, 2, 3, 10, 17, 24]);
        assert_eq!(zigzag()[60..], [47, 55, 62, 63]);
    }
}
