//! SARIF 2.1.0, the format in which code hosts and editors import results of static analysis. Written piece by piece, so that a
//! collection of any size needs little memory: [`head`], [`results`] for each file, [`tail`].

use std::ffi::OsStr;

use serde_json::{Value, json};

use super::Lint;
use super::codes::{ALL, Severity};
use super::names::as_uri;
use crate::suite::address::{self, published_url};

/// Returns everything before the first result.
#[must_use]
pub fn head() -> String {
    let rules: Vec<Value> = ALL
        .iter()
        .map(|code| {
            let mut rule = json!({
                "id": code.id,
                "shortDescription": { "text": code.says },
                "defaultConfiguration": { "level": level(code.severity) },
                "helpUri": published_url(&address::code(code.id)),
                "properties": { "clause": code.clause },
            });
            if !code.fix.is_empty() {
                rule["help"] = json!({ "text": code.fix });
            }
            rule
        })
        .collect();
    let driver = json!({
        "name": "ptm-conform",
        "version": env!("CARGO_PKG_VERSION"),
        "informationUri": env!("CARGO_PKG_REPOSITORY"),
        "rules": rules,
    });
    format!(
        "{{\"$schema\": \"https://json.schemastore.org/sarif-2.1.0.json\", \"version\": \"2.1.0\", \"runs\": [{{\"tool\": {{\"driver\": {driver}}}, \"results\": [\n"
    )
}

/// Returns the results of a file, each a line that ends without a comma; `failed` is true if it could not be read.
#[must_use]
pub fn results(path: &OsStr, lint: &Lint, failed: bool) -> Vec<String> {
    // A result that is not a failure has the level `none`.
    let (kind, level_of_unread) = if failed {
        ("fail", "error")
    } else {
        ("open", "none")
    };
    let artifact = json!({ "uri": as_uri(path) });
    let of_finding = |finding: &super::diagnostic::Diagnostic| {
        json!({
            "ruleId": finding.code,
            "ruleIndex": ALL.iter().position(|code| code.id == finding.code),
            "level": level(finding.severity),
            "message": { "text": finding.text() },
            "locations": [{ "physicalLocation": {
                "artifactLocation": artifact,
                "region": { "byteOffset": finding.offset, "byteLength": 0 },
            }}],
        })
    };
    let unread = lint.reason.iter().map(|why| {
        json!({
            "kind": kind,
            "level": level_of_unread,
            "message": { "text": format!("not judged: {why}") },
            "locations": [{ "physicalLocation": { "artifactLocation": artifact } }],
        })
    });
    let results = lint.findings.iter().map(of_finding).chain(unread);
    results.map(|result| result.to_string()).collect()
}

/// Returns everything after the last result.
#[must_use]
pub fn tail() -> &'static str {
    "\n], \"columnKind\": \"utf16CodeUnits\"}]}\n"
}

const fn level(severity: Severity) -> &'static str {
    match severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
        Severity::Info => "note",
    }
}
