//! Other polynomials than that of the text.

use crate::ptm::Shape;

/// What may stand beside a coefficient, in words and as a function of the light. The first six are right, one for each.
pub(in crate::diagnose) const POWERS: &[(&str, fn(f64, f64) -> f64)] = &[
    ("u²", |u, _| u * u),
    ("v²", |_, v| v * v),
    ("u·v", |u, v| u * v),
    ("u", |u, _| u),
    ("v", |_, v| v),
    ("1", |_, _| 1.0),
    ("0", |_, _| 0.0),
    ("(−u²)", |u, _| -u * u),
    ("(−v²)", |_, v| -v * v),
    ("(−u·v)", |u, v| -u * v),
    ("(−u)", |u, _| -u),
    ("(−v)", |_, v| -v),
    ("(−1)", |_, _| -1.0),
    ("2·u", |u, _| 2.0 * u),
    ("2·v", |_, v| 2.0 * v),
    ("2·u·v", |u, v| 2.0 * u * v),
    ("2", |_, _| 2.0),
    ("u² / 2", |u, _| u * u / 2.0),
    ("v² / 2", |_, v| v * v / 2.0),
    ("u·v / 2", |u, v| u * v / 2.0),
    ("u / 2", |u, _| u / 2.0),
    ("v / 2", |_, v| v / 2.0),
    ("1/2", |_, _| 0.5),
    ("|u|", |u, _| u.abs()),
    ("|v|", |_, v| v.abs()),
    ("|u·v|", |u, v| (u * v).abs()),
    ("u·|u|", |u, _| u * u.abs()),
    ("v·|v|", |_, v| v * v.abs()),
    ("(u + v)", |u, v| u + v),
    ("(u − v)", |u, v| u - v),
    ("(u² + v²)", |u, v| u * u + v * v),
    ("(u² − v²)", |u, v| u * u - v * v),
    ("u³", |u, _| u * u * u),
    ("v³", |_, v| v * v * v),
    ("u²·v", |u, v| u * u * v),
    ("u·v²", |u, v| u * v * v),
    ("u²·v²", |u, v| u * u * v * v),
    ("√(1 − u² − v²)", |u, v| {
        (1.0 - u * u - v * v).max(0.0).sqrt()
    }),
];

/// What the six coefficients are multiplied by: places in [`POWERS`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnose) struct Powers(pub [usize; 6]);

impl Powers {
    /// Puts into a5 what becomes of the six coefficients of each polynomial under this light, and 0 into the others.
    pub fn apply(self, finals: &mut [f64], shape: Shape, (u, v): (f64, f64)) {
        let powers = self.0.map(|power| POWERS[power].1(u, v));
        for texel in finals.chunks_exact_mut(shape.channels()) {
            for a in texel[..shape.coefficients()].chunks_exact_mut(6) {
                let sum = a.iter().zip(powers).map(|(a, power)| a * power).sum();
                a.copy_from_slice(&[0.0, 0.0, 0.0, 0.0, 0.0, sum]);
            }
        }
    }

    /// As a sentence without its subject.
    pub fn says(self) -> String {
        let terms = self.0.iter().enumerate();
        let terms = terms.filter_map(|(i, &power)| match POWERS[power].0 {
            "0" => None,
            "1" => Some(format!("a{i}")),
            power => Some(format!("a{i}·{power}")),
        });
        format!("computes C = {}", terms.collect::<Vec<_>>().join(" + "))
    }
}
