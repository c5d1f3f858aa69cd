//! `ptm-conform explain`: describes a case, clause, ruling, misreading or lint code, or lists all ids.

use std::collections::BTreeMap;
#[cfg(unix)]
use std::collections::HashMap;
use std::fmt::Write as _;
#[cfg(unix)]
use std::time::Duration;

use clap::Args;

#[cfg(unix)]
use super::output::{bar, jobs};
use super::terminal::print_styled;
use super::{
    CommandResult, arguments::is_at_or_below, links::page_line, names::did_you_mean, readers,
};
use ptm::Format;
use ptm_files::lint::codes::{self, Code};
use ptm_files::readers::ReaderProfile;
#[cfg(unix)]
use ptm_harness::strength::matrix::run_with_mistakes;
use ptm_mistakes::{Misreading, writing};
use ptm_suite::address;
use ptm_suite::cases::{Case, Suite, TableSpelling};
use ptm_suite::clauses::{self, Clause, Ruling, section_of};
use ptm_suite::kit::digest::sha256;
use ptm_suite::texture::cases as texture;
#[cfg(unix)]
use ptm_suite::verdicts::outcome::Outcome;
use ptm_suite::{name::SuiteName, test_case::Listed};
#[cfg(unix)]
use ptm_writers::cases::load_writer_requests;
#[cfg(unix)]
use ptm_writers::fitting::{cases::load_fitter_requests, photographs::Encoding};

/// Explain a case, a clause, a ruling, a misreading, a lint code or a public reader, or search for a word.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform explain 2.4/8\n  ptm-conform explain hand-rgb-blocks\n  ptm-conform explain rows-top-down\n  ptm-conform explain nentries"
)]
pub struct ExplainArgs {
    /// An id such as hand-rgb-blocks, 2.4/8, lut-count, PTM-W102 or PTM_LUT; without one, all ids except those of cases are listed.
    /// A word that is no id is searched for in the texts.
    #[arg(value_name = "ID|WORD")]
    id: Option<String>,
    /// Of a case, list every field of the file, also those of long lists.
    #[arg(long)]
    all: bool,
}

/// Explains an id. If it is unknown, searches for it in all texts, or suggests similar ids.
pub fn run(args: &ExplainArgs) -> CommandResult {
    let Some(id) = &args.id else {
        print_styled(&list_ids(&Suite::load()?)?);
        return Ok(0);
    };
    let Some(text) = explain(id, args.all)? else {
        let known = explainable(&Suite::load()?)?;
        let found = search(id, &known);
        if found.is_empty() {
            return Err(unknown_id_message(id, &known).into());
        }
        print_styled(&found);
        return Ok(0);
    };
    print_styled(&text);
    Ok(0)
}

/// Describes the `check-writer` request with this id. Returns an empty string if there is none.
#[cfg(unix)]
fn explain_request(id: &str) -> Result<String, String> {
    let fits = load_fitter_requests(None, Encoding::Png);
    if let Some(case) = fits.case(id) {
        let clauses = case.clauses.join(", ");
        let lights = case.values.photographs(case.format).lp();
        let because = &case.because;
        return Ok(format!(
            "fitter request {id} ({clauses})\n  {because}\n  lights:\n{lights}"
        ));
    }
    let suite = load_writer_requests()?;
    let Some(case) = suite.case(id) else {
        return Ok(String::new());
    };
    let request = case.request();
    let first = request.samples.iter().take(18);
    let first: Vec<String> = first.map(|byte| format!("{byte:02x}")).collect();
    Ok(format!(
        "writer request {id} ({})\n  {}\n  expected: {}\n{}  planes: {} bytes, top row first, beginning with {}\n",
        case.clauses.join(", "),
        case.because,
        case.expectation_name(),
        request.header.to_json(),
        request.samples.len(),
        first.join(" ")
    ))
}

