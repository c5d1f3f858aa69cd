//! Evidence for a failing case: texel values, images, bytes of the file, and a preview.

use std::collections::HashMap;
use std::ops::Range;

use data_encoding::BASE64;
use maud::{Markup, html};

use crate::report::html::figures::{self, Position};
use crate::report::html::preview;
use ptm::decode::decode;
use ptm::{Shape, channel_name};
use ptm_harness::diagnose::arithmetic_steps;
use ptm_harness::session::lit_scene::LitScene;
use ptm_harness::session::run::Run;
use ptm_harness::session::texture::TextureObservation;
use ptm_suite::cases::{Built, Case, Suite, TableSpelling};
use ptm_suite::compare::{Difference, Expected};
use ptm_suite::dialect::RightDialects;
use ptm_suite::origin::{Origin, origin_of_samples, origin_of_scale_and_bias};
use ptm_suite::protocol::frame::{Frame, View, ViewKind};
use ptm_suite::test_case::Listed;
use ptm_suite::texture::cases::TextureCase;
use ptm_suite::verdicts::observation::{Observation, ObservationOf, Response};
use ptm_writers::test_case::{ComparedFrames, FileCase, RequestValues, wrong_file};

/// What a page shows of a run, in addition to the report.
pub struct Evidence<'a> {
    /// Renders the evidence for the case with this id, if it was observed.
    pub of_case: Box<dyn Fn(&str) -> Option<Markup> + 'a>,
    /// The scene at the top of the page.
    pub scene: Option<&'a LitScene>,
}

impl<'a> Evidence<'a> {
    /// Creates the evidence of a run. `render` renders the evidence for a case.
    pub fn new<C: Listed, V, T, D, F>(
        suite: &'a Suite<C>,
        run: &'a Run<V, T, D, F>,
        render: fn(&C, TableSpelling, &Observation<V, T, D>) -> Markup,
    ) -> Evidence<'a> {
        let cases = suite.cases.iter().zip(&run.observations);
        let observed: HashMap<&str, _> = cases
            .map(|(case, seen)| (case.id(), (case, seen)))
            .collect();
        let of_case = move |id: &str| {
            let (case, observation) = observed.get(id)?;
            Some(render(case, run.table, observation.as_ref()?))
        };
        Evidence {
            of_case: Box::new(of_case),
            scene: None,
        }
    }
}

/// Renders the evidence for a PTM file.
#[must_use]
pub fn case_evidence(case: &Case, table: TableSpelling, observed: &Observation) -> Markup {
    let built = case.build(table);
    let shown = match &observed.response {
        Response::Image {
            difference: Some(difference),
            frame: Some(frame),
            ..
        } => render_image(case, &built, &observed.view, difference, frame),
        Response::Image { .. } => accepted_file_evidence(&built),
        _ => render_file_beginning(&built),
    };
    html! {
        @if let Response::Image { right: RightDialects::Depends { .. }, .. } = &observed.response {
            p.note { "The specification leaves open how to read this file. Several images are correct; the reference's image is shown." }
        }
        (shown)
        @if !observed.stderr.is_empty() { (standard_error(&observed.stderr)) }
        (download(&format!("{}.ptm", case.id), &built.file))
    }
}

/// Maximum size in bytes of a file that is embedded in a page.
const MAX_DOWNLOAD_BYTES: usize = 4 << 10;

/// Renders a download link for a file, or the size of the file if it is too large to embed.
pub fn download(name: &str, file: &[u8]) -> Markup {
    html! {
        p.download {
            @if file.len() <= MAX_DOWNLOAD_BYTES {
                a download=(name) href={ "data:application/octet-stream;base64," (BASE64.encode(file)) } { "Download " (name) }
                ", " (file.len()) " bytes"
            } @else { (name) " has " (file.len()) " bytes and is too large for this page." }
        }
    }
}

/// Renders the evidence for a texture question, which has no table.
#[must_use]
pub fn question_evidence(
    case: &TextureCase,
    _: TableSpelling,
    observed: &TextureObservation,
) -> Markup {
    let received = match &observed.response {
        Response::Image { frame, .. } => frame.as_ref().unwrap_or(&case.expect).to_string(),
        other => other.name().to_owned(),
    };
    html! {
        @for (name, text) in [("The question", case.question().to_string()), ("Expected", case.expect.to_string()), ("Received", received)] {
            p.label { (name) }
            pre.bytes tabindex="0" { (text) }
        }
        @if !case.relevant_axes().is_empty() {
            p.note { "The chapter leaves open how to answer this question. Several answers are correct; the reference's answer is shown." }
        }
        @if !observed.stderr.is_empty() { (standard_error(&observed.stderr)) }
        (download(&format!("{}.json", case.id), case.question().to_string().as_bytes()))
    }
}

