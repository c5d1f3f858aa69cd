//! A minimal PTM decoder for ptm-conform: ./decoder VIEW FILE, or ./decoder serve. To build: `rustc -O decoder.rs`.
use std::io::{self, BufRead, Write};

/// Returns the next word and its separator: spaces, or a line feed with at most one space before it.
fn word<'a>(rest: &mut &'a [u8]) -> Option<(&'a str, &'a [u8])> {
    let (word, after) = rest.split_at(rest.iter().position(|byte| b" \n".contains(byte))?);
    let spaces = after.iter().take_while(|byte| **byte == b' ').count();
    let length = spaces + usize::from(after.get(spaces) == Some(&b'\n') && spaces < 2);
    *rest = &after[length..];
    Some((std::str::from_utf8(word).ok()?, &after[..length]))
}

/// To do: return width, height, channels, "u8" or "f32", and the samples, texel by texel, top row first.
/// The error is an exit status: 65 for malformed files, 69 for unsupported files or views.
/// This example decodes the stored values of PTM_FORMAT_LRGB: all polynomials, then all colors, bottom row first.
fn decode(view: &str, file: &[u8]) -> Result<(usize, usize, usize, &'static str, Vec<u8>), u8> {
    let (mut rest, mut words) = (file, Vec::new());
    for i in 0..16 {
        let (word, separator) = word(&mut rest).ok_or(65)?;
        let (may_end, must_end) = ([0, 1, 2, 3, 9, 15].contains(&i), [0, 1, 3, 15].contains(&i));
        if i == 1 && (view != "raw" || word.starts_with("PTM_FORMAT_") && word != "PTM_FORMAT_LRGB") { return Err(69); }
        if separator.ends_with(b"\n") && !may_end || !separator.ends_with(b"\n") && must_end { return Err(65); }
        words.push(word);
    }
    let digits = |word: &str| !word.is_empty() && word.bytes().all(|byte| byte.is_ascii_digit());
    let is_scale = |word: &&str| word.parse::<f64>().is_ok_and(f64::is_finite);
    let is_bias = |word: &&str| digits(word.strip_prefix(['+', '-']).unwrap_or(word)) && is_scale(&word);
    let size = |word: &str| word.parse().ok().filter(|&size: &usize| digits(word) && size > 0).ok_or(65);
    let (width, height) = (size(words[2])?, size(words[3])?);
    let count = width.checked_mul(height).filter(|&count| rest.len() / 9 >= count).ok_or(65)?;
    let are_numbers = words[4..10].iter().all(is_scale) && words[10..].iter().all(is_bias);
    if words[..2] != ["PTM_1.2", "PTM_FORMAT_LRGB"] || !are_numbers { return Err(65); }
    let texel = |i: usize| [&rest[6 * i..6 * i + 6], &rest[6 * count + 3 * i..][..3]].concat();
    let rows = (0..height).rev().map(|y| (y * width..(y + 1) * width).flat_map(texel));
    Ok((width, height, 9, "u8", rows.flatten().collect()))
}

fn frame(view: &str, path: &str) -> Result<Vec<u8>, u8> {
    let (width, height, channels, kind, samples) = decode(view, &std::fs::read(path).map_err(|_| 2)?)?;
    let line = format!("PTM1 {} {width} {height} {channels} {kind}\n", view.split(':').next().unwrap_or(view));
    Ok([line.into_bytes(), samples].concat())
}

fn main() -> io::Result<()> {
    let (words, mut out): (Vec<String>, _) = (std::env::args().collect(), io::stdout());
    match words[1].as_str() {
        "capabilities" => print!("protocol: 1\nname: my-decoder\nmodes: [one-shot, serve]\npipelined: true\n"),
        "serve" => for request in io::stdin().lock().lines().map_while(Result::ok) {
            let request: Vec<&str> = request.splitn(3, ' ').collect();
            match frame(request[1], request[2]) {
                Ok(frame) => out.write_all(&[format!("{} ok {}\n", request[0], frame.len()).as_bytes(), &frame].concat())?,
                Err(65) => writeln!(out, "{} reject 65", request[0])?,
                Err(_) => writeln!(out, "{} unsupported", request[0])?,
            }
            out.flush()?;
        },
        view => out.write_all(&frame(view, &words[2]).unwrap_or_else(|status| std::process::exit(status.into())))?,
    }
    Ok(())
}
