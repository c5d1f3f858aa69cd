//! Tests that the mistakes of writers are diagnosed with the catalog of misreadings.

use std::collections::HashMap;

use ptm::Format;
use ptm_harness::diagnose::Cause;
use ptm_harness::pipeline::judge_answers;
use ptm_harness::session::plan::RunPlan;
use ptm_mistakes::writing::{self, WriterMistake};
use ptm_suite::cases::{Expect, Suite};
use ptm_suite::protocol::frame::Answer;
use ptm_suite::protocol::request::{Reply, Request};
use ptm_suite::verdicts::outcome::Outcome;
use ptm_writers::cases::load_writer_requests;
use ptm_writers::request::{RequestHeader, WriteRequest};
use ptm_writers::test_case::{WriteView, WrittenFile};
use ptm_writers::wrong_files::write_with_mistake;
use ptm_writers::{cases::WriterCase, diagnose::diagnose, reference::write_requested_file};

use crate::common::{Workspace, edit, have_tool, repository_text, rows};

/// Requests for small files, with the files that the reference writes.
struct Requests {
    suite: Suite<WriterCase>,
    all: HashMap<String, (WriteRequest, Vec<u8>)>,
}

impl Requests {
    fn small() -> Requests {
        let mut suite = load_writer_requests().expect("the requests load");
        let large = |case: &WriterCase| {
            let request = case.request();
            let limit = match request.format.coding().is_some() {
                true => 1300,
                false => 3200,
            };
            request.samples.len() > limit || case.expect != Expect::Decode
        };
        suite.cases.retain(|case| !large(case));
        let all = suite.cases.iter().map(|case| {
            let request = case.request();
            let correct = write_requested_file(&request).expect("the reference writes it");
            (case.id.clone(), (request, correct))
        });
        Requests {
            all: all.collect(),
            suite,
        }
    }

    /// Returns the number of wrong files that a writer with this mistake writes, the first cause, and its equivalents.
    fn first_cause(&self, mistake: &WriterMistake) -> (usize, String, Vec<String>) {
        let ask = |query: &Request<'_, WriteView>, _: usize| {
            let (request, correct) = &self.all[query.name];
            let file =
                write_with_mistake(request, mistake.change).unwrap_or_else(|| correct.clone());
            Reply::from(Answer::Decoded(WrittenFile(file)))
        };
        let plan = RunPlan::new(&self.suite, 2);
        let run = judge_answers(&self.suite, &plan, &ask);
        let failing = run.judgment.with_outcome(Outcome::Fail).count();
        let causes = diagnose(&self.suite, &run, 2);
        match causes.first().map(|first| &first.cause) {
            Some(Cause::Misreading {
                misreading,
                equivalents: alike,
                ..
            }) => {
                let alike = alike.iter().map(|other| other.slug.to_owned());
                (failing, misreading.slug.to_owned(), alike.collect())
            }
            Some(Cause::Described { effect, .. }) => (failing, effect.clone(), Vec::new()),
            None => (failing, String::new(), Vec::new()),
        }
    }

    /// Returns three counts of mistakes: those that are caught, those that are named as the first cause, and those that are named
    /// as the first cause or as one of its equivalents.
    fn count_named(&self, mistakes: &[&'static WriterMistake]) -> (usize, usize, usize) {
        let (mut caught, mut first, mut matched) = (0, 0, 0);
        for mistake in mistakes {
            let (failing, cause, alike) = self.first_cause(mistake);
            let slug = mistake.slug.to_owned();
            caught += usize::from(failing > 0);
            first += usize::from(cause == slug);
            matched += usize::from(cause == slug || alike.contains(&slug));
            if cause != slug {
                println!("{slug}: {failing} failures, named {cause}, equivalent to {alike:?}");
            }
        }
        (caught, first, matched)
    }
}

#[test]
fn every_section_has_writer_mistakes() {
    let all: Vec<&WriterMistake> = writing::all().collect();
    assert!(all.len() >= 150, "{} mistakes", all.len());
    for section in "2.0 2.2 2.3 2.4 2.5 2.6 2.7 2.8 2.9".split(' ') {
        let mut clauses = all.iter().map(|one| one.clause);
        assert!(
            clauses.any(|clause| clause.starts_with(section)),
            "{section}"
        );
    }
}

#[test]
fn three_writer_mistakes_are_named() {
    let requests = Requests::small();
    let slugs = ["rgb-blocks-bgr", "rows-top-down", "height-before-width"];
    let some: Vec<_> = slugs.into_iter().filter_map(writing::find).collect();
    let (caught, _, matched) = requests.count_named(&some);
    assert_eq!((caught, matched), (some.len(), some.len()));
}

