//! Temperatures in the shade, beside a wall or under other heat: the formulas of schemas/formats/htt-1.md.

use crate::axis::Result;
use crate::database::Database;
use crate::film::{Film, FilmStep};

const STEPS: usize = 288;
const CORRECTIONS: usize = 8;
const DAY: f64 = 24.0;
const STEP: f64 = DAY / STEPS as f64;
/// K below its melting point in which a surface counts as melting.
const MELTING_RANGE: f64 = 0.01;
const STEFAN_BOLTZMANN: f64 = 5.670374419e-8;

/// Values of the axes of `temperature`, by name.
pub type Face<'a> = [(&'a str, f64); 5];

/// What keeps sunlight and sky from a face.
#[derive(Clone, Debug)]
pub struct Surroundings {
    /// Hours from first to last, over midnight where the first is later; they do not overlap.
    pub shade: Vec<[f64; 2]>,
    /// Open share of the sky.
    pub sky_view: f64,
    /// Temperature of the wall that hides the rest [K]; none: that of the air.
    pub facing: Option<f64>,
    /// Of that wall.
    pub facing_emissivity: f64,
}

/// Of masonry, concrete and foliage in the thermal infrared.
pub const WALL_EMISSIVITY: f64 = 0.95;

impl Default for Surroundings {
    fn default() -> Self {
        Surroundings { shade: Vec::new(), sky_view: 1.0, facing: None, facing_emissivity: WALL_EMISSIVITY }
    }
}

fn hour(step: usize) -> f64 {
    step as f64 * STEP
}

fn of(face: &Face, name: &str) -> f64 {
    face.iter().find(|(axis, _)| *axis == name).map_or(f64::NAN, |(_, value)| *value)
}

/// Step means with their sums, for integrals to any hour.
struct Sums<'a> {
    values: &'a [f64],
    totals: Vec<f64>,
}

impl<'a> Sums<'a> {
    fn new(values: &'a [f64]) -> Self {
        let mut totals = vec![0.0];
        for value in values {
            totals.push(totals[totals.len() - 1] + value);
        }
        Sums { values, totals }
    }

    /// Integral from the beginning of the first step to an hour of any day.
    fn integral(&self, hour: f64) -> f64 {
        let count = self.values.len();
        let steps = count as f64;
        let mut place = hour * steps / DAY + 0.5;
        let day = (place / steps).floor();
        place -= day * steps;
        let before = (place.floor().max(0.0) as usize).min(count - 1);
        (self.totals[before] + (place - before as f64) * self.values[before] + day * self.totals[count]) * DAY / steps
    }
}

/// Means over the steps of the day of values that are means over other equal steps.
fn step_means(values: &[f64]) -> Vec<f64> {
    if values.len() == STEPS {
        return values.to_vec();
    }
    let sums = Sums::new(values);
    let half = STEP / 2.0;
    (0..STEPS).map(|k| (sums.integral(hour(k) + half) - sums.integral(hour(k) - half)) / STEP).collect()
}

/// Cell of the nodes in which a point lies, or that next to it.
fn cell(nodes: &[f64], at: f64) -> usize {
    let mut lower = 0;
    while lower + 2 < nodes.len() && nodes[lower + 1] <= at {
        lower += 1;
    }
    lower
}

/// Value at a point, linear between nodes and beyond their ends.
fn read(nodes: &[f64], values: &[f64], at: f64) -> f64 {
    let lower = cell(nodes, at);
    values[lower] + (at - nodes[lower]) * (values[lower + 1] - values[lower]) / (nodes[lower + 1] - nodes[lower])
}

/// Slope of what `read` reads.
fn rise(nodes: &[f64], values: &[f64], at: f64) -> f64 {
    let lower = cell(nodes, at);
    (values[lower + 1] - values[lower]) / (nodes[lower + 1] - nodes[lower])
}

/// Point at which ascending values are a wanted one.
fn inverse(nodes: &[f64], values: &[f64], wanted: f64) -> f64 {
    let below = values.iter().filter(|value| **value <= wanted).count();
    let lower = below.saturating_sub(1).min(nodes.len() - 2);
    let rise = values[lower + 1] - values[lower];
    let share = if rise > 0.0 { (wanted - values[lower]) / rise } else { 0.0 };
    nodes[lower] + share * (nodes[lower + 1] - nodes[lower])
}

