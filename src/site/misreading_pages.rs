//! Pages for misreadings: effect, fix, the smallest file that reveals the misreading, and correct and wrong images.

use std::collections::BTreeMap;

use maud::{Markup, html};

use super::page::{PageContext, SiteFile};
use super::{images, objects, readers::readers_with_mistake, witness::MisreadingWitness};
use ptm::decode::decode;
use ptm::reading::Reading;
use ptm_mistakes::Misreading;
use ptm_suite::protocol::frame::{Answer, Frame, View};
use ptm_suite::{cases::TableSpelling, clauses::section_of};

/// Renders the list of misreadings and the page of each misreading.
pub(super) fn pages(context: PageContext) -> Vec<SiteFile> {
    let mut pages = vec![list_page(context)];
    pages.extend(ptm_mistakes::all().map(|misreading| page(context, misreading)));
    pages
}

fn list_page(context: PageContext) -> SiteFile {
    let count = ptm_mistakes::all().count();
    let mut sections: BTreeMap<&str, Vec<&Misreading>> = BTreeMap::new();
    for misreading in ptm_mistakes::all() {
        let section = sections.entry(section_of(misreading.clause));
        section.or_default().push(misreading);
    }
    let chapters = &context.library.annotated.chapters;
    let body = html! {
        p.lead { (count) " mistakes that a reader of the format can make, each concerning one clause. Mistakes marked ● were seen in public readers." }
        (filter_box("misreadings"))
        @for (section, misreadings) in sections {
            section.filtered aria-label={ "Section " (section) } {
                h2 { "Section " (context.link_as(section, &html! { (section) })) @if let Some(chapter) = chapters.iter().find(|chapter| chapter.section == section) { ": " (chapter.title) } }
                ul.plain { @for misreading in misreadings { li {
                    (context.link(misreading.slug)) @if !readers_with_mistake(misreading).is_empty() { span.seen title="seen in a public reader" { " ●" } }
                    " " span.quiet { (misreading.clause) } " " (misreading.effect)
                } } }
            }
        }
    };
    context.list("Misreadings", &body)
}

/// Renders a search box that filters the entries of a list page.
pub(super) fn filter_box(entries: &str) -> Markup {
    html! {
        form.tools role="search" {
            label for="list-filter" { "Filter" }
            input #list-filter type="search" placeholder={ "words or clauses; hides other " (entries) } autocomplete="off" spellcheck="false";
            span #list-found role="status" aria-live="polite" {}
        }
    }
}

fn page(context: PageContext, misreading: &Misreading) -> SiteFile {
    let rule = context.library.clause(misreading.clause);
    let witness = context.library.witnesses.get(misreading.slug);
    let object = objects::misreading(context, misreading);
    let body = html! {
        h1 { code { (misreading.slug) } }
        p.lead { "The decoder " (misreading.effect) "." }
        p.fix { b { "Fix: " } (context.prose(misreading.fix)) "." }
        p { b { "Clause " (context.link_as(misreading.clause, &html! { (misreading.clause) })) } @if let Some(rule) = rule { ": " (rule.rule) } }
        @match misreading.violates {
            Some(violated) if violated != misreading.clause => p { b { "Violates ruling " (context.link(violated)) } @if let Some(ruling) = context.library.rulings.iter().find(|ruling| ruling.id == violated) { ": " (context.prose(ruling.reading.trim())) } },
            _ => p { b { "Violates " } "the words of this clause." },
        }
        @if !readers_with_mistake(misreading).is_empty() { p { b { "Seen in " } (sightings(context, misreading)) "." } }
        @if let Some(object) = &object { (object) }
        h2 { "Smallest file that reveals the mistake" }
        @match witness {
            Some(witness) => (witness_markup(context, misreading, witness, object.is_none())),
            None => p { "The mistake concerns a choice or the spelling of a table, so no single file of the suite reveals it." },
        }
    };
    context.entry("Misreadings", misreading.slug, misreading.slug, &body)
}

fn witness_markup(
    context: PageContext,
    misreading: &Misreading,
    w: &MisreadingWitness,
    with_images: bool,
) -> Markup {
    let case = &context.library.suite.cases[w.case];
    let built = case.build(TableSpelling::default());
    html! {
        p { (context.link(&case.id)) ", " (built.file.len()) " bytes, requested as " code { (w.view) } ": " (case.because) }
        @if with_images { (witness_image_pair(context, misreading)) }
        @if let Some(difference) = &w.difference { p { "In " code { (w.view) } ": " (difference) "." } }
        pre.command tabindex="0" { "ptm-conform check --case '" (case.id) "' ./my-decoder" }
    }
}

/// Lists the public readers that make the mistake.
pub(super) fn sightings(context: PageContext, misreading: &Misreading) -> Markup {
    html! {
        @for (i, (reader, version)) in readers_with_mistake(misreading).into_iter().enumerate() {
            @if i > 0 { ", " }
            (context.link_as(reader, &html! { (reader) }))
            @if let Some(version) = version { " " span.quiet { (version) } }
        }
    }
}

/// Renders an image as it is, next to the image that a decoder with the mistake outputs: an object that can be relit, or the
/// smallest file that reveals the mistake if the object does not show it.
pub(super) fn image_pair(context: PageContext, misreading: &Misreading) -> Markup {
    objects::misreading(context, misreading)
        .unwrap_or_else(|| witness_image_pair(context, misreading))
}

/// Renders the smallest file that reveals the mistake, correct and with the mistake.
fn witness_image_pair(context: PageContext, misreading: &Misreading) -> Markup {
    let Some(witness) = context.library.witnesses.get(misreading.slug) else {
        return html! {};
    };
    let case = &context.library.suite.cases[witness.case];
    let file = &case.build(TableSpelling::default()).file;
    let right = decode(file);
    let right_frame = |view: &View| {
        let ptm = right.as_ref().ok()?;
        Some(Frame::render(ptm, view))
    };
    let light: View = match &witness.view {
        View::Rgb(_) => witness.view.clone(),
        _ => View::DEFAULT_RGB.parse().expect("a light"),
    };
    let wrong = |view: &View| {
        let answer = ptm_mistakes::answer(&[misreading], Reading::SPEC, file, view);
        answer.decoded::<Frame>().ok()
    };
    let wrong_lit = wrong(&light);
    let is_visible = right.is_err() || wrong_lit.is_none() || wrong_lit != right_frame(&light);
    // If the mistake is invisible under a light, display the stored values.
    let (view, wrong) = match is_visible {
        true => (light, wrong_lit),
        false => (View::Raw, wrong(&View::Raw)),
    };
    let answer = match &witness.answer {
        Answer::Rejected => "refused",
        Answer::Unsupported => "unsupported",
        _ => "no image",
    };
    html! {
        div.pair {
            figure { (image_or_text(right_frame(&view).as_ref(), "correct", "refused: the file breaks a rule")) figcaption { "correct" } }
            figure { (image_or_text(wrong.as_ref(), "with the mistake", answer)) figcaption { "with the mistake" } }
        }
        @if view == View::Raw { p.quiet { "These are the stored values, plane by plane, because a lit image does not show the difference." } }
    }
}

fn image_or_text(frame: Option<&Frame>, alt: &str, fallback: &str) -> Markup {
    let image = frame.and_then(|frame| images::render_frame(frame, alt));
    image.unwrap_or_else(|| html! { p.nothing { (fallback) } })
}
