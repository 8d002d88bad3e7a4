//! A runtime's reader of the databases with the HDF5 library: the radiance of the pixels of a scene.
//!
//! Usage: runtime SCENE.json
//!
//! The scene and the result are described in ../../README.md. Equation numbers are those of DSTO-TN-0193.

mod axis;
mod channels;
mod database;
mod layouts;
mod shade;
mod source;
mod texture;

use axis::Result;
use database::Database;
use layouts::{GLOW, HARMONICS, LIGHT};
use serde::{Deserialize, Serialize};
use shade::{absorbed_change, temperature_under, Face, Surroundings};
use std::collections::HashMap;
use std::path::Path;
use texture::Texture;

#[derive(Deserialize)]
struct Scene {
    surface: String,
    band: String,
    atmosphere: String,
    texture: Option<String>,
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
    material: Option<Material>,
    texel: Option<[f64; 2]>,
    #[serde(default)]
    level: u32,
    surface_altitude: f64,
    surface_azimuth: f64,
    surface_slope: f64,
    time: f64,
    range: f64,
    centre_range: f64,
    altitude: f64,
    centre_elevation: f64,
    source_elevation: Option<f64>,
    source_azimuth: Option<f64>,
    source_heading: Option<f64>,
    line_heading: Option<f64>,
    ground_material: Option<Material>,
    normal: [f64; 3],
    to_source: Option<[f64; 3]>,
    to_observer: [f64; 3],
    absorbed_change: Option<Vec<f64>>,
    surroundings: Option<Surroundings>,
}

#[derive(Serialize, Default)]
struct Pixel {
    material: f64,
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

/// Equation (44), rounded to the nearest integer: the nearest to x - 1/2, halves upwards, is the floor of x.
fn pixel_value(radiance: f64, scene: &Scene) -> i64 {
    let size = 2f64.powi(scene.bits);
    let share = (radiance / scene.gain).clamp(0.0, 1.0);
    let value = (size * scene.buffer_gain * (share - scene.offset)).floor();
    value.clamp(0.0, size - 1.0) as i64
}

/// Temperature of the table, or with the heat or the surroundings that the pixel has.
fn temperature_of(surface: &Database, face: &Face, given: &Given) -> Result<f64> {
    match (&given.surroundings, &given.absorbed_change) {
        (Some(around), _) => temperature_under(surface, face, &absorbed_change(surface, face, around)?),
        (None, Some(absorbed)) => temperature_under(surface, face, absorbed),
        (None, None) => surface.value("temperature", face),
    }
}

fn code_of(band: &Database, material: &Material) -> Result<f64> {
    match material {
        Material::Code(code) => Ok(*code),
        Material::Name(name) => band.material(name),
    }
}

/// A_l / pi times Y_lm of a unit normal, in the order of the codes.
fn irradiance_harmonics([x, y, z]: [f64; 3]) -> [f64; 11] {
    let even = x * x - y * y;
    [
        0.28209479177387814,
        0.32573500793527993 * z,
        0.32573500793527993 * x,
        0.15769578262626002 * (3.0 * z * z - 1.0) / 2.0,
        0.2731371076480198 * x * z,
        0.1365685538240099 * even,
        -0.03526184897173477 * ((35.0 * z * z - 30.0) * z * z + 3.0) / 8.0,
        -0.0557538786297741 * x * z * (7.0 * z * z - 3.0) / 2.0,
        -0.039423945656565 * even * (7.0 * z * z - 1.0) / 2.0,
        -0.14751089748166088 * x * z * (x * x - 3.0 * y * y) / 2.0,
        -0.026076488977049006 * (even * even - 4.0 * x * x * y * y),
    ]
}

type Place<'a> = [(&'a str, f64)];

