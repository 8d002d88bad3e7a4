//! An atmosphere in channels (format 3): its quantities, computed from tables that have no axis of range.
//!
//! Light on surfaces is a list: one number for the whole band, or one for each of its wavelengths.
//! The formulas are those of ../../../../schemas/formats/atmq-3.md; lengths are in km.

use crate::axis::Result;
use crate::database::Database;
use crate::layouts::{CHANNEL_SHARES, CIVIL_TWILIGHT, GLOW, LIGHT};
use std::collections::HashMap;

const SHORTEST: f64 = 1e-12;
const FARTHEST_BETA: f64 = 1e12;
const EARTH_RADIUS: f64 = 6371.0088;
const LINE: [&str; 3] = ["range", "altitude", "elevation"];

type Place<'a> = [(&'a str, f64)];

/// What the file states.
pub struct Channels {
    ground: f64,
    scale: f64,
    /// Least and largest of range, altitude and elevation, and whether values beyond them are read at the ends.
    ends: [(f64, f64, bool); 3],
    dark_below: f64,
}

/// A path: its place in the tables, the length that mean extinction is multiplied by, and the height of its end.
#[derive(Default)]
struct Line {
    share: f64,
    height_root: f64,
    direction: f64,
    length: f64,
    end: f64,
    grounded: bool,
}

/// Height of the end of a straight line over an Earth of a radius.
fn height_at(reach: f64, earth: f64, height: f64, angle: f64) -> f64 {
    let radius = earth + height;
    let step = reach * reach + 2.0 * radius * angle.sin() * reach;
    (step + height * (2.0 * earth + height)) / (earth + (radius * radius + step).max(0.0).sqrt())
}

impl Line {
    fn place(&self) -> [(&'static str, f64); 3] {
        [("share", self.share), ("height_root", self.height_root), ("direction", self.direction)]
    }

    /// A line that meets the ground; `rise` and `fall` are a and c of the page.
    fn meet_ground(&mut self, reach: f64, height: f64, rho: f64, rise: f64, fall: f64) {
        let distance = fall / ((rise * rise - fall).sqrt() - rise);
        let across = 2.0 * rho * height;
        self.share = if distance > 0.0 { (reach / distance).min(1.0) } else { 1.0 };
        self.direction = if across > 0.0 { ((distance * distance - height * height) / across).clamp(0.0, 1.0) } else { 0.0 };
        self.length = reach;
        self.grounded = reach >= distance;
    }

    fn reach_space(&mut self, reach: f64, height: f64, radius: f64, angle: f64, scale: f64) {
        let (rise, above) = (radius * angle.sin(), scale * (2.0 * radius + scale));
        let (level, way) = (above.sqrt(), above / (rise + (rise * rise + above).sqrt()));
        self.share = -(-reach / way).exp_m1();
        self.direction = if angle < 0.0 {
            3.0 - (2.0 * radius * (angle / 2.0).sin().powi(2) / height).clamp(0.0, 1.0).sqrt()
        } else {
            3.0 + ((level - way) / (level - scale)).clamp(0.0, 1.0)
        };
        self.length = way * self.share;
    }
}

/// Shares of so many wavelengths in each channel; no shares where light is not parted.
#[derive(Clone, Copy)]
struct Shares<'a> {
    count: usize,
    values: Option<&'a [f32]>,
}

impl<'a> Shares<'a> {
    const UNDIVIDED: Self = Shares { count: 1, values: None };

    fn of(air: &'a Database, which: usize) -> Self {
        let array = air.array(CHANNEL_SHARES[which].0);
        Shares { count: array.axes[1].nodes.len(), values: Some(&array.values) }
    }

    /// Sum over the channels at each wavelength.
    fn parted(&self, channels: &[f64]) -> Vec<f64> {
        let share = |j: usize, b: usize| self.values.map_or(1.0, |values| f64::from(values[j * self.count + b]));
        (0..self.count).map(|b| channels.iter().enumerate().map(|(j, light)| light * share(j, b)).sum()).collect()
    }
}

/// What parts the light of the air and the ground, and that of the source.
type Parting<'a> = [Shares<'a>; 2];

