//! The light of the sky on faces of any direction, as weights of functions of that direction.

use crate::axis::Result;
use crate::database::Database;
use crate::layouts::{GLOW, HARMONICS, LIGHT};

/// Functions of a direction: the first for the light that no harmonic holds, then the harmonics.
pub const BASES: usize = 12;

/// Values of the axes of a quantity, by name.
pub type Place<'a> = [(&'a str, f64)];

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

/// The functions at a unit normal in the frame of the source's azimuth; of a file with second-degree harmonics or with
/// fourth-degree ones.
pub fn bases(fourth_degree: bool, normal: [f64; 3]) -> [f64; BASES] {
    let square = normal[2] * normal[2];
    let mut values = [0.0; BASES];
    values[0] = if fourth_degree {
        (((231.0 * square - 315.0) * square + 105.0) * square - 5.0) / 16.0
    } else {
        ((35.0 * square - 30.0) * square + 3.0) / 8.0
    };
    values[1..].copy_from_slice(&irradiance_harmonics(normal));
    values
}

/// Whether the harmonics of a file with harmonics go to the fourth degree.
pub fn has_fourth_degree(air: &Database) -> bool {
    air.last_nodes(LIGHT).len() > 6
}

/// Unit normal of a face with an azimuth from that of the source, in degree.
pub fn normal(slope: f64, azimuth: f64) -> [f64; 3] {
    let ((across, up), (y, x)) = (slope.to_radians().sin_cos(), azimuth.to_radians().sin_cos());
    [across * x, across * y, up]
}

/// L_ambient as weights of the bases, each a list of wavelengths, or of one value for the whole band; `ground` is the
/// temperature of the ground and what it emits. One weight, of level faces, where there is no ground.
pub fn ambient_weights(air: &Database, place: &Place, ground: Option<[f64; 2]>, by_wavelength: bool) -> Result<Vec<Vec<f64>>> {
    let light = |name: &str, place: &Place| if by_wavelength { air.light(name, place) } else { Ok(vec![air.value(name, place)?]) };
    let mut weights = vec![light("ambient_radiance", place)?];
    let Some([temperature, emitted]) = ground else { return Ok(weights) };
    for code in air.last_nodes(LIGHT) {
        weights.push(light(LIGHT, &[place, &[("harmonic", *code)]].concat())?);
    }
    for code in air.last_nodes(GLOW) {
        let at = [place, &[("ground_temperature", temperature), ("zonal_harmonic", *code)]].concat();
        let index = HARMONICS.iter().position(|each| each == code).unwrap_or(0);
        for (part, glow) in weights[1 + index].iter_mut().zip(light(GLOW, &at)?) {
            *part += emitted * glow;
        }
    }
    let upright = irradiance_harmonics([0.0, 0.0, 1.0]);
    let (level, harmonics) = weights.split_at_mut(1);
    for (weight, basis) in harmonics.iter().zip(upright) {
        for (level, light) in level[0].iter_mut().zip(weight) {
            *level -= basis * light;
        }
    }
    Ok(weights)
}

/// Light at each wavelength, at least 0.
pub fn summed(weights: &[Vec<f64>], bases: &[f64; BASES]) -> Vec<f64> {
    let one = |b: usize| weights.iter().zip(bases).map(|(weight, basis)| weight[b] * basis).sum::<f64>().max(0.0);
    (0..weights[0].len()).map(one).collect()
}
