//! `ptm-conform lint`

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::output::{self, Machine};
use super::{Outcome, files};
use ptm_conform::tools::lint::Lint;
use ptm_conform::tools::lint::codes::{ALL, Severity};

/// Say what is wrong with files, what other readers may make of them, and what their writer can mend.
///
/// Codes are stable: PTM-E… the file breaks a rule or the reference cannot read it, PTM-W… there are readers that refuse it
/// or show another picture, PTM-I… somebody may want to know. `ptm-conform explain PTM-W102` tells more of one.
///
/// Exit status: 0 no errors, 1 errors, 2 wrong usage or a file that cannot be opened.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform lint coin.ptm\n  ptm-conform lint --json maps/*.ptm\n  ptm-conform lint --allow PTM-W301 --allow PTM-W302 --deny-warnings table.ptm"
)]
pub struct LintArgs {
    /// PTM files.
    #[arg(required_unless_present = "codes")]
    files: Vec<PathBuf>,
    /// Codes not to mention. May be given more than once.
    #[arg(long, value_name = "CODE", value_parser = known_code)]
    allow: Vec<String>,
    /// Exit with 1 if there are warnings, too.
    #[arg(long)]
    deny_warnings: bool,
    /// List all codes and stop.
    #[arg(long)]
    codes: bool,
    #[command(flatten)]
    machine: Machine,
}

/// A code as it is listed.
#[derive(Serialize)]
struct Listed {
    code: &'static str,
    severity: Severity,
    clause: &'static str,
    says: &'static str,
    mend: &'static str,
    provoked_by: &'static [&'static str],
}

pub fn run(args: &LintArgs) -> Outcome {
    if args.codes {
        return list_codes(args);
    }
    let mut lints = Vec::new();
    let mut unreadable = false;
    for path in &args.files {
        match files::read(path) {
            Ok(file) => {
                let lint = Lint::of(&path.display().to_string(), &file);
                lints.push(lint.without(&args.allow));
            }
            Err(why) => {
                super::output::complain(&format!("ptm-conform: {why}"));
                unreadable = true;
            }
        }
    }
    if !args.machine.print(&lints)? {
        let least = if output::quiet() {
            Severity::Error
        } else {
            Severity::Info
        };
        for lint in &lints {
            output::print(&lint.to_text(least));
            output::note(&lint.summary());
        }
    }
    let failing = |lint: &Lint| lint.errors > 0 || (args.deny_warnings && lint.warnings > 0);
    Ok(match unreadable {
        true => 2,
        false => u8::from(lints.iter().any(failing)),
    })
}

fn list_codes(args: &LintArgs) -> Outcome {
    let listed: Vec<Listed> = ALL
        .iter()
        .map(|code| Listed {
            code: code.id,
            severity: code.severity,
            clause: code.clause,
            says: code.says,
            mend: code.mend,
            provoked_by: code.provoked_by,
        })
        .collect();
    if !args.machine.print(&listed)? {
        for code in listed {
            output::print(&format!(
                "{}  {:<8} {}\n",
                code.code, code.clause, code.says
            ));
        }
    }
    Ok(0)
}

fn known_code(text: &str) -> Result<String, String> {
    let known = ALL.iter().any(|code| code.id == text);
    known
        .then(|| text.to_owned())
        .ok_or_else(|| "no such code; `ptm-conform lint --codes` lists them".to_owned())
}
