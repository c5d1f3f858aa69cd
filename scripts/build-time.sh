#!/usr/bin/env bash
# Compares the time from a fresh clone to the first verdict, and the time of the following steps, between two commits:
#
#     scripts/build-time.sh [OLD [NEW]]        # default: 22eed75b and HEAD
#
# Each commit is cloned into an empty folder, and every step runs once per commit, first OLD, then NEW. Run nothing else. Crates are
# downloaded before the measurements. Prints a table of seconds and ratios. Needs python3 for the decoders.
set -euo pipefail
cd "$(dirname "$0")/.."

old=${1:-22eed75b} new=${2:-HEAD}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
for commit in "$old" "$new"; do
    git clone --quiet . "$folder/$commit"
    git -C "$folder/$commit" checkout --quiet "$(git rev-parse "$commit")"
    cargo fetch --quiet --locked --manifest-path "$folder/$commit/Cargo.toml"
    # The first decoder of the README.
    sed -n '/^```python/,/^```/p' "$folder/$commit/README.md" | sed '1d;/^```/,$d' > "$folder/$commit/minimal.py"
done

# The commands that README names under "To verify your setup".
readme_command() { grep -m "$2" '^    cargo \(run\|test\)' "$folder/$1/README.md" | tail -1 | sed 's/#.*//'; }
program() { if [ -x "$folder/$1/target/release/ptm-conform" ]; then echo target/release/ptm-conform; else echo target/debug/ptm-conform; fi; }

first_verdict() { eval "$(readme_command "$1" 1)" | grep '^pass'; }
all_tests() { eval "$(readme_command "$1" 2)"; }
edit_and_test() {
    sed -i 's/unsupported (exit status 69): /unsupported, exit status 69: /' src/report/text.rs
    # Status 101: the test may check the message.
    cargo test --test it clause_and_section_options_select_cases || [ $? = 101 ]
}
check_minimal() { "$(program "$1")" check --report minimal.yaml -- python3 minimal.py; }
check_python() { "$(program "$1")" check --one-shot --report python.yaml -- python3 examples/decoders/ptm_decoder.py || [ $? = 1 ]; }
release_build() { cargo build --release --locked; }
check_reference() { target/release/ptm-conform check --report reference.yaml; }

TIMEFORMAT='%R %U %S'
printf '%-28s %10s %10s %7s\n' 'seconds' "$old" "$new" ratio
for step in first_verdict all_tests edit_and_test check_minimal check_python release_build check_reference; do
    times=()
    for commit in "$old" "$new"; do
        log=$folder/$commit.log
        [ $step != release_build ] || rm -rf "$folder/$commit/target/release"
        taken=$( { time (cd "$folder/$commit" && $step "$commit" > "$log" 2>&1) 2> /dev/null || echo "failed" >> "$log"; } 2>&1 )
        [ "$(tail -1 "$log")" != failed ] || { echo "$step failed at $commit:"; tail -20 "$log"; exit 1; }
        times+=("$taken")
    done
    # The processor time of a check counts, and the wall-clock time of everything else.
    awk -v step=$step -v old="${times[0]}" -v new="${times[1]}" 'BEGIN {
        split(old, o, " "); split(new, n, " ")
        is_check = step ~ /^check_/
        a = is_check ? o[2] + o[3] : o[1]; b = is_check ? n[2] + n[3] : n[1]
        printf "%-28s %10.1f %10.1f %7.2f\n", step (is_check ? " (CPU)" : ""), a, b, b / a
    }'
done
