//! Expressions, which represent the arithmetic of the specification as data.
//!
//! ```text
//! (raw - bias[i]) * scale[i]             numbers, variables, list elements, + - * / and parentheses
//! min(max(c, 0), 255)                    functions
//! [row:height, x:width, i:6]             an address: digits with their radices, the most significant first
//! ```
//!
//! Values are real numbers. `mod` is never negative, and `floor` rounds toward minus infinity. An element outside its
//! list, a division of zero by zero, and the constant `none` evaluate to NaN.

use std::iter::Peekable;
use std::str::Chars;

use crate::error::{Error, Result};

/// Spelling of the constant NaN.
const NO_NUMBER: &str = "none";

/// Names that an expression may use: variables and lists. Expressions refer to them by index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scope {
    /// Names of single values.
    pub variables: &'static [&'static str],
    /// Names of lists of values.
    pub lists: &'static [&'static str],
}

/// An expression in a [`Scope`].
#[derive(Clone, Debug, PartialEq)]
pub enum Expression {
    /// A constant.
    Number(f64),
    /// A variable, identified by its index in the scope.
    Variable(usize),
    /// An element of a list: the index of the list in the scope, and the index of the element.
    Element(usize, Box<Expression>),
    /// A sum of two or more terms.
    Sum(Vec<Expression>),
    /// A product of two or more factors.
    Product(Vec<Expression>),
    /// A negated expression.
    Negative(Box<Expression>),
    /// A quotient.
    Quotient(Box<Expression>, Box<Expression>),
    /// A function of one or more arguments.
    Call(Function, Vec<Expression>),
    /// A position in a loop nest: digits with their radices, the most significant first.
    Address(Vec<(Expression, Expression)>),
}

/// Functions that expressions may call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Function {
    /// `floor(a)`.
    Floor,
    /// `round(a)`, which rounds halves away from zero.
    Round,
    /// `truncate(a)`, which rounds toward zero.
    Truncate,
    /// `abs(a)`.
    Abs,
    /// `min(a, b)`.
    Min,
    /// `max(a, b)`.
    Max,
    /// `mod(a, b)`: the remainder, at least 0 and less than `b`.
    Mod,
    /// `power(a, b)`.
    Power,
    /// `sin(a)`, with `a` in radians.
    Sin,
    /// `at_most(a, b)`: 1 if `a <= b`, else 0.
    AtMost,
    /// `select(condition, a, b)`: `b` if the condition is 0, else `a`.
    Select,
    /// `invert(plane)`, applied to a whole plane.
    Invert,
    /// `displace(plane)`, applied to a whole plane.
    Displace,
}

impl Function {
    /// All functions in the order of the enum, with their names and numbers of arguments.
    const ALL: [(Function, &'static str, usize); 13] = [
        (Function::Floor, "floor", 1),
        (Function::Round, "round", 1),
        (Function::Truncate, "truncate", 1),
        (Function::Abs, "abs", 1),
        (Function::Min, "min", 2),
        (Function::Max, "max", 2),
        (Function::Mod, "mod", 2),
        (Function::Power, "power", 2),
        (Function::Sin, "sin", 1),
        (Function::AtMost, "at_most", 2),
        (Function::Select, "select", 3),
        (Function::Invert, "invert", 1),
        (Function::Displace, "displace", 1),
    ];

    fn name(self) -> &'static str {
        Function::ALL[self as usize].1
    }
}

