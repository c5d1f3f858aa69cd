//! Tests the examples that render with OpenGL, on Mesa's llvmpipe.

use std::process::Command;

use crate::common::{
    assert_contains, check, have_python, outcome, python_example, repository, skip, starts,
};

/// Chooses llvmpipe, also on a machine with a GPU.
const LLVMPIPE: &str = "env LIBGL_ALWAYS_SOFTWARE=1 GALLIUM_DRIVER=llvmpipe";

/// Returns true if EGL gives a context of llvmpipe. Prints SKIPPED if not.
fn have_llvmpipe() -> bool {
    let units = python_example("gpu/units.py");
    have_python(&["moderngl", "numpy"])
        && (starts(&format!("{LLVMPIPE} {units} | grep -q llvmpipe"))
            || skip("python3 with EGL and Mesa's llvmpipe"))
}

#[test]
fn shader_writes_correct_colors() {
    if !have_llvmpipe() {
        return;
    }
    let decoder = python_example("gpu/ptm_shader.py");
    for target in ["rgba8", "rgba16f", "rgba32f --truncate"] {
        let line = format!(
            "--view rgb --clause 1.0 --clause 2.7 -- {LLVMPIPE} {decoder} --target {target}"
        );
        let checked = check(&line);
        checked.assert_exit(0, "");
        assert!(checked.cases("pass").len() > 100, "{}", checked.text);
    }
}

#[test]
fn texture_unit_samples_correctly() {
    if !have_llvmpipe() {
        return;
    }
    let stage = python_example("gpu/texture_stage.py");
    let line = format!("--suite texture --clause R-SMP-05 --clause R-BND-05 -- {LLVMPIPE} {stage}");
    let checked = check(&line);
    checked.assert_exit(0, "");
    assert!(checked.cases("pass").len() > 20, "{}", checked.text);
}

#[test]
fn emulated_weights_of_8_bits_are_within_the_tolerance() {
    if !have_python(&["numpy"]) {
        return;
    }
    let stage = python_example("gpu/texture_stage.py");
    let line = format!("--suite texture --clause R-SMP-05 -- {stage} --unit emulated");
    check(&line).assert_exit(0, "");
}

#[test]
fn tables_are_measured_without_check() {
    if !have_llvmpipe() {
        return;
    }
    let output = Command::new("python3")
        .arg(repository("examples/gpu/measure.py"))
        .args(["--no-check", "--program", env!("CARGO_BIN_EXE_ptm-conform")])
        .output();
    let (status, text) = outcome(&output.expect("the program starts"));
    assert_eq!(status, 0, "{text}");
    assert_contains(
        &text,
        "| llvmpipe, RGBA8 framebuffer | && | softpipe, RGBA8 framebuffer |",
    );
}

/// The programs say what is missing, and end with 77, as the scripts of `findings/` do.
#[test]
fn missing_devices_are_named() {
    if !have_python(&["numpy"]) || starts("python3 -c 'import cupy, torch'") {
        return;
    }
    for (program, argument) in [("units.py", "cuda"), ("nvjpeg_planes.py", "capabilities")] {
        let output = Command::new("python3")
            .args([&repository(&format!("examples/gpu/{program}")), argument])
            .output();
        let (status, text) = outcome(&output.expect("the program starts"));
        assert_eq!(status, 77, "{text}");
        assert_contains(&text, "skipped: ");
    }
}
