//! Reasons why a question about textures has no value.

/// Reason why a question has no value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NoValue {
    /// The chapter leaves the value to the implementation. Contains the name of the ruling.
    ImplementationDefined(&'static str),
    /// An argument is out of range. Contains a short name of the argument.
    OutOfRange(&'static str),
    /// The method needs a value that is missing. Contains the name of the value.
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
