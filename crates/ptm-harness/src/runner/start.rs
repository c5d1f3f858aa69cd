//! Explains why a program does not start, and how to fix the problem.
//!
//! The system's message ("no such file or directory") is often misleading: the file exists, but its interpreter does not.

use std::ffi::OsStr;
use std::fs;
use std::io::{self, Read};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

/// The reason why a program cannot be started, and a remedy.
pub(crate) type Obstacle = (String, String);

/// Returns an obstacle as an error.
fn obstacle(message: String, next: impl Into<String>) -> Result<(), Obstacle> {
    Err((message, next.into()))
}

/// Returns the message for `program`, which did not start because of `error`.
pub(crate) fn describe_start_failure(program: &OsStr, error: &io::Error) -> String {
    // The report contains the name of the program, but not its directory.
    let name = Path::new(program).file_name().unwrap_or(program);
    match check_program(program, &name.to_string_lossy()) {
        Err((says, next)) => format!("{says}; {next}"),
        Ok(()) if error.kind() == io::ErrorKind::NotFound => format!(
            "{}: the file exists, but its loader is missing; is the program built for a different C library? See ldd",
            name.display()
        ),
        Ok(()) => format!("{}: {error}", name.display()),
    }
}

/// Checks a program before it is started. `text` is the name of the program in messages. Returns the reason why the program
/// cannot be started, and a remedy.
pub(crate) fn check_program(word: &OsStr, text: &str) -> Result<(), Obstacle> {
    let here = Path::new(word);
    let is_path = word.as_encoded_bytes().contains(&b'/');
    let found = (!is_path).then(|| find_in_path(word)).flatten();
    if here.is_dir() && found.is_none() {
        return obstacle(
            format!("{text} is a directory"),
            "give the path of a program in the directory",
        );
    }
    if here.is_file() && here.extension().is_some_and(|suffix| suffix == "ptm") {
        return obstacle(
            format!("{text} is a PTM file, not a decoder"),
            format!("to check a file, run: ptm-conform lint {text}"),
        );
    }
    let Some(program) = (if is_path {
        Some(here.to_owned())
    } else {
        found
    }) else {
        if here.is_file() {
            let says = format!(
                "{text} is in this directory, but a name without a / is looked up only in PATH"
            );
            return obstacle(says, format!("write ./{text}"));
        }
        return Err(missing_command(text));
    };
    let Ok(about) = fs::metadata(&program) else {
        return obstacle(
            format!("{text}: no such file"),
            "check the path of the decoder",
        );
    };
    if !about.is_file() {
        return obstacle(
            format!("{text} is a device, a pipe or a socket, not a program"),
            "give the path of the decoder after --, for example -- ./my-decoder",
        );
    }
    let beginning = read_beginning(&program);
    if about.permissions().mode() & 0o111 == 0 {
        if let Some(language) = source_language(text) {
            return Err(source_code_obstacle(text, language));
        }
        return Err((
            format!("{text} is not executable"),
            match interpreter_for(text) {
                Some(interpreter) => {
                    format!(
                        "run chmod +x {text}, or name the interpreter too: -- {interpreter} {text}"
                    )
                }
                None => format!("chmod +x {text}"),
            },
        ));
    }
    check_beginning(text, &beginning)
}

/// Returns the file that a command without a directory names.
pub(crate) fn find_in_path(word: &OsStr) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    let mut files = std::env::split_paths(&path).map(|directory| directory.join(word));
    files.find(|file| file.is_file())
}

/// Returns the message and the remedy for a command that was not found. The command may be several words passed as one.
fn missing_command(text: &str) -> Obstacle {
    let next = if text.contains(' ') {
        format!(
            "the command consists of several words; write them without quotation marks: -- {text}"
        )
    } else {
        "give the path of the decoder after --, for example -- ./my-decoder".to_owned()
    };
    ("no program with this name is in PATH".to_owned(), next)
}

/// Returns the first bytes of a file, or nothing if the file cannot be read. An unreadable file may still be executable.
fn read_beginning(path: &Path) -> Vec<u8> {
    let mut bytes = Vec::new();
    if fs::metadata(path).is_ok_and(|about| about.is_file()) {
        let _ = fs::File::open(path).and_then(|file| file.take(512).read_to_end(&mut bytes));
    }
    bytes
}

/// First bytes of files that this system cannot execute, with the file type and a remedy.
const FOREIGN_FILE_KINDS: [(&[u8], &str, &str); 6] = [
    (
        b"MZ",
        "a Windows program",
        "run the decoder with wine (-- wine my-decoder.exe), or run it on Windows with an exported corpus: ptm-conform generate --help",
    ),
    (b"\xcf\xfa\xed\xfe", MACH_O, MACH_O_REMEDY),
    (b"\xce\xfa\xed\xfe", MACH_O, MACH_O_REMEDY),
    (b"\xca\xfe\xba\xbe", MACH_O, MACH_O_REMEDY),
    (
        b"PK\x03\x04",
        "an archive",
        "run a jar with java: -- java -jar my-decoder.jar",
    ),
    (
        b"\xef\xbb\xbf#!",
        "a script that begins with a byte order mark, which hides its #! line",
        "save the script as UTF-8 without a byte order mark",
    ),
];

