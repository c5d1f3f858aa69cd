//! §2.9.2: mistakes in the choice and effect of transforms

use super::change::{Change, Changes};
use ptm::decode::{compressed, predict as rule};
use ptm::error::{Error, Kind, Result};
use ptm::parts::{Coded, Number, Plan, RawLists, Step};
use ptm::reading::Reading;

pub const CHANGES: Changes = |slug| {
    let change: fn(&mut Reading) = match slug {
        // 2.9.2: choice of the transform
        "any-transform-refused" => {
            |r| r.plan = |lists| plan_unless(lists, |transform| transform != 0)
        }
        "motion-refused" => |r| r.plan = |lists| plan_unless(lists, |transform| transform & 2 != 0),
        "undefined-transforms-ignored" => |r| {
            r.plan = |lists| {
                let mut lists = lists.clone();
                for transform in &mut lists.transforms {
                    transform.value &= 3;
                }
                compressed::make_plan(&lists)
            };
        },
        // 2.9.2: effect of the transform
        "inversion-turns-the-plane-round" => |r| r.invert = <[u8]>::reverse,
        "inversion-with-one-carry" => |r| {
            r.reconstruct = |coded, residuals, reading| {
                reconstruct_with(coded, residuals, reading, |i, plane, done, _| {
                    let step = &coded.plan.steps[i];
                    match step.reference {
                        Some(reference) if step.inverted && !step.displaced => {
                            for (value, &reference) in plane.iter_mut().zip(&done[reference]) {
                                let sum = i16::from(*value) - i16::from(reference) - 129;
                                let sum = if sum < 0 { sum + 256 } else { sum };
                                *value = sum.clamp(0, 255) as u8;
                            }
                        }
                        _ => coded.predict(i, plane, done, reading),
                    }
                })
            };
        },
        "inversion-of-the-residual" => |r| {
            r.reconstruct = |coded, residuals, reading| {
                reconstruct_with(coded, residuals, reading, |i, plane, done, steps| {
                    if steps[i].reference.is_some() && steps[i].inverted {
                        (reading.invert)(plane);
                    }
                    predict(coded, reading, plane, done, without_inversion(steps[i]));
                })
            };
        },
        "inversion-of-the-result" => |r| {
            r.reconstruct = |coded, residuals, reading| {
                reconstruct_with(coded, residuals, reading, |i, plane, done, steps| {
                    predict(coded, reading, plane, done, without_inversion(steps[i]));
                    if steps[i].reference.is_some() && steps[i].inverted {
                        (reading.invert)(plane);
                    }
                })
            };
        },
        "motion-of-the-residual" => |r| {
            r.reconstruct = |coded, residuals, reading| {
                reconstruct_with(coded, residuals, reading, |i, plane, done, steps| {
                    if steps[i].reference.is_some() && steps[i].displaced {
                        let moved =
                            rule::displace_plane(plane, coded.size, steps[i].motion, reading);
                        plane.copy_from_slice(&moved);
                    }
                    predict(coded, reading, plane, done, without_motion(steps[i]));
                })
            };
        },
        "motion-of-the-result" => |r| {
            r.reconstruct = |coded, residuals, reading| {
                reconstruct_with(coded, residuals, reading, |i, plane, done, steps| {
                    predict(coded, reading, plane, done, without_motion(steps[i]));
                    if steps[i].reference.is_some() && steps[i].displaced {
                        let moved =
                            rule::displace_plane(plane, coded.size, steps[i].motion, reading);
                        plane.copy_from_slice(&moved);
                    }
                })
            };
        },
        "transforms-of-intra-planes" => |r| {
            r.reconstruct = |coded, residuals, reading| {
                reconstruct_with(coded, residuals, reading, |i, plane, done, steps| {
                    coded.predict(i, plane, done, reading);
                    if steps[i].reference.is_none() && steps[i].inverted {
                        (reading.invert)(plane);
                    }
                })
            };
        },
        "reference-stays-inverted" => |r| {
            r.reconstruct = |coded, residuals, reading| {
                let mut done = coded.blank_planes();
                for (&i, mut plane) in coded.plan.sequence.iter().zip(residuals) {
                    let step = coded.plan.steps[i];
                    if let (Some(reference), true) = (step.reference, step.inverted) {
                        (reading.invert)(&mut done[reference]);
                    }
                    predict(coded, reading, &mut plane, &done, without_inversion(step));
                    coded.correct(i, &mut plane, reading)?;
                    done[i] = plane;
                }
                Ok(done)
            };
        },
        "motion-leaves-planes-empty" => |r| {
            r.reconstruct = |coded, residuals, reading| {
                reconstruct_with(coded, residuals, reading, |i, plane, done, steps| {
                    coded.predict(i, plane, done, reading);
                    if steps[i].reference.is_some() && steps[i].displaced {
                        plane.fill(0);
                    }
                })
            };
        },
        _ => return None,
    };
    Some(Change::Reading(change))
};

/// Returns the plan of a decoder that refuses some transforms.
fn plan_unless(lists: &RawLists, refuses: fn(i64) -> bool) -> Result<Plan> {
    let mut transforms = lists.transforms.iter();
    match transforms.find(|transform| refuses(transform.value)) {
        Some(transform) => Err(unexpected_number(transform)),
        None => compressed::make_plan(lists),
    }
}

pub fn unexpected_number(number: &Number) -> Error {
    Error::new(
        "2.9/1",
        number.at,
        Kind::Expected {
            what: "a different number",
            found: number.value.to_string(),
        },
    )
}

/// Reconstructs all planes. `predict` converts the residuals of a plane to its samples, which are then corrected.
pub fn reconstruct_with(
    coded: &Coded,
    residuals: Vec<Vec<u8>>,
    reading: &Reading,
    predict: impl Fn(usize, &mut [u8], &[Vec<u8>], &[Step]),
) -> Result<Vec<Vec<u8>>> {
    let mut done = coded.blank_planes();
    for (&i, mut plane) in coded.plan.sequence.iter().zip(residuals) {
        predict(i, &mut plane, &done, &coded.plan.steps);
        coded.correct(i, &mut plane, reading)?;
        done[i] = plane;
    }
    Ok(done)
}

fn without_inversion(step: Step) -> Step {
    Step {
        inverted: false,
        ..step
    }
}

fn without_motion(step: Step) -> Step {
    Step {
        displaced: false,
        ..step
    }
}

/// Predicts a plane with the given step instead of the one in the plan.
fn predict(coded: &Coded, reading: &Reading, plane: &mut [u8], done: &[Vec<u8>], step: Step) {
    if let Some(reference) = step.reference {
        rule::predict_plane(
            coded.coding,
            plane,
            &done[reference],
            &step,
            coded.size,
            reading,
        );
    }
}

pub fn map_samples(plane: &mut [u8], change: impl Fn(u8) -> u8) {
    for value in plane {
        *value = change(*value);
    }
}
