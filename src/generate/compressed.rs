//! §2.9 Compressed Data
//!
//! Not written yet; no recipe of these formats is accepted ([`super::recipe`]).

use super::output::Output;
use super::scene::Model;

pub(super) fn write(_model: &Model, _out: &mut Output) {
    unreachable!("Recipe::check refuses compressed formats")
}
