//! The pages: links lead somewhere, nothing is fetched, the bytes are the same each time and not too many.

use std::collections::{HashMap, HashSet};
use std::sync::LazyLock;

use ptm_conform::site::readers::reader_runs;
use ptm_conform::site::{SiteFile, build};
use ptm_conform::suite::cases::Suite;

static SITE: LazyLock<Vec<SiteFile>> =
    LazyLock::new(|| build(None, None, 2).expect("the site is built"));

fn is_page(file: &SiteFile) -> bool {
    file.path.rsplit('.').next() == Some("html")
}

/// The values of an attribute, wherever it stands.
fn values<'a>(page: &'a str, attribute: &str) -> Vec<&'a str> {
    let start = format!(" {attribute}=\"");
    let pieces = page.split(start.as_str()).skip(1);
    pieces.filter_map(|piece| piece.split('"').next()).collect()
}

/// A link of the page at `from` as a path from the root, without what follows `#` and `?`.
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
fn every_link_and_anchor_leads_somewhere() {
    let paths: HashSet<&str> = SITE.iter().map(|file| file.path.as_str()).collect();
    let pages = SITE.iter().filter(|file| is_page(file));
    let pages: HashMap<&str, &str> = pages
        .map(|file| {
            (
                file.path.as_str(),
                std::str::from_utf8(&file.bytes).expect("UTF-8"),
            )
        })
        .collect();
    let ids: HashMap<&str, HashSet<&str>> = pages
        .iter()
        .map(|(path, page)| (*path, values(page, "id").into_iter().collect()))
        .collect();
    let mut links = 0;
    for (path, page) in &pages {
        assert_eq!(
            values(page, "id").len(),
            ids[path].len(),
            "{path}: an id stands there twice"
        );
        for link in [values(page, "href"), values(page, "src")].concat() {
            if link.starts_with("data:") || link.starts_with("https://") {
                continue;
            }
            links += 1;
            let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
            let file = file.split('?').next().expect("a first part");
            let leads = if file.is_empty() {
                (*path).to_owned()
            } else {
                target(path, file)
            };
            assert!(paths.contains(leads.as_str()), "{path}: {link}");
            assert!(
                anchor.is_empty() || ids[leads.as_str()].contains(anchor),
                "{path}: {link}"
            );
        }
    }
    assert!(links > 50_000, "{links} links");
}

#[test]
fn nothing_is_fetched_from_anywhere() {
    for file in SITE.iter().filter(|file| is_page(file)) {
        let page = std::str::from_utf8(&file.bytes).expect("UTF-8");
        for source in values(page, "src") {
            assert!(!source.contains("://"), "{}: {source}", file.path);
        }
        let styles = page.split("rel=\"stylesheet\" href=\"").skip(1);
        assert!(
            styles
                .filter_map(|piece| piece.split('"').next())
                .all(|style| !style.contains("://"))
        );
    }
}

#[test]
fn the_same_bytes_are_made_each_time_and_not_too_many() {
    let again = build(None, None, 1).expect("the site is built");
    let bytes: usize = again.iter().map(|file| file.bytes.len()).sum();
    assert!(bytes <= 40_000_000, "{bytes} bytes");
    assert_eq!(again.len(), SITE.len());
    for (one, other) in SITE.iter().zip(&again) {
        assert!(
            one.path == other.path && one.bytes == other.bytes,
            "{}",
            one.path
        );
    }
}

#[test]
fn runs_of_readers_name_cases_of_the_suite_each_once() {
    let suite = Suite::load().expect("the suite loads");
    let runs = reader_runs().expect("the runs are read");
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("reports/readers");
    assert_eq!(
        runs.len(),
        std::fs::read_dir(folder).expect("the runs").count()
    );
    for run in runs {
        let cases: Vec<&String> = run.outcomes.values().flatten().collect();
        let unknown: Vec<_> = cases.iter().filter(|id| suite.case(id).is_none()).collect();
        assert!(unknown.is_empty(), "{}: {unknown:?}", run.reader);
        assert_eq!(
            cases.iter().collect::<HashSet<_>>().len(),
            cases.len(),
            "{}",
            run.reader
        );
    }
}
