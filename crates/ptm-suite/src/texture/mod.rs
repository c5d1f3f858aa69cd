//! Texture stages under test: the cases of `spec-cases/texture`, requested one by one.
//!
//! The protocol is PTM-CP 1 with an additional view:
//!
//! ```text
//! DECODER [ARG…] texture FILE
//! ```
//! FILE is a question in JSON, and the answer on standard output is a JSON object, because nearly every language can read and
//! write JSON without a library. The exit status is 0 for an answer, 65 for a question outside the valid range, and 69 for one
//! that is not supported. `spec-cases/texture/README.md` lists every field.

pub mod cases;
pub mod choices;
pub mod compare;
pub mod expected;
pub mod fixtures;
pub mod judge;
pub mod question;
pub mod verify;
