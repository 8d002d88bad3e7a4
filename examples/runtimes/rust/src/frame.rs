//! Many pixels of one observer, one source and one time: what they share is resolved once.

use crate::axis::{self, Axis};
use crate::error::{of_value, Result};
use crate::light::{ambient_weights, bases, has_fourth_degree, normal, BASES};
use crate::tables::{Face, Line, Tables};

/// Panels of the lattice of ranges: in each octave of range + NEAREST equally many of equal length, each with a cubic.
const OCTAVE_BITS: u32 = 4;
const PANELS: usize = 22 << OCTAVE_BITS;
const NEAREST: f64 = 1.0 / 1024.0;
/// km.
const FARTHEST: f64 = 4095.0;
const CELLS_LIMIT: f64 = 65536.0;

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

/// An axis whose cells are found by one division and few comparisons. A periodic one has its first node again at its end; one
/// of a single node has a second one, at which the same values stand.
struct Grid {
    name: String,
    nodes: Vec<f64>,
    first: f64,
    last: f64,
    scale: f64,
    period: f64,
    clamps: bool,
    /// The lowest cell that reaches into an equal part of the axis.
    cell: Vec<u32>,
}

impl Grid {
    fn new(axis: &Axis) -> Self {
        let mut nodes = axis.nodes.clone();
        let (first, mut last) = (nodes[0], nodes[nodes.len() - 1]);
        let closed = axis.rule == "linear_periodic";
        if closed {
            last = first + axis.period;
            nodes.push(last);
        } else if nodes.len() == 1 {
            nodes.push(first + 1.0);
        }
        let length = nodes[nodes.len() - 1] - first;
        let shortest = nodes.windows(2).map(|pair| pair[1] - pair[0]).fold(length, f64::min);
        let parts = (2.0 * length / shortest).ceil().min(CELLS_LIMIT);
        let scale = parts / length;
        // One part earlier, for the division that finds the part may round.
        let lowest = |part: usize| nodes[1..nodes.len() - 1].partition_point(|node| *node <= first + (part as f64 - 1.0) / scale) as u32;
        let cell = (0..=parts as usize).map(lowest).collect();
        let period = if closed { axis.period } else { 0.0 };
        Grid { name: axis.name.clone(), first, last, scale, period, clamps: axis.clamps, cell, nodes }
    }

    /// Lower node and weight of the upper one.
    fn locate(&self, given: f64) -> Option<(usize, f64)> {
        let value = if self.period > 0.0 { given - self.period * ((given - self.first) / self.period).floor() } else { given };
        if !value.is_finite() || !(self.clamps || (value >= self.first && value <= self.last)) {
            return None;
        }
        let value = value.clamp(self.first, self.last);
        let mut lower = self.cell[((value - self.first) * self.scale) as usize] as usize;
        while lower + 2 < self.nodes.len() && value >= self.nodes[lower + 1] {
            lower += 1;
        }
        Some((lower, (value - self.nodes[lower]) / (self.nodes[lower + 1] - self.nodes[lower])))
    }

    fn refusal(&self, pixel: usize, value: f64) -> String {
        format!("pixel {pixel}: {}: found {value}; allowed: {} to {}", self.name, self.first, self.last)
    }
}

/// A material: emission by panel and node of temperature (four coefficients of a cubic of the place in the panel), light of
/// the sky by basis, what the beam becomes by (34) and (35), and temperatures of the surface file, where it has the material.
struct Material {
    emission: Vec<[f64; 4]>,
    sky: [f64; BASES],
    /// Reflectance at the wavelengths at which light is bounded.
    bounded: Vec<f64>,
    diffuse: f64,
    specular: f64,
    shininess: f64,
    temperature: Option<Vec<f64>>,
}

/// A frame: the atmosphere at its centre, the temperatures at its time, and the emission of each material over a fine lattice
/// of range, from which its radiances differ by less than 1e-6 of those of [`Tables::pixel_radiance`].
pub struct Frame {
    extinction: f64,
    path_ratio: f64,
    source_heading: f64,
    to_source: [f64; 2],
    centre: (f64, f64),
    materials: Vec<Material>,
    by_code: Vec<(i32, usize)>,
    altitude: Grid,
    azimuth: Grid,
    slope: Grid,
    kelvin: Grid,
    planck: Grid,
    blackbody: Vec<f64>,
    level: bool,
    fourth_degree: bool,
    /// Weights of the bases at wavelengths at which light may fall below 0, where it is bounded.
    bounded: Vec<[f64; BASES]>,
}

