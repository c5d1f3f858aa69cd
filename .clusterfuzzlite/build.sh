#!/bin/bash -eu
# Builds every target with its seeds, what it has found before, and its dictionary; ClusterFuzzLite and OSS-Fuzz call it alike.
cd "$SRC/ptm-conform"
cargo fuzz build -O
for target in fuzz/fuzz_targets/*.rs; do
    name=$(basename "$target" .rs)
    cp "fuzz/target/x86_64-unknown-linux-gnu/release/$name" "$OUT/"
    begin=("fuzz/seeds/$name")
    if [ -d "fuzz/finds/$name" ]; then begin+=("fuzz/finds/$name"); fi
    zip -jqr "$OUT/${name}_seed_corpus.zip" "${begin[@]}"
    cp fuzz/ptm.dict "$OUT/$name.dict"
done
