//! The Rust libraries as plane codecs, with the protocol of worker.py: `worker NAME`.

use std::io::{BufRead, Cursor, Read, Write};
use zune_core::{bytestream::ZCursor, colorspace::ColorSpace, options::DecoderOptions};

type Image = (usize, usize, usize, Vec<u8>);
type Failure = Box<dyn std::error::Error>;

fn zune(stream: &[u8], options: DecoderOptions) -> Result<Image, Failure> {
    let mut decoder = zune_jpeg::JpegDecoder::new_with_options(ZCursor::new(stream), options);
    let samples = decoder.decode().map_err(|problem| format!("{problem:?}"))?;
    let info = decoder.info().ok_or("no frame")?;
    let (width, height) = (info.width.into(), info.height.into());
    Ok((width, height, samples.len() / (width * height), samples))
}

fn jpeg_decoder(stream: &[u8]) -> Result<Image, Failure> {
    let mut decoder = jpeg_decoder::Decoder::new(stream);
    let samples = decoder.decode()?;
    let info = decoder.info().ok_or("no frame")?;
    let (width, height) = (info.width.into(), info.height.into());
    Ok((width, height, samples.len() / (width * height), samples))
}

fn image(stream: &[u8]) -> Result<Image, Failure> {
    let image = image::ImageReader::with_format(Cursor::new(stream), image::ImageFormat::Jpeg).decode()?;
    let (width, height, channels) = (image.width(), image.height(), image.color().channel_count());
    Ok((width as usize, height as usize, channels.into(), image.into_bytes()))
}

fn zenjpeg(stream: &[u8]) -> Result<Image, Failure> {
    let decoder = zenjpeg::decoder::Decoder::new().output_format(zenjpeg::decoder::PixelFormat::Gray);
    let image = decoder.auto_orient(false).decode(stream, enough::Unstoppable)?;
    let (width, height) = image.dimensions();
    let samples = image.pixels_u8().ok_or("no bytes")?.to_vec();
    Ok((width as usize, height as usize, samples.len() / (width * height) as usize, samples))
}

fn decode(name: &str, stream: &[u8]) -> Result<Image, Failure> {
    match name {
        "zune-jpeg" => zune(stream, DecoderOptions::default()),
        "zune-jpeg-luma" => {
            let options = DecoderOptions::default().jpeg_set_out_colorspace(ColorSpace::Luma);
            zune(stream, options.set_max_width(65535).set_max_height(65535))
        }
        "jpeg-decoder" => jpeg_decoder(stream),
        "image" => image(stream),
        "zenjpeg" => zenjpeg(stream),
        _ => Err("no decoder".into()),
    }
}

fn encode(name: &str, samples: &[u8], width: u16, height: u16, quality: u8) -> Result<Vec<u8>, Failure> {
    let mut out = Vec::new();
    if name == "image" {
        let mut encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut out, quality);
        encoder.encode(samples, width.into(), height.into(), image::ExtendedColorType::L8)?;
    } else if name == "jpeg-encoder" {
        jpeg_encoder::Encoder::new(&mut out, quality).encode(samples, width, height, jpeg_encoder::ColorType::Luma)?;
    } else if name == "mozjpeg-rs" {
        out = mozjpeg_rs::Encoder::baseline_optimized().quality(quality).encode_gray(samples, width.into(), height.into())?;
    } else if name == "zenjpeg" {
        let config = zenjpeg::encoder::EncoderConfig::grayscale(quality).progressive(false);
        let mut encoder = config.encode_from_bytes(width.into(), height.into(), zenjpeg::encoder::PixelLayout::Gray8Srgb)?;
        encoder.push_packed(samples, enough::Unstoppable)?;
        out = encoder.finish()?;
    } else {
        return Err("no encoder".into());
    }
    Ok(out)
}

fn main() {
    let name = std::env::args().nth(1).expect("a name");
    std::panic::set_hook(Box::new(|_| ()));
    let (mut input, mut output) = (std::io::stdin().lock(), std::io::stdout().lock());
    let mut line = String::new();
    while input.read_line(&mut line).expect("standard input") > 0 {
        let words: Vec<String> = line.split_whitespace().map(String::from).collect();
        let number = |at: usize| words[at].parse::<usize>().expect("a number");
        let mut body = vec![0; number(words.len() - 1)];
        input.read_exact(&mut body).expect("a body");
        let answer = std::panic::catch_unwind(|| match words[0].as_str() {
            "decode" => decode(&name, &body),
            _ => encode(&name, &body, number(1) as u16, number(2) as u16, number(3) as u8).map(|out| (0, 0, 0, out)),
        });
        match answer {
            Ok(Ok((width, height, channels, result))) => {
                writeln!(output, "ok {width} {height} {channels} {}", result.len()).and_then(|()| output.write_all(&result))
            }
            Ok(Err(problem)) => writeln!(output, "error {}", problem.to_string().replace('\n', " ")),
            Err(_) => writeln!(output, "error panic"),
        }
        .and_then(|()| output.flush())
        .expect("standard output");
        line.clear();
    }
}