/// L_ambient, as `Database::light`, of a face with a normal in the frame of the source's azimuth; temperature of the ground
/// and what it emits.
fn ambient(air: &Database, centre: &Place, normal: [f64; 3], temperature: f64, emitted: f64) -> Result<Vec<f64>> {
    let codes = air.last_nodes(LIGHT);
    let mut total = Vec::new();
    for code in codes {
        total.push(air.light(LIGHT, &[centre, &[("harmonic", *code)]].concat())?);
    }
    for code in air.last_nodes(GLOW) {
        let place = [centre, &[("ground_temperature", temperature), ("zonal_harmonic", *code)]].concat();
        let index = HARMONICS.iter().position(|each| each == code).unwrap_or(0);
        for (part, glow) in total[index].iter_mut().zip(air.light(GLOW, &place)?) {
            *part += emitted * glow;
        }
    }
    let sum = |basis: [f64; 11], b: usize| total.iter().zip(basis).map(|(part, each)| part[b] * each).sum::<f64>();
    let square = normal[2] * normal[2];
    let share = if codes.len() == 6 {
        ((35.0 * square - 30.0) * square + 3.0) / 8.0
    } else {
        (((231.0 * square - 315.0) * square + 105.0) * square - 5.0) / 16.0
    };
    let (facing, upright) = (irradiance_harmonics(normal), irradiance_harmonics([0.0, 0.0, 1.0]));
    let one = |(b, level): (usize, f64)| (sum(facing, b) + (level - sum(upright, b)) * share).max(0.0);
    Ok(air.light("ambient_radiance", centre)?.into_iter().enumerate().map(one).collect())
}

/// Where Sun or Moon stands: its azimuth from the line of sight, and from north eastward; and the direction to it.
struct Source {
    elevation: f64,
    azimuth: f64,
    heading: Option<f64>,
    direction: [f64; 3],
}

/// The source of a pixel: as it says, or from the tracks of the surface file.
fn source_of(surface: &Database, air: &Database, given: &Given) -> Result<Source> {
    let lacks = |key: &str| format!("the scene lacks '{key}'");
    if let Some(elevation) = given.source_elevation {
        return Ok(Source {
            elevation,
            azimuth: given.source_azimuth.ok_or_else(|| lacks("source_azimuth"))?,
            heading: given.source_heading,
            direction: unit(&given.to_source.ok_or_else(|| lacks("to_source"))?)?,
        });
    }
    if !surface.holds("sun_elevation") {
        return Err("the surface file holds no tracks of Sun and Moon".into());
    }
    let names = if air.lunar { ["moon_elevation", "moon_azimuth"] } else { ["sun_elevation", "sun_azimuth"] };
    let time = [("track_time", given.time)];
    let (elevation, heading) = (surface.value(names[0], &time)?, surface.value(names[1], &time)?);
    let from_line = || given.line_heading.map(|line| heading - line).ok_or_else(|| lacks("line_heading"));
    let (up, turn) = (elevation.to_radians(), heading.to_radians());
    Ok(Source {
        elevation,
        azimuth: given.source_azimuth.map_or_else(from_line, Ok)?,
        heading: given.source_heading.or(Some(heading)),
        direction: unit(&given.to_source.unwrap_or([up.cos() * turn.sin(), up.cos() * turn.cos(), up.sin()]))?,
    })
}

/// Codes and shares of the materials that a pixel sees: those of a texel, or one.
fn materials_of(band: &Database, texture: &mut Option<Texture>, given: &Given) -> Result<Vec<(f64, f64)>> {
    match (given.texel, texture, &given.material) {
        (Some(texel), Some(texture), _) => texture.mixture(texel, given.level),
        (Some(_), None, _) => Err("the scene lacks 'texture'".into()),
        (None, _, Some(material)) => Ok(vec![(code_of(band, material)?, 1.0)]),
        (None, _, None) => Err("the scene lacks 'material'".into()),
    }
}

/// Reflectance of a material, and the share in what a black body emits, at each wavelength or in the whole band.
fn reflectance_and_emission(band: &Database, parted: bool, code: f64, temperature: f64) -> Result<(Vec<f64>, Vec<f64>)> {
    if !parted {
        return Ok((vec![band.value("reflectance", &[("material", code)])?], vec![1.0]));
    }
    let emission = band.spectrum("emission_share", ("planck_temperature", temperature))?;
    Ok((band.spectrum("reflectance_spectrum", ("material", code))?, emission))
}

/// L_ambient of a pixel's face, as `Database::light`; of a level one where the file or the pixel says no more.
fn ambient_of_pixel(surface: &Database, band: &Database, air: &Database, centre: &Place, given: &Given, heading: Option<f64>) -> Result<Vec<f64>> {
    let (Some([emissivity, mut temperature, mut emitted]), Some(heading)) = (air.ground, heading) else {
        return air.light("ambient_radiance", centre);
    };
    if let Some(material) = &given.ground_material {
        let level = [
            ("material", code_of(band, material)?),
            ("altitude", given.surface_altitude),
            ("azimuth", 0.0),
            ("slope", 0.0),
            ("time", given.time),
        ];
        temperature = surface.value("temperature", &level)?;
        emitted = emissivity * band.value("blackbody_radiance", &[("temperature", temperature)])?;
    }
    let (slope, turn) = (given.surface_slope.to_radians(), (given.surface_azimuth - heading).to_radians());
    let normal = [slope.sin() * turn.cos(), slope.sin() * turn.sin(), slope.cos()];
    ambient(air, centre, normal, temperature, emitted)
}

