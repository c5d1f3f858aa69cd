//! Answers in other forms than a PTM1 frame, sound and hostile.

use ptm_conform::protocol::forms::read;
use ptm_conform::protocol::frame::{Frame, Samples, View};

const MOST: usize = 1 << 20;

fn rgb() -> View {
    View::ORDINARY_LIGHT.parse().expect("a view")
}

fn frame(view: &'static str, size: (u32, u32, u32), samples: Samples) -> Frame {
    let (width, height, channels) = size;
    Frame {
        view,
        width,
        height,
        channels,
        samples,
    }
}

#[track_caller]
fn refuses(bytes: &[u8], says: &str) {
    let error = read(bytes, &rgb(), MOST).expect_err("no answer");
    assert!(error.contains(says), "{error:?} should say {says:?}");
}

/// A PNG of those samples.
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

/// An array with that header.
fn npy(version: u8, header: &str, data: &[u8]) -> Vec<u8> {
    let mut bytes = b"\x93NUMPY".to_vec();
    bytes.extend([version, 0]);
    let length = header.len() as u32;
    let length = length.to_le_bytes();
    bytes.extend(if version == 1 {
        &length[..2]
    } else {
        &length[..]
    });
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

#[test]
fn a_pixmap_is_a_picture() {
    let expected = frame("rgb", (2, 1, 3), Samples::U8(b"\n12 56".to_vec()));
    for header in [
        "P6\n2 1\n255\n",
        "P6 2 1 255 ",
        "P6#by hand\n 2\t1\r\n# more\n255\n",
    ] {
        let bytes = [header.as_bytes(), b"\n12 56"].concat();
        assert_eq!(
            read(&bytes, &rgb(), MOST),
            Ok(expected.clone()),
            "{header:?}"
        );
    }
}

#[test]
fn pixmaps_that_are_none() {
    refuses(b"P6\n2 1\n255\n12345", "need 6 bytes, 5 follow");
    refuses(b"P6\n2 1\n255\n1234567", "need 6 bytes, 7 follow");
    refuses(b"P6\n4294967295 4294967295\n255\n1", "bytes, 1 follow");
    refuses(b"P6\n99999999999 1\n255\n1", "width is no number");
    refuses(b"P6\n-1 1\n255\n1", "width is no number");
    refuses(b"P6\n2 1\n65535\n123456", "65535, not 255");
    refuses(b"P6\n2 1 255", "ends with its header");
    refuses(b"P6\n2 1 255x123456", "no white space");
    refuses(b"P6 # no end", "width is no number");
    refuses(b"P3\n1 1\n255\n1 2 3\n", "P6");
    refuses(b"P5\n1 1\n255\n1", "P6");
}

#[test]
fn a_png_is_a_picture_whatever_its_color_type() {
    use png::{BitDepth::Eight, BitDepth::One, ColorType};
    let color = [10, 20, 30, 40, 50, 60];
    let grey = [7, 7, 7, 200, 200, 200];
    for (color_type, depth, samples, expected) in [
        (ColorType::Rgb, Eight, &color[..], color),
        (
            ColorType::Rgba,
            Eight,
            &[10, 20, 30, 255, 40, 50, 60, 255],
            color,
        ),
        (ColorType::Grayscale, Eight, &[7, 200], grey),
        (ColorType::GrayscaleAlpha, Eight, &[7, 255, 200, 255], grey),
        (ColorType::Indexed, Eight, &[0, 1], [1, 2, 3, 250, 251, 252]),
        (ColorType::Grayscale, One, &[0x40], [0, 0, 0, 255, 255, 255]),
    ] {
        let bytes = png(color_type, depth, (2, 1), samples);
        let expected = frame("rgb", (2, 1, 3), Samples::U8(expected.to_vec()));
        assert_eq!(read(&bytes, &rgb(), MOST), Ok(expected), "{color_type:?}");
    }
}

#[test]
fn pngs_that_are_none() {
    use png::{BitDepth, ColorType};
    let sound = png(ColorType::Rgb, BitDepth::Eight, (2, 1), b"123456");
    refuses(&[&sound[..], b"x"].concat(), "1 bytes follow its end");
    refuses(&[&sound[..], &sound[..]].concat(), "bytes follow its end");
    for length in 0..sound.len() {
        assert!(
            read(&sound[..length], &rgb(), MOST).is_err(),
            "{length} bytes"
        );
    }
    let deep = png(ColorType::Rgb, BitDepth::Sixteen, (1, 1), b"123456");
    refuses(&deep, "16 bits");
    let clear = png(ColorType::Rgba, BitDepth::Eight, (1, 2), b"123\xff456\x80");
    refuses(&clear, "texel (0, 1) is not opaque");
    // Two thousand rows of nothing are a few bytes of file.
    let large = png(
        ColorType::Grayscale,
        BitDepth::Eight,
        (2000, 2000),
        &vec![0; 4_000_000],
    );
    assert!(large.len() < 50_000);
    refuses(&large, "than the file can");
    let mut torn = sound;
    let stream = torn.windows(4).position(|name| name == b"IDAT");
    torn[stream.expect("a stream") + 8] ^= 1;
    assert!(read(&torn, &rgb(), MOST).is_err());
}

#[test]
fn an_array_is_a_frame_of_the_view_asked_for() {
    let values = [1.5f32, -2.0, 3.0, 4.0, 5.0, 6.0];
    let data: Vec<u8> = values
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .collect();
    let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 2, 3), }          \n";
    for version in 1..=3 {
        let expected = frame("coef", (2, 1, 3), Samples::F32(values.to_vec()));
        let bytes = npy(version, header, &data);
        assert_eq!(read(&bytes, &View::Coef, MOST), Ok(expected));
    }
    let header = "{\"shape\":(2,1,3),\"fortran_order\":False,\"descr\":\"|u1\"}\n";
    for view in [View::Raw, rgb()] {
        let expected = frame(view.name(), (1, 2, 3), Samples::U8(b"123456".to_vec()));
        assert_eq!(read(&npy(1, header, b"123456"), &view, MOST), Ok(expected));
    }
}