/// Lists all ids except case ids.
fn list_ids(suite: &Suite) -> Result<String, String> {
    let clauses = clauses::clauses()?;
    let sections = clauses.iter().map(|clause| section_of(&clause.id));
    let mut sections: Vec<&str> = sections.collect();
    sections.dedup();
    let mut text = format!(
        "{} cases; ptm-conform explain SECTION lists those about a section\n\n{} clauses:\n  section  clauses  cases\n",
        suite.cases.len(),
        clauses.len()
    );
    for section in &sections {
        let is_about = |id: &String| section_of(id) == *section;
        let clauses = clauses.iter().filter(|clause| is_about(&clause.id)).count();
        let is_case = |case: &&Case| case.clauses.iter().any(is_about);
        let cases = suite.cases.iter().filter(is_case).count();
        let _ = writeln!(text, "  {section:<7}  {clauses:>7}  {cases:>5}");
    }
    let rulings = clauses::rulings()?;
    let names: Vec<&str> = rulings.iter().map(|ruling| ruling.id.as_str()).collect();
    let _ = writeln!(text, "\n{} rulings:\n  {}", names.len(), names.join(", "));
    let _ = writeln!(text, "\n{} misreadings:", ptm_mistakes::all().count());
    for section in &sections {
        let about = ptm_mistakes::all().filter(|found| section_of(found.clause) == *section);
        let slugs: Vec<&str> = about.map(|misreading| misreading.slug).collect();
        if !slugs.is_empty() {
            let _ = writeln!(text, "  {section}: {}", slugs.join(", "));
        }
    }
    let codes: Vec<&str> = codes::ALL.iter().map(|code| code.id).collect();
    let (count, codes) = (codes.len(), codes.join(", "));
    let _ = writeln!(text, "\n{count} lint codes:\n  {codes}");
    let profiles = readers::load_profiles(None)?;
    let names = profiles.iter().map(|profile| profile.name.as_str());
    let names: Vec<&str> = names.collect();
    let _ = writeln!(text, "\n{} readers:\n  {}", names.len(), names.join(", "));
    Ok(text)
}

/// Describes everything that has the given id. Returns `None` if the id is unknown.
fn explain(id: &str, shows_all: bool) -> Result<Option<String>, String> {
    let (suite, pages) = (Suite::load()?, SuiteName::Ptm);
    let mut text = String::new();
    if let Some(case) = suite.case(id) {
        text += &explain_case(case, shows_all);
        text += &page_line(pages.case_page(id));
    }
    #[cfg(unix)]
    text.push_str(&explain_request(id)?);
    let clauses = clauses::clauses()?;
    text += &explain_rules(&suite, pages, &clauses, &clauses::rulings()?, id);
    if let Some(misreading) = ptm_mistakes::find(id) {
        text += &explain_misreading(misreading, "clause");
        let clause = clauses.iter().find(|clause| clause.id == misreading.clause);
        text.extend(clause.map(|clause| format!("  The clause says: {}\n", clause.rule)));
        let sightings = misreading.sightings.iter();
        let readers: Vec<String> = sightings.map(ToString::to_string).collect();
        if !readers.is_empty() {
            let _ = writeln!(text, "  Seen in: {}.", readers.join(", "));
        }
        if let Some(mistake) = writing::find(id) {
            let _ = writeln!(text, "  A writer with this mistake {}.", mistake.effect);
            let _ = writeln!(text, "  Fix: {}.", mistake.fix);
        }
        #[cfg(unix)]
        text.push_str(&describe_failing_cases(misreading, &suite)?);
        text += &page_line(match misreading.reading_of {
            Some(ruling) => Some(pages.ruling_page(ruling)),
            None => Some(pages.misreading_page(id)),
        });
    }
    if let Ok(format) = id.parse() {
        text += &explain_format(&suite, format);
    }
    if let Some(known) = Code::find(&id.to_uppercase()) {
        text += &explain_code(known, &suite);
        text += &page_line(Some(address::code(known.id)));
    }
    let profiles = readers::load_profiles(None)?;
    text.extend(
        profiles
            .iter()
            .filter(|profile| profile.name == id)
            .map(explain_reader),
    );
    text += &explain_texture(id)?;
    Ok(Some(text).filter(|text| !text.is_empty()))
}

fn explain_reader(profile: &ReaderProfile) -> String {
    let ReaderProfile { name, reader, .. } = profile;
    let title = profile.title.as_deref();
    let title = title.map_or_else(String::new, |title| format!(" ({title})"));
    let misreadings = profile.misreadings.iter();
    let misreadings = misreadings.map(|row| format!("{} ({})", row.slug, row.evidence.name()));
    let mut unusual = String::new();
    for row in &profile.unusual {
        let (shows, files) = (row.shows.label(), row.kind.label());
        let evidence = row.evidence.name();
        // Nothing is known about the other formats.
        let formats = match &row.formats[..] {
            [] => String::new(),
            formats => format!(", in the format {}", formats.join(" or ")),
        };
        let _ = writeln!(unusual, "  {shows} files {files}{formats} ({evidence})");
    }
    format!(
        "reader {name}: {reader}{title}\n  shows files of {}\n  misreadings: {}\n{unusual}  Predictions: ptm-conform lint --for {name} FILE\n",
        profile.formats.join(", "),
        misreadings.collect::<Vec<_>>().join(", ")
    )
}

