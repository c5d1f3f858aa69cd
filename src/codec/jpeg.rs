//! JPEG: ITU-T T.81 | ISO/IEC 10918-1, the sequential Huffman processes, one component of 8 bits
//!
//! The image is cut into blocks of 8 × 8 samples, left to right and top to bottom. Each block is
//! turned into 64 frequencies by the discrete cosine transform; each frequency is divided by its
//! entry of a quantisation table and rounded; the quotients are written in zigzag order, the first
//! (DC) as the difference to that of the block before, the others (AC) as pairs of a run of zeros
//! and a value, all with Huffman codes. Reading goes the same way back.
//!
//! Format notes
//! - The standard does not fix the inverse transform to the bit; it allows any that is close
//!   (A.3.3). PTM planes carry differences modulo 256, where being off by one turns 255 into 0. So
//!   this one is exact, and it is the integer transform "islow" of the Independent JPEG Group,
//!   which HP's encoder and nearly every decoder use (ruling `jpeg-samples`). Its arithmetic was
//!   published by the Group; the structure is the one of Loeffler, Ligtenberg and Moschytz (ICASSP
//!   1989).
//!   This file is based in part on the work of the Independent JPEG Group.
//! - The last step of that transform keeps ten bits of the result, as a signed number, and clamps
//!   those. For every stream that an encoder made this is plain clamping; for coefficients that are
//!   out of all bounds it wraps.
//! - 16-bit quantisation tables occur with 8-bit samples, although B.2.4.1 rules them out in one
//!   sentence: libjpeg writes them, under SOF1, whenever the quality is below 24. So they are read
//!   under SOF0 as well.
//! - A scan of one component has its blocks in plain raster order, and one block is one MCU,
//!   whatever the component's sampling factors say (A.2.2). A restart interval counts these blocks.
//! - The bits left over at the end of a scan or of an interval should be ones (F.1.2.3); nobody
//!   checks them.
//! - A code of nothing but ones is never given out (Annex C), so a table of two codes of one bit is
//!   illegal.
//! - Tables must stand before the scan header that names them, not before the frame header.

use std::num::Wrapping;

use super::{
    Error, Frame, Input, Marker, Result, Scan, malformed, marker, room_for_samples, unsupported,
};

#[cfg(feature = "generate")]
pub use write::{Options, encode};

/// Markers that only JPEG has (Table B.1).
const SOF0: u8 = 0xC0;
const SOF1: u8 = 0xC1;
const DHT: u8 = 0xC4;
const DQT: u8 = 0xDB;

/// Where the k-th coefficient of the stream stands in its block, in rows from the top left (A.3.6).
const ZIGZAG: [u8; 64] = [
    0, 1, 8, 16, 9, 2, 3, 10, //
    17, 24, 32, 25, 18, 11, 4, 5, //
    12, 19, 26, 33, 40, 48, 41, 34, //
    27, 20, 13, 6, 7, 14, 21, 28, //
    35, 42, 49, 56, 57, 50, 43, 36, //
    29, 22, 15, 23, 30, 37, 44, 51, //
    58, 59, 52, 45, 38, 31, 39, 46, //
    53, 60, 61, 54, 47, 55, 62, 63,
];

/// Decodes a JPEG stream of one component and `width` × `height` samples, in row order from the
/// top.
///
/// # Errors
///
/// [`Class::Malformed`](super::Class) if the stream breaks the standard, has another size or
/// another number of components; [`Class::Unsupported`](super::Class) for the processes of T.81
/// other than sequential Huffman with 8 bits.
pub fn decode(stream: &[u8], width: u32, height: u32) -> Result<Vec<u8>> {
    let mut input = Input::open(stream)?;
    let mut tables = Tables::default();
    let frame = read_frame(&mut input, &mut tables, width, height)?;
    let scan = read_scan(&mut input, &mut tables, &frame)?;
    let samples = read_samples(&mut input, &tables, &scan, width, height)?;
    read_end(&mut input, &mut tables)?;
    Ok(samples)
}

// B.2: the frame header, the scan header and the end; tables and other segments before each.

fn read_frame(input: &mut Input, tables: &mut Tables, width: u32, height: u32) -> Result<Frame> {
    let marker = tables.read(input)?;
    match marker.code {
        SOF0 | SOF1 => Frame::read(input, width, height, &[12]),
        _ => Err(unexpected(marker, "a frame header")),
    }
}

/// The tables of the one scan, by number.
struct ScanTables {
    quantisation: usize,
    dc: usize,
    ac: usize,
}

fn read_scan(input: &mut Input, tables: &mut Tables, frame: &Frame) -> Result<ScanTables> {
    let marker = tables.read(input)?;
    if marker.code != marker::SOS {
        return Err(unexpected(marker, "the scan header"));
    }
    let scan = Scan::read(input, frame)?;
    let numbers = ScanTables {
        quantisation: usize::from(frame.table),
        dc: usize::from(scan.tables >> 4),
        ac: usize::from(scan.tables & 15),
    };
    // All of the spectrum in one go, and no successive approximation: the rest is for progressive
    // frames (Table B.3).
    if scan.parameters != [0, 63, 0] {
        let [first, last, approximation] = scan.parameters;
        return Err(malformed(
            scan.at + 1,
            format!(
                "a sequential scan has parameters 0 63 0, found {first} {last} {approximation}"
            ),
        ));
    }
    let missing = |kind, number| malformed(scan.at, format!("{kind} {number} was not defined"));
    if !tables
        .quantisation
        .get(numbers.quantisation)
        .is_some_and(Option::is_some)
    {
        return Err(missing("quantisation table", numbers.quantisation));
    }
    if !tables.dc.get(numbers.dc).is_some_and(Option::is_some) {
        return Err(missing("DC Huffman table", numbers.dc));
    }
    if !tables.ac.get(numbers.ac).is_some_and(Option::is_some) {
        return Err(missing("AC Huffman table", numbers.ac));
    }
    Ok(numbers)
}

fn read_end(input: &mut Input, tables: &mut Tables) -> Result<()> {
    let marker = tables.read(input)?;
    if marker.code == marker::EOI {
        Ok(())
    } else {
        Err(unexpected(marker, "the end of the image"))
    }
}

/// Says of a marker in the wrong place whether another process of T.81 would have used it.
fn unexpected(marker: Marker, expected: &str) -> Error {
    let process = match marker.code {
        0xC2 => "progressive",
        0xC3 => "lossless",
        0xC5..=0xC7 | 0xCD..=0xCF | 0xDE | 0xDF => "hierarchical",
        0xC9..=0xCC => "arithmetic",
        marker::DNL => return unsupported(marker.at, "a height told by DNL is not implemented"),
        0xF7 => {
            return malformed(
                marker.at,
                format!("expected {expected}, found a JPEG-LS frame"),
            );
        }
        _ => return malformed(marker.at, format!("expected {expected}, found {marker}")),
    };
    unsupported(
        marker.at,
        format!("{process} coding ({marker}) is not implemented"),
    )
}

// B.2.4: tables and miscellaneous segments.

#[derive(Default)]
struct Tables {
    /// In zigzag order, as stored.
    quantisation: [Option<[u16; 64]>; 4],
    dc: [Option<Box<Huffman>>; 4],
    ac: [Option<Box<Huffman>>; 4],
    /// In blocks; 0 for none.
    restart_interval: u16,
}

impl Tables {
    /// Reads table segments, steps over comments and application data, and returns the first other
    /// marker.
    fn read(&mut self, input: &mut Input) -> Result<Marker> {
        loop {
            let marker = input.marker()?;
            match marker.code {
                DQT => self.read_quantisation(input.segment("the quantisation table segment")?)?,
                DHT => self.read_huffman(input.segment("the Huffman table segment")?)?,
                marker::DRI => {
                    self.read_restart_interval(input.segment("the restart interval segment")?)?;
                }
                marker::COM | marker::APP0..=marker::APP15 => {
                    input.segment("a comment or application segment")?;
                }
                _ => return Ok(marker),
            }
        }
    }

