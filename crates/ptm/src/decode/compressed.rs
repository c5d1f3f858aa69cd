//! §2.9 Compressed Data: the parameter and the lists (§2.9.1 – 2.9.7)
//!
//! The biases are followed by ASCII numbers in this order (clause 2.9/1): the compression parameter, the transforms,
//! the motion vectors (all x, then all y), the order, the references, the sizes of the streams and the sizes of their
//! side information. A list has one number per plane, 18 or 9 (clause 2.9/3). The planes follow (§2.9.8).
//!
//! ```text
//! 90                              the encoder's quality                                        §2.9.1
//! 0 1 0 0 0 0 2 0 0               plane 1 inverts its reference, plane 6 displaces its own     §2.9.2
//! 0 0 0 0 0 0 3 0 0               by 3 half texels along x                                     §2.9.3
//! 0 0 0 0 0 0 -2 0 0              and by −2 half texels, one texel, along y
//! 1 2 0 0 0 0 1 0 0               decoded in the order 2 3 4 5 7 8, 0 6, 1                     §2.9.4
//! 5 0 -1 -1 -1 -1 7 -1 -1         plane 0 is predicted from plane 5, 1 from 0, 6 from 7        §2.9.5
//! 812 640 655 702 688 690 …       the bytes of each stream                                     §2.9.6
//! 0 5 0 0 0 0 0 0 0               plane 1 has one record of side information                   §2.9.7
//! ```
//!
//! Format notes
//! - The text does not specify line ends. The only known real file has one line per list and two for the motion vectors. Any
//!   other line breaks are accepted as well (clause 2.9/2, ruling `list-layout`).
//! - A number in the order list is a *rank*. Its index in the list is the index of the plane, not of the step (ruling `order`).
//!   Equal ranks, gaps between ranks and a missing rank 0 are accepted if every reference has a lower rank than the planes that
//!   it predicts (clause 2.9.4/3, ruling `ranks`).
//! - The parameter is for the encoder (clause 2.9.1/2). A decoder uses the quantization tables or the NEAR of each stream.
//! - All lists, and the planes themselves (clause 2.9.8/1), are in plane order, regardless of the order of decoding.
//! - References are zero-based. Only −1 means that there is no reference (clause 2.9.5/2).
//! - The transform and the vector belong to the predicted plane, not to its reference. For an intra plane they have
//!   no meaning (ruling `prediction`).
//! - A side information size of 0 means no side information (clause 2.9.7/2), represented here as an empty block.

use std::ops::Range;

use super::{channels::Channels, planes};
// Both versions return the same residuals. The parallel version is faster.
#[cfg(not(feature = "parallel"))]
use super::planes::residuals;
#[cfg(feature = "parallel")]
use super::threads::residuals;
use crate::error::{Error, Kind, Result};
use crate::input::Input;
use crate::parts::{Coded, Extent, Number, Plan, RawLists, Step};
use crate::reading::Reading;
use crate::types::{Coding, Header, Limits};

/// A compressed file with decoded streams, before its planes are predicted and corrected.
pub struct Streams<'a> {
    pub(super) header: Header,
    coding: Coding,
    /// Numbers in the lists (2.9.1–2.9.7), unmodified.
    pub lists: RawLists,
    pub(super) plan: Plan,
    /// Offset of `payload` in the file.
    pub(super) at: usize,
    /// All streams and their side information.
    pub(super) payload: &'a [u8],
    /// Residuals of each stream, in the order of decoding.
    pub(super) residuals: Vec<Vec<u8>>,
}