/// Describes everything in the texture suite that has the given id. Returns an empty string if the id is unknown there.
fn explain_texture(id: &str) -> Result<String, String> {
    let (suite, pages) = (Suite::load_texture()?, SuiteName::Texture);
    let mut text = String::new();
    if let Some(case) = suite.case(id) {
        let clauses = case.clauses.join(", ");
        let _ = writeln!(text, "case {id} ({clauses}): {}", case.because);
        let _ = writeln!(text, "  question: {}", case.question());
        let _ = writeln!(text, "  expected: {}", case.expect);
        for also in &case.alternatives {
            let _ = writeln!(text, "  read as {}: {}", also.reading, also.expect);
        }
        if let Some(ruling) = &case.ruling {
            let _ = writeln!(text, "  ruling: {ruling}");
        }
        text += &page_line(pages.case_page(id));
    }
    let (clauses, rulings) = (texture::clauses()?, texture::rulings()?);
    text += &explain_rules(&suite, pages, &clauses, &rulings, id);
    if let Some(misreading) = ptm_mistakes::texture::find(id) {
        text += &explain_misreading(misreading, "requirement");
        text += &page_line(Some(pages.misreading_page(id)));
    }
    Ok(text)
}

/// Lists the sections that have cases in the given format.
fn explain_format(suite: &Suite, format: Format) -> String {
    let mut sections: BTreeMap<&str, usize> = BTreeMap::new();
    for case in suite.cases.iter().filter(|case| case.format() == format) {
        let first = case.clauses.first().map_or("none", |id| section_of(id));
        *sections.entry(first).or_default() += 1;
    }
    let mut text = format!(
        "format {} (clause 2.2/1): its cases by section\n",
        format.name()
    );
    for (section, count) in sections {
        let _ = writeln!(text, "  {section:<7} {count:>3} cases");
    }
    text + "  More: ptm-conform explain SECTION\n"
}

/// Describes the clauses that equal `id` or are contained in it, and the ruling with this id.
fn explain_rules<C: Listed>(
    suite: &Suite<C>,
    pages: SuiteName,
    clauses: &[Clause],
    rulings: &[Ruling],
    id: &str,
) -> String {
    let is_ptm = pages == SuiteName::Ptm;
    let [rule, open, reference] = match is_ptm {
        true => ["clause", "open: ", "the reference"],
        false => ["requirement", "", "reading"],
    };
    let mut text = String::new();
    let is_named = |clause: &&Clause| is_at_or_below(&clause.id, id);
    for clause in clauses.iter().filter(is_named) {
        let _ = write!(text, "{rule} {}: {}", clause.id, clause.rule);
        if let Some(ruling) = &clause.ruling {
            let _ = write!(text, " Ruling: {ruling}.");
        }
        text.extend(clause.why.iter().map(|why| format!(" Not tested: {why}.")));
        let about = suite.cases.iter();
        let about = about.filter(|case| case.clauses().contains(&clause.id));
        let ids: Vec<&str> = about.map(Listed::id).collect();
        let _ = match is_ptm {
            true => writeln!(text, "\n  {}", abbreviate_ids(&ids, "cases")),
            false => writeln!(text, "\n  cases: {}", ids.join(", ")),
        };
        text += &page_line(pages.clause_page(id).filter(|_| clause.id == id));
    }
    for ruling in rulings.iter().filter(|ruling| ruling.id == id) {
        let _ = writeln!(
            text,
            "ruling {id} ({}), {rule}s {}",
            ruling.kind.name(),
            ruling.clauses.join(", ")
        );
        let _ = writeln!(text, "  {open}{}", ruling.question.trim());
        let _ = writeln!(text, "  {reference}: {}", ruling.reading.trim());
        for also in &ruling.alternatives {
            let _ = writeln!(text, "  also correct: {also}");
        }
        let _ = writeln!(text, "  evidence: {}", ruling.evidence.trim());
        if let Some(basis) = ruling.rests_on {
            let _ = writeln!(text, "  rests on: {} ({})", basis.name(), basis.describe());
        }
        text += &page_line(Some(pages.ruling_page(id)));
    }
    text
}

fn explain_misreading<A>(misreading: &Misreading<A>, rule: &str) -> String {
    let Misreading {
        slug,
        clause,
        effect,
        fix,
        ..
    } = misreading;
    if let Some(ruling) = misreading.reading_of {
        return format!(
            "reading {slug} of {rule} {clause}: the decoder {effect}.\n  This is no mistake: ruling {ruling} allows it.\n"
        );
    }
    let violates = match misreading.violates {
        Some(violated) if violated == *clause => {
            format!("  It violates the words of {rule} {clause}.\n")
        }
        Some(ruling) => format!("  It violates ruling {ruling}.\n"),
        None => String::new(),
    };
    format!(
        "misreading {slug} of {rule} {clause}: the decoder {effect}.\n{violates}  Fix: {fix}.\n"
    )
}