    /// B.2.4.1: any number of tables, each a byte of precision and number, then 64 divisors.
    fn read_quantisation(&mut self, mut segment: Input) -> Result<()> {
        while !segment.at_end() {
            let at = segment.at;
            let byte = segment.byte("a quantisation table")?;
            let (precision, number) = (byte >> 4, usize::from(byte & 15));
            if precision > 1 || number > 3 {
                return Err(malformed(
                    at,
                    format!("no quantisation table has precision {precision} and number {number}"),
                ));
            }
            let mut table = [0; 64];
            for divisor in &mut table {
                let at = segment.at;
                *divisor = match precision {
                    0 => u16::from(segment.byte("64 divisors")?),
                    _ => segment.u16("64 divisors")?,
                };
                if *divisor == 0 {
                    return Err(malformed(at, "a quantisation table holds a zero"));
                }
            }
            self.quantisation[number] = Some(table);
        }
        Ok(())
    }

    /// B.2.4.2: any number of tables, each a byte of class and number, then the codes.
    fn read_huffman(&mut self, mut segment: Input) -> Result<()> {
        while !segment.at_end() {
            let at = segment.at;
            let byte = segment.byte("a Huffman table")?;
            let (class, number) = (byte >> 4, usize::from(byte & 15));
            if class > 1 || number > 3 {
                return Err(malformed(
                    at,
                    format!("no Huffman table has class {class} and number {number}"),
                ));
            }
            let table = Some(Box::new(Huffman::read(&mut segment)?));
            if class == 0 {
                self.dc[number] = table;
            } else {
                self.ac[number] = table;
            }
        }
        Ok(())
    }

    /// B.2.4.4.
    fn read_restart_interval(&mut self, mut segment: Input) -> Result<()> {
        self.restart_interval = segment.u16("the restart interval")?;
        segment.expect_end()
    }
}

/// Codes up to this length are found with one look; longer ones are rare.
const SHORT: u32 = 9;

/// A Huffman table, made ready for reading (Annex C, F.2.2.3).
///
/// Codes are given out in order: the first of the shortest length is all zeros, each next one is
/// one more, and with each bit of length the count doubles. So a table needs only the number of
/// codes of each length, and the symbols in order.
struct Huffman {
    /// For each possible next nine bits: length (high byte) and symbol (low byte) of the code they
    /// begin with; 0 if it is longer or none.
    short: [u16; 1 << SHORT],
    /// By length: the first sixteen bits that are too large to begin with a code of this length.
    beyond: [u32; 17],
    /// By length: where the symbols of this length would begin if its codes began at zero.
    base: [i32; 17],
    symbols: [u8; 256],
}

impl Huffman {
    fn read(segment: &mut Input) -> Result<Huffman> {
        let at = segment.at;
        let mut counts = [0_u8; 17];
        for count in &mut counts[1..] {
            *count = segment.byte("16 numbers of codes")?;
        }
        let total: usize = counts.iter().map(|&count| usize::from(count)).sum();
        if total > 256 {
            return Err(malformed(
                at,
                format!("a Huffman table of {total} codes has more than 256"),
            ));
        }
        let mut symbols = [0; 256];
        for symbol in &mut symbols[..total] {
            *symbol = segment.byte("the symbols of a Huffman table")?;
        }

        let mut table = Huffman {
            short: [0; 1 << SHORT],
            beyond: [0; 17],
            base: [0; 17],
            symbols,
        };
        let mut code = 0_u32; // the next one to give out
        let mut given = 0; // how many have been
        for length in 1..=16 {
            let count = u32::from(counts[length as usize]);
            // One code must be left over, the one of all ones.
            if code + count >= 1 << length {
                return Err(malformed(
                    at,
                    format!("a Huffman table has too many codes of {length} bits"),
                ));
            }
            table.base[length as usize] = given - code as i32;
            for _ in 0..count {
                if length <= SHORT {
                    let first = (code << (SHORT - length)) as usize;
                    let entry = (length as u16) << 8 | u16::from(symbols[given as usize]);
                    table.short[first..first + (1 << (SHORT - length))].fill(entry);
                }
                code += 1;
                given += 1;
            }
            table.beyond[length as usize] = code << (16 - length);
            code <<= 1;
        }
        Ok(table)
    }
}

// B.1.1.5, F.2.2: the entropy-coded segment.

/// The bits of an entropy-coded segment, first bit of a byte first (F.2.2.5).
///
/// A byte 0xFF in the data is followed by a stuffed zero (F.1.2.3), so 0xFF and anything else is
/// the marker that ends it.
struct Bits<'a> {
    stream: &'a [u8],
    at: usize,
    /// The next bits, from the top; zeros below them.
    window: u64,
    /// How many of them there are.
    count: u32,
}

impl Bits<'_> {
    /// Fills the window: at least 57 bits, unless the data ends.
    #[inline]
    fn fill(&mut self) {
        if self.count > 56 {
            return;
        }
        // Eight bytes at once if there is no 0xFF among them, which would be a zero byte of the
        // complement.
        let rest = self.stream.get(self.at..).unwrap_or_default();
        if let Some(eight) = rest.first_chunk() {
            let eight = u64::from_be_bytes(*eight);
            let complement = !eight;
            if complement.wrapping_sub(0x0101_0101_0101_0101) & !complement & 0x8080_8080_8080_8080
                == 0
            {
                let bytes = (64 - self.count) / 8;
                self.window |= (eight >> (64 - 8 * bytes)) << (64 - self.count - 8 * bytes);
                self.count += 8 * bytes;
                self.at += bytes as usize;
                return;
            }
        }
        while self.count <= 56 {
            let Some(&byte) = self.stream.get(self.at) else {
                return;
            };
            if byte == 0xFF && self.stream.get(self.at + 1) != Some(&0) {
                return;
            }
            self.window |= u64::from(byte) << (56 - self.count);
            self.count += 8;
            self.at += if byte == 0xFF { 2 } else { 1 };
        }
    }

    /// Steps over bits of the window, if they are there.
    #[inline]
    fn skip(&mut self, bits: u32) -> Result<()> {
        if bits > self.count {
            return Err(malformed(self.at, "the entropy-coded data ends too early"));
        }
        self.window <<= bits;
        self.count -= bits;
        Ok(())
    }

    /// F.2.2.3: the next code of a table, as its symbol. Afterwards at least 25 bits are still in
    /// the window.
    #[inline]
    fn symbol(&mut self, table: &Huffman) -> Result<u8> {
        if self.count < 41 {
            self.fill();
        }
        let entry = table.short[(self.window >> (64 - SHORT)) as usize];
        if entry != 0 {
            self.skip(u32::from(entry >> 8))?;
            return Ok(entry as u8);
        }
        let next = (self.window >> 48) as u32;
        let Some(length) = (SHORT + 1..=16).find(|&length| next < table.beyond[length as usize])
        else {
            // Beyond the last code even with zeros behind the data, so more data would not help.
            let what = "the next bits are no code of the Huffman table";
            return Err(malformed(self.offset(), what));
        };
        self.skip(length)?;
        let index = table.base[length as usize] + (next >> (16 - length)) as i32;
        Ok(table.symbols[index as usize])
    }

    /// F.2.2.1, F.2.2.4: a number of `size` bits. Its first bit tells the sign: the values of five
    /// bits are −31 … −16 (codes 0 … 15) and 16 … 31 (codes 16 … 31).
    #[inline]
    fn number(&mut self, size: u8) -> Result<i32> {
        let size = u32::from(size);
        // In two steps, because a shift by all 64 bits is not defined.
        let bits = (self.window >> 1 >> (63 - size)) as i32;
        self.skip(size)?;
        let negative = size > 0 && bits >> (size - 1) == 0;
        Ok(if negative {
            bits - (1 << size) + 1
        } else {
            bits
        })
    }

    /// The byte of the stream that holds the next bit.
    fn offset(&self) -> usize {
        let mut at = self.at;
        for _ in 0..self.count.div_ceil(8) {
            at -= if self.stream[..at].ends_with(&[0xFF, 0]) {
                2
            } else {
                1
            };
        }
        at
    }

    /// Drops the bits that fill the last byte; the data must end there.
    fn finish(&mut self) -> Result<()> {
        self.fill();
        if self.count >= 8 {
            return Err(malformed(
                self.offset() + 1,
                "the entropy-coded data goes on after the last block",
            ));
        }
        (self.window, self.count) = (0, 0);
        Ok(())
    }
}

