//! §2.9.8: mistakes in decoding the streams of planes, and in the order of rows

use super::change::{Change, Changes};
use super::layout::{flip_rows, top_row_first};
use super::literal_presets::{self, LiteralPresets};
use ptm::Coding::{self, Jpeg, JpegLs};
use ptm::Size;
use ptm::decode::planes;
use ptm::error::{Error, Kind, Result};
use ptm::parts::{Coded, PlaneStream};
use ptm::reading::Reading;

type PlaneSamples = Result<Vec<u8>>;

pub const CHANGES: Changes = |slug| {
    let change: fn(&mut Reading) = match slug {
        // Rows
        "compressed-rows-top-down" => {
            |r| r.stored_row = |header, row| top_row_first(&[Jpeg, JpegLs], header, row)
        }
        "jpeg-rows-top-down" => {
            |r| r.stored_row = |header, row| top_row_first(&[Jpeg], header, row)
        }
        "jpeg-ls-rows-top-down" => {
            |r| r.stored_row = |header, row| top_row_first(&[JpegLs], header, row)
        }
        "compressed-colors-top-down" => {
            return Some(Change::Map(|ptm| {
                if ptm.header.format.coding().is_some() && ptm.header.format.channels() == 9 {
                    flip_rows(ptm, 6..9);
                }
            }));
        }
        "compressed-green-and-blue-top-down" => {
            return Some(Change::Map(|ptm| {
                if ptm.header.format.coding().is_some() && ptm.header.format.channels() == 18 {
                    flip_rows(ptm, 6..18);
                }
            }));
        }
        // Samples
        "jpeg-rows-padded-to-4" => |r| r.stream = |plane| decode_with_padded_rows(plane, 4),
        "jpeg-rows-padded-to-8" => |r| r.stream = |plane| decode_with_padded_rows(plane, 8),
        "compressed-columns-mirrored" => |r| {
            r.stream = |plane| {
                let mut samples = planes::decode_stream(plane)?;
                let rows = samples.chunks_exact_mut(plane.size.width as usize);
                rows.for_each(<[u8]>::reverse);
                Ok(samples)
            };
        },
        "jpeg-studio-range" => |r| {
            r.stream = |plane| {
                decode_and_map(plane, |value| {
                    ((i32::from(value) - 16) * 255 / 219).clamp(0, 255) as u8
                })
            };
        },
        "jpeg-studio-range-made" => |r| {
            r.stream =
                |plane| decode_and_map(plane, |value| (u16::from(value) * 219 / 255 + 16) as u8);
        },
        "jpeg-without-level-shift" => {
            |r| r.stream = |plane| decode_and_map(plane, |value| value.saturating_sub(128))
        }
        "jpeg-gamma" => |r| {
            r.stream = |plane| {
                // A square root resembles color management, and is exact on every machine.
                decode_and_map(plane, |value| (u16::from(value) * 255).isqrt() as u8)
            };
        },
        "jpeg-first-bytes-of-rgb" => |r| r.stream = |plane| decode_first_bytes(plane, 3),
        "jpeg-first-bytes-of-rgba" => |r| r.stream = |plane| decode_first_bytes(plane, 4),
        "jpeg-linear-gray-to-srgb" => |r| r.stream = |plane| decode_and_map(plane, linear_to_srgb),
        "jpeg-low-bit-lost" => |r| r.stream = |plane| decode_and_map(plane, |value| value & 0xFE),
        // Optional features of streams
        "restart-markers-refused" => {
            |r| r.stream = |plane| decode_unless(has_marker(plane.bytes, 0xDD), plane)
        }
        "sof1-refused" => {
            |r| r.stream = |plane| decode_unless(has_marker(plane.bytes, 0xC1), plane)
        }
        "tables-of-16-bits-refused" => |r| {
            r.stream = |plane| {
                let wide = segments(plane.bytes).any(|(code, segment)| {
                    code == 0xDB && segment.first().is_some_and(|&first| first >> 4 == 1)
                });
                decode_unless(wide, plane)
            };
        },
        "tables-of-16-bits-cut" => |r| {
            r.stream = |plane| {
                decode_edited(plane, |code, segment| {
                    if let (0xDB, [16..=31, table @ ..]) = (code, segment) {
                        for entry in table.chunks_exact_mut(2) {
                            // A step of 0 becomes 1.
                            entry[0] = 0;
                            entry[1] = entry[1].max(1);
                        }
                    }
                })
            };
        },
        "quantization-table-in-rows" => |r| {
            r.stream = |plane| {
                decode_edited(plane, |code, segment| {
                    if let (0xDB, [0..=15, table @ ..]) = (code, segment)
                        && table.len() == 64
                    {
                        // Entry k of the table is used for frequency k in row order, although the table is in zigzag order.
                        let stored = table.to_vec();
                        table.copy_from_slice(&zigzag().map(|position| stored[position]));
                    }
                })
            };
        },
        "optimised-tables-refused" => |r| {
            r.stream = |plane| {
                // The tables of Annex K have 12 and 162 codes.
                let codes = |segment: &[u8]| -> u32 {
                    let counts = segment.get(1..17).unwrap_or_default();
                    counts.iter().map(|&count| u32::from(count)).sum()
                };
                let own = segments(plane.bytes).any(|(code, segment)| {
                    code == 0xC4 && ![12, 162, 174].contains(&codes(segment))
                });
                decode_unless(own, plane)
            };
        },
        "sampling-factors-refused" => |r| {
            r.stream = |plane| {
                let factors = segments(plane.bytes).any(|(code, segment)| {
                    matches!(code, 0xC0 | 0xC1) && segment.get(7).is_some_and(|&f| f != 0x11)
                });
                decode_unless(factors, plane)
            };
        },
        "jfif-required" => |r| {
            r.stream = |plane| {
                let is_jpeg = plane.coding == Coding::Jpeg;
                decode_unless(is_jpeg && !has_marker(plane.bytes, 0xE0), plane)
            };
        },
        "one-row-refused" => |r| {
            r.stream = |plane| {
                let is_small = plane.size.width < 8 || plane.size.height < 8;
                decode_unless(is_small && plane.coding == Coding::Jpeg, plane)
            };
        },
        // JPEG-LS parameters
        "near-ignored" => |r| {
            r.stream = |plane| {
                decode_edited(plane, |code, segment| {
                    if let (0xDA, [1, _, _, near, ..], Coding::JpegLs) =
                        (code, segment, plane.coding)
                    {
                        *near = 0;
                    }
                })
            };
        },
        "presets-ignored" => {
            |r| r.stream = |plane| decode_with_presets(plane, |segment| segment[1..11].fill(0))
        }
        "thresholds-ignored" => {
            |r| r.stream = |plane| decode_with_presets(plane, |segment| segment[3..9].fill(0))
        }
        "reset-ignored" => {
            |r| r.stream = |plane| decode_with_presets(plane, |segment| segment[9..11].fill(0))
        }
        "zeros-in-presets-literal" => |r| r.stream = decode_with_literal_presets,
        "presets-kept" => {
            |r| r.reconstruct = |coded, _, reading| decode_reusing_segments(coded, reading, 0xF8)
        }
        "restart-interval-kept" => {
            |r| r.reconstruct = |coded, _, reading| decode_reusing_segments(coded, reading, 0xDD)
        }
        "samples-scaled-to-8-bits" => |r| {
            r.stream = |plane| {
                let mut samples = planes::decode_stream(plane)?;
                if let Some((_, [bits @ 2..=7, ..])) =
                    segments(plane.bytes).find(|&(code, _)| code == 0xF7)
                {
                    for sample in &mut samples {
                        *sample <<= 8 - bits;
                    }
                }
                Ok(samples)
            };
        },
        "presets-refused" => {
            |r| r.stream = |plane| decode_unless(has_marker(plane.bytes, 0xF8), plane)
        }
        // Streams that must be refused
        "plane-size-unchecked" => |r| {
            r.stream = |plane| {
                let frame_header =
                    segments(plane.bytes).find(|(code, _)| matches!(code, 0xC0 | 0xC1 | 0xF7));
                let Some((_, [_, h1, h0, w1, w0, ..])) = frame_header else {
                    return planes::decode_stream(plane);
                };
                let size = Size {
                    width: u16::from_be_bytes([*w1, *w0]).into(),
                    height: u16::from_be_bytes([*h1, *h0]).into(),
                };
                if size.texels() > 1 << 24 {
                    return planes::decode_stream(plane);
                }
                let samples = planes::decode_stream(&PlaneStream { size, ..*plane })?;
                let mut resized = vec![0; plane.size.texels()];
                let rows = resized.chunks_exact_mut(plane.size.width as usize);
                for (to, from) in rows.zip(samples.chunks_exact((size.width as usize).max(1))) {
                    to.iter_mut().zip(from).for_each(|(to, &from)| *to = from);
                }
                Ok(resized)
            };
        },
        "empty-stream-is-a-blank-plane" => |r| {
            r.stream = |plane| {
                if plane.bytes.is_empty() {
                    Ok(vec![0; plane.size.texels()])
                } else {
                    planes::decode_stream(plane)
                }
            };
        },
        "codec-from-the-stream" => |r| {
            r.stream = |plane| {
                let coding = match plane.bytes {
                    [] => plane.coding,
                    bytes if has_marker(bytes, 0xF7) => Coding::JpegLs,
                    _ => Coding::Jpeg,
                };
                planes::decode_stream(&PlaneStream { coding, ..*plane })
            };
        },
        "broken-plane-is-blank" => |r| {
            r.stream = |plane| {
                Ok(planes::decode_stream(plane).unwrap_or_else(|_| vec![0; plane.size.texels()]))
            };
        },
        _ => return None,
    };
    Some(Change::Reading(change))
};