/// Lists the cases that a decoder with this misreading fails, and describes its response to the smallest failing file.
#[cfg(unix)]
fn describe_failing_cases(misreading: &Misreading, suite: &Suite) -> Result<String, String> {
    let bar = bar(None, "{spinner} simulating this mistake in every case");
    bar.enable_steady_tick(Duration::from_millis(200));
    let (run, _) = run_with_mistakes(suite, &[misreading], &[], jobs(None)?, &HashMap::new());
    bar.finish_and_clear();
    let (mut ids, mut sizes) = (Vec::new(), Vec::new());
    for index in run.judgment.with_outcome(Outcome::Fail) {
        let case = &suite.cases[index];
        ids.push(&*case.id);
        sizes.push((case.build(TableSpelling::default()).file.len(), index));
    }
    let Some((bytes, index)) = sizes.into_iter().min() else {
        return Ok(String::new());
    };
    let (ids, Case { id, because, .. }) = (abbreviate_ids(&ids, "cases"), &suite.cases[index]);
    let (judged, seen) = (&run.judgment.cases[index], &run.observations[index]);
    let says = judged.as_ref().map_or("", |judged| &judged.message);
    let view = seen.as_ref().map(|seen| seen.view.to_string());
    let view = view.unwrap_or_default();
    Ok(format!(
        "  A decoder with this mistake fails {ids}\n  The smallest file that reveals it has {bytes} bytes: ptm-conform generate --case {id}\n    {view}: {says}\n    {because}\n"
    ))
}

fn explain_case(case: &Case, shows_all: bool) -> String {
    let (id, clauses, because) = (&case.id, case.clauses.join(", "), &case.because);
    let views: Vec<String> = case.views.iter().map(ToString::to_string).collect();
    let (views, built) = (views.join(", "), case.build(TableSpelling::default()));
    let mut text = format!("case {id} (clauses {clauses}): {because}\n");
    let _ = writeln!(text, "  expected: {}", case.expect.name());
    if let (Some(twin), Some(damage)) = (&case.twin_of, case.damage()) {
        let _ = writeln!(text, "  file: a copy of {twin}, in which {}", damage.effect);
    }
    let requested = "requested in the first of these views that the decoder supports";
    let _ = writeln!(text, "  {requested}: {views}");
    if let Some(ruling) = &case.ruling {
        let _ = writeln!(text, "  ruling: {ruling}");
    }
    let (size, digest) = (built.file.len(), sha256(&built.file));
    let _ = writeln!(text, "  file: {size} bytes, sha-256 {digest}");
    for (is, bytes) in case.pieces() {
        let _ = writeln!(text, "    {is:<40} {}", bytes.escape_ascii());
    }
    for list in built.fields.chunk_by(|a, b| a.clause == b.clause) {
        let is_folded = !shows_all && list.len() > MAX_LIST_FIELDS;
        let shown = if is_folded { FIRST_FIELDS } else { list.len() };
        for field in &list[..shown] {
            let (start, name, clause) = (field.range.start, &field.name, &field.clause);
            let bytes = &built.file[field.range.clone()];
            let shown = bytes[..bytes.len().min(24)].escape_ascii();
            let more = if bytes.len() > 24 { "…" } else { "" };
            let _ = writeln!(
                text,
                "    byte {start:>5}  {name:<22} {clause:<8} {shown}{more}"
            );
        }
        if is_folded {
            let more = list.len() - shown;
            let _ = writeln!(
                text,
                "                … {more} more of this clause; --all lists them"
            );
        }
    }
    text
}

/// Maximum number of fields of a clause that are listed one by one.
const MAX_LIST_FIELDS: usize = 8;

/// Number of fields that are listed of a longer list.
const FIRST_FIELDS: usize = 3;

/// Maximum number of texts of each kind that a search lists.
const MAX_FOUND: usize = 8;

