//! Valid and hostile answers in forms other than a PTM1 frame.

use std::io::Cursor;

use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageFormat, write_buffer_with_format};
use ptm_suite::cases::{Suite, TableSpelling};
use ptm_suite::compare::{Expected, LOSSY_TOLERANCE};
use ptm_suite::protocol::forms::read;
use ptm_suite::protocol::frame::{Frame, Samples, View, ViewKind};

use crate::table::rows;

const MAX_DECOMPRESSED_BYTES: usize = 1 << 20;

fn rgb() -> View {
    View::DEFAULT_RGB.parse().expect("a view")
}

fn frame(view: ViewKind, size: (u32, u32, u32), samples: Samples) -> Frame {
    Frame::exact(view, size.into(), samples)
}

#[track_caller]
fn assert_refused(bytes: &[u8], says: &str) {
    let error = read(bytes, &rgb(), MAX_DECOMPRESSED_BYTES).expect_err("an error");
    assert!(
        error.to_string().contains(says),
        "{error:?} should say {says:?}"
    );
}

fn png(color: png::ColorType, depth: png::BitDepth, size: (u32, u32), samples: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size.0, size.1);
    encoder.set_color(color);
    encoder.set_depth(depth);
    if color == png::ColorType::Indexed {
        encoder.set_palette(vec![1, 2, 3, 250, 251, 252]);
    }
    encoder.set_source_gamma(png::ScaledFloat::new(0.1));
    let mut writer = encoder.write_header().expect("a header");
    writer.write_image_data(samples).expect("samples");
    writer.finish().expect("an end");
    bytes
}

