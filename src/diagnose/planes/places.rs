//! Where in a file planes are rebuilt otherwise: in which planes, and at which of their samples.

use super::rules::Coding;
use crate::reading::Reading;

/// A part of the planes of every file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::diagnose) struct Place {
    /// All of these hold of the plane.
    pub planes: Vec<PlaneIs>,
    /// This holds of the sample, by its place in the list.
    pub sample: Option<usize>,
}

/// What may hold of a plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnose) enum PlaneIs {
    /// By its place in the list.
    Listed(usize),
    /// It has this number or a higher one.
    From(usize),
    /// It has this number or a lower one.
    UpTo(usize),
    /// A part of its vector is longer than this, along rows, or along columns.
    Longer(i64),
}

/// A thing that may hold of a plane.
pub(in crate::diagnose) struct PlaneTrait {
    /// Completes "planes …".
    pub says: &'static str,
    /// What it is about.
    pub clause: &'static str,
    pub holds: fn(&Coding, usize) -> bool,
}

/// A thing that may hold of a sample.
pub(in crate::diagnose) struct SampleTrait {
    /// Completes "where …".
    pub says: &'static str,
    /// What it is about.
    pub clause: &'static str,
    pub holds: fn(&Sample) -> bool,
}

/// What a sample is made of, as it should be.
pub(in crate::diagnose) struct Sample {
    pub residual: u8,
    /// Of its own place; of the plane that it is predicted from.
    pub reference: Option<u8>,
    /// Residual + predictor − 128.
    pub sum: i32,
    /// How far beyond the first column, the last, the first stored row, the last the vector leads.
    pub beyond: [i64; 4],
    /// The value of the record for it, and that of the record before.
    pub record: Option<(u8, Option<u8>)>,
    pub column: i64,
    pub row: i64,
    pub width: i64,
    pub height: i64,
}

fn motion(coding: &Coding, i: usize) -> (i64, i64) {
    coding.planes[i].step.motion
}

fn transform(coding: &Coding, i: usize) -> u8 {
    let step = &coding.planes[i].step;
    u8::from(step.inverted) + 2 * u8::from(step.moved)
}

fn reference(coding: &Coding, i: usize) -> Option<usize> {
    coding.planes[i].step.reference
}

const fn is_odd(part: i64) -> bool {
    part & 1 != 0
}

const fn is_negative_odd(part: i64) -> bool {
    part < 0 && is_odd(part)
}

pub(in crate::diagnose) const LAST: &str = "that are the last one of the file";