/// What the response of a face is at one step of the day.
struct Step {
    slope: f64,
    start: f64,
    base: f64,
    loss: Vec<f64>,
    kernel: Vec<f64>,
}

/// The kernel applied to a history of heat.
fn linear(steps: &[Step], edges: &[f64], heat: &[f64]) -> Vec<f64> {
    let sums = Sums::new(heat);
    let at = |k: usize| edges.iter().map(|edge| sums.integral(hour(k) - edge)).collect::<Vec<f64>>();
    let moved = |k: usize, ends: &[f64]| {
        let cells = steps[k].kernel.iter().enumerate();
        cells.map(|(l, share)| share * (ends[l] - ends[l + 1]) / (edges[l + 1] - edges[l])).sum()
    };
    (0..STEPS).map(|k| moved(k, &at(k))).collect()
}

/// Change of temperature at each step of the day by a change of absorbed heat at each step.
fn change(surface: &Database, face: &Face, given: &[f64]) -> Result<Vec<f64>> {
    let material = ("material", of(face, "material"));
    let altitude = ("response_altitude", surface.within("response_kernel", 1, of(face, "altitude")));
    let slope = ("response_slope", surface.within("response_kernel", 2, of(face, "slope")));
    let (lags, offsets) = (surface.nodes("response_kernel", 4), surface.nodes("heat_loss_excess", 4));
    if offsets.len() < 2 {
        return Err("the response has too few nodes".into());
    }
    let mut edges = lags.to_vec();
    edges.push(lags[0] + DAY);
    let (mut steps, mut lowest, mut highest) = (Vec::new(), 0f64, 0f64);
    let limit = surface.value("highest_temperature", face)?;
    let mut absorbed = given.to_vec();
    for (k, heat) in absorbed.iter_mut().enumerate() {
        let place = [material, altitude, slope, ("response_hour", hour(k))];
        let tangent = surface.value("heat_loss_slope", &place)?;
        let start = if surface.holds_hour(hour(k)) {
            let now = face.map(|(name, value)| (name, if name == "time" { hour(k) } else { value }));
            let sunlit = surface.value("temperature", &now)?;
            if sunlit >= limit - MELTING_RANGE {
                *heat = (*heat + surface.value("melting_heat", &place)?).min(0.0);
            }
            sunlit - surface.value("response_temperature", &place)?
        } else {
            0.0
        };
        let with = |name, value| [place[0], place[1], place[2], place[3], (name, value)];
        let excess = |offset: &f64| Ok(tangent * offset + surface.value("heat_loss_excess", &with("temperature_offset", *offset))?);
        let loss = offsets.iter().map(excess).collect::<Result<Vec<f64>>>()?;
        let kernel = lags.iter().map(|lag| surface.value("response_kernel", &with("lag", *lag))).collect::<Result<Vec<f64>>>()?;
        let base = read(offsets, &loss, start);
        let balanced = inverse(offsets, &loss, base + *heat) - start;
        if *heat < 0.0 {
            lowest = lowest.min(balanced);
        }
        if *heat > 0.0 {
            highest = highest.max(balanced);
        }
        steps.push(Step { slope: tangent, start, base, loss, kernel });
    }
    if let Some(film) = film_of(surface, face, &[material, altitude, slope], offsets)? {
        return Ok(wet_change(&film, &steps, &edges, offsets, &absorbed));
    }
    let bounded = |value: f64| value.max(lowest).min(highest);
    let mut moved: Vec<f64> = linear(&steps, &edges, &absorbed).into_iter().map(bounded).collect();
    for _ in 0..CORRECTIONS {
        let excess = |k: usize| read(offsets, &steps[k].loss, steps[k].start + moved[k]) - steps[k].base - steps[k].slope * moved[k];
        let beyond: Vec<f64> = (0..STEPS).map(excess).collect();
        let heat: Vec<f64> = absorbed.iter().zip(&beyond).map(|(heat, excess)| heat - excess).collect();
        let target = linear(&steps, &edges, &heat);
        for k in 0..STEPS {
            let steeper = if moved[k] != 0.0 { beyond[k] / (steps[k].slope * moved[k]) } else { 0.0 };
            moved[k] = bounded(moved[k] + (target[k] - moved[k]) / (1.0 + steeper.max(0.0)));
        }
    }
    Ok(moved)
}

