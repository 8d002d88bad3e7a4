//! The error of the public calls.

use crate::kernel::{Failure, NO_GROUND};
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

/// A number as messages have it, not longer than it needs to be.
fn shown(value: f64) -> String {
    let plain = value == 0.0 || (1e-5..1e15).contains(&value.abs());
    if plain || !value.is_finite() { value.to_string() } else { format!("{value:e}") }
}

/// What the library says of a failure, as one line; of a call for many places, with the number of the place.
fn text(failure: &Failure, many: bool) -> String {
    let name = if failure.name.is_null() { "" } else { unsafe { CStr::from_ptr(failure.name) }.to_str().unwrap_or("") };
    let [found, least, most] = [failure.found, failure.least, failure.most].map(shown);
    let line = match failure.status {
        1 => format!("{name}: found {found}; allowed: {least} to {most}"),
        2 => format!("{name}: found {found}; allowed: a code of the file"),
        3 => format!("{name}: found {found}; allowed: {least} and above, or {most} and below"),
        4 => format!("{name}: found a direction without length; allowed: three finite numbers that are not all 0"),
        5 => format!("{name}: found {found}; allowed: 0 to 1"),
        6 => format!("{name}: found {found}; allowed: finite numbers from 0"),
        7 => "found a pixel without material; allowed: codes of the tables".to_owned(),
        8 => "the surface file has no response to shade".to_owned(),
        NO_GROUND => "the atmosphere states no ground; allowed: one that the surface file has".to_owned(),
        10 => format!("{name}: found what is not a finite number; allowed: finite numbers"),
        11 => format!("lacks '{name}'"),
        12 => format!("the axis '{name}' has nodes, a rule or a period that are not those of the format"),
        13 => format!("'{name}' has {found}; allowed: {least} to {most}"),
        14 => format!("a row of '{name}' sums to {found}; allowed: 1"),
        15 => format!("does not state '{name}', in {least} to {most}"),
        _ => format!("has {found} wavelengths from {least} to {most} um; allowed: those of the air"),
    };
    if many && failure.status <= 10 { format!("pixel {}: {line}", failure.row) } else { line }
}

/// Nothing, or the error of a status that a call of the library gave.
pub(crate) fn check(status: i32, failure: &Failure, kind: ErrorKind, many: bool) -> Result<()> {
    if status == 0 { Ok(()) } else { Err(Error::of(kind, text(failure, many))) }
}
