//! Errors of all crates: what was asked, what came, what was expected.

/// Result of every fallible function of these crates.
pub type Result<T> = std::result::Result<T, Error>;

/// A refused argument, description or file.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// An argument outside what the function can take.
    #[error("{argument}: expected {expected}, got {received}")]
    Argument {
        /// Name of the argument as the caller knows it.
        argument: String,
        /// What came.
        received: String,
        /// What was expected.
        expected: String,
    },
    /// A text that does not describe what it should.
    #[error("{format}: {message}")]
    Description {
        /// The format of the text, such as URDF.
        format: &'static str,
        /// What is wrong with it, and where.
        message: String,
    },
    /// The caller asked to stop before all targets were processed.
    #[error("interrupted before all targets were processed")]
    Interrupted,
}

impl Error {
    /// An [`Error::Argument`] from anything printable.
    pub fn argument(
        argument: impl Into<String>,
        expected: impl Into<String>,
        received: impl ToString,
    ) -> Self {
        Self::Argument {
            argument: argument.into(),
            received: received.to_string(),
            expected: expected.into(),
        }
    }
}
