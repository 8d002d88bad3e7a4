//! A runtime's reader of the databases with the HDF5 library: the radiance of the pixels of a scene.
//!
//! Usage: runtime SCENE.json
//!
//! The scene and the result are described in ../../README.md. Equation numbers are those of DSTO-TN-0193.

use hdf5::types::VarLenUnicode;
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::collections::HashMap;
use std::path::Path;
use std::rc::Rc;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

#[derive(Deserialize)]
struct Scene {
    surface: String,
    band: String,
    atmosphere: String,
    #[serde(default)]
    clamp: Vec<String>,
    bits: i32,
    gain: f64,
    buffer_gain: f64,
    offset: f64,
    pixels: Vec<Given>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Material {
    Code(f64),
    Name(String),
}

#[derive(Deserialize)]
struct Given {
    material: Material,
    surface_altitude: f64,
    surface_azimuth: f64,
    surface_slope: f64,
    time: f64,
    range: f64,
    centre_range: f64,
    altitude: f64,
    centre_elevation: f64,
    source_elevation: f64,
    source_azimuth: f64,
    normal: [f64; 3],
    to_source: [f64; 3],
    to_observer: [f64; 3],
}

#[derive(Serialize)]
struct Pixel {
    temperature: f64,
    blackbody_radiance: f64,
    beta_star: f64,
    transmittance: f64,
    thermal: f64,
    path: f64,
    skyshine: f64,
    diffuse: f64,
    specular: f64,
    radiance: f64,
    pixel_value: i64,
}

fn text(place: &hdf5::Location, name: &str) -> Option<String> {
    let value = place.attr(name).ok()?.read_scalar::<VarLenUnicode>().ok()?;
    Some(value.as_str().to_owned())
}

/// Neighbouring nodes of a value and the weight of the upper one.
struct Place {
    lower: usize,
    upper: usize,
    weight: f64,
}

struct Axis {
    name: String,
    nodes: Vec<f64>,
    interpolation: String,
    period: f64,
    clamps: bool,
}

impl Axis {
    fn read(name: &str, dataset: &hdf5::Dataset, clamped: bool) -> Result<Self> {
        let period = dataset.attr("period").ok().and_then(|a| a.read_scalar::<f64>().ok());
        Ok(Axis {
            name: name.to_owned(),
            nodes: dataset.read_raw::<f64>()?,
            interpolation: text(dataset, "interpolation").unwrap_or_else(|| "linear".into()),
            period: period.unwrap_or(0.0),
            clamps: clamped || text(dataset, "out_of_range").as_deref() == Some("clamp"),
        })
    }

    fn locate(&self, given: f64) -> Result<Place> {
        if !given.is_finite() {
            return Err(format!("{}: found {given}; allowed: finite numbers", self.name).into());
        }
        let (mut value, mut nodes) = (given, self.nodes.clone());
        match self.interpolation.as_str() {
            "exact" => {
                let at = nodes.iter().position(|node| *node == value);
                let at = at.ok_or_else(|| format!("{}: found {value}; allowed: a code of the file", self.name))?;
                return Ok(Place { lower: at, upper: at, weight: 0.0 });
            }
            "linear_periodic" => {
                nodes.push(nodes[0] + self.period);
                value = nodes[0] + (value - nodes[0]).rem_euclid(self.period);
            }
            "linear" if self.period > 0.0 => {
                value -= self.period * ((value - nodes[0]) / self.period).floor();
            }
            "linear_folded" => {
                value = ((value + self.period / 2.0).rem_euclid(self.period) - self.period / 2.0).abs();
            }
            _ => {}
        }
        let (first, last) = (nodes[0], nodes[nodes.len() - 1]);
        if !self.clamps && !(first..=last).contains(&value) {
            return Err(format!("{}: found {value}; allowed: {first} to {last}", self.name).into());
        }
        value = value.clamp(first, last);
        let below = nodes.partition_point(|node| *node <= value);
        let lower = below.saturating_sub(1).min(nodes.len().saturating_sub(2));
        let upper = (lower + 1).min(nodes.len() - 1);
        let weight = if upper > lower { (value - nodes[lower]) / (nodes[upper] - nodes[lower]) } else { 0.0 };
        Ok(Place { lower, upper: upper % self.nodes.len(), weight })
    }
}

/// One file; axes and arrays are read when they are first asked for.
struct Database {
    file: hdf5::File,
    clamped: Vec<String>,
    axes: RefCell<HashMap<String, Rc<Axis>>>,
    arrays: RefCell<HashMap<String, Rc<Vec<f32>>>>,
}

impl Database {
    fn open(path: &Path, filetypes: &[&str], clamped: &[String]) -> Result<Self> {
        let shown = path.display();
        let file = hdf5::File::open(path).map_err(|_| format!("{shown}: is not a readable HDF5 file"))?;
        let filetype = text(&file, "filetype").unwrap_or_default();
        let version = text(&file, "format_version").unwrap_or_default();
        let major = if filetypes[0] == "atmq" { "2" } else { "1" };
        if !filetypes.contains(&filetype.as_str()) || version.split('.').next() != Some(major) {
            let allowed = filetypes.join(" or ");
            return Err(format!("{shown}: holds '{filetype}' {version}; allowed: {allowed} {major}.x").into());
        }
        Ok(Database { file, clamped: clamped.to_vec(), axes: RefCell::default(), arrays: RefCell::default() })
    }

