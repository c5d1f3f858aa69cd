//! What the `image` crate does not say about a TIFF: its color space, its compression, its palette, further pages, and whether bytes
//! follow the image.

use std::io::Cursor;

use tiff::decoder::{Decoder, DecodingResult};

use crate::error::{Error, Result};

// Tags of a directory (TIFF 6.0, sections 4 and following).
const WIDTH: u16 = 256;
const HEIGHT: u16 = 257;
const BITS_PER_SAMPLE: u16 = 258;
const COMPRESSION: u16 = 259;
const PHOTOMETRIC: u16 = 262;
const STRIP_OFFSETS: u16 = 273;
const ORIENTATION: u16 = 274;
const SAMPLES_PER_PIXEL: u16 = 277;
const STRIP_BYTE_COUNTS: u16 = 279;
const COLOR_MAP: u16 = 320;
const TILE_OFFSETS: u16 = 324;
const TILE_BYTE_COUNTS: u16 = 325;
const SAMPLE_FORMAT: u16 = 339;

/// Tags that point to further directories: pages of smaller size, EXIF and GPS.
const DIRECTORIES: [u16; 3] = [330, 34665, 34853];

/// Number of colors in the palette of an image with 8 bits per texel.
const PALETTE_COLORS: usize = 256;

/// The first directory of a TIFF.
pub(super) struct Directory {
    entries: Vec<(u16, Vec<usize>)>,
    /// The offset of the next page, or 0.
    next: usize,
    /// The end of the last part of the file that the directory refers to.
    end: usize,
}

impl Directory {
    /// Reads the first directory. Returns `None` if the file is damaged, which the decoder describes.
    pub fn read(bytes: &[u8]) -> Option<Directory> {
        let numbers = Numbers::new(bytes)?;
        let mut directory = numbers.directory(numbers.at(4, 4)?)?;
        for tag in DIRECTORIES {
            for offset in directory.values(tag).to_vec() {
                directory.end = directory.end.max(numbers.directory(offset)?.end);
            }
        }
        Some(directory)
    }

    fn values(&self, tag: u16) -> &[usize] {
        let mut entries = self.entries.iter();
        entries
            .find(|entry| entry.0 == tag)
            .map_or(&[], |entry| &entry.1)
    }

    fn value(&self, tag: u16, default: usize) -> usize {
        self.values(tag).first().copied().unwrap_or(default)
    }

    /// Returns true if the texels are indices of a palette.
    pub fn has_palette(&self) -> bool {
        self.value(PHOTOMETRIC, 0) == 3
    }

    /// Returns the width and height in texels.
    pub fn size(&self) -> (u32, u32) {
        (self.value(WIDTH, 0) as u32, self.value(HEIGHT, 0) as u32)
    }

    /// Returns the orientation, 1 for the top row first.
    pub fn orientation(&self) -> u8 {
        self.value(ORIENTATION, 1) as u8
    }

    /// Rejects an image that is not 8-bit gray, palette, RGB or CMYK, or whose compression is lossy.
    pub fn check(&self) -> Result<()> {
        if matches!(self.value(COMPRESSION, 1), 6 | 7) {
            return Error::invalid(
                "the image is compressed as JPEG, which is lossy; use no compression, LZW or deflate",
            );
        }
        if self.value(SAMPLE_FORMAT, 1) == 3 {
            return Error::invalid("the samples are floating-point numbers, not bytes");
        }
        let (bits, samples) = (
            self.value(BITS_PER_SAMPLE, 1),
            self.value(SAMPLES_PER_PIXEL, 1),
        );
        let (colors, allowed) = match self.value(PHOTOMETRIC, 0) {
            0 | 1 => ("grayscale", 1..=2),
            2 => ("RGB", 3..=4),
            3 => ("a palette", 1..=1),
            5 => ("CMYK", 4..=4),
            other => {
                return Error::invalid(format!(
                    "the color space (photometric interpretation {other}) is not supported; write RGB"
                ));
            }
        };
        if !allowed.contains(&samples) {
            return Error::invalid(format!(
                "the image has {samples} samples per texel in {colors}; write RGB with 3 samples of 8 bits"
            ));
        }
        if bits == 8 || bits == 1 && samples == 1 && !self.has_palette() {
            Ok(())
        } else {
            Error::invalid(format!("the image has {bits} bits per sample, not 8"))
        }
    }

