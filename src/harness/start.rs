//! Why a program does not start, and what to do about it.
//!
//! The system's own word for it ("no such file or directory") often names the wrong thing: the file is there, and what
//! is missing is its interpreter.

use std::ffi::OsStr;
use std::fs;
use std::io::{self, Read};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

/// What is wrong, and what to do.
pub(super) type Found = (String, String);

/// What to say of `program`, which did not start because of `error`.
pub(super) fn why_not(program: &OsStr, error: &io::Error) -> String {
    // Where it lies is nothing to report; its name is.
    let name = Path::new(program).file_name().unwrap_or(program);
    match look(program, &name.to_string_lossy()) {
        Err((says, next)) => format!("{error}: {says}; {next}"),
        Ok(()) if error.kind() == io::ErrorKind::NotFound => format!(
            "{error}: the file is there, so its loader is missing: is it built for another C library? See ldd"
        ),
        Ok(()) => error.to_string(),
    }
}

/// Looks at a program before it is started. `text` is what to call it.
///
/// # Errors
/// What keeps it from being started, and what to do.
pub(super) fn look(word: &OsStr, text: &str) -> Result<(), Found> {
    let here = Path::new(word);
    let is_path = word.as_encoded_bytes().contains(&b'/');
    if here.is_dir() {
        return Err((
            format!("{text} is a directory"),
            "name the program in it".to_owned(),
        ));
    }
    let Some(program) = (if is_path {
        Some(here.to_owned())
    } else {
        in_path(word)
    }) else {
        let (says, next) = if here.is_file() {
            (
                format!(
                    "{text} is in this directory, and programs without a / are looked up in PATH only"
                ),
                format!("write ./{text}"),
            )
        } else {
            missing(text, "no program of this name is in PATH")
        };
        return Err((says, next));
    };
    let Ok(about) = fs::metadata(&program) else {
        return Err(missing(text, &format!("{text}: no such file")));
    };
    let beginning = beginning(&program);
    if about.permissions().mode() & 0o111 == 0 {
        return Err((
            format!("{text} is not executable"),
            match interpreter_for(text) {
                Some(interpreter) => {
                    format!("chmod +x {text}, or name the interpreter too: -- {interpreter} {text}")
                }
                None => format!("chmod +x {text}"),
            },
        ));
    }
    look_at_beginning(text, &beginning)
}

/// A command that was not found: perhaps it is several words in one.
fn missing(text: &str, says: &str) -> Found {
    let next = if text.contains(' ') {
        format!("the command is several words: write them without quotation marks, -- {text}")
    } else {
        "name the decoder by a path such as ./my-decoder, after --".to_owned()
    };
    (says.to_owned(), next)
}

fn in_path(word: &OsStr) -> Option<PathBuf> {
    let directories = std::env::var_os("PATH")?;
    std::env::split_paths(&directories)
        .map(|directory| directory.join(word))
        .find(|path| path.is_file())
}

/// The first bytes of a file; none of one that cannot be read, which can run all the same.
fn beginning(path: &Path) -> Vec<u8> {
    let mut bytes = Vec::new();
    if fs::metadata(path).is_ok_and(|about| about.is_file()) {
        let _ = fs::File::open(path).and_then(|file| file.take(512).read_to_end(&mut bytes));
    }
    bytes
}

