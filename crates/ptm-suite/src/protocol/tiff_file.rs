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

/// Maximum number of further directories that are read, so that a file with many of them takes no time.
const MAX_DIRECTORIES: usize = 16;

/// The first directory of a TIFF. Values are read when they are needed, so that a file whose entries overlap takes no memory.
pub(super) struct Directory<'a> {
    numbers: Numbers<'a>,
    entries: Vec<Entry>,
    /// The offset of the next page, or 0.
    next: usize,
    /// The end of the last part of the file that the directory refers to.
    end: usize,
}

/// An entry of a directory.
struct Entry {
    tag: u16,
    /// Size of each value in bytes.
    length: usize,
    count: usize,
    /// Offset of the first value.
    place: usize,
}

impl<'a> Directory<'a> {
    /// Reads the first directory. Returns `None` if the file is damaged, which the decoder describes.
    pub fn read(bytes: &'a [u8]) -> Option<Directory<'a>> {
        let numbers = Numbers::new(bytes)?;
        let mut directory = numbers.directory(numbers.at(4, 4)?)?;
        let further = DIRECTORIES.iter().flat_map(|&tag| directory.values(tag));
        let further = further
            .take(MAX_DIRECTORIES)
            .map(|offset| Some(numbers.directory(offset)?.end));
        let ends = further.collect::<Option<Vec<usize>>>()?;
        directory.end = ends.into_iter().fold(directory.end, usize::max);
        Some(directory)
    }

    fn entry(&self, tag: u16) -> Option<&Entry> {
        // Fractions and 64-bit numbers are not needed.
        let mut entries = self.entries.iter();
        entries.find(|entry| entry.tag == tag && entry.length <= 4)
    }

    /// Returns the values of a tag, as far as the file contains them.
    fn values(&self, tag: u16) -> impl Iterator<Item = usize> {
        let entry = self.entry(tag).into_iter();
        entry.flat_map(|entry| {
            let value = |i| {
                self.numbers
                    .at(entry.place + i * entry.length, entry.length)
            };
            (0..entry.count).map_while(value)
        })
    }

    fn value(&self, tag: u16, default: usize) -> usize {
        self.values(tag).next().unwrap_or(default)
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
        // The `tiff` crate decodes the indices only as levels of gray.
        let mut gray = bytes.to_vec();
        let level = if bytes[0] == b'M' { [0, 1] } else { [1, 0] };
        let place = self.entry(PHOTOMETRIC).map_or(0, |entry| entry.place);
        if let Some(color_space) = gray.get_mut(place..place + 2) {
            color_space.copy_from_slice(&level);
        }
        let to_text = |error: tiff::TiffError| error.to_string();
        let mut decoder = Decoder::new(Cursor::new(gray)).map_err(to_text)?;
        let DecodingResult::U8(indices) = decoder.read_image().map_err(to_text)? else {
            return Error::invalid("the indices of the palette are not bytes");
        };
        let palette: Vec<usize> = self
            .values(COLOR_MAP)
            .take(3 * PALETTE_COLORS + 1)
            .collect();
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
#[derive(Clone, Copy)]
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

    fn directory(self, start: usize) -> Option<Directory<'a>> {
        let count = self.at(start, 2)?;
        let mut directory = Directory {
            numbers: self,
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
            directory.entries.push(Entry {
                tag,
                length,
                count,
                place,
            });
        }
        for (offsets, counts) in [
            (STRIP_OFFSETS, STRIP_BYTE_COUNTS),
            (TILE_OFFSETS, TILE_BYTE_COUNTS),
        ] {
            let parts = directory.values(offsets).zip(directory.values(counts));
            let end = parts.map(|(offset, count)| offset + count).max();
            directory.end = directory.end.max(end.unwrap_or_default());
        }
        Some(directory)
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use tiff::encoder::TiffEncoder;
    use tiff::tags::Tag;

    use crate::protocol::frame::Samples;
    use crate::protocol::image_file::read;

    /// Writes a TIFF of 2 × 1 texels with one byte per texel, and additional tags.
    fn gray_tiff(photometric: u16, tags: &[(Tag, u16)], palette: &[u16], pages: usize) -> Vec<u8> {
        let mut out = Cursor::new(Vec::new());
        let mut encoder = TiffEncoder::new(&mut out).expect("a file in memory");
        for _ in 0..pages {
            let mut directory = encoder.image_directory().expect("a directory");
            let offset = directory.write_data(&[7_u8, 200][..]).expect("samples") as u32;
            let usual = [
                (Tag::ImageWidth, 2),
                (Tag::ImageLength, 1),
                (Tag::BitsPerSample, 8),
                (Tag::Compression, 1),
                (Tag::PhotometricInterpretation, photometric),
                (Tag::SamplesPerPixel, 1),
                (Tag::RowsPerStrip, 1),
            ];
            for (tag, value) in usual.iter().chain(tags) {
                directory.write_tag(*tag, *value).expect("a tag");
            }
            directory
                .write_tag(Tag::StripOffsets, offset)
                .expect("a tag");
            directory
                .write_tag(Tag::StripByteCounts, 2_u32)
                .expect("a tag");
            if !palette.is_empty() {
                directory.write_tag(Tag::ColorMap, palette).expect("a tag");
            }
            directory.finish().expect("a directory");
        }
        out.into_inner()
    }

    fn result(file: &[u8]) -> Result<Vec<u8>, String> {
        match read(file, 1 << 10).expect("a TIFF") {
            Ok(frame) => match frame.samples {
                Samples::U8(samples) => Ok(samples),
                Samples::F32(_) => Err("floats".to_owned()),
            },
            Err(error) => Err(error.to_string()),
        }
    }

    #[test]
    fn palettes_are_read() {
        let palette: Vec<u16> = (0..768).map(|i| (i % 256 * 256 + i / 256) as u16).collect();
        assert_eq!(
            result(&gray_tiff(3, &[], &palette, 1)),
            Ok(vec![7, 7, 7, 200, 200, 200])
        );
        let error = result(&gray_tiff(3, &[], &palette[..6], 1)).expect_err("a short palette");
        assert!(error.contains("6 numbers instead of 768"), "{error}");
    }

    #[test]
    fn files_that_other_programs_show_differently_are_refused() {
        let gray = || Ok(vec![7, 7, 7, 200, 200, 200]);
        assert_eq!(result(&gray_tiff(1, &[], &[], 1)), gray());
        assert_eq!(
            result(&gray_tiff(1, &[(Tag::Orientation, 1)], &[], 1)),
            gray()
        );
        let trailing = [gray_tiff(1, &[], &[], 1), b"more".to_vec()].concat();
        for (file, says) in [
            (
                gray_tiff(1, &[(Tag::Orientation, 4)], &[], 1),
                "orientation 4",
            ),
            (gray_tiff(1, &[(Tag::Compression, 7)], &[], 1), "lossy"),
            (
                gray_tiff(1, &[(Tag::SamplesPerPixel, 3)], &[], 1),
                "3 samples per texel in grayscale",
            ),
            (gray_tiff(6, &[], &[], 1), "photometric interpretation 6"),
            (
                gray_tiff(1, &[(Tag::BitsPerSample, 4)], &[], 1),
                "4 bits per sample",
            ),
            (
                gray_tiff(1, &[(Tag::SampleFormat, 3)], &[], 1),
                "floating-point",
            ),
            (gray_tiff(1, &[], &[], 2), "several pages"),
            (trailing, "4 bytes follow"),
        ] {
            let error = result(&file).expect_err(says);
            assert!(error.contains(says), "{error}, expected {says}");
        }
    }

    /// The values of all entries together are two hundred times as large as the file.
    #[test]
    fn overlapping_entries_are_not_copied() {
        let (count, values) = (1000_u16, 500_u32);
        let mut file = b"II*\0\x08\0\0\0".to_vec();
        file.extend(count.to_le_bytes());
        for tag in 1000..1000 + count {
            file.extend([tag.to_le_bytes(), 4_u16.to_le_bytes()].concat());
            file.extend([values, 8].map(u32::to_le_bytes).concat());
        }
        file.extend([0; 4]);
        let directory = super::Directory::read(&file).expect("a directory");
        assert_eq!(directory.entries.len(), usize::from(count));
        assert_eq!(directory.values(1000).count(), values as usize);
    }
}
