//! What one request showed.

use crate::protocol::frame::Answer;
use crate::suite::cases::{Case, Expect};
use crate::suite::dialect::Right;
use crate::suite::test_case::{Allowance, TestCase};

/// What one request showed.
#[derive(Clone, Debug)]
pub struct Observation<C: TestCase = Case> {
    /// The view that was asked for.
    pub view: C::View,
    /// What the decoder did.
    pub response: Response<C>,
    /// Whether it is a refusal by an exit status that also means something else.
    pub weak: bool,
    /// The beginning of its standard error.
    pub stderr: String,
    /// The case that the same process was asked before, where it serves.
    pub after: Option<String>,
    /// How two answers to this request differ, if it was asked for twice and they do.
    pub nondeterminism: Option<Nondeterminism>,
}

impl<C: TestCase> Observation<C> {
    /// Returns true if the call ended in neither a frame nor a refusal, or a serving process did not answer.
    pub(super) fn is_violation(&self) -> bool {
        matches!(self.response, Response::Violation(_)) || self.nondeterminism.is_some()
    }

    /// Whether it will fail, whatever else is seen: a difference between answers apart.
    #[must_use]
    pub fn is_wrong_for(&self, case: &C) -> bool {
        match (&self.response, case.expect()) {
            (Response::Picture { right, .. }, Expect::Decode) => *right == Right::Anyway(false),
            (Response::Violation(_), _)
            | (Response::Rejected, Expect::Decode)
            | (Response::Picture { .. }, Expect::Reject | Expect::Refuse) => true,
            _ => false,
        }
    }
}

/// Two answers to one request.
#[derive(Clone, Debug)]
pub struct Nondeterminism {
    /// Whether one of them is of a serving process.
    pub served: bool,
    /// How they differ.
    pub says: String,
}

/// An answer, compared with the expected one.
#[derive(Clone, Debug)]
pub enum Response<C: TestCase = Case> {
    /// A picture, or another answer to what was asked.
    Picture {
        /// Where it is right: in every dialect, or in some.
        right: Right,
        /// How it differs from the reference's, if it does and there is one.
        difference: Option<C::Difference>,
        /// What room was made for it.
        allowance: Allowance,
        /// The picture itself where it differs.
        frame: Option<C::Output>,
    },
    /// Exit status 65.
    Rejected,
    /// Exit status 69.
    Unsupported,
    /// Anything else.
    Violation(Answer<C::Output>),
}

impl<C: TestCase> Response<C> {
    /// Whether it is the same in all that a decoder is responsible for.
    #[must_use]
    pub fn is_like(&self, other: &Response<C>) -> bool {
        match (self, other) {
            (
                Response::Picture { right, frame, .. },
                Response::Picture {
                    right: other_right,
                    frame: other_frame,
                    ..
                },
            ) => {
                let alike = match (frame, other_frame) {
                    (Some(a), Some(b)) => C::is_like(a, b),
                    (a, b) => a.is_none() && b.is_none(),
                };
                right == other_right && alike
            }
            (Response::Violation(a), Response::Violation(b)) => a.is_of_kind(b),
            _ => std::mem::discriminant(self) == std::mem::discriminant(other),
        }
    }

    /// What it is, in words.
    #[must_use]
    pub fn describe(&self) -> String {
        match self {
            Response::Picture {
                difference: Some(difference),
                ..
            } => format!("a wrong picture ({difference})"),
            Response::Picture { .. } => "a picture".to_owned(),
            Response::Rejected => "a refusal".to_owned(),
            Response::Unsupported => "\"unsupported\"".to_owned(),
            Response::Violation(answer) => answer.describe(),
        }
    }

    /// One or two words for a report.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Response::Picture { .. } => "decoded",
            Response::Rejected => "rejected",
            Response::Unsupported => "unsupported",
            Response::Violation(answer) => answer.name(),
        }
    }
}
