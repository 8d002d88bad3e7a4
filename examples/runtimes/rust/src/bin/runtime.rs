//! The program of this folder: the radiance of the pixels of a scene, by the public calls alone.
//!
//! Usage: runtime SCENE.json
//!
//! The scene and the result are described in ../../../README.md.

use serde::{Deserialize, Serialize};
use skyshine::{pixel_value, Face, Pixel, Pixels, Shade, Surroundings, Tables, Texture, View, SHADED_SKY};
use std::collections::HashMap;
use std::path::Path;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

#[derive(Deserialize)]
struct Scene {
    surface: String,
    band: String,
    atmosphere: String,
    texture: Option<String>,
    shaded_sky: Option<f64>,
    #[serde(default)]
    clamp: Vec<String>,
    #[serde(default)]
    bits: i32,
    #[serde(default)]
    gain: f64,
    #[serde(default)]
    buffer_gain: f64,
    #[serde(default)]
    offset: f64,
    #[serde(default)]
    pixels: Vec<Given>,
    frame: Option<GivenFrame>,
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
    surroundings: Option<Around>,
    sky_view: Option<f64>,
}

#[derive(Deserialize)]
struct Around {
    #[serde(default)]
    shade: Vec<[f64; 2]>,
    sky_view: Option<f64>,
    facing: Option<f64>,
    facing_emissivity: Option<f64>,
}

#[derive(Deserialize)]
struct GivenFrame {
    altitude: f64,
    centre_range: f64,
    centre_elevation: f64,
    centre_heading: f64,
    source_elevation: f64,
    source_heading: f64,
    time: f64,
    ground_material: Option<Material>,
    #[serde(default)]
    ground_altitude: f64,
    #[serde(default = "once")]
    repeat: usize,
    material: Vec<Material>,
    range: Vec<f64>,
    elevation: Option<Vec<f64>>,
    heading: Option<Vec<f64>>,
    surface_altitude: Vec<f64>,
    surface_azimuth: Vec<f64>,
    surface_slope: Vec<f64>,
    temperature: Option<Vec<f64>>,
}

fn once() -> usize {
    1
}

