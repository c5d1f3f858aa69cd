//! SARIF 2.1.0 output, which code hosts and editors import. The document is written in parts, so that collections of any
//! size require little memory: [`head`], then [`results`] for each file, then [`tail`].

use std::path::Path;

use serde_json::{Value, json};

use super::Lint;
use super::codes::{ALL, Code, Severity};
use super::names::as_uri;
use ptm_suite::address::{self, published_url};

/// Returns the part of the document before the first result.
#[must_use]
pub fn head() -> String {
    let rule = |code: &Code| {
        let mut rule = json!({
            "id": code.id,
            "shortDescription": { "text": code.message },
            "defaultConfiguration": { "level": level(code.severity) },
            "helpUri": published_url(&address::code(code.id)),
            "properties": { "clause": code.clause },
        });
        if !code.fix.is_empty() {
            rule["help"] = json!({ "text": code.fix });
        }
        rule
    };
    let rules: Vec<Value> = ALL.iter().map(rule).collect();
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

/// Returns the results of a file as JSON objects. `failed` is true if the file could not be read.
#[must_use]
pub fn results(path: &Path, lint: &Lint, failed: bool) -> Vec<String> {
    // SARIF requires the level `none` for results that are not failures.
    let (kind, unread_level) = match failed {
        true => ("fail", "error"),
        false => ("open", "none"),
    };
    let artifact = json!({ "uri": as_uri(path.as_os_str()) });
    let finding_result = |finding: &super::diagnostic::Diagnostic| {
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
            "level": unread_level,
            "message": { "text": format!("not judged: {why}") },
            "locations": [{ "physicalLocation": { "artifactLocation": artifact } }],
        })
    });
    let results = lint.findings.iter().map(finding_result).chain(unread);
    results.map(|result| result.to_string()).collect()
}

/// Returns the part of the document after the last result.
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