/// Renders the recorded standard error of the decoder, or only the end of it if it is long.
pub fn standard_error(stderr: &str) -> Markup {
    const MAX_CHARS: usize = 700;
    let skipped = stderr.chars().count().saturating_sub(MAX_CHARS);
    let end: String = stderr.chars().skip(skipped).collect();
    html! {
        p.label { "Standard error" @if skipped > 0 { ", the end" } }
        pre.stderr tabindex="0" { (end) }
    }
}

fn render_image(case: &Case, built: &Built, view: &View, at: &Difference, frame: &Frame) -> Markup {
    let expected = Expected::new(&built.values, view);
    let (Some(expected), Difference::Samples { x, y, .. }) = (&expected, at) else {
        return render_file_beginning(built);
    };
    let first = (y * expected.size.width as usize + x) * expected.channels;
    let received = |i: usize| frame.samples.real(i);
    let position = first_wrong_position(expected, frame, (*x, *y));
    let channel = position.2;
    let name = channel_name(expected.channels, channel);
    let ptm = decode(&built.file).ok();
    let texel = first / expected.channels;
    let steps = ptm.and_then(|ptm| arithmetic_steps(&ptm, view, texel, channel));
    html! {
        p.label { "Texel (" (x) ", " (y) ")" }
        div.scroll tabindex="0" { table.texel {
            thead {
                @if expected.channels == 18 {
                    tr { td {} @for of in ["red", "green", "blue"] { th scope="colgroup" colspan="6" { (of) } } }
                }
                tr { td {} @for c in 0..expected.channels {
                    th scope="col" { (channel_name(expected.channels, c).split(' ').next().unwrap_or_default()) }
                } }
            }
            tbody {
                tr { th scope="row" { "expected" } @for c in 0..expected.channels { td { (number(expected.values[first + c])) } } }
                tr { th scope="row" { "received" } @for c in 0..expected.channels {
                    @let value = received(first + c);
                    @if expected.is_near(first + c, value) { td { (number(value)) } } @else { td.wrong { "≠ " (number(value)) } }
                } }
            }
        } }
        @if let Some(steps) = steps {
            p.label { "The arithmetic" }
            p.arithmetic {
                code { (name) " = " (steps) @if let View::Rgb(_) = view { "; clamped to 0…255: " } @else { " = " } (number(expected.values[first + channel])) }
            }
        }
        @if let Some(figure) = figures::figure(expected, frame, position) { (figure) }
        (origins(&name, &built.file, &sample_origins(case, &built.file, expected, position)))
        @if let Some(figure) = preview::figure(built, frame) { (figure) }
    }
}

/// Returns the position of the first wrong sample in a texel.
fn first_wrong_position(expected: &Expected, frame: &Frame, (x, y): (usize, usize)) -> Position {
    let first = (y * expected.size.width as usize + x) * expected.channels;
    let is_wrong = |c: &usize| !expected.is_near(first + c, frame.samples.real(first + c));
    let channel = (0..expected.channels).find(is_wrong);
    (x, y, channel.unwrap_or_default())
}

/// Returns the byte ranges of `file` from which the sample at `position` is computed.
fn sample_origins(case: &Case, file: &[u8], image: &Expected, position: Position) -> Vec<Origin> {
    let (x, y, channel) = position;
    let stored = |channels| origin_of_samples(case.format(), file, image.size, (x, y), channels);
    let shape = decode(file).map(|ptm| ptm.planes.shape);
    match (image.view, shape) {
        (ViewKind::Raw, _) => stored(channel..channel + 1),
        (ViewKind::Coef, Ok(shape)) => {
            let mut origins = stored(channel..channel + 1);
            if channel < shape.coefficients() {
                origins.extend(origin_of_scale_and_bias(file, channel));
            }
            origins
        }
        // A color is computed from whole polynomials.
        (ViewKind::Rgb, Ok(Shape::Rgb)) => stored(6 * channel..6 * channel + 6),
        (ViewKind::Rgb, Ok(Shape::Lrgb)) => {
            [stored(0..6), stored(6 + channel..7 + channel)].concat()
        }
        (ViewKind::Rgb, Ok(Shape::Lum(_))) => stored(0..8),
        _ => Vec::new(),
    }
}

fn origins(name: &str, file: &[u8], origins: &[Origin]) -> Markup {
    html! {
        @if !origins.is_empty() { p.label { "Bytes of " (name) " in this texel" } }
        @for (field, clause, range) in origins {
            p.origin {
                @if range.len() == 1 { "Byte " (range.start) } @else { "Bytes " (range.start) "–" (range.end.max(1) - 1) }
                ": " (field) " " span.clauses { (clause) }
            }
            (excerpt(file, range))
        }
    }
}

