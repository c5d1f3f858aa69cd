//! The generator of a run: equal seeds give equal files.

use std::collections::BTreeMap;

use arbitrary::Unstructured;

use super::draft::{Draft, DraftDamage};
use crate::ptm::Format;
use crate::suite::cases::{Expect, Suite};

/// One in this number of files is damaged and must be refused.
const FILES_PER_DAMAGE: u32 = 6;
/// Number of random bytes for one file.
const RANDOM_BYTES: usize = 2048;

/// The generator of files.
pub struct DraftGenerator {
    /// Damages after which a file of a format must be refused, whatever its contents.
    damages: Vec<(Format, DraftDamage)>,
}

impl DraftGenerator {
    /// Creates a generator of legal files, and of damages with the same expected result in all cases of the suite.
    #[must_use]
    pub fn new(suite: &Suite) -> DraftGenerator {
        let mut expected: BTreeMap<(Format, &'static str), Vec<Expect>> = BTreeMap::new();
        for case in &suite.cases {
            if let Some(damage) = case.damage() {
                let place = expected.entry((case.format(), damage.name.as_str()));
                place.or_default().push(case.expect);
            }
        }
        let damage = |((format, name), expects): (_, Vec<Expect>)| {
            let expect = expects[0];
            let settled = matches!(expect, Expect::Reject | Expect::Refuse)
                && expects.iter().all(|&other| other == expect);
            settled.then_some((format, DraftDamage { name, expect }))
        };
        DraftGenerator {
            damages: expected.into_iter().filter_map(damage).collect(),
        }
    }

    /// Generates file `number`, which is legal or damaged.
    #[must_use]
    pub fn file(&self, seed: u64, number: u64) -> Option<Draft> {
        let bytes = random_bytes(seed, number);
        self.draw(&mut Unstructured::new(&bytes)).ok()
    }

    fn draw(&self, u: &mut Unstructured) -> arbitrary::Result<Draft> {
        let mut draft = Draft::draw(u)?;
        if u.ratio(1, FILES_PER_DAMAGE)? {
            let fitting: Vec<DraftDamage> = self
                .damages
                .iter()
                .filter(|(format, _)| *format == draft.format)
                .map(|&(_, damage)| damage)
                .collect();
            if !fitting.is_empty() {
                draft.damage = Some(*u.choose(&fitting)?);
            }
        }
        Ok(draft)
    }
}

/// Returns the random bytes for file `number`, from `SplitMix64` seeded with both numbers.
pub(super) fn random_bytes(seed: u64, number: u64) -> Vec<u8> {
    let mut state = seed ^ number.wrapping_mul(0xd134_2543_de82_ef95);
    let mut next = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    };
    (0..RANDOM_BYTES / 8)
        .flat_map(|_| next().to_le_bytes())
        .collect()
}
