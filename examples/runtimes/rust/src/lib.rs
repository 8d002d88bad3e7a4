#![doc = include_str!("../README.md")]
#![warn(missing_docs)]

mod axis;
mod channels;
mod database;
mod error;
mod film;
mod frame;
mod layouts;
mod light;
mod pixel;
mod shade;
mod source;
mod tables;
mod texture;
mod walls;

pub use error::{Error, ErrorKind, Result};
pub use frame::{Frame, Pixels, View};
pub use pixel::{pixel_value, Pixel, Shade, Terms, SHADED_SKY};
pub use shade::Surroundings;
pub use tables::{Face, Line, Source, Tables};
pub use texture::Texture;

/// The newest formats that this version knows; it reads all minor versions of their major ones.
pub const FORMATS: &[(&str, &str)] = &[("htt", "1.8"), ("band", "1.5"), ("atmq", "2.4"), ("atmq", "3.4"), ("tmm", "1.5")];
