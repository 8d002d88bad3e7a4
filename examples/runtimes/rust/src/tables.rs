//! The tables of a state, a band and a source: opened, and read at one place.

use crate::axis;
use crate::database::Database;
use crate::error::{of_file, of_value, Result};
use crate::light::{ambient_weights, bases, has_fourth_degree, normal, summed, Place, BASES};
use crate::shade::{absorbed_change, temperature_under, Surroundings};
use std::path::Path;

/// Sun or Moon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// The tables of the files `.atmq`.
    Sun,
    /// The tables of the files `.lunar_atmq`.
    Moon,
}

/// A face of a material.
#[derive(Clone, Copy, Debug)]
pub struct Face {
    /// Code of the material.
    pub material: i32,
    /// km.
    pub altitude: f64,
    /// Degree from north eastward.
    pub azimuth: f64,
    /// Degree from level.
    pub slope: f64,
    /// Hours of the local clock.
    pub time: f64,
}

/// A line of sight, and the source.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// km.
    pub range: f64,
    /// Of the observer, km.
    pub altitude: f64,
    /// Apparent, degree.
    pub elevation: f64,
    /// Geometric, degree.
    pub source_elevation: f64,
    /// From the azimuth of the line, degree.
    pub source_azimuth: f64,
}

/// The tables of a state, a band and a source. Reading them needs no exclusive access: they serve any number of threads.
pub struct Tables {
    pub(crate) surface: Database,
    pub(crate) band: Database,
    pub(crate) air: Database,
    materials: Vec<(i32, String)>,
}

impl Face {
    pub(crate) fn place(&self) -> [(&'static str, f64); 5] {
        [
            ("material", f64::from(self.material)),
            ("altitude", self.altitude),
            ("azimuth", self.azimuth),
            ("slope", self.slope),
            ("time", self.time),
        ]
    }
}

/// Angle between line of sight and source, all in degree.
fn scattering_angle(elevation: f64, source_elevation: f64, azimuth: f64) -> f64 {
    let (line, source) = (elevation.to_radians(), source_elevation.to_radians());
    let turn = (azimuth.to_radians() / 2.0).sin().powi(2);
    let half = ((line - source) / 2.0).sin().powi(2) + line.cos() * source.cos() * turn;
    2.0 * half.clamp(0.0, 1.0).sqrt().asin().to_degrees()
}

impl Line {
    pub(crate) fn place(&self) -> [(&'static str, f64); 6] {
        [
            ("range", self.range),
            ("altitude", self.altitude),
            ("elevation", self.elevation),
            ("source_elevation", self.source_elevation),
            ("source_azimuth", self.source_azimuth),
            ("scattering_angle", scattering_angle(self.elevation, self.source_elevation, self.source_azimuth)),
        ]
    }
}

/// Name of the file of a type that a catalogue lists for a state and a band, where it needs them.
fn listed(catalog: &serde_json::Value, filetype: &str, state: Option<u32>, band: Option<u32>) -> axis::Result<String> {
    let is_of = |entry: &serde_json::Value, key: &str, wanted: Option<u32>| wanted.is_none_or(|number| entry[key] == number);
    let files = catalog["files"].as_array().ok_or("is not a catalogue of databases")?;
    let entry = files.iter().find(|entry| entry["filetype"] == filetype && is_of(entry, "state", state) && is_of(entry, "band", band));
    let name = entry.and_then(|entry| entry["file"].as_str()).ok_or_else(|| format!("lists no '{filetype}' of that state and band"))?;
    if name.contains(['/', '\\']) {
        return Err("names a file elsewhere".into());
    }
    Ok(name.to_owned())
}

fn files_of(folder: &Path, state: u32, band: u32, source: Source) -> axis::Result<[String; 3]> {
    let path = folder.join("catalog.json");
    let text = std::fs::read_to_string(&path).map_err(|_| format!("{}: cannot be read", path.display()))?;
    let catalog = serde_json::from_str(&text).unwrap_or_default();
    let air = if source == Source::Moon { "lunar_atmq" } else { "atmq" };
    let found = || Ok([
        listed(&catalog, "htt", Some(state), None)?,
        listed(&catalog, "band", None, Some(band))?,
        listed(&catalog, air, Some(state), Some(band))?,
    ]);
    found().map_err(|error: Box<dyn std::error::Error>| format!("{}: {error}", path.display()).into())
}

impl Tables {
    /// Open a state, a band (numbers from 1, as in the names of the files) and a source in the folder of a build, by its
    /// `catalog.json`. Values outside the axes named in `clamp` are read at the nearest node.
    ///
    /// # Errors
    /// A file is missing, damaged, of another format, or does not fit the others.
    pub fn open(folder: impl AsRef<Path>, state: u32, band: u32, source: Source, clamp: &[&str]) -> Result<Self> {
        let folder = folder.as_ref();
        let [surface, spectral, air] = of_file(files_of(folder, state, band, source))?;
        Self::open_files(folder.join(surface), folder.join(spectral), folder.join(air), clamp)
    }