fn bounded(values: Vec<f64>) -> Vec<f64> {
    values.into_iter().map(|value| value.max(0.0)).collect()
}

/// The optical depth and mean extinction of the channels along a path, and exp(least depth - depth).
struct Path {
    line: Line,
    depth: Vec<f64>,
    extinction: Vec<f64>,
    least: f64,
    through: Vec<f64>,
}

impl Path {
    /// Sum over the channels of a spectrum times 1 - exp(-optical depth).
    fn absorbed(&self, air: &Database, spectrum: &str) -> f64 {
        air.array(spectrum).values.iter().zip(&self.depth).map(|(value, depth)| -f64::from(*value) * (-depth).exp_m1()).sum()
    }

    /// Mean over the channels by their weights.
    fn mean(&self, air: &Database, values: &[f64]) -> f64 {
        air.array("channel_weight").values.iter().zip(values).map(|(weight, value)| f64::from(*weight) * value).sum()
    }

    fn beta_star(&self, air: &Database, reach: f64) -> f64 {
        let absorptance = self.absorbed(air, "channel_weight");
        let thick = self.least - self.mean(air, &self.through).ln();
        let depth = if absorptance < 0.5 { -(-absorptance).ln_1p() } else { thick };
        let over = if reach > 0.0 { depth / reach } else { self.mean(air, &self.extinction) };
        if over > 0.0 { (5.5 / over).min(FARTHEST_BETA) } else { FARTHEST_BETA }
    }

    /// Light on the surface at the end of the path as the path weighs it, over its transmittance, parted by shares.
    fn light(&self, air: &Database, name: &str, place: &Place, spectrum: Option<&[f64]>, shares: Shares) -> Result<Vec<f64>> {
        let value = air.parts(name, &[place, &[("surface_height", self.line.end)]].concat())?;
        let factor = &air.array(&format!("{name}_factor")).values;
        let mean = self.mean(air, &self.through);
        let in_channel = |(j, (through, row)): (usize, (&f64, &[f32]))| {
            let light: f64 = row.iter().zip(&value).map(|(factor, value)| f64::from(*factor) * value).sum();
            through * spectrum.map_or(1.0, |spectrum| spectrum[j]) * light / mean
        };
        let lit: Vec<f64> = self.through.iter().zip(factor.chunks_exact(value.len())).enumerate().map(in_channel).collect();
        Ok(shares.parted(&lit))
    }

    /// Optical depth of emitted light at a wavelength whose share in each channel is given.
    fn optical_depth(&self, air: &Database, share: impl Fn(usize) -> f64) -> f64 {
        let emitted = air.array("thermal_reference").values.iter().enumerate();
        let parts: Vec<f64> = emitted.map(|(j, light)| f64::from(*light) * share(j)).collect();
        let whole: f64 = parts.iter().sum();
        let mean = |values: &[f64]| match whole > 0.0 {
            true => parts.iter().zip(values).map(|(part, value)| part * value).sum::<f64>() / whole,
            false => self.mean(air, values),
        };
        let absorbed = mean(&self.depth.iter().map(|depth| -(-depth).exp_m1()).collect::<Vec<f64>>());
        let through = mean(&self.depth.iter().map(|depth| (-depth).exp()).collect::<Vec<f64>>());
        -(if absorbed < 0.5 { (-absorbed).ln_1p() } else { through.max(f64::MIN_POSITIVE).ln() })
    }
}

fn given(place: &Place, name: &str) -> Result<f64> {
    let found = place.iter().find(|(each, _)| *each == name);
    Ok(found.ok_or_else(|| format!("a quantity needs the axis '{name}'"))?.1)
}

impl Channels {
    pub fn new(stated: &HashMap<&str, Vec<f64>>, dark_below: f64, clamped: &[String]) -> Self {
        let clamps = |name: &str| clamped.iter().any(|each| each == name);
        let span = |name: &str, values: &[f64]| (values[0], values[values.len() - 1], clamps(name));
        Channels {
            ground: stated["ground_altitude_km"][0],
            scale: stated["scale_height_km"][0],
            ends: [span(LINE[0], &stated["range_km"]), span(LINE[1], &stated["altitude_km"]), span(LINE[2], &[-90.0, 90.0])],
            dark_below,
        }
    }