impl Expression {
    /// Evaluates the expression. `variables` and `lists` are in the order of the scope.
    #[must_use]
    pub fn value(&self, variables: &[f64], lists: &[&[f64]]) -> f64 {
        // Most nodes are leaves. Without a call for each, evaluation is faster.
        let value = |expression: &Expression| match expression {
            Expression::Number(number) => *number,
            Expression::Variable(index) => variables[*index],
            _ => expression.value(variables, lists),
        };
        match self {
            Expression::Number(_) | Expression::Variable(_) => value(self),
            Expression::Element(list, index) => {
                let element = index_of(value(index)).and_then(|index| lists[*list].get(index));
                element.copied().unwrap_or(f64::NAN)
            }
            Expression::Sum(terms) => terms.iter().map(value).fold(-0.0, |sum, term| sum + term),
            Expression::Product(factors) => factors.iter().map(value).product(),
            Expression::Negative(inner) => -value(inner),
            Expression::Quotient(numerator, denominator) => value(numerator) / value(denominator),
            Expression::Call(Function::Select, arguments) => match value(&arguments[0]) {
                0.0 => value(&arguments[2]),
                _ => value(&arguments[1]),
            },
            Expression::Call(function, arguments) => {
                let second = arguments.get(1).map_or(0.0, value);
                call(*function, value(&arguments[0]), second)
            }
            Expression::Address(digits) => digits.iter().fold(0.0, |address, (digit, radix)| {
                address * value(radix) + value(digit)
            }),
        }
    }

    /// Returns the direct subexpressions, indexed as in `with_child`.
    #[must_use]
    pub fn children(&self) -> Vec<&Expression> {
        match self {
            Expression::Number(_) | Expression::Variable(_) => Vec::new(),
            Expression::Element(_, inner) | Expression::Negative(inner) => vec![inner],
            Expression::Sum(all) | Expression::Product(all) | Expression::Call(_, all) => {
                all.iter().collect()
            }
            Expression::Quotient(numerator, denominator) => vec![numerator, denominator],
            Expression::Address(digits) => digits
                .iter()
                .flat_map(|(digit, radix)| [digit, radix])
                .collect(),
        }
    }

    /// Returns a copy of the expression in which the child at `index` is replaced.
    pub(crate) fn with_child(&self, index: usize, child: Expression) -> Expression {
        let mut changed = self.clone();
        match &mut changed {
            Expression::Number(_) | Expression::Variable(_) => {}
            Expression::Element(_, inner) | Expression::Negative(inner) => **inner = child,
            Expression::Sum(all) | Expression::Product(all) | Expression::Call(_, all) => {
                all[index] = child;
            }
            Expression::Quotient(numerator, denominator) => {
                **if index == 0 { numerator } else { denominator } = child;
            }
            Expression::Address(digits) => {
                let (digit, radix) = &mut digits[index / 2];
                *if index.is_multiple_of(2) {
                    digit
                } else {
                    radix
                } = child;
            }
        }
        changed
    }

    /// Returns true if the expression uses the variable with this index.
    #[must_use]
    pub fn uses(&self, index: usize) -> bool {
        *self == Expression::Variable(index)
            || self.children().iter().any(|child| child.uses(index))
    }

    /// Formats the expression. Addresses become sums of products, and `select` becomes `a if …, else b`.
    #[must_use]
    pub fn display(&self, scope: Scope) -> String {
        let mut text = String::new();
        self.write(&mut text, scope, 0);
        text
    }