    /// [`Tables::open`] of named files: an .htt, a .band and an .atmq or .lunar_atmq file.
    ///
    /// # Errors
    /// As [`Tables::open`].
    pub fn open_files(surface: impl AsRef<Path>, band: impl AsRef<Path>, atmosphere: impl AsRef<Path>, clamp: &[&str]) -> Result<Self> {
        let clamped: Vec<String> = clamp.iter().map(|name| (*name).to_owned()).collect();
        let open = |path: &Path, filetypes: &[&str]| of_file(Database::open(path, filetypes, &clamped));
        let (surface, spectral) = (open(surface.as_ref(), &["htt"])?, open(band.as_ref(), &["band"])?);
        let mut air = open(atmosphere.as_ref(), &["atmq", "lunar_atmq"])?;
        of_file(air.part_light(&spectral, band.as_ref()))?;
        let materials = spectral.materials();
        Ok(Tables { surface, band: spectral, air, materials })
    }

    /// Codes and names of the materials of the band, by ascending code.
    pub fn materials(&self) -> &[(i32, String)] {
        &self.materials
    }

    /// Temperature [K] of a face in full sun under the whole sky.
    ///
    /// # Errors
    /// A value outside the tables.
    pub fn temperature(&self, face: &Face) -> Result<f64> {
        of_value(self.surface.value("temperature", &face.place()))
    }

    /// Temperature [K] of a face with surroundings.
    ///
    /// # Errors
    /// A value outside the tables, or a surface file without the response to shade.
    pub fn shaded_temperature(&self, face: &Face, surroundings: &Surroundings) -> Result<f64> {
        let place = face.place();
        of_value(absorbed_change(&self.surface, &place, surroundings).and_then(|heat| temperature_under(&self.surface, &place, &heat)))
    }

    /// Temperature [K] of a face that absorbs other heat than that of the tables: means over equal steps of the day, each
    /// centred on its time, the first on midnight, in W m^-2.
    ///
    /// # Errors
    /// As [`Tables::shaded_temperature`].
    pub fn heated_temperature(&self, face: &Face, absorbed: &[f64]) -> Result<f64> {
        of_value(temperature_under(&self.surface, &face.place(), absorbed))
    }

    /// Transmittance of the band along a line, (9). Its source is not read.
    ///
    /// # Errors
    /// A value outside the tables.
    pub fn transmittance(&self, line: &Line) -> Result<f64> {
        Ok((-5.5 * line.range / of_value(self.air.value("beta_star", &line.place()))?).exp())
    }

    /// What the air along a line emits and scatters to its beginning, (11) [W m^-2 sr^-1].
    ///
    /// # Errors
    /// A value outside the tables.
    pub fn path_radiance(&self, line: &Line) -> Result<f64> {
        let depth = 5.5 * line.range / of_value(self.air.value("beta_star", &line.place()))?;
        Ok(of_value(self.air.value("path_radiance_ratio", &line.place()))? * -(-depth).exp_m1())
    }

