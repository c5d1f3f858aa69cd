//! Somebody else's decoder under test.
//!
//! cases → run → compare → judge → diagnose → report. The decoder is only ever spoken to through [`protocol`].

pub mod cases;

pub mod protocol;

pub mod processes;

pub mod run;

pub mod compare;

pub mod choices;

pub mod judge;

pub mod misreadings;

pub mod diagnose;

pub mod matrix;

pub mod check;

pub mod corpus;

pub mod report;
