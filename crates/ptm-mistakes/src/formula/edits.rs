//! Generates all edits that a programmer is likely to make to a formula, the most likely ones first.
//!
//! Each edit operator is applied to every node of the expression. Structural operators come first: dropped terms, swapped
//! variables, and different loop orders. Arithmetic around a node comes last.

use std::collections::HashSet;
use std::sync::LazyLock;

use super::edit::{Edit, EditedForm};
use super::expression::{Expression, Function, Scope, parse, single_or_node};
use super::formulas::Formula;

/// Constants that are commonly confused. The first constant in each row is replaced with each of the others.
const CONFUSED_CONSTANTS: [&[f64]; 5] = [
    &[255.0, 256.0, 254.0, 128.0, 127.0],
    &[128.0, 127.0, 129.0, 256.0, 255.0, 0.0, 64.0],
    &[0.0, 1.0, -1.0],
    &[1.0, 0.0, 2.0, -1.0],
    &[65536.0, 65535.0, 32768.0],
];

/// Functions that are commonly confused with each other.
const CONFUSED_FUNCTIONS: [&[Function]; 2] = [
    &[Function::Min, Function::Max],
    &[Function::Round, Function::Truncate, Function::Floor],
];

/// Factors that are commonly added by mistake.
const EXTRA_FACTORS: [f64; 4] = [2.0, 255.0, 256.0, 128.0];

/// Formulas that may be computed differently under a condition on records, planes or coefficients.
const CONDITIONAL_FORMULAS: [Formula; 6] = [
    Formula::FinalCoefficient,
    Formula::StoredValue,
    Formula::StreamSample,
    Formula::Plane,
    Formula::RecordPlace,
    Formula::Corrected,
];

