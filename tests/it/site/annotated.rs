//! The annotated format: every clause has examples, and an example that does not hold ends the build.

use ptm_conform::site::annotated::{Annotated, CHAPTERS, FILES};
use ptm_conform::site::build;
use ptm_conform::site::example::{Found, execute, execute_all};
use ptm_conform::suite::clauses::clauses;
use ptm_conform::suite::name::SuiteName;

fn annotated() -> Annotated {
    Annotated::read(CHAPTERS, FILES).expect("the chapters are read")
}

/// The chapters with one thing in their text replaced, which occurs.
fn with(from: &str, to: &str) -> Annotated {
    let (mut found, mut texts) = (false, Vec::new());
    for (name, text) in CHAPTERS {
        found |= text.contains(from);
        texts.push((*name, text.replacen(from, to, 1)));
    }
    assert!(found, "{from:?} occurs");
    let chapters: Vec<(&str, &str)> = texts
        .iter()
        .map(|(name, text)| (*name, text.as_str()))
        .collect();
    Annotated::read(&chapters, FILES).expect("the chapters are read")
}

#[test]
fn every_clause_has_an_example_in_the_order_of_the_text() {
    let known: Vec<String> = clauses()
        .expect("the clauses")
        .into_iter()
        .map(|clause| clause.id)
        .collect();
    let annotated = annotated();
    let told: Vec<&str> = annotated
        .chapters
        .iter()
        .flat_map(|chapter| &chapter.clauses)
        .map(|clause| clause.clause.as_str())
        .collect();
    let missing: Vec<&String> = known
        .iter()
        .filter(|id| !told.contains(&id.as_str()))
        .collect();
    assert!(
        missing.is_empty() && told.len() == known.len(),
        "missing: {missing:?}"
    );
    for chapter in &annotated.chapters {
        for clause in &chapter.clauses {
            let page = SuiteName::Ptm.clause_page(&clause.clause).expect("a page");
            let expected = format!("format/{}.html#", chapter.section);
            assert!(page.starts_with(&expected), "{}: {page}", clause.clause);
        }
    }
}

#[test]
fn every_example_holds() {
    execute_all(&annotated()).expect("every example holds");
}

#[test]
fn a_changed_byte_ends_the_build_and_names_the_clause() {
    let error = build(
        Some(with("83 02 03 04 05 0a", "84 02 03 04 05 0a")),
        None,
        1,
    )
    .err()
    .expect("no site");
    assert_eq!(
        error,
        "clause 2.4/8, example 1: expected 1.5 60, found 2 60"
    );
    let error = build(Some(with("00 00 00 03 e7", "00 00 00 02 e7")), None, 1)
        .err()
        .expect("no site");
    assert!(
        error.starts_with("clause 2.9.8/5, example 1: expected 30 231 10 21"),
        "{error}"
    );
    // What should be refused and is not, and the other way round.
    let error = build(Some(with("PTM_FORMAT_lrgb", "PTM_FORMAT_LRGB")), None, 1)
        .err()
        .expect("no site");
    assert!(
        error.contains("clause 2.2/1, example 2: the file is decoded"),
        "{error}"
    );
}

/// A wrong byte in what an example shows is not passed over: of the parts that a clause points at, some byte decides.
#[test]
fn what_an_example_points_at_decides_it() {
    let annotated = annotated();
    for clause in annotated
        .chapters
        .iter()
        .flat_map(|chapter| &chapter.clauses)
    {
        let decides = clause.examples.iter().enumerate().any(|(i, example)| {
            let parts = annotated
                .files
                .parts(&example.file, &example.with)
                .expect("its parts");
            let looked = |is: &String| example.look.is_empty() || example.look.contains(is);
            let places = parts.iter().enumerate().filter(|(_, (is, _))| looked(is));
            places
                .flat_map(|(place, (_, bytes))| (0..bytes.len()).map(move |at| (place, at)))
                .any(|(place, at)| {
                    let mut changed = parts.clone();
                    changed[place].1[at] ^= 1;
                    let file: Vec<u8> = changed.into_iter().flat_map(|(_, bytes)| bytes).collect();
                    !holds(clause, i, &annotated, &file)
                })
        });
        // These say what does not matter.
        let unimportant = ["2.9.1/1", "2.9.1/2"];
        assert!(
            decides || unimportant.contains(&clause.clause.as_str()),
            "{}: no byte decides",
            clause.clause
        );
    }
}

/// Whether a file means what example `i` of a clause says.
fn holds(
    clause: &ptm_conform::site::annotated::AnnotatedClause,
    i: usize,
    annotated: &Annotated,
    file: &[u8],
) -> bool {
    let executed = execute(clause, None, &annotated.files).expect("it holds");
    let example = &clause.examples[i];
    match (&executed[i].found, example.find_in(file)) {
        (Found::Refused(clause, _), Ok(Found::Refused(now, _))) => *clause == now,
        (expected, Ok(found)) => *expected == found,
        (_, Err(_)) => false,
    }
}