fn npy(version: u8, header: &str, data: &[u8]) -> Vec<u8> {
    let mut bytes = b"\x93NUMPY".to_vec();
    bytes.extend([version, 0]);
    let length = (header.len() as u32).to_le_bytes();
    bytes.extend(&length[..if version == 1 { 2 } else { 4 }]);
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

#[test]
fn netpbm_files_are_images() {
    let color = frame(ViewKind::Rgb, (2, 1, 3), Samples::U8(b"\n12 56".to_vec()));
    for header in [
        "P6\n2 1\n255\n",
        "P6 2 1 255 ",
        "P6 #by hand\n 2\t1\n# more\n255\n",
    ] {
        let bytes = [header.as_bytes(), b"\n12 56"].concat();
        assert_eq!(
            read(&bytes, &rgb(), MAX_DECOMPRESSED_BYTES),
            Ok(color.clone()),
            "{header:?}"
        );
    }
    let gray = frame(
        ViewKind::Rgb,
        (2, 1, 3),
        Samples::U8(vec![0, 0, 0, 255, 255, 255]),
    );
    for file in [
        &b"P1\n2 1\n1 0\n"[..],
        b"P2\n2 1\n255\n0 255\n",
        b"P3\n2 1\n255\n0 0 0 255 255 255\n",
        b"P4\n2 1\n\x80",
        b"P5\n2 1\n255\n\x00\xff",
    ] {
        assert_eq!(
            read(file, &rgb(), MAX_DECOMPRESSED_BYTES),
            Ok(gray.clone()),
            "{file:?}"
        );
    }
}

#[test]
fn malformed_netpbm_files_are_refused() {
    for (file, says) in [
        (&b"P6\n2 1\n255\n12345"[..], ""),
        (b"P6\n2 1\n255\n1234567", "1 bytes follow the end"),
        (b"P6\n4294967295 4294967295\n255\n1", ""),
        (b"P6\n60000 60000\n255\n1", "more than the PTM file"),
        (b"P6\n99999999999 1\n255\n1", ""),
        (b"P6\n2 1\n65535\n123456123456", "16 bits per sample"),
        (b"P6\n2 1\n15\n123456", "the maxval is 15, not 255"),
        (b"P6\n2 1 255", ""),
        (b"P6 # no end", ""),
        (b"P3\n1 1\n255\n1 2\n", ""),
        (b"P3\n1 1\n255\n1 2 3\n4\n", "follow the end"),
    ] {
        assert_refused(file, "a Netpbm file: ");
        assert_refused(file, says);
    }
}

/// Encodes an image of 2 × 2 texels, with alpha if there are four samples per texel.
fn small_image(color: ExtendedColorType, format: ImageFormat) -> Vec<u8> {
    let samples: Vec<u8> = match color {
        ExtendedColorType::L8 => vec![7, 80, 160, 250],
        ExtendedColorType::Rgb8 => (1..13).map(|i| i * 20).collect(),
        _ => (1..17)
            .map(|i| if i % 4 == 0 { 255 } else { i * 15 })
            .collect(),
    };
    let mut bytes = Cursor::new(Vec::new());
    write_buffer_with_format(&mut bytes, &samples, 2, 2, color, format).expect("a small image");
    bytes.into_inner()
}

const LOSSLESS_FORMS: [(ImageFormat, &str); 5] = [
    (ImageFormat::Png, "a PNG"),
    (ImageFormat::Pnm, "a Netpbm file"),
    (ImageFormat::Tiff, "a TIFF"),
    (ImageFormat::Bmp, "a BMP"),
    (ImageFormat::WebP, "a WebP"),
];

#[test]
fn lossless_forms_keep_all_samples() {
    let gray = [7, 80, 160, 250].iter().flat_map(|&gray| [gray; 3]);
    let gray: Vec<u8> = gray.collect();
    let color: Vec<u8> = (1..13).map(|i| i * 20).collect();
    let alpha: Vec<u8> = (1..17).filter(|i| i % 4 != 0).map(|i| i * 15).collect();
    for (format, name) in LOSSLESS_FORMS {
        for (kind, samples) in [
            (ExtendedColorType::L8, &gray),
            (ExtendedColorType::Rgb8, &color),
            (ExtendedColorType::Rgba8, &alpha),
        ] {
            let expected = frame(ViewKind::Rgb, (2, 2, 3), Samples::U8(samples.clone()));
            let found = read(&small_image(kind, format), &rgb(), MAX_DECOMPRESSED_BYTES);
            assert_eq!(found, Ok(expected), "{name}, {kind:?}");
        }
    }
}

/// Replaces bytes of a file, at an offset from the first occurrence of `before`.
fn patch(mut file: Vec<u8>, before: &[u8], offset: usize, bytes: &[u8]) -> Vec<u8> {
    let mut windows = file.windows(before.len());
    let at = windows
        .position(|window| window == before)
        .expect("an occurrence")
        + offset;
    file[at..at + bytes.len()].copy_from_slice(bytes);
    file
}

/// Returns short files whose headers announce far more texels than follow.
fn oversized_frames() -> Vec<(&'static str, Vec<u8>)> {
    let small = |format| small_image(ExtendedColorType::Rgb8, format);
    let side = 60_000_u32.to_le_bytes();
    let mut png = Vec::new();
    let writer = png::Encoder::new(&mut png, 60_000, 60_000).write_header();
    let written = writer.and_then(|mut writer| writer.write_chunk(png::chunk::IDAT, &[0x78]));
    written.expect("a start");
    let tiff = patch(
        small(ImageFormat::Tiff),
        &[0, 1, 4, 0, 1, 0, 0, 0, 2],
        8,
        &side,
    );
    let tiff = patch(tiff, &[1, 1, 4, 0, 1, 0, 0, 0, 2], 8, &side);
    let bmp = patch(small(ImageFormat::Bmp), b"BM", 18, &[side, side].concat());
    // VP8L stores each side minus one in fourteen bits.
    let webp = patch(
        small(ImageFormat::WebP),
        b"VP8L",
        9,
        &[0xfe, 0xbf, 0xff, 0x0f],
    );
    let jpeg = patch(small(ImageFormat::Jpeg), &[0xff, 0xc0], 5, &[0xff; 4]);
    vec![
        ("a PNG", png),
        ("a Netpbm file", b"P5 60000 60000 255 1".to_vec()),
        ("a TIFF", tiff),
        ("a BMP", bmp),
        ("a WebP", webp),
        ("a JPEG", jpeg),
    ]
}

#[test]
fn huge_images_are_refused_before_allocation() {
    for (name, file) in oversized_frames() {
        let error = read(&file, &rgb(), MAX_DECOMPRESSED_BYTES).expect_err("an error");
        assert!(error.to_string().starts_with(name), "{error}");
        assert!(
            error.to_string().contains("texels, more than the PTM file"),
            "{error}"
        );
    }
}

#[test]
fn truncated_or_damaged_images_cause_no_panic() {
    let mut forms = LOSSLESS_FORMS.to_vec();
    forms.push((ImageFormat::Jpeg, "a JPEG"));
    for (format, name) in forms {
        let valid = small_image(ExtendedColorType::Rgb8, format);
        let half = &valid[..valid.len() / 2];
        assert_refused(half, name);
        for at in 0..valid.len() {
            let mut damaged = valid.clone();
            damaged[at] ^= 0x55;
            let _ = read(&damaged, &rgb(), MAX_DECOMPRESSED_BYTES);
            let _ = read(&valid[..at], &rgb(), MAX_DECOMPRESSED_BYTES);
        }
    }
}

/// Encodes colors as a JPEG of the given quality.
fn jpeg(samples: &[u8], size: (u32, u32), quality: u8) -> Vec<u8> {
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, quality)
        .write_image(samples, size.0, size.1, ExtendedColorType::Rgb8)
        .expect("a small image");
    bytes
}