/// Edits that no operator generates: the name of the formula, and the expression.
const FURTHER_EDITS: [(Formula, &str); 67] = [
    // The limits of a color are exchanged.
    (
        Formula::Rendering,
        "select(at_most(value, 0), 255, min(value, 255))",
    ),
    // A limited color is rounded down after one half is subtracted.
    (Formula::Rendering, "max(min(value, 255) - 1, 0)"),
    // One is added to, or subtracted from, a color between the limits only.
    (
        Formula::Rendering,
        "select(at_most(value, 0), 0, select(at_most(255, value), 255, value + 1))",
    ),
    (
        Formula::Rendering,
        "select(at_most(value, 0), 0, select(at_most(255, value), 255, max(value - 1, 0)))",
    ),
    // A byte is signed.
    (Formula::ByteNumber, "mod(raw + 128, 256) - 128"),
    (Formula::ByteNumber, "mod(raw, 128)"),
    (Formula::ByteNumber, "255 - raw"),
    (Formula::ByteNumber, "raw / 255"),
    (Formula::ByteNumber, "raw / 256"),
    (Formula::ByteNumber, "raw + 1"),
    (Formula::ByteNumber, "raw - 1"),
    // A loop over the scales and biases has one iteration.
    (
        Formula::FinalCoefficient,
        "select(at_most(i, 0), (raw - bias[i]) * scale[i], 0)",
    ),
    // The loop over the coefficients of a polynomial is one too long.
    (
        Formula::FinalColor,
        "select(at_most(i, 0), (raw - bias[i]) * scale[i], raw)",
    ),
    // A loop over the texels is too short, or ends after one iteration.
    (Formula::StoredValue, "select(at_most(abs(t), 0), 0, raw)"),
    (Formula::StoredValue, "select(at_most(n - 1, t), 0, raw)"),
    (Formula::StoredValue, "select(at_most(abs(t), 0), raw, 0)"),
    (Formula::StoredValue, "select(at_most(n - 1, t), raw, 0)"),
    (Formula::StoredValue, "select(at_most(abs(row), 0), 0, raw)"),
    (
        Formula::StoredValue,
        "select(at_most(height - 1, row), 0, raw)",
    ),
    // A value is written to another channel, or the colors come before the coefficients.
    (Formula::ValueChannel, "c * 5 + i"),
    (Formula::ValueChannel, "c * 7 + i"),
    (Formula::ValueChannel, "c + 6 + i"),
    (Formula::ValueChannel, "c * 6 - i"),
    (Formula::ValueChannel, "i - c * 6"),
    (Formula::ValueChannel, "c * 6 + i + 1"),
    (Formula::ValueChannel, "c * 6 + i - 1"),
    (Formula::ColorPlace, "t * 2 + k"),
    (Formula::ColorPlace, "t * 4 + k"),
    (Formula::ColorPlace, "t + 3 + k"),
    (Formula::ColorPlace, "t * 3 - k"),
    (Formula::ColorPlace, "t * 3 + k + 1"),
    (Formula::ColorPlace, "t * 3 + k - 1"),
    // A loop over the texels is too short, or has one iteration.
    (
        Formula::ColorPlace,
        "select(at_most(abs(t), 0), none, t * 3 + k)",
    ),
    (
        Formula::ColorPlace,
        "select(at_most(n - 1, t), none, t * 3 + k)",
    ),
    (
        Formula::ColorPlace,
        "select(at_most(abs(t), 0), t * 3 + k, none)",
    ),
    (
        Formula::ColorPlace,
        "select(at_most(n - 1, t), t * 3 + k, none)",
    ),
    (Formula::FloatPlace, "3 * v"),
    (Formula::FloatPlace, "4 + v"),
    (Formula::FloatPlace, "4 * v + 1"),
    (Formula::FloatPlace, "4 * v - 1"),
    (
        Formula::ValueChannel,
        "select(at_most(abs(c), 0), i + 3, i)",
    ),
    // A loop over the columns of the image is too long or too short, so that the next row begins too late or too early.
    (
        Formula::StoredTexel,
        "(height - 1 - floor(p / (width + 1))) * width + mod(p, width + 1) - 1",
    ),
    (
        Formula::StoredTexel,
        "(height - 1 - floor(p / (width + 1))) * width + mod(p, width + 1)",
    ),
    (
        Formula::StoredTexel,
        "select(at_most(height * (width - 1), p), none, (height - 1 - floor(p / (width - 1))) * width + mod(p, width - 1))",
    ),
    (
        Formula::StoredTexel,
        "select(at_most(height * (width - 1), p), none, (height - 1 - floor(p / (width - 1))) * width + mod(p, width - 1) + 1)",
    ),
    // A loop over the rows of the image starts or ends one row too early.
    (
        Formula::StoredTexel,
        "select(at_most(height - 1, y), none, (height - 1 - y) * width + x)",
    ),
    (
        Formula::StoredTexel,
        "select(at_most(abs(y), 0), none, (height - y) * width + x)",
    ),
    (Formula::StoredTexel, "height - 1 - y + width + x"),
    (Formula::StoredTexel, "(height - 1 - y) * width - x"),
    // Texels are written from right to left.
    (
        Formula::StoredTexel,
        "select(at_most(abs(x), 0), (height - 1 - y) * width, select(at_most(height - 1, y), none, (height - 1 - y) * width - x))",
    ),
    (
        Formula::StoredTexel,
        "select(at_most(height - 1, y), none, (height - 2 - y) * width + x)",
    ),
    // The header ends earlier or later.
    (Formula::TexelStart, "at - 1"),
    (Formula::TexelStart, "at + 1"),
    (Formula::TexelStart, "at - 2"),
    (Formula::TexelStart, "at + 2"),
    // The last coefficient of a polynomial is that of the next channel.
    (
        Formula::IntensityChannel,
        "select(at_most(5, i), c * 6 + 6, c * 6 + i)",
    ),
    // The bytes of a float are those of an integer, are those of its integer part, or are shifted by another number of bits.
    (
        Formula::FloatByte,
        "mod(floor(truncated / power(2, 8 * k)), 256)",
    ),
    (
        Formula::FloatByte,
        "mod(floor(integer / power(2, 8 * k)), 256)",
    ),
    (
        Formula::FloatByte,
        "mod(floor(bits / power(2, 8 * (3 - k))), 256)",
    ),
    (
        Formula::FloatByte,
        "mod(floor(bits * power(2, 8 * k)), 256)",
    ),
    (
        Formula::FloatByte,
        "mod(floor(bits / power(2, 7 * k)), 256)",
    ),
    (
        Formula::FloatByte,
        "mod(floor(bits / power(2, 9 * k)), 256)",
    ),
    (
        Formula::FloatByte,
        "mod(floor(bits / power(2, 8 + k)), 256)",
    ),
    (
        Formula::FloatByte,
        "mod(floor(bits / power(2, 8 * (k + 1))), 256)",
    ),
    // A byte of a float loses its lowest bit.
    (
        Formula::FloatByte,
        "2 * floor(mod(floor(bits / power(2, 8 * k)), 256) / 2)",
    ),
    // The loop over the bytes of a float is too short.
    (
        Formula::FloatByte,
        "select(at_most(3, k), 0, mod(floor(bits / power(2, 8 * k)), 256))",
    ),
    (
        Formula::FloatByte,
        "select(at_most(k, 0), 0, mod(floor(bits / power(2, 8 * k)), 256))",
    ),
];

/// Formulas without other edits. Operators would generate edits of another formula, or positions outside the data: a value that is
/// written there looks like one that is never written.
const ONLY_FURTHER_EDITS: [Formula; 7] = [
    Formula::TexelStart,
    Formula::ColorPlace,
    Formula::FloatPlace,
    Formula::FloatByte,
    Formula::ByteNumber,
    Formula::ValueChannel,
    Formula::StoredTexel,
];

/// Formulas with variables that only further edits use: the number of variables for the operators.
const OPERATOR_VARIABLES: [(Formula, usize); 1] = [(Formula::StoredValue, 3)];

/// Edits of every formula, in the order of [`Formula::ALL`].
static ALL: LazyLock<Vec<Vec<Edit>>> =
    LazyLock::new(|| Formula::ALL.iter().map(|row| all_edits(row.0)).collect());

/// Returns the edits of a formula without duplicates, the most likely ones first.
#[must_use]
pub fn all(formula: Formula) -> &'static [Edit] {
    &ALL[formula as usize]
}

