#!/usr/bin/env bash
# Compares two builds of the program: runs `check` with both on the same decoders, and prints the lines in which their reports,
# standard output or exit statuses differ.
#
#     cargo build --release --bins --examples
#     scripts/compare-verdicts.sh [--smoke] BEFORE AFTER
#
# The decoders are the reference, the programs of examples/zoo.rs, and every misreading in the catalog (examples/misread.rs, in
# serve mode). They are taken from the folder `examples` next to AFTER. --smoke runs only the smoke subset against the
# misreadings, and only every eighth of them. JOBS is the number of decoders that are compared at a time. OPTIONS is added to all
# command lines, for example "--html page.html --junit junit.xml". Exit status: 0 all reports are equal, 1 some differ.
set -euo pipefail
cd "$(dirname "$0")/.."

subset='' step=1
if [ "${1-}" = --smoke ]; then
    subset=--smoke step=8
    shift
fi
[ $# = 2 ] || { sed -n '2,/^set/s/^# \{0,1\}//p' "$0" >&2; exit 2; }
BEFORE=$(realpath "$1") AFTER=$(realpath "$2")
decoders=$(dirname "$AFTER")/examples
WORK=$(mktemp -d)
export BEFORE AFTER WORK
trap 'rm -rf "$WORK"' EXIT

# Prints the command lines of all runs, one per line, without the programs.
lines() {
    echo "check"
    echo "check --suite texture"
    echo "check-writer"
    echo "check-writer --fitter"
    # The tests list the zoo: names, exit status, options. Rows may continue on a second line. These programs answer differently
    # in every run: differs-each-time, and one that depends on which process is faster.
    local few
    few=$(sed -n '/^const FEW_CASES/,/;$/{s/^const.*= //;s/[";\\]//g;p;}' tests/it/runner/zoo.rs | tr -s '\n ' '  ')
    sed -n '/^const ANSWERING/,/^";/p; /^const STOPPED/,/^";/p; /^const SERVING/,/^"#;/p' tests/it/runner/zoo.rs |
        sed -e ':more' -e 'N; s/\n  / /; t more' -e 'P; D' |
        awk -F ' *\\| *' -v few="$few" -v zoo="$decoders/zoo" 'NF > 3 && $4 != "any" {
            count = split($1, kinds, " +")
            timeout = $3 ~ /--timeout/ ? "" : " --timeout 60"
            for (i = 1; i <= count; i++) if (kinds[i] != "differs-each-time")
                print "check", few, $3 timeout, "--", zoo, kinds[i]
        }'
    sed -n 's/^- slug: //p' spec-cases/misreadings.yaml | awk "NR % $step == 0" |
        sed "s|.*|check $subset --jobs 1 --timeout 60 --serve -- $decoders/misread &|"
}

# Runs both programs with one command line, whose number is the first argument.
compare() {
    local folder=$WORK/$1 program
    shift
    for program in before after; do
        mkdir -p "$folder/$program"
        (
            cd "$folder/$program"
            [ $program = before ] && path=$BEFORE || path=$AFTER
            # Patterns of cases must reach the program.
            set -f
            # shellcheck disable=SC2086 # a command line consists of words
            set -- $1
            command=$1
            shift
            "$path" "$command" --quiet --report report.yaml ${OPTIONS-} "$@" > output 2> /dev/null < /dev/null || echo $? > status
        )
    done
    if ! (cd "$folder" && diff -rU0 -I '^  version: ' -I '^  corpus: ' before after) > "$folder.diff"; then
        printf '== %s\n%s\n' "$1" "$(cut -c 1-300 "$folder.diff")"
        touch "$WORK/differs"
    fi
    rm -r "$folder"
}
export -f compare

[ -x "$decoders/zoo" ] && [ -x "$decoders/misread" ] || { echo "no decoders in $decoders" >&2; exit 2; }
lines | nl -w1 -s$'\n' | tr '\n' '\0' | xargs -0 -n2 -P "${JOBS:-2}" bash -c 'compare "$1" "$2"' compare
[ ! -e "$WORK/differs" ]