/// A mistake in the scales does not explain a wrong matrix, and a mistake in the matrix does not explain wrong scales.
#[test]
fn unrelated_mistakes_are_not_reported() {
    let mut requests = Requests::small();
    let cases = &mut requests.suite.cases;
    cases.retain(|case| case.format == Format::Lum);
    let first = |edit: fn(&mut RequestHeader)| {
        let ask = |query: &Request<'_, WriteView>, _: usize| {
            let mut request = requests.all[query.name].0.clone();
            edit(&mut request.header);
            let file = write_requested_file(&request).expect("a file");
            Reply::from(Answer::Decoded(WrittenFile(file)))
        };
        let plan = RunPlan::new(&requests.suite, 2);
        let run = judge_answers(&requests.suite, &plan, &ask);
        let causes = diagnose(&requests.suite, &run, 2);
        match &causes.first().expect("a cause").cause {
            Cause::Misreading { misreading, .. } => misreading.clause.to_owned(),
            Cause::Described { clause, .. } => clause.clone().unwrap_or_default(),
        }
    };
    let transposed = first(|header| {
        let matrix = header.matrix.expect("LUM");
        header.matrix = Some(std::array::from_fn(|i| matrix[4 * (i % 4) + i / 4]));
    });
    assert!(transposed.starts_with("2.6"), "{transposed}");
    let shifted = first(|header| header.scale = header.scale.map(|scale| scale + 0.0001));
    assert!(shifted.starts_with("2.4"), "{shifted}");
}

#[test]
#[ignore = "tests every mistake of the catalog; takes minutes"]
fn every_mistake_of_a_wrong_writer_is_named() {
    let requests = Requests::small();
    let all: Vec<&'static WriterMistake> = writing::all().collect();
    let (caught, first, matched) = requests.count_named(&all);
    let count = all.len();
    println!(
        "{count} mistakes: {caught} are caught, {first} are named first, {matched} if equivalents count"
    );
    assert!(caught * 100 >= count * 70, "{caught} of {count}");
    assert!(matched * 100 >= caught * 95, "{matched} of {caught}");
}

/// Copies of the Python writer, each with one mistake: the text to replace, the replacement, and a part of the first cause.
const COPIES: &str = r#"
b"".join(reversed(rows)) | b"".join(rows) | explain rows-top-down
"little") | "big") | explain big-endian-index
wide = entries > 256 | wide = entries >= 256 | explain width-at-256
wide = entries > 256 | wide = entries > 255 | explain width-at-256
wide = entries > 256 | wide = True | explain width-always-two
table.setdefault(entry, len(table)) | table.setdefault(entry, len(table)) + 1 | explain index-one-based
block(texels, 18, 0, 6) + block(texels, 18, 6, 6) + block(texels, 18, 12, 6)
  | block(texels, 18, 12, 6) + block(texels, 18, 6, 6) + block(texels, 18, 0, 6) | explain rgb-blocks-bgr
block(texels, 18, 0, 6) + block(texels, 18, 6, 6) + block(texels, 18, 12, 6)
  | block(texels, 18, 0, 6) + block(texels, 18, 12, 6) + block(texels, 18, 6, 6)
  | explain rgb-green-and-blue-exchanged
block(texels, 18, 0, 6) + block(texels, 18, 6, 6) + block(texels, 18, 12, 6) | texels
  | explain rgb-eighteen-interleaved
block(texels, 18, 0, 6) + block(texels, 18, 6, 6) + block(texels, 18, 12, 6)
  | b"".join(block(texels, 18, i, 1) for i in range(18)) | explain rgb-eighteen-planes
return header(request), block(texels, 9, 0, 6) + block(texels, 9, 6, 3) | return header(request), texels
  | explain lrgb-nine-interleaved
return header(request), block(texels, 9, 0, 6) + block(texels, 9, 6, 3)
  | return header(request), block(texels, 9, 6, 3) + block(texels, 9, 0, 6) | explain color-block-first
return header(request), block(texels, 9, 0, 6) + block(texels, 9, 6, 3)
  | return header(request), b"".join(block(texels, 9, i, 1) for i in range(9)) | explain lrgb-nine-planes
return header(request), block(texels, 9, 0, 6) + block(texels, 9, 6, 3)
  | return header(request), block(texels, 9, 0, 6) + block(texels, 9, 8, 1) + block(texels, 9, 7, 1) + block(texels, 9, 6, 1)
  | colors-in-planes
