#![cfg_attr(not(doctest), doc = include_str!("../README.md"))] // its example wants the files of a build
#![warn(missing_docs)]

mod database;
mod error;
mod kernel;
mod pixel;
mod source;
mod tables;
mod texture;

pub use error::{Error, ErrorKind, Result};
pub use pixel::{pixel_value, Pixel, Pixels, Shade, Terms, View, SHADED_SKY};
pub use tables::{Face, Line, Source, Surroundings, Tables};
pub use texture::Texture;

/// The newest formats that this version knows; it reads all minor versions of their major ones, of .band from 1.5 on.
pub const FORMATS: &[(&str, &str)] = &[("htt", "1.9"), ("band", "1.6"), ("atmq", "4.0"), ("tmm", "1.6")];
