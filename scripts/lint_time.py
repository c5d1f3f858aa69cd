#!/usr/bin/env python3
"""Compares the processor time of `lint` with that of `openssl dgst -sha256`, and with an older `lint`.

    cargo build --release
    scripts/lint_time.py [--files N] target/release/ptm-conform [OLDER]

Writes N uncompressed files of 100 kB (default 20,000, which is 2 GB) to /dev/shm, LRGB and RGB in turn, with random texels. Prints a table
in Markdown: user and system time, medians of three interleaved runs, and the peak memory for N files and for a quarter of them.
With OLDER, also compares both programs on 200 compressed files.
"""

import argparse
import os
import pathlib
import shutil
import statistics
import subprocess
import tempfile

HEADER = "PTM_1.2\nPTM_FORMAT_%s\n%d\n%d\n1 1 1 1 1 1\n128 128 128 128 128 0\n"
ROUNDS = 3


def write_uncompressed(folder, first, count):
    for number in range(first, first + count):
        name, width, height, channels = (("LRGB", 110, 101, 9), ("RGB", 101, 55, 18))[number % 2]
        directory = folder / f"{number // 1000:03}"
        directory.mkdir(exist_ok=True)
        header = (HEADER % (name, width, height)).encode()
        (directory / f"{number:06}.ptm").write_bytes(header + os.urandom(width * height * channels))


def write_compressed(folder, program):
    """Writes 50 copies of a map of 256 x 256 texels in each of four compressed formats. Neighboring texels differ little."""
    side, rows = 256, []
    for y in range(side):
        for x in range(side):
            rows.append(bytes((x * (k + 3) // 4 + y * (9 - k) // 8 + (x ^ y) % (k + 2)) % 256 for k in range(18)))
    for name, channels in ("LRGB", 9), ("RGB", 18):
        if name == "LRGB":
            payload = b"".join(row[:6] for row in rows) + b"".join(row[6:9] for row in rows)
        else:
            payload = b"".join(row[6 * block:6 * block + 6] for block in range(3) for row in rows)
        source = folder / "source"
        source.write_bytes((HEADER % (name, side, side)).encode() + payload)
        for coding, options in ("JPEG", ["--quality", "90"]), ("JPEGLS", []):
            target = folder / f"{coding}_{name}-00.ptm"
            subprocess.run([program, "convert", "-q", source, "--to", f"{coding}_{name}", *options, "-o", target], check=True)
            for copy in range(1, 50):
                shutil.copy(target, folder / f"{coding}_{name}-{copy:02}.ptm")
        source.unlink()


def measure(command, folder):
    """Returns the processor time in seconds, and the peak memory in MB."""
    with open(os.devnull, "w") as null:
        process = subprocess.Popen(command, cwd=folder, stdout=null, stderr=null)
        _, status, used = os.wait4(process.pid, 0)
    if status != 0:
        raise SystemExit(f"{command[:2]} failed with {os.waitstatus_to_exitcode(status)}")
    return used.ru_utime + used.ru_stime, used.ru_maxrss / 1000


def medians(commands, folder):
    """Returns the median processor time of each command."""
    rounds = [[measure(command, folder)[0] for command in commands] for _ in range(ROUNDS)]
    return [statistics.median(times) for times in zip(*rounds)]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--files", type=int, default=20_000)
    parser.add_argument("program")
    parser.add_argument("older", nargs="?")
    arguments = parser.parse_args()
    program = os.path.abspath(arguments.program)
    with tempfile.TemporaryDirectory(dir="/dev/shm") as folder:
        folder = pathlib.Path(folder)
        needed, free = arguments.files * 101_000, shutil.disk_usage(folder).free
        if needed > free:
            raise SystemExit(f"{needed} bytes are needed in /dev/shm, but {free} are free; use --files")
        lint = [program, "lint", "-r", "--format", "jsonl", "."]
        quarter = arguments.files // 4
        write_uncompressed(folder, 0, quarter)
        _, memory_of_quarter = measure(lint, folder)
        write_uncompressed(folder, quarter, arguments.files - quarter)
        # A child process inherits the peak memory of this script, which the list of files increases.
        _, memory = measure(lint, folder)
        files = sorted(str(path.relative_to(folder)) for path in folder.rglob("*.ptm"))
        time, openssl_time = medians([lint, ["openssl", "dgst", "-sha256", *files]], folder)
        print("| files | `lint`, s | `openssl`, s | ratio | peak memory, MB | for a quarter of the files, MB |")
        print("|---|---|---|---|---|---|")
        print(f"| {len(files)} | {time:.2f} | {openssl_time:.2f} | {time / openssl_time:.2f} | {memory:.0f} | {memory_of_quarter:.0f} |")
    if arguments.older:
        with tempfile.TemporaryDirectory(dir="/dev/shm") as folder:
            write_compressed(pathlib.Path(folder), program)
            programs = [program, os.path.abspath(arguments.older)]
            now, before = medians([[one, "lint", "-r", "--format", "csv", "."] for one in programs], folder)
        print("\n| 200 compressed files | older, s | now, s | ratio |\n|---|---|---|---|")
        print(f"| `lint --format csv` | {before:.2f} | {now:.2f} | {now / before:.2f} |")


if __name__ == "__main__":
    main()