/// What may hold of planes, the widest first.
#[rustfmt::skip]
pub(in crate::diagnose) const PLANES: &[PlaneTrait] = &[
    PlaneTrait { says: "that are predicted", clause: "2.9.5/4", holds: |c, i| reference(c, i).is_some() },
    PlaneTrait { says: "that are not predicted", clause: "2.9.5/4", holds: |c, i| reference(c, i).is_none() },
    PlaneTrait { says: "of transform 0", clause: "2.9.5/4", holds: |c, i| transform(c, i) == 0 },
    PlaneTrait { says: "of transform 1", clause: "2.9.2/3", holds: |c, i| transform(c, i) == 1 },
    PlaneTrait { says: "of transform 2", clause: "2.9.3/2", holds: |c, i| transform(c, i) == 2 },
    PlaneTrait { says: "of transform 3", clause: "2.9.3/2", holds: |c, i| transform(c, i) == 3 },
    PlaneTrait { says: "predicted from an inverted reference", clause: "2.9.2/3", holds: |c, i| reference(c, i).is_some() && transform(c, i) & 1 != 0 },
    PlaneTrait { says: "predicted from a reference that is not inverted", clause: "2.9.2/3", holds: |c, i| reference(c, i).is_some() && transform(c, i) & 1 == 0 },
    PlaneTrait { says: "whose reference is moved", clause: "2.9.3/2", holds: |c, i| reference(c, i).is_some() && transform(c, i) & 2 != 0 },
    PlaneTrait { says: "with a vector whose x is 0", clause: "2.9.3/2", holds: |c, i| motion(c, i).0 == 0 },
    PlaneTrait { says: "with a vector whose y is 0", clause: "2.9.3/2", holds: |c, i| motion(c, i).1 == 0 },
    PlaneTrait { says: "with a vector whose x is not 0", clause: "2.9.3/2", holds: |c, i| motion(c, i).0 != 0 },
    PlaneTrait { says: "with a vector whose y is not 0", clause: "2.9.3/2", holds: |c, i| motion(c, i).1 != 0 },
    PlaneTrait { says: "with a vector of which neither x nor y is 0", clause: "2.9.3/2", holds: |c, i| motion(c, i).0 != 0 && motion(c, i).1 != 0 },
    PlaneTrait { says: "with a vector whose x and y have opposite signs", clause: "2.9.3/2", holds: |c, i| motion(c, i).0.signum() * motion(c, i).1.signum() < 0 },
    PlaneTrait { says: "with a vector whose x and y have the same sign", clause: "2.9.3/2", holds: |c, i| motion(c, i).0.signum() * motion(c, i).1.signum() > 0 },
    PlaneTrait { says: "with a vector whose x is below 0", clause: "2.9.3/2", holds: |c, i| motion(c, i).0 < 0 },
    PlaneTrait { says: "with a vector whose y is below 0", clause: "2.9.3/2", holds: |c, i| motion(c, i).1 < 0 },
    PlaneTrait { says: "with a vector of which x or y is below 0", clause: "2.9.3/2", holds: |c, i| motion(c, i).0 < 0 || motion(c, i).1 < 0 },
    PlaneTrait { says: "with a vector whose x is over 0", clause: "2.9.3/2", holds: |c, i| motion(c, i).0 > 0 },
    PlaneTrait { says: "with a vector whose y is over 0", clause: "2.9.3/2", holds: |c, i| motion(c, i).1 > 0 },
    PlaneTrait { says: "with a vector whose x is odd", clause: "2.9.3/2", holds: |c, i| is_odd(motion(c, i).0) },
    PlaneTrait { says: "with a vector whose y is odd", clause: "2.9.3/2", holds: |c, i| is_odd(motion(c, i).1) },
    PlaneTrait { says: "with a vector of which x or y is odd", clause: "2.9.3/2", holds: |c, i| is_odd(motion(c, i).0) || is_odd(motion(c, i).1) },
    PlaneTrait { says: "with a vector of which x and y are odd", clause: "2.9.3/2", holds: |c, i| is_odd(motion(c, i).0) && is_odd(motion(c, i).1) },
    PlaneTrait { says: "with a vector of which x alone is odd", clause: "2.9.3/2", holds: |c, i| is_odd(motion(c, i).0) && !is_odd(motion(c, i).1) },
    PlaneTrait { says: "with a vector of which y alone is odd", clause: "2.9.3/2", holds: |c, i| !is_odd(motion(c, i).0) && is_odd(motion(c, i).1) },
    PlaneTrait { says: "with a vector of which x and y are even", clause: "2.9.3/2", holds: |c, i| !is_odd(motion(c, i).0) && !is_odd(motion(c, i).1) },
    PlaneTrait { says: "with a vector of which x or y is odd and below 0", clause: "2.9.3/2", holds: |c, i| is_negative_odd(motion(c, i).0) || is_negative_odd(motion(c, i).1) },
    PlaneTrait { says: "with two or more records of side information", clause: "2.9.8/8", holds: |c, i| c.planes[i].records.len() > 1 },
    PlaneTrait { says: "with 256 or more records of side information", clause: "2.9.8/8", holds: |c, i| c.planes[i].records.len() > 255 },
    PlaneTrait { says: "with side information", clause: "2.9.8/8", holds: |c, i| !c.planes[i].records.is_empty() },
    PlaneTrait { says: "without side information", clause: "2.9.8/8", holds: |c, i| c.planes[i].records.is_empty() },
    PlaneTrait { says: "predicted from a plane with a higher number", clause: "2.9.5/4", holds: |c, i| reference(c, i).is_some_and(|j| j > i) },
    PlaneTrait { says: "predicted from a plane with a lower number", clause: "2.9.5/4", holds: |c, i| reference(c, i).is_some_and(|j| j < i) },
    PlaneTrait { says: "predicted from plane 0", clause: "2.9.5/4", holds: |c, i| reference(c, i) == Some(0) },
    PlaneTrait { says: "predicted from a plane that is not predicted itself", clause: "2.9.5/4", holds: |c, i| reference(c, i).is_some_and(|j| reference(c, j).is_none()) },
    PlaneTrait { says: "predicted from a plane that is predicted itself", clause: "2.9.5/4", holds: |c, i| reference(c, i).is_some_and(|j| reference(c, j).is_some()) },
    PlaneTrait { says: "predicted from a plane with side information", clause: "2.9.8/8", holds: |c, i| reference(c, i).is_some_and(|j| !c.planes[j].records.is_empty()) },
    PlaneTrait { says: LAST, clause: "2.9.5/4", holds: |c, i| i + 1 == c.planes.len() },
    PlaneTrait { says: "of stored colors", clause: "2.9.5/4", holds: |c, i| c.planes.len() == 9 && i > 5 },
    PlaneTrait { says: "of coefficients", clause: "2.9.5/4", holds: |c, i| c.planes.len() == 18 || i < 6 },
    PlaneTrait { says: "of green and of blue in files of eighteen planes", clause: "2.9.5/4", holds: |c, i| c.planes.len() == 18 && i > 5 },
    PlaneTrait { says: "with a rank over 0", clause: "2.9.4/3", holds: |c, i| c.planes[i].rank > 0 },
    PlaneTrait { says: "with the rank 0", clause: "2.9.4/3", holds: |c, i| c.planes[i].rank == 0 },
    PlaneTrait { says: "with the numbers 6 to 8, counted from 0", clause: "2.9.5/4", holds: |_, i| (6..9).contains(&i) },
    PlaneTrait { says: "with an odd number, counted from 0", clause: "2.9.5/4", holds: |_, i| i % 2 == 1 },
    PlaneTrait { says: "with an even number, counted from 0", clause: "2.9.5/4", holds: |_, i| i % 2 == 0 },
    PlaneTrait { says: "that are JPEG streams", clause: "2.9.5/4", holds: |c, _| !c.is_jpeg_ls },
    PlaneTrait { says: "that are JPEG-LS streams", clause: "2.9.5/4", holds: |c, _| c.is_jpeg_ls },
    PlaneTrait { says: "that are JPEG-LS streams, in files of a parameter over 0", clause: "2.9.5/4", holds: |c, _| c.is_jpeg_ls && c.parameter > 0 },
    PlaneTrait { says: "that are JPEG-LS streams, in files of parameter 0", clause: "2.9.5/4", holds: |c, _| c.is_jpeg_ls && c.parameter == 0 },
    PlaneTrait { says: "of maps that are not square", clause: "2.9.5/4", holds: |c, _| c.size.width != c.size.height },
    PlaneTrait { says: "of files with nine planes", clause: "2.9.5/4", holds: |c, _| c.planes.len() == 9 },
    PlaneTrait { says: "of files with eighteen planes", clause: "2.9.5/4", holds: |c, _| c.planes.len() == 18 },
];

