#!/usr/bin/env bash
# Packs all crates, installs the program from the packages, and runs `check` in an empty directory.
# CARGO_TARGET_DIR may be a target directory with compiled dependencies.
set -euo pipefail
cd "$(dirname "$0")/.."
rm -f target/package/ptm*.crate
cargo package --quiet --allow-dirty --no-verify --workspace
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
patches=()
for crate in target/package/ptm*.crate; do
    tar -C "$work" -xzf "$crate"
    folder=$(basename "$crate" .crate)
    name=${folder%-*}
    [ "$name" = ptm-conform ] || patches+=(--config "patch.crates-io.$name.path=\"$work/$folder\"")
done
mkdir "$work/empty"
cargo install --quiet --debug "${patches[@]}" --path "$work"/ptm-conform-* --root "$work/installed"
cd "$work/empty"
"$work/installed/bin/ptm-conform" check