    /// The quantity's own axis where the file has one, else the one that quantities share.
    fn axis(&self, quantity: &str, name: &str) -> Result<Rc<Axis>> {
        let own = format!("{quantity}_{name}");
        if let Some(axis) = self.axes.borrow().get(&own) {
            return Ok(axis.clone());
        }
        let clamped = self.clamped.iter().any(|each| each == name);
        let kept = if self.file.link_exists(&own) { own.as_str() } else { name };
        let axis = Rc::new(Axis::read(name, &self.file.dataset(kept)?, clamped)?);
        self.axes.borrow_mut().insert(own, axis.clone());
        Ok(axis)
    }

    fn array(&self, name: &str) -> Result<Rc<Vec<f32>>> {
        if let Some(array) = self.arrays.borrow().get(name) {
            return Ok(array.clone());
        }
        let array = Rc::new(self.file.dataset(name)?.read_raw::<f32>()?);
        self.arrays.borrow_mut().insert(name.to_owned(), array.clone());
        Ok(array)
    }

    /// Linear interpolation in every axis: the weighted sum over the corners of one cell.
    fn value(&self, quantity: &str, place: &[(&str, f64)]) -> Result<f64> {
        let array = self.array(quantity)?;
        let mut located = Vec::new();
        for (name, value) in place {
            let axis = self.axis(quantity, name)?;
            located.push((axis.locate(*value)?, axis.nodes.len()));
        }
        let mut total = 0.0;
        for corner in 0..1usize << place.len() {
            let (mut share, mut index) = (1.0, 0);
            for (k, (at, size)) in located.iter().enumerate() {
                let up = corner >> k & 1 == 1;
                share *= if up { at.weight } else { 1.0 - at.weight };
                index = index * size + if up { at.upper } else { at.lower };
            }
            if share != 0.0 {
                total += share * f64::from(array[index]);
            }
        }
        Ok(total)
    }