/// Formulas for both axes. A decoder often computes both with the same code.
const AXES: [[Formula; 2]; 4] = [
    [Formula::DisplacedX, Formula::DisplacedY],
    [Formula::FirstColumn, Formula::FirstRow],
    [Formula::SecondColumn, Formula::SecondRow],
    [Formula::EdgeX, Formula::EdgeY],
];

/// Returns the edits of both axes at once, the most likely ones of each formula first: an edit for x, and the same edit for y.
#[must_use]
pub fn of_both_axes() -> Vec<[Edit; 2]> {
    let other_axis = |name: &str| match name {
        "x" => "y",
        "y" => "x",
        "mx" => "my",
        "my" => "mx",
        "width" => "height",
        _ => "width",
    };
    let pairs = AXES.iter().flat_map(|&[first, second]| {
        let names = first.scope().variables;
        let swapped = move |node: &Expression| match node {
            Expression::Variable(index) => {
                let other = other_axis(names[*index]);
                let index = names.iter().position(|name| *name == other)?;
                Some(Expression::Variable(index))
            }
            _ => None,
        };
        all(first)
            .iter()
            .filter_map(move |edit| match &edit.change {
                EditedForm::Expression(expression) => {
                    let other = Edit {
                        formula: second,
                        change: EditedForm::Expression(replace_nodes(expression, &swapped)),
                    };
                    Some([edit.clone(), other])
                }
                EditedForm::Table(_) => None,
            })
    });
    pairs.collect()
}

fn all_edits(formula: Formula) -> Vec<Edit> {
    let (stated, whole_scope) = (&formula.stated().expression, formula.scope());
    let mut scope = whole_scope;
    if let Some((_, count)) = OPERATOR_VARIABLES.iter().find(|row| row.0 == formula) {
        scope.variables = &scope.variables[..*count];
    }
    let further = FURTHER_EDITS.iter().filter(|row| row.0 == formula);
    let parse = |text: &str| {
        parse(text, whole_scope).unwrap_or_else(|error| unreachable!("invalid edit: {error}"))
    };
    let further = further.map(|(_, text)| parse(text));
    if formula == Formula::GroupSize {
        return as_edits(
            formula,
            group_sizes().iter().map(|text| parse(text)).collect(),
        );
    }
    if ONLY_FURTHER_EDITS.contains(&formula) {
        return as_edits(formula, further.collect());
    }
    let mut all = Vec::new();
    // A value that is never written stays 0, and a position that never advances remains the same.
    if let Formula::Rendering
    | Formula::FinalCoefficient
    | Formula::StoredValue
    | Formula::BlockLength = formula
    {
        all.push(number(0.0));
    }
    // A coefficient stays as stored, or a color is treated as a coefficient.
    let other = match formula {
        Formula::FinalCoefficient => Some(Formula::FinalColor),
        Formula::FinalColor => Some(Formula::FinalCoefficient),
        _ => None,
    };
    all.extend(other.map(|other| other.stated().expression.clone()));
    for operator in [
        drop_parts,
        replace_operators,
        replace_names,
        change_loops,
        replace_constants,
    ] {
        all.extend(apply_to_all_nodes(stated, &|node| operator(node, scope)));
    }
    all.extend(swap_names_everywhere(stated, scope));
    if scope.lists == ["m"] {
        all.extend(change_matrix_indices(stated));
    }
    for operator in [add_factors, add_constants, apply_functions, change_groups] {
        all.extend(apply_to_all_nodes(stated, &|node| match node {
            Expression::Number(_) => Vec::new(),
            _ => operator(node, scope),
        }));
    }
    if CONDITIONAL_FORMULAS.contains(&formula) {
        all.extend(apply_to_all_nodes(stated, &|node| {
            replace_conditionally(node, scope)
        }));
    }
    if formula == Formula::IndexByte {
        all.extend(change_index_bytes(scope));
    }
    all.extend(further);
    // A final value that does not depend on the stored value, except for a constant, reveals a wrong stored value.
    if formula == Formula::FinalCoefficient {
        let raw = |node: &Expression| matches!(node, Expression::Variable(0));
        all.retain(|one| matches!(one, Expression::Number(_)) || contains(one, &raw));
    }
    // If there is no such channel in or near the texel, the color is 0, which shows nothing else.
    if let Formula::IntensityChannel | Formula::ColorChannel = formula {
        let is_near = |channel: f64| channel.fract() == 0.0 && channel.abs() < 36.0;
        // Coefficient i of color c; color k is the first variable.
        let variables = |n: u8| [n % 6, n / 6].map(f64::from);
        all.retain(|one| (0..18).all(|n| is_near(one.value(&variables(n), &[]))));
    }
    // A color of an image may be rounded.
    if formula == Formula::Rendering {
        all.retain(|expression| !rounds(expression));
    }
    let mut known = HashSet::from([stated.display(scope)]);
    all.retain(|expression| known.insert(expression.display(whole_scope)));
    as_edits(formula, all)
}

