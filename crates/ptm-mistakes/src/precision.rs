//! §1.0, §2.4, §2.6 and §2.7: mistakes of precision in computing coefficients and colors

use super::change::{Change, Changes};
use super::half::{Half, round_to_half};
use ptm::reading::Reading;
use ptm::{ScaleBias, Shape, evaluate};

pub const CHANGES: Changes = |slug| {
    let change: fn(&mut Reading) = match slug {
        "coefficients-of-half-floats" => |r| {
            r.final_coefficient =
                |raw, channel, set| round_to_half(evaluate::final_coefficient(raw, channel, set));
        },
        "coefficients-in-half-precision" => |r| r.final_coefficient = half_final_coefficient,
        "colors-in-half-precision" => |r| r.texel_color = half_texel_color,
        _ => return None,
    };
    Some(Change::Reading(change))
};

fn half_final_coefficient(raw: u8, channel: usize, set: &ScaleBias) -> f64 {
    let [raw, bias, scale] = [
        f64::from(raw),
        set.bias[channel % 6],
        set.scale[channel % 6],
    ]
    .map(Half::new);
    ((raw - bias) * scale).value()
}

/// Computes the color of a texel in half precision. The values between the operations are those of the reading.
fn half_texel_color(
    shape: &Shape,
    texel: &[f64],
    (lu, lv): (f64, f64),
    reading: &Reading,
) -> [f64; 3] {
    let (u, v) = (Half::new(lu), Half::new(lv));
    let polynomial = |a: &[f64]| {
        let a = |i: usize| Half::new(a[i]);
        let sum = a(0) * u * u + a(1) * v * v + a(2) * u * v + a(3) * u + a(4) * v + a(5);
        sum.value()
    };
    match shape {
        Shape::Rgb => [&texel[..6], &texel[6..12], &texel[12..]].map(polynomial),
        Shape::Lrgb => {
            let luminance = Half::new((reading.luminance)(polynomial(&texel[..6])));
            let color = |color: f64| luminance * Half::new(color) / Half::new(255.0);
            [texel[6], texel[7], texel[8]].map(|stored| color(stored).value())
        }
        Shape::Lum(matrix) => {
            let y = (reading.lum_luminance)(polynomial(&texel[..6]));
            let [cr, cb] = [texel[6], texel[7]].map(reading.lum_chroma);
            let [y, cr, cb] = (reading.lum_values)(y, cr, cb);
            let v = (reading.lum_vector)(y, cr, cb).map(Half::new);
            (reading.lum_matrix)(matrix).map(|[m0, m1, m2, t]| {
                let [m0, m1, m2, t] = [m0, m1, m2, (reading.lum_translation)(t)].map(Half::new);
                (m0 * v[0] + m1 * v[1] + m2 * v[2] + t).value()
            })
        }
    }
}
