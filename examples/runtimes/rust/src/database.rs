//! A database, read and checked whole before the first pixel: files come from anywhere, and nothing in one is believed before.

use crate::axis::{Axis, Place, Result};
use crate::channels::Channels;
use crate::layouts::*;
use crate::source::{number, numbers, text, Array, Source, PACKING, SMALL};
use hdf5::{File, IterationOrder};
use std::collections::HashMap;
use std::path::Path;

pub struct Database {
    arrays: HashMap<&'static str, Array>,
    codes: HashMap<String, f64>,
    /// Emissivity, temperature and emitted radiance of the ground, where the file has harmonics.
    pub ground: Option<[f64; 3]>,
    /// Name of the ground's material, where the file names one.
    pub ground_material: Option<String>,
    /// Of the ground that the file states, where it does.
    pub ground_temperature: Option<f64>,
    /// Whether its source is the Moon.
    pub lunar: bool,
    /// Whether light is read at each wavelength of the band.
    pub parted: bool,
    channels: Option<Channels>,
}

/// A list of arrays that stand together, where the file has any of them.
fn whole(source: &Source, part: &'static [Layout]) -> &'static [Layout] {
    if part.iter().any(|(name, ..)| source.links.contains_key(*name)) { part } else { &[] }
}

/// The shares of the wavelengths sum to 1.
fn check_shares(arrays: &HashMap<&str, Array>) -> Result<()> {
    for (name, array) in SHARES.iter().filter_map(|name| arrays.get(name).map(|array| (name, array))) {
        for row in array.values.chunks_exact(array.axes[1].nodes.len()) {
            let sum: f64 = row.iter().map(|share| f64::from(*share)).sum();
            if (sum - 1.0).abs() > WEIGHT_ROUNDING {
                return Err(format!("a row of '{name}' sums to {sum}; allowed: 1").into());
            }
        }
    }
    Ok(())
}

/// What a file with harmonics of the light and of the ground states of the ground: emissivity, temperature, radiance.
fn stated_ground(source: &Source, light: &Array, glow: &Array) -> Result<[f64; 3]> {
    let count = |array: &Array| array.axes[array.axes.len() - 1].nodes.len();
    if (count(light) == 6) != (count(glow) == 3) {
        return Err(format!("'{LIGHT}' and '{GLOW}' are of different harmonics").into());
    }
    let mut stated = [0.0; 3];
    for (name, value) in GROUND.iter().zip(&mut stated) {
        *value = if source.file.attr(name).is_ok() { number(&source.file, name)? } else { f64::NAN };
        if !value.is_finite() || *value < 0.0 {
            return Err(format!("does not state '{name}'").into());
        }
    }
    Ok(stated)
}

/// Name of the ground's material and the temperature of the ground, where the file says them.
fn ground_before_walls(source: &Source) -> (Option<String>, Option<f64>) {
    let name = text(&source.file, "ground_material").unwrap_or_default();
    let stated = source.file.attr("ground_temperature").ok().and_then(|_| number(&source.file, "ground_temperature").ok());
    (Some(name).filter(|name| !name.is_empty()), stated.filter(|kelvin| kelvin.is_finite() && *kelvin >= 0.0))
}

impl Database {
    pub fn open(path: &Path, filetypes: &[&str], clamped: &[String]) -> Result<Self> {
        let shown = path.display();
        let unreadable = || format!("{shown}: is not a readable HDF5 file");
        let on_disk = std::fs::metadata(path).ok().filter(|found| found.is_file()).ok_or_else(unreadable)?;
        let file = File::open(path).map_err(|_| unreadable())?;
        Self::read(file, PACKING * on_disk.len() + SMALL, filetypes, clamped).map_err(|error| {
            let words = error.to_string().replace(char::is_control, "?");
            let damaged = if error.is::<hdf5::Error>() { "is damaged: " } else { "" };
            format!("{shown}: {damaged}{}", words.chars().take(200).collect::<String>()).into()
        })
    }

    fn read(file: File, bytes: u64, filetypes: &[&str], clamped: &[String]) -> Result<Self> {
        let (filetype, version) = (text(&file, "filetype")?, text(&file, "format_version")?);
        let (layouts, majors): (_, &[&str]) = match filetypes[0] {
            "htt" => (SURFACE, &["1."]),
            "band" => (BAND, &["1."]),
            _ => (ATMOSPHERE, &["2.", "3."]),
        };
        if !filetypes.contains(&filetype.as_str()) || !majors.iter().any(|major| version.starts_with(major)) {
            let allowed: Vec<String> = majors.iter().map(|major| format!("{major}x")).collect();
            return Err(format!("holds '{filetype}' {version}; allowed: {} {}", filetypes.join(" or "), allowed.join(" or ")).into());
        }
        let links = file.links(hdf5::IndexType::Name, IterationOrder::Native)?;
        let links = links.into_iter().map(|(name, link)| (name, link.link_type)).collect();
        let in_channels = layouts[0].0 == ATMOSPHERE[0].0 && version.starts_with("3.");
        let source = Source { file, links, bytes, clamped, own_axes: !in_channels };
        if in_channels {
            return Self::read_channels(&source, filetype == "lunar_atmq");
        }
        let mut arrays = HashMap::new();
        let has = |part: &'static [Layout]| if source.links.contains_key(part[0].0) { part } else { &[] };
        let (surface, air) = (filetype == "htt", layouts[0].0 == ATMOSPHERE[0].0);
        let tilted = if air { has(TILTED) } else { &[] };
        let night = if air { has(NIGHT) } else { &[] };
        let night = if tilted.is_empty() && !night.is_empty() { night.split_at(2).0 } else { night };
        let parts = if surface { [has(SHADE), has(FILM), has(FILM_BEFORE), has(TRACKS)] } else { [&[] as &[Layout]; 4] };
        let spectra = if filetype == "band" { whole(&source, SPECTRA) } else { &[] };
        for layout in [layouts, tilted, night, spectra].into_iter().chain(parts).flatten() {
            arrays.insert(layout.0, source.array(layout)?);
        }
        check_shares(&arrays)?;
        if !night.is_empty() {
            let mut lit = WITHOUT_SOURCE.iter().filter_map(|(name, _)| arrays.get(name).map(|array: &Array| (name, array)));
            if let Some((name, _)) = lit.find(|(_, array)| array.axes[3].dark_below.is_none()) {
                return Err(format!("the source elevations of '{name}' do not state dark_below").into());
            }
        }
        let ground = if tilted.is_empty() { None } else { Some(stated_ground(&source, &arrays[LIGHT], &arrays[GLOW])?) };
        let codes = match arrays.get("reflectance") {
            Some(array) => source.names(&array.axes[0].nodes)?,
            None => HashMap::new(),
        };
        let (ground_material, ground_temperature) = ground_before_walls(&source);
        let lunar = filetype == "lunar_atmq";
        Ok(Database { arrays, codes, ground, ground_material, ground_temperature, lunar, parted: false, channels: None })
    }

    /// An atmosphere of format 3.
    fn read_channels(source: &Source, lunar: bool) -> Result<Self> {
        let layout = text(&source.file, "layout")?;
        if layout != "channels" {
            return Err(format!("has the layout '{layout}'; allowed: channels").into());
        }
        let mut stated = HashMap::new();
        for (name, count, least, most) in STATED {
            let values = numbers(&source.file, name, *count)?;
            if !values.iter().all(|value| (least..=most).contains(&value)) || values[0] > values[count - 1] {
                return Err(format!("does not state '{name}', in {least} to {most} and ascending").into());
            }
            stated.insert(*name, values);
        }
        let harmonics = whole(source, CHANNEL_HARMONICS);
        let mut arrays = HashMap::new();
        for layout in [CHANNELS, harmonics, whole(source, CHANNEL_BENDING), whole(source, CHANNEL_SHARES)].into_iter().flatten() {
            arrays.insert(layout.0, source.array(layout)?);
        }
        check_shares(&arrays)?;
        let sum: f64 = arrays["channel_weight"].values.iter().map(|weight| f64::from(*weight)).sum();
        if (sum - 1.0).abs() > WEIGHT_ROUNDING {
            return Err(format!("'channel_weight' sums to {sum}; allowed: 1").into());
        }
        let dark_below = arrays["source_factor"].axes[1].dark_below;
        let dark_below = dark_below.ok_or("the source elevations of 'source_factor' do not state dark_below")?;
        let stated_by = |_: &Layout| stated_ground(source, &arrays["scattered_harmonics"], &arrays["ground_harmonics"]);
        let ground = harmonics.first().map(stated_by).transpose()?;
        let channels = Some(Channels::new(&stated, dark_below, source.clamped));
        let (ground_material, ground_temperature) = ground_before_walls(source);
        Ok(Database { arrays, codes: HashMap::new(), ground, ground_material, ground_temperature, lunar, parted: false, channels })
    }

    /// Wavelengths of the band at which the file parts light; none where it does not.
    fn wavelengths(&self) -> &[f64] {
        let array = SHARES.iter().find_map(|name| self.arrays.get(name));
        array.map_or(&[], |array| &array.axes[1].nodes)
    }

    /// Read the light of this atmosphere at each wavelength, where it and the file of the band hold what that takes; they
    /// are then of one band, whose file stands at `path`.
    pub fn part_light(&mut self, band: &Database, path: &Path) -> Result<()> {
        let (ours, theirs) = (self.wavelengths(), band.wavelengths());
        if ours.is_empty() || theirs.is_empty() {
            return Ok(());
        }
        let near = |(ours, theirs): (&f64, &f64)| (ours - theirs).abs() <= WAVELENGTH_ROUNDING * theirs.abs();
        if ours.len() != theirs.len() || !ours.iter().zip(theirs).all(near) {
            let span = |nodes: &[f64]| format!("{} from {} to {} um", nodes.len(), nodes[0], nodes[nodes.len() - 1]);
            let words = format!("has the wavelengths {}; allowed: those of the air, {}", span(theirs), span(ours));
            return Err(format!("{}: {words}", path.display()).into());
        }
        self.parted = true;
        Ok(())
    }

    /// Light on surfaces at each wavelength; one number for the whole band where light is not parted.
    pub fn light(&self, quantity: &str, place: &[(&str, f64)]) -> Result<Vec<f64>> {
        match &self.channels {
            Some(channels) if self.parted => channels.light(self, quantity, place),
            _ => Ok(vec![self.value(quantity, place)?]),
        }
    }

    /// Extinction per km of emitted light over the range of the place, as (8) and (9) have it; of the band where light is
    /// not parted.
    pub fn extinction(&self, place: &[(&str, f64)]) -> Result<Vec<f64>> {
        match &self.channels {
            Some(channels) if self.parted => channels.extinction(self, place),
            _ => Ok(vec![5.5 / self.value("beta_star", place)?]),
        }
    }

    /// A quantity of this file of a band at each of its wavelengths.
    pub fn spectrum(&self, quantity: &str, place: (&str, f64)) -> Result<Vec<f64>> {
        self.wavelengths().iter().map(|node| self.interpolated(quantity, &[place, ("band_wavelength", *node)])).collect()
    }

    /// Nodes of the last axis of a quantity: the codes of harmonics.
    pub fn last_nodes(&self, quantity: &str) -> &[f64] {
        let stored = if self.channels.is_some() { Channels::stored(quantity) } else { quantity };
        let axes = &self.arrays[stored].axes;
        &axes[axes.len() - 1].nodes
    }

    /// A quantity at a place; below the lowest elevation of the source, its light fades into what the air emits.
    pub fn value(&self, quantity: &str, place: &[(&str, f64)]) -> Result<f64> {
        if let Some(channels) = &self.channels {
            return channels.value(self, quantity, place);
        }
        let entry = WITHOUT_SOURCE.iter().find(|(name, _)| *name == quantity);
        let (Some((_, emitted)), true) = (entry, self.arrays.contains_key(NIGHT[0].0)) else {
            return self.interpolated(quantity, place);
        };
        let axis = &self.arrays[quantity].axes[3];
        let (lowest, dark) = (axis.nodes[0], axis.dark_below.unwrap_or(f64::NAN));
        let height = place.iter().find(|(name, _)| *name == axis.name).map_or(f64::NAN, |(_, value)| *value);
        let night = height.is_finite() && height < lowest && (height <= dark || lowest <= CIVIL_TWILIGHT);
        if !night {
            return self.interpolated(quantity, place);
        }
        let share = if height > dark { (height - dark) / (lowest - dark) } else { 0.0 };
        let lit: Vec<(&str, f64)> =
            place.iter().map(|(name, value)| (*name, if *name == axis.name { lowest } else { *value })).collect();
        let light = share * self.interpolated(quantity, &lit)?;
        Ok(light + emitted.map_or(Ok(0.0), |name| self.interpolated(name, place))? * (1.0 - share))
    }

    /// Whether the file holds an array.
    pub fn holds(&self, array: &str) -> bool {
        self.arrays.contains_key(array)
    }

    /// An array that the file holds.
    pub fn array(&self, name: &str) -> &Array {
        &self.arrays[name]
    }

    /// Linear interpolation in every axis: the weighted sum over the corners of one cell.
    pub fn interpolated(&self, quantity: &str, place: &[(&str, f64)]) -> Result<f64> {
        let located = self.located(quantity, 0, place)?;
        Ok(self.in_cell(quantity, 0, &located))
    }

    /// Values of all parts, which the first axis counts.
    pub fn parts(&self, quantity: &str, place: &[(&str, f64)]) -> Result<Vec<f64>> {
        let located = self.located(quantity, 1, place)?;
        Ok((0..self.arrays[quantity].axes[0].nodes.len()).map(|part| self.in_cell(quantity, part, &located)).collect())
    }

    /// Cells on the axes behind the first ones, with the number of nodes.
    fn located(&self, quantity: &str, first: usize, place: &[(&str, f64)]) -> Result<Vec<(Place, usize)>> {
        let locate = |axis: &Axis| {
            let given = place.iter().find(|(name, _)| *name == axis.name);
            let (_, value) = given.ok_or_else(|| format!("'{quantity}' needs the axis '{}'", axis.name))?;
            Ok((axis.locate(*value)?, axis.nodes.len()))
        };
        self.arrays[quantity].axes[first..].iter().map(locate).collect()
    }

    /// The weighted sum over the corners of a cell of one part.
    fn in_cell(&self, quantity: &str, part: usize, located: &[(Place, usize)]) -> f64 {
        let mut total = 0.0;
        for corner in 0..1usize << located.len() {
            let (mut share, mut index) = (1.0, part);
            for (k, (at, size)) in located.iter().enumerate() {
                let up = corner >> k & 1 == 1;
                share *= if up { at.weight } else { 1.0 - at.weight };
                index = index * size + if up { at.upper } else { at.lower };
            }
            if share != 0.0 {
                total += share * f64::from(self.arrays[quantity].values[index]);
            }
        }
        total
    }

    /// Nodes of an axis of an array, by its number.
    pub fn nodes(&self, array: &str, axis: usize) -> &[f64] {
        &self.arrays[array].axes[axis].nodes
    }

    /// The value, or the end of that axis that it is beyond.
    pub fn within(&self, array: &str, axis: usize, value: f64) -> f64 {
        let nodes = self.nodes(array, axis);
        value.max(nodes[0]).min(nodes[nodes.len() - 1])
    }

    /// Whether the temperatures hold an hour of the day.
    pub fn holds_hour(&self, hour: f64) -> bool {
        let time = &self.arrays["temperature"].axes[4];
        let (first, last) = (time.nodes[0], time.nodes[time.nodes.len() - 1]);
        time.rule == "linear_periodic" || (hour - first).rem_euclid(time.period) <= last - first
    }

    /// Refuse a file that lacks the arrays for shade.
    pub fn need(&self, array: &str) -> Result<()> {
        let missing = || "the surface file holds no response to shade".into();
        self.arrays.contains_key(array).then_some(()).ok_or_else(missing)
    }

    /// Codes and names of the materials, by ascending code.
    pub fn materials(&self) -> Vec<(i32, String)> {
        let mut materials: Vec<(i32, String)> = self.codes.iter().map(|(name, code)| (*code as i32, name.clone())).collect();
        materials.sort_unstable();
        materials
    }
}
