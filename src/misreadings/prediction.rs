//! §2.9.4 and §2.9.5: ranks, references, and the sum

#![allow(
    clippy::cast_possible_wrap,
    reason = "planes are 18 at most, and texels fewer than a limit allows"
)]

use super::at::At;
use super::transforms::{clamped, each, each_pair, planes, refused};
use crate::decode::compressed;
use crate::error::Result;
use crate::parts::{Number, Plan, RawLists};

pub(super) const ACTS: &[(&str, At)] = &[
    // 2.9.4
    (
        "order-as-strict-sequence",
        At::Plan(|lists| {
            let mut plan = compressed::plan(lists)?;
            plan.sequence = listed(lists)?;
            let mut done = vec![false; plan.steps.len()];
            for &i in &plan.sequence {
                if plan.steps[i]
                    .reference
                    .is_some_and(|reference| !done[reference])
                {
                    return Err(refused(&lists.order[i]));
                }
                done[i] = true;
            }
            Ok(plan)
        }),
    ),
    (
        "order-as-sequence",
        At::Plan(|lists| {
            Ok(Plan {
                sequence: listed(lists)?,
                ..unranked(lists)?
            })
        }),
    ),
    ("order-ignored", At::Plan(unranked)),
    (
        "order-reversed",
        At::Plan(|lists| {
            let mut plan = compressed::plan(lists)?;
            plan.sequence.reverse();
            Ok(plan)
        }),
    ),
    (
        "order-one-based",
        At::Plan(|lists| {
            let mut plan = compressed::plan(lists)?;
            plan.sequence.retain(|&i| lists.order[i].value > 0);
            Ok(plan)
        }),
    ),
    (
        "one-plane-a-rank",
        At::Plan(|lists| {
            let mut plan = compressed::plan(lists)?;
            let planes = lists.order.len() as i64;
            plan.sequence = (0..planes)
                .filter_map(|rank| lists.order.iter().position(|number| number.value == rank))
                .collect();
            Ok(plan)
        }),
    ),
    (
        "ranks-of-references-unchecked",
        At::Plan(|lists| {
            let mut plan = unranked(lists)?;
            plan.sequence.sort_by_key(|&plane| lists.order[plane].value);
            Ok(plan)
        }),
    ),
    // 2.9.5
    (
        "reference-one-based",
        At::Plan(|lists| referring(lists, |_, value| value.saturating_sub(1))),
    ),
    (
        "reference-one-late",
        At::Plan(|lists| {
            let planes = lists.references.len() as i64;
            referring_to(lists, |_, value| {
                if value < 0 {
                    value
                } else {
                    value.saturating_add(1).min(planes - 1)
                }
            })
        }),
    ),
    (
        "reference-is-a-rank",
        At::Plan(|lists| {
            let by_rank = |_: usize, rank: i64| {
                if rank < 0 {
                    -1
                } else {
                    lists
                        .order
                        .iter()
                        .position(|number| number.value == rank)
                        .map_or(-1, |i| i as i64)
                }
            };
            referring_to(lists, by_rank)
        }),
    ),
    (
        "reference-is-the-plane-before",
        At::Plan(|lists| {
            let mut plan = compressed::plan(lists)?;
            for pair in plan.sequence.windows(2) {
                if let &[before, i] = pair
                    && plan.steps[i].reference.is_some()
                {
                    plan.steps[i].reference = Some(before);
                }
            }
            Ok(plan)
        }),
    ),
    (
        "reference-zero-is-intra",
        At::Plan(|lists| referring(lists, |_, value| if value == 0 { -1 } else { value })),
    ),
    (
        "references-ignored",
        At::Plan(|lists| referring(lists, |_, _| -1)),
    ),
    (
        "reference-past-the-last-is-intra",
        At::Plan(|lists| {
            let planes = lists.references.len() as i64;
            referring(lists, |_, value| if value < planes { value } else { -1 })
        }),
    ),
    (
        "intra-planes-less-128",
        At::Reconstruct(|coded, residuals, reading| {
            planes(coded, residuals, reading, |i, plane, done, steps| {
                coded.predict(i, plane, done, reading);
                if steps[i].reference.is_none() {
                    each(plane, |value| value.wrapping_sub(128));
                }
            })
        }),
    ),
    (
        "predicted-from-residuals",
        At::Reconstruct(|coded, residuals, reading| {
            let mut streams = coded.blank_planes();
            for (&i, stream) in coded.plan.sequence.iter().zip(&residuals) {
                streams[i].clone_from(stream);
            }
            planes(coded, residuals, reading, |i, plane, _, _| {
                coded.predict(i, plane, &streams, reading);
            })
        }),
    ),
    (
        "no-128",
        At::Predict(|residuals, predictor| each_pair(residuals, predictor, u8::wrapping_add)),
    ),
    (
        "offset-127",
        At::Predict(|residuals, predictor| {
            each_pair(residuals, predictor, |value, predicted| {
                value.wrapping_add(predicted).wrapping_sub(127)
            });
        }),
    ),
    (
        "wrap-mod-255",
        At::Predict(|residuals, predictor| {
            each_pair(residuals, predictor, |value, predicted| {
                (sum(value, predicted) % 255) as u8
            });
        }),
    ),
    (
        "wrap-below-only",
        At::Predict(|residuals, predictor| {
            each_pair(residuals, predictor, |value, predicted| {
                match sum(value, predicted) {
                    sum @ ..0 => sum as u8,
                    sum => clamped(sum),
                }
            });
        }),
    ),
    (
        "wrap-above-only",
        At::Predict(|residuals, predictor| {
            each_pair(residuals, predictor, |value, predicted| {
                match sum(value, predicted) {
                    sum @ 0.. => sum as u8,
                    _ => 0,
                }
            });
        }),
    ),
    (
        "clamp-not-wrap",
        At::Predict(|residuals, predictor| {
            each_pair(residuals, predictor, |value, predicted| {
                clamped(sum(value, predicted))
            });
        }),
    ),
    (
        "residual-subtracted",
        At::Predict(|residuals, predictor| {
            each_pair(residuals, predictor, |value, predicted| {
                predicted.wrapping_sub(value).wrapping_add(128)
            });
        }),
    ),
    (
        "residual-doubled",
        At::Predict(|residuals, predictor| {
            each_pair(residuals, predictor, |value, predicted| {
                predicted.wrapping_add(value.wrapping_sub(128).wrapping_mul(2))
            });
        }),
    ),
    (
        "residual-zero-is-256",
        At::Predict(|residuals, predictor| {
            each_pair(residuals, predictor, |value, predicted| {
                if value == 0 {
                    predicted.saturating_add(128)
                } else {
                    value.wrapping_add(predicted).wrapping_sub(128)
                }
            });
        }),
    ),
    (
        "prediction-is-a-mean",
        At::Predict(|residuals, predictor| each_pair(residuals, predictor, u8::midpoint)),
    ),
];