/// E.2.3, E.2.4: all blocks of the scan, in raster order, in intervals that start afresh.
fn read_samples(
    input: &mut Input,
    tables: &Tables,
    scan: &ScanTables,
    width: u32,
    height: u32,
) -> Result<Vec<u8>> {
    let (Some(quantisation), Some(dc), Some(ac)) = (
        &tables.quantisation[scan.quantisation],
        &tables.dc[scan.dc],
        &tables.ac[scan.ac],
    ) else {
        unreachable!("the scan header was read, which refuses tables that were not defined")
    };

    let (columns, rows) = (width.div_ceil(8), height.div_ceil(8));
    // No code is shorter than a bit, and a block is at least a DC code and an end of block. This
    // keeps a short stream from claiming a large image.
    if (input.stream.len() - input.at) as u64 * 4 < u64::from(columns) * u64::from(rows) {
        let what = format!("{columns} x {rows} blocks cannot be held by the bytes that remain");
        return Err(malformed(input.at, what));
    }
    let mut samples = room_for_samples(width, height, input.at)?;
    let (width, height) = (width as usize, height as usize);
    samples.resize(width * height, 0);

    let mut bits = Bits {
        stream: input.stream,
        at: input.at,
        window: 0,
        count: 0,
    };
    let mut previous_dc = 0;
    let mut left = tables.restart_interval; // in this interval
    let mut restarts = 0_u8;
    let mut block = [0; 64];
    for top in (0..height).step_by(8) {
        let strip_end = (top + 8).min(height) * width;
        let strip = &mut samples[top * width..strip_end];
        for x in (0..width).step_by(8) {
            if tables.restart_interval > 0 {
                if left == 0 {
                    read_restart(&mut bits, restarts)?;
                    restarts = (restarts + 1) % 8;
                    previous_dc = 0;
                    left = tables.restart_interval;
                }
                left -= 1;
            }
            read_block(
                &mut bits,
                dc,
                ac,
                quantisation,
                &mut previous_dc,
                &mut block,
            )?;
            let decoded = inverse_transform(&block);
            // The last column and row of blocks may stick out of the image (A.2.4).
            let inside = (width - x).min(8);
            for (row, from) in strip.chunks_exact_mut(width).zip(decoded.chunks_exact(8)) {
                row[x..x + inside].copy_from_slice(&from[..inside]);
            }
        }
    }
    bits.finish()?;
    input.at = bits.at;
    Ok(samples)
}

/// E.2.4: between two intervals stands a restart marker, and these count from 0 to 7 and over
/// again.
fn read_restart(bits: &mut Bits, number: u8) -> Result<()> {
    bits.finish()?;
    let mut input = Input {
        stream: bits.stream,
        at: bits.at,
        name: "the stream",
    };
    let marker = input.marker()?;
    if marker.code != marker::RST0 + number {
        return Err(unexpected(marker, &format!("restart marker {number}")));
    }
    bits.at = input.at;
    Ok(())
}

/// F.2.2: one block, multiplied by the divisors on the way (A.3.4), in rows from the top left.
fn read_block(
    bits: &mut Bits,
    dc: &Huffman,
    ac: &Huffman,
    divisors: &[u16; 64],
    previous_dc: &mut i32,
    block: &mut [i32; 64],
) -> Result<()> {
    block.fill(0);

    // F.2.2.1: the size of the difference, then the difference. Table F.1 ends at 11 bits for
    // samples of 8.
    let size = bits.symbol(dc)?;
    if size > 11 {
        return Err(malformed(
            bits.offset(),
            format!("a DC difference of {size} bits does not exist"),
        ));
    }
    *previous_dc += bits.number(size)?;
    // The sum of 64 samples of at most 128, over 8, needs eleven bits; a divisor only makes it
    // smaller.
    if !(-2048..2048).contains(previous_dc) {
        return Err(malformed(
            bits.offset(),
            format!("a DC coefficient of {previous_dc} does not exist"),
        ));
    }
    block[0] = *previous_dc * i32::from(divisors[0]);

    // F.2.2.2: pairs of a run of zeros and the size of what follows it, until the end of the block.
    let mut k = 1;
    while k < 64 {
        let symbol = bits.symbol(ac)?;
        let (run, size) = (usize::from(symbol >> 4), symbol & 15);
        match (run, size) {
            (0, 0) => break, // EOB: nothing but zeros
            (_, 1..=10) => k += run,
            (15, 0) => k += 15, // ZRL: fifteen zeros and then a zero
            _ => {
                return Err(malformed(
                    bits.offset(),
                    format!("an AC code for run {run}, size {size} does not exist"),
                ));
            }
        }
        if k > 63 || (k == 63 && size == 0) {
            return Err(malformed(bits.offset(), "a run of zeros leaves the block"));
        }
        block[usize::from(ZIGZAG[k])] = bits.number(size)? * i32::from(divisors[k]);
        k += 1;
    }
    Ok(())
}

// A.3.3: the inverse transform, as the Independent JPEG Group computes it.

/// Factors are multiplied by 2¹³ and rounded.
const FRACTION: u32 = 13;

/// Between the two passes values keep two more bits than samples need.
const EXTRA: u32 = 2;

/// `factor!(0.541196100)` is that number with 13 bits of fraction.
macro_rules! factor {
    ($value:literal) => {
        const { ($value * (1 << FRACTION) as f64 + 0.5) as i32 }
    };
}

/// Division by a power of two that rounds halves up.
#[inline]
fn round_off(value: i32, bits: u32) -> i32 {
    value.wrapping_add(1 << (bits - 1)) >> bits
}

/// Rows to columns.
fn transpose(block: &mut [i32; 64]) {
    for y in 0..8 {
        for x in 0..y {
            block.swap(8 * y + x, 8 * x + y);
        }
    }
}

/// From frequencies (in rows) to samples: all columns, then all rows.
///
/// 32 bits are enough for both passes. What the second returns may be too large for them, but of
/// that only the ten bits from bit 18 on are kept, and these come out right. Of the first all bits
/// count, so frequencies of more than 14 bits, which no encoder makes, are cut in two, and as all
/// is sums and products up to the rounding, the upper parts are brought in after it.
fn inverse_transform(block: &[i32; 64]) -> [u8; 64] {
    const CUT: u32 = 14;
    let (mut block, mut upper) = (*block, [0; 64]);
    let mut any_upper = 0;
    for (lower, upper) in block.iter_mut().zip(&mut upper) {
        *upper = round_off(*lower, CUT);
        *lower -= *upper << CUT;
        any_upper |= *upper;
    }
    inverse_of_columns(&mut block);
    for value in &mut block {
        *value = round_off(*value, FRACTION - EXTRA);
    }
    if any_upper != 0 {
        inverse_of_columns(&mut upper);
        for (value, upper) in block.iter_mut().zip(&upper) {
            *value = value.wrapping_add(upper << (CUT - (FRACTION - EXTRA)));
        }
    }
    transpose(&mut block);
    inverse_of_columns(&mut block);
    transpose(&mut block);
    let mut samples = [0; 64];
    for (sample, value) in samples.iter_mut().zip(&block) {
        // Three more bits, because two passes of this kind multiply by eight.
        *sample = to_sample(round_off(*value, FRACTION + EXTRA + 3));
    }
    samples
}