    /// Rejects further pages, and bytes after the image.
    pub fn check_end(&self, bytes: &[u8]) -> Result<()> {
        if self.next != 0 {
            return Error::invalid("the file has several pages");
        }
        // A writer may align the end of the file.
        let more = bytes.len().saturating_sub(self.end);
        match more {
            0 => Ok(()),
            1 if bytes.ends_with(&[0]) => Ok(()),
            _ => Error::invalid(format!("{more} bytes follow the image")),
        }
    }

    /// Decodes an image with a palette to red, green and blue of every texel. The palette has 16 bits per color, of which the high
    /// byte is used.
    pub fn read_palette(&self, bytes: &[u8]) -> Result<Vec<u8>> {
        let to_text = |error: tiff::TiffError| error.to_string();
        let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(to_text)?;
        let DecodingResult::U8(indices) = decoder.read_image().map_err(to_text)? else {
            return Error::invalid("the indices of the palette are not bytes");
        };
        let palette = self.values(COLOR_MAP);
        if palette.len() != 3 * PALETTE_COLORS {
            return Error::invalid(format!(
                "the palette has {} numbers instead of 768",
                palette.len()
            ));
        }
        let color = |&index: &u8| {
            [0, 1, 2].map(|color| (palette[color * PALETTE_COLORS + usize::from(index)] >> 8) as u8)
        };
        Ok(indices.iter().flat_map(color).collect())
    }
}

/// The numbers of a TIFF, in its byte order.
struct Numbers<'a> {
    bytes: &'a [u8],
    is_big_endian: bool,
}

impl<'a> Numbers<'a> {
    fn new(bytes: &'a [u8]) -> Option<Numbers<'a>> {
        let is_big_endian = match bytes.get(..4)? {
            b"II*\0" => false,
            b"MM\0*" => true,
            _ => return None,
        };
        Some(Numbers {
            bytes,
            is_big_endian,
        })
    }

    /// Returns the number of `length` bytes, 1, 2 or 4, at an offset.
    fn at(&self, offset: usize, length: usize) -> Option<usize> {
        let bytes = self.bytes.get(offset..offset.checked_add(length)?)?.iter();
        let join = |number: usize, byte: &u8| number << 8 | usize::from(*byte);
        Some(match self.is_big_endian {
            true => bytes.fold(0, join),
            false => bytes.rev().fold(0, join),
        })
    }

    fn directory(&self, start: usize) -> Option<Directory> {
        let count = self.at(start, 2)?;
        let mut directory = Directory {
            entries: Vec::new(),
            next: self.at(start + 2 + 12 * count, 4)?,
            end: start + 2 + 12 * count + 4,
        };
        for i in 0..count {
            let at = start + 2 + 12 * i;
            let (tag, kind, count) = (
                self.at(at, 2)? as u16,
                self.at(at + 2, 2)?,
                self.at(at + 4, 4)?,
            );
            let length = match kind {
                1 | 2 | 6 | 7 => 1,
                3 | 8 => 2,
                4 | 9 | 11 | 13 => 4,
                5 | 10 | 12 => 8,
                _ => continue,
            };
            let size = length * count;
            let place = if size <= 4 {
                at + 8
            } else {
                self.at(at + 8, 4)?
            };
            if size > 4 {
                directory.end = directory.end.max(place + size);
            }
            // Fractions and floating-point numbers are not needed.
            if length <= 4 && place + size <= self.bytes.len() {
                let values = (0..count).map(|i| self.at(place + i * length, length));
                directory
                    .entries
                    .push((tag, values.collect::<Option<_>>()?));
            }
        }
        for (offsets, counts) in [
            (STRIP_OFFSETS, STRIP_BYTE_COUNTS),
            (TILE_OFFSETS, TILE_BYTE_COUNTS),
        ] {
            let parts = directory
                .values(offsets)
                .iter()
                .zip(directory.values(counts));
            let end = parts.map(|(offset, count)| offset + count).max();
            directory.end = directory.end.max(end.unwrap_or_default());
        }
        Some(directory)
    }
}
