# Functions for the scripts of this folder. Each script begins with: . "$(dirname "$0")/tools.sh"
set -euo pipefail
script=$(realpath "$0")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

missing() {
    echo "skipped: $1"
    exit 77
}

# Installs packages from PyPI, as NAME==VERSION; afterwards "$python" has them.
python_packages() {
    command -v python3 > "$work/log" || missing "python3 is missing"
    python3 -m venv "$work/venv" > "$work/log" 2>&1 || missing "python3 -m venv does not work"
    python=$work/venv/bin/python
    "$python" -m pip install -q --disable-pip-version-check "$@" > "$work/log" 2>&1 || missing "pip cannot install $*: $(tail -n 1 "$work/log")"
}

# Installs packages from npm, as NAME@VERSION, in the folder "$work/node".
node_packages() {
    command -v npm > "$work/log" || missing "npm is missing"
    mkdir -p "$work/node"
    echo '{}' > "$work/node/package.json"
    install=(npm install --prefix "$work/node" --fetch-retries=0 --no-audit --no-fund "$@")
    # The second try trusts the certificates of the system.
    "${install[@]}" > "$work/log" 2>&1 || NODE_OPTIONS=--use-openssl-ca "${install[@]}" > "$work/log" 2>&1 || missing "npm cannot install $*: $(grep -m 1 'npm error' "$work/log")"
}

# Makes a Rust program in the folder "$work/rust". The arguments are its dependencies, as lines of TOML; standard input is its source.
rust_program() {
    command -v cargo > "$work/log" || missing "cargo is missing"
    mkdir -p "$work/rust/src"
    printf '%s\n' '[package]' 'name = "program"' 'version = "0.0.0"' 'edition = "2021"' '[dependencies]' "$@" > "$work/rust/Cargo.toml"
    cat > "$work/rust/src/main.rs"
}

# Compares standard input with the lines "# observed: …" of the script. Exits with 0 if they are equal, else with 1.
confirm() {
    sed -n 's/^# observed: //p' "$script" > "$work/observed"
    tee "$work/output"
    if diff "$work/observed" "$work/output" > "$work/diff"; then
        echo "as observed"
    else
        cat "$work/diff"
        echo "the behavior has changed"
        exit 1
    fi
}