/// A.3.1 takes 128 off every sample before the transform; here it comes back, and what leaves
/// 0 … 255 is clamped.
///
/// Ten bits of the value are kept first, as the Group's table look-up does (see the format notes).
#[inline]
fn to_sample(value: i32) -> u8 {
    let ten_bits = (value << 22) >> 22;
    (ten_bits + 128).clamp(0, 255) as u8
}

fn inverse_of_columns(block: &mut [i32; 64]) {
    for x in 0..8 {
        let column = inverse_of_eight(std::array::from_fn(|y| Wrapping(block[8 * y + x])));
        for y in 0..8 {
            block[8 * y + x] = column[y].0;
        }
    }
}

/// The inverse transform in one dimension, times √8 and times 2¹³.
#[inline]
fn inverse_of_eight(c: [Wrapping<i32>; 8]) -> [Wrapping<i32>; 8] {
    let times = |value: Wrapping<i32>, factor: i32| value * Wrapping(factor);

    // The even frequencies: 0 and 4 need no factor, 2 and 6 are turned by 6π/16 with three
    // multiplications.
    let turn = times(c[2] + c[6], factor!(0.541_196_100));
    let low = turn + times(c[2], factor!(0.765_366_865));
    let high = turn - times(c[6], factor!(1.847_759_065));
    let sum = times(c[0] + c[4], 1 << FRACTION);
    let difference = times(c[0] - c[4], 1 << FRACTION);
    let even = [sum + low, difference + high, difference - high, sum - low];

    // The odd frequencies: four pairs of them share one product each, and all share one.
    let shared = times(c[7] + c[3] + c[5] + c[1], factor!(1.175_875_602));
    let pair_71 = -times(c[7] + c[1], factor!(0.899_976_223));
    let pair_53 = -times(c[5] + c[3], factor!(2.562_915_447));
    let pair_73 = shared - times(c[7] + c[3], factor!(1.961_570_560));
    let pair_51 = shared - times(c[5] + c[1], factor!(0.390_180_644));
    let odd = [
        times(c[1], factor!(1.501_321_110)) + pair_71 + pair_51,
        times(c[3], factor!(3.072_711_026)) + pair_53 + pair_73,
        times(c[5], factor!(2.053_119_869)) + pair_53 + pair_51,
        times(c[7], factor!(0.298_631_336)) + pair_71 + pair_73,
    ];

    // Even frequencies are symmetric about the middle, odd ones change their sign there.
    [
        even[0] + odd[0],
        even[1] + odd[1],
        even[2] + odd[2],
        even[3] + odd[3],
        even[3] - odd[3],
        even[2] - odd[2],
        even[1] - odd[1],
        even[0] - odd[0],
    ]
}

#[cfg(feature = "generate")]
mod write {
    //! The same way forth, as libjpeg goes it: with the default options every byte equals what
    //! `cjpeg -baseline -dct int -grayscale -quality Q` writes.

    use super::super::{Encoded, marker};
    use super::{DHT, DQT, EXTRA, FRACTION, SOF0, SOF1, ZIGZAG, inverse_transform, round_off};