/// Begin of a panel, with NEAREST.
fn panel_begin(panel: usize) -> f64 {
    f64::from_bits(NEAREST.to_bits() + ((panel as u64) << (52 - OCTAVE_BITS)))
}

/// Panel of a range and the place in it.
fn panel_of(range: f64) -> (usize, f64) {
    let bits = (range + NEAREST).to_bits() - NEAREST.to_bits();
    let inside = (bits << OCTAVE_BITS) & 0x000F_FFFF_FFFF_FFFF;
    ((bits >> (52 - OCTAVE_BITS)) as usize, f64::from_bits(inside | 0x3FF0_0000_0000_0000) - 1.0)
}

/// Sum over wavelengths of weight times e^(-extinction range), as cubics of the place in each panel.
fn cubics(weight: &[f64], extinction: &[f64]) -> Vec<[f64; 4]> {
    let panel = |k: usize| {
        let (begin, length) = (panel_begin(k), panel_begin(k + 1) - panel_begin(k));
        let end = |at: f64| {
            let part = |(weight, extinction): (&f64, &f64)| (weight * (-extinction * (begin - NEAREST + at * length)).exp(), *extinction);
            let parts = weight.iter().zip(extinction).map(part);
            parts.fold((0.0, 0.0), |(value, slope), (part, extinction)| (value + part, slope - part * extinction * length))
        };
        let ((low, rise), (high, fall)) = (end(0.0), end(1.0));
        [low, rise, 3.0 * (high - low) - 2.0 * rise - fall, 2.0 * (low - high) + rise + fall]
    };
    (0..PANELS).map(panel).collect()
}

/// Whether light may fall below 0, or near it, in some direction of a face.
fn may_be_bounded(weights: &[f64; BASES], level: bool, fourth_degree: bool) -> bool {
    if level {
        return weights[0] < 0.0;
    }
    let (mut least, mut most) = (f64::INFINITY, 0f64);
    for step in 0..31 * 31 {
        let at = bases(fourth_degree, normal(f64::from(step / 31 * 6), f64::from(step % 31 * 6)));
        let light: f64 = at.iter().zip(weights).map(|(basis, weight)| basis * weight).sum();
        (least, most) = (least.min(light), most.max(light.abs()));
    }
    least < 0.02 * most
}

/// Temperatures of a material at a time, with the nodes that grids have beyond those of the axes.
fn temperatures(tables: &Tables, code: f64, time: f64, grids: [&Grid; 3]) -> axis::Result<Vec<f64>> {
    let axes = &tables.surface.array("temperature").axes;
    let node = |k: usize, i: usize| axes[k].nodes[i % axes[k].nodes.len()];
    let [rows, columns, slopes] = grids.map(|grid| grid.nodes.len());
    let one = |at: usize| {
        let (altitude, azimuth, slope) = (node(1, at / (columns * slopes)), node(2, at / slopes % columns), node(3, at % slopes));
        tables.surface.value("temperature", &Face { material: code as i32, altitude, azimuth, slope, time }.place())
    };
    (0..rows * columns * slopes).map(one).collect()
}

impl Tables {
    /// Resolve all that the pixels of a frame share.
    ///
    /// # Errors
    /// A value outside the tables.
    pub fn frame(&self, view: &View) -> Result<Frame> {
        of_value(self.make_frame(view))
    }

