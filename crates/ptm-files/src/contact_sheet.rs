//! Contact sheets: thumbnails of many maps in rows, with the name of each file.

use std::sync::LazyLock;

use image::{GrayImage, ImageFormat, Rgb, RgbImage, imageops};

use crate::error::{Error, Result};
use crate::render::{BACKGROUND, MAX_IMAGE_BYTES};

/// Cell of a contact sheet.
pub struct Cell {
    /// Name of the file.
    pub name: String,
    /// Thumbnail, or a notice that says why there is none.
    pub content: std::result::Result<RgbImage, Notice>,
}

/// Text in a cell without a thumbnail.
pub struct Notice {
    /// Lines of text; long ones are wrapped.
    pub lines: Vec<String>,
    /// True if something is wrong with the file. The cell is then red, and gray if not.
    pub is_alarm: bool,
}

/// Number of pixels between cells.
const GAP: u32 = 12;
/// Height of the name below a cell.
const NAME_HEIGHT: u32 = GLYPH_HEIGHT + 4;
/// Color of a cell of a damaged or unreadable file.
const ALARM: Rgb<u8> = Rgb([92, 32, 32]);
/// Color of another cell without a thumbnail.
const NEUTRAL: Rgb<u8> = Rgb([60, 60, 66]);
/// Color of text.
const TEXT: Rgb<u8> = Rgb([230; 3]);

/// Returns the size in pixels of a sheet of `count` cells in rows of at most `columns`. Thumbnails are at most `side` × `side` pixels.
///
/// # Errors
/// Returns an error if the sheet is larger than 1 GiB.
///
/// # Panics
/// Panics if `count` or `columns` is 0.
pub fn sheet_size(count: u32, columns: u32, side: u32) -> Result<(u32, u32)> {
    let columns = columns.min(count);
    let width = GAP + columns * (side + GAP);
    let height = GAP + count.div_ceil(columns) * (side + NAME_HEIGHT + GAP);
    let bytes = 3 * u64::from(width) * u64::from(height);
    match bytes > MAX_IMAGE_BYTES {
        true => Error::impossible(format!(
            "a sheet of {bytes} bytes is too large; request fewer or smaller images"
        )),
        false => Ok((width, height)),
    }
}

/// Draws cells in rows of at most `columns`. Thumbnails are at most `side` × `side` pixels.
///
/// # Errors
/// Returns an error if the sheet is larger than 1 GiB.
///
/// # Panics
/// Panics if there are no cells, or `columns` is 0.
pub fn contact_sheet(cells: &[Cell], columns: u32, side: u32) -> Result<RgbImage> {
    let (width, height) = sheet_size(cells.len() as u32, columns, side)?;
    let mut sheet = RgbImage::from_pixel(width, height, BACKGROUND);
    for (i, cell) in (0..).zip(cells) {
        let left = GAP + i % columns * (side + GAP);
        let top = GAP + i / columns * (side + NAME_HEIGHT + GAP);
        match &cell.content {
            Ok(image) => {
                let x = left + side.saturating_sub(image.width()) / 2;
                let y = top + side.saturating_sub(image.height()) / 2;
                imageops::replace(&mut sheet, image, x.into(), y.into());
            }
            Err(notice) => {
                let color = if notice.is_alarm { ALARM } else { NEUTRAL };
                let empty = RgbImage::from_pixel(side, side, color);
                imageops::replace(&mut sheet, &empty, left.into(), top.into());
                let limit = (side / GLYPH_WIDTH) as usize;
                let lines = notice.lines.iter().flat_map(|line| wrap(line, limit));
                let lines: Vec<String> = lines.take((side / GLYPH_HEIGHT) as usize).collect();
                let height = lines.len() as u32 * GLYPH_HEIGHT;
                let mut y = top + side.saturating_sub(height) / 2;
                for line in &lines {
                    draw_centered(&mut sheet, line, left, y, side);
                    y += GLYPH_HEIGHT;
                }
            }
        }
        let y = top + side + NAME_HEIGHT - GLYPH_HEIGHT;
        draw_centered(&mut sheet, &cell.name, left, y, side);
    }
    Ok(sheet)
}