    /// The array that has the codes of `LIGHT` or `GLOW`.
    pub fn stored(quantity: &str) -> &str {
        match quantity {
            LIGHT => "scattered_harmonics",
            GLOW => "ground_harmonics",
            other => other,
        }
    }

    /// A quantity of format 2 at a place.
    pub fn value(&self, air: &Database, quantity: &str, place: &Place) -> Result<f64> {
        let path = self.path(air, place)?;
        match quantity {
            "beta_star" => Ok(path.beta_star(air, self.within(0, place)?)),
            "path_radiance_ratio" => self.path_radiance_ratio(air, &path, place),
            _ => Ok(self.on_surface(air, quantity, &path, place, [Shares::UNDIVIDED; 2])?[0]),
        }
    }

    /// A quantity of light on surfaces at each wavelength.
    pub fn light(&self, air: &Database, quantity: &str, place: &Place) -> Result<Vec<f64>> {
        self.on_surface(air, quantity, &self.path(air, place)?, place, [Shares::of(air, 0), Shares::of(air, 1)])
    }

    /// Extinction per km of emitted light at each wavelength, a mean over the range of the place.
    pub fn extinction(&self, air: &Database, place: &Place) -> Result<Vec<f64>> {
        let path = self.path(air, place)?;
        let array = air.array(CHANNEL_SHARES[0].0);
        let (count, reach) = (array.axes[1].nodes.len(), self.within(0, place)?.max(SHORTEST));
        Ok((0..count).map(|b| path.optical_depth(air, |j| f64::from(array.values[j * count + b])) / reach).collect())
    }

    fn on_surface(&self, air: &Database, quantity: &str, path: &Path, place: &Place, parting: Parting) -> Result<Vec<f64>> {
        match quantity {
            "direct_radiance" => Ok(bounded(self.direct(air, path, given(place, "source_elevation")?, parting[1])?)),
            "ambient_radiance" => Ok(bounded(self.sky(air, "sky", path, place, parting)?)),
            LIGHT => self.sky(air, "harmonics", path, place, parting),
            GLOW => {
                let spectrum = emission(air, given(place, "ground_temperature")?)?;
                path.light(air, "ground_harmonics", place, Some(&spectrum), parting[0])
            }
            _ => Err(format!("the atmosphere file holds no '{quantity}'").into()),
        }
    }

    /// Range, altitude or elevation, which must be one that the file is for.
    fn within(&self, which: usize, place: &Place) -> Result<f64> {
        let (value, (first, last, clamps)) = (given(place, LINE[which])?, self.ends[which]);
        if !value.is_finite() || !(clamps || (first..=last).contains(&value)) {
            return Err(format!("{}: found {value}; allowed: {first} to {last}", LINE[which]).into());
        }
        Ok(value.clamp(first, last))
    }

    fn line(&self, air: &Database, place: &Place) -> Result<Line> {
        let (reach, altitude) = (self.within(0, place)?, self.within(1, place)?);
        let angle = self.within(2, place)?.to_radians();
        let height = (altitude - self.ground).max(0.0);
        let mut line = Line { height_root: height.cbrt(), ..Line::default() };
        let rho = air.interpolated("effective_radius", &line.place())?;
        let (radius, fall) = (rho + height, height * (2.0 * rho + height));
        let rise = radius * angle.sin();
        if angle < 0.0 && rise * rise >= fall {
            line.meet_ground(reach, height, rho, rise, fall);
        } else {
            line.reach_space(reach, height, radius, angle, self.scale);
        }
        line.end = match air.holds("end_rise") {
            _ if line.grounded => 0.0,
            false => height_at(reach, rho, height, angle).max(0.0),
            true => {
                let straight = height_at(reach, EARTH_RADIUS + self.ground, height, angle);
                (straight + reach * air.interpolated("end_rise", &line.place())?).max(0.0)
            }
        };
        Ok(line)
    }

