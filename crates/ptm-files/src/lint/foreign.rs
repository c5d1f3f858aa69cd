//! Kinds of files that are found under the names of PTMs, by their first bytes.

use super::status::MAGIC;

/// First bytes of common kinds of files, and their names.
const KINDS: [(&[u8], &str); 17] = [
    (b"\x1f\x8b", "a gzip archive"),
    (b"PK\x03\x04", "a ZIP archive"),
    (b"BZh", "a bzip2 archive"),
    (b"\xfd7zXZ\0", "an xz archive"),
    (b"7z\xbc\xaf\x27\x1c", "a 7z archive"),
    (b"\xff\xd8\xff", "a JPEG image"),
    (b"\x89PNG\r\n", "a PNG image"),
    (b"II*\0", "a TIFF image"),
    (b"MM\0*", "a TIFF image"),
    (b"GIF8", "a GIF image"),
    (b"BM", "a BMP image"),
    (b"%PDF", "a PDF document"),
    (
        b"\0\x05\x16\x07",
        "an AppleDouble file, which belongs to another file",
    ),
    (
        b"\xff\xfeP\0T\0M\0_\0",
        "a PTM that was converted to UTF-16",
    ),
    (
        b"\xfe\xff\0P\0T\0M\0_",
        "a PTM that was converted to UTF-16",
    ),
    (b"P\0T\0M\0_\0", "a PTM that was converted to UTF-16"),
    (b"UFRNXz", "a PTM that was converted to base64"),
];

/// Size of the header that `MacBinary` puts before a file.
const MAC_BINARY_BYTES: usize = 128;

/// Returns the kind of a file that is not a PTM, or `None` if its first bytes do not show it.
pub(super) fn kind(file: &[u8]) -> Option<String> {
    if let Some((_, kind)) = KINDS.iter().find(|(start, _)| file.starts_with(start)) {
        return Some((*kind).to_owned());
    }
    let text = file[..file.len().min(1024)]
        .trim_ascii_start()
        .to_ascii_lowercase();
    if text.starts_with(b"<!doctype html") || text.starts_with(b"<html") {
        return Some("an HTML page".to_owned());
    }
    let rest = file.get(MAC_BINARY_BYTES..).unwrap_or_default();
    if file.first() == Some(&0) && rest.starts_with(MAGIC) {
        return Some("a PTM in MacBinary, which begins at byte 128".to_owned());
    }
    let mut places = file.windows(MAGIC.len() + 4).take(4096);
    let place = places.position(|window| window == b"PTM_1.2\n")?;
    Some(format!("a PTM after {place} other bytes"))
}