/// The font Misc-Fixed 6x13 of the X Window System, which is in the public domain: the characters from U+0020 to U+04FF, 32 in a
/// row. A question mark replaces those that the font does not contain.
static FONT: LazyLock<GrayImage> = LazyLock::new(|| {
    let image = image::load_from_memory_with_format(include_bytes!("font.png"), ImageFormat::Png);
    image.expect("the font is a PNG file").into_luma8()
});
const GLYPH_WIDTH: u32 = 6;
const GLYPH_HEIGHT: u32 = 13;
const GLYPHS_PER_ROW: u32 = 32;

/// Draws a line of text in the middle of `width` pixels. A longer text is shortened in its middle.
fn draw_centered(image: &mut RgbImage, text: &str, left: u32, top: u32, width: u32) {
    let text = shorten(text, (width / GLYPH_WIDTH) as usize);
    let left = left + (width - text.len() as u32 * GLYPH_WIDTH) / 2;
    for (column, character) in (0..).zip(text) {
        let glyph = match u32::from(character) {
            code @ 0x20..=0x4ff => code - 0x20,
            _ => u32::from(b'?' - b' '),
        };
        let (glyph_x, glyph_y) = (
            glyph % GLYPHS_PER_ROW * GLYPH_WIDTH,
            glyph / GLYPHS_PER_ROW * GLYPH_HEIGHT,
        );
        for y in 0..GLYPH_HEIGHT {
            for x in 0..GLYPH_WIDTH {
                if FONT.get_pixel(glyph_x + x, glyph_y + y).0[0] > 0 {
                    image.put_pixel(left + column * GLYPH_WIDTH + x, top + y, TEXT);
                }
            }
        }
    }
}

/// Breaks a text at spaces into lines of at most `limit` characters. Longer words remain whole.
fn wrap(text: &str, limit: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= limit => {
                *line += " ";
                *line += word;
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// Returns the characters of a text. If there are more than `limit`, dots replace those in the middle, so that the beginning and
/// the number at the end remain.
fn shorten(text: &str, limit: usize) -> Vec<char> {
    const DOTS: &str = "...";
    let characters: Vec<char> = text.chars().collect();
    if characters.len() <= limit {
        return characters;
    }
    let Some(kept) = limit.checked_sub(DOTS.len()) else {
        return characters[characters.len() - limit..].to_vec();
    };
    let (start, end) = (kept / 2, characters.len() - kept.div_ceil(2));
    let mut short = characters[..start].to_vec();
    short.extend(DOTS.chars());
    short.extend(&characters[end..]);
    short
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_keep_both_ends() {
        for (limit, expected) in [
            (9, "coin1.ptm"),
            (8, "co...ptm"),
            (4, "...m"),
            (3, "..."),
            (2, "tm"),
            (0, ""),
        ] {
            assert_eq!(String::from_iter(shorten("coin1.ptm", limit)), expected);
        }
    }

    #[test]
    fn reasons_are_wrapped_between_words() {
        let lines = wrap("the file has another version", 12);
        assert_eq!(lines, ["the file has", "another", "version"]);
    }

    #[test]
    fn cells_are_in_rows_with_their_names() {
        let cell = |name: &str, content| Cell {
            name: name.to_owned(),
            content,
        };
        let notice = |line: &str, is_alarm| {
            let lines = vec![line.to_owned()];
            Err(Notice { lines, is_alarm })
        };
        let color = Rgb([1, 2, 3]);
        let cells = [
            cell("I", Ok(RgbImage::from_pixel(6, 4, color))),
            cell("\u{10ffff}", notice("I", true)),
            cell("", notice("", false)),
        ];
        let sheet = contact_sheet(&cells, 2, 20).expect("a small sheet");
        assert_eq!(sheet.dimensions(), (12 + 2 * 32, 12 + 2 * 49));
        assert_eq!(*sheet.get_pixel(12 + 7, 12 + 8), color);
        assert_eq!(*sheet.get_pixel(12 + 6, 12 + 8), BACKGROUND);
        assert_eq!(*sheet.get_pixel(32 + 12, 12), ALARM);
        assert_eq!(*sheet.get_pixel(12, 49 + 12), NEUTRAL);
        let has_text = |x: u32, y: u32| {
            let mut pixels = (x..x + 20).flat_map(|x| (y..y + 13).map(move |y| (x, y)));
            pixels.any(|(x, y)| *sheet.get_pixel(x, y) == TEXT)
        };
        assert!(has_text(12, 36) && has_text(44, 15) && has_text(44, 36));
        assert!(!has_text(12, 61) && !has_text(12, 85));
        assert!(sheet_size(3, 2, 1 << 14).is_err());
    }
}
