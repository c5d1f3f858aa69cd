//! What is wrong with an answer: the mistakes of wrappers, each undone, until the picture is right.

use crate::harness::compare::{Expected, ExpectedValues};
use crate::harness::frames;
use crate::harness::probe::Sample;
use crate::harness::protocol::{Answer, Frame, Samples, View};
use crate::harness::run::Reply;

/// One mistake: what is found, and what to do.
#[derive(Clone, Debug)]
struct Mistake {
    says: String,
    next: &'static str,
}

fn mistake(says: impl Into<String>, next: &'static str) -> Mistake {
    Mistake {
        says: says.into(),
        next,
    }
}

/// The mistakes that, undone, leave the right picture.
pub(super) struct Trouble(Vec<Mistake>);

impl Trouble {
    pub(super) fn says(&self) -> String {
        let says: Vec<&str> = self.0.iter().map(|mistake| mistake.says.as_str()).collect();
        says.join("; and ")
    }

    pub(super) fn next(&self) -> String {
        let next: Vec<&str> = self.0.iter().map(|mistake| mistake.next).collect();
        next.join("\n")
    }
}

/// The fewest mistakes that, undone, make `bytes` the right answer; nothing if there are no such.
pub(super) fn repair(bytes: &[u8], sample: &Sample, view: &View) -> Option<Trouble> {
    let expected = sample.expected(view);
    let mut best: Option<Vec<Mistake>> = None;
    for (bytes, mistakes) in streams(bytes) {
        let Some((shape, values)) = body(&bytes, &expected, view) else {
            continue;
        };
        for (values, said) in values {
            for (values, arranged) in arrangements(&values, &expected) {
                let all: Vec<Mistake> = [&mistakes[..], &shape, &said, &arranged].concat();
                let fewer = best.as_ref().is_none_or(|best| all.len() < best.len());
                if fewer && !all.is_empty() && is_right(&values, &expected) {
                    best = Some(all);
                }
            }
        }
    }
    best.map(Trouble)
}

/// The bytes as they are, and without what text mode, encodings and loose words do to them.
fn streams(bytes: &[u8]) -> Vec<(Vec<u8>, Vec<Mistake>)> {
    let mut streams = vec![(bytes.to_vec(), Vec::new())];
    let utf16 = bytes.strip_prefix(b"\xff\xfe");
    if let Some(pairs) = utf16 {
        let units: Vec<u16> = pairs
            .as_chunks::<2>()
            .0
            .iter()
            .copied()
            .map(u16::from_le_bytes)
            .collect();
        let narrow = units.iter().map(|&unit| unit as u8).collect();
        streams.push((
            narrow,
            vec![mistake(
                "its output is text in UTF-16, as PowerShell writes it",
                "write bytes; do not send them through PowerShell's > or |",
            )],
        ));
    }
    if let Ok(text) = std::str::from_utf8(bytes)
        && !bytes.is_ascii()
        && text.chars().all(|c| u32::from(c) < 256)
    {
        let narrow = text.chars().map(|c| u32::from(c) as u8).collect();
        streams.push((
            narrow,
            vec![mistake(
                "its samples are printed as text: every byte from 128 on has become two (UTF-8)",
                "write bytes, not characters: in Python sys.stdout.buffer, in Java System.out.write, in Node a Buffer",
            )],
        ));
    }
    streams.extend(line_ends(bytes));
    let loose = streams.iter().filter_map(|(bytes, mistakes)| {
        let begin = bytes
            .windows(5)
            .position(|word| word == b"PTM1 ")
            .filter(|&begin| begin > 0)?;
        let shown = bytes[..begin.min(60)].escape_ascii();
        let mut mistakes = mistakes.clone();
        mistakes.push(mistake(
            format!("it prints text before the frame: \"{shown}\""),
            "print messages to standard error; the frame is all that standard output has",
        ));
        Some((bytes[begin..].to_vec(), mistakes))
    });
    let loose: Vec<_> = loose.collect();
    streams.extend(loose);
    streams
}

