//! §2.9.4 and §2.9.5: mistakes in handling ranks and references, and in adding predictors to residuals

#![allow(
    clippy::cast_possible_wrap,
    reason = "there are at most 18 planes, and the number of texels is limited"
)]

use super::change::{Change, Changes};
use super::transforms::{map_samples, reconstruct_with, unexpected_number};
use ptm::decode::compressed;
use ptm::error::Result;
use ptm::parts::{Number, Plan, RawLists};
use ptm::reading::Reading;

pub const CHANGES: Changes = |slug| {
    let change: fn(&mut Reading) = match slug {
        // 2.9.4
        "order-as-strict-sequence" => |r| {
            r.plan = |lists| {
                let mut plan = compressed::make_plan(lists)?;
                plan.sequence = order_as_planes(lists)?;
                let mut done = vec![false; plan.steps.len()];
                for &i in &plan.sequence {
                    let reference = plan.steps[i].reference;
                    if reference.is_some_and(|reference| !done[reference]) {
                        return Err(unexpected_number(&lists.order[i]));
                    }
                    done[i] = true;
                }
                Ok(plan)
            };
        },
        "order-as-sequence" => |r| {
            r.plan = |lists| {
                Ok(Plan {
                    sequence: order_as_planes(lists)?,
                    ..plan_without_ranks(lists)?
                })
            };
        },
        "order-ignored" => |r| r.plan = plan_without_ranks,
        "order-reversed" => |r| {
            r.plan = |lists| {
                let mut plan = compressed::make_plan(lists)?;
                plan.sequence.reverse();
                Ok(plan)
            };
        },
        "order-one-based" => |r| {
            r.plan = |lists| {
                let mut plan = compressed::make_plan(lists)?;
                plan.sequence.retain(|&i| lists.order[i].value > 0);
                Ok(plan)
            };
        },
        "one-plane-a-rank" => |r| {
            r.plan = |lists| {
                let mut plan = compressed::make_plan(lists)?;
                let planes = lists.order.len() as i64;
                plan.sequence = (0..planes)
                    .filter_map(|rank| lists.order.iter().position(|number| number.value == rank))
                    .collect();
                Ok(plan)
            };
        },
        "ranks-of-references-unchecked" => |r| {
            r.plan = |lists| {
                let mut plan = plan_without_ranks(lists)?;
                plan.sequence.sort_by_key(|&plane| lists.order[plane].value);
                Ok(plan)
            };
        },
        // 2.9.5
        "reference-one-based" => |r| {
            r.plan = |lists| {
                compressed::make_plan(&with_references(lists, |value| value.saturating_sub(1)))
            };
        },
        "reference-one-late" => |r| {
            r.plan = |lists| {
                let planes = lists.references.len() as i64;
                change_references_unchecked(lists, |value| match value {
                    0.. => value.saturating_add(1).min(planes - 1),
                    _ => value,
                })
            };
        },
        "reference-is-a-rank" => |r| {
            r.plan = |lists| {
                let by_rank = |rank: i64| {
                    let plane = lists.order.iter().position(|number| number.value == rank);
                    plane.filter(|_| rank >= 0).map_or(-1, |plane| plane as i64)
                };
                change_references_unchecked(lists, by_rank)
            };
        },
        "reference-is-the-plane-before" => |r| {
            r.plan = |lists| {
                let mut plan = compressed::make_plan(lists)?;
                for pair in plan.sequence.windows(2) {
                    if let &[before, i] = pair
                        && plan.steps[i].reference.is_some()
                    {
                        plan.steps[i].reference = Some(before);
                    }
                }
                Ok(plan)
            };
        },
        "reference-past-the-last-is-intra" => |r| {
            r.plan = |lists| {
                let planes = lists.references.len() as i64;
                let plane_or_none = |value: i64| if value < planes { value } else { -1 };
                compressed::make_plan(&with_references(lists, plane_or_none))
            };
        },
        "intra-planes-less-128" => |r| {
            r.reconstruct = |coded, residuals, reading| {
                reconstruct_with(coded, residuals, reading, |i, plane, done, steps| {
                    coded.predict(i, plane, done, reading);
                    if steps[i].reference.is_none() {
                        map_samples(plane, |value| value.wrapping_sub(128));
                    }
                })
            };
        },
        _ => return None,
    };
    Some(Change::Reading(change))
};

fn with_references(lists: &RawLists, change: impl Fn(i64) -> i64) -> RawLists {
    let mut lists = lists.clone();
    for reference in &mut lists.references {
        reference.value = change(reference.value);
    }
    lists
}

/// Returns the plan of a decoder that changes the references and does not check their ranks.
fn change_references_unchecked(lists: &RawLists, change: impl Fn(i64) -> i64) -> Result<Plan> {
    let sequence = compressed::make_plan(lists)?.sequence;
    let plan = plan_without_ranks(&with_references(lists, change))?;
    Ok(Plan { sequence, ..plan })
}

/// Returns the plan of a decoder that ignores ranks and decodes in index order. References not yet decoded contain zeros.
fn plan_without_ranks(lists: &RawLists) -> Result<Plan> {
    let mut plan = compressed::make_plan(&with_references(lists, |_| -1))?;
    for (step, reference) in plan.steps.iter_mut().zip(&lists.references) {
        let predicted = (reference.value >= 0).then(|| plane_index(lists, reference));
        step.reference = predicted.transpose()?;
    }
    plan.sequence.sort_unstable();
    Ok(plan)
}

/// Interprets the order list as plane indices.
fn order_as_planes(lists: &RawLists) -> Result<Vec<usize>> {
    let numbers = lists.order.iter();
    numbers.map(|number| plane_index(lists, number)).collect()
}

/// Converts a number to the index of a plane, or returns an error if there is no plane with this index.
fn plane_index(lists: &RawLists, number: &Number) -> Result<usize> {
    match usize::try_from(number.value) {
        Ok(plane) if plane < lists.planes => Ok(plane),
        _ => Err(unexpected_number(number)),
    }
}
