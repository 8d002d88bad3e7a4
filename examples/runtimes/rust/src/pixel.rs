//! A pixel and the pixels of a frame: what they are, and their radiance by the C library.

use crate::error::{Error, Result};
use crate::kernel;
use crate::tables::Tables;
use std::ptr::{null, null_mut};

/// Open share of the sky above what a texture shows in the shade, where a scene says nothing else.
pub const SHADED_SKY: f64 = 0.5;

/// What of a pixel lies in the shade all day: no direct light falls there.
#[derive(Clone, Debug)]
pub struct Shade {
    /// Of the pixel, as `Texture::shade` gives it.
    pub share: f64,
    /// Open share of the sky there, which is never more than that above the pixel.
    pub sky: f64,
    /// Temperatures of the materials there [K]; empty: by the response of the surface file.
    pub temperatures: Vec<f64>,
}

/// A pixel; the atmosphere is read at the range and elevation of the centre.
#[derive(Clone, Debug)]
pub struct Pixel {
    /// Codes and shares of its materials.
    pub materials: Vec<(i32, f64)>,
    /// Temperatures of the materials [K]; empty: those of the tables.
    pub temperatures: Vec<f64>,
    /// km.
    pub surface_altitude: f64,
    /// Degree from north eastward.
    pub surface_azimuth: f64,
    /// Degree from level.
    pub surface_slope: f64,
    /// Hours of the local clock.
    pub time: f64,
    /// From the observer to the pixel's point, km.
    pub range: f64,
    /// At which the atmosphere is read, km.
    pub centre_range: f64,
    /// At which the atmosphere is read, degree.
    pub centre_elevation: f64,
    /// Of the observer, km.
    pub altitude: f64,
    /// Geometric, degree.
    pub source_elevation: f64,
    /// From the azimuth of the line of sight, degree.
    pub source_azimuth: f64,
    /// From north eastward, degree; none: the sky of a level face.
    pub source_heading: Option<f64>,
    /// Code of the ground's material; none: the ground that the atmosphere file states.
    pub ground_material: Option<i32>,
    /// Of the face, of any length.
    pub normal: [f64; 3],
    /// From the point, of any length.
    pub to_source: [f64; 3],
    /// From the point, of any length.
    pub to_observer: [f64; 3],
    /// Share of the sky above it that something as warm as the air hides.
    pub hidden_sky: f64,
    /// What of it lies in the shade all day.
    pub shade: Option<Shade>,
}

/// The terms of a pixel, radiances in W m^-2 sr^-1.
#[derive(Clone, Copy, Debug, Default)]
pub struct Terms {
    /// Mean over the materials [K].
    pub temperature: f64,
    /// (7).
    pub blackbody_radiance: f64,
    /// km.
    pub beta_star: f64,
    /// (9).
    pub transmittance: f64,
    /// (6).
    pub thermal: f64,
    /// (11).
    pub path: f64,
    /// (19).
    pub skyshine: f64,
    /// (34).
    pub diffuse: f64,
    /// (35), with the lobe of (37) and (38).
    pub specular: f64,
    /// (1).
    pub radiance: f64,
}

/// What all pixels of a frame share.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// Of the observer, km.
    pub altitude: f64,
    /// Range of the line of sight at which the atmosphere is read, km.
    pub centre_range: f64,
    /// Its elevation, degree.
    pub centre_elevation: f64,
    /// Its azimuth from north eastward, degree.
    pub centre_heading: f64,
    /// Geometric, degree.
    pub source_elevation: f64,
    /// Azimuth of the source from north eastward, degree.
    pub source_heading: f64,
    /// Hours of the local clock.
    pub time: f64,
    /// Code of the ground's material and its altitude [km]; none: the ground that the atmosphere file states.
    pub ground: Option<(i32, f64)>,
}

/// Pixels of a frame: lists with one value for each.
#[derive(Clone, Copy, Debug)]
pub struct Pixels<'a> {
    /// Codes.
    pub material: &'a [i32],
    /// km.
    pub range: &'a [f64],
    /// Elevations and headings of the lines of sight [degree], for the lobe; none: those of the centre.
    pub lines: Option<(&'a [f64], &'a [f64])>,
    /// km.
    pub surface_altitude: &'a [f64],
    /// Degree from north eastward.
    pub surface_azimuth: &'a [f64],
    /// Degree from level.
    pub surface_slope: &'a [f64],
    /// K; none: those of the tables.
    pub temperature: Option<&'a [f64]>,
}

impl Pixels<'_> {
    fn check(&self) -> Result<usize> {
        let (elevation, heading) = self.lines.unwrap_or((self.range, self.range));
        let lists = [self.range, elevation, heading, self.surface_altitude, self.surface_azimuth, self.surface_slope];
        let count = self.material.len();
        if lists.into_iter().chain(self.temperature).any(|list| list.len() != count) {
            return Err(Error::value(format!("the lists of a frame differ in length; allowed: {count} values each")));
        }
        Ok(count)
    }
}

/// Pixel value of a radiance, (44), rounded to the nearest integer: of `bits` bits, a gain [W m^-2 sr^-1], buffer gain and
/// offset.
pub fn pixel_value(radiance: f64, bits: i32, gain: f64, buffer_gain: f64, offset: f64) -> i64 {
    unsafe { kernel::skyshine_value_of_pixel(radiance, bits, gain, buffer_gain, offset) }
}