/// Decodes all planes. A stream that lacks a segment with this marker reuses the segment of the previous stream.
fn decode_reusing_segments(coded: &Coded, reading: &Reading, marker: u8) -> Result<Vec<Vec<u8>>> {
    let mut payload = Vec::new();
    let mut plan = coded.plan.clone();
    let mut previous: Vec<u8> = Vec::new();
    for extent in &mut plan.extents {
        let mut stream = coded.payload[extent.stream.clone()].to_vec();
        // The marker and the length occupy four bytes.
        let own = segment_ranges(&stream)
            .into_iter()
            .find(|&(code, _)| code == marker)
            .map(|(_, segment)| stream[segment.start - 4..segment.end].to_vec());
        match own {
            Some(own) => previous = own,
            None if stream.len() > 2 => {
                stream.splice(2..2, previous.iter().copied());
            }
            None => {}
        }
        let start = payload.len();
        payload.extend_from_slice(&stream);
        let middle = payload.len();
        payload.extend_from_slice(&coded.payload[extent.side.clone()]);
        extent.stream = start..middle;
        extent.side = middle..payload.len();
    }
    let modified = Coded {
        plan: &plan,
        payload: &payload,
        ..*coded
    };
    planes::reconstruct(&modified, planes::residuals(&modified, reading)?, reading)
}

