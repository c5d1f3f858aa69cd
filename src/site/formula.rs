//! Formulas: conversion of a line of text to `MathML`.
//!
//! Letters are names, digits numbers; `_` and `^` make subscripts and superscripts, braces group, `√(…)` is a root. All other
//! characters are operators.

use std::iter::Peekable;
use std::str::Chars;

use maud::{Markup, PreEscaped, html};

/// Returns a display formula.
pub(super) fn formula(text: &str) -> Markup {
    let row = row(&mut text.chars().peekable(), None);
    PreEscaped(format!("<math display=\"block\">{row}</math>"))
}

/// Reads everything up to and including `end`.
fn row(chars: &mut Peekable<Chars>, end: Option<char>) -> String {
    let mut parts = String::new();
    // Two names separated only by a space keep that space.
    let mut after_name = false;
    while let Some(&next) = chars.peek()
        && Some(next) != end
    {
        if chars.next_if_eq(&' ').is_some() {
            continue;
        }
        let is_name = next.is_alphanumeric();
        if is_name && after_name {
            parts += "<mspace width=\".4em\"></mspace>";
        }
        after_name = is_name;
        parts += &scripted_atom(chars);
    }
    chars.next();
    format!("<mrow>{parts}</mrow>")
}

/// Reads an atom with its subscript and superscript.
fn scripted_atom(chars: &mut Peekable<Chars>) -> String {
    let base = atom(chars);
    let mut script = |sign| {
        chars.next_if_eq(&sign)?;
        Some(match chars.next_if_eq(&'{') {
            Some(_) => row(chars, Some('}')),
            None => atom(chars),
        })
    };
    match (script('_'), script('^')) {
        (Some(below), Some(above)) => format!("<msubsup>{base}{below}{above}</msubsup>"),
        (Some(below), None) => format!("<msub>{base}{below}</msub>"),
        (None, Some(above)) => format!("<msup>{base}{above}</msup>"),
        (None, None) => base,
    }
}

fn atom(chars: &mut Peekable<Chars>) -> String {
    let Some(first) = chars.next() else {
        return String::new();
    };
    if first == '√' && chars.next_if_eq(&'(').is_some() {
        return format!("<msqrt>{}</msqrt>", row(chars, Some(')')));
    }
    let (tag, belongs): (&str, fn(char) -> bool) = if first.is_ascii_digit() {
        ("mn", |c| c.is_ascii_digit() || c == '.')
    } else if first.is_alphabetic() {
        ("mi", |c| c.is_alphanumeric() || c == '′')
    } else {
        ("mo", |c| c == '>')
    };
    let mut word = first.to_string();
    while let Some(next) = chars.next_if(|&next| belongs(next)) {
        word.push(next);
    }
    format!("<{tag}>{}</{tag}>", html! { (word) }.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn becomes(text: &str, inside: &str) {
        let whole = format!("<math display=\"block\"><mrow>{inside}</mrow></math>");
        assert_eq!(formula(text).0, whole);
    }

    #[test]
    fn formulas_are_typeset() {
        becomes("a_0", "<msub><mi>a</mi><mn>0</mn></msub>");
        becomes("L_u^2", "<msubsup><mi>L</mi><mi>u</mi><mn>2</mn></msubsup>");
        becomes(
            "m_{4·c}",
            "<msub><mi>m</mi><mrow><mn>4</mn><mo>·</mo><mi>c</mi></mrow></msub>",
        );
        becomes("1 >> 2", "<mn>1</mn><mo>&gt;&gt;</mo><mn>2</mn>");
        becomes("√(1)", "<msqrt><mrow><mn>1</mn></mrow></msqrt>");
        becomes(
            "x mod y",
            "<mi>x</mi><mspace width=\".4em\"></mspace><mi>mod</mi><mspace width=\".4em\"></mspace><mi>y</mi>",
        );
    }
}
