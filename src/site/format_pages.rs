//! Pages of the annotated format, one per chapter.

use std::collections::BTreeSet;

use maud::{Markup, html};

use super::annotated::{AnnotatedClause, Chapter, WorkedExample};
use super::example::{Decoding, Execution, execute};
use super::page::{PageContext, SiteFile};
use super::{formula::formula, misreading_pages, overview};
use super::{readers::readers_with_mistake, ruling_pages};
use ptm_mistakes::Misreading;
use ptm_suite::clauses::Clause;

/// Maximum number of misreadings per clause that are displayed with images. The others are listed.
const MAX_ILLUSTRATED_MISREADINGS: usize = 2;
/// Maximum number of parts of a file that are all displayed. Of other files, the parts that an example is not about are folded.
const MAX_UNFOLDED_PARTS: usize = 8;
/// Maximum length of a part whose bytes are all displayed.
const MAX_DISPLAYED_BYTES: usize = 32;

/// Renders the table of contents and the page of each chapter. Returns an error that names the clause whose example fails.
pub(super) fn pages(context: PageContext) -> Result<Vec<SiteFile>, String> {
    let chapters = &context.library.annotated.chapters;
    let mut pages = vec![contents(context)];
    for (i, chapter) in chapters.iter().enumerate() {
        let before = i.checked_sub(1).map(|i| &chapters[i]);
        pages.push(page(context, chapter, before, chapters.get(i + 1))?);
    }
    Ok(pages)
}

fn contents(context: PageContext) -> SiteFile {
    let body = html! {
        h1 { "The format, annotated" }
        p.lead {
            "PTM 1.2 section by section, in our own words. Every rule has an id, a byte-level example that was run when this page was built, and a list of the mistakes that "
            "readers make. Where the specification is silent, a ruling states the reading of this suite and the reasons for it."
        }
        p { "To write a decoder, read the chapters in order. " (context.link_as("2.2", &html! { "Section 2.2" })) " lists the chapters that each format needs." }
        ol.chapters {
            @for chapter in &context.library.annotated.chapters {
                li { a href={ (chapter.section) ".html" } { b { (chapter.section) } " " (chapter.title) } " " span.quiet { (chapter.clauses.len()) " clauses" } }
            }
        }
        h2 #drawing { "File structure" }
        (overview::drawing(context))
        (overview::flow(context))
    };
    let title = "The format, annotated";
    context.page("format/index.html", "Format", title, &body)
}

fn page(
    context: PageContext,
    chapter: &Chapter,
    before: Option<&Chapter>,
    after: Option<&Chapter>,
) -> Result<SiteFile, String> {
    let mut explained = BTreeSet::new();
    let mut clauses = Vec::new();
    for annotated in &chapter.clauses {
        clauses.push(clause(context, annotated, &mut explained)?);
    }
    let link = |chapter: &Chapter| html! { a href={ (chapter.section) ".html" } { (chapter.section) " " (chapter.title) } };
    let body = html! {
        p.kicker { a href="index.html" { "The format, annotated" } }
        h1 { (chapter.section) " " (chapter.title) }
        p.lead { (context.prose(&chapter.intro)) }
        @if let Some(table) = &chapter.table {
            div.scroll tabindex="0" { table.list {
                thead { tr { @for cell in &table.head { th scope="col" { (cell) } } } }
                tbody { @for row in &table.rows { tr { @for cell in row { td { (context.prose(cell)) } } } } }
            } }
        }
        @if !chapter.steps.is_empty() {
            ol.steps { @for step in &chapter.steps { li { (context.prose(step)) } } }
        }
        nav.within aria-label="Clauses of this chapter" {
            @for clause in &chapter.clauses { a href={ "#c-" (clause.clause.replace('/', "-")) } { (clause.clause) } " " }
        }
        @for clause in &clauses { (clause) }
        nav.turn aria-label="Chapters" {
            @if let Some(chapter) = before { span { "← " (link(chapter)) } }
            @if let Some(chapter) = after { span { (link(chapter)) " →" } }
        }
    };
    let path = format!("format/{}.html", chapter.section);
    let title = format!("{} {}", chapter.section, chapter.title);
    Ok(context.page(&path, "Format", &title, &body))
}

