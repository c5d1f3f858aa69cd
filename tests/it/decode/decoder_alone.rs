//! Tests the decoder on the corpus without any other crate. `cargo mutants` runs this test.
//!
//! `PTM_CORPUS` selects a different corpus, for example one with large files that `generate` wrote.

use std::path::PathBuf;

use ptm::decode::open;
use ptm::error::Class;
use ptm::{Ptm, decode};

/// A manifest entry. The manifest is parsed line by line.
#[derive(Default)]
struct Entry {
    id: String,
    file: String,
    expect: String,
    view: String,
    frame: String,
}

fn entries(manifest: &str) -> Vec<Entry> {
    let mut entries: Vec<Entry> = Vec::new();
    for line in manifest.lines() {
        if let Some(id) = line.strip_prefix("- id: ") {
            let id = id.to_owned();
            entries.push(Entry {
                id,
                ..Entry::default()
            });
        }
        let (Some(entry), Some((key, value))) = (entries.last_mut(), line.split_once(": ")) else {
            continue;
        };
        let field = match key {
            "  file" => &mut entry.file,
            "  expect" => &mut entry.expect,
            "    view" => &mut entry.view,
            "    file" => &mut entry.frame,
            _ => continue,
        };
        value.trim_matches('"').clone_into(field);
    }
    entries
}

/// Returns the samples of a map in a view, and their tolerance.
fn samples(ptm: &Ptm, view: &str) -> (Vec<f64>, f64) {
    let bytes = |bytes: &[u8]| bytes.iter().map(|&byte| f64::from(byte)).collect();
    match view.split_once(':') {
        Some((_, light)) => {
            let (lu, lv) = light.split_once(',').expect("a light has two numbers");
            let [lu, lv] = [lu, lv].map(|number| number.parse().expect("a number"));
            (bytes(&ptm.coefficients().evaluate(lu, lv).to_bytes()), 1.0)
        }
        None if view == "coef" => (ptm.coefficients().values.clone(), 0.0),
        None => (bytes(&ptm.planes.samples), 0.0),
    }
}

fn frame_samples(frame: &[u8]) -> Vec<f64> {
    let line = frame.iter().position(|&byte| byte == b'\n');
    let (line, samples) = frame.split_at(line.expect("a frame has a line") + 1);
    match line.ends_with(b"f32\n") {
        true => samples
            .chunks_exact(4)
            .map(|word| f64::from(f32::from_le_bytes(word.try_into().expect("four bytes"))))
            .collect(),
        false => samples.iter().map(|&byte| f64::from(byte)).collect(),
    }
}

/// Returns the reason why a result differs from the manifest, if it does.
fn mismatch(entry: &Entry, file: &[u8], frame: Option<Vec<u8>>) -> Option<String> {
    let outcome = decode(file);
    if let Ok(ptm) = &outcome {
        let stored = open(file).expect("a decodable file opens");
        let pieces = stored.pieces().flat_map(|piece| piece.planes.samples);
        if !pieces.eq(ptm.planes.samples.iter().copied()) {
            return Some("a different image, row by row".to_owned());
        }
    }
    match (entry.expect.as_str(), outcome) {
        ("decode" | "lenient", Ok(ptm)) => {
            let (samples, slack) = samples(&ptm, &entry.view);
            let received = frame_samples(&frame.expect("a frame next to its file"));
            let is_near = |(&a, &b): (&f64, &f64)| {
                (a - b).abs() <= slack || a as f32 == b as f32 || (a - b).abs() <= 1e-6 * b.abs()
            };
            let same =
                samples.len() == received.len() && samples.iter().zip(&received).all(is_near);
            (!same).then(|| "a different image".to_owned())
        }
        ("reject", Err(error)) if error.class() != Class::Malformed => Some(error.to_string()),
        ("decode", Err(error)) => Some(error.to_string()),
        ("reject" | "refuse", Ok(_)) => Some("accepted".to_owned()),
        _ => None,
    }
}

#[test]
fn every_file_has_the_result_of_the_manifest() {
    let corpus = std::env::var_os("PTM_CORPUS").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("corpus"),
        PathBuf::from,
    );
    let manifest = std::fs::read_to_string(corpus.join("MANIFEST.yaml")).expect("a manifest");
    let mut read = 0;
    for entry in entries(&manifest) {
        // The committed corpus does not contain its large files.
        let Ok(file) = std::fs::read(corpus.join(&entry.file)) else {
            continue;
        };
        let frame = std::fs::read(corpus.join(&entry.frame)).ok();
        let mismatch = mismatch(&entry, &file, frame);
        assert_eq!(mismatch, None, "{}", entry.id);
        read += 1;
    }
    assert!(read > 1000, "{read} files");
}
