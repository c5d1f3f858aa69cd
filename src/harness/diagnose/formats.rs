//! Formats of which nothing is read: their failures have one cause, or none that files could tell.

use super::refusals::{deed_of, deeds, example};
use super::witness::Witness;
use super::{Diagnosis, Kind};
use crate::harness::cases::Expect;
use crate::ptm::Format;

/// One diagnosis for each format that fails in more than one way. Its failures are taken out of `left`.
pub(super) fn describe(witnesses: &[Witness], left: &mut Vec<usize>) -> Vec<Diagnosis> {
    let mut diagnoses = Vec::new();
    for format in Format::ALL {
        let is_legal = |w: usize| {
            let case = witnesses[w].case;
            case.format() == format && case.expect == Expect::Decode
        };
        let all_open = (0..witnesses.len())
            .filter(|&w| is_legal(w))
            .all(|w| left.contains(&w));
        let of: Vec<usize> = left
            .iter()
            .copied()
            .filter(|&w| witnesses[w].case.format() == format)
            .collect();
        let wrong = of
            .iter()
            .filter(|&&w| deed_of(&witnesses[w]).is_none())
            .count();
        let mut ways: Vec<String> = deeds(witnesses, &of)
            .into_iter()
            .map(|deed| {
                let like = |&&w: &&usize| deed_of(&witnesses[w]).as_ref() == Some(&deed);
                format!("{} {}", deed.verb, of.iter().filter(like).count())
            })
            .collect();
        if wrong > 0 {
            ways.push(format!("shows wrong pictures of {wrong}"));
        }
        if !all_open || ways.len() < 2 {
            continue;
        }
        left.retain(|w| !of.contains(w));
        let effect = format!(
            "reads no file of format {}: it {}",
            format.short_name(),
            ways.join(", ")
        );
        let mend = "begin with the smallest file, the example".to_owned();
        let said = (effect, mend, example(witnesses, &of));
        let diagnosis = Diagnosis::described(Kind::Difference, witnesses, &of, said);
        diagnoses.push(diagnosis.about(clause(format)));
    }
    diagnoses
}

/// Where the text says how a format's data lies.
const fn clause(format: Format) -> &'static str {
    match format {
        Format::Rgb => "2.7.1/1",
        Format::Lum => "2.7.2/1",
        Format::Lrgb => "2.7.3/1",
        Format::PtmLut => "2.8.1/1",
        Format::PtmCLut => "2.8.2/1",
        _ => "2.9/1",
    }
}