/// What may hold of samples, the widest first.
#[rustfmt::skip]
pub(in crate::diagnose) const SAMPLES: &[SampleTrait] = &[
    SampleTrait { says: "residual + predictor − 128 is below 0", clause: "2.9.5/4", holds: |s| s.sum < 0 },
    SampleTrait { says: "residual + predictor − 128 is over 255", clause: "2.9.5/4", holds: |s| s.sum > 255 },
    SampleTrait { says: "residual + predictor − 128 is below 0 or over 255", clause: "2.9.5/4", holds: |s| s.sum < 0 || s.sum > 255 },
    SampleTrait { says: "the reference is 0", clause: "2.9.5/4", holds: |s| s.reference == Some(0) },
    SampleTrait { says: "the reference is 255", clause: "2.9.5/4", holds: |s| s.reference == Some(255) },
    SampleTrait { says: "the residual is 0", clause: "2.9.5/4", holds: |s| s.residual == 0 },
    SampleTrait { says: "the residual is 255", clause: "2.9.5/4", holds: |s| s.residual == 255 },
    SampleTrait { says: "the residual is 128", clause: "2.9.5/4", holds: |s| s.residual == 128 },
    SampleTrait { says: "the reference is over 127", clause: "2.9.5/4", holds: |s| s.reference.is_some_and(|r| r > 127) },
    SampleTrait { says: "the reference is below 128", clause: "2.9.5/4", holds: |s| s.reference.is_some_and(|r| r < 128) },
    SampleTrait { says: "a record stands", clause: "2.9.8/8", holds: |s| s.record.is_some() },
    SampleTrait { says: "a record has the value 255", clause: "2.9.8/8", holds: |s| s.record.is_some_and(|(value, _)| value == 255) },
    SampleTrait { says: "a record has the value 0", clause: "2.9.8/8", holds: |s| s.record.is_some_and(|(value, _)| value == 0) },
    SampleTrait { says: "a record has the value of the record before", clause: "2.9.8/8", holds: |s| s.record.is_some_and(|(value, before)| before == Some(value)) },
    SampleTrait { says: "the vector leads beyond an edge", clause: "2.9.3/6", holds: |s| s.beyond != [0; 4] },
    SampleTrait { says: "the vector leads beyond the first column", clause: "2.9.3/6", holds: |s| s.beyond[0] > 0 },
    SampleTrait { says: "the vector leads beyond the last column", clause: "2.9.3/6", holds: |s| s.beyond[1] > 0 },
    SampleTrait { says: "the vector leads beyond the first stored row", clause: "2.9.3/6", holds: |s| s.beyond[2] > 0 },
    SampleTrait { says: "the vector leads beyond the last stored row", clause: "2.9.3/6", holds: |s| s.beyond[3] > 0 },
    SampleTrait { says: "the vector leads two columns or more beyond the first one", clause: "2.9.3/6", holds: |s| s.beyond[0] > 1 },
    SampleTrait { says: "the vector leads two columns or more beyond the last one", clause: "2.9.3/6", holds: |s| s.beyond[1] > 1 },
    SampleTrait { says: "the vector leads two rows or more beyond the first stored one", clause: "2.9.3/6", holds: |s| s.beyond[2] > 1 },
    SampleTrait { says: "the vector leads two rows or more beyond the last stored one", clause: "2.9.3/6", holds: |s| s.beyond[3] > 1 },
    SampleTrait { says: "the vector leads one column beyond the last one", clause: "2.9.3/6", holds: |s| s.beyond[1] == 1 },
    SampleTrait { says: "the vector leads one row beyond the last stored one", clause: "2.9.3/6", holds: |s| s.beyond[3] == 1 },
    SampleTrait { says: "the sample is one of the first column", clause: "2.9.5/4", holds: |s| s.column == 0 },
    SampleTrait { says: "the sample is one of the last column", clause: "2.9.5/4", holds: |s| s.column == s.width - 1 },
    SampleTrait { says: "the sample is one of the first stored row", clause: "2.9.5/4", holds: |s| s.row == 0 },
    SampleTrait { says: "the sample is one of the last stored row", clause: "2.9.5/4", holds: |s| s.row == s.height - 1 },
];

