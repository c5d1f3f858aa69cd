#!/usr/bin/env bash
# Packs the crate, installs it from the package, and runs `check` in an empty directory.
# CARGO_TARGET_DIR may be a target directory with compiled dependencies.
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