#[derive(Serialize)]
struct Shown {
    material: i32,
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

#[derive(Serialize)]
struct ShownFrame {
    radiance: Vec<f64>,
}

fn code_of(tables: &Tables, material: &Material) -> Result<i32> {
    match material {
        Material::Code(code) if code.fract() == 0.0 && (1.0..=65535.0).contains(code) => Ok(*code as i32),
        Material::Code(code) => Err(format!("material: found {code}; allowed: a code of the file").into()),
        Material::Name(name) => {
            let found = tables.materials().iter().find(|(_, each)| each == name);
            Ok(found.ok_or_else(|| format!("material: found '{name}'; allowed: a name of the file"))?.0)
        }
    }
}

/// The source of a pixel, as it says or by the tracks: elevation, azimuth from the line, heading, direction.
fn source_of(tables: &Tables, given: &Given) -> Result<(f64, f64, Option<f64>, [f64; 3])> {
    let lacks = |key: &str| format!("the scene lacks '{key}'");
    if let Some(elevation) = given.source_elevation {
        let azimuth = given.source_azimuth.ok_or_else(|| lacks("source_azimuth"))?;
        return Ok((elevation, azimuth, given.source_heading, given.to_source.ok_or_else(|| lacks("to_source"))?));
    }
    let (elevation, heading) = tables.source_position(given.time)?;
    let from_line = || given.line_heading.map(|line| heading - line).ok_or_else(|| lacks("line_heading"));
    let (up, turn) = (elevation.to_radians(), heading.to_radians());
    let direction = given.to_source.unwrap_or([up.cos() * turn.sin(), up.cos() * turn.cos(), up.sin()]);
    Ok((elevation, given.source_azimuth.map_or_else(from_line, Ok)?, given.source_heading.or(Some(heading)), direction))
}

impl Around {
    fn surroundings(&self) -> Surroundings {
        let usual = Surroundings::default();
        Surroundings {
            shade: self.shade.clone(),
            sky_view: self.sky_view.unwrap_or(usual.sky_view),
            facing: self.facing,
            facing_emissivity: self.facing_emissivity,
        }
    }
}

/// What of a pixel lies in the shade: a share of it under a share of the sky.
fn shade_of(tables: &Tables, faces: &[Face], given: &Given, share: f64, sky: f64) -> Result<Option<Shade>> {
    if share == 0.0 {
        return Ok(None);
    }
    let mut temperatures = Vec::new();
    if let Some(around) = &given.surroundings {
        let own = around.surroundings();
        let sky_view = own.sky_view.min(sky).min(given.sky_view.unwrap_or(1.0));
        let whole_day = Surroundings { shade: vec![[0.0, 24.0]], sky_view, ..own };
        temperatures = faces.iter().map(|face| tables.shaded_temperature(face, &whole_day)).collect::<skyshine::Result<_>>()?;
    } else if given.absorbed_change.is_some() {
        return Err("a texel in the shade takes 'surroundings' in place of 'absorbed_change'".into());
    }
    Ok(Some(Shade { share, sky, temperatures }))
}

/// Temperature of a material where the pixel has surroundings or other heat.
fn temperature_of(tables: &Tables, face: &Face, given: &Given) -> Result<Option<f64>> {
    match (&given.surroundings, &given.absorbed_change) {
        (Some(around), _) => Ok(Some(tables.shaded_temperature(face, &around.surroundings())?)),
        (None, Some(absorbed)) => Ok(Some(tables.heated_temperature(face, absorbed)?)),
        (None, None) => Ok(None),
    }
}

fn pixel(scene: &Scene, tables: &Tables, texture: &mut Option<Texture>, given: &Given) -> Result<Shown> {
    let (source_elevation, source_azimuth, source_heading, to_source) = source_of(tables, given)?;
    let mut share = 0.0;
    let materials = match (given.texel, texture, &given.material) {
        (Some(texel), Some(texture), _) => {
            share = texture.shade(texel, given.level)?;
            texture.mixture(texel, given.level)?
        }
        (Some(_), None, _) => return Err("the scene lacks 'texture'".into()),
        (None, _, Some(material)) => vec![(code_of(tables, material)?, 1.0)],
        (None, _, None) => return Err("the scene lacks 'material'".into()),
    };
    let (altitude, azimuth, slope, time) = (given.surface_altitude, given.surface_azimuth, given.surface_slope, given.time);
    let faces: Vec<Face> = materials.iter().map(|(material, _)| Face { material: *material, altitude, azimuth, slope, time }).collect();
    let temperatures: Vec<Option<f64>> = faces.iter().map(|face| temperature_of(tables, face, given)).collect::<Result<_>>()?;
    let terms = tables.pixel_radiance(&Pixel {
        temperatures: temperatures.into_iter().flatten().collect(),
        surface_altitude: altitude,
        surface_azimuth: azimuth,
        surface_slope: slope,
        time,
        range: given.range,
        centre_range: given.centre_range,
        centre_elevation: given.centre_elevation,
        altitude: given.altitude,
        source_elevation,
        source_azimuth,
        source_heading,
        ground_material: given.ground_material.as_ref().map(|material| code_of(tables, material)).transpose()?,
        normal: given.normal,
        to_source,
        to_observer: given.to_observer,
        hidden_sky: 1.0 - given.sky_view.unwrap_or(1.0),
        shade: shade_of(tables, &faces, given, share, scene.shaded_sky.unwrap_or(SHADED_SKY))?,
        materials: materials.clone(),
    })?;
    Ok(Shown {
        material: materials[0].0,
        temperature: terms.temperature,
        blackbody_radiance: terms.blackbody_radiance,
        beta_star: terms.beta_star,
        transmittance: terms.transmittance,
        thermal: terms.thermal,
        path: terms.path,
        skyshine: terms.skyshine,
        diffuse: terms.diffuse,
        specular: terms.specular,
        radiance: terms.radiance,
        pixel_value: pixel_value(terms.radiance, scene.bits, scene.gain, scene.buffer_gain, scene.offset),
    })
}

fn frame(tables: &Tables, given: &GivenFrame) -> Result<ShownFrame> {
    let material: Vec<i32> = given.material.iter().map(|material| code_of(tables, material)).collect::<Result<_>>()?;
    let ground = given.ground_material.as_ref().map(|material| code_of(tables, material)).transpose()?;
    let view = View {
        altitude: given.altitude,
        centre_range: given.centre_range,
        centre_elevation: given.centre_elevation,
        centre_heading: given.centre_heading,
        source_elevation: given.source_elevation,
        source_heading: given.source_heading,
        time: given.time,
        ground: ground.map(|code| (code, given.ground_altitude)),
    };
    let pixels = Pixels {
        material: &material,
        range: &given.range,
        lines: given.elevation.as_deref().zip(given.heading.as_deref()),
        surface_altitude: &given.surface_altitude,
        surface_azimuth: &given.surface_azimuth,
        surface_slope: &given.surface_slope,
        temperature: given.temperature.as_deref(),
    };
    let mut radiance = vec![0.0; material.len()];
    for _ in 0..given.repeat {
        tables.frame_radiance(&view, &pixels, &mut radiance)?;
    }
    Ok(ShownFrame { radiance })
}

fn run(path: &Path) -> Result<String> {
    let scene: Scene = serde_json::from_str(&std::fs::read_to_string(path)?)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let clamp: Vec<&str> = scene.clamp.iter().map(String::as_str).collect();
    let tables = Tables::open_files(folder.join(&scene.surface), folder.join(&scene.band), folder.join(&scene.atmosphere), &clamp)?;
    let mut texture = scene.texture.as_ref().map(|name| Texture::open(folder.join(name))).transpose()?;
    if let Some(given) = &scene.frame {
        return Ok(serde_json::to_string(&frame(&tables, given)?)?);
    }
    let pixels: Vec<Shown> = scene.pixels.iter().map(|given| pixel(&scene, &tables, &mut texture, given)).collect::<Result<_>>()?;
    Ok(serde_json::to_string(&HashMap::from([("pixels", pixels)]))?)
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
