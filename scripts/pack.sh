#!/usr/bin/env bash
# Packs a program that is built, and tries what it packed: scripts/pack.sh DIRECTORY TARGET VERSION OUT
# DIRECTORY holds ptm-conform; OUT gets ptm-conform-VERSION-TARGET.tar.gz, for Windows .zip, as `cargo binstall` expects.
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
# The module of the page on which files can be dropped, if it is built.
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

# What was packed, in an empty directory.
mkdir "$work/tried"
case $archive in
    *.zip) 7z x -bso0 "-o$work/tried" "$archive" ;;
    *) tar -C "$work/tried" -xzf "$archive" ;;
esac
tried=$work/tried/$name/ptm-conform$suffix
"$tried" --version
"$tried" inspect "$root/corpus/lrgb/first-lrgb.ptm" > /dev/null
"$tried" lint "$root/corpus/lrgb/first-lrgb.ptm"
# Without a Unix system `check` is not there.
if [ -z "$suffix" ]; then
    (cd "$work/tried" && "./$name/ptm-conform" --quiet check)
fi
echo "$archive"
