//! Converts formulas from plain text to `MathML`.
//!
//! Letters form names, and digits form numbers. `_` and `^` create subscripts and superscripts, braces form groups, and `√(…)` is
//! a square root. All other characters are operators.

use std::iter::Peekable;
use std::str::Chars;

use maud::{Markup, PreEscaped, html};

pub(super) fn formula(text: &str) -> Markup {
    let row = parse_row(&mut text.chars().peekable(), None);
    PreEscaped(format!("<math display=\"block\">{row}</math>"))
}

/// Parses a sequence of atoms up to and including `end`.
fn parse_row(chars: &mut Peekable<Chars>, end: Option<char>) -> String {
    let mut parts = String::new();
    // Preserve the space between two names.
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
        parts += &parse_scripted_atom(chars);
    }
    chars.next();
    format!("<mrow>{parts}</mrow>")
}

/// Parses an atom with an optional subscript and superscript.
fn parse_scripted_atom(chars: &mut Peekable<Chars>) -> String {
    let base = parse_atom(chars);
    let mut script = |sign| {
        chars.next_if_eq(&sign)?;
        Some(match chars.next_if_eq(&'{') {
            Some(_) => parse_row(chars, Some('}')),
            None => parse_atom(chars),
        })
    };
    match (script('_'), script('^')) {
        (Some(below), Some(above)) => format!("<msubsup>{base}{below}{above}</msubsup>"),
        (Some(below), None) => format!("<msub>{base}{below}</msub>"),
        (None, Some(above)) => format!("<msup>{base}{above}</msup>"),
        (None, None) => base,
    }
}

fn parse_atom(chars: &mut Peekable<Chars>) -> String {
    let Some(first) = chars.next() else {
        return String::new();
    };
    if first == '√' && chars.next_if_eq(&'(').is_some() {
        return format!("<msqrt>{}</msqrt>", parse_row(chars, Some(')')));
    }
    let (tag, continues): (&str, fn(char) -> bool) = if first.is_ascii_digit() {
        ("mn", |c| c.is_ascii_digit() || c == '.')
    } else if first.is_alphabetic() {
        ("mi", |c| c.is_alphanumeric() || c == '′')
    } else {
        ("mo", |c| c == '>')
    };
    let mut word = first.to_string();
    while let Some(next) = chars.next_if(|&next| continues(next)) {
        word.push(next);
    }
    format!("<{tag}>{}</{tag}>", html! { (word) }.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check_formula(text: &str, row: &str) {
        let expected = format!("<math display=\"block\"><mrow>{row}</mrow></math>");
        assert_eq!(formula(text).0, expected);
    }

    #[test]
    fn formulas_are_typeset() {
        check_formula("a_0", "<msub><mi>a</mi><mn>0</mn></msub>");
        check_formula("L_u^2", "<msubsup><mi>L</mi><mi>u</mi><mn>2</mn></msubsup>");
        check_formula(
            "m_{4·c}",
            "<msub><mi>m</mi><mrow><mn>4</mn><mo>·</mo><mi>c</mi></mrow></msub>",
        );
        check_formula("1 >> 2", "<mn>1</mn><mo>&gt;&gt;</mo><mn>2</mn>");
        check_formula("√(1)", "<msqrt><mrow><mn>1</mn></mrow></msqrt>");
        check_formula(
            "x mod y",
            "<mi>x</mi><mspace width=\".4em\"></mspace><mi>mod</mi><mspace width=\".4em\"></mspace><mi>y</mi>",
        );
    }
}