/// Equations (1) to (44) for one pixel.
fn pixel(
    scene: &Scene,
    surface: &Database,
    band: &Database,
    air: &Database,
    texture: &mut Option<Texture>,
    given: &Given,
) -> Result<Pixel> {
    let source = source_of(surface, air, given)?;
    let centre = [
        ("range", given.centre_range),
        ("altitude", given.altitude),
        ("elevation", given.centre_elevation),
        ("source_elevation", source.elevation),
        ("source_azimuth", source.azimuth),
        ("scattering_angle", scattering_angle(given.centre_elevation, source.elevation, source.azimuth)),
    ];
    let beta_star = air.value("beta_star", &centre)?;
    let depth = 5.5 * given.range / beta_star;
    let transmittance = (-depth).exp(); // (9)
    let (normal, to_observer) = (unit(&given.normal)?, unit(&given.to_observer)?);
    let incidence = dot(&normal, &source.direction).max(0.0);
    let sky = ambient_of_pixel(surface, band, air, &centre, given, source.heading)?;
    let beam = if incidence > 0.0 { air.light("direct_radiance", &centre)? } else { vec![0.0; sky.len()] };
    let through = air.transmittance(&centre, given.range)?;
    let materials = materials_of(band, texture, given)?;
    let mut sums = Pixel { material: materials[0].0, beta_star, transmittance, ..Pixel::default() };
    for (code, share) in materials {
        let face = [
            ("material", code),
            ("altitude", given.surface_altitude),
            ("azimuth", given.surface_azimuth),
            ("slope", given.surface_slope),
            ("time", given.time),
        ];
        let temperature = temperature_of(surface, &face, given)?;
        let blackbody = band.value("blackbody_radiance", &[("temperature", temperature)])?; // (7)
        let property = |name: &str| band.value(name, &[("material", code)]);
        let fraction = property("specular_fraction")?;
        let (rho, emission) = reflectance_and_emission(band, air.parted, code, temperature)?;
        let emitted: f64 = rho.iter().zip(&emission).zip(&through).map(|((rho, share), through)| (1.0 - rho) * share * through).sum();
        let reflected = |light: &[f64]| rho.iter().zip(light).map(|(rho, light)| rho * light).sum::<f64>().max(0.0);
        let direct = reflected(&beam) * transmittance;
        sums.temperature += share * temperature;
        sums.blackbody_radiance += share * blackbody;
        sums.thermal += share * blackbody * emitted; // (5), or (6)
        sums.skyshine += share * reflected(&sky) * transmittance; // (18), or (19)
        sums.diffuse += share * direct * incidence * (1.0 - fraction); // (34)
        let shape = lobe(&normal, &source.direction, &to_observer, property("shininess")?);
        sums.specular += share * direct * shape * fraction * property("normalisation")?; // (35)
    }
    sums.path = air.value("path_radiance_ratio", &centre)? * -(-depth).exp_m1(); // (11)
    sums.radiance = sums.diffuse + sums.specular + sums.skyshine + sums.thermal + sums.path; // (1)
    sums.pixel_value = pixel_value(sums.radiance, scene);
    Ok(sums)
}

fn run(path: &Path) -> Result<String> {
    let scene: Scene = serde_json::from_str(&std::fs::read_to_string(path)?)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let surface = Database::open(&folder.join(&scene.surface), &["htt"], &scene.clamp)?;
    let band_path = folder.join(&scene.band);
    let band = Database::open(&band_path, &["band"], &scene.clamp)?;
    let mut air = Database::open(&folder.join(&scene.atmosphere), &["atmq", "lunar_atmq"], &scene.clamp)?;
    air.part_light(&band, &band_path)?;
    let mut texture = scene.texture.as_ref().map(|name| Texture::open(&folder.join(name))).transpose()?;
    let one = |given: &Given| pixel(&scene, &surface, &band, &air, &mut texture, given);
    let pixels: Result<Vec<Pixel>> = scene.pixels.iter().map(one).collect();
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
