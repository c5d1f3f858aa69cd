//! §2.9.6–2.9.8/1: mistakes with sizes, offsets and the order of the planes

use super::at::At;
use crate::decode::compressed;
use crate::error::Result;
use crate::parts::{Extent, Number, Plan, RawLists};

pub(super) const CHANGES: &[(&str, At)] = &[
    // 2.9.6, 2.9.7 and the offsets of the planes
    (
        "planes-in-decode-order",
        At::Plan(|lists| {
            change_plan(lists, |lists, plan| {
                let mut end = 0;
                for &i in &plan.sequence {
                    let (stream, side) = (
                        nonnegative_size(&lists.sizes[i]),
                        nonnegative_size(&lists.side_sizes[i]),
                    );
                    let (start, middle) = (end, usize::saturating_add(end, stream));
                    end = middle.saturating_add(side);
                    plan.extents[i] = Extent {
                        stream: start..middle,
                        side: middle..end,
                    };
                }
            })
        }),
    ),
    (
        "sizes-by-rank",
        At::Plan(|lists| {
            change_plan(lists, |_, plan| {
                // The first stream, with its sizes, belongs to the plane that is decoded first.
                let before = plan.extents.clone();
                for (place, &i) in plan.sequence.iter().enumerate() {
                    plan.extents[i] = before[place].clone();
                }
            })
        }),
    ),
    (
        "side-sizes-are-records",
        At::Plan(|lists| {
            change_plan(lists, |lists, plan| {
                set_sizes(plan, |i| {
                    (
                        nonnegative_size(&lists.sizes[i]),
                        nonnegative_size(&lists.side_sizes[i]).saturating_mul(5),
                    )
                });
            })
        }),
    ),
    (
        "sizes-include-side-information",
        At::Plan(|lists| {
            change_plan(lists, |lists, plan| {
                set_sizes(plan, |i| {
                    (
                        nonnegative_size(&lists.sizes[i])
                            .saturating_sub(nonnegative_size(&lists.side_sizes[i])),
                        nonnegative_size(&lists.side_sizes[i]),
                    )
                });
            })
        }),
    ),
    (
        "side-information-not-skipped",
        At::Plan(|lists| {
            change_plan(lists, |lists, plan| {
                set_sizes(plan, |i| (nonnegative_size(&lists.sizes[i]), 0));
            })
        }),
    ),
    (
        "side-information-before-its-plane",
        At::Plan(|lists| {
            change_plan(lists, |_, plan| {
                for extent in &mut plan.extents {
                    let (start, end) = (extent.stream.start, extent.side.end);
                    let side = start..start + extent.side.len();
                    *extent = Extent {
                        stream: side.end..end,
                        side,
                    };
                }
            })
        }),
    ),
    (
        "side-information-behind-all-planes",
        At::Plan(|lists| {
            change_plan(lists, |_, plan| {
                let mut end = 0;
                for extent in &mut plan.extents {
                    extent.stream = end..usize::saturating_add(end, extent.stream.len());
                    end = extent.stream.end;
                }
                for extent in &mut plan.extents {
                    extent.side = end..end.saturating_add(extent.side.len());
                    end = extent.side.end;
                }
            })
        }),
    ),
    (
        "negative-side-size-is-none",
        At::Plan(|lists| {
            let mut lists = lists.clone();
            lists
                .side_sizes
                .iter_mut()
                .for_each(|number| number.value = number.value.max(0));
            compressed::make_plan(&lists)
        }),
    ),
    // 2.9.8: the order of the planes
];

/// Returns the plan after changing the byte ranges of its planes.
fn change_plan(lists: &RawLists, change: fn(&RawLists, &mut Plan)) -> Result<Plan> {
    let mut plan = compressed::make_plan(lists)?;
    change(lists, &mut plan);
    Ok(plan)
}

/// Sets the byte ranges of consecutive planes with these sizes.
fn set_sizes(plan: &mut Plan, sizes: impl Fn(usize) -> (usize, usize)) {
    let mut end = 0usize;
    for (i, extent) in plan.extents.iter_mut().enumerate() {
        let (stream, side) = sizes(i);
        let (start, middle) = (end, end.saturating_add(stream));
        end = middle.saturating_add(side);
        *extent = Extent {
            stream: start..middle,
            side: middle..end,
        };
    }
}

/// Returns a size that is known to be nonnegative.
fn nonnegative_size(number: &Number) -> usize {
    number.value.max(0) as usize
}