/// The plan of a reader who uses other numbers as references, and checks them correctly.
fn referring(lists: &RawLists, change: impl Fn(usize, i64) -> i64) -> Result<Plan> {
    let mut lists = lists.clone();
    for (i, reference) in lists.references.iter_mut().enumerate() {
        reference.value = change(i, reference.value);
    }
    compressed::plan(&lists)
}

/// The same of a reader that does not look at their ranks.
fn referring_to(lists: &RawLists, change: impl Fn(usize, i64) -> i64) -> Result<Plan> {
    let sequence = compressed::plan(lists)?.sequence;
    let mut lists = lists.clone();
    for (i, reference) in lists.references.iter_mut().enumerate() {
        reference.value = change(i, reference.value);
    }
    Ok(Plan {
        sequence,
        ..unranked(&lists)?
    })
}

/// The plan of a reader that does not look at ranks: planes in plane order, from references that may come later. What is
/// not decoded yet is full of zeros.
fn unranked(lists: &RawLists) -> Result<Plan> {
    let mut intra = lists.clone();
    intra
        .references
        .iter_mut()
        .for_each(|reference| reference.value = -1);
    let mut plan = compressed::plan(&intra)?;
    for (step, reference) in plan.steps.iter_mut().zip(&lists.references) {
        step.reference = if reference.value < 0 {
            None
        } else {
            Some(plane(lists, reference)?)
        };
    }
    plan.sequence.sort_unstable();
    Ok(plan)
}

/// The order list as planes.
fn listed(lists: &RawLists) -> Result<Vec<usize>> {
    let numbers = lists.order.iter();
    numbers.map(|number| plane(lists, number)).collect()
}

/// The plane of that number, if there is one.
fn plane(lists: &RawLists, number: &Number) -> Result<usize> {
    let planes = lists.format.channels();
    let found = usize::try_from(number.value)
        .ok()
        .filter(|&plane| plane < planes);
    found.ok_or_else(|| refused(number))
}

/// Residual + predictor − 128, before anything wraps.
fn sum(value: u8, predicted: u8) -> i16 {
    i16::from(value) + i16::from(predicted) - 128
}