/// The bytes without the carriage returns that text mode puts before line feeds: all of them, those of the first line, or
/// those behind it.
fn line_ends(bytes: &[u8]) -> Vec<(Vec<u8>, Vec<Mistake>)> {
    let next = "set standard output to binary mode and end the line with a line feed alone: in C on Windows \
                _setmode(_fileno(stdout), _O_BINARY), in Python sys.stdout.buffer, in Perl binmode STDOUT";
    let Some(end) = bytes.iter().position(|&byte| byte == b'\n') else {
        return Vec::new();
    };
    let (line, samples) = bytes.split_at(end + 1);
    let (mended_line, mended) = (
        without_carriage_returns(line),
        without_carriage_returns(samples),
    );
    let candidates = [
        (
            [&mended_line[..], samples].concat(),
            mended_line != line,
            "its first line ends in CR LF",
        ),
        (
            [line, &mended].concat(),
            mended != samples,
            "every line feed among the samples has become CR LF: text mode",
        ),
        (
            [mended_line.clone(), mended.clone()].concat(),
            mended_line != line && mended != samples,
            "CR LF ends its first line, and every line feed among the samples has become CR LF: text mode",
        ),
    ];
    candidates
        .into_iter()
        .filter(|(_, changed, _)| *changed)
        .map(|(bytes, _, says)| (bytes, vec![mistake(says, next)]))
        .collect()
}

fn without_carriage_returns(bytes: &[u8]) -> Vec<u8> {
    let mut kept = Vec::with_capacity(bytes.len());
    for (i, &byte) in bytes.iter().enumerate() {
        if byte != b'\r' || bytes.get(i + 1) != Some(&b'\n') {
            kept.push(byte);
        }
    }
    kept
}

/// Numbers, and what had to be undone to read them.
type Readings = Vec<(Vec<f64>, Vec<Mistake>)>;

/// What the first line says wrongly, and the samples in every way in which they may be meant.
fn body(bytes: &[u8], expected: &Expected, view: &View) -> Option<(Vec<Mistake>, Readings)> {
    if let Ok(frame) = frames::read(bytes, view, bytes.len().max(1 << 16)) {
        let values = match &frame.samples {
            Samples::U8(values) => values.iter().map(|&value| f64::from(value)).collect(),
            Samples::F32(values) => values.iter().map(|&value| f64::from(value)).collect(),
        };
        let kind = if matches!(frame.samples, Samples::U8(_)) {
            "u8"
        } else {
            "f32"
        };
        // A frame may be well-formed and its samples still be bytes of something else.
        let mut readings = numbers(&bytes_of(&frame.samples), expected);
        if kind == kind_of(expected) {
            readings.push((values, Vec::new()));
        }
        let line = line_mistakes(
            frame.view,
            (frame.width, frame.height, frame.channels),
            kind,
            expected,
        );
        return Some((line, readings));
    }
    let end = bytes.iter().position(|&byte| byte == b'\n')?;
    let line = std::str::from_utf8(&bytes[..end]).ok()?;
    if line.ends_with('\r') {
        return None;
    }
    let words: Vec<&str> = line.split_whitespace().collect();
    let ["PTM1", name, width, height, channels, kind] = words[..] else {
        return None;
    };
    let shape = (
        width.parse().ok()?,
        height.parse().ok()?,
        channels.parse().ok()?,
    );
    let mut mistakes = line_mistakes(name, shape, kind, expected);
    if line != words.join(" ") {
        mistakes.push(mistake(
            "the words of its first line are not parted by single spaces",
            "write \"PTM1 VIEW WIDTH HEIGHT CHANNELS TYPE\" with one space between two words, and no other",
        ));
    }
    Some((mistakes, numbers(&bytes[end + 1..], expected)))
}