fn clause<'a>(
    context: PageContext<'a>,
    annotated: &AnnotatedClause,
    explained: &mut BTreeSet<&'a str>,
) -> Result<Markup, String> {
    let library = context.library;
    let id = annotated.clause.as_str();
    let rule = library.clause(id);
    let rule = rule.ok_or_else(|| format!("unknown clause {id}"))?;
    let executed = execute(annotated, rule.ruling.as_deref(), &library.annotated.files)?;
    let anchor = format!("c-{}", id.replace('/', "-"));
    let mistakes = ptm_mistakes::all().filter(|misreading| misreading.clause == id);
    Ok(html! {
        section.clause id=(anchor) aria-labelledby={ (anchor) "-h" } {
            h2 id={ (anchor) "-h" } { a.id href={ "#" (anchor) } { (id) } " " (rule.rule) }
            p { (context.prose(&annotated.text)) }
            @for line in &annotated.formula { div.formula tabindex="0" { (formula(line)) } }
            @for (i, (example, executed)) in annotated.examples.iter().zip(&executed).enumerate() {
                (render_example(context, example, executed, i + 1, annotated.examples.len()))
            }
            (ruling_markup(context, &rule.id, explained))
            (misreading_markup(context, mistakes.collect()))
            (test_markup(context, rule))
        }
    })
}

fn render_example(
    context: PageContext,
    example: &WorkedExample,
    executed: &Execution,
    number: usize,
    count: usize,
) -> Markup {
    let placed = executed.parts.iter().scan(0, |end, (name, bytes)| {
        let offset = *end;
        *end += bytes.len();
        Some((offset, name.as_str(), bytes.as_slice()))
    });
    let placed = placed.filter(|(.., bytes)| !bytes.is_empty());
    let parts: Vec<FilePart> = placed
        .map(|(offset, name, bytes)| FilePart {
            offset,
            name,
            bytes,
            is_highlighted: example
                .highlighted
                .iter()
                .any(|highlighted| highlighted == name),
        })
        .collect();
    let highlighted: Vec<&FilePart> = parts.iter().filter(|part| part.is_highlighted).collect();
    let is_folded = parts.len() > MAX_UNFOLDED_PARTS && !highlighted.is_empty();
    html! {
        figure.example {
            figcaption { b { "Example" @if count > 1 { " " (number) } } @if let Some(says) = &example.description { " " (context.prose(says)) } }
            @if is_folded {
                (part_table(&highlighted))
                details { summary { "all " (parts.len()) " parts of the file" } (part_table(&parts.iter().collect::<Vec<_>>())) }
            } @else { (part_table(&parts.iter().collect::<Vec<_>>())) }
            (result(&executed.view, &executed.found, example.because.as_deref()))
            @for (reading, found) in &executed.alternatives {
                p.otherwise { "Under the reading " em { (reading) } ": " (inline_result(found)) "." }
            }
        }
    }
}

/// A part of the file of an example.
struct FilePart<'a> {
    offset: usize,
    name: &'a str,
    bytes: &'a [u8],
    /// True if the example is about this part.
    is_highlighted: bool,
}

fn part_table(parts: &[&FilePart]) -> Markup {
    html! {
        div.scroll tabindex="0" { table.hex {
            thead { tr { th.number scope="col" { "byte" } th scope="col" { "part" } th scope="col" { "bytes" } th scope="col" { "as text" } } }
            tbody {
                @for part in parts {
                    tr data-look[part.is_highlighted] {
                        td.number { (part.offset) } td { (part.name) } td { code { (hex(part.bytes)) } } td { code { (as_text(part.bytes)) } }
                    }
                }
            }
        } }
    }
}

fn result(asks: &str, found: &Decoding, because: Option<&str>) -> Markup {
    html! {
        @match found {
            Decoding::Refused(..) => p.result { (inline_result(found)) "." },
            Decoding::Values(names, rows) => div.scroll tabindex="0" { table.values {
                thead { tr { th scope="col" { code { (asks) } } @for name in names { th.number scope="col" { (name) } } } }
                tbody { @for (texel, values) in rows { tr { th scope="row" { "texel " (texel) } @for value in values { td.number { (value) } } } } }
            } },
        }
        @if let Some(because) = because { p.because { (because) } }
    }
}