line(request["matrix"]), texels | line(request["matrix"]), block(texels, 8, 0, 6) + block(texels, 8, 6, 2)
  | explain lum-two-blocks
line(request["matrix"]), texels | line(request["matrix"]), b"".join(block(texels, 8, i, 1) for i in range(8))
  | explain lum-planar
+ line(request["matrix"]), texels | , texels | clause 2.6
line(request["matrix"]), texels | line(request["matrix"][4 * (i % 4) + i // 4] for i in range(16)), texels
  | clause 2.6
+ line(request["bias"]) | + line(min(max(b, 0), 255) for b in request["bias"]) | explain bias-clamped
+ line(request["bias"]) | + line(max(b, 0) for b in request["bias"]) | explain bias-not-negative
+ line(request["bias"]) | + line(min(b, 255) for b in request["bias"]) | explain bias-at-most-255
+ line(request["bias"]) | + line(b % 256 for b in request["bias"]) | explain bias-in-a-byte
+ line(request["bias"]) | + line(abs(b) for b in request["bias"]) | explain bias-sign-lost
+ line(request["bias"]) | + line(-b for b in request["bias"]) | explain bias-added
+ line(request["bias"]) | + line(0 for b in request["bias"]) | explain bias-ignored
+ line(request["bias"]) | + line(b / 255 for b in request["bias"]) | clause 2.4
+ line(request["scale"]) | + line(round(s, 3) for s in request["scale"]) | explain scale-with-three-decimals
+ line(request["scale"]) | + " ".join("%f" % s for s in request["scale"]) + "\n" | clause 2.4/3
+ line(request["scale"]) | + line(abs(s) for s in request["scale"]) | explain scale-sign-lost
+ line(request["scale"]) | + line(1 / s if s else 0 for s in request["scale"]) | explain scale-divides
+ line(request["scale"]) | + line(reversed(request["scale"])) | explain scales-reversed
"%d\n%d\n" % (request["width"], request["height"]) | "%d\n%d\n" % (request["height"], request["width"])
  | explain height-before-width
"PTM_1.2\n" | "PTM_1.1\n" | clause 2.1/1
request["format"] + "\n" | request["format"].lower() + "\n" | explain format-in-any-case
text.encode("ascii") + payload | (text.encode("ascii") + payload).replace(b"\n", b"\r\n") | clause 2
text.encode("ascii") + payload | text.encode("ascii") + payload.replace(b"\n", b"\r\n") | explain text-mode
text.encode("ascii") + payload | text.encode("ascii") + b"\n" + payload | line-
text.encode("ascii") + payload | text.encode("ascii") + payload.rstrip(b"\0") | zero
payload = b"".join(table) | payload = b"".join(bytes(entry[i] for entry in table) for i in range(entry_size))
  | explain table-in-planes
payload += block(texels, 9, 6, 3) | payload += b"".join(block(texels, 9, i, 1) for i in (6, 7, 8))
  | explain lut-colors-in-planes
"#;

/// Returns true if `check-writer` exits with 1 for the copy and the first cause contains `words`.
fn is_diagnosed([find, replace, words]: &[String; 3]) -> bool {
    let source = repository_text("examples/writers/ptm_writer.py");
    let here = Workspace::new();
    here.write("writer.py", edit(&source, find, replace));
    let checked = here.check_writer("--smoke -- python3 writer.py");
    let mut parts = checked.text.split("\n\n");
    let first = parts.find(|part| part.contains("failures: the writer"));
    let first = first.unwrap_or(&checked.text).lines().take(4);
    let first = first.collect::<Vec<_>>().join("\n");
    let named = checked.status == 1 && first.contains(words);
    if !named {
        println!("{replace}: {}: expected {words}\n{first}", checked.status);
    }
    named
}

#[test]
fn two_wrong_copies_of_the_python_writer_are_named() {
    if have_tool("python3") {
        let copies = rows(COPIES);
        for copy in [&copies[1], &copies[18]] {
            assert!(is_diagnosed(copy), "{copy:?}");
        }
    }
}

#[test]
#[ignore = "runs a Python writer forty times; takes minutes"]
fn forty_wrong_copies_of_the_python_writer_are_named() {
    if !have_tool("python3") {
        return;
    }
    let copies = rows(COPIES);
    assert!(copies.len() >= 40, "{}", copies.len());
    let named = copies.iter().filter(|copy| is_diagnosed(copy)).count();
    println!("{named} of {} named", copies.len());
    assert!(named >= 38, "{named} of {}", copies.len());
}
