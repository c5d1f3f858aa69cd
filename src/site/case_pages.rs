//! Pages for cases. Each page shows the file byte by byte, its image, the expected result, and related cases.

use image::RgbaImage;
use maud::{Markup, html};

use super::page::{PageContext, SiteFile};
use super::{gallery, images};
use crate::report::html::number;
use ptm::decode::decode;
use ptm::{Ptm, channel_name};
use ptm_files::inspect::{Inspection, inspect};
use ptm_files::lint::lint;
use ptm_files::render::render_lit;
use ptm_suite::cases::{Built, Case, Expect, TableSpelling};
use ptm_suite::compare::{Expected, tolerance_text};
use ptm_suite::protocol::frame::{Light, View};

/// Maximum size in bytes of a file on the site. Larger files can be generated with the program.
const MAX_DOWNLOAD_BYTES: usize = 64 << 10;
/// Maximum number of texels whose values are listed.
const MAX_TEXELS: usize = 12;
/// Maximum number of fields that are listed.
const MAX_FIELDS: usize = 32;

/// Renders the gallery of cases and a page for each case. Also returns the files that are small enough.
pub(super) fn pages(context: PageContext, jobs: usize) -> Vec<SiteFile> {
    let cases = &context.library.suite.cases;
    let rendered = ptm_suite::kit::parallel::map_in_parallel(cases.len(), jobs, &|_, _| (), &|i| {
        let built = cases[i].build(TableSpelling::default());
        let page = page(context, &cases[i], &built);
        let path = format!("files/{}.ptm", cases[i].id);
        let is_small = built.file.len() <= MAX_DOWNLOAD_BYTES;
        let file = is_small.then(|| SiteFile::new(path, built.file.clone()));
        (thumbnail(&cases[i], &built), [Some(page), file])
    });
    let (thumbnails, files): (Vec<_>, Vec<_>) = rendered.into_iter().unzip();
    let mut pages = gallery::pages(context, &thumbnails);
    pages.extend(files.into_iter().flatten().flatten());
    pages
}

/// Renders the map under the light of the case, or returns `None` if the reference refuses the file.
fn thumbnail(case: &Case, built: &Built) -> Option<RgbaImage> {
    let (ptm, light) = lit_map(case, built)?;
    Some(gallery::fit(&render_lit(
        &ptm.coefficients(),
        light.lu,
        light.lv,
    )))
}

/// Returns the map of a case, and the light of its first view with a light.
fn lit_map(case: &Case, built: &Built) -> Option<(Ptm, Light)> {
    let default_view: View = View::DEFAULT_RGB.parse().expect("a light");
    let mut views = case.views.iter().chain([&default_view]);
    let light = views.find_map(|view| match view {
        View::Rgb(light) => Some(light.clone()),
        _ => None,
    })?;
    Some((decode(&built.file).ok()?, light))
}

fn page(context: PageContext, case: &Case, built: &Built) -> SiteFile {
    let inspection = inspect(&built.file);
    let body = html! {
        h1 { code { (case.id) } }
        p.lead { (context.prose(&case.because)) }
        p { span.chip { (case.expect.name()) } " " (context.library.texts.expectations[case.expect.name()]) }
        (facts(context, case, built))
        (render_image(case, built))
        (values(case, built))
        h2 { "The file, byte by byte" }
        (fields(context, &inspection))
        (findings(context, built))
        (related_cases(context, case))
        (reader_results(context, case))
        h2 { "Commands" }
        pre.command tabindex="0" { "ptm-conform check --case '" (case.id) "' ./my-decoder\nptm-conform explain " (case.id) }
    };
    context.entry("Cases", &case.id, &case.id, &body)
}

fn facts(context: PageContext, case: &Case, built: &Built) -> Markup {
    let views: Vec<String> = case.views.iter().map(ToString::to_string).collect();
    html! {
        dl.facts {
            dt { "Clauses" } dd { (context.links(case.clauses.iter().map(String::as_str))) }
            dt { "Format" } dd { (context.link_as("2.2", &html! { code { (case.format()) } })) }
            @if let Some(ruling) = &case.ruling { dt { "Ruling" } dd { (context.link(ruling)) } }
            dt { "Requested views" } dd { code { (views.join(", ")) } " — the first of these that the decoder supports" }
            @if let Some(tolerance) = describe_tolerance(case, built) { dt { "Tolerance" } dd { (tolerance) } }
            dt { "File" } dd {
                @if built.file.len() <= MAX_DOWNLOAD_BYTES {
                    a href={ (context.root) "files/" (case.id) ".ptm" } download { (case.id) ".ptm" } ", "
                }
                (built.file.len()) " bytes"
                @if built.file.len() > MAX_DOWNLOAD_BYTES { "; " code { "ptm-conform generate --all --out DIR" } " writes it" }
            }
        }
    }
}