/// The film on a face at its column of the response; none where no water stays.
fn film_of(surface: &Database, face: &Face, column: &[(&str, f64); 3], offsets: &[f64]) -> Result<Option<Film>> {
    if !surface.holds("film_heat_loss") {
        return Ok(None);
    }
    let capacity = surface.value("film_capacity", face)?;
    if capacity.is_nan() || capacity <= 0.0 {
        return Ok(None);
    }
    let upward = of(face, "slope").to_radians().cos().max(0.0);
    let one = |k: usize| -> Result<FilmStep> {
        let place = [column[0], column[1], column[2], ("response_hour", hour(k))];
        let at = |name, offset: &f64| surface.value(name, &[place[0], place[1], place[2], place[3], ("temperature_offset", *offset)]);
        let table = |name| offsets.iter().map(|offset| at(name, offset)).collect::<Result<Vec<f64>>>();
        Ok(FilmStep {
            loss: table("film_heat_loss")?,
            evaporation: table("film_evaporation")?,
            sunlight: surface.value("film_sunlight", &place)?,
            dry_sunlight: surface.value("absorbed_sunlight", &place)?,
            rain: upward * surface.value("rain", &[("forcing_time", hour(k))])?,
        })
    };
    let before = if surface.holds("film_before") { Some(surface.value("film_before", column)?) } else { None };
    Ok(Some(Film { steps: (0..STEPS).map(one).collect::<Result<Vec<FilmStep>>>()?, capacity, before }))
}

/// `change` of a face with a film.
fn wet_change(film: &Film, steps: &[Step], edges: &[f64], offsets: &[f64], absorbed: &[f64]) -> Vec<f64> {
    let evaporation = |moved: &[f64]| -> Vec<f64> {
        (0..STEPS).map(|k| read(offsets, &film.steps[k].evaporation, steps[k].start + moved[k])).collect()
    };
    let mut moved = vec![0.0; STEPS];
    let open = film.in_the_open(&evaporation(&moved));
    let wet = |k: usize| open.covered[k] * (read(offsets, &film.steps[k].loss, steps[k].start) - film.steps[k].sunlight);
    let base: Vec<f64> = (0..STEPS).map(|k| steps[k].base + wet(k)).collect();
    let (mut covered, mut start) = (open.covered.clone(), open.start);
    for pass in 0..=CORRECTIONS {
        let (mut lowest, mut highest) = (0f64, 0f64);
        let (mut wholes, mut heat) = (Vec::new(), Vec::new());
        for (k, step) in steps.iter().enumerate() {
            let share = covered[k];
            let whole: Vec<f64> = step.loss.iter().zip(&film.steps[k].loss).map(|(dry, more)| dry + share * more).collect();
            let given = absorbed[k] + share * film.light(k, absorbed[k]);
            let surplus = given - (read(offsets, &whole, step.start) - base[k]);
            let balanced = inverse(offsets, &whole, base[k] + given) - step.start;
            if surplus < 0.0 {
                lowest = lowest.min(balanced);
            }
            if surplus > 0.0 {
                highest = highest.max(balanced);
            }
            heat.push(given - (read(offsets, &whole, step.start + moved[k]) - base[k] - step.slope * moved[k]));
            wholes.push(whole);
        }
        let target = linear(steps, edges, if pass == 0 { absorbed } else { &heat });
        for (k, step) in steps.iter().enumerate() {
            let steeper = if pass == 0 { 1.0 } else { (rise(offsets, &wholes[k], step.start + moved[k]) / step.slope).max(1.0) };
            moved[k] = (moved[k] + (target[k] - moved[k]) / steeper).max(lowest).min(highest);
        }
        let day = film.march(&evaporation(&moved), start);
        start = film.next_start(&open, &day);
        covered = day.covered;
    }
    moved
}

