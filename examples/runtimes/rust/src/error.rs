//! The error of the public calls.

use crate::axis;
use std::fmt;

/// What was wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorKind {
    /// A file is missing, damaged, of another format, or does not fit the others.
    File,
    /// A value that the tables do not hold.
    Value,
}

/// What was found, and what is allowed, in one line.
#[derive(Clone, Debug)]
pub struct Error {
    kind: ErrorKind,
    message: String,
}

/// The result of a call.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// What was wrong.
    pub fn kind(&self) -> ErrorKind {
        self.kind
    }
}

impl fmt::Display for Error {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str(&self.message)
    }
}

impl std::error::Error for Error {}

fn of<T>(kind: ErrorKind, result: axis::Result<T>) -> Result<T> {
    result.map_err(|error| Error { kind, message: error.to_string().replace(char::is_control, "?") })
}

/// The result of what reads a file.
pub(crate) fn of_file<T>(result: axis::Result<T>) -> Result<T> {
    of(ErrorKind::File, result)
}

/// The result of what reads values.
pub(crate) fn of_value<T>(result: axis::Result<T>) -> Result<T> {
    of(ErrorKind::Value, result)
}
