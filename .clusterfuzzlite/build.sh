#!/bin/bash -eu
# Builds every target with its seeds and its dictionary; ClusterFuzzLite and OSS-Fuzz call it alike.
cd "$SRC/ptm-conform"
cargo fuzz build -O
for target in fuzz/fuzz_targets/*.rs; do
    name=$(basename "$target" .rs)
    cp "fuzz/target/x86_64-unknown-linux-gnu/release/$name" "$OUT/"
    zip -jqr "$OUT/${name}_seed_corpus.zip" "fuzz/seeds/$name"
    cp fuzz/ptm.dict "$OUT/$name.dict"
done
