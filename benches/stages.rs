//! Separate benchmarks of the decoder, the codecs and the generator: `cargo bench --bench stages`.

// Criterion's macro generates a public function without documentation.
#![expect(missing_docs)]

mod common;

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};

use ptm::codec::{jpeg, jpeg_ls};
use ptm::{Format, Size};
use ptm_generate::{Model, Recipe, write};

const SIDE: u32 = 512;

fn decoder(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("decode");
    for format in Format::ALL {
        let file = common::file(format, SIDE, SIDE);
        group.throughput(Throughput::Elements(u64::from(SIDE * SIDE)));
        group.bench_with_input(
            BenchmarkId::from_parameter(format.short_name()),
            &file,
            |b, file| {
                b.iter(|| ptm::decode(black_box(file)).expect("a legal file"));
            },
        );
    }
    group.finish();

    let ptm = ptm::decode(&common::file(Format::Lrgb, SIDE, SIDE)).expect("a legal file");
    criterion.bench_function("coefficients", |b| {
        b.iter(|| black_box(&ptm).coefficients());
    });
    let coefficients = ptm.coefficients();
    criterion.bench_function("evaluate", |b| {
        b.iter(|| black_box(&coefficients).evaluate(0.25, -0.5));
    });
}

fn codecs(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("codec");
    group.throughput(Throughput::Elements(u64::from(SIDE * SIDE)));
    let samples = common::plane(SIDE, SIDE, 0);
    let options = jpeg::JpegOptions::new(90);
    let lossless = jpeg_ls::JpegLsOptions {
        near: 0,
        precision: 8,
        presets: None,
    };
    let jpeg_stream = jpeg::encode(&samples, SIDE, SIDE, &options).stream;
    let jpeg_ls_stream = jpeg_ls::encode(&samples, SIDE, SIDE, &lossless).stream;
    group.bench_function("jpeg decode", |b| {
        b.iter(|| jpeg::decode(black_box(&jpeg_stream), SIDE, SIDE));
    });
    group.bench_function("jpeg encode", |b| {
        b.iter(|| jpeg::encode(black_box(&samples), SIDE, SIDE, &options));
    });
    group.bench_function("jpeg_ls decode", |b| {
        b.iter(|| jpeg_ls::decode(black_box(&jpeg_ls_stream), SIDE, SIDE));
    });
    group.bench_function("jpeg_ls encode", |b| {
        b.iter(|| jpeg_ls::encode(black_box(&samples), SIDE, SIDE, &lossless));
    });
    group.finish();
}

fn generator(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("generate");
    let size = Size {
        width: 64,
        height: 64,
    };
    for format in Format::ALL {
        let recipe = Recipe::default_for(format, size);
        group.bench_with_input(
            BenchmarkId::from_parameter(format.short_name()),
            &recipe,
            |b, recipe| b.iter(|| write(recipe, &Model::paint(recipe))),
        );
    }
    group.finish();
}

criterion_group!(stages, decoder, codecs, generator);
criterion_main!(stages);
