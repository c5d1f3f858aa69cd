//! Tests of the pages: links are valid, nothing is fetched, and the output is reproducible and small.

use std::collections::{HashMap, HashSet};
use std::sync::LazyLock;

use ptm_conform::site::{SiteFile, readers::reader_runs};
use ptm_files::lint::codes;
use ptm_files::readers::profiles;
use ptm_suite::texture::cases as texture;
use ptm_suite::{address, cases::Suite, clauses, name::SuiteName};

use super::SITE;

fn is_page(file: &SiteFile) -> bool {
    file.path.rsplit('.').next() == Some("html")
}

fn text(file: &SiteFile) -> &str {
    std::str::from_utf8(&file.bytes).expect("UTF-8")
}

/// Returns the values of an attribute, in the order in which they occur on the page.
fn values<'a>(page: &'a str, attribute: &str) -> Vec<&'a str> {
    let start = format!(" {attribute}=\"");
    let pieces = page.split(start.as_str()).skip(1);
    pieces.filter_map(|piece| piece.split('"').next()).collect()
}

/// Returns the page at a path.
#[track_caller]
fn page(path: &str) -> &'static str {
    static PAGES: LazyLock<HashMap<&str, &SiteFile>> =
        LazyLock::new(|| SITE.iter().map(|file| (&*file.path, file)).collect());
    text(PAGES.get(path).unwrap_or_else(|| panic!("no page {path}")))
}

/// Asserts that the page at an address exists and contains the anchor.
#[track_caller]
fn assert_exists(address: &str) {
    let (path, anchor) = address.split_once('#').unwrap_or((address, ""));
    let (page, id) = (page(path), format!(" id=\"{anchor}\""));
    assert!(anchor.is_empty() || page.contains(&id), "{address}");
}

/// Resolves a link on the page at `from`. Returns a path relative to the root of the site.
fn target(from: &str, link: &str) -> String {
    let mut path: Vec<&str> = from.split('/').collect();
    path.pop();
    for part in link.split('/') {
        match part {
            ".." => {
                path.pop().expect("no link leaves the site");
            }
            part => path.push(part),
        }
    }
    path.join("/")
}

#[test]
fn every_link_and_anchor_exists() {
    let paths: HashSet<&str> = SITE.iter().map(|file| file.path.as_str()).collect();
    let pages = SITE.iter().filter(|file| is_page(file));
    let pages: HashMap<&str, &str> = pages.map(|file| (&*file.path, text(file))).collect();
    let ids = pages
        .iter()
        .map(|(path, page)| (*path, values(page, "id").into_iter().collect()));
    let ids: HashMap<&str, HashSet<&str>> = ids.collect();
    let mut links = 0;
    for (path, page) in &pages {
        let count = values(page, "id").len();
        assert_eq!(count, ids[path].len(), "{path}: a duplicate id");
        for link in [values(page, "href"), values(page, "src")].concat() {
            if link.starts_with("data:") || link.starts_with("https://") {
                continue;
            }
            links += 1;
            let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
            let file = file.split('?').next().expect("a first part");
            let resolved = if file.is_empty() {
                (*path).to_owned()
            } else {
                target(path, file)
            };
            assert!(paths.contains(resolved.as_str()), "{path}: {link}");
            let exists = anchor.is_empty() || ids[resolved.as_str()].contains(anchor);
            assert!(exists, "{path}: {link}");
        }
    }
    assert!(links > 50_000, "{links} links");
}

#[test]
fn pages_load_nothing_external() {
    for file in SITE.iter().filter(|file| is_page(file)) {
        let page = text(file);
        for source in values(page, "src") {
            assert!(!source.contains("://"), "{}: {source}", file.path);
        }
        let styles = page.split("rel=\"stylesheet\" href=\"").skip(1);
        let mut styles = styles.filter_map(|piece| piece.split('"').next());
        assert!(styles.all(|style| !style.contains("://")));
    }
}

