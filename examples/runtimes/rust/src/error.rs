//! The error of the public calls.

use crate::kernel::Failure;
use std::ffi::CStr;
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

    pub(crate) fn file(message: impl fmt::Display) -> Self {
        Error::of(ErrorKind::File, message)
    }

    pub(crate) fn value(message: impl fmt::Display) -> Self {
        Error::of(ErrorKind::Value, message)
    }

    fn of(kind: ErrorKind, message: impl fmt::Display) -> Self {
        let line: String = message.to_string().chars().map(|each| if each.is_control() { '?' } else { each }).collect();
        Error { kind, message: line.chars().take(600).collect() }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str(&self.message)
    }
}

impl std::error::Error for Error {}

impl From<hdf5::Error> for Error {
    fn from(_: hdf5::Error) -> Self {
        Error::file("is damaged: the HDF5 library cannot read it")
    }
}

/// What the library says of a failure, as one line.
pub(crate) fn text(failure: &Failure) -> String {
    let name = if failure.name.is_null() { "" } else { unsafe { CStr::from_ptr(failure.name) }.to_str().unwrap_or("") };
    let (found, least, most) = (failure.found, failure.least, failure.most);
    match failure.status {
        1 if found.is_nan() => format!("{name}: found a value that is not finite; allowed: finite numbers"),
        1 => format!("{name}: found {found}; allowed: {least} to {most}"),
        _ => format!("{name}: found {found}; status {}", failure.status),
    }
}

/// Nothing, or the error of a status that a call of the library gave.
pub(crate) fn check(status: i32, failure: &Failure, kind: ErrorKind) -> Result<()> {
    if status == 0 { Ok(()) } else { Err(Error::of(kind, text(failure))) }
}
