//! The result of one request.

use std::fmt::Display;

use crate::cases::Expect;
use crate::compare::Difference;
use crate::dialect::RightDialects;
use crate::protocol::frame::{Answer, Frame, TimeLimit, View};
use crate::protocol::request::AttemptKind;
use crate::test_case::{Allowance, Output, TestCase};
use crate::verdicts::outcome::ResponseKind;

/// The result of a request for a case.
pub type ObservationOf<C> =
    Observation<<C as TestCase>::View, <C as TestCase>::Output, <C as TestCase>::Difference>;

/// The result of one request. `V` is the type of views, `T` that of outputs, and `D` that of their differences.
#[derive(Clone, Debug)]
pub struct Observation<V = View, T = Frame, D = Difference> {
    /// The requested view.
    pub view: V,
    /// The response of the decoder.
    pub response: Response<T, D>,
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

impl<V: Clone, T: Clone, D> Observation<V, T, D> {
    /// Creates the observation of an answer that needed no process. `built` is the file that was sent.
    pub fn of_answer<C: TestCase<View = V, Output = T, Difference = D>>(
        case: &C,
        built: &C::Built,
        view: &V,
        answer: &Answer<T>,
    ) -> Observation<V, T, D> {
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
}

impl<V, T, D> Observation<V, T, D> {
    /// Returns true if the request exceeded the usual time limit, and nothing is known about a higher one.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.attempt != AttemptKind::Alone && self.response.time_limit().is_some()
    }

    /// Returns true if a repetition would not change the verdict. A request that exceeded the time limit has been repeated already,
    /// and would probably exceed it again. If two responses already differ, the case is decided.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        self.nondeterminism.is_some()
            || self.attempt == AttemptKind::Alone
            || self.response.time_limit().is_some()
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

/// An answer, compared with the expected one. `T` is the type of outputs, and `D` that of their differences.
#[derive(Clone, Debug)]
pub enum Response<T = Frame, D = Difference> {
    /// An image, or the answer to a texture question.
    Image {
        /// The dialects in which the image is right.
        right: RightDialects,
        /// The difference from the output of the reference, if any.
        difference: Option<D>,
        /// The tolerance that was applied.
        allowance: Allowance,
        /// The image, unless it equals the reference's.
        frame: Option<T>,
    },
    /// Exit status 65.
    Rejected,
    /// Exit status 69.
    Unsupported,
    /// Any other result, which violates the protocol.
    Violation(Answer<T>),
}

impl<T: Clone, D> Response<T, D> {
    /// Compares an answer with the expected one. `built` is the file that was sent.
    pub fn new<C: TestCase<Output = T, Difference = D>>(
        case: &C,
        built: &C::Built,
        view: &C::View,
        answer: &Answer<T>,
    ) -> Response<T, D> {
        match answer {
            Answer::Rejected => Response::Rejected,
            Answer::Unsupported => Response::Unsupported,
            Answer::Decoded(output) => {
                let result = case.compare(built, view, output);
                // An image of a malformed file is kept, because it shows how the file was read.
                let differs = match result.right {
                    RightDialects::Regardless(is_right) => !is_right,
                    RightDialects::Depends { .. } => result.difference.is_some(),
                };
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
}

impl<T, D> Response<T, D> {
    /// Returns the kind of the response. `is_right` is true if it is an image that is right.
    #[must_use]
    pub const fn kind(&self, is_right: bool) -> ResponseKind {
        match self {
            Response::Image { .. } if is_right => ResponseKind::Expected,
            Response::Image { .. } => ResponseKind::Different,
            Response::Rejected => ResponseKind::Rejected,
            Response::Unsupported => ResponseKind::Unsupported,
            Response::Violation(_) => ResponseKind::Violation,
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

    /// Returns true if the output equals that of the reference, apart from rounding, in all dialects.
    #[must_use]
    pub fn is_expected(&self) -> bool {
        matches!(
            self,
            Response::Image {
                right: RightDialects::Regardless(true),
                difference: None,
                allowance: Allowance::None,
                ..
            }
        )
    }

    /// Returns true if a case with this expected result fails regardless of other observations.
    #[must_use]
    pub fn is_certain_failure(&self, expect: Expect) -> bool {
        match (self, expect) {
            (Response::Image { right, .. }, Expect::Decode) => {
                *right == RightDialects::Regardless(false)
            }
            (Response::Violation(_), _)
            | (Response::Rejected, Expect::Decode)
            | (Response::Image { .. }, Expect::Reject | Expect::Refuse) => true,
            _ => false,
        }
    }

    /// Returns the image unless it equals the reference's. The reference shows no image of a malformed file.
    pub const fn wrong_image(&self) -> Option<&T> {
        match self {
            Response::Image { frame, .. } => frame.as_ref(),
            _ => None,
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

impl<T: Output, D> Response<T, D> {
    /// Returns true if both responses agree in everything that the decoder controls.
    #[must_use]
    pub fn is_equivalent(&self, other: &Response<T, D>) -> bool {
        match (self, other) {
            (Response::Image { right: a, .. }, Response::Image { right: b, .. }) if a != b => false,
            (Response::Image { frame: a, .. }, Response::Image { frame: b, .. }) => match (a, b) {
                (Some(a), Some(b)) => a.is_equivalent(b),
                (a, b) => a.is_none() && b.is_none(),
            },
            (Response::Violation(a), Response::Violation(b)) => a.is_same_kind_as(b),
            _ => std::mem::discriminant(self) == std::mem::discriminant(other),
        }
    }
}

impl<T, D: Display> Response<T, D> {
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
}