fn bytes_of(samples: &Samples) -> Vec<u8> {
    match samples {
        Samples::U8(values) => values.clone(),
        Samples::F32(values) => values
            .iter()
            .flat_map(|value| value.to_le_bytes())
            .collect(),
    }
}

/// The type of samples that is expected.
fn kind_of(expected: &Expected) -> &'static str {
    match expected.values {
        ExpectedValues::Coef(_) => "f32",
        ExpectedValues::Raw(_) | ExpectedValues::Rgb(_) => "u8",
    }
}

/// What the words of the first line say wrongly.
fn line_mistakes(
    name: &str,
    shape: (u32, u32, u32),
    kind: &str,
    expected: &Expected,
) -> Vec<Mistake> {
    let wanted = match expected.values {
        ExpectedValues::Raw(_) => "raw",
        ExpectedValues::Coef(_) => "coef",
        ExpectedValues::Rgb(_) => "rgb",
    };
    let wanted_kind = kind_of(expected);
    let (width, height) = (expected.size.width, expected.size.height);
    let mut mistakes = Vec::new();
    if name.starts_with("rgb:") && wanted == "rgb" {
        mistakes.push(mistake(
            format!("its first line says {name:?}"),
            "the line has rgb alone, without the light",
        ));
    } else if name != wanted {
        mistakes.push(mistake(
            format!("its first line says {name:?} where {wanted} is asked for"),
            "the line names the view that was asked for: raw, coef or rgb",
        ));
    }
    if (shape.0, shape.1) == (height, width) && width != height {
        mistakes.push(mistake(
            "its first line has height and width exchanged",
            "the width stands before the height",
        ));
    } else if (shape.0, shape.1) != (width, height) {
        mistakes.push(mistake(
            format!(
                "its first line says {} x {} where the file is {width} x {height}",
                shape.0, shape.1
            ),
            "width and height are those of the file",
        ));
    }
    if shape.2 != expected.channels as u32 {
        mistakes.push(mistake(
            format!(
                "its first line says {} channels instead of {}",
                shape.2, expected.channels
            ),
            "channels: 18 for RGB, 9 for LRGB and tables, 8 for LUM; 3 for rgb",
        ));
    }
    if kind != wanted_kind {
        mistakes.push(mistake(
            format!("its first line says the type is {kind} instead of {wanted_kind}"),
            "types: u8 for raw and rgb, f32 for coef",
        ));
    }
    mistakes
}

