//! Parsers for option values: durations, sizes, exit statuses and patterns.

use std::time::Duration;

use clap::builder::{PossibleValuesParser, TypedValueParser};

use ptm::Format;
use ptm_suite::protocol::frame::{EXIT_MALFORMED, EXIT_UNSUPPORTED, ViewKind};

/// Converts a timeout in seconds to a duration. Rejects zero, negative and non-finite values.
pub fn positive_seconds(seconds: f64) -> Result<Duration, String> {
    match Duration::try_from_secs_f64(seconds) {
        Ok(time) if !time.is_zero() => Ok(time),
        _ => Err("expected a positive number of seconds".to_owned()),
    }
}

/// Parses an exit status to treat as a refusal. Rejects 0 and 69, which have other meanings.
pub fn parse_refusal(text: &str) -> Result<i32, String> {
    let status = text.parse().ok();
    let status = status.filter(|n| (1..=255).contains(n) && *n != EXIT_UNSUPPORTED);
    let expected = "expected an exit status from 1 to 255 other than";
    status.ok_or_else(|| format!("{expected} {EXIT_UNSUPPORTED}, found {text:?}"))
}

/// Parses an exit status to treat as success. Rejects 0, 65 and 69, which have other meanings.
pub fn parse_success(text: &str) -> Result<i32, String> {
    let is_free =
        |n: &i32| (1..=255).contains(n) && ![EXIT_MALFORMED, EXIT_UNSUPPORTED].contains(n);
    let expected = "expected an exit status from 1 to 255 other than";
    text.parse().ok().filter(is_free).ok_or_else(|| {
        format!("{expected} {EXIT_MALFORMED} and {EXIT_UNSUPPORTED}, found {text:?}")
    })
}

/// Parses a number of bytes, optionally followed by the suffix K, M or G.
pub fn parse_size(text: &str) -> Result<u64, String> {
    let digits = text.trim_end_matches(['K', 'M', 'G']);
    let mut units = ["", "K", "M", "G"].into_iter();
    let power = units.position(|unit| unit == &text[digits.len()..]);
    let size = digits.parse::<u64>().ok().filter(|&size| size > 0);
    let bytes = size.and_then(|size| size.checked_mul(1 << (10 * power?)));
    bytes.ok_or_else(|| format!("expected a size such as 500M or 2G, found {text:?}"))
}

/// Parses two numbers separated by a comma.
pub fn parse_pair(text: &str) -> Option<(f64, f64)> {
    let (first, second) = text.split_once(',')?;
    Some((first.trim().parse().ok()?, second.trim().parse().ok()?))
}

/// Returns a predicate that accepts case ids matching any of the patterns of an option, or all ids if there are no patterns.
pub fn id_filter(
    option: &str,
    patterns: &[String],
) -> Result<impl Fn(&str) -> bool + use<>, String> {
    let parse = |text: &String| {
        glob::Pattern::new(text).map_err(|error| format!("{option} {text}: {error}"))
    };
    let globs: Vec<glob::Pattern> = patterns.iter().map(parse).collect::<Result<_, _>>()?;
    Ok(move |id: &str| globs.is_empty() || globs.iter().any(|glob| glob.matches(id)))
}

/// Returns a predicate that accepts case ids matching a pattern of `--case`, if there are any, and none of `--skip`.
pub fn id_selection(
    cases: &[String],
    skipped: &[String],
) -> Result<impl Fn(&str) -> bool + use<>, String> {
    let is_named = id_filter("--case", cases)?;
    let is_skipped = id_filter("--skip", skipped)?;
    let skips_some = !skipped.is_empty();
    Ok(move |id: &str| is_named(id) && !(skips_some && is_skipped(id)))
}

/// Returns true if `clause` equals `requested` or is contained in it. For example, 2.4 contains 2.4/8.
pub fn is_at_or_below(clause: &str, requested: &str) -> bool {
    let rest = clause.strip_prefix(requested);
    rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(['/', '.', '-']))
}

/// Returns a parser for the name of a view.
pub fn view_parser() -> impl TypedValueParser<Value = ViewKind> {
    PossibleValuesParser::new(ViewKind::NAMES)
        .map(|name| ViewKind::from_name(&name).expect("a possible value"))
}

/// Parses the short name of a format in upper or lower case.
pub fn parse_format(text: &str) -> Result<Format, String> {
    text.to_uppercase().parse::<Format>().map_err(|_| {
        let names = Format::ALL.map(Format::short_name);
        format!("expected one of {}", names.join(", "))
    })
}