#[test]
fn arrays_that_are_none() {
    let with = |descr: &str, order: &str, shape: &str, data: &[u8]| {
        let header =
            format!("{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}\n");
        npy(1, &header, data)
    };
    refuses(&with("'|u1'", "True", "(1, 1, 3)", b"123"), "Fortran order");
    refuses(
        &with("'>f4'", "False", "(1, 1, 1)", b"1234"),
        "high byte first",
    );
    refuses(&with("'<f8'", "False", "(1, 1, 1)", b"12345678"), "f64");
    refuses(&with("'<i8'", "False", "(1, 1, 1)", b"12345678"), "\"<i8\"");
    refuses(
        &with("[('r', '|u1')]", "False", "(1, 1, 1)", b"1"),
        "a string before",
    );
    refuses(&with("'|u1'", "False", "(1, 3)", b"123"), "2 numbers");
    refuses(
        &with("'|u1'", "False", "(1, 1, 4)", b"123"),
        "needs 4 bytes, 3 follow",
    );
    refuses(
        &with("'|u1'", "False", "(1, 1, 2)", b"123"),
        "needs 2 bytes, 3 follow",
    );
    refuses(
        &with(
            "'<f4'",
            "False",
            "(4294967295, 4294967295, 4294967295)",
            b"",
        ),
        "more bytes than can be counted",
    );
    refuses(
        &with("'|u1'", "False", "(-1, 1, 1)", b"1"),
        "a number before",
    );
    refuses(
        &with("'|u1'", "0", "(1, 1, 1)", b"1"),
        "neither True nor False",
    );
    let header = "{'descr': '|u1', 'descr': '|u1', 'fortran_order': False, 'shape': (1, 1, 1)}\n";
    refuses(&npy(1, header, b"1"), "twice");
    refuses(&npy(1, "{'descr': '|u1'}\n", b"1"), "lacks");
    refuses(&npy(1, "{'x': 1}\n", b"1"), "unknown key");
    refuses(&npy(1, "{} []\n", b"1"), "goes on");
    refuses(&npy(1, "{", b""), "line feed");
    refuses(&npy(4, "{}\n", b""), "version");
    refuses(&npy(2, "", b"")[..10], "within its header");
    let mut cut = npy(2, "{}\n", b"");
    cut[8..12].copy_from_slice(&u32::MAX.to_le_bytes());
    refuses(&cut, "within its header");
    let deep = "(".repeat(60_000);
    refuses(
        &npy(1, &format!("{{'shape': {deep}\n"), b""),
        "a number before",
    );
}

#[test]
fn other_files_are_named() {
    refuses(b"\xff\xd8\xff\xe0JFIF", "a JPEG picture");
    refuses(b"BM1234", "a BMP picture");
    refuses(b"PTM_1.2\n", "the PTM file itself");
    refuses(b"", "standard output is empty");
    refuses(b"hello", "begins with \"hello\"");
}
