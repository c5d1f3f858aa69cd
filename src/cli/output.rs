//! Output functions: colored text, YAML or JSON for other programs, and progress bars.

use std::borrow::Cow;
use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use clap::{Args, ColorChoice};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use terminal_size::{Height, Width};
use textwrap::{Options, WordSeparator, WordSplitter};

use ptm_suite::kit::{strip_os_error_code, yaml::to_yaml};

/// Options common to all commands.
#[derive(Args)]
pub struct GlobalArgs {
    /// Color: auto (on a terminal, unless NO_COLOR is set), always or never.
    #[arg(long, global = true, value_name = "WHEN", default_value = "auto")]
    #[arg(hide_possible_values = true, help_heading = "Global options")]
    color: ColorChoice,
    /// Print only results and errors: no progress, notes or summaries.
    #[arg(short, long, global = true, help_heading = "Global options")]
    quiet: bool,
}

/// Options for machine-readable output.
#[derive(Args)]
pub struct MachineFormatArgs {
    /// Print YAML.
    #[arg(long, conflicts_with = "json")]
    pub yaml: bool,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

static QUIET: AtomicBool = AtomicBool::new(false);

impl GlobalArgs {
    /// Applies the options to the rest of the run.
    pub fn apply(&self) {
        QUIET.store(self.quiet, Relaxed);
        let choice = match self.color {
            ColorChoice::Auto => anstream::ColorChoice::Auto,
            ColorChoice::Always => anstream::ColorChoice::Always,
            ColorChoice::Never => anstream::ColorChoice::Never,
        };
        choice.write_global();
    }
}

/// Returns true if only results and errors should be printed.
pub fn is_quiet() -> bool {
    QUIET.load(Relaxed)
}

/// Prints text to standard output, in color if requested. A closed pipe is not an error.
pub fn print(text: &str) {
    let _ = anstream::stdout().write_all(text.as_bytes());
}

/// Returns an error if results were lost, for example because a disk is full. A closed pipe is not an error.
pub fn check_written(written: io::Result<()>) -> Result<(), String> {
    match written {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            let error = strip_os_error_code(&error);
            Err(format!("cannot write the results: {error}"))
        }
        _ => Ok(()),
    }
}

/// Prints a message to standard error, wrapped to the width of the terminal. A closed pipe is not an error.
pub fn print_error(text: &str) {
    let width = columns(terminal_size::terminal_size_of(std::io::stderr()));
    let lines = text.lines().flat_map(|line| wrap_line(line, width));
    let lines: String = lines.map(|line| line + "\n").collect();
    let _ = std::io::stderr().write_all(lines.as_bytes());
}

/// Prints a note unless `--quiet` is given.
pub fn print_note(text: &str) {
    if !is_quiet() {
        print(text);
    }
}

impl MachineFormatArgs {
    /// Prints `value` as YAML or JSON if either is requested. Returns true if it was printed.
    pub fn print(&self, value: &impl Serialize) -> Result<bool, String> {
        if self.yaml {
            print(&to_yaml(value)?);
        } else if self.json {
            let json = serde_json::to_string_pretty(value).map_err(|error| error.to_string())?;
            print(&(json + "\n"));
        }
        Ok(self.yaml || self.json)
    }
}

/// Returns the requested number of workers. The default is the available parallelism of the machine.
pub fn jobs(requested: Option<usize>) -> Result<usize, String> {
    match requested {
        Some(0) => Err("--jobs must be at least 1".to_owned()),
        Some(jobs) => Ok(jobs),
        None => Ok(std::thread::available_parallelism().map_or(1, usize::from)),
    }
}

/// Creates a progress bar on standard error. The bar is hidden if standard error is not a terminal or `--quiet` is given.
pub fn bar(length: Option<u64>, template: &str) -> ProgressBar {
    let bar = match (is_quiet(), length) {
        (true, _) => ProgressBar::hidden(),
        (false, Some(length)) => ProgressBar::new(length),
        (false, None) => ProgressBar::no_length(),
    };
    bar.with_style(ProgressStyle::with_template(template).expect("the template is well-formed"))
}

/// Runs `work` with a progress bar. `work` reports the number of finished items and the total.
pub fn with_progress<T>(work: impl FnOnce(&(dyn Fn(usize, usize) + Sync)) -> T) -> T {
    let bar = bar(Some(0), "{bar:40} {pos}/{len} {elapsed}");
    let result = work(&|done, all| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
    });
    bar.finish_and_clear();
    result
}

/// Minimum width for wrapped text.
const MIN_COLUMNS: usize = 40;

/// Returns the width in columns at which to wrap text, or `None` if there is no terminal.
pub fn columns(size: Option<(Width, Height)>) -> Option<usize> {
    size.map(|(width, _)| usize::from(width.0).max(MIN_COLUMNS))
}

/// Wraps a line at `width` and indents the continuation lines.
pub fn wrap_line(line: &str, width: Option<usize>) -> Vec<Cow<'_, str>> {
    let indent = line.len() - line.trim_start_matches(' ').len();
    // A command is not wrapped, so that it can be copied.
    let Some(width) = width.filter(|_| !line[indent..].starts_with("$ ")) else {
        return vec![line.into()];
    };
    let hanging = " ".repeat(indent + 2);
    let options = Options::new(width)
        .subsequent_indent(&hanging)
        .word_separator(WordSeparator::AsciiSpace)
        .word_splitter(WordSplitter::NoHyphenation)
        .break_words(false);
    let lines = textwrap::wrap(line, options).into_iter();
    lines.map(|line| Cow::Owned(line.into_owned())).collect()
}
