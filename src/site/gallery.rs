//! List of the cases: thumbnails by section and clause, folded by clause.

use std::collections::BTreeMap;

use image::{DynamicImage, ImageFormat, RgbImage, RgbaImage, imageops};
use maud::{Markup, html};

use super::misreading_pages::filter_box;
use super::page::{PageContext, SiteFile};
use ptm_files::render::encode_image;
use ptm_suite::cases::Case;
use ptm_suite::clauses::section_of;

/// Width and height of a thumbnail in the file of a section.
const SIDE: u32 = 32;
/// Width and height of a thumbnail on the page, in CSS pixels. The style sheet uses the same number.
const DISPLAYED_SIDE: usize = 40;
/// Number of thumbnails in a row of the file. The style sheet uses the same number.
const COLUMNS: usize = 16;

/// Maximum number of thumbnails that are shown of a folded group.
const MAX_PREVIEW: usize = 12;

/// A case, and its thumbnail unless the reference refuses the file.
type Entry<'a> = (&'a Case, Option<&'a RgbaImage>);

/// Enlarges or subsamples an image to a thumbnail.
pub(super) fn fit(image: &RgbImage) -> RgbaImage {
    let (width, height) = image.dimensions();
    let largest = width.max(height);
    let scaled = |side: u32| (side * SIDE / largest).max(1);
    let (width, height) = (scaled(width), scaled(height));
    let scaled = imageops::resize(image, width, height, imageops::FilterType::Nearest);
    let mut thumbnail = RgbaImage::new(SIDE, SIDE);
    let margin = |side: u32| i64::from((SIDE - side) / 2);
    let scaled = DynamicImage::from(scaled).to_rgba8();
    imageops::replace(&mut thumbnail, &scaled, margin(width), margin(height));
    thumbnail
}

/// Renders the list, and a file with the thumbnails of each section.
pub(super) fn pages(context: PageContext, thumbnails: &[Option<RgbaImage>]) -> Vec<SiteFile> {
    let cases = &context.library.suite.cases;
    let mut sections: BTreeMap<&str, BTreeMap<&str, Vec<Entry>>> = BTreeMap::new();
    for (case, thumbnail) in cases.iter().zip(thumbnails) {
        let clause = case.clauses.first().map_or("", String::as_str);
        let clauses = sections.entry(section_of(clause)).or_default();
        let entries = clauses.entry(clause).or_default();
        entries.push((case, thumbnail.as_ref()));
    }
    let chapters = &context.library.annotated.chapters;
    let body = html! {
        p.lead { (cases.len()) " files, each with one feature that a reader can get wrong, by the first clause that they test." }
        (PageContext::descriptions(&context.library.texts.expectations, &["decode", "reject", "refuse", "lenient", "spelling"]))
        p { "The exit statuses are defined in " (context.protocol()) ". A thumbnail shows the map under the light of the case." }
        (filter_box("cases"))
        @for (section, clauses) in &sections {
            section.filtered.gallery aria-label={ "Section " (section) } {
                h2 { "Section " (context.link_as(section, &html! { (section) })) @if let Some(chapter) = chapters.iter().find(|chapter| chapter.section == *section) { ": " (chapter.title) } }
                (clause_groups(context, section, clauses))
            }
        }
    };
    let mut files = vec![context.list("Cases", &body)];
    files.extend(sections.iter().map(|(section, clauses)| {
        let images: Vec<&RgbaImage> = clauses
            .values()
            .flatten()
            .filter_map(|entry| entry.1)
            .collect();
        SiteFile::new(format!("thumbnails/{section}.png"), sheet(&images))
    }));
    files
}

/// Renders the folded list of each clause of a section.
fn clause_groups(
    context: PageContext,
    section: &str,
    clauses: &BTreeMap<&str, Vec<Entry>>,
) -> Markup {
    let mut next = 0..;
    let groups = clauses.iter().map(|(clause, entries)| {
        let places: Vec<Option<usize>> = entries
            .iter()
            .map(|(_, image)| image.and_then(|_| next.next()))
            .collect();
        (clause, entries, places)
    });
    let groups: Vec<_> = groups.collect();
    html! {
        @for (clause, entries, places) in &groups {
            details {
                summary {
                    b { (clause) } " " @if let Some(clause) = context.library.clause(clause) { (clause.rule) } " "
                    span.quiet { (entries.len()) @if entries.len() == 1 { " case" } @else { " cases" } }
                    span aria-hidden="true" { @for &place in &preview(entries, places) { (thumbnail(context, section, Some(place))) } }
                }
                ul { @for ((case, _), place) in entries.iter().zip(places) {
                    li title=(case.because) {
                        (thumbnail(context, section, *place))
                        span { (context.link(&case.id)) br; small { (case.expect.name()) " · " (case.format().short_name()) " · " (case.clauses.join(" ")) } }
                    }
                } }
            }
        }
    }
}

/// Returns the places of the first different thumbnails of a group.
fn preview(entries: &[Entry], places: &[Option<usize>]) -> Vec<usize> {
    let mut shown: Vec<&RgbaImage> = Vec::new();
    let mut preview = Vec::new();
    for ((_, image), place) in entries.iter().zip(places) {
        if let (Some(image), Some(place)) = (image, place)
            && preview.len() < MAX_PREVIEW
            && !shown.contains(image)
        {
            shown.push(image);
            preview.push(*place);
        }
    }
    preview
}

/// Renders the thumbnail at a place of the file of a section, or an empty frame.
fn thumbnail(context: PageContext, section: &str, place: Option<usize>) -> Markup {
    let Some(place) = place else {
        return html! { i {} };
    };
    let offset = |i: usize| i * DISPLAYED_SIDE;
    let style = format!(
        "background:url({}thumbnails/{section}.png) -{}px -{}px",
        context.root,
        offset(place % COLUMNS),
        offset(place / COLUMNS)
    );
    html! { i style=(style) {} }
}

/// Joins thumbnails to one image.
fn sheet(thumbnails: &[&RgbaImage]) -> Vec<u8> {
    let rows = thumbnails.len().div_ceil(COLUMNS).max(1) as u32;
    let mut sheet = RgbaImage::new(SIDE * COLUMNS as u32, SIDE * rows);
    for (i, thumbnail) in thumbnails.iter().enumerate() {
        let place = |i: usize| i as i64 * i64::from(SIDE);
        imageops::replace(
            &mut sheet,
            *thumbnail,
            place(i % COLUMNS),
            place(i / COLUMNS),
        );
    }
    encode_image(&sheet.into(), ImageFormat::Png).expect("the image is small enough to encode")
}