/// Decodes a plane, and changes its samples if the stream is a JPEG stream.
fn decode_and_map(plane: &PlaneStream, change: fn(u8) -> u8) -> PlaneSamples {
    let mut samples = planes::decode_stream(plane)?;
    if plane.coding == Coding::Jpeg {
        for value in &mut samples {
            *value = change(*value);
        }
    }
    Ok(samples)
}

/// Applies the transfer function of sRGB to a byte of linear light. No result is close to a tie, so it is the same on every machine.
fn linear_to_srgb(linear: u8) -> u8 {
    let linear = f64::from(linear) / 255.0;
    let encoded = if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    };
    (encoded * 255.0).round() as u8
}

/// Decodes a plane. For JPEG streams, returns the first samples of a buffer whose rows are padded to a multiple of `unit`.
fn decode_with_padded_rows(plane: &PlaneStream, unit: usize) -> PlaneSamples {
    let samples = planes::decode_stream(plane)?;
    if plane.coding != Coding::Jpeg {
        return Ok(samples);
    }
    let width = plane.size.width as usize;
    let padded = width.next_multiple_of(unit);
    let at = |i: usize| samples[i / padded * width + (i % padded).min(width - 1)];
    Ok((0..samples.len()).map(at).collect())
}

/// Decodes a plane. For JPEG streams, returns the first bytes of an image that has `channels` bytes per texel: the sample three
/// times, and an opaque alpha.
fn decode_first_bytes(plane: &PlaneStream, channels: usize) -> PlaneSamples {
    let samples = planes::decode_stream(plane)?;
    if plane.coding != Coding::Jpeg {
        return Ok(samples);
    }
    let byte = |i: usize| match i % channels {
        3 => 255,
        _ => samples[i / channels],
    };
    Ok((0..samples.len()).map(byte).collect())
}

