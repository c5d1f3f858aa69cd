//! Streams that replace those in a file but have wrong properties: gray planes with a wrong size, codec or number of components.
//! They require an encoder, so `spec-cases/damages.yaml` contains only their names.

use crate::error::{Error, Result};
use serde::Deserialize;

use super::{model::Model, place::segment};
use ptm::codec::Coding;

/// A stream of a gray plane (all samples are 128) with a wrong property, such as `gray-one-wider`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StandIn {
    OneWider,
    OneTaller,
    WithSwappedSides,
    ByTheOtherCodec,
    OfThreeComponents,
}

impl StandIn {
    /// Returns the stream for a file with these values.
    pub fn stream(self, model: &Model) -> Result<Vec<u8>> {
        let (width, height) = (model.size.width, model.size.height);
        let own = model
            .format
            .coding()
            .ok_or(Error::NotApplicable("the file has no streams".into()))?;
        let other = match own {
            Coding::Jpeg => Coding::JpegLs,
            Coding::JpegLs => Coding::Jpeg,
        };
        Ok(match self {
            StandIn::OneWider => gray(width + 1, height, own),
            StandIn::OneTaller => gray(width, height + 1, own),
            StandIn::WithSwappedSides if width == height => {
                return Err(Error::NotApplicable(
                    "the sides of a square are equal".into(),
                ));
            }
            StandIn::WithSwappedSides => gray(height, width, own),
            StandIn::ByTheOtherCodec => gray(width, height, other),
            StandIn::OfThreeComponents => three_components(&gray(width, height, own)),
        })
    }
}

fn gray(width: u32, height: u32, coding: Coding) -> Vec<u8> {
    let samples = vec![128; width as usize * height as usize];
    let parameter = match coding {
        Coding::Jpeg => 75,
        Coding::JpegLs => 0,
    };
    coding.encode(&samples, (width, height), parameter)
}

/// Returns a legal stream with three full-size components, each in its own scan and equal to the component of `stream`.
fn three_components(stream: &[u8]) -> Vec<u8> {
    let find = |code| segment(stream, code);
    let frame = (find(0xc0).or_else(|| find(0xf7))).expect("an encoder writes a frame header");
    let scan = find(0xda).expect("an encoder writes a scan header").start;
    let (start, end) = (frame.start, stream.len() - 2);
    let table = stream[start + 12];
    // The frame header grows by three bytes per component: id, sampling factors, table.
    let header = [
        &[stream[start], stream[start + 1], 0, 17],
        &stream[start + 4..start + 9],
        &[3],
        &[1, 0x11, table],
        &[2, 0x11, table],
        &[3, 0x11, table],
    ]
    .concat();
    let data = |component: u8| {
        let mut data = stream[scan..end].to_vec();
        data[5] = component;
        data
    };
    let before = [&stream[..start], &header, &stream[frame.end..scan]].concat();
    [before, data(1), data(2), data(3), stream[end..].to_vec()].concat()
}