const MACH_O: &str = "a macOS program, or a Java class";
const MACH_O_REMEDY: &str = "build the program for this system; run a Java class file with java";

/// Checks the first bytes of a file, which determine how the system executes it.
fn check_beginning(text: &str, beginning: &[u8]) -> Result<(), Obstacle> {
    if beginning.is_empty() {
        return obstacle(format!("{text} is empty"), "write the decoder first");
    }
    if let Some(line) = beginning.strip_prefix(b"#!") {
        return check_first_line(text, line);
    }
    if let [0x7f, b'E', b'L', b'F', ..] = beginning {
        return check_elf(text, beginning);
    }
    let mut kinds = FOREIGN_FILE_KINDS.iter();
    let kind = kinds.find(|(first, name, _)| {
        beginning.starts_with(first) && (*name != MACH_O || cfg!(target_os = "linux"))
    });
    Err(if let Some((_, name, next)) = kind {
        (format!("{text} is {name}"), (*next).to_owned())
    } else if let Some(language) = source_language(text) {
        source_code_obstacle(text, language)
    } else {
        let interpreter = interpreter_for(text).unwrap_or("python3");
        (
            format!("{text} has no #! line, so the system does not know its interpreter"),
            format!(
                "begin the script with #!/usr/bin/env {interpreter}, or name the interpreter: -- {interpreter} {text}"
            ),
        )
    })
}

/// Checks the rest of a line that begins with `#!`. `line` starts after `#!` and may extend past the end of that line.
fn check_first_line(text: &str, line: &[u8]) -> Result<(), Obstacle> {
    let end = line.iter().position(|&byte| byte == b'\n');
    let line = &line[..end.unwrap_or(line.len())];
    if line.ends_with(b"\r") {
        return obstacle(
            format!(
                "the first line of {text} ends in CR LF, and the CR becomes part of the interpreter's name"
            ),
            "save the script with LF line endings (dos2unix)",
        );
    }
    let line = String::from_utf8_lossy(line);
    let interpreter = line.split_whitespace().next().unwrap_or_default();
    if !Path::new(interpreter).is_file() {
        return obstacle(
            format!(
                "the first line of {text} names the interpreter {interpreter:?}, which does not exist"
            ),
            "name an interpreter that exists, for example #!/usr/bin/env python3",
        );
    }
    Ok(())
}

fn check_elf(text: &str, beginning: &[u8]) -> Result<(), Obstacle> {
    let Some(&[low, high]) = beginning.get(18..20) else {
        return Ok(());
    };
    let machine = match beginning[5] {
        2 => u16::from_be_bytes([low, high]),
        _ => u16::from_le_bytes([low, high]),
    };
    let bits = if beginning[4] == 1 { 32 } else { 64 };
    let (name, ours) = machine_name(machine);
    if ours {
        return Ok(());
    }
    obstacle(
        format!("{text} is a program for a different machine: {name}, {bits} bits"),
        "build the program for this machine, or run it in an emulator: -- qemu-aarch64 ./my-decoder",
    )
}

/// Returns the name of an ELF machine, and whether this system can execute programs for that machine.
fn machine_name(machine: u16) -> (String, bool) {
    let known = [
        (3, "x86"),
        (8, "mips"),
        (20, "powerpc"),
        (21, "powerpc64"),
        (22, "s390x"),
        (40, "arm"),
        (62, "x86_64"),
        (183, "aarch64"),
        (243, "riscv64"),
        (258, "loongarch64"),
    ];
    let known = known.into_iter().find(|(number, _)| *number == machine);
    let Some((_, name)) = known else {
        return (format!("machine {machine}"), true);
    };
    // 64-bit machines can also execute programs for their 32-bit predecessors. The system decides about unknown machines.
    let ours = std::env::consts::ARCH;
    let runs = [("x86_64", "x86"), ("aarch64", "arm")].contains(&(ours, name));
    (name.to_owned(), name == ours || runs)
}

/// Returns the interpreter for a script, based on its extension.
fn interpreter_for(text: &str) -> Option<&'static str> {
    Some(match text.rsplit_once('.')?.1 {
        "py" => "python3",
        "js" | "mjs" => "node",
        "rb" => "ruby",
        "pl" => "perl",
        "sh" => "sh",
        "lua" => "lua",
        "R" => "Rscript",
        "jl" => "julia",
        "php" => "php",
        _ => return None,
    })
}

fn source_code_obstacle(text: &str, language: &str) -> Obstacle {
    (
        format!("{text} is {language} source code, not a program"),
        "compile it, and name the resulting program".to_owned(),
    )
}

/// Returns the language of a source file that must be compiled, based on its extension.
fn source_language(text: &str) -> Option<&'static str> {
    Some(match text.rsplit_once('.')?.1 {
        "c" => "C",
        "cc" | "cpp" | "cxx" => "C++",
        "cs" => "C#",
        "go" => "Go",
        "java" => "Java",
        "kt" => "Kotlin",
        "rs" => "Rust",
        "swift" => "Swift",
        "ts" => "TypeScript",
        _ => return None,
    })
}

pub(crate) fn is_script_name(text: &str) -> bool {
    let other = [".jar", ".class", ".exe", ".dll"];
    interpreter_for(text).is_some() || other.iter().any(|suffix| text.ends_with(suffix))
}