impl<'a> Streams<'a> {
    /// Reads everything from the parameter to the last stream.
    ///
    /// # Errors
    /// Returns the violated clause, the byte offset, and what was found there.
    pub fn read(
        header: &Header,
        coding: Coding,
        input: &mut Input<'a>,
        reading: &Reading,
        limits: &Limits,
    ) -> Result<Streams<'a>> {
        // Clause 2.9/3: one number per plane, 18 or 9.
        let lists = read_lists(header.format.channels(), input)?; //            §2.9.1 – 2.9.7
        let plan = (reading.plan)(&lists)?; //                                  the steps that they describe
        let at = input.at();
        let mut streams = Streams {
            header: *header,
            coding,
            payload: planes::take_payload(header, &plan, declared_bytes(&lists), input, limits)?, // §2.9.8: all planes
            lists,
            plan,
            at,
            residuals: Vec::new(),
        };
        streams.residuals = residuals(&streams.coded(), reading)?; //           the decoded streams
        Ok(streams)
    }

    /// Returns the parts of the file that are passed to the functions of a reading.
    #[must_use]
    pub fn coded(&self) -> Coded<'_> {
        Coded {
            coding: self.coding,
            size: self.header.size,
            plan: &self.plan,
            at: self.at,
            payload: self.payload,
        }
    }

    /// Returns the index of each plane with the residuals of its stream, in the order of decoding.
    pub fn residuals(&self) -> impl Iterator<Item = (usize, &[u8])> {
        let residuals = self.residuals.iter().map(Vec::as_slice);
        self.plan.sequence.iter().copied().zip(residuals)
    }

    /// Predicts and corrects the planes, and returns them as parts of the file. `residuals` are the decoded streams.
    pub(super) fn channels(
        &self,
        residuals: Vec<Vec<u8>>,
        reading: &Reading,
    ) -> Result<Vec<Channels<'static>>> {
        let planes = (reading.reconstruct)(&self.coded(), residuals, reading)?;
        Ok(planes::planes_to_channels(planes))
    }
}

pub(super) fn read(
    header: &Header,
    coding: Coding,
    input: &mut Input,
    reading: &Reading,
    limits: &Limits,
) -> Result<Vec<Channels<'static>>> {
    let mut streams = Streams::read(header, coding, input, reading, limits)?;
    // Residuals become planes in place, so that there is only one copy.
    let residuals = std::mem::take(&mut streams.residuals);
    streams.channels(residuals, reading)
}

/// Reads the parameter and the six lists in file order (clause 2.9/1). The list of motion vectors has two numbers per plane.
fn read_lists(plane_count: usize, input: &mut Input) -> Result<RawLists> {
    let parameter = read_number(input, "2.9.1/1", "a compression parameter")?;
    let mut list = |clause, name, count| -> Result<Vec<Number>> {
        let next = |_| {
            // list-layout: a gap or a line end after any number.
            input.gap_or_line_end("2.9/2")?;
            read_number(input, clause, name)
        };
        (0..count).map(next).collect()
    };
    let lists = RawLists {
        planes: plane_count,
        parameter,
        transforms: list("2.9.2/1", "a transform", plane_count)?,
        motion: list("2.9.3/1", "a motion vector", 2 * plane_count)?,
        order: list("2.9.4/1", "the order of a plane", plane_count)?,
        references: list("2.9.5/1", "a reference plane", plane_count)?,
        sizes: list("2.9.6/1", "a compressed size", plane_count)?,
        side_sizes: list("2.9.7/1", "a side information size", plane_count)?,
    };
    input.line_end("2.0/2")?;
    Ok(lists)
}

/// Reads one number in a list. Keeps its offset, because some errors are detected later, when the lists are compared.
fn read_number(input: &mut Input, clause: &'static str, name: &'static str) -> Result<Number> {
    let at = input.at();
    Ok(Number {
        value: input.integer(clause, name)?,
        at,
    })
}

/// Creates the decoding plan that the lists describe, or returns the reason why they are invalid.
///
/// # Errors
/// Returns the violated clause, the byte offset, and what was found there.
pub fn make_plan(lists: &RawLists) -> Result<Plan> {
    let planes = lists.planes;
    let steps = (0..planes)
        .map(|plane| prediction_step(lists, plane))
        .collect::<Result<_>>()?;
    // Planes with the lowest rank come first (clause 2.9.4/2). Planes of equal rank are independent and sorted by index.
    let mut sequence: Vec<usize> = (0..planes).collect();
    sequence.sort_by_key(|&plane| lists.order[plane].value);
    let extents = plane_extents(lists)?;
    Ok(Plan {
        parameter: lists.parameter.value,
        steps,
        sequence,
        extents,
    })
}

