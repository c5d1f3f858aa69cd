//! Portable network graphics: grey, palette or color of at most 8 bits, taken as the bytes that they are.
//!
//! There is no color management: gamma, profiles and chromaticities are ignored, because the samples are what the
//! decoder computed. Grey stands for three equal channels. Alpha is left out where it hides nothing.

use std::io::Cursor;

use png::{BitDepth, ColorType, Decoder, DecodingError, Limits, Transformations};

use crate::protocol::frame::{Frame, Samples};

/// Reads a whole file; no more than `most` bytes are unpacked.
pub(crate) fn read(bytes: &[u8], most: usize) -> Result<Frame, String> {
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: most });
    decoder.set_transformations(Transformations::EXPAND);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let mut reader = decoder.read_info().map_err(say)?;
    let (width, height) = reader.info().size();
    if reader.info().bit_depth == BitDepth::Sixteen {
        return Err("it has 16 bits a sample, not 8".to_owned());
    }
    if reader.info().is_animated() {
        return Err("it is animated; an answer is one picture".to_owned());
    }
    let size = reader
        .output_buffer_size()
        .filter(|&size| size <= most)
        .ok_or_else(|| format!("{width} x {height} texels are more than the file can have"))?;
    let mut samples = vec![0; size];
    let info = reader.next_frame(&mut samples).map_err(say)?;
    samples.truncate(info.buffer_size());
    let color = info.color_type;
    reader.finish().map_err(say)?;
    nothing_after(bytes)?;
    Ok(Frame {
        view: "rgb",
        width,
        height,
        channels: 3,
        samples: Samples::U8(color_of(&samples, color, width as usize)?),
    })
}

fn say(error: DecodingError) -> String {
    match error {
        DecodingError::LimitsExceeded => "it is larger than the file can be".to_owned(),
        error => error.to_string(),
    }
}

/// Red, green and blue of each texel.
fn color_of(samples: &[u8], color: ColorType, width: usize) -> Result<Vec<u8>, String> {
    match color {
        ColorType::Rgb => Ok(samples.to_vec()),
        ColorType::Grayscale => Ok(samples.iter().flat_map(|&grey| [grey; 3]).collect()),
        ColorType::Rgba => opaque::<4>(samples, width),
        ColorType::GrayscaleAlpha => opaque::<2>(samples, width),
        ColorType::Indexed => unreachable!("palettes are expanded"),
    }
}

/// The texels without their alpha, the last of `N` samples, which must be 255.
fn opaque<const N: usize>(samples: &[u8], width: usize) -> Result<Vec<u8>, String> {
    let texels = samples.as_chunks::<N>().0;
    if let Some(at) = texels.iter().position(|texel| texel[N - 1] != 255) {
        return Err(format!(
            "texel ({}, {}) is not opaque, its alpha is {}; a lit PTM hides nothing",
            at % width,
            at / width,
            texels[at][N - 1]
        ));
    }
    let color = |texel: &[u8; N]| match N {
        2 => [texel[0]; 3],
        _ => [texel[0], texel[1], texel[2]],
    };
    Ok(texels.iter().flat_map(color).collect())
}

/// The chunk `IEND` is the end of the file.
fn nothing_after(bytes: &[u8]) -> Result<(), String> {
    let mut rest = &bytes[8..];
    while let [a, b, c, d, chunk @ ..] = rest {
        let length = u32::from_be_bytes([*a, *b, *c, *d]) as usize;
        let is_last = chunk.starts_with(b"IEND");
        rest = chunk.get(length + 8..).unwrap_or_default();
        if is_last {
            return match rest.len() {
                0 => Ok(()),
                more => Err(format!("{more} bytes follow its end")),
            };
        }
    }
    Err("it has no end".to_owned())
}
