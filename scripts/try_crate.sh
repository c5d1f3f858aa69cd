#!/usr/bin/env bash
# Packs the crate, installs it from the packed file in an empty directory, and runs `check` there.
# CARGO_TARGET_DIR may name a target directory whose dependencies are built already.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo package --quiet --allow-dirty --no-verify
crates=(target/package/ptm-conform-*.crate)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
tar -C "$work" -xzf "${crates[-1]}"
mkdir "$work/empty"
cargo install --quiet --locked --debug --path "$work"/ptm-conform-* --root "$work/installed"
cd "$work/empty"
"$work/installed/bin/ptm-conform" check
