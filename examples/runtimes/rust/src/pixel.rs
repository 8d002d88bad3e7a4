//! Equations (1) to (44) for one pixel.

use crate::axis;
use crate::database::Database;
use crate::error::{of_value, Result};
use crate::light::{ambient_weights, bases, has_fourth_degree, normal, summed, Place};
use crate::shade::{absorbed_change, temperature_under, Surroundings};
use crate::tables::{Face, Line, Tables};

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

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(vector: &[f64; 3]) -> axis::Result<[f64; 3]> {
    let length = dot(vector, vector).sqrt();
    if !length.is_finite() || length == 0.0 {
        return Err("a direction must be three finite numbers that are not all 0".into());
    }
    Ok(vector.map(|part| part / length))
}

/// Equations (37) and (38): chi of the half vector to the power of the shininess.
fn lobe(normal: &[f64; 3], to_source: &[f64; 3], to_observer: &[f64; 3], shininess: f64) -> f64 {
    let between = [0, 1, 2].map(|k| to_source[k] + to_observer[k]);
    let length = dot(&between, &between).sqrt();
    let chi = if length > 0.0 { dot(&between, normal) / length } else { 0.0 };
    chi.clamp(0.0, 1.0).powf(shininess)
}

/// Pixel value of a radiance, (44), rounded to the nearest integer: of `bits` bits, a gain [W m^-2 sr^-1], buffer gain and
/// offset.
pub fn pixel_value(radiance: f64, bits: i32, gain: f64, buffer_gain: f64, offset: f64) -> i64 {
    let (size, share) = (2f64.powi(bits), (radiance / gain).clamp(0.0, 1.0));
    // The nearest integer to x - 1/2, halves upwards, is the floor of x.
    (size * buffer_gain * (share - offset)).floor().clamp(0.0, size - 1.0) as i64
}

/// Reflectance of a material at each wavelength or in the whole band.
fn reflectance(band: &Database, parted: bool, code: f64) -> axis::Result<Vec<f64>> {
    if parted {
        return band.spectrum("reflectance_spectrum", ("material", code));
    }
    Ok(vec![band.value("reflectance", &[("material", code)])?])
}

/// Share of each wavelength in what a black body emits, or of the whole band.
fn emission(band: &Database, parted: bool, temperature: f64) -> axis::Result<Vec<f64>> {
    if parted {
        return band.spectrum("emission_share", ("planck_temperature", temperature));
    }
    Ok(vec![1.0])
}

/// L_ambient of a pixel's face at each wavelength; of a level one where the file or the pixel says no more.
fn ambient(tables: &Tables, pixel: &Pixel, centre: &Place) -> axis::Result<Vec<f64>> {
    let ground = tables.ground(pixel.ground_material, pixel.surface_altitude, pixel.time)?;
    let (Some(ground), Some(heading)) = (ground, pixel.source_heading) else {
        return tables.air.light("ambient_radiance", centre);
    };
    let weights = ambient_weights(&tables.air, centre, Some(ground), true)?;
    let normal = normal(pixel.surface_slope, pixel.surface_azimuth - heading);
    Ok(summed(&weights, &bases(has_fourth_degree(&tables.air), normal)))
}

/// Share of a pixel in the shade, and the open share of the sky there and above the rest.
fn open_sky(pixel: &Pixel) -> axis::Result<(f64, f64, f64)> {
    let (share, sky) = pixel.shade.as_ref().map_or((0.0, 1.0), |shade| (shade.share, shade.sky));
    for (name, value) in [("shade", share), ("shaded_sky", sky), ("hidden_sky", pixel.hidden_sky)] {
        if !(0.0..=1.0).contains(&value) {
            return Err(format!("{name}: found {value}; allowed: 0 to 1").into());
        }
    }
    let open = 1.0 - pixel.hidden_sky;
    Ok((share, open.min(sky), open))
}

impl Tables {
    /// The terms of a pixel, (1).
    ///
    /// # Errors
    /// A value outside the tables, a pixel without material, or a direction without length.
    pub fn pixel_radiance(&self, pixel: &Pixel) -> Result<Terms> {
        of_value(self.terms(pixel))
    }