    /// Code of a material given by code or by name.
    fn material(&self, given: &Material) -> Result<f64> {
        let name = match given {
            Material::Code(code) => return Ok(*code),
            Material::Name(name) => name,
        };
        let names = self.file.dataset("material_name")?.read_raw::<VarLenUnicode>()?;
        let at = names.iter().position(|known| known.as_str() == name);
        let at = at.ok_or_else(|| format!("material: found '{name}'; allowed: a name of the file"))?;
        Ok(self.axis("material_name", "material")?.nodes[at])
    }
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(vector: &[f64; 3]) -> Result<[f64; 3]> {
    let length = dot(vector, vector).sqrt();
    if !length.is_finite() || length == 0.0 {
        return Err("a direction must be three finite numbers that are not all 0".into());
    }
    Ok(vector.map(|part| part / length))
}

/// Angle between line of sight and source, all in degree.
fn scattering_angle(elevation: f64, source_elevation: f64, azimuth: f64) -> f64 {
    let (line, source) = (elevation.to_radians(), source_elevation.to_radians());
    let turn = (azimuth.to_radians() / 2.0).sin().powi(2);
    let half = ((line - source) / 2.0).sin().powi(2) + line.cos() * source.cos() * turn;
    2.0 * half.clamp(0.0, 1.0).sqrt().asin().to_degrees()
}

/// Equations (37) and (38): chi of the half vector to the power of the shininess.
fn lobe(normal: &[f64; 3], to_source: &[f64; 3], to_observer: &[f64; 3], shininess: f64) -> f64 {
    let between = [0, 1, 2].map(|k| to_source[k] + to_observer[k]);
    let length = dot(&between, &between).sqrt();
    let chi = if length > 0.0 { dot(&between, normal) / length } else { 0.0 };
    chi.clamp(0.0, 1.0).powf(shininess)
}

/// Equation (44).
fn pixel_value(radiance: f64, scene: &Scene) -> i64 {
    let size = 2f64.powi(scene.bits);
    let share = (radiance / scene.gain).clamp(0.0, 1.0);
    let value = (size * scene.buffer_gain * (share - scene.offset) - 0.5).trunc();
    value.clamp(0.0, size - 1.0) as i64
}

/// Equations (1) to (44) for one pixel.
fn pixel(scene: &Scene, surface: &Database, band: &Database, air: &Database, given: &Given) -> Result<Pixel> {
    let code = band.material(&given.material)?;
    let face = [
        ("material", code),
        ("altitude", given.surface_altitude),
        ("azimuth", given.surface_azimuth),
        ("slope", given.surface_slope),
        ("time", given.time),
    ];
    let temperature = surface.value("temperature", &face)?;
    let blackbody_radiance = band.value("blackbody_radiance", &[("temperature", temperature)])?; // (7)
    let property = |name: &str| band.value(name, &[("material", code)]);
    let (rho, fraction) = (property("reflectance")?, property("specular_fraction")?);
    let centre = [
        ("range", given.centre_range),
        ("altitude", given.altitude),
        ("elevation", given.centre_elevation),
        ("source_elevation", given.source_elevation),
        ("source_azimuth", given.source_azimuth),
    ];
    let beta_star = air.value("beta_star", &centre[..3])?;
    let depth = 5.5 * given.range / beta_star;
    let transmittance = (-depth).exp(); // (9)
    let mut along = centre;
    if air.file.link_exists("scattering_angle") {
        along[4] = ("scattering_angle", scattering_angle(given.centre_elevation, given.source_elevation, given.source_azimuth));
    }
    let path = air.value("path_radiance_ratio", &along)? * -(-depth).exp_m1(); // (11)
    let skyshine = air.value("ambient_radiance", &centre[..4])? * rho * transmittance; // (19)
    let (normal, to_source, to_observer) = (unit(&given.normal)?, unit(&given.to_source)?, unit(&given.to_observer)?);
    let incidence = dot(&normal, &to_source).max(0.0);
    let lit = incidence > 0.0;
    let direct = if lit { air.value("direct_radiance", &centre[..4])? * rho * transmittance } else { 0.0 };
    let thermal = blackbody_radiance * (1.0 - rho) * transmittance; // (6)
    let diffuse = direct * incidence * (1.0 - fraction); // (34)
    let shape = lobe(&normal, &to_source, &to_observer, property("shininess")?);
    let specular = direct * shape * fraction * property("normalisation")?; // (35)
    let radiance = diffuse + specular + skyshine + thermal + path; // (1)
    let pixel_value = pixel_value(radiance, scene);
    Ok(Pixel {
        temperature,
        blackbody_radiance,
        beta_star,
        transmittance,
        thermal,
        path,
        skyshine,
        diffuse,
        specular,
        radiance,
        pixel_value,
    })
}

fn run(path: &Path) -> Result<String> {
    let scene: Scene = serde_json::from_str(&std::fs::read_to_string(path)?)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let surface = Database::open(&folder.join(&scene.surface), &["htt"], &scene.clamp)?;
    let band = Database::open(&folder.join(&scene.band), &["band"], &scene.clamp)?;
    let air = Database::open(&folder.join(&scene.atmosphere), &["atmq", "lunar_atmq"], &scene.clamp)?;
    let pixels: Result<Vec<Pixel>> =
        scene.pixels.iter().map(|given| pixel(&scene, &surface, &band, &air, given)).collect();
    Ok(serde_json::to_string(&HashMap::from([("pixels", pixels?)]))?)
}

fn main() {
    let path = std::env::args().nth(1).unwrap_or_default();
    match run(Path::new(&path)) {
        Ok(result) => println!("{result}"),
        Err(error) => {
            eprintln!("{error}");
            std::process::exit(1);
        }
    }
}