#[test]
fn coarse_jpegs_are_refused() {
    let samples: Vec<u8> = (0..192).collect();
    let frame =
        read(&jpeg(&samples, (8, 8), 95), &rgb(), MAX_DECOMPRESSED_BYTES).expect("an image");
    assert!(frame.lossy && (frame.width, frame.height, frame.channels) == (8, 8, 3));
    // A frame round-trips through text.
    let text = serde_json::to_string(&frame).expect("UTF-8");
    let read_back: Frame = serde_json::from_str(&text).expect("a frame");
    assert_eq!(read_back, frame);
    assert_refused(&jpeg(&samples, (8, 8), 90), "too coarse");
    let fine = jpeg(&samples, (8, 8), 95);
    let subsampled = patch(fine.clone(), &[0xff, 0xc0], 11, &[0x22]);
    assert_refused(&subsampled, "several texels share one color");
    assert_refused(&fine[..fine.len() - 2], "does not end");
}

#[test]
fn every_correct_image_of_the_suite_passes_as_a_high_quality_jpeg() {
    let suite = Suite::load().expect("the suite loads");
    let (mut images, mut largest) = (0, 0.0_f64);
    for case in &suite.cases {
        let Some(view) = case.views.iter().find(|view| view.name() == "rgb") else {
            continue;
        };
        let built = case.build(TableSpelling::default());
        let Some(expected) = Expected::new(&built.values, view) else {
            continue;
        };
        let values = &expected.values;
        let samples: Vec<u8> = values.iter().map(|value| value.round() as u8).collect();
        let size = (expected.size.width, expected.size.height);
        if size.0.max(size.1) > 65_535 {
            continue;
        }
        let file = jpeg(&samples, size, 95);
        let frame = read(&file, view, samples.len().max(MAX_DECOMPRESSED_BYTES)).expect("an image");
        assert_eq!(expected.compare(&frame), None, "{}", case.id);
        let Samples::U8(found) = &frame.samples else {
            unreachable!("an image has bytes")
        };
        let losses = values.iter().zip(found);
        largest = losses.fold(largest, |largest, (value, &found)| {
            largest.max((value - f64::from(found)).abs())
        });
        images += 1;
    }
    println!(
        "{images} images; the largest error is {largest:.1}, the tolerance is {LOSSY_TOLERANCE}"
    );
    assert!(images > 1000);
    let page = include_str!("../../../docs/check.md");
    assert!(page.contains(&format!("is {LOSSY_TOLERANCE} larger than in other")));
}

#[test]
fn pngs_of_every_color_type_are_images() {
    use png::{BitDepth::Eight, BitDepth::One, ColorType};
    let color = [10, 20, 30, 40, 50, 60];
    let gray = [7, 7, 7, 200, 200, 200];
    for (color_type, depth, samples, expected) in [
        (ColorType::Rgb, Eight, &color[..], color),
        (
            ColorType::Rgba,
            Eight,
            &[10, 20, 30, 255, 40, 50, 60, 255],
            color,
        ),
        (ColorType::Grayscale, Eight, &[7, 200], gray),
        (ColorType::GrayscaleAlpha, Eight, &[7, 255, 200, 255], gray),
        (ColorType::Indexed, Eight, &[0, 1], [1, 2, 3, 250, 251, 252]),
        (ColorType::Grayscale, One, &[0x40], [0, 0, 0, 255, 255, 255]),
    ] {
        let bytes = png(color_type, depth, (2, 1), samples);
        let expected = frame(ViewKind::Rgb, (2, 1, 3), Samples::U8(expected.to_vec()));
        assert_eq!(
            read(&bytes, &rgb(), MAX_DECOMPRESSED_BYTES),
            Ok(expected),
            "{color_type:?}"
        );
    }
}

