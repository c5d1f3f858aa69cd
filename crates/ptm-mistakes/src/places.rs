//! §2.9.6–2.9.8/1: mistakes in sizes, offsets and the order of the planes

use super::change::{Change, Changes};
use ptm::decode::compressed;
use ptm::error::Result;
use ptm::parts::{Extent, Number, Plan, RawLists};
use ptm::reading::Reading;

pub const CHANGES: Changes = |slug| {
    let change: fn(&mut Reading) = match slug {
        // 2.9.6, 2.9.7 and the offsets of the planes
        "planes-in-decode-order" => |r| {
            r.plan = |lists| {
                change_plan(lists, |lists, plan| {
                    let order = plan.sequence.clone();
                    set_sizes(plan, order, |i| stored_sizes(lists, i));
                })
            };
        },
        "sizes-by-rank" => |r| {
            r.plan = |lists| {
                change_plan(lists, |_, plan| {
                    // The first stream, with its sizes, belongs to the plane that is decoded first.
                    let before = plan.extents.clone();
                    for (position, &i) in plan.sequence.iter().enumerate() {
                        plan.extents[i] = before[position].clone();
                    }
                })
            };
        },
        "side-sizes-are-records" => |r| {
            r.plan = |lists| {
                change_plan(lists, |lists, plan| {
                    set_sizes(plan, 0..lists.planes, |i| {
                        let (stream, side) = stored_sizes(lists, i);
                        (stream, side.saturating_mul(5))
                    });
                })
            };
        },
        "sizes-include-side-information" => |r| {
            r.plan = |lists| {
                change_plan(lists, |lists, plan| {
                    set_sizes(plan, 0..lists.planes, |i| {
                        let (stream, side) = stored_sizes(lists, i);
                        (stream.saturating_sub(side), side)
                    });
                })
            };
        },
        "side-information-not-skipped" => |r| {
            r.plan = |lists| {
                change_plan(lists, |lists, plan| {
                    set_sizes(plan, 0..lists.planes, |i| (stored_sizes(lists, i).0, 0));
                })
            };
        },
        "side-information-before-its-plane" => |r| {
            r.plan = |lists| {
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
            };
        },
        "side-information-behind-all-planes" => |r| {
            r.plan = |lists| {
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
            };
        },
        "negative-side-size-is-none" => |r| {
            r.plan = |lists| {
                let mut lists = lists.clone();
                for number in &mut lists.side_sizes {
                    number.value = number.value.max(0);
                }
                compressed::make_plan(&lists)
            };
        },
        _ => return None,
    };
    Some(Change::Reading(change))
};

/// Returns the plan after changing the byte ranges of its planes.
fn change_plan(lists: &RawLists, change: fn(&RawLists, &mut Plan)) -> Result<Plan> {
    let mut plan = compressed::make_plan(lists)?;
    change(lists, &mut plan);
    Ok(plan)
}

/// Sets the byte ranges of planes that are stored in this order with these sizes.
fn set_sizes(
    plan: &mut Plan,
    order: impl IntoIterator<Item = usize>,
    sizes: impl Fn(usize) -> (usize, usize),
) {
    let mut end = 0usize;
    for i in order {
        let (stream, side) = sizes(i);
        let (start, middle) = (end, end.saturating_add(stream));
        end = middle.saturating_add(side);
        plan.extents[i] = Extent {
            stream: start..middle,
            side: middle..end,
        };
    }
}

/// Returns the sizes of the stream and the side information of a plane. Both are known to be nonnegative.
fn stored_sizes(lists: &RawLists, plane: usize) -> (usize, usize) {
    let size = |number: &Number| number.value.max(0) as usize;
    (size(&lists.sizes[plane]), size(&lists.side_sizes[plane]))
}
