//! Tests of the annotated format: every clause has examples, and a wrong example makes the build fail.

use ptm_conform::site::annotated::{Annotated, AnnotatedClause, CHAPTERS, FILES};
use ptm_conform::site::build;
use ptm_conform::site::example::{Decoding, execute, execute_all};
use ptm_suite::{clauses::clauses, name::SuiteName};

use crate::table::rows;

fn annotated() -> Annotated {
    Annotated::read(CHAPTERS, FILES).expect("the chapters are read")
}

/// Returns the annotated format after replacing the first occurrence of `from`, which must exist, with `to`.
fn with_replacement(from: &str, to: &str) -> Annotated {
    let (mut found, mut texts) = (false, Vec::new());
    for (name, text) in CHAPTERS {
        found |= text.contains(from);
        texts.push((*name, text.replacen(from, to, 1)));
    }
    assert!(found, "{from:?} does not occur");
    let chapters = texts.iter().map(|(name, text)| (*name, text.as_str()));
    let chapters: Vec<(&str, &str)> = chapters.collect();
    Annotated::read(&chapters, FILES).expect("the chapters are read")
}

#[test]
fn every_clause_has_an_example_in_its_chapter() {
    let known = clauses().expect("the clauses");
    let annotated = annotated();
    let chapters = annotated.chapters.iter();
    let explained = chapters.flat_map(|chapter| &chapter.clauses);
    let explained: Vec<&String> = explained.map(|clause| &clause.clause).collect();
    let ids = known.iter().map(|clause| &clause.id);
    let missing: Vec<&String> = ids.filter(|id| !explained.contains(id)).collect();
    assert!(missing.is_empty(), "missing: {missing:?}");
    assert_eq!(explained.len(), known.len());
    for chapter in &annotated.chapters {
        for clause in &chapter.clauses {
            let page = SuiteName::Ptm.clause_page(&clause.clause).expect("a page");
            let expected = format!("format/{}.html#", chapter.section);
            assert!(page.starts_with(&expected), "{}: {page}", clause.clause);
        }
    }
}

#[test]
fn every_example_is_correct() {
    execute_all(&annotated()).expect("every example is correct");
}

#[test]
fn wrong_example_names_the_clause() {
    for [from, to, message] in rows(
        "
83 02 03 04 05 0a | 84 02 03 04 05 0a | clause 2.4/8, example 1: expected 1.5 60, found 2 60
00 00 00 03 e7 | 00 00 00 02 e7 | clause 2.9.8/5, example 1: expected 30 231 10 21
PTM_FORMAT_lrgb | PTM_FORMAT_LRGB | clause 2.2/1, example 2: the file is decoded",
    ) {
        let error = build(Some(with_replacement(&from, &to)), None, 1).err();
        let error = error.expect("no site");
        assert!(error.contains(&message), "{error}");
    }
}

/// At least one byte in the highlighted parts of a clause's examples affects the result.
#[test]
fn highlighted_bytes_affect_the_result() {
    let annotated = annotated();
    let chapters = annotated.chapters.iter();
    for clause in chapters.flat_map(|chapter| &chapter.clauses) {
        let decides = clause.examples.iter().enumerate().any(|(i, example)| {
            let parts = annotated.files.parts(&example.file, &example.replacements);
            let parts = parts.expect("the parts of the file");
            let shown = &example.highlighted;
            let is_shown = |name: &String| shown.is_empty() || shown.contains(name);
            let places = parts.iter().enumerate();
            let places = places.filter(|(_, (name, _))| is_shown(name));
            places
                .flat_map(|(place, (_, bytes))| (0..bytes.len()).map(move |at| (place, at)))
                .any(|(place, at)| {
                    let mut changed = parts.clone();
                    changed[place].1[at] ^= 1;
                    let file: Vec<u8> = changed.into_iter().flat_map(|(_, bytes)| bytes).collect();
                    !is_correct(clause, i, &annotated, &file)
                })
        });
        // These clauses are about bytes that do not affect the result.
        let exceptions = ["2.9.1/1", "2.9.1/2"];
        let decides = decides || exceptions.contains(&clause.clause.as_str());
        assert!(decides, "{}: no byte affects the result", clause.clause);
    }
}

/// Returns true if the result of example `i` of a clause is correct for a file.
fn is_correct(clause: &AnnotatedClause, i: usize, annotated: &Annotated, file: &[u8]) -> bool {
    let executed = execute(clause, None, &annotated.files).expect("a correct example");
    let example = &clause.examples[i];
    match (&executed[i].found, example.evaluate(file)) {
        (Decoding::Refused(clause, _), Ok(Decoding::Refused(now, _))) => *clause == now,
        (expected, Ok(found)) => *expected == found,
        (_, Err(_)) => false,
    }
}
