//! Reasons why a question about textures has no value.

/// The reason why there is no value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NoValue {
    /// The chapter leaves it to the implementation; with the ruling that says so.
    ImplementationDefined(&'static str),
    /// The question is out of the valid range; with a short name of the value.
    OutOfRange(&'static str),
    /// The method needs a value that is missing; with its name.
    Missing(&'static str),
}

impl std::fmt::Display for NoValue {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            NoValue::ImplementationDefined(ruling) => {
                write!(f, "left to the implementation (ruling {ruling})")
            }
            NoValue::OutOfRange(what) => write!(f, "out of range: {what}"),
            NoValue::Missing(what) => write!(f, "the method needs {what}"),
        }
    }
}

impl std::error::Error for NoValue {}
