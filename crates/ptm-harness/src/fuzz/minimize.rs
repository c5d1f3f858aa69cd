//! Minimizes a generated file: every step removes or simplifies a word of its description.

use std::sync::atomic::AtomicBool;

use super::draft::Draft;
use super::shrink::{shrink, smaller_sizes};
use ptm::Size;
use ptm_suite::cases::TableSpelling;

/// Simplifies `draft` step by step while it still `fails`, and returns the smallest draft.
pub fn minimize(
    draft: &Draft,
    table: TableSpelling,
    stop: &AtomicBool,
    fails: &impl Fn(&Draft) -> bool,
) -> Draft {
    let weigh = |draft: &Draft| weight(draft, table);
    shrink(draft.clone(), weigh, simpler_drafts, stop, fails)
}

/// Returns the sizes of the file and of its description, in bytes.
fn weight(draft: &Draft, table: TableSpelling) -> Option<(usize, usize)> {
    let case = draft.cases("draft").ok()?.pop()?;
    let description = draft.to_yaml("", "", None).len();
    Some((case.build(table).file.len(), description))
}

fn simpler_drafts(draft: &Draft) -> Vec<Draft> {
    let (width, height) = (draft.width, draft.height);
    let sizes = smaller_sizes(Size { width, height }).into_iter();
    // A record may be past the new end. The file then cannot be written and is skipped.
    let mut all: Vec<Draft> = sizes
        .map(|Size { width, height }| Draft {
            width,
            height,
            ..draft.clone()
        })
        .collect();
    let mut add = |change: &dyn Fn(&mut Draft)| {
        let mut simpler = draft.clone();
        change(&mut simpler);
        all.push(simpler);
    };
    for (key, word) in &draft.words {
        add(&|draft| drop(draft.words.remove(key)));
        for word in simpler_words(key.1, word) {
            add(&|draft| drop(draft.words.insert(*key, word.clone())));
        }
    }
    let (has_table, is_compressed) = (draft.format.has_table(), draft.format.coding().is_some());
    for (applies, part, key, word) in [
        (true, "", "scale", "1 1 1 1 1 1"),
        (true, "", "bias", "0 0 0 0 0 0"),
        (true, "", "scene", "flat-128"),
        (has_table, "", "entries", "1"),
        (has_table, "", "entries", "2"),
        (has_table, "", "entries", "256"),
        (has_table, "", "entries", "257"),
        (true, "", "matrix", "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"),
        (is_compressed, "compression", "residuals", "gray"),
        (is_compressed, "compression", "parameter", "1"),
    ] {
        if applies {
            add(&|draft| drop(draft.words.insert((part, key), word.to_owned())));
        }
    }
    all
}

/// Returns numbers closer to zero, or lists with one word removed or simplified.
fn simpler_words(key: &str, word: &str) -> Vec<String> {
    let list: Vec<&str> = word.split(' ').collect();
    let mut all = Vec::new();
    // Lists with one number per plane, coefficient or element keep their length.
    let is_fixed = ["scale", "bias", "matrix", "references", "order", "presets"].contains(&key);
    for i in 0..list.len() {
        let mut replace = |words: &[&str]| {
            let (before, after) = (&list[..i], &list[i + 1..]);
            all.push([before, words, after].concat().join(" "));
        };
        if !is_fixed && list.len() > 1 {
            replace(&[]);
        }
        match (key, list[i].parse::<i64>()) {
            ("references", Ok(plane)) if plane >= 0 => replace(&["-1"]),
            ("order" | "references" | "presets", _) => {}
            ("scale" | "matrix", _) => {
                for simple in ["0", "1", "-1", "2"] {
                    replace(&[simple]);
                }
            }
            (_, Ok(number)) => {
                for smaller in [0, 1, -1, number / 2, number - number.signum()] {
                    if smaller != number {
                        replace(&[&smaller.to_string()]);
                    }
                }
            }
            _ => {}
        }
        if let Some((planes, texels)) = list[i].split_once(':') {
            let simple = [
                format!("0:{texels}"),
                format!("{planes}:first"),
                format!("{planes}:last"),
                format!("{planes}:{}", texels.split('+').next().unwrap_or(texels)),
            ];
            for simple in simple.iter().filter(|simple| **simple != list[i]) {
                replace(&[simple]);
            }
        }
    }
    all
}