    fn make_frame(&self, view: &View) -> axis::Result<Frame> {
        let line = Line {
            range: view.centre_range,
            altitude: view.altitude,
            elevation: view.centre_elevation,
            source_elevation: view.source_elevation,
            source_azimuth: view.source_heading - view.centre_heading,
        };
        if !line.source_azimuth.is_finite() {
            return Err("heading: found a value that is not finite; allowed: finite numbers".into());
        }
        let (centre, air, band) = (line.place(), &self.air, &self.band);
        let ground = self.ground(view.ground.map(|(code, _)| code), view.ground.map_or(0.0, |(_, altitude)| altitude), view.time)?;
        let weights = ambient_weights(air, &centre, ground, true)?;
        let (level, fourth_degree) = (ground.is_none(), ground.is_some() && has_fourth_degree(air));
        let (beam, extinction) = (air.light("direct_radiance", &centre)?, air.extinction(&centre)?);
        let parts = beam.len();
        let weights_at = |b: usize| {
            let mut at = [0.0; BASES];
            weights.iter().zip(&mut at).for_each(|(weight, at)| *at = weight[b]);
            at
        };
        let (limited, free): (Vec<usize>, Vec<usize>) = (0..parts).partition(|b| may_be_bounded(&weights_at(*b), level, fourth_degree));
        let reflectance = band.array(if air.parted { "reflectance_spectrum" } else { "reflectance" });
        let shares = air.parted.then(|| band.array("emission_share"));
        let undivided = Axis {
            name: "planck_temperature".to_owned(),
            nodes: vec![1.0],
            rule: "linear".to_owned(),
            period: 0.0,
            clamps: true,
            dark_below: None,
        };
        let planck = Grid::new(shares.map_or(&undivided, |array| &array.axes[0]));
        let axes = &self.surface.array("temperature").axes;
        let (altitude, azimuth, slope) = (Grid::new(&axes[1]), Grid::new(&axes[2]), Grid::new(&axes[3]));
        let blackbody = band.array("blackbody_radiance");
        let kelvin = Grid::new(&blackbody.axes[0]);
        let material = |m: usize, code: f64| -> axis::Result<Material> {
            let rho: Vec<f64> = reflectance.values[m * parts..(m + 1) * parts].iter().map(|value| f64::from(*value)).collect();
            let mut sky = [0.0; BASES];
            for b in &free {
                weights_at(*b).iter().zip(&mut sky).for_each(|(weight, sky)| *sky += rho[*b] * weight);
            }
            let direct = rho.iter().zip(&beam).map(|(rho, beam)| rho * beam).sum::<f64>().max(0.0);
            let of = |name: &str| f64::from(band.array(name).values[m]);
            let mut emission = vec![[0.0; 4]; PANELS * planck.nodes.len()];
            for n in 0..planck.nodes.len() {
                let share = |b: usize| shares.map_or(1.0, |array| f64::from(array.values[n % array.axes[0].nodes.len() * parts + b]));
                let weight: Vec<f64> = rho.iter().enumerate().map(|(b, rho)| (1.0 - rho) * share(b)).collect();
                for (panel, cubic) in cubics(&weight, &extinction).into_iter().enumerate() {
                    emission[panel * planck.nodes.len() + n] = cubic;
                }
            }
            let known = axes[0].nodes.contains(&code);
            let temperature = if known { Some(temperatures(self, code, view.time, [&altitude, &azimuth, &slope])?) } else { None };
            let fraction = of("specular_fraction");
            let (diffuse, specular) = (direct * (1.0 - fraction), direct * fraction * of("normalisation"));
            let bounded = limited.iter().map(|b| rho[*b]).collect();
            Ok(Material { emission, sky, bounded, diffuse, specular, shininess: of("shininess"), temperature })
        };
        let codes = &reflectance.axes[0].nodes;
        let materials = codes.iter().enumerate().map(|(m, code)| material(m, *code)).collect::<axis::Result<_>>()?;
        let (sine, cosine) = view.source_elevation.to_radians().sin_cos();
        Ok(Frame {
            extinction: 5.5 / air.value("beta_star", &centre)?,
            path_ratio: self.path_ratio(&centre)?,
            source_heading: view.source_heading,
            to_source: [cosine, sine],
            centre: (view.centre_elevation, view.centre_heading),
            materials,
            by_code: codes.iter().enumerate().map(|(m, code)| (*code as i32, m)).collect(),
            blackbody: (0..kelvin.nodes.len()).map(|k| f64::from(blackbody.values[k % blackbody.values.len()])).collect(),
            altitude,
            azimuth,
            slope,
            kelvin,
            planck,
            level,
            fourth_degree,
            bounded: limited.iter().map(|b| weights_at(*b)).collect(),
        })
    }
}

impl Frame {
    /// Radiances of pixels [W m^-2 sr^-1], in one thread; of a range of 0 to 4095 km.
    ///
    /// # Errors
    /// A value outside the tables, or lists of unlike lengths.
    pub fn radiance(&self, pixels: &Pixels, radiance: &mut [f64]) -> Result<()> {
        let count = radiance.len();
        let mut lengths = vec![pixels.material.len(), pixels.range.len(), pixels.surface_altitude.len(), pixels.surface_azimuth.len(), pixels.surface_slope.len()];
        lengths.extend(pixels.lines.map_or(vec![], |(elevations, headings)| vec![elevations.len(), headings.len()]));
        lengths.extend(pixels.temperature.map(<[f64]>::len));
        if lengths.iter().any(|length| *length != count) {
            return of_value(Err(format!("lists of {lengths:?} values for {count} pixels; allowed: as many").into()));
        }
        for (i, value) in radiance.iter_mut().enumerate() {
            *value = of_value(self.pixel(pixels, i))?;
        }
        Ok(())
    }