/// Returns edits of the size of a group: a texel has as many bytes as there are texels, or one byte more or less, in all blocks or in
/// one of the three.
fn group_sizes() -> Vec<String> {
    let sizes = ["count", "size + 1", "size - 1"];
    let in_block =
        |b: usize| sizes.map(|size| format!("select(at_most(abs(b - {b}), 0), {size}, size)"));
    let in_all = sizes.map(str::to_owned);
    in_all
        .into_iter()
        .chain((0..3).flat_map(in_block))
        .collect()
}

fn as_edits(formula: Formula, expressions: Vec<Expression>) -> Vec<Edit> {
    let changes = expressions.into_iter().map(EditedForm::Expression);
    changes.map(|change| Edit { formula, change }).collect()
}

/// Returns true if a node of the expression satisfies `predicate`.
fn contains(expression: &Expression, predicate: &dyn Fn(&Expression) -> bool) -> bool {
    let mut children = expression.children().into_iter();
    predicate(expression) || children.any(|child| contains(child, predicate))
}

/// Applies an operator to every node, from the root to the leaves.
fn apply_to_all_nodes(
    expression: &Expression,
    operator: &dyn Fn(&Expression) -> Vec<Expression>,
) -> Vec<Expression> {
    let mut all = operator(expression);
    for (index, child) in expression.children().into_iter().enumerate() {
        let changed = apply_to_all_nodes(child, operator).into_iter();
        all.extend(changed.map(|child| expression.with_child(index, child)));
    }
    all
}

fn number(value: f64) -> Expression {
    Expression::Number(value)
}

fn negate(expression: &Expression) -> Expression {
    match expression {
        Expression::Negative(inner) => (**inner).clone(),
        other => Expression::Negative(Box::new(other.clone())),
    }
}

fn call(function: Function, arguments: &[Expression]) -> Expression {
    Expression::Call(function, arguments.to_vec())
}

/// Drops a term, a factor or a function: replaces the node with one of its parts, or with 0.
fn drop_parts(node: &Expression, _: Scope) -> Vec<Expression> {
    let drop_each =
        |all: &[Expression], node: fn(Vec<Expression>) -> Expression| -> Vec<Expression> {
            let drop_part = |i| {
                let mut others = all.to_vec();
                others.remove(i);
                single_or_node(others, node)
            };
            let single_parts = all.iter().map(|part| match part {
                Expression::Negative(inner) => (**inner).clone(),
                other => other.clone(),
            });
            (0..all.len()).map(drop_part).chain(single_parts).collect()
        };
    match node {
        Expression::Sum(terms) => drop_each(terms, Expression::Sum),
        Expression::Product(factors) => drop_each(factors, Expression::Product),
        Expression::Quotient(over, _) => vec![(**over).clone()],
        Expression::Call(_, arguments) => arguments.clone(),
        Expression::Variable(_) | Expression::Element(..) => vec![number(0.0)],
        _ => Vec::new(),
    }
}

/// Replaces an operator with its counterpart, in one term or in every term of a sum, or swaps two nested functions.
fn replace_operators(node: &Expression, _: Scope) -> Vec<Expression> {
    match node {
        Expression::Sum(terms) => {
            let negate_term = |i: usize| {
                let mut changed = terms.clone();
                changed[i] = negate(&terms[i]);
                Expression::Sum(changed)
            };
            let mut all: Vec<Expression> = terms.iter().map(negate).collect();
            // Put positive terms first, for readability.
            all.sort_by_key(|term| matches!(term, Expression::Negative(_)));
            // A term without a factor is often the product of itself and a factor of 1 in a list of factors.
            let split_every_term = |(variant, with_one): (usize, bool)| {
                let changed = |term: &Expression| match term {
                    Expression::Product(factors) => split_product(factors)[variant].clone(),
                    other if with_one => Expression::Sum(vec![other.clone(), number(1.0)]),
                    other => other.clone(),
                };
                Expression::Sum(terms.iter().map(changed).collect())
            };
            let sums = (0..terms.len()).rev().map(negate_term);
            let sums = sums.chain([Expression::Sum(all)]);
            let every_term = [(1, false), (0, false), (1, true)].map(split_every_term);
            sums.chain(every_term).collect()
        }
        Expression::Product(factors) => split_product(factors),
        Expression::Quotient(over, under) => {
            let both = [over, under].map(|part| (**part).clone());
            let mut all = vec![
                Expression::Product(both.to_vec()),
                Expression::Quotient(under.clone(), over.clone()),
            ];
            // The last product of a * b / c becomes a sum.
            if let Expression::Product(factors) = &**over
                && let [first @ .., last] = &factors[..]
            {
                let quotient = Expression::Quotient(Box::new(last.clone()), under.clone());
                let product = single_or_node(first.to_vec(), Expression::Product);
                all.push(Expression::Sum(vec![product, quotient]));
            }
            all
        }
        Expression::Call(outer, arguments) => {
            let family = CONFUSED_FUNCTIONS
                .iter()
                .find(|family| family.contains(outer));
            let others = family.copied().into_iter().flatten();
            let others = others.filter(|other| *other != outer);
            let mut all: Vec<Expression> = others.map(|other| call(*other, arguments)).collect();
            if let [Expression::Call(inner, innermost)] = &arguments[..]
                && innermost.len() == 1
            {
                all.push(call(*inner, &[call(*outer, innermost)]));
            }
            all
        }
        _ => Vec::new(),
    }
}