    /// Appends the expression to `text`. Adds parentheses if the expression binds more weakly than `strength`: 1 for a term, 2
    /// for a factor, 3 for the right side of a division.
    fn write(&self, text: &mut String, scope: Scope, strength: u8) {
        // An address with one digit is this digit.
        if let Expression::Address(digits) = self
            && let [(digit, _)] = &digits[..]
        {
            return digit.write(text, scope, strength);
        }
        let own_strength = match self {
            Expression::Sum(_) | Expression::Address(_) => 0,
            Expression::Negative(_) => 1,
            Expression::Product(_) | Expression::Quotient(..) => 2,
            _ => 3,
        };
        if own_strength < strength {
            text.push('(');
            self.write(text, scope, 0);
            text.push(')');
            return;
        }
        match self {
            Expression::Number(number) if number.is_nan() => text.push_str(NO_NUMBER),
            Expression::Number(number) => text.push_str(&number.to_string()),
            Expression::Variable(index) => text.push_str(scope.variables[*index]),
            Expression::Element(list, index) => {
                text.push_str(scope.lists[*list]);
                text.push('[');
                index.write(text, scope, 0);
                text.push(']');
            }
            Expression::Sum(terms) => {
                for (i, term) in terms.iter().enumerate() {
                    match term {
                        Expression::Negative(inner) if i > 0 => {
                            text.push_str(" - ");
                            inner.write(text, scope, 1);
                        }
                        Expression::Number(number) if i > 0 && *number < 0.0 => {
                            text.push_str(" - ");
                            text.push_str(&(-number).to_string());
                        }
                        _ => {
                            text.push_str(if i > 0 { " + " } else { "" });
                            term.write(text, scope, u8::from(i > 0));
                        }
                    }
                }
            }
            Expression::Product(factors) => {
                for (i, factor) in factors.iter().enumerate() {
                    text.push_str(if i > 0 { " * " } else { "" });
                    factor.write(text, scope, 2);
                }
            }
            Expression::Negative(inner) => {
                text.push('-');
                inner.write(text, scope, 2);
            }
            Expression::Quotient(numerator, denominator) => {
                numerator.write(text, scope, 2);
                text.push_str(" / ");
                denominator.write(text, scope, 3);
            }
            Expression::Call(Function::Select, arguments) => {
                let [condition, then, otherwise] = &arguments[..] else {
                    return;
                };
                text.push('(');
                then.write(text, scope, 0);
                text.push_str(" if ");
                condition.write_condition(text, scope);
                text.push_str(", else ");
                otherwise.write(text, scope, 0);
                text.push(')');
            }
            Expression::Call(function, arguments) => {
                text.push_str(function.name());
                for (i, argument) in arguments.iter().enumerate() {
                    text.push_str(if i > 0 { ", " } else { "(" });
                    argument.write(text, scope, 0);
                }
                text.push(')');
            }
            Expression::Address(digits) => Expression::write_address(digits, text, scope),
        }
    }

    /// Writes the expression as a condition, in the form of a comparison.
    fn write_condition(&self, text: &mut String, scope: Scope) {
        let (left, sign, right) = match self {
            Expression::Call(Function::AtMost, sides) => match &sides[..] {
                [Expression::Call(Function::Abs, value), zero]
                    if *zero == Expression::Number(0.0) =>
                {
                    match &value[0] {
                        Expression::Sum(terms)
                            if let [left, Expression::Negative(right)] = &terms[..] =>
                        {
                            (left, " = ", &**right)
                        }
                        left => (left, " = ", zero),
                    }
                }
                sides => (&sides[0], " <= ", &sides[1]),
            },
            other => (other, " != ", &Expression::Number(0.0)),
        };
        left.write(text, scope, 0);
        text.push_str(sign);
        right.write(text, scope, 0);
    }

    /// Writes an address as the last digit plus its radix times the value of the other digits.
    fn write_address(digits: &[(Expression, Expression)], text: &mut String, scope: Scope) {
        if let [others @ .., (digit, radix)] = digits {
            if !others.is_empty() {
                Expression::Address(others.to_vec()).write(text, scope, 2);
                text.push_str(" * ");
                radix.write(text, scope, 3);
                text.push_str(" + ");
            }
            digit.write(text, scope, 0);
        }
    }
}

/// Parses an expression.
///
/// # Errors
/// Returns a sentence that names the unexpected text or the unknown name.
pub fn parse(text: &str, scope: Scope) -> Result<Expression> {
    let mut parser = ExpressionParser {
        rest: text.chars().peekable(),
        scope,
    };
    let expression = parser.parse_sum()?;
    match parser.next() {
        None => Ok(expression),
        Some(other) => Err(Error::Formula(format!("unexpected {other:?} in {text:?}"))),
    }
}

struct ExpressionParser<'a> {
    rest: Peekable<Chars<'a>>,
    scope: Scope,
}

