//! Suggestions for misspelled names.

/// Returns "; did you mean …?", or nothing.
pub fn did_you_mean<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> String {
    match nearest(name, known) {
        near if near.is_empty() => String::new(),
        near => format!("; did you mean {}?", near.join(" or ")),
    }
}

/// Returns at most three names that are similar to `id`, or begin with it, the nearest first.
pub fn nearest<'a>(id: &str, known: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let asked = id.to_lowercase();
    let mut near: Vec<(f64, &str)> = known
        .map(|name| {
            let likeness = strsim::jaro_winkler(&asked, &name.to_lowercase());
            let within = asked.len() >= 4 && name.to_lowercase().contains(&asked);
            (if within { likeness.max(0.9) } else { likeness }, name)
        })
        .filter(|(likeness, _)| *likeness >= 0.88)
        .collect();
    near.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(b.1)));
    near.dedup_by_key(|(_, name)| *name);
    near.into_iter().take(3).map(|(_, name)| name).collect()
}