/// Returns variants of a product in which two adjacent parts are divided or added instead of multiplied.
fn split_product(factors: &[Expression]) -> Vec<Expression> {
    let split_at = |(start, middle): (usize, usize)| {
        let parts = [&factors[start..middle], &factors[middle..]];
        let [a, b] = parts.map(|part| single_or_node(part.to_vec(), Expression::Product));
        let sum = Expression::Sum(vec![a.clone(), b.clone()]);
        [Expression::Quotient(Box::new(a), Box::new(b)), sum]
            .map(|part| single_or_node([&factors[..start], &[part]].concat(), Expression::Product))
    };
    let ranges = (0..factors.len())
        .flat_map(|start| (start + 1..factors.len()).map(move |middle| (start, middle)));
    ranges.flat_map(split_at).collect()
}

/// Replaces a variable or a list with another in its scope, or an index with a nearby one.
fn replace_names(node: &Expression, scope: Scope) -> Vec<Expression> {
    match node {
        Expression::Variable(index) => {
            let others = (0..scope.variables.len()).filter(|other| other != index);
            others.map(Expression::Variable).collect()
        }
        Expression::Element(list, index) => {
            // Only scales and biases are confused with each other.
            let lists =
                (0..scope.lists.len()).filter(|other| other != list && scope.lists.len() == 2);
            let other_lists = lists.map(|other| Expression::Element(other, index.clone()));
            let next = |step: f64| Expression::Sum(vec![(**index).clone(), number(step)]);
            let has_six_elements = scope.lists == ["scale", "bias"];
            let last = if has_six_elements { 5.0 } else { 15.0 };
            let cyclic = |step| call(Function::Mod, &[next(step), number(last + 1.0)]);
            let reversed = Expression::Sum(vec![number(last), negate(index)]);
            let double = Expression::Product(vec![(**index).clone(), number(2.0)]);
            let near = [cyclic(1.0), cyclic(last), next(1.0), next(-1.0), reversed];
            let indices = near.into_iter().chain([number(0.0), number(last), double]);
            let mut elements: Vec<Expression> = indices
                .map(|index| Expression::Element(*list, Box::new(index)))
                .collect();
            if has_six_elements {
                elements.extend(change_remainder(*list));
            }
            other_lists.chain(elements).collect()
        }
        _ => Vec::new(),
    }
}

/// Returns elements of a list of six whose index is computed in another way than as the remainder of c * 6 + i, the number of the
/// channel.
fn change_remainder(list: usize) -> Vec<Expression> {
    let [i, c] = [1, 2].map(Expression::Variable);
    let sixfold = Expression::Product(vec![c.clone(), number(6.0)]);
    let channel = Expression::Sum(vec![sixfold, i.clone()]);
    let remainder = |divisor| call(Function::Mod, &[channel.clone(), number(divisor)]);
    let element = |index| Expression::Element(list, Box::new(index));
    let sixth = Expression::Quotient(Box::new(i), Box::new(number(6.0)));
    let indices = [
        remainder(5.0),
        remainder(7.0),
        Expression::Sum(vec![c.clone(), sixth]),
        c,
        channel.clone(),
    ];
    let mut all = indices.map(element).to_vec();
    // In the file, and often in memory, the biases follow the scales.
    let at = |list: usize, index: f64| Expression::Element(list, Box::new(number(index)));
    let i = Expression::Variable(1);
    let previous = Expression::Sum(vec![i.clone(), number(-1.0)]);
    let (is_inside, inside, outside) = if list == 0 {
        let index = remainder(7.0);
        let is_inside = call(Function::AtMost, &[index.clone(), number(5.0)]);
        (is_inside, element(index), at(1, 0.0))
    } else {
        let is_inside = call(Function::AtMost, &[number(1.0), i]);
        (is_inside, element(previous), at(0, 5.0))
    };
    all.push(call(Function::Select, &[is_inside, inside, outside]));
    all
}

/// Swaps two variables or two lists in the whole expression.
fn swap_names_everywhere(expression: &Expression, scope: Scope) -> Vec<Expression> {
    let count = scope.variables.len();
    let mut all = Vec::new();
    for a in (0..count).filter(|&index| expression.uses(index)) {
        for b in 0..count {
            if b != a && (b > a || !expression.uses(b)) {
                all.push(replace_nodes(expression, &|node| match node {
                    Expression::Variable(index) if *index == a => Some(Expression::Variable(b)),
                    Expression::Variable(index) if *index == b => Some(Expression::Variable(a)),
                    _ => None,
                }));
            }
        }
    }
    if scope.lists.len() == 2 {
        all.push(replace_nodes(expression, &|node| match node {
            Expression::Element(list, index) => Some(Expression::Element(1 - list, index.clone())),
            _ => None,
        }));
    }
    all
}