impl ExpressionParser<'_> {
    /// Skips spaces and returns the next character without consuming it.
    fn peek(&mut self) -> Option<char> {
        while self.rest.next_if(|c| c.is_whitespace()).is_some() {}
        self.rest.peek().copied()
    }

    fn next(&mut self) -> Option<char> {
        self.peek();
        self.rest.next()
    }

    fn accept(&mut self, expected: char) -> bool {
        let is_next = self.peek() == Some(expected);
        if is_next {
            self.rest.next();
        }
        is_next
    }

    fn expect(&mut self, expected: char) -> Result<()> {
        match self.accept(expected) {
            true => Ok(()),
            false => Err(Error::Formula(format!(
                "expected {expected:?}, found {:?}",
                self.peek()
            ))),
        }
    }

    fn parse_sum(&mut self) -> Result<Expression> {
        let mut terms = vec![self.parse_product()?];
        loop {
            if self.accept('+') {
                terms.push(self.parse_product()?);
            } else if self.accept('-') {
                terms.push(Expression::Negative(Box::new(self.parse_product()?)));
            } else {
                return Ok(single_or_node(terms, Expression::Sum));
            }
        }
    }

    fn parse_product(&mut self) -> Result<Expression> {
        let mut factors = vec![self.parse_signed()?];
        loop {
            if self.accept('*') {
                factors.push(self.parse_signed()?);
            } else if self.accept('/') {
                let numerator = single_or_node(factors, Expression::Product);
                factors = vec![Expression::Quotient(
                    Box::new(numerator),
                    Box::new(self.parse_signed()?),
                )];
            } else {
                return Ok(single_or_node(factors, Expression::Product));
            }
        }
    }

    fn parse_signed(&mut self) -> Result<Expression> {
        match self.accept('-') {
            true => Ok(Expression::Negative(Box::new(self.parse_signed()?))),
            false => self.parse_atom(),
        }
    }

    fn parse_atom(&mut self) -> Result<Expression> {
        match self.peek() {
            Some('(') => {
                self.next();
                let inner = self.parse_sum()?;
                self.expect(')')?;
                Ok(inner)
            }
            Some('[') => self.parse_address(),
            Some(c) if c.is_ascii_digit() => {
                let text = self.take_word(|c| c.is_ascii_digit() || c == '.');
                let number = text.parse().map(Expression::Number);
                number.map_err(|_| Error::Formula(format!("not a number: {text:?}")))
            }
            Some(c) if c.is_ascii_alphabetic() => {
                let name = self.take_word(|c| c.is_ascii_alphanumeric() || c == '_');
                self.parse_name(&name)
            }
            other => Err(Error::Formula(format!("expected a value, found {other:?}"))),
        }
    }

    fn take_word(&mut self, is_part: fn(char) -> bool) -> String {
        let mut word = String::new();
        while let Some(c) = self.rest.next_if(|&c| is_part(c)) {
            word.push(c);
        }
        word
    }

    fn parse_address(&mut self) -> Result<Expression> {
        self.expect('[')?;
        let mut digits = Vec::new();
        loop {
            let digit = self.parse_sum()?;
            self.expect(':')?;
            digits.push((digit, self.parse_sum()?));
            if !self.accept(',') {
                self.expect(']')?;
                return Ok(Expression::Address(digits));
            }
        }
    }

    fn parse_name(&mut self, name: &str) -> Result<Expression> {
        let find_in = |names: &[&str]| names.iter().position(|&known| known == name);
        if let Some(variable) = find_in(self.scope.variables) {
            return Ok(Expression::Variable(variable));
        }
        if let Some(list) = find_in(self.scope.lists) {
            self.expect('[')?;
            let index = self.parse_sum()?;
            self.expect(']')?;
            return Ok(Expression::Element(list, Box::new(index)));
        }
        if name == NO_NUMBER {
            return Ok(Expression::Number(f64::NAN));
        }
        let known = |&&(_, known, _): &&(Function, &str, usize)| known == name;
        let Some(&(function, _, count)) = Function::ALL.iter().find(known) else {
            return Err(Error::Formula(format!("unknown name {name:?}")));
        };
        self.expect('(')?;
        let mut arguments = vec![self.parse_sum()?];
        while self.accept(',') {
            arguments.push(self.parse_sum()?);
        }
        self.expect(')')?;
        match arguments.len() == count {
            true => Ok(Expression::Call(function, arguments)),
            false => Err(Error::Formula(format!("{name} takes {count} arguments"))),
        }
    }
}

