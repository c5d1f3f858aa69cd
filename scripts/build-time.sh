#!/usr/bin/env bash
# Measures the processor time of a release build in an empty target directory, and the size of the program, and
# compares them with earlier figures. Run nothing else during the build.
set -euo pipefail
cd "$(dirname "$0")/.."

target=$(mktemp -d)
trap 'rm -rf "$target"' EXIT
cargo fetch --locked --quiet

TIMEFORMAT='%U %S %R'
read -r user system elapsed < <(
    { time CARGO_TARGET_DIR=$target cargo build --release --locked --offline --quiet 2> "$target/errors"; } 2>&1
)
[ -s "$target/release/ptm-conform" ] || { cat "$target/errors"; exit 1; }
size=$(wc -c < "$target/release/ptm-conform")

awk -v used="$(awk "BEGIN { print $user + $system }")" -v elapsed="$elapsed" -v size="$size" -v processors="$(nproc)" 'BEGIN {
    printf "cargo build --release, empty target directory, crates already fetched, %d processors\n", processors
    printf "                 now             before\n"
    printf "processor time   %3d min %02d s    5 min 09 s\n", used / 60, used % 60
    printf "wall-clock time  %3d min %02d s\n", elapsed / 60, elapsed % 60
    printf "program          %.1f MB         12.9 MB\n", size / 1e6
}'