/// The program generates the same files in a separate process with one thread.
#[test]
fn site_is_reproducible_and_small() {
    let here = crate::common::Workspace::new();
    here.succeeds("site --jobs 1 --out again");
    let bytes: usize = SITE.iter().map(|file| file.bytes.len()).sum();
    assert!(bytes <= 56_000_000, "{bytes} bytes");
    for file in SITE.iter() {
        let other = here.read(&format!("again/{}", file.path));
        assert!(file.bytes == other, "{}", file.path);
    }
}

/// Every URL that the program prints for a catalog id leads to a page.
#[test]
fn every_published_address_has_a_page() {
    let mut addresses: Vec<String> = Vec::new();
    let (ptm, stage) = (SuiteName::Ptm, SuiteName::Texture);
    let suite = Suite::load().expect("the suite loads");
    let stages = Suite::load_texture().expect("the texture suite loads");
    let cases = suite.cases.iter().map(|case| ptm.case_page(&case.id));
    let cases = cases.chain(stages.cases.iter().map(|case| stage.case_page(&case.id)));
    addresses.extend(cases.map(|page| page.expect("a case has a page")));
    for (suite, clauses, rulings) in [
        (ptm, clauses::clauses(), clauses::rulings()),
        (stage, texture::clauses(), texture::rulings()),
    ] {
        let clauses = clauses.expect("the clauses").into_iter();
        addresses.extend(clauses.map(|clause| suite.clause_page(&clause.id).expect("a place")));
        let rulings = rulings.expect("the rulings").into_iter();
        addresses.extend(rulings.map(|ruling| suite.ruling_page(&ruling.id)));
    }
    let slugs = ptm_mistakes::all().map(|one| ptm.misreading_page(one.slug));
    let slugs =
        slugs.chain(ptm_mistakes::texture::all().map(|one| stage.misreading_page(one.slug)));
    addresses.extend(slugs);
    addresses.extend(codes::ALL.iter().map(|code| address::code(code.id)));
    addresses.extend(profiles().iter().map(|one| address::reader(&one.reader)));
    addresses.extend([ptm, stage, SuiteName::Writers].map(|name| name.protocol_page().to_owned()));
    for address in &addresses {
        assert_exists(address);
    }
    assert!(addresses.len() > 3000, "{}", addresses.len());
}

#[test]
fn search_finds_documents_terms_and_the_protocol() {
    let entries = page("search-index.js").strip_prefix("window.searchIndex = ");
    let entries = entries.and_then(|entries| entries.trim_end().strip_suffix(';'));
    let entries: Vec<[String; 4]> =
        serde_json::from_str(entries.expect("a list")).expect("the list is read");
    for expected in [
        ["Serve mode and capabilities", "document"],
        ["stored order", "word"],
        ["PTM-CP 1", "protocol"],
    ] {
        assert!(
            entries.iter().any(|[id, kind, ..]| [id, kind] == expected),
            "{expected:?}"
        );
    }
    for [id, _, place, _] in &entries {
        println!("{id}");
        assert_exists(place);
    }
}

#[test]
fn ruling_page_lists_its_cases_with_expected_results() {
    let says = "Cases of this ruling that are marked lenient";
    assert!(page("rulings/numbers.html").contains(says));
    assert!(!page("rulings/dimensions.html").contains(says));
    let version = page("rulings/version.html");
    for (case, verdict) in [
        ("version-longer-lrgb", "refuse"),
        ("version-1-1-interleaves", "lenient"),
    ] {
        let line = version
            .split("<li>")
            .find(|line| line.contains(&format!(">{case}<")));
        assert!(line.expect("the case").contains(verdict), "{case}");
    }
}

#[test]
fn reader_reports_name_each_case_once() {
    let suite = Suite::load().expect("the suite loads");
    let runs = reader_runs().expect("the runs are read");
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("reports/readers");
    let files = std::fs::read_dir(folder).expect("the runs");
    assert_eq!(runs.len(), files.count());
    for run in runs {
        let cases: Vec<&String> = run.outcomes.values().flatten().collect();
        let unknown: Vec<_> = cases.iter().filter(|id| suite.case(id).is_none()).collect();
        assert!(unknown.is_empty(), "{}: {unknown:?}", run.reader);
        let distinct: HashSet<_> = cases.iter().collect();
        assert_eq!(distinct.len(), cases.len(), "{}", run.reader);
    }
}