/// The numbers that the bytes of the samples may mean.
fn numbers(bytes: &[u8], expected: &Expected) -> Readings {
    let texels = expected.size.texels();
    let count = texels * expected.channels;
    let is_real = matches!(expected.values, ExpectedValues::Coef(_));
    let width = if is_real { 4 } else { 1 };
    let mut readings = Readings::new();
    let mut add = |values: Vec<f64>, mistakes: Vec<Mistake>| readings.push((values, mistakes));
    let plain = |bytes: &[u8]| -> Vec<f64> {
        if is_real {
            reals4(bytes, f32::from_le_bytes)
        } else {
            bytes.iter().map(|&byte| f64::from(byte)).collect()
        }
    };
    let f32_low = "samples are 4-byte floats, low byte first: '<f4' in NumPy, \"<f\" in Python's struct, LITTLE_ENDIAN in Java";
    if bytes.len() == count * width {
        add(plain(bytes), Vec::new());
    }
    if (count * width + 1..=count * width + 2).contains(&bytes.len()) {
        let (samples, rest) = bytes.split_at(count * width);
        let says = format!("it prints \"{}\" behind the samples", rest.escape_ascii());
        add(
            plain(samples),
            vec![mistake(
                says,
                "print nothing behind the samples: write, not println or puts",
            )],
        );
    }
    if bytes.len() == count * 4 {
        if is_real {
            add(
                reals4(bytes, f32::from_be_bytes),
                vec![mistake("its f32 have the high byte first", f32_low)],
            );
        } else {
            for (read, order) in [
                (f32::from_le_bytes as fn([u8; 4]) -> f32, "low"),
                (f32::from_be_bytes, "high"),
            ] {
                let says =
                    format!("its samples are f32, {order} byte first, where u8 is asked for");
                let values = reals4(bytes, read);
                let full = values.iter().map(|value| (value * 255.0).round()).collect();
                let next = "one byte for each sample, from 0 to 255";
                add(
                    values.iter().map(|value| value.round()).collect(),
                    vec![mistake(&*says, next)],
                );
                add(full, vec![mistake(format!("{says}, from 0 to 1"), next)]);
            }
        }
    }
    if bytes.len() == count * 8 {
        for (read, order) in [
            (f64::from_le_bytes as fn([u8; 8]) -> f64, "low"),
            (f64::from_be_bytes, "high"),
        ] {
            let values: Vec<f64> = bytes
                .as_chunks::<8>()
                .0
                .iter()
                .map(|&chunk| read(chunk))
                .collect();
            let says = format!("its samples are f64, {order} byte first");
            let values = if is_real {
                values
            } else {
                values.iter().map(|value| value.round()).collect()
            };
            add(values, vec![mistake(says, f32_low)]);
        }
    }
    if !is_real && expected.channels == 3 && bytes.len() == texels * 4 {
        for (skipped, name) in [(3, "last"), (0, "first")] {
            let kept = bytes.iter().enumerate().filter(|(i, _)| i % 4 != skipped);
            let says = format!("its texels have four samples; the {name} is no color (alpha?)");
            add(
                kept.map(|(_, &byte)| f64::from(byte)).collect(),
                vec![mistake(says, "three samples a texel: red, green, blue")],
            );
        }
    }
    if let Ok(text) = std::str::from_utf8(bytes) {
        let values: Result<Vec<f64>, _> = text
            .split(|c: char| c.is_whitespace() || c == ',')
            .filter(|word| !word.is_empty())
            .map(str::parse)
            .collect();
        if let Ok(values) = values {
            add(
                values,
                vec![mistake(
                    "its samples are numbers in ASCII",
                    "write samples as bytes",
                )],
            );
        }
    }
    readings
}

fn reals4(bytes: &[u8], read: fn([u8; 4]) -> f32) -> Vec<f64> {
    let chunks = bytes.as_chunks::<4>().0.iter();
    chunks.map(|&chunk| f64::from(read(chunk))).collect()
}

/// Where the sample of (x, y, channel) stands in a raster of (width, height, channels).
type Place = fn((usize, usize, usize), (usize, usize, usize)) -> usize;

/// The same values in every order in which they may stand.
fn arrangements(values: &[f64], expected: &Expected) -> Readings {
    let (width, height) = (expected.size.width as usize, expected.size.height as usize);
    let channels = expected.channels;
    if values.len() != width * height * channels {
        return Readings::new();
    }
    // Where the sample of (x, y, channel) stands in a raster of (width, height, channels).
    let layouts: [(Option<&str>, Place); 4] = [
        (None, |(x, y, c), (w, _, n)| (y * w + x) * n + c),
        (
            Some("its channels stand one behind the other as whole planes"),
            |(x, y, c), (w, h, _)| (c * h + y) * w + x,
        ),
        (
            Some("its channels stand one behind the other within each row"),
            |(x, y, c), (w, _, n)| (y * n + c) * w + x,
        ),
        (
            Some("its texels run column by column"),
            |(x, y, c), (_, h, n)| (x * h + y) * n + c,
        ),
    ];
    let mut readings = Readings::new();
    for (layout, place) in layouts {
        for (order, permuted) in channel_orders(channels) {
            for (upside_down, mirrored) in
                [(false, false), (true, false), (false, true), (true, true)]
            {
                let mut mistakes = Vec::new();
                if let Some(says) = layout {
                    mistakes.push(mistake(
                        says,
                        "texel after texel, all channels of a texel side by side: array index [y][x][channel]",
                    ));
                }
                if let Some(says) = order {
                    mistakes.push(mistake(
                        says,
                        "channels in the order of the text: r a0…a5, g a0…a5, b a0…a5; a0…a5, R, G, B; a0…a5, Cr, Cb; red, green, blue",
                    ));
                }
                if upside_down {
                    mistakes.push(mistake(
                        "its rows stand upside down",
                        "files store the bottom row first; frames have the top row first",
                    ));
                }
                if mirrored {
                    mistakes.push(mistake(
                        "its rows run from right to left",
                        "texels run from left to right, as they are stored",
                    ));
                }
                let mut ordered = Vec::with_capacity(values.len());
                for y in 0..height {
                    for x in 0..width {
                        for &c in &permuted {
                            let y = if upside_down { height - 1 - y } else { y };
                            let x = if mirrored { width - 1 - x } else { x };
                            ordered.push(values[place((x, y, c), (width, height, channels))]);
                        }
                    }
                }
                readings.push((ordered, mistakes));
            }
        }
    }
    readings
}