fn decode_unless(refused: bool, plane: &PlaneStream) -> PlaneSamples {
    if refused {
        let kind = Kind::Stream {
            plane: plane.plane,
            unsupported: false,
            what: "streams of this kind are not supported".to_owned(),
        };
        return Err(Error::new("2.9.8/3", plane.at, kind));
    }
    planes::decode_stream(plane)
}

/// Returns the codes and contents of the marker segments of a stream, up to the scan header.
fn segments(bytes: &[u8]) -> impl Iterator<Item = (u8, &[u8])> {
    segment_ranges(bytes)
        .into_iter()
        .map(|(code, range)| (code, &bytes[range]))
}

fn has_marker(bytes: &[u8], marker: u8) -> bool {
    segments(bytes).any(|(code, _)| code == marker)
}

fn segment_ranges(bytes: &[u8]) -> Vec<(u8, std::ops::Range<usize>)> {
    let mut found = Vec::new();
    let mut at = 2;
    while let Some(&[0xFF, code, high, low]) = bytes.get(at..at + 4) {
        let end = at + 2 + usize::from(u16::from_be_bytes([high, low]));
        if end < at + 4 || end > bytes.len() {
            break;
        }
        found.push((code, at + 4..end));
        at = end;
        if code == 0xDA {
            break;
        }
    }
    found
}

/// Decodes a plane after editing the marker segments of its stream.
fn decode_edited(plane: &PlaneStream, edit: impl Fn(u8, &mut [u8])) -> PlaneSamples {
    let mut stream = plane.bytes.to_vec();
    for (code, range) in segment_ranges(plane.bytes) {
        edit(code, &mut stream[range]);
    }
    let bytes = &stream;
    planes::decode_stream(&PlaneStream { bytes, ..*plane })
}

/// Decodes a plane after editing the preset parameters of its stream. A parameter value of 0 selects the default.
fn decode_with_presets(plane: &PlaneStream, edit: fn(&mut [u8])) -> PlaneSamples {
    decode_edited(plane, |code, segment| {
        if code == 0xF8 && segment.len() == 11 && segment[0] == 1 {
            edit(segment);
        }
    })
}

/// Decodes a plane. A 0 among the preset parameters of its stream does not mean a default value.
fn decode_with_literal_presets(plane: &PlaneStream) -> PlaneSamples {
    let samples = planes::decode_stream(plane)?;
    let ranges = segment_ranges(plane.bytes);
    let segment = |marker: u8| {
        let last = ranges.iter().rev().find(|(code, _)| *code == marker);
        last.map(|(_, range)| &plane.bytes[range.clone()])
    };
    let (Some([1, presets @ ..]), Some([1, _, _, near, ..])) = (segment(0xF8), segment(0xDA))
    else {
        return Ok(samples);
    };
    let numbers: Vec<i64> = (presets.chunks_exact(2))
        .map(|bytes| i64::from(u16::from_be_bytes([bytes[0], bytes[1]])))
        .collect();
    let &[maxval, t1, t2, t3, reset] = &numbers[..] else {
        return Ok(samples);
    };
    if !numbers.contains(&0) {
        return Ok(samples);
    }
    let presets = LiteralPresets {
        maxval,
        thresholds: [t1, t2, t3],
        reset,
        near: i64::from(*near),
    };
    let data = &plane.bytes[ranges.last().expect("a scan header").1.end..];
    let decoded = literal_presets::decode(data, plane.size, &presets);
    decoded.map_or_else(|| decode_unless(true, plane), Ok)
}

/// Returns the zigzag permutation of the positions in a block.
fn zigzag() -> [usize; 64] {
    let mut order: Vec<usize> = (0..64).collect();
    // Visit the diagonals in order, even ones upward and odd ones downward.
    order.sort_by_key(|&position| {
        let (row, column) = (position / 8, position % 8);
        let diagonal = row + column;
        (diagonal, if diagonal % 2 == 0 { column } else { row })
    });
    order.try_into().expect("there are 64 positions")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Java 17 returns these values from `getRGB`, for the samples 0, 1, 32, 51, 64, 128, 224 and 255.
    #[test]
    fn linear_gray_is_converted_as_in_java() {
        let encoded = [0, 1, 32, 51, 64, 128, 224, 255].map(linear_to_srgb);
        assert_eq!(encoded, [0, 13, 99, 124, 137, 188, 241, 255]);
    }
}
