//! Suggestions for misspelled names.

/// Returns "; did you mean …?" with at most three names that are similar to `name` or contain it, most similar first, or an
/// empty string if there are none.
pub fn did_you_mean<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> String {
    let wanted = name.to_lowercase();
    let similarity = |name: &str| {
        let name = name.to_lowercase();
        let is_part = wanted.len() >= 4 && name.contains(&wanted);
        let least = if is_part { 0.9 } else { 0.0 };
        strsim::jaro_winkler(&wanted, &name).max(least)
    };
    let mut near: Vec<(f64, &str)> = known.map(|name| (similarity(name), name)).collect();
    near.retain(|(similarity, _)| *similarity >= 0.88);
    near.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(b.1)));
    near.dedup_by_key(|(_, name)| *name);
    let near: Vec<&str> = near.into_iter().take(3).map(|(_, name)| name).collect();
    match near.is_empty() {
        true => String::new(),
        false => format!("; did you mean {}?", near.join(" or ")),
    }
}
