//! The result of one request.

use crate::cases::{Case, Expect};
use crate::dialect::RightDialects;
use crate::protocol::frame::{Answer, TimeLimit};
use crate::protocol::request::AttemptKind;
use crate::test_case::{Allowance, TestCase};

/// The result of one request.
#[derive(Clone, Debug)]
pub struct Observation<C: TestCase = Case> {
    /// The requested view.
    pub view: C::View,
    /// The response of the decoder.
    pub response: Response<C>,
    /// True for a refusal whose exit status may also mean something else.
    pub weak: bool,
    /// Beginning of standard error.
    pub stderr: String,
    /// The kind of attempt that resulted in this response.
    pub attempt: AttemptKind,
    /// In serve mode, the name of the previous request to the same process.
    pub previous_request: Option<String>,
    /// Difference between two answers to this request, if it was repeated and the answers differ.
    pub nondeterminism: Option<Nondeterminism>,
}

impl<C: TestCase> Observation<C> {
    /// Creates the observation of an answer that needed no process.
    pub fn of_answer(
        case: &C,
        built: &C::Built,
        view: &C::View,
        answer: &Answer<C::Output>,
    ) -> Observation<C> {
        Observation {
            view: view.clone(),
            response: Response::new(case, built, view, answer),
            weak: false,
            stderr: String::new(),
            attempt: AttemptKind::Usual,
            previous_request: None,
            nondeterminism: None,
        }
    }

    /// Returns true if the request exceeded the usual time limit, and nothing is known about a higher one.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.attempt != AttemptKind::Alone && self.response.time_limit().is_some()
    }

    /// Returns true if the case fails regardless of other observations. Nondeterminism is not considered.
    #[must_use]
    pub fn is_certain_failure(&self, case: &C) -> bool {
        match (&self.response, case.expect()) {
            _ if self.is_open() => false,
            (Response::Image { right, .. }, Expect::Decode) => {
                *right == RightDialects::Regardless(false)
            }
            (Response::Violation(_), _)
            | (Response::Rejected, Expect::Decode)
            | (Response::Image { .. }, Expect::Reject | Expect::Refuse) => true,
            _ => false,
        }
    }
}

/// Two different answers to one request.
#[derive(Clone, Debug)]
pub struct Nondeterminism {
    /// True if one of the answers is from a serving process.
    pub in_serve_mode: bool,
    /// Description of the difference.
    pub message: String,
}

/// An answer, compared with the expected one.
#[derive(Clone, Debug)]
pub enum Response<C: TestCase = Case> {
    /// An image, or the answer to a texture question.
    Image {
        /// The dialects in which the image is right.
        right: RightDialects,
        /// The difference from the output of the reference, if any.
        difference: Option<C::Difference>,
        /// The tolerance that was applied.
        allowance: Allowance,
        /// The image, if it differs from the reference's.
        frame: Option<C::Output>,
    },
    /// Exit status 65.
    Rejected,
    /// Exit status 69.
    Unsupported,
    /// Any other result, which violates the protocol.
    Violation(Answer<C::Output>),
}

impl<C: TestCase> Response<C> {
    /// Compares an answer with the expected one. `built` is the file that was sent.
    pub fn new(
        case: &C,
        built: &C::Built,
        view: &C::View,
        answer: &Answer<C::Output>,
    ) -> Response<C> {
        match answer {
            Answer::Rejected => Response::Rejected,
            Answer::Unsupported => Response::Unsupported,
            Answer::Decoded(output) => {
                let result = case.compare(built, view, output);
                let differs =
                    result.right != RightDialects::Regardless(true) && result.difference.is_some();
                Response::Image {
                    right: result.right,
                    difference: result.difference,
                    allowance: result.allowance,
                    frame: differs.then(|| output.clone()),
                }
            }
            _ => Response::Violation(answer.clone()),
        }
    }

    /// Returns the time limit that the request exceeded, if it did.
    #[must_use]
    pub const fn time_limit(&self) -> Option<TimeLimit> {
        match self {
            Response::Violation(Answer::TimedOut(limit)) => Some(*limit),
            _ => None,
        }
    }

    /// Returns true if both responses agree in everything that the decoder controls.
    #[must_use]
    pub fn is_equivalent(&self, other: &Response<C>) -> bool {
        match (self, other) {
            (Response::Image { right: a, .. }, Response::Image { right: b, .. }) if a != b => false,
            (Response::Image { frame: a, .. }, Response::Image { frame: b, .. }) => match (a, b) {
                (Some(a), Some(b)) => C::is_equivalent(a, b),
                (a, b) => a.is_none() && b.is_none(),
            },
            (Response::Violation(a), Response::Violation(b)) => a.is_same_kind_as(b),
            _ => std::mem::discriminant(self) == std::mem::discriminant(other),
        }
    }

    /// Returns the image if it differs from the reference's.
    pub const fn wrong_image(&self) -> Option<&C::Output> {
        match self {
            Response::Image { frame, .. } => frame.as_ref(),
            _ => None,
        }
    }

    /// Describes the response.
    pub fn describe(&self) -> String {
        match self {
            Response::Image { difference, .. } => match difference {
                Some(difference) => format!("a wrong image ({difference})"),
                None => "an image".to_owned(),
            },
            Response::Rejected => "a refusal".to_owned(),
            Response::Unsupported => "\"unsupported\"".to_owned(),
            Response::Violation(answer) => answer.describe(),
        }
    }

    /// Returns a short name for reports.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Response::Image { .. } => "decoded",
            Response::Rejected => "rejected",
            Response::Unsupported => "unsupported",
            Response::Violation(answer) => answer.name(),
        }
    }
}