    fn kelvin_of(&self, material: &Material, pixels: &Pixels, i: usize) -> axis::Result<f64> {
        if let Some(given) = pixels.temperature {
            return Ok(given[i]);
        }
        let at = |grid: &Grid, value: f64| grid.locate(value).ok_or_else(|| grid.refusal(i, value));
        let (a, u) = at(&self.altitude, pixels.surface_altitude[i])?;
        let (b, v) = at(&self.azimuth, pixels.surface_azimuth[i])?;
        let (c, w) = at(&self.slope, pixels.surface_slope[i])?;
        let values = material.temperature.as_ref().ok_or_else(|| format!("pixel {i}: the surface file lacks the material"))?;
        let (row, column) = (self.slope.nodes.len(), self.slope.nodes.len() * self.azimuth.nodes.len());
        let along = |from: usize| values[from] + w * (values[from + 1] - values[from]);
        let across = |from: usize| along(from) + v * (along(from + row) - along(from));
        let from = a * column + b * row + c;
        Ok(across(from) + u * (across(from + column) - across(from)))
    }

    fn pixel(&self, pixels: &Pixels, i: usize) -> axis::Result<f64> {
        let (code, range) = (pixels.material[i], pixels.range[i]);
        let found = self.by_code.binary_search_by_key(&code, |(each, _)| *each);
        let found = found.map_err(|_| format!("pixel {i}: material: found {code}; allowed: a code of the file"))?;
        let material = &self.materials[self.by_code[found].1];
        if !(0.0..=FARTHEST).contains(&range) {
            return Err(format!("pixel {i}: range: found {range}; allowed: 0 to {FARTHEST}").into());
        }
        let kelvin = self.kelvin_of(material, pixels, i)?;
        let (lower, weight) = self.kelvin.locate(kelvin).ok_or_else(|| self.kelvin.refusal(i, kelvin))?;
        let blackbody = self.blackbody[lower] + weight * (self.blackbody[lower + 1] - self.blackbody[lower]);
        let (node, warm) = self.planck.locate(kelvin).ok_or_else(|| self.planck.refusal(i, kelvin))?;
        let (panel, t) = panel_of(range);
        let at = panel * self.planck.nodes.len() + node;
        let cubic = |[a, b, c, d]: [f64; 4]| a + t * (b + t * (c + t * d));
        let emitted = cubic(material.emission[at]) * (1.0 - warm) + cubic(material.emission[at + 1]) * warm;
        let normal = normal(pixels.surface_slope[i], pixels.surface_azimuth[i] - self.source_heading);
        let sky = self.sky(material, normal);
        let [ahead, up] = self.to_source;
        let incidence = (ahead * normal[0] + up * normal[2]).max(0.0);
        let beam = if incidence > 0.0 { incidence * material.diffuse + self.glint(material, pixels, i, normal) } else { 0.0 };
        let tau = (-self.extinction * range).exp();
        Ok(blackbody * emitted + (sky + beam) * tau + self.path_ratio * (1.0 - tau))
    }

    /// Reflected light of the sky.
    fn sky(&self, material: &Material, normal: [f64; 3]) -> f64 {
        let mut at = [1.0; BASES];
        if !self.level {
            at = bases(self.fourth_degree, normal);
        }
        let used = if self.level { 1 } else if self.fourth_degree { BASES } else { 7 };
        let sum = |weights: &[f64; BASES]| (0..used).map(|k| at[k] * weights[k]).sum::<f64>();
        let limited: f64 = self.bounded.iter().zip(&material.bounded).map(|(weights, rho)| rho * sum(weights).max(0.0)).sum();
        (sum(&material.sky) + limited).max(0.0)
    }

    /// The beam in the direction of the observer, (35).
    fn glint(&self, material: &Material, pixels: &Pixels, i: usize, normal: [f64; 3]) -> f64 {
        if material.specular == 0.0 {
            return 0.0;
        }
        let (elevation, heading) = pixels.lines.map_or(self.centre, |(elevations, headings)| (elevations[i], headings[i]));
        let ((rise, level), (y, x)) = (elevation.to_radians().sin_cos(), (heading - self.source_heading).to_radians().sin_cos());
        let between = [self.to_source[0] - level * x, -level * y, self.to_source[1] - rise];
        let length = between.iter().map(|part| part * part).sum::<f64>().sqrt();
        let along: f64 = between.iter().zip(normal).map(|(part, normal)| part * normal).sum();
        let chi = if length > 0.0 { (along / length).clamp(0.0, 1.0) } else { 0.0 };
        chi.powf(material.shininess) * material.specular
    }
}