/// Changes the indices of a matrix, such as m[8 + k], element k of column 2: the distance of the columns in all terms, or the column in
/// one term.
fn change_matrix_indices(expression: &Expression) -> Vec<Expression> {
    const ROWS: f64 = 4.0;
    let with_index = |change: &dyn Fn(f64, &Expression) -> Expression| {
        replace_nodes(expression, &|node| match node {
            Expression::Element(list, index) => {
                let (offset, row) = split_index(index);
                Some(Expression::Element(*list, Box::new(change(offset, row))))
            }
            _ => None,
        })
    };
    let sum = |offset: f64, row: Expression| match offset {
        0.0 => row,
        _ => Expression::Sum(vec![number(offset), row]),
    };
    let mut all = [3.0, 5.0]
        .map(|stride| with_index(&|offset, row| sum(offset / ROWS * stride, row.clone())))
        .to_vec();
    all.push(with_index(&|offset, row| sum(offset, negate(row))));
    all.push(with_index(&|offset, row| {
        sum(ROWS + offset / ROWS, row.clone())
    }));
    all.extend(apply_to_all_nodes(expression, &|node| match node {
        Expression::Element(list, index) => {
            let (_, row) = split_index(index);
            let columns = [0.0, 4.0, 8.0, 12.0].map(|offset| sum(offset, row.clone()));
            columns
                .map(|index| Expression::Element(*list, Box::new(index)))
                .to_vec()
        }
        _ => Vec::new(),
    }));
    all
}

/// Splits an index such as 8 + k into 8 and k.
fn split_index(index: &Expression) -> (f64, &Expression) {
    match index {
        Expression::Sum(terms) => match &terms[..] {
            [Expression::Number(offset), row] => (*offset, row),
            _ => (0.0, index),
        },
        _ => (0.0, index),
    }
}

/// Returns edits of the position of an index byte that change only one of the two bytes of an index.
fn change_index_bytes(scope: Scope) -> Vec<Expression> {
    let parse = |text: &str| {
        parse(text, scope).unwrap_or_else(|error| unreachable!("invalid edit: {error}"))
    };
    let stated = &Formula::IndexByte.stated().expression;
    let positions = [
        "[row:height, x:width] + k",
        "[row:height, x:width] * 3 + k",
        "[row:height, x:width] + 2 + k",
        "[row:height, x:width] * 2 + k + 1",
        "[row:height, x:width] * 2 + k - 1",
        "[row:height, x:width] * 2 - k",
    ];
    let mut all = Vec::new();
    for position in positions {
        let changed = parse(&format!("entries * size + {position}"));
        let second = parse("at_most(1, k)");
        all.push(call(
            Function::Select,
            &[second.clone(), changed.clone(), stated.clone()],
        ));
        let first = call(Function::Select, &[second, stated.clone(), changed]);
        let is_single = parse("at_most(bytes, 1)");
        all.push(call(Function::Select, &[is_single, stated.clone(), first]));
    }
    all
}

/// Replaces the nodes for which `change` returns a new expression.
fn replace_nodes(
    expression: &Expression,
    change: &dyn Fn(&Expression) -> Option<Expression>,
) -> Expression {
    change(expression).unwrap_or_else(|| {
        let children = expression.children().into_iter().enumerate();
        children.fold(expression.clone(), |changed, (index, child)| {
            changed.with_child(index, replace_nodes(child, change))
        })
    })
}

/// Changes the loops of an address: their order, their direction, or their length.
fn change_loops(node: &Expression, _: Scope) -> Vec<Expression> {
    let Expression::Address(digits) = node else {
        return Vec::new();
    };
    let in_order = |order: Vec<usize>| {
        Expression::Address(order.iter().map(|&index| digits[index].clone()).collect())
    };
    let permutations = permutations(digits.len()).into_iter();
    let mut all: Vec<Expression> = permutations.map(in_order).collect();
    all.extend(change_merged_loops(digits));
    // A digit is left out.
    if digits.len() > 1 {
        all.extend((0..digits.len()).map(|index| {
            let others = digits
                .iter()
                .enumerate()
                .filter(|(other, _)| *other != index);
            Expression::Address(others.map(|(_, digit)| digit.clone()).collect())
        }));
    }
    let with_digit = |index: usize, digit: Expression, radix: Expression| {
        let mut changed = digits.clone();
        changed[index] = (digit, radix);
        Expression::Address(changed)
    };
    // The outer loops count backward from the start.
    if let [outer @ .., (inner, radix)] = &digits[..]
        && !outer.is_empty()
    {
        let steps = vec![Expression::Address(outer.to_vec()), radix.clone()];
        all.push(Expression::Sum(vec![
            inner.clone(),
            negate(&Expression::Product(steps)),
        ]));
    }
    for (index, (digit, radix)) in digits.iter().enumerate() {
        let reversed = Expression::Sum(vec![radix.clone(), number(-1.0), negate(digit)]);
        all.push(with_digit(index, reversed, radix.clone()));
        if index > 0 {
            // One product of the nested loops is a sum, or is left out.
            let outer = Expression::Address(digits[..index].to_vec());
            let sums = [
                vec![outer.clone(), radix.clone(), digit.clone()],
                vec![outer, digit.clone()],
            ];
            all.extend(sums.map(|sum| {
                let outer = (Expression::Sum(sum), radix.clone());
                let inner = digits[index + 1..].iter().cloned();
                Expression::Address([outer].into_iter().chain(inner).collect())
            }));
            let multiples = match radix {
                Expression::Number(_) => &[][..],
                _ => &[4.0, 8.0, 2.0],
            };
            for &multiple in multiples {
                all.push(with_digit(index, digit.clone(), round_up(radix, multiple)));
            }
            for step in [1.0, -1.0] {
                all.push(with_digit(index, digit.clone(), plus(radix, step)));
            }
        }
    }
    all
}

