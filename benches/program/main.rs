//! Compares the program with other programs on the same bytes, as ratios within one run: `cargo bench --bench program`.
//!
//! With `-- cases`, it instead measures growth with the number of cases, up to 100,000 in one run.
//!
//! Times are processor times (user and system) of interleaved repetitions, so unrelated load and the speed of the machine
//! hardly matter. All files are in `/dev/shm`, and therefore in memory, if it exists.

mod cases;

#[path = "../common/mod.rs"]
mod common;

mod growth;

mod measure;

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use ptm::Format;

use measure::{Spent, measure_in_turn, memory_of_call, own_time, time_of};

const SIDE: u32 = 4096;

fn main() {
    if std::env::args().any(|word| word == "cases") {
        return cases::growth();
    }
    // A test run only builds this benchmark.
    if std::env::args().any(|word| word == "--test") {
        return;
    }
    let scratch = scratch();
    println!("# Uncompressed maps of {SIDE} x {SIDE} texels\n");
    println!(
        "The time of `reference raw FILE > OTHER` is divided by the time of `cp` for a file as large as the output. Memory is divided by the size of the output.\n"
    );
    println!(
        "| format | file, MB | output, MB | time / cp | wall-clock / cp | time / memcpy | memory / output |"
    );
    println!("|---|---|---|---|---|---|---|");
    for format in [
        Format::Lrgb,
        Format::Rgb,
        Format::Lum,
        Format::PtmLut,
        Format::PtmCLut,
    ] {
        compare_with_cp(format, scratch.path());
    }
    println!("\n# Compressed maps of {SIDE} x {SIDE} texels\n");
    for format in [Format::JpegLrgb, Format::JpeglsLrgb] {
        compare_with_decoders(format, scratch.path());
    }
    println!("# Growth with the number of texels\n");
    growth::in_texels(scratch.path());
}

fn scratch() -> tempfile::TempDir {
    let shm = Path::new("/dev/shm");
    let made = if shm.is_dir() {
        tempfile::tempdir_in(shm)
    } else {
        tempfile::tempdir()
    };
    made.expect("a scratch directory")
}

fn reference(view: &str, file: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ptm-conform"));
    command.args(["reference", view]).arg(file);
    command
}

fn write_file(directory: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    let path = directory.join(name);
    fs::write(&path, bytes).expect("space for a file");
    path
}

/// Measures a program whose standard output goes to a new file.
fn run_to_file(mut command: Command, out: &Path) -> Spent {
    let spent = time_of(command.stdout(File::create(out).expect("a file")));
    fs::remove_file(out).expect("the file exists");
    spent
}

fn compare_with_cp(format: Format, directory: &Path) {
    let file = write_file(directory, "map.ptm", &common::file(format, SIDE, SIDE));
    let bytes = SIDE as usize * SIDE as usize * format.channels();
    let same_size = write_file(directory, "same", &vec![7; bytes]);
    let out = directory.join("out");
    let mut source = vec![1_u8; bytes];
    let [ours, cp, memcpy] = measure_in_turn(
        9,
        &mut [
            &mut || run_to_file(reference("raw", &file), &out),
            &mut || {
                let mut cp = Command::new("cp");
                let spent = time_of(cp.arg(&same_size).arg(&out));
                fs::remove_file(&out).expect("the copy");
                spent
            },
            &mut || {
                source[0] ^= 1;
                own_time(|| {
                    std::hint::black_box(source.clone());
                })
            },
        ],
    );
    println!(
        "| {} | {:.0} | {:.0} | {:.1} | {:.1} | {:.1} | {:.2} |",
        format.short_name(),
        fs::metadata(&file).expect("the file").len() as f64 / 1e6,
        bytes as f64 / 1e6,
        ours.processor / cp.processor,
        ours.wall / cp.wall,
        ours.processor / memcpy.processor,
        memory_of_call(&mut reference("raw", &file)) as f64 / bytes as f64,
    );
}