/// Temperature of a face that absorbs other heat than the table's: means over equal steps of the day, W m^-2.
pub fn temperature_under(surface: &Database, face: &Face, absorbed: &[f64]) -> Result<f64> {
    surface.need("response_kernel")?;
    if absorbed.is_empty() || !absorbed.iter().all(|heat| heat.is_finite()) {
        return Err("absorbed_change must be a list of finite numbers".into());
    }
    let sunlit = surface.value("temperature", face)?;
    let moved = change(surface, face, &step_means(absorbed))?;
    let place = of(face, "time").rem_euclid(DAY) / STEP;
    let (before, weight) = (place.floor() as usize % STEPS, place - place.floor());
    let limit = surface.value("highest_temperature", face)?.max(sunlit);
    Ok((sunlit + moved[before] * (1.0 - weight) + moved[(before + 1) % STEPS] * weight).min(limit))
}

impl Surroundings {
    /// Share of a step of the day in the shade, of intervals that do not overlap.
    fn shaded_share(&self, hour: f64) -> f64 {
        let (first, last) = (hour - STEP / 2.0, hour + STEP / 2.0);
        let mut covered = 0.0;
        for [begin, end] in &self.shade {
            let end = if end < begin { end + DAY } else { *end };
            for turn in [-DAY, 0.0, DAY] {
                covered += (last.min(end + turn) - first.max(begin + turn)).max(0.0);
            }
        }
        (covered / STEP).min(1.0)
    }
}

/// Temperature of the air over surfaces at an altitude and a time.
pub fn air_temperature(surface: &Database, altitude: f64, time: f64) -> Result<f64> {
    surface.need("response_kernel")?;
    surface.value("air_temperature", &[("altitude", surface.within("air_temperature", 0, altitude)), ("forcing_time", time)])
}

/// Change of the heat that a face absorbs at each step of the day, by shade and a wall.
pub fn absorbed_change(surface: &Database, face: &Face, around: &Surroundings) -> Result<Vec<f64>> {
    surface.need("response_kernel")?;
    let given = around.shade.iter().flatten().chain([&around.sky_view, &around.facing_emissivity]).chain(around.facing.as_ref());
    if !given.into_iter().all(|value| value.is_finite()) {
        return Err("surroundings must be finite numbers".into());
    }
    let absorbs = surface.value("solar_absorptance", face)?;
    let emits = surface.value("thermal_emissivity", face)?;
    let altitude = surface.within("air_temperature", 0, of(face, "altitude"));
    let (sine, cosine) = of(face, "slope").to_radians().sin_cos();
    let (view, hidden) = (0.5 * (1.0 + cosine), 1.0 - around.sky_view);
    let one = |k: usize| -> Result<f64> {
        let place = [("altitude", altitude), ("forcing_time", hour(k))];
        let at = |name: &str| surface.value(name, &place);
        let up = at("solar_elevation")?.to_radians();
        let turn = (at("solar_azimuth")? - of(face, "azimuth")).to_radians();
        let (normal, level, sky) = (at("direct_normal_irradiance")?, at("diffuse_irradiance")?, at("sky_irradiance")?);
        let incidence = (cosine * up.sin() + sine * up.cos() * turn.cos()).max(0.0);
        let index = normal / at("extraterrestrial_irradiance")?;
        let ratio = incidence / up.sin().max(1f64.to_radians().sin());
        let diffuse = level * ((1.0 - index) * view + index * ratio);
        let spread = diffuse.min(view * level);
        let beam = normal * incidence + diffuse - spread;
        let air = STEFAN_BOLTZMANN * at("air_temperature")?.powi(4);
        let emitted = around.facing.map_or(air, |facing| STEFAN_BOLTZMANN * facing.powi(4));
        let wall = around.facing_emissivity * emitted + (1.0 - around.facing_emissivity) * (sky + air) / 2.0;
        Ok(emits * hidden * view * (wall - sky) - absorbs * (around.shaded_share(hour(k)) * beam + hidden * spread))
    };
    (0..STEPS).map(one).collect()
}