/// Changes a loop nest in which two loops within others are one loop, such as one over all texels.
fn change_merged_loops(digits: &[(Expression, Expression)]) -> Vec<Expression> {
    let mut all = Vec::new();
    for index in 1..digits.len().saturating_sub(1) {
        let (outer, inner) = (&digits[..index], &digits[index + 2..]);
        let merged = Expression::Address(digits[index..index + 2].to_vec());
        let radices = [&digits[index + 1], &digits[index]].map(|(_, radix)| radix.clone());
        let radix = Expression::Product(radices.to_vec());
        let with =
            |head: Vec<(Expression, Expression)>| Expression::Address([&head[..], inner].concat());
        let with_merged =
            |digit: Expression, radix: Expression| with([outer, &[(digit, radix)]].concat());
        let sum = Expression::Sum(vec![
            Expression::Address(outer.to_vec()),
            radix.clone(),
            merged.clone(),
        ]);
        all.push(with(vec![(sum, radix.clone())]));
        all.push(with_merged(negate(&merged), radix.clone()));
        for step in [1.0, -1.0] {
            all.push(with_merged(merged.clone(), plus(&radix, step)));
        }
    }
    all
}

/// Returns the sum of an expression and a number. The sum of two numbers is a number.
fn plus(value: &Expression, step: f64) -> Expression {
    match value {
        Expression::Number(value) => number(value + step),
        _ => Expression::Sum(vec![value.clone(), number(step)]),
    }
}

fn round_up(value: &Expression, multiple: f64) -> Expression {
    let sum = Expression::Sum(vec![value.clone(), number(multiple - 1.0)]);
    let quotient = Expression::Quotient(Box::new(sum), Box::new(number(multiple)));
    Expression::Product(vec![call(Function::Floor, &[quotient]), number(multiple)])
}

/// Returns all permutations of `count` elements except the identity.
fn permutations(count: usize) -> Vec<Vec<usize>> {
    let mut all = vec![Vec::new()];
    for index in 0..count {
        let longer = |order: Vec<usize>| {
            (0..=order.len()).map(move |i| [&order[..i], &[index], &order[i..]].concat())
        };
        all = all.into_iter().flat_map(longer).collect();
    }
    all.sort();
    all.split_off(1)
}

/// Replaces a constant with its neighbors, its half, its double, and constants that are commonly confused with it.
fn replace_constants(node: &Expression, _: Scope) -> Vec<Expression> {
    let Expression::Number(value) = *node else {
        return Vec::new();
    };
    let rivals = CONFUSED_CONSTANTS
        .iter()
        .filter(|rivals| rivals[0] == value);
    let rivals = rivals.flat_map(|rivals| rivals[1..].iter().copied());
    let neighbors = [value + 1.0, value - 1.0, 2.0 * value, value / 2.0, 0.0, 1.0];
    rivals.chain(neighbors).map(number).collect()
}

fn add_factors(node: &Expression, _: Scope) -> Vec<Expression> {
    let product = |factor| Expression::Product(vec![node.clone(), number(factor)]);
    let quotient = |factor| Expression::Quotient(Box::new(node.clone()), Box::new(number(factor)));
    let ratio =
        |over, under| Expression::Quotient(Box::new(product(over)), Box::new(number(under)));
    let both = EXTRA_FACTORS
        .into_iter()
        .flat_map(|factor| [product(factor), quotient(factor)]);
    both.chain([ratio(255.0, 256.0), ratio(256.0, 255.0)])
        .collect()
}

fn add_constants(node: &Expression, _: Scope) -> Vec<Expression> {
    let sum = |constant| Expression::Sum(vec![node.clone(), number(constant)]);
    [1.0, -1.0, 128.0, -128.0, 0.5].map(sum).to_vec()
}

fn rounds(node: &Expression) -> bool {
    matches!(node, Expression::Call(Function::Round, _)) || node.children().into_iter().any(rounds)
}

/// Applies a function to a node: rounds it, clamps it, or keeps some of its bits.
fn apply_functions(node: &Expression, _: Scope) -> Vec<Expression> {
    let apply = |function| call(function, std::slice::from_ref(node));
    let limit_by = |function, limit| call(function, &[node.clone(), number(limit)]);
    let clamp = |min, max| call(Function::Min, &[limit_by(Function::Max, min), number(max)]);
    let signed = |half: f64| {
        let shifted = Expression::Sum(vec![node.clone(), number(half)]);
        let remainder = call(Function::Mod, &[shifted, number(2.0 * half)]);
        Expression::Sum(vec![remainder, number(-half)])
    };
    vec![
        apply(Function::Truncate),
        apply(Function::Round),
        apply(Function::Floor),
        apply(Function::Abs),
        negate(node),
        clamp(0.0, 255.0),
        limit_by(Function::Max, 0.0),
        limit_by(Function::Min, 255.0),
        limit_by(Function::Mod, 256.0),
        signed(128.0),
        clamp(-128.0, 127.0),
        clamp(0.0, 1.0),
        clamp(-1.0, 1.0),
        limit_by(Function::Mod, 128.0),
        limit_by(Function::Mod, 255.0),
        signed(32768.0),
        call(Function::Mod, &[apply(Function::Truncate), number(256.0)]),
        Expression::Sum(vec![number(255.0), negate(node)]),
    ]
}