    fn path(&self, air: &Database, place: &Place) -> Result<Path> {
        let line = self.line(air, place)?;
        let mean: Vec<f64> = air.parts("log_mean_extinction", &line.place())?.into_iter().map(f64::exp).collect();
        let of_channel = |row: &[f32]| row.iter().zip(&mean).map(|(factor, mean)| f64::from(*factor) * mean).sum::<f64>().max(0.0);
        let extinction: Vec<f64> = air.array("absorber_factor").values.chunks_exact(mean.len()).map(of_channel).collect();
        let depth: Vec<f64> = extinction.iter().map(|each| each * line.length.max(SHORTEST)).collect();
        let least = depth.iter().copied().fold(f64::INFINITY, f64::min);
        let through = depth.iter().map(|each| (least - each).exp()).collect();
        Ok(Path { line, depth, extinction, least, through })
    }

    fn path_radiance_ratio(&self, air: &Database, path: &Path, place: &Place) -> Result<f64> {
        let height = given(place, "source_elevation")?;
        let lit = [("source_elevation", lit(air, height)?), ("scattering_angle", given(place, "scattering_angle")?)];
        let (factor, ratio) = (air.parts("source_factor", &lit)?, air.parts("scattered_ratio", &path.line.place())?);
        let scattered = factor.iter().zip(&ratio).map(|(factor, ratio)| factor * ratio).sum::<f64>().max(0.0);
        let scattered = self.night(air, height)? * scattered * path.absorbed(air, "source_reference");
        let thermal = air.interpolated("thermal_ratio", &path.line.place())? * path.absorbed(air, "thermal_reference");
        let absorptance = path.absorbed(air, "channel_weight");
        Ok(if absorptance > 0.0 { (thermal + scattered) / absorptance } else { 0.0 })
    }

    fn direct(&self, air: &Database, path: &Path, height: f64, shares: Shares) -> Result<Vec<f64>> {
        lit(air, height)?;
        let target = ("target_height", path.line.end);
        let above = height - air.interpolated("source_rise", &[target])?;
        if above < 0.0 {
            return Ok(vec![0.0; shares.count]);
        }
        path.light(air, "direct_light", &[target, ("elevation_above_rise", above)], None, shares)
    }

    /// What the air emits, and what it scatters.
    fn sky(&self, air: &Database, kind: &str, path: &Path, place: &Place, parting: Parting) -> Result<Vec<f64>> {
        let height = given(place, "source_elevation")?;
        let by_source = [place, &[("sky_source_elevation", lit(air, height)?)]].concat();
        let scattered = path.light(air, &format!("scattered_{kind}"), &by_source, None, parting[1])?;
        let emitted = path.light(air, &format!("thermal_{kind}"), place, None, parting[0])?;
        let share = self.night(air, height)?;
        Ok(emitted.iter().zip(&scattered).map(|(emitted, scattered)| emitted + share * scattered).collect())
    }

    /// Share of the light of the first node that the source gives below it; 1 above.
    fn night(&self, air: &Database, height: f64) -> Result<f64> {
        let axis = &air.array("source_factor").axes[1];
        let lowest = axis.nodes[0];
        if height.is_nan() || height >= lowest {
            return Ok(1.0);
        }
        if height <= self.dark_below {
            return Ok(0.0);
        }
        if lowest > CIVIL_TWILIGHT {
            return axis.locate(height).map(|_| 1.0); // refuses it, or clamps
        }
        Ok((height - self.dark_below) / (lowest - self.dark_below))
    }
}

/// The elevation of the source, or the first node where it is below.
fn lit(air: &Database, height: f64) -> Result<f64> {
    let axis = &air.array("source_factor").axes[1];
    let lit = if height.is_finite() { height.max(axis.nodes[0]) } else { height };
    axis.locate(lit).map(|_| lit) // refuses what the file is not for
}

/// What the ground emits in the channels.
fn emission(air: &Database, kelvin: f64) -> Result<Vec<f64>> {
    let array = air.array("ground_emission");
    let (at, count) = (array.axes[0].locate(kelvin)?, array.axes[1].nodes.len());
    let of = |row: usize, j: usize| f64::from(array.values[row * count + j]);
    Ok((0..count).map(|j| (1.0 - at.weight) * of(at.lower, j) + at.weight * of(at.upper, j)).collect())
}
