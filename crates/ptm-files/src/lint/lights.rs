//! Maps on which the light has no effect: the same, black or white under every light.

use super::{codes::Problem, diagnostic::Findings};
use crate::dissection::Role;
use ptm::evaluate::{Coefficients, compute_coefficients};
use ptm::reading::Reading;
use ptm::{Planes, Ptm, Size};

/// Number of texels that are evaluated at a time. Most maps are decided by the first texels.
const CHUNK_TEXELS: usize = 64;
/// Number of lights on each of the two circles of [`lights`].
const LIGHTS_PER_CIRCLE: u32 = 16;

/// Properties that all texels so far have.
struct UniformProperties {
    is_constant: bool,
    is_black: bool,
    is_white: bool,
}

pub(super) fn diagnose(findings: &mut Findings) {
    let Ok(ptm) = &findings.dissection.outcome else {
        return;
    };
    // The values of a converted payload say nothing about the map.
    let converted = Problem::Utf8Payload.code().id;
    if findings
        .list
        .iter()
        .any(|finding| finding.code == converted)
    {
        return;
    }
    let properties = uniform_properties(ptm);
    let colors = [
        (properties.is_black, "black"),
        (properties.is_white, "white"),
    ];
    match colors.into_iter().find(|(is_uniform, _)| *is_uniform) {
        Some((_, color)) => findings.add(Problem::BlackOrWhite, Role::Scale(0), color),
        None if properties.is_constant => {
            let found = "every final coefficient of u and v is 0";
            findings.add(Problem::LightWithoutEffect, Role::Scale(0), found);
        }
        None => {}
    }
}

fn uniform_properties(ptm: &Ptm) -> UniformProperties {
    let mut properties = UniformProperties {
        is_constant: true,
        is_black: true,
        is_white: true,
    };
    let shape = ptm.planes.shape;
    for samples in ptm.planes.samples.chunks(CHUNK_TEXELS * shape.channels()) {
        let (width, height) = ((samples.len() / shape.channels()) as u32, 1);
        let planes = Planes {
            size: Size { width, height },
            shape,
            samples: samples.to_vec(),
        };
        let finals = compute_coefficients(&ptm.header.scale_bias, &planes, &Reading::SPEC);
        properties.restrict(&finals);
        if !(properties.is_constant || properties.is_black || properties.is_white) {
            break;
        }
    }
    properties
}

impl UniformProperties {
    /// Removes the properties that some of these texels do not have.
    fn restrict(&mut self, finals: &Coefficients) {
        let polynomials = finals.shape.coefficients() / 6;
        let mut texels = finals.values.chunks(finals.shape.channels());
        self.is_constant &= texels.all(|texel| {
            let mut polynomials = texel.chunks(6).take(polynomials);
            polynomials.all(|a| a[..5].iter().all(|&coefficient| coefficient == 0.0))
        });
        for (lu, lv) in lights() {
            if !self.is_black && !self.is_white {
                break;
            }
            let colors = finals.evaluate(lu, lv).to_bytes();
            self.is_black &= colors.iter().all(|&color| color == 0);
            self.is_white &= colors.iter().all(|&color| color == u8::MAX);
        }
    }
}

/// Returns the vertical light, and lights on the unit circle and on a circle of half its radius.
fn lights() -> impl Iterator<Item = (f64, f64)> {
    let circle = (0..LIGHTS_PER_CIRCLE).flat_map(|i| {
        let (sin, cos) =
            (std::f64::consts::TAU * f64::from(i) / f64::from(LIGHTS_PER_CIRCLE)).sin_cos();
        [1.0, 0.5].map(|radius| (radius * cos, radius * sin))
    });
    std::iter::once((0.0, 0.0)).chain(circle)
}
