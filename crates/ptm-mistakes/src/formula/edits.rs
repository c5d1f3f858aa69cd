//! Generates all edits that a programmer is likely to make to a formula, the most likely ones first.
//!
//! Each edit operator is applied to every node of the expression. Structural operators come first: dropped terms, swapped
//! variables, and different loop orders. Arithmetic around a node comes last.

use std::collections::HashSet;
use std::sync::LazyLock;

use super::edit::{Edit, EditedForm};
use super::expression::{Expression, Function, Scope, single_or_node};
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

/// Edits of every formula, in the order of [`Formula::ALL`].
static ALL: LazyLock<Vec<Vec<Edit>>> =
    LazyLock::new(|| Formula::ALL.iter().map(|row| all_edits(row.0)).collect());

/// Returns the edits of a formula without duplicates, the most likely ones first.
#[must_use]
pub fn all(formula: Formula) -> &'static [Edit] {
    &ALL[formula as usize]
}

fn all_edits(formula: Formula) -> Vec<Edit> {
    let (stated, scope) = (&formula.stated().expression, formula.scope());
    let mut all = Vec::new();
    // A value that is never written stays 0.
    if let Formula::Rendering | Formula::FinalCoefficient | Formula::StoredValue = formula {
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
    all.extend(change_list_strides(stated));
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
    // A final value that does not depend on the stored value, except for a constant, reveals a wrong stored value.
    if formula == Formula::FinalCoefficient {
        let raw = |node: &Expression| matches!(node, Expression::Variable(0));
        all.retain(|one| matches!(one, Expression::Number(_)) || contains(one, &raw));
    }
    // A color of an image may be rounded.
    if formula == Formula::Rendering {
        all.retain(|expression| !rounds(expression));
    }
    let mut known = HashSet::from([stated.display(scope)]);
    all.retain(|expression| known.insert(expression.display(scope)));
    let changes = all.into_iter().map(EditedForm::Expression);
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
            let elements = indices.map(|index| Expression::Element(*list, Box::new(index)));
            other_lists.chain(elements).collect()
        }
        _ => Vec::new(),
    }
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

/// Changes the distance between the elements of a list that have a constant in their index, such as m[4 + k] and m[8 + k].
fn change_list_strides(expression: &Expression) -> Vec<Expression> {
    const STRIDE: f64 = 4.0;
    let with_stride = |stride: f64| {
        replace_nodes(expression, &|node| match node {
            Expression::Element(list, index) => {
                let scaled = replace_nodes(index, &|part| match part {
                    Expression::Number(offset) => Some(number(offset / STRIDE * stride)),
                    _ => None,
                });
                Some(Expression::Element(*list, Box::new(scaled)))
            }
            _ => None,
        })
    };
    [3.0, 5.0].map(with_stride).to_vec()
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
            // One product of the nested loops is a sum.
            let sum = vec![
                Expression::Address(digits[..index].to_vec()),
                radix.clone(),
                digit.clone(),
            ];
            let outer = (Expression::Sum(sum), radix.clone());
            let inner = digits[index + 1..].iter().cloned();
            all.push(Expression::Address(
                [outer].into_iter().chain(inner).collect(),
            ));
            for multiple in [4.0, 8.0, 2.0] {
                all.push(with_digit(index, digit.clone(), round_up(radix, multiple)));
            }
            for step in [1.0, -1.0] {
                let other = Expression::Sum(vec![radix.clone(), number(step)]);
                all.push(with_digit(index, digit.clone(), other));
            }
        }
    }
    all
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
        use Formula::{Color, FinalCoefficient, LumSample, Plane, Predictor, StoredRow};
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
            (Plane, "mod(residual + predictor - 128, 255)"),
            (Predictor, "invert(displace(reference))"),
            (Predictor, "displace(invert(coded))"),
        ] {
            let is_generated = edit_texts(formula).iter().any(|text| text == expected);
            assert!(is_generated, "{expected} is not generated");
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
