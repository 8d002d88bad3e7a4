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

/// Version of the formats that this version knows; it reads all minor versions of its major one.
pub const FORMAT: &str = "1.0";