impl PlaneIs {
    pub fn holds(self, coding: &Coding, i: usize) -> bool {
        match self {
            PlaneIs::Listed(listed) => (PLANES[listed].holds)(coding, i),
            PlaneIs::From(first) => i >= first,
            PlaneIs::UpTo(last) => i <= last,
            PlaneIs::Longer(most) => {
                let (x, y) = motion(coding, i);
                x.saturating_abs().max(y.saturating_abs()) > most
            }
        }
    }

    fn says(self) -> String {
        match self {
            PlaneIs::Listed(listed) => PLANES[listed].says.to_owned(),
            PlaneIs::From(first) => format!("with number {first} or a higher one, from 0"),
            PlaneIs::UpTo(last) => format!("with number {last} or a lower one, from 0"),
            PlaneIs::Longer(most) => {
                format!("with a vector of which x or y is over {most} or below −{most}")
            }
        }
    }
}

impl Place {
    pub fn holds_of_plane(&self, coding: &Coding, i: usize) -> bool {
        self.planes.iter().all(|one| one.holds(coding, i))
    }

    /// What it is about.
    pub fn clause(&self) -> &'static str {
        match (self.sample, self.planes.first()) {
            (Some(sample), _) => SAMPLES[sample].clause,
            (None, Some(&PlaneIs::Listed(listed))) => PLANES[listed].clause,
            _ => "2.9.5/4",
        }
    }

    /// ", only in planes …, where …"; nothing for all.
    pub fn says(&self) -> String {
        let planes: Vec<String> = self.planes.iter().map(|one| one.says()).collect();
        let planes = match planes.is_empty() {
            true => String::new(),
            false => format!(" in planes {}", planes.join(" and ")),
        };
        match self.sample.map(|sample| SAMPLES[sample].says) {
            Some(says) => format!(", only{planes} where {says}"),
            None if planes.is_empty() => String::new(),
            None => format!(", only{planes}"),
        }
    }
}

impl Coding {
    /// What sample `at` of plane `i` is made of, where all other planes are as `planes` says; `predictor` is what the
    /// plane is predicted with.
    pub fn sample(
        &self,
        (i, at): (usize, usize),
        planes: &[Vec<u8>],
        predictor: &[u8],
        reading: &Reading,
    ) -> Sample {
        let plane = &self.planes[i];
        let (width, height) = (i64::from(self.size.width), i64::from(self.size.height));
        let (column, row) = (at as i64 % width, at as i64 / width);
        let records = &plane.records;
        let position = |record: &[u8; 5]| {
            u32::from_be_bytes([record[0], record[1], record[2], record[3]]) as usize
        };
        let found = records.iter().rposition(|record| position(record) == at);
        let value = |place: usize| records[place][4];
        let beyond = match plane.step.reference {
            Some(_) => self.beyond(i, column, row, reading),
            None => [0; 4],
        };
        Sample {
            residual: plane.residuals[at],
            reference: plane.step.reference.map(|reference| planes[reference][at]),
            sum: match plane.step.reference {
                Some(_) => i32::from(plane.residuals[at]) + i32::from(predictor[at]) - 128,
                None => 0,
            },
            beyond,
            record: found.map(|place| (value(place), place.checked_sub(1).map(value))),
            column,
            row,
            width,
            height,
        }
    }
}
