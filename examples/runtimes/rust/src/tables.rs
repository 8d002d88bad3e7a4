//! The tables of a state, a band and a source: opened, and read at one place.

use crate::database::{array_number, Database, Memory};
use crate::error::{check, Error, ErrorKind, Result};
use crate::kernel::*;
use std::ffi::c_void;
use std::path::Path;
use std::ptr::null;
use std::sync::Mutex;

const DAY_H: f64 = 24.0;

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

/// What keeps sunlight and sky from a face.
#[derive(Clone, Debug)]
pub struct Surroundings {
    /// Hours from first to last, over midnight where the first is later; they do not overlap.
    pub shade: Vec<[f64; 2]>,
    /// Open share of the sky.
    pub sky_view: f64,
    /// Temperature of the wall that hides the rest [K]; none: that of the air.
    pub facing: Option<f64>,
    /// Of that wall; none: 0.95.
    pub facing_emissivity: Option<f64>,
}

impl Default for Surroundings {
    fn default() -> Self {
        Surroundings { shade: Vec::new(), sky_view: 1.0, facing: None, facing_emissivity: None }
    }
}

/// The tables of a state, a band and a source. Reading them needs no exclusive access: they serve any number of threads.
pub struct Tables {
    surface: Database,
    band: Database,
    air: Database,
    memory: Memory,
    /// Memory of calls that are over.
    scratch: Mutex<Vec<Memory>>,
}

/// Name of the file of a type that a catalogue lists for a state and a band, where it needs them.
fn listed(catalog: &serde_json::Value, filetype: &str, state: Option<u32>, band: Option<u32>) -> Result<String> {
    let is_of = |entry: &serde_json::Value, key: &str, wanted: Option<u32>| wanted.is_none_or(|number| entry[key] == number);
    let files = catalog["files"].as_array().ok_or_else(|| Error::file("is not a catalogue of databases"))?;
    let entry = files.iter().find(|entry| entry["filetype"] == filetype && is_of(entry, "state", state) && is_of(entry, "band", band));
    let name = entry.and_then(|entry| entry["file"].as_str());
    let name = name.ok_or_else(|| Error::file(format!("lists no '{filetype}' of that state and band")))?;
    if name.contains(['/', '\\']) {
        return Err(Error::file("names a file elsewhere"));
    }
    Ok(name.to_owned())
}

fn files_of(folder: &Path, state: u32, band: u32, source: Source) -> Result<[String; 3]> {
    let path = folder.join("catalog.json");
    let placed = |error: Error| Error::file(format!("{}: {error}", path.display()));
    let text = std::fs::read_to_string(&path).map_err(|_| placed(Error::file("cannot be read")))?;
    let catalog = serde_json::from_str(&text).unwrap_or_default();
    let air = if source == Source::Moon { "lunar_atmq" } else { "atmq" };
    let names = || {
        let (surface, spectral) = (listed(&catalog, "htt", Some(state), None)?, listed(&catalog, "band", None, Some(band))?);
        Ok([surface, spectral, listed(&catalog, air, Some(state), Some(band))?])
    };
    names().map_err(placed)
}

/// Share in the shade of each step of the day.
fn shaded_steps(shade: &[[f64; 2]]) -> Result<[f64; STEPS]> {
    if !shade.iter().flatten().all(|hour| hour.is_finite()) {
        return Err(Error::value("surroundings must be finite numbers"));
    }
    let (step, mut shaded) = (DAY_H / STEPS as f64, [0.0; STEPS]);
    for (k, share) in shaded.iter_mut().enumerate() {
        let hour = k as f64 * DAY_H / STEPS as f64;
        let (first, last) = (hour - step / 2.0, hour + step / 2.0);
        for [begin, end] in shade {
            let end = if end < begin { end + DAY_H } else { *end };
            for turn in [-DAY_H, 0.0, DAY_H] {
                *share += (last.min(end + turn) - first.max(begin + turn)).max(0.0);
            }
        }
        *share = (*share / step).min(1.0);
    }
    Ok(shaded)
}

impl Tables {
    /// Open a state, a band (numbers from 1, as in the names of the files) and a source in the folder of a build, by its
    /// `catalog.json`. Values outside the axes named in `clamp` are read at the nearest node.
    ///
    /// # Errors
    /// A file is missing, damaged, of another format, or does not fit the others.
    pub fn open(folder: impl AsRef<Path>, state: u32, band: u32, source: Source, clamp: &[&str]) -> Result<Self> {
        let folder = folder.as_ref();
        let [surface, spectral, air] = files_of(folder, state, band, source)?;
        Self::open_files(folder.join(surface), folder.join(spectral), folder.join(air), clamp)
    }