/// Drops two or more adjacent terms or factors, or applies a function to them.
fn change_groups(node: &Expression, scope: Scope) -> Vec<Expression> {
    let (all, node): (&[Expression], fn(Vec<Expression>) -> Expression) = match node {
        Expression::Sum(terms) => (terms, Expression::Sum),
        Expression::Product(factors) => (factors, Expression::Product),
        _ => return Vec::new(),
    };
    let mut changed = Vec::new();
    for start in 0..all.len() {
        for end in (start + 2..=all.len()).filter(|end| end - start < all.len()) {
            let replace = |new: Option<Expression>| {
                let parts = [&all[..start], new.as_slice(), &all[end..]].concat();
                single_or_node(parts, node)
            };
            let group = node(all[start..end].to_vec());
            changed.push(replace(None));
            let calls = apply_functions(&group, scope).into_iter();
            changed.extend(calls.map(|new| replace(Some(new))));
        }
    }
    changed
}

/// Replaces a variable with another one under a condition: a variable in the scope is 0, is not 0, or is greater than 255.
fn replace_conditionally(node: &Expression, scope: Scope) -> Vec<Expression> {
    let Expression::Variable(own) = node else {
        return Vec::new();
    };
    let mut all = Vec::new();
    for condition in 0..scope.variables.len() {
        let variable = Expression::Variable(condition);
        let absolute = call(Function::Abs, std::slice::from_ref(&variable));
        let is_zero = call(Function::AtMost, &[absolute, number(0.0)]);
        let is_byte = call(Function::AtMost, &[variable, number(255.0)]);
        for index in (0..scope.variables.len()).filter(|other| other != own) {
            let other = Expression::Variable(index);
            let if_zero = match index == condition {
                true => number(0.0),
                false => other.clone(),
            };
            let select = |condition: &Expression, then: &Expression, otherwise: &Expression| {
                let arguments = [condition, then, otherwise].map(Clone::clone);
                call(Function::Select, &arguments)
            };
            all.push(select(&is_zero, &if_zero, node));
            all.push(select(&is_zero, node, &other));
            all.push(select(&is_byte, node, &other));
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edit_texts(formula: Formula) -> Vec<String> {
        all(formula).iter().map(Edit::edited_text).collect()
    }

    #[test]
    fn ordinary_mistakes_are_generated() {
        use Formula::{Color, FinalCoefficient, IndexByte, LumSample, Plane, Predictor, StoredRow};
        for (formula, expected) in [
            (FinalCoefficient, "(raw + bias[i]) * scale[i]"),
            (FinalCoefficient, "(raw - bias[i]) * scale[mod(i + 1, 6)]"),
            (FinalCoefficient, "(raw - scale[i]) * bias[i]"),
            (FinalCoefficient, "truncate((raw - bias[i]) * scale[i])"),
            (FinalCoefficient, "(bias[i] - raw) * scale[i]"),
            (Color, "min(max(L, 0), 255) * rgb / 255"),
            (StoredRow, "y"),
            (StoredRow, "width - 1 - y"),
            (LumSample, "(i * height + row) * width + x"),
            (LumSample, "row * width + x + i"),
            (IndexByte, "entries * size + (row * width + x + k)"),
            (Plane, "mod(residual + predictor - 128, 255)"),
            (Predictor, "invert(displace(reference))"),
            (Predictor, "displace(invert(coded))"),
        ] {
            let is_generated = edit_texts(formula).iter().any(|text| text == expected);
            assert!(is_generated, "{expected} is not generated");
        }
    }

    #[test]
    fn edits_of_both_axes_are_the_same() {
        let texts: Vec<[String; 2]> = of_both_axes()
            .iter()
            .map(|pair| [0, 1].map(|i| pair[i].edited_text()))
            .collect();
        for expected in [
            ["x - mx / 2", "y - my / 2"],
            ["x + floor(mx / 3)", "y + floor(my / 3)"],
            ["x - floor((mx + 1) / 2)", "y - floor((my + 1) / 2)"],
            ["min(max(x, 0), width - 2)", "min(max(y, 0), height - 2)"],
        ] {
            assert!(texts.iter().any(|pair| pair == &expected), "{expected:?}");
        }
    }

    #[test]
    fn edits_are_distinct_and_differ_from_the_formula() {
        for (formula, name) in Formula::ALL {
            let texts = edit_texts(formula);
            assert!(texts.len() > 3, "{name}: {}", texts.len());
            let stated = formula.stated().expression.display(formula.scope());
            assert!(!texts.contains(&stated), "{name}");
        }
    }
}
