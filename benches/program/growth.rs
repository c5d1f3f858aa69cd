//! Growth with the number of texels, from 1 Mi to 16 Mi.

use std::path::Path;
use std::process::Command;

use ptm::Format;
use ptm_suite::protocol::frame::View;

use crate::measure::{measure_in_turn, memory_of_call, slope};
use crate::{common, reference, run_to_file, write_file};

/// Widths and heights. Each size has twice as many texels as the previous one.
const SIZES: [(u32, u32); 5] = [
    (1024, 1024),
    (2048, 1024),
    (2048, 2048),
    (4096, 2048),
    (4096, 4096),
];

pub fn in_texels(directory: &Path) {
    println!(
        "Slopes in log-log scale for 1, 2, 4, 8 and 16 Mi texels, minus the values of a map with one texel. 1 means linear growth.\n"
    );
    println!("| format | view | time | memory |");
    println!("|---|---|---|---|");
    let raw = [
        Format::Lrgb,
        Format::PtmLut,
        Format::JpegLrgb,
        Format::JpeglsLrgb,
    ];
    let raw = raw.map(|format| (format, "raw"));
    let others = [(Format::Lrgb, "coef"), (Format::Lrgb, View::DEFAULT_RGB)];
    for (format, view) in raw.into_iter().chain(others) {
        measure_view(format, view, directory);
    }
}

fn measure_view(format: Format, view: &str, directory: &Path) {
    let out = directory.join("out");
    let command = |width, height| -> Command {
        let path = write_file(directory, "map.ptm", &common::file(format, width, height));
        reference(view, &path)
    };
    let spent = |width, height| {
        command(width, height);
        let map = directory.join("map.ptm");
        let [spent] = measure_in_turn(9, &mut [&mut || run_to_file(reference(view, &map), &out)]);
        spent.processor
    };
    let (time, memory) = (spent(1, 1), memory_of_call(&mut command(1, 1)) as f64);
    let times = SIZES.map(|(w, h)| (f64::from(w * h), spent(w, h) - time));
    let memories = SIZES.map(|(w, h)| {
        (
            f64::from(w * h),
            memory_of_call(&mut command(w, h)) as f64 - memory,
        )
    });
    println!(
        "| {} | {view} | {:.2} | {:.2} |",
        format.short_name(),
        slope(&times),
        slope(&memories)
    );
}