    /// Light of the sky on a face at the end of a line, over pi [W m^-2 sr^-1]. `azimuth` of the face is relative to that
    /// of the source. A tilted face needs a file with harmonics; its ground is that which the file states.
    ///
    /// # Errors
    /// A value outside the tables.
    pub fn ambient_radiance(&self, line: &Line, slope: f64, azimuth: f64) -> Result<f64> {
        let stated = self.air.ground.map(|[_, temperature, emitted]| [temperature, emitted]);
        if !slope.is_finite() || !azimuth.is_finite() || (stated.is_none() && slope != 0.0) {
            let allowed = if stated.is_none() { "0, as the file holds no harmonics" } else { "finite numbers" };
            return of_value(Err(format!("slope: found {slope}; allowed: {allowed}").into()));
        }
        let weights = of_value(ambient_weights(&self.air, &line.place(), stated, false))?;
        let mut at = [1.0; BASES];
        if stated.is_some() {
            at = bases(has_fourth_degree(&self.air), normal(slope, azimuth));
        }
        Ok(summed(&weights, &at)[0])
    }

    /// Light of the source on a surface normal to it at the end of a line, over pi [W m^-2 sr^-1].
    ///
    /// # Errors
    /// A value outside the tables.
    pub fn direct_radiance(&self, line: &Line) -> Result<f64> {
        of_value(self.air.value("direct_radiance", &line.place()))
    }

    /// Temperature [K] of the black body that has a radiance [W m^-2 sr^-1] in the band.
    ///
    /// # Errors
    /// A radiance beyond those of the band's temperatures.
    pub fn apparent_temperature(&self, radiance: f64) -> Result<f64> {
        let (values, nodes) = (&self.band.array("blackbody_radiance").values, self.band.nodes("blackbody_radiance", 0));
        let (first, last) = (f64::from(values[0]), f64::from(values[values.len() - 1]));
        if !(first..=last).contains(&radiance) {
            return of_value(Err(format!("radiance: found {radiance}; allowed: {first} to {last}").into()));
        }
        let lower = values.partition_point(|value| f64::from(*value) <= radiance) - 1;
        if lower + 1 == values.len() {
            return Ok(nodes[lower]);
        }
        let (from, to) = (f64::from(values[lower]), f64::from(values[lower + 1]));
        Ok(nodes[lower] + (radiance - from) / (to - from) * (nodes[lower + 1] - nodes[lower]))
    }

    /// Elevation and heading [degree] of the tables' source at a time, 0 to 36 h, from the tracks of the surface file.
    ///
    /// # Errors
    /// A file without tracks, or a time outside them.
    pub fn source_position(&self, time: f64) -> Result<(f64, f64)> {
        if !self.surface.holds("sun_elevation") {
            return of_value(Err("the surface file holds no tracks of Sun and Moon".into()));
        }
        let names = if self.air.lunar { ["moon_elevation", "moon_azimuth"] } else { ["sun_elevation", "sun_azimuth"] };
        let read = |name: &str| of_value(self.surface.value(name, &[("track_time", time)]));
        Ok((read(names[0])?, read(names[1])?))
    }

    /// Temperature of the ground around a face, and what it emits: of a material, or as the file states it; none where the
    /// file has no harmonics.
    pub(crate) fn ground(&self, material: Option<i32>, altitude: f64, time: f64) -> axis::Result<Option<[f64; 2]>> {
        let Some([emissivity, temperature, emitted]) = self.air.ground else { return Ok(None) };
        let Some(material) = material else { return Ok(Some([temperature, emitted])) };
        let kelvin = self.surface.value("temperature", &Face { material, altitude, azimuth: 0.0, slope: 0.0, time }.place())?;
        Ok(Some([kelvin, emissivity * self.band.value("blackbody_radiance", &[("temperature", kelvin)])?]))
    }

    /// (10) at a place.
    pub(crate) fn path_ratio(&self, place: &Place) -> axis::Result<f64> {
        self.air.value("path_radiance_ratio", place)
    }
}
