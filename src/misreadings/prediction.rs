//! §2.9.4 and §2.9.5: mistakes with ranks, references, and the sum

#![allow(
    clippy::cast_possible_wrap,
    reason = "planes are 18 at most, and texels fewer than a limit allows"
)]

use super::at::At;
use super::transforms::{map_samples, reconstruct_with, unexpected_number};
use crate::decode::compressed;
use crate::error::Result;
use crate::parts::{Number, Plan, RawLists};

pub(super) const CHANGES: &[(&str, At)] = &[
    // 2.9.4
    (
        "order-as-strict-sequence",
        At::Plan(|lists| {
            let mut plan = compressed::make_plan(lists)?;
            plan.sequence = order_as_planes(lists)?;
            let mut done = vec![false; plan.steps.len()];
            for &i in &plan.sequence {
                if plan.steps[i]
                    .reference
                    .is_some_and(|reference| !done[reference])
                {
                    return Err(unexpected_number(&lists.order[i]));
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
                sequence: order_as_planes(lists)?,
                ..plan_without_ranks(lists)?
            })
        }),
    ),
    ("order-ignored", At::Plan(plan_without_ranks)),
    (
        "order-reversed",
        At::Plan(|lists| {
            let mut plan = compressed::make_plan(lists)?;
            plan.sequence.reverse();
            Ok(plan)
        }),
    ),
    (
        "order-one-based",
        At::Plan(|lists| {
            let mut plan = compressed::make_plan(lists)?;
            plan.sequence.retain(|&i| lists.order[i].value > 0);
            Ok(plan)
        }),
    ),
    (
        "one-plane-a-rank",
        At::Plan(|lists| {
            let mut plan = compressed::make_plan(lists)?;
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
            let mut plan = plan_without_ranks(lists)?;
            plan.sequence.sort_by_key(|&plane| lists.order[plane].value);
            Ok(plan)
        }),
    ),
    // 2.9.5
    (
        "reference-one-based",
        At::Plan(|lists| change_references(lists, |_, value| value.saturating_sub(1))),
    ),
    (
        "reference-one-late",
        At::Plan(|lists| {
            let planes = lists.references.len() as i64;
            change_references_unchecked(lists, |_, value| {
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
            change_references_unchecked(lists, by_rank)
        }),
    ),
    (
        "reference-is-the-plane-before",
        At::Plan(|lists| {
            let mut plan = compressed::make_plan(lists)?;
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
        "reference-past-the-last-is-intra",
        At::Plan(|lists| {
            let planes = lists.references.len() as i64;
            change_references(lists, |_, value| if value < planes { value } else { -1 })
        }),
    ),
    (
        "intra-planes-less-128",
        At::Reconstruct(|coded, residuals, reading| {
            reconstruct_with(coded, residuals, reading, |i, plane, done, steps| {
                coded.predict(i, plane, done, reading);
                if steps[i].reference.is_none() {
                    map_samples(plane, |value| value.wrapping_sub(128));
                }
            })
        }),
    ),
];

/// Returns the plan of a decoder that changes the references before it checks them.
fn change_references(lists: &RawLists, change: impl Fn(usize, i64) -> i64) -> Result<Plan> {
    let mut lists = lists.clone();
    for (i, reference) in lists.references.iter_mut().enumerate() {
        reference.value = change(i, reference.value);
    }
    compressed::make_plan(&lists)
}

/// Returns the plan of a decoder that changes the references and does not check their ranks.
fn change_references_unchecked(
    lists: &RawLists,
    change: impl Fn(usize, i64) -> i64,
) -> Result<Plan> {
    let sequence = compressed::make_plan(lists)?.sequence;
    let mut lists = lists.clone();
    for (i, reference) in lists.references.iter_mut().enumerate() {
        reference.value = change(i, reference.value);
    }
    Ok(Plan {
        sequence,
        ..plan_without_ranks(&lists)?
    })
}

/// Returns the plan of a decoder that ignores ranks and decodes planes in index order. References that are not
/// decoded yet are all zeros.
fn plan_without_ranks(lists: &RawLists) -> Result<Plan> {
    let mut intra = lists.clone();
    intra
        .references
        .iter_mut()
        .for_each(|reference| reference.value = -1);
    let mut plan = compressed::make_plan(&intra)?;
    for (step, reference) in plan.steps.iter_mut().zip(&lists.references) {
        step.reference = if reference.value < 0 {
            None
        } else {
            Some(plane_index(lists, reference)?)
        };
    }
    plan.sequence.sort_unstable();
    Ok(plan)
}

/// Interprets the order list as plane indices.
fn order_as_planes(lists: &RawLists) -> Result<Vec<usize>> {
    let numbers = lists.order.iter();
    numbers.map(|number| plane_index(lists, number)).collect()
}

/// Returns the index of a plane if it is in range.
fn plane_index(lists: &RawLists, number: &Number) -> Result<usize> {
    let planes = lists.planes;
    let found = usize::try_from(number.value)
        .ok()
        .filter(|&plane| plane < planes);
    found.ok_or_else(|| unexpected_number(number))
}