fn inline_result(found: &Decoding) -> Markup {
    match found {
        Decoding::Refused(clause, why) => {
            html! { b { "Refused" } " by clause " (clause) ": " code { (why) } }
        }
        Decoding::Values(_, rows) => html! {
            @for (i, (texel, values)) in rows.iter().enumerate() {
                @if i > 0 { "; " } "texel " (texel) " is" @for value in values { " " b { (value) } }
            }
        },
    }
}

/// Formats bytes in hexadecimal. Long sequences are abbreviated to the first and last bytes.
fn hex(bytes: &[u8]) -> String {
    let words: Vec<String> = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
    if words.len() <= MAX_DISPLAYED_BYTES {
        return words.join(" ");
    }
    let first = words[..MAX_DISPLAYED_BYTES / 2].join(" ");
    let last = words[words.len() - MAX_DISPLAYED_BYTES / 4..].join(" ");
    format!("{first} … {last} ({} bytes)", words.len())
}

/// Formats a header line with visible whitespace. Returns an empty string for binary data.
fn as_text(bytes: &[u8]) -> String {
    let mut texts = bytes.iter();
    let is_text = texts.all(|byte| byte.is_ascii_graphic() || b" \r\n".contains(byte));
    if !is_text || !bytes.ends_with(b"\n") && !bytes.ends_with(b" ") {
        return String::new();
    }
    let text = String::from_utf8_lossy(bytes).replace(' ', "␣");
    text.replace('\r', "←").replace('\n', "↵")
}

/// Renders the rulings of a clause. If a ruling is in `seen`, only its reading is rendered.
fn ruling_markup<'a>(context: PageContext<'a>, id: &str, seen: &mut BTreeSet<&'a str>) -> Markup {
    let rulings = context.library.rulings.iter();
    let rulings = rulings.filter(|ruling| ruling.clauses.iter().any(|clause| clause == id));
    html! {
        @for ruling in rulings {
            aside.ruling aria-label={ "Ruling " (ruling.id) " at " (id) } {
                p { b { "Ruling: " } (context.link(&ruling.id)) " " span.chip { (ruling.kind.name()) } }
                @if seen.insert(&ruling.id) { (ruling_pages::describe_ruling(context, ruling)) } @else { p { (context.prose(ruling.reading.trim())) } }
            }
        }
    }
}

fn misreading_markup(context: PageContext, mut mistakes: Vec<&Misreading>) -> Markup {
    // List misreadings of known readers first.
    mistakes.sort_by_key(|misreading| readers_with_mistake(misreading).is_empty());
    let (first, others) = mistakes.split_at(MAX_ILLUSTRATED_MISREADINGS.min(mistakes.len()));
    html! {
        @if !first.is_empty() {
            details.mistakes open[first.iter().any(|misreading| !readers_with_mistake(misreading).is_empty())] {
                summary { (mistakes.len()) @if mistakes.len() == 1 { " misreading" } @else { " misreadings" } }
                @for misreading in first {
                    article.mistake {
                        p { (context.link(misreading.slug)) ": the decoder " (misreading.effect) ". " b { "Fix: " } (misreading.fix) "." }
                        @if !readers_with_mistake(misreading).is_empty() { p.seen { "Seen in " (misreading_pages::sightings(context, misreading)) "." } }
                        (misreading_pages::image_pair(context, misreading))
                    }
                }
                @if !others.is_empty() {
                    ul { @for misreading in others { li { (context.link(misreading.slug)) ": " (misreading.effect) } } }
                }
            }
        }
    }
}

fn test_markup(context: PageContext, clause: &Clause) -> Markup {
    let mut cases: Vec<_> = context.library.suite.cases.iter().collect();
    cases.retain(|case| case.clauses.contains(&clause.id));
    let first = cases.iter().take(6).map(|case| case.id.as_str());
    html! {
        p.tested {
            @if let Some(why) = &clause.why { "Not tested separately: " (why) ". " }
            @if !cases.is_empty() {
                (cases.len()) @if cases.len() == 1 { " case: " } @else { " cases: " } (context.links(first))
                @if cases.len() > 6 { " … " a href={ (context.root) "cases/index.html?" (clause.id) } { "all" } }
            }
        }
    }
}
