//! What a decoder with some mistakes makes of a file, listed ones and solved ones.

use std::borrow::Cow;

use super::codecs::file_streams::{acts_on, is_shown};
use super::codecs::stream_slips::StreamSlip;
use super::mistake::Mistake;
use super::planes::slips::{self, PlaneSlip};
use super::solved::{self, Act};
use super::witness::{Witness, applies};
use crate::misreadings::{self, At, Misreading, Stage};
use crate::protocol::frame::{Answer, View};
use crate::ptm::Ptm;
use crate::reading::Reading;
use crate::session::observation::Response;

/// The clauses of the position of a record.
const POSITIONS: [&str; 2] = ["2.9.8/5", "2.9.8/6"];

impl Witness<'_> {
    /// What a decoder with these mistakes answers.
    pub fn answer(&self, mistakes: &[&Mistake]) -> Cow<'_, Answer> {
        let listed = self.listed(mistakes);
        let acts = self.acts(mistakes);
        if acts.is_empty() {
            return self.answer_of_listed(&listed);
        }
        let answer = match self.planes(mistakes) {
            Ok(ptm) => {
                let reading = misreadings::misread(&listed, self.reading);
                let view = &self.observation.view;
                Answer::Decoded(solved::frame(&acts, &ptm, view, &reading))
            }
            Err(answer) => answer,
        };
        let acting = self.acting_slips(&acts);
        match acting.is_empty() {
            true => Cow::Owned(answer),
            false => self.out_of_step(&acting, answer),
        }
    }

    /// The slips in the decoder of streams among these that change a stream of this file.
    fn acting_slips(&self, acts: &[&Act]) -> Vec<StreamSlip> {
        slips_of(acts).filter(|&slip| acts_on(slip, self)).collect()
    }

    /// A decoder that is out of step with a stream shows nonsense of some kind or gives up.
    fn out_of_step(&self, slips: &[StreamSlip], made: Answer) -> Cow<'_, Answer> {
        Cow::Owned(match &self.observation.response {
            Response::Picture {
                frame: Some(shown), ..
            } if self.failed && is_shown(slips, self) => Answer::Decoded(shown.clone()),
            Response::Picture { .. } => made,
            _ if slips.iter().any(|slip| slip.may_refuse()) => Answer::Rejected,
            _ => made,
        })
    }

    /// What of these mistakes the catalog lists and is made in this file.
    fn listed(&self, mistakes: &[&Mistake]) -> Vec<&'static Misreading> {
        let made = mistakes.iter().filter(|mistake| match mistake {
            Mistake::Narrow(_, scope) => scope.holds(self),
            _ => true,
        });
        made.filter_map(|mistake| mistake.listed()).collect()
    }

    /// What of these mistakes is solved and made in this file.
    fn acts<'m>(&self, mistakes: &[&'m Mistake]) -> Vec<&'m Act> {
        let solved = mistakes.iter().filter_map(|mistake| mistake.solved());
        solved
            .filter(|solved| solved.scope.holds(self))
            .map(|solved| &solved.act)
            .collect()
    }

    /// The stored values that a decoder with these mistakes finds; what it answers where it finds none.
    pub fn planes(&self, mistakes: &[&Mistake]) -> Result<Ptm, Answer> {
        let acts = self.acts(mistakes);
        // Of several the first: what all of them show is held against streams, not pictures.
        let stream = self.acting_slips(&acts).first().map(|slip| slip.stream());
        let reading = Reading {
            stream: stream.unwrap_or(self.reading.stream),
            // Where a file was accepted whose index is out of range, another entry than its own was looked up.
            entry: match self.accepts_what_is_refused()
                && acts.iter().any(|act| act.is_of_indices())
            {
                true => |index, entries| (entries > 0).then(|| index.min(entries - 1)),
                false => self.reading.entry,
            },
            ..self.reading
        };
        let listed = self.listed(mistakes);
        let mut ptm = self.misread(&listed, reading)?;
        let slips: Vec<&PlaneSlip> = (acts.iter())
            .filter_map(|act| match act {
                Act::Planes(slip) => Some(slip),
                _ => None,
            })
            .collect();
        if !slips.is_empty() {
            let reading = misreadings::misread(&listed, reading);
            if slips::lack_a_reference(&slips, self, &reading) {
                return Err(Answer::Rejected);
            }
            slips::apply(&slips, &mut ptm, self, &reading);
        }
        for act in acts {
            act.apply(&mut ptm, self)?;
        }
        Ok(ptm)
    }

    /// Whether the decoder shows a picture of a file that must be refused.
    fn accepts_what_is_refused(&self) -> bool {
        self.failed && self.right == Answer::Rejected
    }

    /// Whether a file was refused in which a record stands beyond the plane, as these mistakes read its position. The catalog
    /// ignores such records; many decoders do not.
    pub fn refuses_positions(&self, mistakes: &[&Mistake]) -> bool {
        let mut readers = mistakes.iter().filter_map(|mistake| {
            let listed = mistake.listed()?;
            match listed.at {
                At::Records(read) if POSITIONS.contains(&listed.clause) => Some(read),
                _ => None,
            }
        });
        if !matches!(self.observation.response, Response::Rejected) {
            return false;
        }
        let Some(model) = self.model() else {
            let clauses = &self.case.clauses;
            return readers.next().is_some()
                && clauses
                    .iter()
                    .any(|clause| POSITIONS.contains(&&clause[..]));
        };
        let bytes =
            |&(position, value): &(u32, u8)| position.to_be_bytes().into_iter().chain([value]);
        let planes = model.compressed.iter().flat_map(|coded| &coded.planes);
        let blocks = planes.map(|plane| plane.records.iter().flat_map(bytes).collect());
        let blocks: Vec<Vec<u8>> = blocks.collect();
        readers.any(|read| {
            let is_fewer = |block: &Vec<u8>| {
                let records = read(block, 0, model.size.texels());
                records.is_ok_and(|records| records.len() * 5 < block.len())
            };
            blocks.iter().any(is_fewer)
        })
    }

    /// Whether a mistake could show in the answer at all.
    pub fn concerns(&self, mistake: &Mistake) -> bool {
        let view = &self.observation.view;
        let misreading = match mistake {
            Mistake::Narrow(_, scope) if !scope.holds(self) => return false,
            Mistake::Listed(misreading) | Mistake::Narrow(misreading, _) => misreading,
            Mistake::Solved(solved) => {
                let is_of = |slip: StreamSlip| slip.is_of(self.case.format());
                let is_compressed = self.case.format().is_compressed();
                return solved.act.shows_in(view)
                    && (is_compressed || !matches!(solved.act, Act::Planes(_)))
                    && solved.scope.holds(self)
                    && slips_of(&[&solved.act]).all(is_of);
            }
        };
        let last = match view {
            View::Raw => Stage::Planes,
            View::Coef => Stage::Coefficients,
            View::Rgb(_) => Stage::Color,
        };
        let shows = misreading.at.stage() <= last;
        shows && applies(misreading, &self.built.file)
    }

    /// Whether a mistake could be why the decoder did what it did here: a mistake that only changes values refuses
    /// nothing.
    pub fn could_be(&self, mistake: &Mistake) -> bool {
        let refused = !matches!(self.observation.response, Response::Picture { .. });
        let may_refuse = || {
            let listed = mistake.listed();
            let solved = mistake.solved();
            listed.is_some_and(|misreading| misreading.at.may_refuse())
                || solved.is_some_and(|solved| solved.act.may_refuse())
        };
        self.concerns(mistake) && (!refused || may_refuse())
    }
}

/// The slips in the decoder of streams among these.
fn slips_of<'a>(acts: &'a [&'a Act]) -> impl Iterator<Item = StreamSlip> + 'a {
    acts.iter().filter_map(|act| match act {
        Act::Stream(slip) => Some(*slip),
        _ => None,
    })
}
