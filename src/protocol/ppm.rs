//! Portable pixmaps: `P6`, the width, the height and 255 in ASCII, one white space, then red, green and blue of each texel.

use crate::protocol::frame::{Frame, Samples};

/// Whether `bytes` begin as a file of the Netpbm family does.
pub(crate) fn is_netpbm(bytes: &[u8]) -> bool {
    matches!(bytes, [b'P', b'1'..=b'7', next, ..] if next.is_ascii_whitespace() || *next == b'#')
}

/// Reads a whole file that [`is_netpbm`].
pub(crate) fn read(bytes: &[u8]) -> Result<Frame, String> {
    if bytes[1] != b'6' {
        return Err(format!(
            "its kind is P{}; the kind that is read is P6, three bytes a texel",
            bytes[1] as char
        ));
    }
    let mut rest = &bytes[2..];
    let width = number(&mut rest, "width")?;
    let height = number(&mut rest, "height")?;
    let largest = number(&mut rest, "largest value")?;
    if largest != 255 {
        return Err(format!("its largest value is {largest}, not 255"));
    }
    // One white space and no more: the next byte is a sample, whatever it looks like.
    let [space, samples @ ..] = rest else {
        return Err("it ends with its header".to_owned());
    };
    if !space.is_ascii_whitespace() {
        return Err("no white space follows its largest value".to_owned());
    }
    let needed = u128::from(width) * u128::from(height) * 3;
    if needed != samples.len() as u128 {
        return Err(format!(
            "{width} x {height} texels need {needed} bytes, {} follow",
            samples.len()
        ));
    }
    Ok(Frame {
        view: "rgb",
        width,
        height,
        channels: 3,
        samples: Samples::U8(samples.to_vec()),
    })
}

/// The next number of the header. White space stands before it, and comments from `#` to the end of their line.
fn number(rest: &mut &[u8], name: &str) -> Result<u32, String> {
    let before = rest.len();
    loop {
        match rest {
            [b'#', ..] => {
                let end = rest.iter().position(|&byte| byte == b'\n' || byte == b'\r');
                *rest = &rest[end.unwrap_or(rest.len())..];
            }
            [space, after @ ..] if space.is_ascii_whitespace() => *rest = after,
            _ => break,
        }
    }
    let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let (word, after) = rest.split_at(digits);
    let value = std::str::from_utf8(word)
        .ok()
        .and_then(|word| word.parse().ok());
    let separated = before > word.len() + after.len();
    *rest = after;
    value
        .filter(|_| separated)
        .ok_or_else(|| format!("its {name} is no number"))
}
