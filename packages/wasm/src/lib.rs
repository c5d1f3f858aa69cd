//! The reference decoder for web pages: fields, findings, planes and images of a file.
//!
//! All exports are functions that take and return numbers, so only `cargo` is needed to build the module. A page calls
//! [`reserve`], writes a file there, calls [`open`], and reads the results at [`report`], [`samples`] and [`relight`].
//! [`examine`] adds fields and findings to the report. One file is open at a time.

use std::cell::RefCell;

use ptm::Ptm;
use ptm::error::{Class, Error};
use ptm_suite::kit::digest::sha256;
use ptm::Shape;
use ptm_files::inspect::inspect;
use ptm_files::lint::lint;
use serde_json::{Value, json};

/// The open file and its results.
#[derive(Default)]
struct Opened {
    /// The bytes of the file, which the page writes.
    file: Vec<u8>,
    /// The map or the error, and after [`examine`] also fields and findings.
    report: Value,
    /// The report as JSON text.
    json: String,
    map: Option<Ptm>,
    /// The last image: red, green, blue and 255 of every texel.
    image: Vec<u8>,
}

thread_local! {
    static OPENED: RefCell<Opened> = RefCell::default();
}

fn with_opened<T>(action: impl FnOnce(&mut Opened) -> T) -> T {
    OPENED.with(|opened| action(&mut opened.borrow_mut()))
}

/// Allocates memory for a file of `length` bytes, and returns its address. The page writes the file there.
#[unsafe(no_mangle)]
pub extern "C" fn reserve(length: usize) -> *mut u8 {
    with_opened(|opened| {
        opened.file = vec![0; length];
        opened.file.as_mut_ptr()
    })
}

/// Decodes the file that the page has written, and creates a report in JSON: properties of the map, or the error. Returns 1 if the
/// file is a map, and 0 if not.
#[unsafe(no_mangle)]
pub extern "C" fn open() -> u32 {
    with_opened(|opened| {
        let decoded = ptm::decode(&opened.file);
        opened.report = describe(decoded.as_ref());
        opened.json = opened.report.to_string();
        opened.map = decoded.ok();
        u32::from(opened.map.is_some())
    })
}

/// Adds fields and findings of the file to the report, as the program prints them. Call it after [`open`].
#[unsafe(no_mangle)]
pub extern "C" fn examine() {
    with_opened(|opened| {
        opened.report["inspect"] = json!(inspect(&opened.file));
        opened.report["lint"] = json!(lint(&opened.file));
        opened.json = opened.report.to_string();
    });
}

/// Returns properties of the map, or the error.
fn describe(decoded: Result<&Ptm, &Error>) -> Value {
    let refused = decoded.err().map(|error| {
        let malformed = error.class() == Class::Malformed;
        let word = if malformed { "malformed" } else { "unsupported" };
        json!({ "kind": word, "says": error.to_string() })
    });
    let map = decoded.ok().map(|ptm| {
        json!({
            "format": ptm.header.format.name(),
            "width": ptm.header.size.width,
            "height": ptm.header.size.height,
            "channels": ptm.planes.shape.channels(),
            "scale": ptm.header.scale_bias.scale,
            "bias": ptm.header.scale_bias.bias,
            "planes": sha256(&ptm.planes.samples),
        })
    });
    json!({ "map": map, "refused": refused })
}

/// Returns the address of the report.
#[unsafe(no_mangle)]
pub extern "C" fn report() -> *const u8 {
    with_opened(|opened| opened.json.as_ptr())
}

/// Returns the length of the report in bytes.
#[unsafe(no_mangle)]
pub extern "C" fn report_length() -> usize {
    with_opened(|opened| opened.json.len())
}

/// Returns the address of the stored values, texel by texel, top row first, or null if no map is open. The report contains
/// width, height and number of channels.
#[unsafe(no_mangle)]
pub extern "C" fn samples() -> *const u8 {
    with_opened(|opened| match &opened.map {
        Some(ptm) => ptm.planes.samples.as_ptr(),
        None => std::ptr::null(),
    })
}

/// Returns the address of the map under a light, four bytes per texel, or null if no map is open.
#[unsafe(no_mangle)]
pub extern "C" fn relight(lu: f64, lv: f64) -> *const u8 {
    with_opened(|opened| {
        let Some(ptm) = &opened.map else {
            return std::ptr::null();
        };
        relight_into(ptm, lu, lv, &mut opened.image);
        opened.image.as_ptr()
    })
}

/// Computes exactly the image of `Coefficients::evaluate` and `RelitImage::to_bytes`. Looks up each term of the polynomial by its
/// stored byte.
fn relight_into(ptm: &Ptm, lu: f64, lv: f64, image: &mut Vec<u8>) {
    let set = &ptm.header.scale_bias;
    let terms: [[f64; 256]; 6] = std::array::from_fn(|i| {
        std::array::from_fn(|raw| {
            let a = (raw as f64 - set.bias[i]) * set.scale[i];
            [a * lu * lu, a * lv * lv, a * lu * lv, a * lu, a * lv, a][i]
        })
    });
    let sum = |a: [u8; 6]| {
        let term = |i: usize| terms[i][usize::from(a[i])];
        term(0) + term(1) + term(2) + term(3) + term(4) + term(5)
    };
    let samples = &ptm.planes.samples;
    match ptm.planes.shape {
        Shape::Rgb => paint(samples, image, |texel: &[u8; 18]| {
            [0, 6, 12].map(|c| sum(std::array::from_fn(|i| texel[c + i])))
        }),
        Shape::Lrgb => paint(samples, image, |&[a0, a1, a2, a3, a4, a5, r, g, b]| {
            let luminance = sum([a0, a1, a2, a3, a4, a5]);
            [r, g, b].map(|color| luminance * f64::from(color) / 255.0)
        }),
        Shape::Lum(m) => paint(samples, image, |&[a0, a1, a2, a3, a4, a5, cr, cb]| {
            let y = sum([a0, a1, a2, a3, a4, a5]);
            let (cr, cb) = (f64::from(cr), f64::from(cb));
            [0, 1, 2].map(|r| m.0[r] * y + m.0[4 + r] * cr + m.0[8 + r] * cb + m.0[12 + r])
        }),
    }
}

/// Writes the color of every texel with `N` channels to an image.
fn paint<const N: usize>(
    samples: &[u8],
    image: &mut Vec<u8>,
    color: impl Fn(&[u8; N]) -> [f64; 3],
) {
    let (texels, _) = samples.as_chunks::<N>();
    image.resize(texels.len() * 4, 255);
    for (texel, pixel) in texels.iter().zip(image.as_chunks_mut::<4>().0) {
        let [r, g, b] = color(texel).map(byte);
        *pixel = [r, g, b, 255];
    }
}

/// Clamps and rounds half up, exactly like `f64::round`, for which WebAssembly has no instruction.
fn byte(value: f64) -> u8 {
    let value = value.clamp(0.0, 255.0);
    let whole = value as u8;
    whole + u8::from(value - f64::from(whole) >= 0.5)
}