/// Returns the prediction step of a plane (clauses 2.9.2/1, 2.9.3/1, 2.9.5/1).
fn prediction_step(lists: &RawLists, plane: usize) -> Result<Step> {
    let planes = lists.planes;
    let transform = lists.transforms[plane];
    if !(0..=3).contains(&transform.value) {
        // Undefined bits are rejected (clause 2.9.2/5, ruling `transforms`), for intra planes as well.
        return Err(Error::new(
            "2.9.2/5",
            transform.at,
            Kind::NotSupported {
                what: "transforms other than 0 to 3",
            },
        ));
    }
    // Each bit has its own meaning (clause 2.9.2/2).
    Ok(Step {
        reference: checked_reference(lists, plane)?,
        // If a bit is not set, the reference is unchanged, even if there is a vector.
        inverted: transform.value & 1 != 0,  // clause 2.9.2/3
        displaced: transform.value & 2 != 0, // clause 2.9.2/4
        motion: (
            lists.motion[plane].value,
            lists.motion[planes + plane].value,
        ),
    })
}

/// Returns the reference of a plane. Checks that it exists and has a lower rank than the plane (clauses 2.9.4/2, 2.9.5/3).
fn checked_reference(lists: &RawLists, plane: usize) -> Result<Option<usize>> {
    let planes = lists.planes;
    let number = lists.references[plane];
    // −1 means "intra coded" (clause 2.9.5/2). Smaller numbers do not refer to a plane either (ruling `ranks`).
    let Ok(reference) = usize::try_from(number.value) else {
        return Ok(None);
    };
    if reference >= planes {
        let kind = Kind::NotAPlane {
            plane,
            reference: number.value,
            planes,
        };
        return Err(Error::new("2.9.5/3", number.at, kind));
    }
    let (rank, reference_rank) = (lists.order[plane].value, lists.order[reference].value);
    if reference_rank >= rank {
        let kind = Kind::NotCausal {
            plane,
            rank,
            reference,
            reference_rank,
        };
        return Err(Error::new("2.9.4/2", number.at, kind));
    }
    Ok(Some(reference))
}

/// Returns the total size of all planes and their side information. The total may exceed the address space.
fn declared_bytes(lists: &RawLists) -> u64 {
    let sizes = lists.sizes.iter().chain(&lists.side_sizes);
    let sizes = sizes.filter_map(|number| u64::try_from(number.value).ok());
    sizes.fold(0, u64::saturating_add)
}

/// Returns the byte ranges of each plane. The streams are in plane order, and each is followed by its side information (clauses
/// 2.9.8/1, 2.9.8/4).
fn plane_extents(lists: &RawLists) -> Result<Vec<Extent>> {
    // Saturate on overflow, because no file is that long.
    let mut end = 0;
    let mut next = |number: &Number, clause, what| -> Result<Range<usize>> {
        let invalid_size = |_| {
            Error::new(
                clause,
                number.at,
                Kind::Expected {
                    what,
                    found: number.value.to_string(),
                },
            )
        };
        let size = u64::try_from(number.value).map_err(invalid_size)?;
        let start = end;
        end = usize::saturating_add(start, usize::try_from(size).unwrap_or(usize::MAX));
        Ok(start..end)
    };
    let extent = |(size, side): (&Number, &Number)| {
        let stream = next(size, "2.9.6/2", "a compressed size of at least 0")?;
        let side = next(side, "2.9.7/3", "a side information size of at least 0")?;
        Ok(Extent { stream, side })
    };
    let sizes = lists.sizes.iter().zip(&lists.side_sizes);
    sizes.map(extent).collect()
}
