//! Pages about texture mapping: requirements, rulings, steps with examples, cases and misreadings.

use maud::{Markup, html};

use super::page::{PageContext, SiteFile};
use super::ruling_pages;
use ptm_suite::clauses::{Clause, section_of};
use ptm_suite::texture::{cases::TextureCase, verify::verify};

/// Renders all pages about texture mapping. Returns an error if the reference does not return the expected answer to a case.
pub(super) fn pages(context: PageContext) -> Result<Vec<SiteFile>, String> {
    let chapter = chapter(context)?;
    Ok(vec![
        chapter,
        rulings(context),
        cases(context),
        mistakes(context),
    ])
}

fn chapter(context: PageContext) -> Result<SiteFile, String> {
    let texts = &context.library.texts;
    let questions = texts.steps.iter().map(|step| question(context, step));
    let questions: Vec<Markup> = questions.collect::<Result<_, _>>()?;
    let body = html! {
        h1 { "Texture mapping, annotated" }
        p.lead { "A PTM under a light is an image, and an image can be a texture. The chapter “Texture Mapping Table” of PEXlib 5.2 describes how a texture is applied to a surface. The formulas of the chapter were printed as images and are "
            "lost. They are reconstructed here from the surrounding text and from related documents. Rulings mark the reconstructions." }
        p { a href="rulings.html" { "Rulings" } " · " a href="cases.html" { "Cases" } " · " a href="misreadings.html" { "Misreadings" } " · " a href="../docs/texture.html" { "Stage protocol" } }
        h2 #steps { "Step by step: a question and its answer" }
        p { "When this page was built, the reference computed every answer, and each was compared with the answer that the suite expects." }
        @for question in &questions { (question) }
        h2 #requirements { "The requirements" }
        @for (letters, title) in &texts.topics {
            @let clauses: Vec<&Clause> = context.library.requirements.iter().filter(|clause| section_of(&clause.id) == letters).collect();
            @if !clauses.is_empty() {
                h3 id=(letters) { (title) " " span.quiet { (letters) } }
                ul.plain { @for clause in clauses { (requirement(context, clause)) } }
            }
        }
    };
    Ok(context.page("texture/index.html", "Texture", "Texture mapping", &body))
}

fn requirement(context: PageContext, clause: &Clause) -> Markup {
    let cases = context.library.textures.cases.iter();
    let cases = cases.filter(|case| case.clauses.contains(&clause.id));
    let cases: Vec<&str> = cases.map(|case| case.id.as_str()).collect();
    html! {
        li id=(clause.id) {
            b { (clause.id) } " " (clause.rule)
            @if let Some(ruling) = &clause.ruling { " Ruling: " (context.link(ruling)) "." }
            @if let Some(why) = &clause.why { " " span.quiet { "Not tested: it " (why) "." } }
            @if !cases.is_empty() { " " span.quiet { "Cases: " (context.links(cases)) "." } }
        }
    }
}

/// Renders the shortest question about a step, and its answer, which is verified against the reference.
fn question(context: PageContext, (op, action): &(String, String)) -> Result<Markup, String> {
    let cases = context.library.textures.cases.iter();
    let cases = cases.filter(|case| case.op == *op);
    let case = cases.min_by_key(|case| case.question().to_string().len());
    let case = case.ok_or_else(|| format!("no case has the operation {op}"))?;
    let mut answers = verify(case).into_iter();
    if let Some(wrong) = answers.find(|answer| answer.agrees == Some(false)) {
        return Err(format!("texture case {}: {}", wrong.id, wrong.message));
    }
    Ok(html! {
        figure.example id={ "step-" (op) } {
            figcaption { b { code { (op) } } " " (action) " — " (context.link(&case.id)) }
            pre tabindex="0" { (case.question()) }
            pre tabindex="0" { (case.expect) }
            p.because { (case.because) }
        }
    })
}

fn rulings(context: PageContext) -> SiteFile {
    let body = html! {
        p.kicker { a href="index.html" { "Texture" } }
        h1 { "Texture: rulings" }
        @for ruling in &context.library.texture_rulings {
            section.clause id=(ruling.id) {
                h2 { code { (ruling.id) } " " span.chip { (ruling.kind.name()) } }
                (ruling_pages::describe_ruling(context, ruling))
                p.tested { "Requirements: " (context.links(ruling.clauses.iter().map(String::as_str))) }
            }
        }
    };
    context.page("texture/rulings.html", "Texture", "Texture: rulings", &body)
}

fn cases(context: PageContext) -> SiteFile {
    let body = html! {
        p.kicker { a href="index.html" { "Texture" } }
        h1 { "Texture: cases" }
        p.lead { (context.library.textures.cases.len()) " questions with their answers." }
        (super::misreading_pages::filter_box("cases"))
        @for case in &context.library.textures.cases { (render_case(context, case)) }
    };
    context.page("texture/cases.html", "Texture", "Texture: cases", &body)
}

fn render_case(context: PageContext, case: &TextureCase) -> Markup {
    html! {
        section.case-text.filtered id=(case.id) {
            h2 { code { (case.id) } " " span.quiet { (case.op) } }
            p { (case.because) " " span.quiet { (context.links(case.clauses.iter().map(String::as_str))) } @if let Some(ruling) = &case.ruling { " Ruling: " (context.link(ruling)) } }
            pre tabindex="0" { (case.question()) }
            pre tabindex="0" { (case.expect) }
            @for also in &case.alternatives { p { "Read as " em { (also.reading) } ": " code { (also.expect) } } }
        }
    }
}

fn mistakes(context: PageContext) -> SiteFile {
    let body = html! {
        p.kicker { a href="index.html" { "Texture" } }
        h1 { "Texture: misreadings" }
        (super::misreading_pages::filter_box("misreadings"))
        section.filtered { ul.plain.mistakes { @for misreading in ptm_mistakes::texture::all() {
            li id=(misreading.slug) { code { (misreading.slug) } " " (context.link_as(misreading.clause, &html! { (misreading.clause) })) ": the stage " (misreading.effect) ". " b { "Fix: " } (misreading.fix) "." (context.library.objects.textures.misreading(context, misreading).unwrap_or_default()) }
        } } }
    };
    let title = "Texture: misreadings";
    context.page("texture/misreadings.html", "Texture", title, &body)
}