/// Renders the evidence for a file that should be refused: the reference's error and the location of the error.
fn accepted_file_evidence(built: &Built) -> Markup {
    match decode(&built.file) {
        Err(error) => html! {
            p.label { "Error of the reference" }
            p.origin { (error) }
            (excerpt(&built.file, &(error.offset()..error.offset() + 1)))
        },
        Ok(_) => render_file_beginning(built),
    }
}

/// Renders the beginning of a file for which the decoder returned no image.
fn render_file_beginning(built: &Built) -> Markup {
    const MAX_BYTES: usize = 320;
    let begins = &built.file[..built.file.len().min(MAX_BYTES)];
    let lines = begins.split_inclusive(|&byte| byte == b'\n');
    let shown = lines.map(|line| line.escape_ascii().to_string().replace("\\n", "↵\n"));
    html! {
        p.label { "The file begins (" (built.file.len()) " bytes in all)" }
        pre.bytes tabindex="0" { (shown.collect::<String>()) }
    }
}

/// Formats a number with up to four decimal places, or in scientific notation if it is very small or large.
pub fn number(value: f64) -> String {
    if value != 0.0 && (value.abs() < 1e-3 || value.abs() >= 1e7) {
        return format!("{value:.4e}");
    }
    let text = format!("{value:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Renders a hex dump of the lines that contain `range`, and highlights the bytes in the range. Only the beginning of a long
/// range is included.
fn excerpt(file: &[u8], range: &Range<usize>) -> Markup {
    let first = range.start / 16 * 16;
    let last = (range.end.max(range.start + 1) - 1).min(range.start + 31) / 16 * 16 + 16;
    html! {
        pre.bytes tabindex="0" {
            @for at in (first..last.min(file.len())).step_by(16) {
                @let end = file.len().min(at + 16);
                @let (from, to) = (range.start.clamp(at, end), range.end.clamp(at, end));
                // Before, inside and after the range.
                @let parts = [(false, at..from), (true, from..to), (false, to..end)].into_iter().filter(|(_, part)| !part.is_empty());
                span.offset { (format!("{at:06x}")) }
                @for (marked, part) in parts.clone() {
                    " "
                    @let hex: Vec<String> = file[part].iter().map(|byte| format!("{byte:02x}")).collect();
                    @if marked { mark { (hex.join(" ")) } } @else { (hex.join(" ")) }
                }
                (" ".repeat(3 * (at + 16 - end) + 2))
                @for (marked, part) in parts {
                    @let text: String = file[part].iter().map(|&byte| if matches!(byte, b' '..=b'~') { char::from(byte) } else { '·' }).collect();
                    @if marked { mark { (text) } } @else { (text) }
                }
                "\n"
            }
            @if range.start >= file.len() { span.offset { "the file ends here" } }
        }
    }
}

/// Renders the images of a written file and of what was requested, unless they are equal.
fn compared_frames(images: &ComparedFrames) -> Markup {
    let expected = Expected::from_frame(&images.expected);
    let Some(Difference::Samples { x, y, .. }) = expected.compare(&images.written) else {
        return Markup::default();
    };
    let position = first_wrong_position(&expected, &images.written, (x, y));
    html! {
        p.label { (images.caption) }
        @if let Some(figure) = figures::figure(&expected, &images.written, position) { (figure) }
    }
}

/// Maximum number of bytes of a wrong file that a page displays.
const MAX_DISPLAYED_BYTES: usize = 512;

/// Renders the evidence for a request, which has no table: the request and the written file.
pub fn file_evidence<V: RequestValues>(
    case: &FileCase<V>,
    _: TableSpelling,
    observation: &ObservationOf<FileCase<V>>,
) -> Markup {
    let file = wrong_file(Some(observation)).map(|(file, _)| file);
    let built = case.values.build(case.format);
    let (caption, text) = V::describe(&built);
    let images = file.and_then(|file| V::images(&built.request, case.format, file));
    html! {
        @if let Some(images) = images { (compared_frames(&images)) }
        p.label { (caption) }
        pre.bytes tabindex="0" { (text) }
        @if let Some(file) = file {
            p.label { "Written file, " (file.len()) " bytes" @if file.len() > MAX_DISPLAYED_BYTES { " (the beginning)" } }
            pre.bytes tabindex="0" { (file[..file.len().min(MAX_DISPLAYED_BYTES)].escape_ascii().to_string().replace("\\n", "\\n\n")) }
            (download(&format!("{}.ptm", case.id), file))
        }
        @if !observation.stderr.is_empty() { (standard_error(&observation.stderr)) }
    }
}