fn describe_tolerance(case: &Case, built: &Built) -> Option<String> {
    let view = &case.views[0];
    let expected = Expected::new(&built.values, view)?;
    let max = expected.slack.iter().copied().fold(0.0, f64::max);
    let text = tolerance_text(view.kind());
    Some(match max > 0.0 {
        true => format!("{text}, plus up to {max} because inverse DCTs differ"),
        false => text.to_owned(),
    })
}

fn render_image(case: &Case, built: &Built) -> Markup {
    html! {
        @if let Some((ptm, light)) = lit_map(case, built) {
            figure.large {
                (images::render_map(&ptm.coefficients(), (light.lu, light.lv), &format!("the map, {}, under a light", ptm.header.size)))
                figcaption { (ptm.header.size) " under the light " (light.lu) ", " (light.lv) @if case.expect != Expect::Decode { ", as the reference decodes it" } }
            }
        } @else { p.nothing { "No image: the reference refuses this file." } }
    }
}

/// Renders the expected values of the first texels.
fn values(case: &Case, built: &Built) -> Markup {
    let view = &case.views[0];
    let Some(expected) = Expected::new(&built.values, view) else {
        return html! {};
    };
    let width = expected.size.width as usize;
    let texels = expected.size.texels();
    html! {
        h2 { "Expected values" }
        div.scroll tabindex="0" { table.values {
            thead { tr { th scope="col" { code { (view) } } @for channel in 0..expected.channels { th.number scope="col" { (channel_name(expected.channels, channel)) } } } }
            tbody { @for texel in 0..texels.min(MAX_TEXELS) { tr {
                th scope="row" { "(" (texel % width) ", " (texel / width) ")" }
                @for channel in 0..expected.channels { td.number { (number(expected.values[texel * expected.channels + channel])) } }
            } } }
        } }
        @if texels > MAX_TEXELS { p.quiet { "The first " (MAX_TEXELS) " of " (texels) " texels are shown; texel (0, 0) is at the top left." } }
    }
}

fn fields(context: PageContext, inspection: &Inspection) -> Markup {
    let all = inspection.fields.len();
    html! {
        div.scroll tabindex="0" { table.hex {
            thead { tr { th.number scope="col" { "byte" } th.number scope="col" { "length" } th scope="col" { "clause" } th scope="col" { "field" } th scope="col" { "value" } th scope="col" { "first bytes" } } }
            tbody { @for field in inspection.fields.iter().take(MAX_FIELDS) { tr {
                td.number { (field.offset) } td.number { (field.length) }
                td { (context.link_as(field.clause, &html! { (field.clause) })) } td { (field.name) } td { code { (truncate(&field.value)) } } td { code { (field.first_bytes) } }
            } } }
        } }
        @if all > MAX_FIELDS { p.quiet { (all - MAX_FIELDS) " more fields; " code { "ptm-conform inspect" } " shows all." } }
        @if let Some(error) = &inspection.error {
            p.fault { b { "Byte " (error.offset) } ", clause " (context.link_as(error.clause, &html! { (error.clause) })) ", " (error.class) ": " (error.description) }
        }
        @if let Some(rest) = &inspection.rest { p { (rest.length) " bytes from byte " (rest.offset) " onward do not belong to a field: " code { (rest.first_bytes) } } }
    }
}

fn truncate(value: &str) -> String {
    const MAX_CHARS: usize = 96;
    match value.char_indices().nth(MAX_CHARS) {
        Some((end, _)) => format!("{}…", &value[..end]),
        None => value.to_owned(),
    }
}

fn findings(context: PageContext, built: &Built) -> Markup {
    let findings = lint(&built.file);
    html! {
        @if !findings.is_empty() {
            h2 { "Lint findings" }
            ul { @for finding in findings.iter().take(12) { li { (context.link(finding.code)) " " (finding.message) @if !finding.found.is_empty() { ": " code { (truncate(&finding.found)) } } } } }
        }
    }
}

/// Renders links from a damaged case to its twin, and from a valid case to its damaged copies.
fn related_cases(context: PageContext, case: &Case) -> Markup {
    let mut children: Vec<&Case> = context.library.suite.cases.iter().collect();
    children.retain(|child| child.twin_of.as_ref() == Some(&case.id));
    html! {
        @if let (Some(twin), Some(damage)) = (&case.twin_of, case.damage()) {
            h2 { "Twin" }
            p { "The file is a copy of " (context.link(twin)) ", in which " (damage.effect) "." }
        }
        @if !children.is_empty() {
            h2 { "Damaged copies of this file" }
            ul.columns { @for child in children { li { (context.link(&child.id)) } } }
        }
    }
}

fn reader_results(context: PageContext, case: &Case) -> Markup {
    html! {
        h2 { "Public readers" }
        ul.plain { @for run in &context.library.runs {
            @let outcome = run.outcome(&case.id).name();
            li { span.outcome data-outcome=(outcome) { (outcome) } " " (context.link_as(&run.reader, &html! { (run.reader) })) " " span.quiet { (run.version) } }
        } }
    }
}
