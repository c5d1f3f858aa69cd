//! Somebody else's decoder under test.
//!
//! cases → run → compare → judge → diagnose → report. The decoder is only ever spoken to through [`protocol`].
//!
//! What starts programs, and what judges their answers, needs a Unix system; cases and corpus do not.

pub mod cases;

pub mod protocol;

pub mod frames;

#[cfg(unix)]
pub mod processes;

#[cfg(unix)]
pub mod start;

#[cfg(unix)]
pub mod template;

#[cfg(unix)]
pub mod scratch;

#[cfg(unix)]
pub mod run;

#[cfg(unix)]
pub mod serve;

#[cfg(unix)]
pub mod capabilities;

#[cfg(unix)]
pub mod locale;

pub mod compare;

pub mod choices;

#[cfg(unix)]
pub mod judge;

pub mod misreadings;

#[cfg(unix)]
pub mod diagnose;

#[cfg(unix)]
pub mod matrix;

#[cfg(unix)]
pub mod coverage;

#[cfg(unix)]
pub mod smoke;

#[cfg(unix)]
pub mod metamorphic;

#[cfg(unix)]
pub mod files;

#[cfg(unix)]
mod tally;

#[cfg(unix)]
pub mod check;

#[cfg(unix)]
pub mod transform;

pub mod corpus;

#[cfg(unix)]
pub mod outputs;

#[cfg(unix)]
pub mod probe;

#[cfg(unix)]
pub mod report;

#[cfg(unix)]
pub mod shards;

#[cfg(unix)]
pub mod merge;

#[cfg(unix)]
pub mod html;

#[cfg(unix)]
pub mod junit;

#[cfg(unix)]
pub mod badge;

#[cfg(unix)]
pub mod github;

#[cfg(unix)]
pub mod fuzz;

#[cfg(unix)]
pub mod properties;

#[cfg(unix)]
pub mod baseline;

#[cfg(all(unix, test))]
mod other_transforms;

#[cfg(unix)]
pub mod texture;