/// Pixels of which nothing is said.
fn unsaid() -> kernel::Pixels {
    kernel::Pixels {
        material: null(),
        share: null(),
        temperature: null(),
        surface_altitude: null(),
        surface_azimuth: null(),
        surface_slope: null(),
        time: null(),
        range: null(),
        line_range: null(),
        altitude: null(),
        elevation: null(),
        source_elevation: null(),
        source_azimuth: null(),
        source_heading: null(),
        normal: null(),
        to_source: null(),
        to_observer: null(),
        sight_elevation: null(),
        sight_heading: null(),
        lit: null(),
        sky_view: null(),
        wall_temperature: null(),
        shade: null(),
        shaded_sky: null(),
        shaded_temperature: null(),
        ground_material: null(),
        ground_temperature: null(),
    }
}

fn of_all(values: &[f64], count: usize, what: &str) -> Result<*const f64> {
    match values.len() {
        0 => Ok(null()),
        same if same == count => Ok(values.as_ptr()),
        other => Err(Error::value(format!("a pixel of {count} materials has {other} temperatures{what}; allowed: {count} or none"))),
    }
}

impl Tables {
    /// The terms of a pixel, (1).
    ///
    /// # Errors
    /// A value outside the tables, a pixel without material, or a direction without length.
    pub fn pixel_radiance(&self, pixel: &Pixel) -> Result<Terms> {
        let (codes, shares): (Vec<i32>, Vec<f64>) = pixel.materials.iter().copied().unzip();
        let sky_view = 1.0 - pixel.hidden_sky;
        let given = kernel::Pixels {
            material: codes.as_ptr(),
            share: shares.as_ptr(),
            temperature: of_all(&pixel.temperatures, codes.len(), "")?,
            surface_altitude: &pixel.surface_altitude,
            surface_azimuth: &pixel.surface_azimuth,
            surface_slope: &pixel.surface_slope,
            time: &pixel.time,
            range: &pixel.range,
            line_range: &pixel.centre_range,
            altitude: &pixel.altitude,
            elevation: &pixel.centre_elevation,
            source_elevation: &pixel.source_elevation,
            source_azimuth: &pixel.source_azimuth,
            source_heading: pixel.source_heading.as_ref().map_or(null(), |heading| heading),
            normal: pixel.normal.as_ptr(),
            to_source: pixel.to_source.as_ptr(),
            to_observer: pixel.to_observer.as_ptr(),
            sky_view: &sky_view,
            shade: pixel.shade.as_ref().map_or(null(), |shade| &shade.share),
            shaded_sky: pixel.shade.as_ref().map_or(null(), |shade| &shade.sky),
            shaded_temperature: pixel.shade.as_ref().map_or(Ok(null()), |shade| of_all(&shade.temperatures, codes.len(), " in the shade"))?,
            ground_material: pixel.ground_material.as_ref().map_or(null(), |code| code),
            ..unsaid()
        };
        let mut to = Terms::default();
        let terms = kernel::Terms {
            temperature: &mut to.temperature,
            blackbody_radiance: &mut to.blackbody_radiance,
            beta_star: &mut to.beta_star,
            transmittance: &mut to.transmittance,
            thermal: &mut to.thermal,
            path: &mut to.path,
            skyshine: &mut to.skyshine,
            diffuse: &mut to.diffuse,
            specular: &mut to.specular,
            radiance: &mut to.radiance,
        };
        if codes.is_empty() {
            return Err(Error::value("found a pixel without material; allowed: codes of the tables"));
        }
        self.call(|tables, scratch, failure| unsafe { kernel::skyshine_pixel_terms(tables, 1, codes.len(), 1, &given, &terms, scratch, failure) })?;
        Ok(to)
    }

    /// Radiances [W m^-2 sr^-1] of the pixels of one observer, one source and one time, in one thread. The atmosphere is
    /// read once, at the centre.
    ///
    /// # Errors
    /// Lists of unlike lengths, or a value outside the tables, with the number of its pixel.
    pub fn frame_radiance(&self, view: &View, pixels: &Pixels, radiance: &mut [f64]) -> Result<()> {
        let count = pixels.check()?;
        if radiance.len() != count {
            return Err(Error::value(format!("found room for {} radiances; allowed: {count}", radiance.len())));
        }
        let turn = view.source_heading - view.centre_heading;
        let time = vec![view.time; count];
        let ground = match view.ground {
            Some((material, altitude)) => vec![self.ground_temperature(material, altitude, view.time)?; count],
            None => Vec::new(),
        };
        let centre = (vec![view.centre_elevation; count], vec![view.centre_heading; count]);
        let (elevation, heading) = pixels.lines.unwrap_or((&centre.0, &centre.1));
        let given = kernel::Pixels {
            material: pixels.material.as_ptr(),
            temperature: pixels.temperature.map_or(null(), <[f64]>::as_ptr),
            surface_altitude: pixels.surface_altitude.as_ptr(),
            surface_azimuth: pixels.surface_azimuth.as_ptr(),
            surface_slope: pixels.surface_slope.as_ptr(),
            time: time.as_ptr(),
            range: pixels.range.as_ptr(),
            line_range: &view.centre_range,
            altitude: &view.altitude,
            elevation: &view.centre_elevation,
            source_elevation: &view.source_elevation,
            source_azimuth: &turn,
            source_heading: &view.source_heading,
            sight_elevation: elevation.as_ptr(),
            sight_heading: heading.as_ptr(),
            ground_temperature: if ground.is_empty() { null() } else { ground.as_ptr() },
            ..unsaid()
        };
        let terms = kernel::Terms {
            temperature: null_mut(),
            blackbody_radiance: null_mut(),
            beta_star: null_mut(),
            transmittance: null_mut(),
            thermal: null_mut(),
            path: null_mut(),
            skyshine: null_mut(),
            diffuse: null_mut(),
            specular: null_mut(),
            radiance: radiance.as_mut_ptr(),
        };
        self.call_many(true, |tables, scratch, failure| unsafe { kernel::skyshine_pixel_terms(tables, count, 1, 1, &given, &terms, scratch, failure) })
    }
}