/// What the system needs to know to run a file stands at its beginning.
fn look_at_beginning(text: &str, beginning: &[u8]) -> Result<(), Found> {
    let found = |says: String, next: &str| Err((says, next.to_owned()));
    if let Some(line) = beginning.strip_prefix(b"#!") {
        let line = &line[..line
            .iter()
            .position(|&byte| byte == b'\n')
            .unwrap_or(line.len())];
        if line.ends_with(b"\r") {
            return found(
                format!(
                    "the first line of {text} ends in CR LF, and the CR is taken for a part of the interpreter's name"
                ),
                "save the script with line feeds alone (dos2unix)",
            );
        }
        let line = String::from_utf8_lossy(line);
        let interpreter = line.split_whitespace().next().unwrap_or_default();
        if !Path::new(interpreter).is_file() {
            return found(
                format!(
                    "the first line of {text} names the interpreter {interpreter:?}, which is not there"
                ),
                "name one that is, for example #!/usr/bin/env python3",
            );
        }
        return Ok(());
    }
    if let [0x7f, b'E', b'L', b'F', class, order, _, ..] = beginning
        && beginning.len() >= 20
    {
        let machine = [beginning[18], beginning[19]];
        let machine = if *order == 2 {
            u16::from_be_bytes(machine)
        } else {
            u16::from_le_bytes(machine)
        };
        let (name, ours) = machine_name(machine);
        if !ours {
            return found(
                format!(
                    "{text} is a program for another machine: {name}, {} bits",
                    if *class == 1 { 32 } else { 64 }
                ),
                "build it for this machine, or run it by an emulator: -- qemu-aarch64 ./my-decoder",
            );
        }
        return Ok(());
    }
    if beginning.starts_with(b"MZ") {
        return found(
            format!("{text} is a Windows program"),
            "run it by wine (-- wine my-decoder.exe), or run it there on an exported corpus: ptm-conform generate --help",
        );
    }
    let mach: [&[u8]; 3] = [
        b"\xcf\xfa\xed\xfe",
        b"\xce\xfa\xed\xfe",
        b"\xca\xfe\xba\xbe",
    ];
    if cfg!(target_os = "linux") && mach.iter().any(|first| beginning.starts_with(first)) {
        return found(
            format!("{text} is a macOS program, or a Java class"),
            "build it for this system; run a class by java",
        );
    }
    if beginning.starts_with(b"PK\x03\x04") {
        return found(
            format!("{text} is an archive"),
            "a jar is run by java: -- java -jar my-decoder.jar",
        );
    }
    if beginning.starts_with(b"\xef\xbb\xbf#!") {
        return found(
            format!("{text} begins with a byte order mark, which hides its #! line"),
            "save the script as UTF-8 without byte order mark",
        );
    }
    if beginning.is_empty() {
        return found(format!("{text} is empty"), "write the decoder first");
    }
    let interpreter = interpreter_for(text).unwrap_or("python3");
    found(
        format!("{text} has no #! line, so the system does not know what runs it"),
        &format!(
            "begin it with #!/usr/bin/env {interpreter}, or name the interpreter: -- {interpreter} {text}"
        ),
    )
}

/// The name of an ELF machine, and whether this program is of it.
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
    let name = known
        .iter()
        .find(|&&(number, _)| number == machine)
        .map(|&(_, name)| name);
    // A machine of 64 bits runs its forebear's programs too; what is not known is left to the system.
    let runs = [("x86_64", "x86"), ("aarch64", "arm")]
        .contains(&(std::env::consts::ARCH, name.unwrap_or_default()));
    let ours = name.is_none_or(|name| name == std::env::consts::ARCH) || runs;
    (
        name.map_or_else(|| format!("machine {machine}"), str::to_owned),
        ours,
    )
}

/// What runs a script, by its suffix.
fn interpreter_for(text: &str) -> Option<&'static str> {
    let suffixes = [
        (".py", "python3"),
        (".js", "node"),
        (".mjs", "node"),
        (".rb", "ruby"),
        (".pl", "perl"),
        (".sh", "sh"),
        (".lua", "lua"),
        (".R", "Rscript"),
        (".jl", "julia"),
        (".php", "php"),
    ];
    suffixes
        .iter()
        .find(|(suffix, _)| text.ends_with(suffix))
        .map(|&(_, interpreter)| interpreter)
}

pub(super) fn is_script_name(text: &str) -> bool {
    let other = [".jar", ".class", ".exe", ".dll"];
    interpreter_for(text).is_some() || other.iter().any(|suffix| text.ends_with(suffix))
}