/// Orders in which channels are known to come: what to say, and for each right channel where it stands.
fn channel_orders(channels: usize) -> Vec<(Option<&'static str>, Vec<usize>)> {
    let mut orders = vec![(None, (0..channels).collect::<Vec<usize>>())];
    let mut add = |says, order: Vec<usize>| orders.push((Some(says), order));
    match channels {
        3 => add("red and blue are exchanged (BGR)", vec![2, 1, 0]),
        8 => {
            add("Cb stands before Cr", vec![0, 1, 2, 3, 4, 5, 7, 6]);
            add(
                "Cr and Cb stand before the coefficients",
                vec![2, 3, 4, 5, 6, 7, 0, 1],
            );
        }
        9 => {
            add(
                "red and blue are exchanged (BGR)",
                vec![0, 1, 2, 3, 4, 5, 8, 7, 6],
            );
            add(
                "the color stands before the coefficients",
                vec![3, 4, 5, 6, 7, 8, 0, 1, 2],
            );
            add(
                "the coefficients run from a5 to a0",
                vec![5, 4, 3, 2, 1, 0, 6, 7, 8],
            );
        }
        18 => {
            let at = |place: fn(usize, usize) -> usize| {
                (0..3)
                    .flat_map(|color| (0..6).map(move |a| place(color, a)))
                    .collect::<Vec<_>>()
            };
            add(
                "red and blue are exchanged (BGR)",
                at(|color, a| (2 - color) * 6 + a),
            );
            add(
                "the three colors of a coefficient stand together",
                at(|color, a| a * 3 + color),
            );
            add(
                "the coefficients run from a5 to a0",
                at(|color, a| color * 6 + 5 - a),
            );
        }
        _ => {}
    }
    orders
}

fn is_right(values: &[f64], expected: &Expected) -> bool {
    let (view, samples) = match expected.values {
        ExpectedValues::Coef(_) => (
            "coef",
            Samples::F32(values.iter().map(|&value| value as f32).collect()),
        ),
        ExpectedValues::Raw(_) => ("raw", Samples::U8(to_bytes(values))),
        ExpectedValues::Rgb(_) => ("rgb", Samples::U8(to_bytes(values))),
    };
    let frame = Frame {
        view,
        width: expected.size.width,
        height: expected.size.height,
        channels: expected.channels as u32,
        samples,
    };
    expected.compare(&frame).is_none()
}

fn to_bytes(values: &[f64]) -> Vec<u8> {
    values
        .iter()
        .map(|value| value.clamp(0.0, 255.0) as u8)
        .collect()
}

/// An answer in a few words.
pub(super) fn briefly(answer: &Answer) -> String {
    match answer.misconduct() {
        Some(what) => format!("{}: {what}", answer.name()),
        None => answer.name().to_owned(),
    }
}