    /// How to encode; the spellings of one image that the standard allows.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub struct Options {
        /// 1 … 100, as the Independent JPEG Group counts it.
        pub quality: u8,
        /// No divisor over 255, so that the frame is baseline (SOF0) at every quality. Without, a
        /// quality below 24 needs 16-bit tables and an extended sequential frame (SOF1).
        pub baseline: bool,
        /// Huffman tables made for this image instead of those of Annex K.
        pub optimised: bool,
        /// Blocks from one restart marker to the next; 0 for no restart markers.
        pub restart_interval: u16,
        /// Horizontal and vertical sampling factor of the component, 1 … 4. They change nothing but
        /// their byte.
        pub sampling: (u8, u8),
    }

    impl Options {
        /// The ordinary file of a quality: baseline, the tables of Annex K, no restart markers,
        /// factors 1 × 1.
        #[must_use]
        pub fn new(quality: u8) -> Options {
            Options {
                quality,
                baseline: true,
                optimised: false,
                restart_interval: 0,
                sampling: (1, 1),
            }
        }
    }

    /// Encodes `width` × `height` samples, given in row order from the top.
    ///
    /// # Panics
    ///
    /// If there are not `width` × `height` samples, a side is not within 1 … 65,535, or an option
    /// is out of its range.
    #[must_use]
    pub fn encode(samples: &[u8], width: u32, height: u32, options: &Options) -> Encoded {
        assert!(
            (1..=0xFFFF).contains(&width) && (1..=0xFFFF).contains(&height),
            "no JPEG has {width} x {height} samples"
        );
        assert_eq!(
            samples.len(),
            width as usize * height as usize,
            "samples of a picture of {width} x {height}"
        );
        assert!(
            (1..=100).contains(&options.quality),
            "quality {}",
            options.quality
        );
        let (h, v) = options.sampling;
        assert!(
            (1..=4).contains(&h) && (1..=4).contains(&v),
            "sampling factors {h} x {v}"
        );

        let divisors = scaled_divisors(options.quality, options.baseline);
        let (blocks, decoded) =
            quantised_blocks(samples, width as usize, height as usize, &divisors);
        let symbols = symbols_of(&blocks, usize::from(options.restart_interval));
        let codes = if options.optimised {
            Codes::made_for(&symbols)
        } else {
            Codes::of_annex_k()
        };

        let mut stream = vec![0xFF, marker::SOI];
        write_jfif(&mut stream);
        write_quantisation(&mut stream, &divisors);
        write_frame_header(&mut stream, &divisors, width, height, options.sampling);
        write_huffman(&mut stream, 0x00, &codes.dc);
        write_huffman(&mut stream, 0x10, &codes.ac);
        if options.restart_interval > 0 {
            segment(
                &mut stream,
                marker::DRI,
                &options.restart_interval.to_be_bytes(),
            );
        }
        segment(&mut stream, marker::SOS, &[1, 1, 0x00, 0, 63, 0]); // B.2.3
        write_symbols(&mut stream, &symbols, &codes);
        stream.extend([0xFF, marker::EOI]);
        Encoded {
            stream,
            samples: decoded,
        }
    }

    // A.3: samples → quantised frequencies.

    /// Divisors for luminance at quality 50, in rows (Table K.1).
    #[rustfmt::skip]
    const LUMINANCE: [u32; 64] = [
        16, 11, 10, 16,  24,  40,  51,  61,
        12, 12, 14, 19,  26,  58,  60,  55,
        14, 13, 16, 24,  40,  57,  69,  56,
        14, 17, 22, 29,  51,  87,  80,  62,
        18, 22, 37, 56,  68, 109, 103,  77,
        24, 35, 55, 64,  81, 104, 113,  92,
        49, 64, 78, 87, 103, 121, 120, 101,
        72, 92, 95, 98, 112, 100, 103,  99,
    ];

    /// The Group's meaning of quality: a percentage by which the table of the standard is
    /// multiplied, 100 at quality 50; from there down it is 5,000 / quality, upwards it falls by
    /// two to zero.
    fn scaled_divisors(quality: u8, baseline: bool) -> [u16; 64] {
        let quality = u32::from(quality);
        let percent = if quality < 50 {
            5000 / quality
        } else {
            200 - 2 * quality
        };
        let largest = if baseline { 255 } else { 32767 };
        LUMINANCE.map(|divisor| ((divisor * percent + 50) / 100).clamp(1, largest) as u16)
    }

    /// All blocks in raster order, each in zigzag order, and the samples they turn back into.
    fn quantised_blocks(
        samples: &[u8],
        width: usize,
        height: usize,
        divisors: &[u16; 64],
    ) -> (Vec<[i16; 64]>, Vec<u8>) {
        let mut blocks = Vec::new();
        let mut decoded = vec![0; samples.len()];
        for top in (0..height).step_by(8) {
            for left in (0..width).step_by(8) {
                // Blocks that stick out are filled up with the last column and row (A.2.4).
                let block = std::array::from_fn(|i| {
                    let (x, y) = ((left + i % 8).min(width - 1), (top + i / 8).min(height - 1));
                    i32::from(samples[y * width + x]) - 128 // A.3.1
                });
                let frequencies = forward_transform(&block);
                let quotients: [i32; 64] =
                    std::array::from_fn(|i| quantise(frequencies[i], divisors[i]));

                let back = inverse_transform(&std::array::from_fn(|i| {
                    quotients[i] * i32::from(divisors[i])
                }));
                for y in top..(top + 8).min(height) {
                    let inside = (width - left).min(8);
                    decoded[y * width + left..][..inside]
                        .copy_from_slice(&back[8 * (y - top)..][..inside]);
                }
                blocks.push(ZIGZAG.map(|i| quotients[usize::from(i)] as i16));
            }
        }
        (blocks, decoded)
    }

    /// A.3.4, with halves away from zero. The transform left a factor of eight in.
    fn quantise(frequency: i32, divisor: u16) -> i32 {
        let divisor = i32::from(divisor) * 8;
        let quotient = (frequency.abs() + divisor / 2) / divisor;
        quotient * frequency.signum()
    }

    /// A.3.3, as the Independent JPEG Group computes it: all rows, then all columns. The result is
    /// eight times too large.
    fn forward_transform(block: &[i32; 64]) -> [i32; 64] {
        let mut half = [0; 64];
        for y in 0..8 {
            let row = std::array::from_fn(|x| block[8 * y + x]);
            for (x, value) in forward_of_eight(row).into_iter().enumerate() {
                half[8 * y + x] = round_off(value, FRACTION - EXTRA);
            }
        }
        let mut frequencies = [0; 64];
        for x in 0..8 {
            let column = std::array::from_fn(|y| half[8 * y + x]);
            for (y, value) in forward_of_eight(column).into_iter().enumerate() {
                frequencies[8 * y + x] = round_off(value, FRACTION + EXTRA);
            }
        }
        frequencies
    }

    /// The forward transform in one dimension, times √8 and times 2¹³: the inverse one, read
    /// backwards.
    fn forward_of_eight(s: [i32; 8]) -> [i32; 8] {
        let even = [s[0] + s[7], s[1] + s[6], s[2] + s[5], s[3] + s[4]];
        let odd = [s[0] - s[7], s[1] - s[6], s[2] - s[5], s[3] - s[4]];

        let (outer, inner) = (even[0] + even[3], even[1] + even[2]);
        let (low, high) = (even[0] - even[3], even[1] - even[2]);
        let turn = (low + high) * factor!(0.541_196_100);

        let shared = (odd[0] + odd[1] + odd[2] + odd[3]) * factor!(1.175_875_602);
        let pair_30 = (odd[3] + odd[0]) * -factor!(0.899_976_223);
        let pair_21 = (odd[2] + odd[1]) * -factor!(2.562_915_447);
        let pair_31 = (odd[3] + odd[1]) * -factor!(1.961_570_560) + shared;
        let pair_20 = (odd[2] + odd[0]) * -factor!(0.390_180_644) + shared;

        [
            (outer + inner) << FRACTION,
            odd[0] * factor!(1.501_321_110) + pair_30 + pair_20,
            turn + low * factor!(0.765_366_865),
            odd[1] * factor!(3.072_711_026) + pair_21 + pair_31,
            (outer - inner) << FRACTION,
            odd[2] * factor!(2.053_119_869) + pair_21 + pair_20,
            turn - high * factor!(1.847_759_065),
            odd[3] * factor!(0.298_631_336) + pair_30 + pair_31,
        ]
    }

    // F.1.2: quantised frequencies → symbols.

    /// What is written: a Huffman code and some more bits, or a restart marker.
    enum Symbol {
        Dc { size: u8, bits: u32 },
        Ac { run_and_size: u8, bits: u32 },
        Restart { number: u8 },
    }

    fn symbols_of(blocks: &[[i16; 64]], restart_interval: usize) -> Vec<Symbol> {
        let mut symbols = Vec::new();
        let mut previous_dc = 0;
        for (index, block) in blocks.iter().enumerate() {
            if restart_interval > 0 && index > 0 && index % restart_interval == 0 {
                symbols.push(Symbol::Restart {
                    number: ((index / restart_interval - 1) % 8) as u8,
                });
                previous_dc = 0;
            }

            let (size, bits) = size_and_bits(i32::from(block[0]) - previous_dc);
            symbols.push(Symbol::Dc { size, bits });
            previous_dc = i32::from(block[0]);

            let mut run = 0;
            for &coefficient in &block[1..] {
                if coefficient == 0 {
                    run += 1;
                    continue;
                }
                while run > 15 {
                    symbols.push(Symbol::Ac {
                        run_and_size: 0xF0,
                        bits: 0,
                    }); // ZRL
                    run -= 16;
                }
                let (size, bits) = size_and_bits(i32::from(coefficient));
                symbols.push(Symbol::Ac {
                    run_and_size: run << 4 | size,
                    bits,
                });
                run = 0;
            }
            if run > 0 {
                symbols.push(Symbol::Ac {
                    run_and_size: 0x00,
                    bits: 0,
                }); // EOB
            }
        }
        symbols
    }

    /// F.1.2.1: the bits that a number needs without its sign, and these; a negative number less
    /// one, so that its first bit is a zero.
    fn size_and_bits(value: i32) -> (u8, u32) {
        let size = 32 - value.unsigned_abs().leading_zeros();
        let bits = if value < 0 { value - 1 } else { value };
        (size as u8, bits as u32 & ((1 << size) - 1))
    }

    // Annex C, K.2, K.3: symbols → codes.

    /// A Huffman table: the number of codes of each length, and the symbols in the order of their
    /// codes.
    struct Table {
        counts: [u8; 16],
        symbols: Vec<u8>,
    }

    /// The tables for both kinds of symbols.
    struct Codes {
        dc: Table,
        ac: Table,
    }

    impl Codes {
        /// The typical tables of K.3 for luminance: K.3 and K.5.
        fn of_annex_k() -> Codes {
            Codes {
                dc: Table {
                    counts: [0, 1, 5, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0],
                    symbols: (0..=11).collect(),
                },
                ac: Table {
                    counts: [0, 2, 1, 3, 3, 2, 4, 3, 5, 5, 4, 4, 0, 0, 1, 125],
                    symbols: AC_SYMBOLS.to_vec(),
                },
            }
        }

        fn made_for(symbols: &[Symbol]) -> Codes {
            let (mut dc, mut ac) = ([0; 256], [0; 256]);
            for symbol in symbols {
                match *symbol {
                    Symbol::Dc { size, .. } => dc[usize::from(size)] += 1,
                    Symbol::Ac { run_and_size, .. } => ac[usize::from(run_and_size)] += 1,
                    Symbol::Restart { .. } => {}
                }
            }
            Codes {
                dc: Table::made_for(&dc),
                ac: Table::made_for(&ac),
            }
        }
    }

    /// The symbols of Table K.5, shortest code first.
    #[rustfmt::skip]
    const AC_SYMBOLS: [u8; 162] = [
        0x01, 0x02, 0x03, 0x00, 0x04, 0x11, 0x05, 0x12, 0x21, 0x31, 0x41, 0x06, 0x13, 0x51,
        0x61, 0x07, 0x22, 0x71, 0x14, 0x32, 0x81, 0x91, 0xA1, 0x08, 0x23, 0x42, 0xB1, 0xC1,
        0x15, 0x52, 0xD1, 0xF0, 0x24, 0x33, 0x62, 0x72, 0x82, 0x09, 0x0A, 0x16, 0x17, 0x18,
        0x19, 0x1A, 0x25, 0x26, 0x27, 0x28, 0x29, 0x2A, 0x34, 0x35, 0x36, 0x37, 0x38, 0x39,
        0x3A, 0x43, 0x44, 0x45, 0x46, 0x47, 0x48, 0x49, 0x4A, 0x53, 0x54, 0x55, 0x56, 0x57,
        0x58, 0x59, 0x5A, 0x63, 0x64, 0x65, 0x66, 0x67, 0x68, 0x69, 0x6A, 0x73, 0x74, 0x75,
        0x76, 0x77, 0x78, 0x79, 0x7A, 0x83, 0x84, 0x85, 0x86, 0x87, 0x88, 0x89, 0x8A, 0x92,
        0x93, 0x94, 0x95, 0x96, 0x97, 0x98, 0x99, 0x9A, 0xA2, 0xA3, 0xA4, 0xA5, 0xA6, 0xA7,
        0xA8, 0xA9, 0xAA, 0xB2, 0xB3, 0xB4, 0xB5, 0xB6, 0xB7, 0xB8, 0xB9, 0xBA, 0xC2, 0xC3,
        0xC4, 0xC5, 0xC6, 0xC7, 0xC8, 0xC9, 0xCA, 0xD2, 0xD3, 0xD4, 0xD5, 0xD6, 0xD7, 0xD8,
        0xD9, 0xDA, 0xE1, 0xE2, 0xE3, 0xE4, 0xE5, 0xE6, 0xE7, 0xE8, 0xE9, 0xEA, 0xF1, 0xF2,
        0xF3, 0xF4, 0xF5, 0xF6, 0xF7, 0xF8, 0xF9, 0xFA,
    ];

    impl Table {
        /// K.2: the shortest codes for symbols that occur so often, none over 16 bits.
        fn made_for(occurrences: &[u32; 256]) -> Table {
            // One more symbol takes the code of all ones, which nobody may have.
            const NOBODY: usize = 256;
            let mut weights: Vec<u32> = occurrences.iter().copied().chain([1]).collect();

            // Figure K.1: join the two lightest trees until one is left; each joining makes the
            // codes of all symbols in both a bit longer. Of equally light trees the one with the
            // larger first symbol counts as lighter.
            let mut trees: Vec<Vec<usize>> = (0..=NOBODY).map(|symbol| vec![symbol]).collect();
            let mut lengths = [0_usize; NOBODY + 1];
            loop {
                let lightest_but = |other: Option<usize>| {
                    let there = (0..=NOBODY)
                        .rev()
                        .filter(|&tree| weights[tree] > 0 && Some(tree) != other);
                    there.min_by_key(|&tree| weights[tree])
                };
                let first = lightest_but(None);
                let (Some(first), Some(second)) = (first, lightest_but(first)) else {
                    break;
                };
                let joined = std::mem::take(&mut trees[second]);
                trees[first].extend(joined);
                weights[first] += std::mem::take(&mut weights[second]);
                for &symbol in &trees[first] {
                    lengths[symbol] += 1;
                }
            }

            // Figure K.3: shorten codes of over 16 bits. Two siblings that are too long make room:
            // one goes up to their parent, the other becomes the sibling of a shorter code, which
            // moves down for it.
            let mut counts = [0_usize; 257];
            for &length in &lengths {
                counts[length] += 1;
            }
            for length in (17..=256).rev() {
                while counts[length] > 0 {
                    let shorter = (1..length - 1).rev().find(|&shorter| counts[shorter] > 0);
                    let shorter = shorter.unwrap_or_else(|| {
                        unreachable!("257 symbols do not need codes of over 16 bits each")
                    });
                    counts[length] -= 2;
                    counts[length - 1] += 1;
                    counts[shorter + 1] += 2;
                    counts[shorter] -= 1;
                }
            }
            // The longest of all is nobody's.
            let longest = (1..=16).rev().find(|&length| counts[length] > 0);
            counts[longest.unwrap_or_else(|| unreachable!("an image has symbols"))] -= 1;

            // Figure K.4: the symbols in the order of their lengths before shortening, then of
            // their values.
            let mut symbols: Vec<usize> = (0..NOBODY)
                .filter(|&symbol| occurrences[symbol] > 0)
                .collect();
            symbols.sort_by_key(|&symbol| lengths[symbol]);
            Table {
                counts: std::array::from_fn(|i| counts[i + 1] as u8),
                symbols: symbols.into_iter().map(|symbol| symbol as u8).collect(),
            }
        }

        /// Annex C: code and length for each symbol; length 0 for symbols that have none.
        fn codes(&self) -> [(u32, u32); 256] {
            let mut codes = [(0, 0); 256];
            let mut symbols = self.symbols.iter();
            let mut code = 0;
            for (length, &count) in (1..).zip(&self.counts) {
                for &symbol in symbols.by_ref().take(usize::from(count)) {
                    codes[usize::from(symbol)] = (code, length);
                    code += 1;
                }
                code <<= 1;
            }
            codes
        }
    }

    // B.2: the segments.

    fn segment(stream: &mut Vec<u8>, code: u8, content: &[u8]) {
        stream.extend([0xFF, code]);
        stream.extend((content.len() as u16 + 2).to_be_bytes());
        stream.extend(content);
    }

    /// The application segment of JFIF 1.01: no unit, pixels as wide as high, no thumbnail.
    fn write_jfif(stream: &mut Vec<u8>) {
        segment(
            stream,
            marker::APP0,
            b"JFIF\0\x01\x01\x00\x00\x01\x00\x01\x00\x00",
        );
    }

    fn wide(divisors: &[u16; 64]) -> bool {
        divisors.iter().any(|&divisor| divisor > 255)
    }

    /// B.2.4.1.
    fn write_quantisation(stream: &mut Vec<u8>, divisors: &[u16; 64]) {
        let mut content = vec![u8::from(wide(divisors)) << 4];
        for i in ZIGZAG {
            let divisor = divisors[usize::from(i)].to_be_bytes();
            content.extend(if wide(divisors) {
                &divisor[..]
            } else {
                &divisor[1..]
            });
        }
        segment(stream, DQT, &content);
    }

    /// B.2.2.
    fn write_frame_header(
        stream: &mut Vec<u8>,
        divisors: &[u16; 64],
        width: u32,
        height: u32,
        sampling: (u8, u8),
    ) {
        let mut content = vec![8];
        content.extend((height as u16).to_be_bytes());
        content.extend((width as u16).to_be_bytes());
        content.extend([1, 1, sampling.0 << 4 | sampling.1, 0]);
        segment(stream, if wide(divisors) { SOF1 } else { SOF0 }, &content);
    }

    /// B.2.4.2.
    fn write_huffman(stream: &mut Vec<u8>, class_and_number: u8, table: &Table) {
        let mut content = vec![class_and_number];
        content.extend(table.counts);
        content.extend(&table.symbols);
        segment(stream, DHT, &content);
    }

    /// B.1.1.5: the entropy-coded data.
    fn write_symbols(stream: &mut Vec<u8>, symbols: &[Symbol], codes: &Codes) {
        let (dc, ac) = (codes.dc.codes(), codes.ac.codes());
        let mut out = Bits {
            stream,
            window: 0,
            count: 0,
        };
        for symbol in symbols {
            match *symbol {
                Symbol::Dc { size, bits } => {
                    let (code, length) = dc[usize::from(size)];
                    out.put(code, length);
                    out.put(bits, u32::from(size));
                }
                Symbol::Ac { run_and_size, bits } => {
                    let (code, length) = ac[usize::from(run_and_size)];
                    out.put(code, length);
                    out.put(bits, u32::from(run_and_size & 15));
                }
                Symbol::Restart { number } => {
                    out.finish();
                    out.stream.extend([0xFF, marker::RST0 + number]);
                }
            }
        }
        out.finish();
    }

    struct Bits<'a> {
        stream: &'a mut Vec<u8>,
        /// Bits that do not yet make a byte, at the bottom.
        window: u64,
        count: u32,
    }

    impl Bits<'_> {
        fn put(&mut self, bits: u32, count: u32) {
            self.window = self.window << count | u64::from(bits);
            self.count += count;
            while self.count >= 8 {
                self.count -= 8;
                let byte = (self.window >> self.count) as u8;
                self.stream.push(byte);
                if byte == 0xFF {
                    self.stream.push(0); // F.1.2.3
                }
            }
        }

        /// Fills the last byte with ones (F.1.2.3).
        fn finish(&mut self) {
            let missing = (8 - self.count) % 8;
            self.put((1 << missing) - 1, missing);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Class, bytes};
    use super::decode;

    // The smallest stream: one block of 8 × 8 samples, both of its codes one bit long.
    const SOI: &str = "FF D8";
    const DQT: &str = "FF DB 00 43  00  01*64";
    const SOF: &str = "FF C0 00 0B  08  00 08 00 08  01  01 11 00";
    const DC: &str = "FF C4 00 14  00  01 00*15  00";
    const AC: &str = "FF C4 00 14  10  01 00*15  00";
    const SOS: &str = "FF DA 00 08  01  01 00  00 3F 00";
    const DATA: &str = "3F";
    const EOI: &str = "FF D9";

    /// The smallest stream, with one of its eight parts replaced.
    fn with(part: usize, other: &str) -> String {
        let mut parts = [SOI, DQT, SOF, DC, AC, SOS, DATA, EOI];
        parts[part] = other;
        parts.join(" ")
    }

    #[track_caller]
    fn reads(text: &str) -> Vec<u8> {
        decode(&bytes(text), 8, 8).unwrap_or_else(|error| panic!("{error}"))
    }

    #[track_caller]
    fn refuses(class: Class, text: &str, expected: &str) {
        let error = decode(&bytes(text), 8, 8).expect_err("an error");
        assert_eq!((error.to_string().as_str(), error.class), (expected, class));
    }

    #[track_caller]
    fn rejects(text: &str, expected: &str) {
        refuses(Class::Malformed, text, expected);
    }

    #[track_caller]
    fn lacks(text: &str, expected: &str) {
        refuses(Class::Unsupported, text, expected);
    }

    #[test]
    fn the_smallest_stream_is_gray() {
        assert_eq!(reads(&with(0, SOI)), [128; 64]);
    }

    #[test]
    fn one_picture_may_be_spelled_in_many_ways() {
        let gray = [128; 64];
        let more = |part: usize, what: &str, text: &str| with(part, &format!("{what} {text}"));
        assert_eq!(
            reads(&more(1, "FF E0 00 04 4A 46  FF FE 00 02", DQT)),
            gray,
            "APP0 and COM"
        );
        assert_eq!(reads(&more(1, "FF FF FF", DQT)), gray, "fill bytes");
        assert_eq!(
            reads(&more(7, "FF FF", EOI)),
            gray,
            "fill bytes after the scan"
        );
        assert_eq!(
            reads(&more(7, "FF FE 00 03 00", EOI)),
            gray,
            "a comment after the scan"
        );
        assert_eq!(
            reads(&more(5, "FF DD 00 04 00 07", SOS)),
            gray,
            "an interval of 7 blocks"
        );
        assert_eq!(
            reads(&more(3, DQT, DC)),
            gray,
            "tables defined twice and late"
        );
        assert_eq!(
            reads(&with(7, "FF D9 01 02 03")),
            gray,
            "bytes after the end"
        );
        assert_eq!(
            reads(&with(1, "FF DB 00 83  10  01*128")),
            gray,
            "16-bit divisors"
        );
        let sof1 = "FF C1 00 0B  08  00 08 00 08  01  01 43 00";
        assert_eq!(reads(&with(2, sof1)), gray, "SOF1, factors 4 x 3");
        let both = "FF C4 00 26  00  01 00*15  00  10  01 00*15  00";
        let text = [SOI, DQT, SOF, both, SOS, DATA, EOI].join(" ");
        assert_eq!(reads(&text), gray, "two tables in one segment");
    }

    /// Two blocks and a marker between them; the second begins its difference at zero again.
    #[test]
    fn a_restart_marker_forgets_the_block_before() {
        let sof = "FF C0 00 0B  08  00 08 00 10  01  01 11 00";
        let dc = "FF C4 00 15  00  00 02 00*14  00 04"; // 00: no difference, 01: four bits
        let interval = format!("FF DD 00 04 00 01 {SOS}");
        let read = |sos: &str, data: &str| {
            let text = [SOI, DQT, sof, dc, AC, sos, data, EOI].join(" ");
            decode(&bytes(&text), 16, 8).map(|samples| (samples[0], samples[8]))
        };
        // 01 1000 0 | 01 1000 0: eight and then sixteen, divided by eight by the transform
        assert_eq!(read(SOS, "60 C3"), Ok((129, 130)));
        assert_eq!(read(&interval, "61 FF D0 61"), Ok((129, 129)));
        let error = read(&interval, "61 FF D1 61").expect_err("the wrong marker");
        assert_eq!(
            error.to_string(),
            "byte 146: expected restart marker 0, found marker FFD1"
        );
        let error = read(&interval, "60 C3").expect_err("no marker");
        assert_eq!(
            error.to_string(),
            "byte 146: the entropy-coded data goes on after the last block"
        );
    }

    #[test]
    fn what_is_no_stream_is_rejected() {
        rejects("", "byte 0: the stream is empty");
        rejects(
            "FF D9",
            "byte 0: the stream does not start with SOI, bytes FF D8",
        );
        rejects("FF D8", "byte 2: the stream ends before a marker");
        rejects(
            "FF D8 FF",
            "byte 3: the stream ends before the code of a marker",
        );
        rejects("FF D8 00", "byte 2: expected a marker, found byte 00");
        rejects(
            "FF D8 FF D9",
            "byte 2: expected a frame header, found marker FFD9",
        );
        rejects(
            "FF D8 FF FE 00",
            "byte 5: the stream ends before the length of a segment",
        );
        rejects(
            "FF D8 FF FE 00 01",
            "byte 4: a comment or application segment has length 1, which does not cover the length itself",
        );
        rejects(
            "FF D8 FF FE 00 03",
            "byte 4: a comment or application segment of 3 bytes runs past the end of the stream",
        );
        rejects(
            "FF D8 FF F7",
            "byte 2: expected a frame header, found a JPEG-LS frame",
        );
    }

    #[test]
    fn what_is_no_plane_is_rejected() {
        rejects(
            &with(2, "FF C0 00 0B 08 00 08 00 09 01 01 11 00"),
            "byte 76: expected 8 x 8 samples, found 9 x 8",
        );
        rejects(
            &with(
                2,
                "FF C0 00 11 08 00 08 00 08 03 01 11 00 02 11 00 03 11 00",
            ),
            "byte 80: expected one component, found 3",
        );
        rejects(
            &with(2, "FF C0 00 0B 07 00 08 00 08 01 01 11 00"),
            "byte 75: samples of 7 bits do not exist here",
        );
        rejects(
            &with(2, "FF C0 00 0B 08 00 08 00 08 01 01 15 00"),
            "byte 82: sampling factors 1 x 5 are not within 1 to 4",
        );
        rejects(
            &with(2, "FF C0 00 0B 08 00 08 00 08 01 01 01 00"),
            "byte 82: sampling factors 0 x 1 are not within 1 to 4",
        );
        rejects(
            &with(2, "FF C0 00 0A 08 00 08 00 08 01 01 11"),
            "byte 83: the frame header ends before the quantisation table of the component",
        );
        rejects(
            &with(2, "FF C0 00 0C 08 00 08 00 08 01 01 11 00 00"),
            "byte 84: the frame header is 1 bytes too long",
        );
    }

    #[test]
    fn the_other_processes_are_not_implemented() {
        lacks(
            "FF D8 FF C2",
            "byte 2: progressive coding (marker FFC2) is not implemented",
        );
        lacks(
            "FF D8 FF C3",
            "byte 2: lossless coding (marker FFC3) is not implemented",
        );
        lacks(
            "FF D8 FF C9",
            "byte 2: arithmetic coding (marker FFC9) is not implemented",
        );
        lacks(
            "FF D8 FF CC",
            "byte 2: arithmetic coding (marker FFCC) is not implemented",
        );
        lacks(
            "FF D8 FF DE",
            "byte 2: hierarchical coding (marker FFDE) is not implemented",
        );
        lacks(
            &with(2, "FF C1 00 0B 0C 00 08 00 08 01 01 11 00"),
            "byte 75: samples of 12 bits are not implemented",
        );
        lacks(
            &with(2, "FF C0 00 0B 08 00 00 00 08 01 01 11 00"),
            "byte 76: a height that DNL tells later is not implemented",
        );
        lacks(
            &with(7, "FF DC 00 04 00 08 FF D9"),
            "byte 139: a height told by DNL is not implemented",
        );
    }

    #[test]
    fn tables_that_are_none_are_rejected() {
        rejects(
            &with(1, "FF DB 00 03 20"),
            "byte 6: no quantisation table has precision 2 and number 0",
        );
        rejects(
            &with(1, "FF DB 00 03 04"),
            "byte 6: no quantisation table has precision 0 and number 4",
        );
        rejects(
            &with(1, "FF DB 00 03 00"),
            "byte 7: the quantisation table segment ends before 64 divisors",
        );
        rejects(
            &with(1, "FF DB 00 43 00 01*63 00"),
            "byte 70: a quantisation table holds a zero",
        );
        rejects(
            &with(3, "FF C4 00 03 20"),
            "byte 88: no Huffman table has class 2 and number 0",
        );
        rejects(
            &with(3, "FF C4 00 03 04"),
            "byte 88: no Huffman table has class 0 and number 4",
        );
        rejects(
            &with(3, "FF C4 00 03 00"),
            "byte 89: the Huffman table segment ends before 16 numbers of codes",
        );
        rejects(
            &with(3, "FF C4 00 13 00 01 00*15"),
            "byte 105: the Huffman table segment ends before the symbols of a Huffman table",
        );
        rejects(
            &with(3, "FF C4 00 15 00 02 00*15 00 01"),
            "byte 89: a Huffman table has too many codes of 1 bits",
        );
        rejects(
            &with(3, "FF C4 00 13 00 00*14 FF FF"),
            "byte 89: a Huffman table of 510 codes has more than 256",
        );
        rejects(
            &with(5, "FF DD 00 03 00"),
            "byte 133: the restart interval segment ends before the restart interval",
        );
        rejects(
            &with(5, "FF DD 00 05 00 00 00"),
            "byte 134: the restart interval segment is 1 bytes too long",
        );
    }

    #[test]
    fn scan_headers_that_do_not_fit_are_rejected() {
        rejects(
            &with(1, ""),
            "byte 65: quantisation table 0 was not defined",
        );
        rejects(&with(3, ""), "byte 112: DC Huffman table 0 was not defined");
        rejects(&with(4, ""), "byte 112: AC Huffman table 0 was not defined");
        rejects(&with(5, ""), "byte 128: expected a marker, found byte 3F");
        rejects(
            &with(5, "FF D9"),
            "byte 128: expected the scan header, found marker FFD9",
        );
        rejects(
            &with(5, SOF),
            "byte 128: expected the scan header, found marker FFC0",
        );
        rejects(
            &with(5, "FF DA 00 0A 02 01 00 02 00 00 3F 00"),
            "byte 132: expected a scan of one component, found 2",
        );
        rejects(
            &with(5, "FF DA 00 08 01 02 00 00 3F 00"),
            "byte 133: the scan is of component 2, the frame has only 1",
        );
        rejects(
            &with(5, "FF DA 00 08 01 01 00 00 3E 00"),
            "byte 135: a sequential scan has parameters 0 63 0, found 0 62 0",
        );
        rejects(
            &with(5, "FF DA 00 08 01 01 40 00 3F 00"),
            "byte 134: DC Huffman table 4 was not defined",
        );
        rejects(
            &with(5, "FF DA 00 07 01 01 00 00 3F"),
            "byte 137: the scan header ends before its parameters",
        );
    }

    #[test]
    fn damaged_data_is_rejected() {
        rejects(
            &with(6, ""),
            "byte 138: the entropy-coded data ends too early",
        );
        rejects(
            &with(6, "BF"),
            "byte 138: the next bits are no code of the Huffman table",
        );
        rejects(
            &with(6, "3F 00"),
            "byte 139: the entropy-coded data goes on after the last block",
        );
        rejects(
            &with(6, "FF"),
            "byte 138: the entropy-coded data ends too early",
        );
        rejects(&with(7, ""), "byte 139: the stream ends before a marker");
        rejects(
            &with(7, "FF"),
            "byte 140: the stream ends before the code of a marker",
        );
        rejects(
            &with(7, "FF D0"),
            "byte 139: expected the end of the image, found marker FFD0",
        );
        let (dc, ac) = (
            |symbol| format!("FF C4 00 14 00 01 00*15 {symbol}"),
            |symbol| format!("FF C4 00 14 10 01 00*15 {symbol}"),
        );
        rejects(
            &with(3, &dc("0C")),
            "byte 138: a DC difference of 12 bits does not exist",
        );
        rejects(
            &with(4, &ac("0B")),
            "byte 138: an AC code for run 0, size 11 does not exist",
        );
        rejects(
            &with(4, &ac("10")),
            "byte 138: an AC code for run 1, size 0 does not exist",
        );
        // Four runs of sixteen are one too many; so is a run of fifteen before the last
        // coefficient.
        let runs = |symbol, data| [SOI, DQT, SOF, DC, &ac(symbol), SOS, data, EOI].join(" ");
        rejects(
            &runs("F0", "07"),
            "byte 138: a run of zeros leaves the block",
        );
        rejects(
            &runs("F1", "2A"),
            "byte 139: a run of zeros leaves the block",
        );
        // Two blocks, each a difference of eleven bits 1 and an end of block.
        let sof = "FF C0 00 0B 08 00 08 00 10 01 01 11 00";
        let text = [SOI, DQT, sof, &dc("0B"), AC, SOS, "7F F3 FF 00 BF", EOI].join(" ");
        let error = decode(&bytes(&text), 16, 8).expect_err("too large");
        assert_eq!(
            error.to_string(),
            "byte 142: a DC coefficient of 4094 does not exist"
        );
    }

    /// 65,535 × 65,535 samples would be four gigabytes.
    #[test]
    fn a_short_stream_cannot_claim_a_large_image() {
        let text = with(2, "FF C0 00 0B 08 FF FF FF FF 01 01 11 00");
        let error = decode(&bytes(&text), 65_535, 65_535).expect_err("too little data");
        assert_eq!(
            error.to_string(),
            "byte 138: 8192 x 8192 blocks cannot be held by the bytes that remain"
        );
    }

    /// A DC coefficient of 1,200 times 4 is 600 above gray, which in ten bits is 424 below it. So it
    /// is black, where clamping alone makes white. No encoder writes it.
    #[test]
    fn samples_are_cut_to_ten_bits_before_they_are_clamped() {
        let dqt = "FF DB 00 43 00 04*64";
        let dc = "FF C4 00 14 00 01 00*15 0B";
        let text = [SOI, dqt, SOF, dc, AC, SOS, "4B 07", EOI].join(" ");
        assert_eq!(reads(&text), [0; 64]);
    }

    /// An AC coefficient of 1,000 times 200, as the Group's own C code returns it.
    #[test]
    fn frequencies_of_over_fourteen_bits_lose_nothing() {
        let dqt = "FF DB 00 43 00 C8*64";
        let ac = "FF C4 00 15 10 00 02 00*14 00 0A";
        let text = [SOI, dqt, SOF, DC, ac, SOS, "3F 41", EOI].join(" ");
        assert_eq!(reads(&text), [0, 0, 255, 0, 255, 0, 255, 255].repeat(8)[..]);
    }
}