#[test]
fn malformed_pngs_are_refused() {
    use png::{BitDepth, ColorType};
    let valid = png(ColorType::Rgb, BitDepth::Eight, (2, 1), b"123456");
    assert_refused(&[&valid[..], b"x"].concat(), "1 bytes follow the end");
    assert_refused(&[&valid[..], &valid[..]].concat(), "bytes follow the end");
    for length in 0..valid.len() {
        let found = read(&valid[..length], &rgb(), MAX_DECOMPRESSED_BYTES);
        assert!(found.is_err(), "{length} bytes");
    }
    let deep = png(ColorType::Rgb, BitDepth::Sixteen, (1, 1), b"123456");
    assert_refused(&deep, "16 bits");
    let clear = png(ColorType::Rgba, BitDepth::Eight, (1, 2), b"123\xff456\x80");
    assert_refused(&clear, "texel (0, 1) is not opaque");
    // Two thousand black rows compress well.
    let (gray, black) = (ColorType::Grayscale, vec![0; 4_000_000]);
    let large = png(gray, BitDepth::Eight, (2000, 2000), &black);
    assert!(large.len() < 50_000);
    assert_refused(&large, "more than the PTM file");
    let mut damaged = valid;
    let stream = damaged.windows(4).position(|name| name == b"IDAT");
    damaged[stream.expect("a stream") + 8] ^= 1;
    assert!(read(&damaged, &rgb(), MAX_DECOMPRESSED_BYTES).is_err());
}

#[test]
fn arrays_are_frames_of_the_requested_view() {
    let values = [1.5f32, -2.0, 3.0, 4.0, 5.0, 6.0];
    let data: Vec<u8> = values
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .collect();
    let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 2, 3), }          \n";
    for version in 1..=3 {
        let expected = frame(ViewKind::Coef, (2, 1, 3), Samples::F32(values.to_vec()));
        let bytes = npy(version, header, &data);
        assert_eq!(
            read(&bytes, &View::Coef, MAX_DECOMPRESSED_BYTES),
            Ok(expected)
        );
    }
    let header = "{\"shape\":(2,1,3),\"fortran_order\":False,\"descr\":\"|u1\"}\n";
    for view in [View::Raw, rgb()] {
        let expected = frame(view.kind(), (1, 2, 3), Samples::U8(b"123456".to_vec()));
        assert_eq!(
            read(&npy(1, header, b"123456"), &view, MAX_DECOMPRESSED_BYTES),
            Ok(expected)
        );
    }
}

#[test]
fn malformed_arrays_are_refused() {
    for [descr, order, shape, data, says] in rows(
        "
'|u1' | True | (1, 1, 3) | 123 | Fortran order
'>f4' | False | (1, 1, 1) | 1234 | high byte first
'<f8' | False | (1, 1, 1) | 12345678 | f64
'<i8' | False | (1, 1, 1) | 12345678 | \"<i8\"
[('r', '|u1')] | False | (1, 1, 1) | 1 | expected a string
'|u1' | False | (1, 3) | 123 | 2 numbers
'|u1' | False | (1, 1, 4) | 123 | needs 4 bytes, 3 follow
'|u1' | False | (1, 1, 2) | 123 | needs 2 bytes, 3 follow
'<f4' | False | (4294967295, 4294967295, 4294967295) | | more bytes than 64 bits can count
'|u1' | False | (-1, 1, 1) | 1 | a number before
'|u1' | 0 | (1, 1, 1) | 1 | neither True nor False",
    ) {
        let header =
            format!("{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}\n");
        assert_refused(&npy(1, &header, data.as_bytes()), &says);
    }
    let deep = format!("{{'shape': {}\n", "(".repeat(60_000));
    for (version, header, says) in [
        (
            1,
            "{'descr': '|u1', 'descr': '|u1', 'fortran_order': False, 'shape': (1, 1, 1)}\n",
            "twice",
        ),
        (1, "{'descr': '|u1'}\n", "lacks"),
        (1, "{'x': 1}\n", "unknown key"),
        (1, "{} []\n", "continues after"),
        (1, "{", "line feed"),
        (4, "{}\n", "version"),
        (1, &deep, "a number before"),
    ] {
        assert_refused(&npy(version, header, b"1"), says);
    }
    assert_refused(&npy(2, "", b"")[..10], "within its header");
    let mut cut = npy(2, "{}\n", b"");
    cut[8..12].copy_from_slice(&u32::MAX.to_le_bytes());
    assert_refused(&cut, "within its header");
}

#[test]
fn unsupported_forms_are_named() {
    let gif = "a GIF image; an image is a PNG, PNM, TIFF, BMP, WebP or JPEG";
    assert_refused(b"GIF89a", gif);
    assert_refused(b"\xff\xd8\xff\xe0JFIF", "a JPEG: ");
    assert_refused(b"BM1234", "a BMP: ");
    assert_refused(b"PTM_1.2\n", "the PTM file itself");
    assert_refused(b"", "standard output is empty");
    assert_refused(b"hello", "begins with \"hello\"");
}