    /// [`Tables::open`] of named files: an .htt, a .band and an .atmq or .lunar_atmq file.
    ///
    /// # Errors
    /// As [`Tables::open`].
    pub fn open_files(surface: impl AsRef<Path>, band: impl AsRef<Path>, atmosphere: impl AsRef<Path>, clamp: &[&str]) -> Result<Self> {
        let paths = [surface.as_ref(), band.as_ref(), atmosphere.as_ref()];
        let (surface, band) = (Database::open(paths[0], SURFACE, clamp)?, Database::open(paths[1], BAND, clamp)?);
        let mut air = Database::open(paths[2], AIR, clamp)?;
        air.set_ground(&surface.materials);
        for (database, path) in [(&surface, paths[0]), (&band, paths[1]), (&air, paths[2])] {
            database.check().map_err(|error| Error::file(format!("{}: {error}", path.display())))?;
        }
        let mut memory = Memory::of(unsafe { skyshine_tables_size(surface.read(), band.read(), air.read()) });
        let mut failure = Failure::none();
        let status = unsafe { skyshine_tables_make(memory.write(), surface.read(), band.read(), air.read(), &mut failure) };
        check(status, &failure, ErrorKind::File, false).map_err(|error| Error::file(format!("{}: {error}", paths[1].display())))?;
        Ok(Tables { surface, band, air, memory, scratch: Mutex::default() })
    }

    /// Call the library for one place.
    pub(crate) fn call(&self, call: impl FnOnce(*const c_void, *mut c_void, &mut Failure) -> i32) -> Result<()> {
        self.call_many(false, call)
    }

    /// Call the library with the tables, memory of its own, and the place of its failure.
    pub(crate) fn call_many(&self, many: bool, call: impl FnOnce(*const c_void, *mut c_void, &mut Failure) -> i32) -> Result<()> {
        let kept = self.scratch.lock().ok().and_then(|mut kept| kept.pop());
        let mut scratch = kept.unwrap_or_else(|| Memory::of(unsafe { skyshine_scratch_size(self.memory.read()) }));
        let mut failure = Failure::none();
        let status = call(self.memory.read(), scratch.write(), &mut failure);
        if let Ok(mut kept) = self.scratch.lock() {
            kept.push(scratch);
        }
        if status == NO_GROUND && !self.air.ground.is_empty() {
            return Err(Error::value(format!("the surface file lacks the ground '{}'; build all files from one job", self.air.ground)));
        }
        check(status, &failure, ErrorKind::Value, many)
    }

    /// Codes and names of the materials of the band, by ascending code.
    pub fn materials(&self) -> &[(i32, String)] {
        &self.band.materials
    }

    /// Temperature [K] of a face in full sun under the whole sky.
    ///
    /// # Errors
    /// A value outside the tables.
    pub fn temperature(&self, face: &Face) -> Result<f64> {
        let mut kelvin = 0.0;
        self.call(|tables, _, failure| unsafe { skyshine_temperatures(tables, 1, &face.faces(), &face.time, &mut kelvin, failure) })?;
        Ok(kelvin)
    }

    /// Temperature [K] of a face with surroundings.
    ///
    /// # Errors
    /// A value outside the tables, or a surface file without the response to shade.
    pub fn shaded_temperature(&self, face: &Face, surroundings: &Surroundings) -> Result<f64> {
        let (shaded, mut absorbed) = (shaded_steps(&surroundings.shade)?, [0.0; STEPS]);
        let optional = |value: &Option<f64>| value.as_ref().map_or(null(), |value| value as *const f64);
        let around = crate::kernel::Surroundings {
            shaded: shaded.as_ptr(),
            sky_view: &surroundings.sky_view,
            facing: optional(&surroundings.facing),
            facing_emissivity: optional(&surroundings.facing_emissivity),
        };
        self.call(|tables, scratch, failure| unsafe {
            skyshine_absorbed(tables, 1, &face.faces(), &around, 1, absorbed.as_mut_ptr(), scratch, failure)
        })?;
        self.heated_temperature(face, &absorbed)
    }

