#!/usr/bin/env bash
# Packs a compiled program and tests the archive: scripts/pack.sh DIRECTORY TARGET VERSION OUT
# DIRECTORY contains ptm-conform. Writes OUT/ptm-conform-VERSION-TARGET.tar.gz, or .zip for Windows, as `cargo binstall` expects.
set -euo pipefail
directory=$1 target=$2 version=$3 out=$4
root=$(cd "$(dirname "$0")/.." && pwd)
name=ptm-conform-$version-$target
suffix=
case $target in *windows*) suffix=.exe ;; esac
program=$directory/ptm-conform$suffix

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/$name/completions" "$out"
cp "$program" "$root"/README.md "$root"/CHANGELOG.md "$root"/CITATION.cff "$root"/LICENSE-* "$work/$name"
# The WebAssembly module of the page for dropped files, if it is compiled.
module=$root/packages/wasm/target/wasm32-unknown-unknown/release/ptm_conform_wasm.wasm
[ ! -f "$module" ] || cp "$module" "$work/$name"
"$program" --quiet man "$work/$name/man"
for shell in bash zsh fish powershell; do
    "$program" completions "$shell" > "$work/$name/completions/ptm-conform.$shell"
done
if [ -n "$suffix" ]; then
    (cd "$work" && 7z a -bso0 "$name.zip" "$name")
    mv "$work/$name.zip" "$out"
    archive=$out/$name.zip
else
    tar -C "$work" -czf "$out/$name.tar.gz" "$name"
    archive=$out/$name.tar.gz
fi

# Test the archive in an empty directory.
mkdir "$work/tested"
case $archive in
    *.zip) 7z x -bso0 "-o$work/tested" "$archive" ;;
    *) tar -C "$work/tested" -xzf "$archive" ;;
esac
tested=$work/tested/$name/ptm-conform$suffix
"$tested" --version
"$tested" inspect "$root/corpus/lrgb/first-lrgb.ptm" > /dev/null
"$tested" lint "$root/corpus/lrgb/first-lrgb.ptm"
# `check` exists only on Unix.
if [ -z "$suffix" ]; then
    (cd "$work/tested" && "./$name/ptm-conform" --quiet check)
fi
echo "$archive"