fn compare_with_decoders(format: Format, directory: &Path) {
    let streams = common::streams(format, SIDE, SIDE);
    let file = write_file(directory, "map.ptm", &common::file(format, SIDE, SIDE));
    let bytes = SIDE as usize * SIDE as usize * format.channels();
    let is_jpeg = format == Format::JpegLrgb;
    let names: Vec<PathBuf> = streams
        .iter()
        .take(3)
        .enumerate()
        .map(|(i, stream)| {
            write_file(
                directory,
                &format!("plane-{i}.{}", if is_jpeg { "jpg" } else { "jls" }),
                stream,
            )
        })
        .collect();
    let out = directory.join("out");
    let bits = streams.iter().map(Vec::len).sum::<usize>() as f64 * 8.0 / bytes as f64;
    println!("## {}, {bits:.1} bits per sample\n", format.short_name());

    let [program, codec, crate_decoder, library] = measure_in_turn(
        5,
        &mut [
            &mut || run_to_file(reference("raw", &file), &out),
            &mut || own_time(|| streams.iter().for_each(|stream| decode(format, stream))),
            &mut || {
                own_time(|| {
                    if is_jpeg {
                        for stream in &streams {
                            let mut decoder = jpeg_decoder::Decoder::new(&stream[..]);
                            std::hint::black_box(decoder.decode().expect("a JPEG stream"));
                        }
                    }
                })
            },
            &mut || pillow(&names, format.channels() / 3).unwrap_or_default(),
        ],
    );
    let (library_name, crate_name) = if is_jpeg {
        ("libjpeg-turbo", "jpeg-decoder")
    } else {
        ("CharLS", "")
    };
    println!(
        "| compared with | the codec alone | `reference raw`, processor time | `reference raw`, wall-clock time |"
    );
    println!("|---|---|---|---|");
    let row = |name: &str, other: Spent| {
        println!(
            "| {name}, the same planes one after another | {:.2} | {:.2} | {:.2} |",
            codec.processor / other.processor,
            program.processor / other.processor,
            program.wall / other.wall,
        );
    };
    if library.processor > 0.0 {
        row(library_name, library);
    } else {
        println!(
            "SKIPPED: {library_name}, because python3 with Pillow and pillow-jpls is not installed"
        );
    }
    if is_jpeg {
        row(crate_name, crate_decoder);
    }
    println!(
        "\nmemory / output: {:.2}; threads: {}\n",
        memory_of_call(&mut reference("raw", &file)) as f64 / bytes as f64,
        std::thread::available_parallelism().map_or(1, usize::from),
    );
}

fn decode(format: Format, stream: &[u8]) {
    let coding = format.coding().expect("a compressed format");
    let samples = coding.decode(stream, SIDE, SIDE);
    std::hint::black_box(samples.expect("a complete stream"));
}

/// Decodes each file `times` times with Pillow on one thread. Returns `None` if this fails.
fn pillow(files: &[PathBuf], times: usize) -> Option<Spent> {
    const SCRIPT: &str = "
import io, sys, time
from PIL import Image
try: import pillow_jpls
except ImportError: pass
Image.MAX_IMAGE_PIXELS = None
streams = [open(name, 'rb').read() for name in sys.argv[2:]]
thread, wall = time.thread_time(), time.perf_counter()
for _ in range(int(sys.argv[1])):
    for stream in streams: Image.open(io.BytesIO(stream)).load()
print(time.thread_time() - thread, time.perf_counter() - wall)
";
    let mut python = Command::new("python3");
    python.args(["-c", SCRIPT, &times.to_string()]).args(files);
    let output = python.stderr(Stdio::null()).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    let (processor, wall) = text.trim().split_once(' ')?;
    Some(Spent {
        processor: processor.parse().ok()?,
        wall: wall.parse().ok()?,
    })
}
