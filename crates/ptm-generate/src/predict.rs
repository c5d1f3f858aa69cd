//! §2.9.2–2.9.5 Transforms, Motion Vectors, Order, Reference Planes
//!
//! A plane may be predicted from another plane, its reference, which is decoded earlier. The reference may first be
//! inverted (clause 2.9.2/3), displaced by half texels (clauses 2.9.2/4, 2.9.3/2), or both.
//!
//! Format notes
//! - All coordinates are in the stored raster, where row 0 is the bottom row.
//! - The text names the transforms but gives no formulas. Inversion is 255 − reference (ruling `prediction`).
//! - Half-texel motion and motion past the edge follow our rulings: `motion-sign`, `motion-vertical`, `motion-half`,
//!   `motion-border`, `motion-inversion`.

use ptm::Size;

/// The bit of a transform that inverts the reference (clause 2.9.2/3).
pub const INVERSION: u32 = 1;

/// The bit of a transform that displaces the reference (clause 2.9.2/4).
pub const MOTION: u32 = 2;

/// Returns the predictor of a plane, which is its transformed reference.
pub fn predictor(reference: &[u8], size: Size, transform: u32, vector: (i32, i32)) -> Vec<u8> {
    // motion-inversion: invert first, then displace.
    let inverted: Vec<u8> = match transform & INVERSION {
        0 => reference.to_vec(),
        _ => reference.iter().map(|&sample| 255 - sample).collect(),
    };
    if transform & MOTION == 0 {
        inverted
    } else {
        displace(&inverted, size, vector)
    }
}

/// Displaces a plane by half the vector: the value at (x, y) is the input at (x + mx / 2, y + my / 2).
fn displace(plane: &[u8], size: Size, (mx, my): (i32, i32)) -> Vec<u8> {
    let mut displaced = Vec::with_capacity(plane.len());
    for y in 0..i64::from(size.height) {
        for x in 0..i64::from(size.width) {
            // motion-sign, motion-vertical: add the vector; y increases in the order of stored rows.
            let (x2, y2) = (2 * x + i64::from(mx), 2 * y + i64::from(my));
            displaced.push(sample_between(plane, size, x2, y2));
        }
    }
    displaced
}

/// Returns the sample at a position in half texels: one texel, or the mean of two or four.
fn sample_between(plane: &[u8], size: Size, x2: i64, y2: i64) -> u8 {
    let (left, below) = (x2.div_euclid(2), y2.div_euclid(2));
    let (right, above) = (left + x2.rem_euclid(2), below + y2.rem_euclid(2));
    let corners = [(left, below), (right, below), (left, above), (right, above)];
    let corners = corners.map(|(x, y)| u32::from(sample_at(plane, size, x, y)));
    let sum: u32 = corners.iter().sum();
    // motion-half: halves are rounded up. For two equal pairs the mean of four is the mean of two, (a + b + 1) >> 1.
    ((sum + 2) >> 2) as u8
}

/// Returns the sample at a position, or the nearest edge sample if the position is outside the plane (ruling `motion-border`).
fn sample_at(plane: &[u8], size: Size, x: i64, y: i64) -> u8 {
    let (width, height) = (i64::from(size.width), i64::from(size.height));
    plane[(y.clamp(0, height - 1) * width + x.clamp(0, width - 1)) as usize]
}
