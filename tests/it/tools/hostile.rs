//! Tests that the file tools terminate for any file.

use proptest::prelude::*;
use ptm::Format;
use ptm_files::convert::{Target, convert};
use ptm_files::dissection::Dissection;
use ptm_files::{diff, export, render};
use ptm_files::{inspect::inspect, lint::codes::Severity, lint::lint};
use ptm_generate::{Model, Recipe, write};
use ptm_suite::cases::{Suite, TableSpelling};
use ptm_suite::kit::yaml::to_yaml;

/// Runs every tool on a file and asserts that the results agree with those of the decoder.
fn run_all_tools(file: &[u8]) {
    let dissection = Dissection::parse(file);
    let decoded = ptm::decode(file);
    assert_eq!(dissection.outcome, decoded);
    let inspection = inspect(file);
    assert_eq!(inspection.error.is_some(), decoded.is_err());
    let _ = (
        inspection.to_text("x", false),
        inspection.to_text("x", true),
    );
    to_yaml(&inspection).expect("YAML");
    let findings = lint(file);
    let errors = findings.iter().any(|one| one.severity == Severity::Error);
    assert_eq!(errors, decoded.is_err());
    if let Ok(ptm) = decoded {
        export::exr(&ptm, 1.0).expect("a small map fits");
        let _ = render::normals(&ptm);
        render::sheet(&ptm, 2, 3).expect("a small map fits");
        for format in Format::ALL {
            let target = Target {
                format,
                quality: None,
                loss: 0,
            };
            if let Ok(converted) = convert(&dissection, &ptm, target) {
                let back = ptm::decode(&converted.bytes).expect("a legal file");
                let same_channels = back.planes.shape.channels() == ptm.planes.shape.channels();
                assert!(
                    !same_channels || diff::diff((file, &ptm), (&converted.bytes, &back)).same,
                    "{format}"
                );
            }
        }
    }
}

#[test]
fn tools_accept_every_small_file_of_the_suite() {
    for case in &Suite::load().expect("the suite loads").cases {
        let file = &case.build(TableSpelling::default()).file;
        // A must-refuse file may declare any size. Lint reports it without allocating the memory.
        if file.len() < 1024 {
            run_all_tools(file);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    #[test]
    fn tools_accept_any_edits_of_a_sound_file(
        format in 0..9_usize,
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..3_u8), 1..6),
    ) {
        let recipe = Recipe::default_for(Format::ALL[format], "4x3".parse().expect("a size"));
        let mut file = write(&recipe, &Model::paint(&recipe)).bytes;
        for (place, byte, edit) in edits {
            let at = place.index(file.len());
            match edit {
                0 => file[at] = byte,
                1 => file.insert(at, byte),
                _ => file.truncate(at.max(1)),
            }
        }
        run_all_tools(&file);
    }
}