/// Returns the element if there is only one, or else a node with all elements.
pub(super) fn single_or_node(
    mut all: Vec<Expression>,
    node: fn(Vec<Expression>) -> Expression,
) -> Expression {
    match all.len() {
        1 => all.remove(0),
        _ => node(all),
    }
}

/// Returns the value as an index, if it is a whole number that is not negative.
pub(super) fn index_of(value: f64) -> Option<usize> {
    let index = value as usize;
    (index as f64 == value).then_some(index)
}

fn call(function: Function, a: f64, b: f64) -> f64 {
    match function {
        Function::Floor => a.floor(),
        Function::Round => a.round(),
        Function::Truncate => a.trunc(),
        Function::Abs => a.abs(),
        Function::Min => a.min(b),
        Function::Max => a.max(b),
        // Most operands are remainders already, and a division of floats is slow.
        Function::Mod if 0.0 <= a && a < b => a,
        Function::Mod => a.rem_euclid(b),
        Function::Power => a.powf(b),
        Function::Sin => a.sin(),
        Function::AtMost => f64::from(u8::from(a <= b)),
        // The callers evaluate `select` and the functions of whole planes.
        Function::Select | Function::Invert | Function::Displace => a,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCOPE: Scope = Scope {
        variables: &["a", "b", "width"],
        lists: &["bias"],
    };

    fn value_of(text: &str) -> f64 {
        let expression = parse(text, SCOPE).expect("an expression");
        expression.value(&[7.0, -2.0, 3.0], &[&[10.0, 20.0]])
    }

    #[test]
    fn operators_have_the_usual_precedence() {
        assert_eq!(value_of("a + b * 2 - 1"), 2.0);
        assert_eq!(value_of("(a - bias[1]) / 2 * 4"), -26.0);
        assert_eq!(value_of("-a * b"), 14.0);
        assert_eq!(value_of("mod(b, width)"), 1.0);
        assert_eq!(value_of("select(at_most(a, 6), 1, truncate(b / 4))"), 0.0);
        assert_eq!(value_of("[1:2, b:width, 2:6]"), 8.0);
        assert!(value_of("bias[2]").is_nan());
        assert!(value_of("bias[b]").is_nan());
    }

    #[test]
    fn printed_expressions_parse_to_the_same_expression() {
        let print = |text| parse(text, SCOPE).expect("an expression").display(SCOPE);
        for text in [
            "a + b * 2 - 1",
            "(a - bias[1]) / 2 * 4",
            "a - (b - 1)",
            "a / (b * 2)",
            "min(max(a, 0), 255)",
            "bias[5 - mod(a, 6)]",
        ] {
            assert_eq!(print(text), text);
        }
        // An address is printed as arithmetic, and a choice as words.
        let address = print("[a:3, b + 1:width, 1:6]");
        assert_eq!(address, "(a * width + b + 1) * 6 + 1");
        let sum = Expression::Address(vec![
            (
                parse("a + b", SCOPE).expect("a sum"),
                Expression::Number(1.0),
            ),
            (
                parse("b", SCOPE).expect("a variable"),
                Expression::Number(6.0),
            ),
        ]);
        assert_eq!(sum.display(SCOPE), "(a + b) * 6 + b");
        let choice = print("1 + select(at_most(abs(a), 0), b, 2)");
        assert_eq!(choice, "1 + (b if a = 0, else 2)");
    }

    #[test]
    fn parse_errors_name_the_fault() {
        let error = |text: &str| parse(text, SCOPE).expect_err("an error").to_string();
        assert_eq!(error("a + c"), "unknown name \"c\"");
        assert_eq!(error("min(a)"), "min takes 2 arguments");
        assert!(error("a b").starts_with("unexpected 'b'"));
        assert!(error("(a").starts_with("expected ')'"));
    }
}