/// An answer that is no frame, and what to do about it.
pub(super) fn explain(reply: &Reply) -> (String, String) {
    let last = reply.stderr.lines().last();
    let stderr = last.map_or(String::new(), |line| {
        format!("\nits standard error ends: {line}")
    });
    let next = match &reply.answer {
        Answer::ProtocolError(_) => return protocol_error(reply),
        Answer::Crashed(_) => match reply.exit {
            Some(64 | 2) => {
                "it seems to find its arguments wrong: it is called as DECODER VIEW FILE, VIEW being raw, coef or rgb:LU,LV"
            }
            Some(_) => {
                "mend what its standard error says; a status other than 0, 65 and 69 counts as a crash"
            }
            None => "it was killed by a signal: run it by hand, in a debugger or with a sanitizer",
        },
        Answer::Hung(_) => {
            "let it end after the frame: no window, no prompt, nothing read from standard input, which is empty"
        }
        Answer::Rejected => "this is an ordinary file: mend what its standard error says",
        Answer::Unsupported => "answer 69 to what it lacks only",
        Answer::Flooded(_) => "print one frame and nothing else",
        Answer::OutOfMemory(_) => "allocate by the sizes in the file, or allow more by --memory",
        Answer::Tampered(_) => "open the file for reading only",
        Answer::NotStarted(_) | Answer::Decoded(_) => "run it by hand",
    };
    (
        format!("{}{stderr}", briefly(&reply.answer)),
        next.to_owned(),
    )
}

fn protocol_error(reply: &Reply) -> (String, String) {
    let says = briefly(&reply.answer);
    let size = reply.stdout.len();
    if size == 0 {
        let next = if reply.stderr.contains("PTM1 ") {
            "it prints the frame on standard error; print it on standard output"
        } else {
            "print the frame on standard output, and flush it before the end"
        };
        return (says, next.to_owned());
    }
    if let Some(step) = [65_536, 4096]
        .into_iter()
        .find(|&step| reply.stdout.starts_with(b"PTM1 ") && size.is_multiple_of(step))
    {
        return (
            format!("its output ends after {size} bytes, a multiple of {step}: it ends before all is written\n{says}"),
            "flush standard output before the end. In Node do not call process.exit() after write(): set process.exitCode; \
             in C return from main or fflush(stdout), no _exit(); in Python sys.stdout.buffer.flush(), no os._exit()"
                .to_owned(),
        );
    }
    let next = if reply.stdout.starts_with(b"PTM1 ") {
        "write exactly as many bytes as the line announces: WIDTH · HEIGHT · CHANNELS, four times that for f32"
    } else {
        "begin with \"PTM1 VIEW WIDTH HEIGHT CHANNELS TYPE\" and a line feed; the samples follow directly"
    };
    (says, next.to_owned())
}

/// What it means that a malformed file was not refused.
pub(super) fn not_refused(answer: &Answer, reply: &Reply) -> (String, String) {
    let last = reply.stderr.lines().last();
    let stderr = last.map_or(String::new(), |line| {
        format!("\nits standard error ends: {line}")
    });
    match (answer, reply.exit) {
        (Answer::Decoded(_), _) => (
            "it prints a frame all the same".to_owned(),
            "compare sizes with what is there before reading, and exit with 65".to_owned(),
        ),
        (Answer::Unsupported, _) => (
            "answered 69 (unsupported) instead of 65".to_owned(),
            "69 is for sound files that it does not read; a malformed file is 65".to_owned(),
        ),
        (Answer::ProtocolError(what), _) => (
            format!("it exits with 0 and prints no frame: {what}"),
            "exit with 65 where the file is malformed".to_owned(),
        ),
        (Answer::Crashed(_), Some(status)) => (
            format!("exit status {status} counts as a crash, not as a refusal{stderr}"),
            format!(
                "catch the error and exit with 65; if that cannot be changed, say check --reject-exit {status}, \
                 which marks such refusals weak"
            ),
        ),
        _ => explain(reply),
    }
}