    /// Temperature of a face in the shade all day under a share of the sky.
    fn temperature_in_shade(&self, face: &Face, sky_view: f64) -> axis::Result<f64> {
        let around = Surroundings { shade: vec![[0.0, 24.0]], sky_view, ..Surroundings::default() };
        let heat = absorbed_change(&self.surface, &face.place(), &around)?;
        temperature_under(&self.surface, &face.place(), &heat)
    }

    fn terms(&self, pixel: &Pixel) -> axis::Result<Terms> {
        let line = Line {
            range: pixel.centre_range,
            altitude: pixel.altitude,
            elevation: pixel.centre_elevation,
            source_elevation: pixel.source_elevation,
            source_azimuth: pixel.source_azimuth,
        };
        let (centre, air, band) = (line.place(), &self.air, &self.band);
        if pixel.materials.is_empty() || !(pixel.temperatures.is_empty() || pixel.temperatures.len() == pixel.materials.len()) {
            return Err("a pixel has a material, and temperatures of all of its materials or of none".into());
        }
        let (shade, under, open) = open_sky(pixel)?;
        let given: &[f64] = pixel.shade.as_ref().map_or(&[], |shade| &shade.temperatures);
        if !(given.is_empty() || given.len() == pixel.materials.len()) {
            return Err("a pixel has temperatures in the shade of all of its materials or of none".into());
        }
        let beta_star = air.value("beta_star", &centre)?;
        let depth = 5.5 * pixel.range / beta_star;
        let mut sums = Terms { beta_star, transmittance: (-depth).exp(), ..Terms::default() }; // (9)
        let (normal, to_source, to_observer) = (unit(&pixel.normal)?, unit(&pixel.to_source)?, unit(&pixel.to_observer)?);
        let incidence = dot(&normal, &to_source).max(0.0);
        let mut sky = ambient(self, pixel, &centre)?;
        let seen = open - shade * (open - under);
        if seen < 1.0 {
            self.hide_sky(pixel, &centre, 1.0 - seen, &mut sky)?;
        }
        let beam = if incidence > 0.0 { air.light("direct_radiance", &centre)? } else { vec![0.0; sky.len()] };
        let through: Vec<f64> = air.extinction(&centre)?.iter().map(|extinction| (-extinction * pixel.range).exp()).collect();
        for (k, (material, share)) in pixel.materials.iter().enumerate() {
            let code = f64::from(*material);
            let (altitude, azimuth, slope) = (pixel.surface_altitude, pixel.surface_azimuth, pixel.surface_slope);
            let face = Face { material: *material, altitude, azimuth, slope, time: pixel.time };
            let from_tables = || self.surface.value("temperature", &face.place());
            let mut parts = vec![(share * (1.0 - shade), pixel.temperatures.get(k).map_or_else(from_tables, |kelvin| Ok(*kelvin))?)];
            if shade > 0.0 {
                let in_shade = || self.temperature_in_shade(&face, under);
                parts.push((share * shade, given.get(k).map_or_else(in_shade, |kelvin| Ok(*kelvin))?));
            }
            let property = |name: &str| band.value(name, &[("material", code)]);
            let fraction = property("specular_fraction")?;
            let rho = reflectance(band, air.parted, code)?;
            for (part, temperature) in parts {
                let blackbody = band.value("blackbody_radiance", &[("temperature", temperature)])?; // (7)
                let emission = emission(band, air.parted, temperature)?;
                let emitted: f64 = rho.iter().zip(&emission).zip(&through).map(|((rho, share), through)| (1.0 - rho) * share * through).sum();
                sums.temperature += part * temperature;
                sums.blackbody_radiance += part * blackbody;
                sums.thermal += part * blackbody * emitted; // (5), or (6)
            }
            let reflected = |light: &[f64]| rho.iter().zip(light).map(|(rho, light)| rho * light).sum::<f64>().max(0.0);
            let direct = reflected(&beam) * sums.transmittance * (1.0 - shade);
            sums.skyshine += share * reflected(&sky) * sums.transmittance; // (18), or (19)
            sums.diffuse += share * direct * incidence * (1.0 - fraction); // (34)
            let shape = lobe(&normal, &to_source, &to_observer, property("shininess")?);
            sums.specular += share * direct * shape * fraction * property("normalisation")?; // (35)
        }
        sums.path = self.path_ratio(&centre)? * -(-depth).exp_m1(); // (11)
        sums.radiance = sums.diffuse + sums.specular + sums.skyshine + sums.thermal + sums.path; // (1)
        Ok(sums)
    }
}
