//! Makes a file small while it fails alike.
//!
//! Every step takes a word away or makes one smaller. The smallest file goes first, so that a step which cuts the
//! picture in half is tried before one that tidies a number.

use std::sync::atomic::{AtomicBool, Ordering};

use super::draft::{Draft, Words};
use crate::harness::cases::TableSpelling;

/// Questions after which the file is small enough.
const PATIENCE: usize = 3000;

/// The smallest draft reached from `draft` by steps after each of which it still `fails`.
pub fn minimise(
    draft: &Draft,
    table: TableSpelling,
    stop: &AtomicBool,
    fails: &impl Fn(&Draft) -> bool,
) -> Draft {
    let mut smallest = draft.clone();
    let mut weight = weigh(&smallest, table).unwrap_or((usize::MAX, usize::MAX));
    let mut asked = 0;
    loop {
        let mut steps: Vec<((usize, usize), Draft)> = steps(&smallest)
            .into_iter()
            .filter_map(|draft| Some((weigh(&draft, table)?, draft)))
            .filter(|(lighter, _)| *lighter < weight)
            .collect();
        steps.sort_by_key(|(weight, _)| *weight);
        let next = steps.into_iter().find(|(_, draft)| {
            asked += 1;
            asked <= PATIENCE && !stop.load(Ordering::Relaxed) && fails(draft)
        });
        match next {
            Some((lighter, draft)) => (weight, smallest) = (lighter, draft),
            None => return smallest,
        }
    }
}

/// Bytes of the file, and of the words that make it.
fn weigh(draft: &Draft, table: TableSpelling) -> Option<(usize, usize)> {
    let case = draft.cases("weighed").ok()?.pop()?;
    let words = draft.to_yaml("", "").len();
    Some((case.build(table).file.len(), words))
}

/// Everything that is one step simpler.
fn steps(draft: &Draft) -> Vec<Draft> {
    let mut all = sizes(draft);
    let with = |change: &dyn Fn(&mut Draft)| {
        let mut simpler = draft.clone();
        change(&mut simpler);
        simpler
    };
    let parts: [fn(&mut Draft) -> &mut Words; 3] = [
        |draft| &mut draft.make,
        |draft| &mut draft.compression,
        |draft| &mut draft.spelling,
    ];
    for part in parts {
        for (key, word) in part(&mut draft.clone()).clone() {
            all.push(with(&|draft| {
                part(draft).remove(key);
            }));
            all.extend(simpler_words(key, &word).into_iter().map(|word| {
                with(&|draft| {
                    part(draft).insert(key, word.clone());
                })
            }));
        }
    }
    for (key, words) in [
        ("scale", "1 1 1 1 1 1"),
        ("bias", "0 0 0 0 0 0"),
        ("scene", "flat-128"),
    ] {
        all.push(with(&|draft| {
            draft.make.insert(key, words.to_owned());
        }));
    }
    if draft.format.has_table() {
        for entries in ["1", "2", "256", "257"] {
            all.push(with(&|draft| {
                draft.make.insert("entries", entries.to_owned());
            }));
        }
    }
    all.push(with(&|draft| {
        draft
            .make
            .insert("matrix", "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1".to_owned());
    }));
    if draft.format.is_compressed() {
        for (key, word) in [("residuals", "gray"), ("parameter", "1")] {
            all.push(with(&|draft| {
                draft.compression.insert(key, word.to_owned());
            }));
        }
    }
    all
}

/// Narrower, lower, or both; and turned, where a strip stands upright.
fn sizes(draft: &Draft) -> Vec<Draft> {
    let smaller = |side: u32| {
        let mut sides = vec![
            1,
            2,
            side / 2,
            side - side / 4,
            side.saturating_sub(8),
            side.saturating_sub(1),
        ];
        sides.retain(|&smaller| (1..side).contains(&smaller));
        sides.push(side);
        sides.dedup();
        sides
    };
    let mut all = Vec::new();
    for width in smaller(draft.width) {
        for height in smaller(draft.height) {
            let mut draft = draft.clone();
            // Records may stand past the end of what is left; such a file cannot be written and is passed over.
            (draft.width, draft.height) = (width, height);
            all.push(draft);
        }
    }
    all
}

/// A number nearer to nothing, or a list with one word less or one word simpler.
fn simpler_words(key: &str, word: &str) -> Vec<String> {
    let list: Vec<&str> = word.split(' ').collect();
    let mut all = Vec::new();
    // Lists with a number for each plane, coefficient or element keep their length.
    let fixed = ["scale", "bias", "matrix", "references", "order", "presets"].contains(&key);
    for place in 0..list.len() {
        let mut replace = |words: &[&str]| {
            let (before, after) = (&list[..place], &list[place + 1..]);
            all.push([before, words, after].concat().join(" "));
        };
        if !fixed && list.len() > 1 {
            replace(&[]);
        }
        match (key, list[place].parse::<i64>()) {
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
        if let Some((planes, texels)) = list[place].split_once(':') {
            let simple = [
                format!("0:{texels}"),
                format!("{planes}:first"),
                format!("{planes}:last"),
                format!("{planes}:{}", texels.split('+').next().unwrap_or(texels)),
            ];
            for simple in simple.iter().filter(|simple| **simple != list[place]) {
                replace(&[simple]);
            }
        }
    }
    all
}
