//! Other numbers in the header: what a writer puts there that computes with them in another way.

use crate::writers::reference::written;
use crate::writers::request::{RequestHeader, WriteRequest};

/// One way to get the numbers wrong.
type Edit = fn(&mut RequestHeader);

const EDITS: &[Edit] = &[
    |h| h.bias = h.bias.map(|bias| -bias),
    |h| h.bias = whole(each(h, |scale, bias| bias * scale)),
    |h| h.scale = h.scale.map(|scale| 1.0 / scale),
    |h| h.scale = h.scale.map(|scale| -scale),
    |h| h.bias = [0; 6],
    |h| h.scale = [1.0; 6],
    |h| h.bias = h.bias.map(|bias| bias.clamp(0, 255)),
    |h| h.bias = h.bias.map(|bias| bias.max(0)),
    |h| h.bias = h.bias.map(|bias| bias.min(255)),
    |h| h.bias = h.bias.map(i64::abs),
    |h| h.bias = h.bias.map(|bias| i64::from(bias as u8)),
    |h| h.bias = h.bias.map(|bias| i64::from(bias as i8)),
    |h| h.bias = h.bias.map(|bias| i64::from(bias as i16)),
    |h| h.scale = h.scale.map(f64::abs),
    |h| h.scale = h.scale.map(|scale| if scale == 0.0 { 1.0 } else { scale }),
    |h| h.scale = h.scale.map(|scale| (scale * 1000.0).round() / 1000.0),
    |h| h.scale = h.scale.map(f64::trunc),
    |h| h.scale = [h.scale[0]; 6],
    |h| h.bias = [h.bias[0]; 6],
    |h| {
        h.scale.reverse();
        h.bias.reverse();
    },
    |h| h.scale.reverse(),
    |h| (h.scale, h.bias) = (h.bias.map(|bias| bias as f64), whole(h.scale)),
    |h| {
        let [s, b] = [h.scale, h.bias.map(|bias| bias as f64)];
        h.scale = [s[0], b[0], s[1], b[1], s[2], b[2]];
        h.bias = whole([s[3], b[3], s[4], b[4], s[5], b[5]]);
    },
    |h| h.bias = h.bias.map(|bias| bias.saturating_mul(255)),
    |h| h.scale = h.scale.map(|scale| scale * 255.0),
    |h| h.scale = h.scale.map(|scale| scale / 255.0),
    // The signs of the terms that a mirrored light changes.
    |h| negate(h, [2, 4]),
    |h| negate(h, [2, 3]),
    |h| negate(h, [3, 4]),
    // The matrix of LUM.
    |h| of_matrix(h, |m| std::array::from_fn(|i| m[i % 4 * 4 + i / 4])),
    |h| {
        of_matrix(h, |m| {
            std::array::from_fn(|i| match (i / 4, i % 4) {
                (column @ 0..3, row @ 0..3) => m[row * 4 + column],
                _ => m[i],
            })
        });
    },
    |h| {
        of_matrix(h, |m| {
            std::array::from_fn(|i| if (12..15).contains(&i) { -m[i] } else { m[i] })
        });
    },
    |h| {
        of_matrix(h, |m| {
            std::array::from_fn(|i| if (12..15).contains(&i) { 0.0 } else { m[i] })
        });
    },
    |h| of_matrix(h, |m| m.map(f64::trunc)),
    |h| {
        of_matrix(h, |m| {
            std::array::from_fn(|i| {
                if i % 4 < 3 {
                    m[i / 4 * 4 + 2 - i % 4]
                } else {
                    m[i]
                }
            })
        });
    },
    |h| {
        of_matrix(h, |m| {
            std::array::from_fn(|i| m[[0, 2, 1, 3][i / 4] * 4 + i % 4])
        });
    },
    |h| {
        // Where the reader takes 128 off Cr and Cb, the translation has it.
        of_matrix(h, |m| {
            std::array::from_fn(|i| match i {
                12..15 => m[i] + 128.0 * (m[4 + i % 4] + m[8 + i % 4]),
                _ => m[i],
            })
        });
    },
    |h| {
        of_matrix(h, |_| {
            [
                1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0,
            ]
        });
    },
];

/// Exchanges of coefficients, whose planes, scales and biases go together.
const EXCHANGES: [[usize; 6]; 7] = [
    [1, 0, 2, 3, 4, 5],
    [0, 1, 2, 4, 3, 5],
    [0, 2, 1, 3, 4, 5],
    [5, 1, 2, 3, 4, 0],
    [0, 1, 3, 2, 4, 5],
    [1, 0, 2, 4, 3, 5],
    [5, 4, 3, 2, 1, 0],
];

/// Files of the same planes under other numbers, and of exchanged coefficients.
pub(super) fn candidates(request: &WriteRequest) -> Vec<Vec<u8>> {
    if request.format.is_compressed() {
        // The numbers mean the same in every format, and streams take their time.
        return Vec::new();
    }
    let edited = EDITS.iter().filter_map(|edit| {
        let mut other = request.clone();
        edit(&mut other.header);
        written(&other).ok()
    });
    let exchanged = EXCHANGES.iter().filter_map(|from| exchanged(request, from));
    edited.chain(exchanged).collect()
}

fn exchanged(request: &WriteRequest, from: &[usize; 6]) -> Option<Vec<u8>> {
    let mut other = request.clone();
    let (scale, bias) = (request.header.scale, request.header.bias);
    other.header.scale = from.map(|i| scale[i]);
    other.header.bias = from.map(|i| bias[i]);
    let channels = request.format.channels();
    let polynomials = if channels == 18 { 18 } else { 6 };
    let texels = other.samples.chunks_exact_mut(channels);
    for (texel, right) in texels.zip(request.samples.chunks_exact(channels)) {
        for i in 0..polynomials {
            texel[i] = right[i / 6 * 6 + from[i % 6]];
        }
    }
    written(&other).ok()
}

/// Something of each scale and its bias.
fn each(header: &RequestHeader, of: fn(f64, f64) -> f64) -> [f64; 6] {
    std::array::from_fn(|i| of(header.scale[i], header.bias[i] as f64))
}

/// Biases are whole numbers.
fn whole(numbers: [f64; 6]) -> [i64; 6] {
    numbers.map(|number| number.round() as i64)
}

fn negate(header: &mut RequestHeader, places: [usize; 2]) {
    for place in places {
        header.scale[place] = -header.scale[place];
    }
}

fn of_matrix(header: &mut RequestHeader, edit: fn([f64; 16]) -> [f64; 16]) {
    header.matrix = header.matrix.map(edit);
}