/// Kind of ids, and each id with its text.
type Explainable = (&'static str, Vec<(String, String)>);

/// Returns the ids of the requests to fitters, with the reason for each.
fn fitter_ids() -> Vec<(String, String)> {
    #[cfg(unix)]
    return load_fitter_requests(None, Encoding::Png)
        .cases
        .into_iter()
        .map(|case| (case.id, case.because))
        .collect();
    #[cfg(not(unix))]
    Vec::new()
}

/// Returns the ids that can be explained, by kind, with the texts about them.
fn explainable(suite: &Suite) -> Result<[Explainable; 7], String> {
    let (clauses, rulings) = (clauses::clauses()?, clauses::rulings()?);
    let profiles = readers::load_profiles(None)?;
    let entry = |id: &str, says: &str| (id.to_owned(), says.trim().to_owned());
    let of_ruling = |ruling: &Ruling| {
        let Ruling {
            question,
            reading,
            evidence,
            ..
        } = ruling;
        format!("{} {reading} {evidence}", question.trim())
    };
    let clauses = clauses.iter().map(|clause| entry(&clause.id, &clause.rule));
    let rulings = rulings
        .iter()
        .map(|ruling| entry(&ruling.id, &of_ruling(ruling)));
    let misreadings = ptm_mistakes::all()
        .map(|found| entry(found.slug, &format!("{}. Fix: {}", found.effect, found.fix)));
    let fits = fitter_ids();
    let codes = codes::ALL.iter().map(|code| entry(code.id, code.message));
    let readers = profiles
        .iter()
        .map(|profile| entry(&profile.name, &profile.reader));
    let cases = suite
        .cases
        .iter()
        .map(|case| entry(&case.id, &case.because));
    Ok([
        ("clauses", clauses.collect()),
        ("rulings", rulings.collect()),
        ("misreadings", misreadings.collect()),
        ("lint codes", codes.collect()),
        ("readers", readers.collect()),
        ("cases", cases.collect()),
        ("fitter requests", fits),
    ])
}

/// Searches for a word in the ids and texts of everything that can be explained. Returns an empty string if it occurs nowhere.
fn search(word: &str, known: &[Explainable]) -> String {
    let wanted = word.to_lowercase();
    let contains = |text: &String| text.to_lowercase().contains(&wanted);
    let mut text = String::new();
    for (kind, entries) in known {
        let matches = |(id, says): &&(String, String)| contains(id) || contains(says);
        let found: Vec<_> = entries.iter().filter(matches).collect();
        if found.is_empty() {
            continue;
        }
        let kind = match found.len() {
            1 => kind.trim_end_matches('s'),
            _ => kind,
        };
        let _ = writeln!(text, "{} {kind}:", found.len());
        for (id, says) in found.iter().take(MAX_FOUND) {
            let _ = writeln!(text, "  {id}: {}", shorten(says));
        }
        if found.len() > MAX_FOUND {
            let _ = writeln!(text, "  … and {} more", found.len() - MAX_FOUND);
        }
    }
    text
}

/// Returns the first words of a long text.
fn shorten(text: &str) -> String {
    const MAX_LENGTH: usize = 200;
    let Some((end, _)) = text.char_indices().nth(MAX_LENGTH) else {
        return text.to_owned();
    };
    let end = text[..end].rfind(' ').unwrap_or(end);
    format!("{} …", &text[..end])
}

fn unknown_id_message(id: &str, known: &[Explainable]) -> String {
    let entries = known.iter().flat_map(|(_, entries)| entries);
    let hint = match did_you_mean(id, entries.map(|(id, _)| id.as_str())) {
        hint if hint.is_empty() => {
            "; ptm-conform explain lists all sections, misreadings, rulings and codes".to_owned()
        }
        hint => hint,
    };
    format!("unknown id {id:?}{hint}")
}

/// Describes a lint code and lists the cases that trigger it.
fn explain_code(code: &Code, suite: &Suite) -> String {
    let provokes = |case: &&Case| {
        let damage = case.damage().map(|damage| damage.name.as_str());
        code.is_triggered_by(&case.id) || damage.is_some_and(|damage| code.is_triggered_by(damage))
    };
    let cases = suite.cases.iter().filter(provokes);
    let cases: Vec<&str> = cases.map(|case| &*case.id).collect();
    let cases = abbreviate_ids(&cases, "cases provoke it");
    let (id, clause, says) = (code.id, code.clause, code.message);
    let mut text = format!(
        "code {id} ({}, clause {clause}): {says}\n",
        code.severity.name()
    );
    if !code.fix.is_empty() {
        let _ = writeln!(text, "  Fix: {}", code.fix);
    }
    text + "  " + &cases + "\n"
}

/// Formats the number of ids and lists the first six. `noun` is plural.
fn abbreviate_ids(ids: &[&str], noun: &str) -> String {
    let more = if ids.len() > 6 { ", …" } else { "" };
    let first = ids[..ids.len().min(6)].join(", ");
    match ids.len() {
        0 => format!("no {noun}"),
        1 => format!("1 {}: {first}", noun.trim_end_matches('s')),
        count => format!("{count} {noun}: {first}{more}"),
    }
}