    /// Temperature [K] of a face that absorbs other heat than that of the tables: means over equal steps of the day, each
    /// centred on its time, the first on midnight, in W m^-2.
    ///
    /// # Errors
    /// As [`Tables::shaded_temperature`].
    pub fn heated_temperature(&self, face: &Face, absorbed: &[f64]) -> Result<f64> {
        if absorbed.is_empty() {
            return Err(Error::value("absorbed_change must be a list of finite numbers"));
        }
        let mut kelvin = 0.0;
        self.call(|tables, scratch, failure| unsafe {
            let (heat, steps) = (absorbed.as_ptr(), absorbed.len());
            skyshine_heated(tables, 1, &face.faces(), heat, steps, &face.time, 1, &mut kelvin, scratch, failure)
        })?;
        Ok(kelvin)
    }

    fn quantity(&self, quantity: i32, line: &Line) -> Result<f64> {
        let mut value = 0.0;
        self.call(|tables, scratch, failure| unsafe {
            skyshine_quantity(tables, quantity, 0, 1, &line.places(), &mut value, scratch, failure)
        })?;
        Ok(value)
    }

    /// Transmittance of the band along a line, (9). Its source is not read.
    ///
    /// # Errors
    /// A value outside the tables.
    pub fn transmittance(&self, line: &Line) -> Result<f64> {
        Ok((-5.5 * line.range / self.quantity(BETA_STAR, line)?).exp())
    }

    /// What the air along a line emits and scatters to its beginning, (11) [W m^-2 sr^-1].
    ///
    /// # Errors
    /// A value outside the tables.
    pub fn path_radiance(&self, line: &Line) -> Result<f64> {
        let depth = 5.5 * line.range / self.quantity(BETA_STAR, line)?;
        Ok(self.quantity(PATH_RATIO, line)? * -(-depth).exp_m1())
    }

    /// Light of the sky on a face at the end of a line, over pi [W m^-2 sr^-1]. `azimuth` of the face is relative to that
    /// of the source. A tilted face needs a file with harmonics; its ground is that which the file states.
    ///
    /// # Errors
    /// A value outside the tables.
    pub fn ambient_radiance(&self, line: &Line, slope: f64, azimuth: f64) -> Result<f64> {
        let mut value = 0.0;
        self.call(|tables, scratch, failure| unsafe {
            skyshine_ambient(tables, 0, 1, &line.places(), &slope, &azimuth, null(), &mut value, scratch, failure)
        })?;
        Ok(value)
    }

    /// Light of the source on a surface normal to it at the end of a line, over pi [W m^-2 sr^-1].
    ///
    /// # Errors
    /// A value outside the tables.
    pub fn direct_radiance(&self, line: &Line) -> Result<f64> {
        self.quantity(DIRECT, line)
    }

    /// Temperature [K] of the black body that has a radiance [W m^-2 sr^-1] in the band.
    ///
    /// # Errors
    /// A radiance beyond those of the band's temperatures.
    pub fn apparent_temperature(&self, radiance: f64) -> Result<f64> {
        let mut kelvin = 0.0;
        self.call(|tables, _, failure| unsafe { skyshine_apparent_temperatures(tables, 1, &radiance, &mut kelvin, failure) })?;
        Ok(kelvin)
    }

    /// Elevation and heading [degree] of the tables' source at a time, 0 to 36 h, from the tracks of the surface file.
    ///
    /// # Errors
    /// A file without tracks, or a time outside them.
    pub fn source_position(&self, time: f64) -> Result<(f64, f64)> {
        if !self.surface.has(c"sun_elevation") {
            return Err(Error::value("the surface file has no tracks of Sun and Moon"));
        }
        let moon = self.air.filetype == "lunar_atmq";
        let names = if moon { ["moon_elevation", "moon_azimuth"] } else { ["sun_elevation", "sun_azimuth"] };
        let mut found = [0.0; 2];
        for (name, value) in names.iter().zip(&mut found) {
            let array = array_number(SURFACE, name);
            self.call(|tables, _, failure| unsafe { skyshine_read(tables, SURFACE, array, 1, &time, value, failure) })?;
        }
        Ok((found[0], found[1]))
    }

    /// Temperature of level ground of a material in full sun.
    pub(crate) fn ground_temperature(&self, material: i32, altitude: f64, time: f64) -> Result<f64> {
        self.temperature(&Face { material, altitude, azimuth: 0.0, slope: 0.0, time })
    }
}

impl Face {
    fn faces(&self) -> Faces {
        Faces { material: &self.material, altitude: &self.altitude, azimuth: &self.azimuth, slope: &self.slope }
    }
}

impl Line {
    fn places(&self) -> Places {
        Places {
            range: &self.range,
            altitude: &self.altitude,
            elevation: &self.elevation,
            source_elevation: &self.source_elevation,
            last: &self.source_azimuth,
        }
    }
}
