//! A database, read and checked whole before the first pixel: files come from anywhere, and nothing in one is believed before.

use hdf5::types::{FixedAscii, FixedUnicode, FloatSize, IntSize, Reference, TypeDescriptor, VarLenArray, VarLenAscii, VarLenUnicode};
use hdf5::{Dataset, File, IterationOrder, LinkType, ObjectReference1, ReferencedObject};
use std::collections::HashMap;
use std::path::Path;

pub type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// What a file must hold: axes, least and largest value of each array.
type Layout = (&'static str, &'static [&'static str], f32, f32);
const PATH: &[&str] = &["range", "altitude", "elevation", "source_elevation", "source_azimuth"];
const SURFACE: &[Layout] = &[("temperature", &["material", "altitude", "azimuth", "slope", "time"], 1.0, 1e4)];
const RESPONSE: &[&str] = &["material", "response_altitude", "response_slope", "response_hour", "lag"];
const EXCESS: &[&str] = &["material", "response_altitude", "response_slope", "response_hour", "temperature_offset"];
const OVERHEAD: &[&str] = &["altitude", "forcing_time"];
/// What an .htt that holds the first of them must hold, to shade surfaces.
const SHADE: &[Layout] = &[
    ("response_kernel", RESPONSE, f32::MIN, f32::MAX),
    ("response_temperature", RESPONSE.split_at(4).0, 0.0, 1e4),
    ("heat_loss_slope", RESPONSE.split_at(4).0, 1e-6, f32::MAX),
    ("heat_loss_excess", EXCESS, f32::MIN, f32::MAX),
    ("solar_absorptance", &["material"], 0.0, 1.0),
    ("thermal_emissivity", &["material"], 0.0, 1.0),
    ("melting_heat", RESPONSE.split_at(4).0, 0.0, f32::MAX),
    ("highest_temperature", &["material"], 1.0, 1e4),
    ("direct_normal_irradiance", OVERHEAD, 0.0, f32::MAX),
    ("diffuse_irradiance", OVERHEAD, 0.0, f32::MAX),
    ("sky_irradiance", OVERHEAD, 0.0, f32::MAX),
    ("air_temperature", OVERHEAD, 1.0, 1e4),
    ("solar_elevation", &["forcing_time"], -90.0, 90.0),
    ("solar_azimuth", &["forcing_time"], -360.0, 360.0),
    ("extraterrestrial_irradiance", &["forcing_time"], 1e-6, f32::MAX),
];
/// Of an .htt that holds the first of them: where Sun and Moon stand.
const TRACKS: &[Layout] = &[
    ("sun_elevation", &["track_time"], -90.0, 90.0),
    ("sun_azimuth", &["track_time"], -1080.0, 1080.0),
    ("sun_distance", &["track_time"], 0.9, 1.1),
    ("moon_elevation", &["track_time"], -90.0, 90.0),
    ("moon_azimuth", &["track_time"], -1080.0, 1080.0),
    ("moon_distance", &["track_time"], 3e5, 4.5e5),
    ("moon_phase_angle", &["track_time"], 0.0, 180.0),
    ("moon_illuminated_fraction", &["track_time"], 0.0, 1.0),
];
const BAND: &[Layout] = &[
    ("blackbody_radiance", &["temperature"], 0.0, f32::MAX),
    ("reflectance", &["material"], 0.0, 1.0),
    ("specular_fraction", &["material"], 0.0, 1.0),
    ("shininess", &["material"], 0.0, f32::MAX),
    ("normalisation", &["material"], 0.0, f32::MAX),
];
const ATMOSPHERE: &[Layout] = &[
    ("beta_star", PATH.split_at(3).0, 1e-12, f32::MAX),
    ("path_radiance_ratio", PATH, 0.0, f32::MAX),
    ("ambient_radiance", PATH.split_at(4).0, 0.0, f32::MAX),
    ("direct_radiance", PATH.split_at(4).0, 0.0, f32::MAX),
];
/// Of an .atmq file that has them: coefficients of the light around faces of any direction.
pub const LIGHT: &str = "ambient_radiance_harmonics";
pub const GLOW: &str = "ground_radiance_harmonics";
const TILTED: &[Layout] = &[
    (LIGHT, &["range", "altitude", "elevation", "source_elevation", "harmonic"], -f32::MAX, f32::MAX),
    (GLOW, &["range", "altitude", "elevation", "ground_temperature", "zonal_harmonic"], -f32::MAX, f32::MAX),
];
/// Of an .atmq that holds the first of them: its quantities without the source; the last beside harmonics alone.
const NIGHT: &[Layout] = &[
    ("thermal_path_radiance_ratio", PATH.split_at(3).0, 0.0, f32::MAX),
    ("thermal_ambient_radiance", PATH.split_at(3).0, 0.0, f32::MAX),
    ("thermal_radiance_harmonics", &["range", "altitude", "elevation", "harmonic"], -f32::MAX, f32::MAX),
];
/// What each quantity that depends on the source equals without it; direct light nothing.
const WITHOUT_SOURCE: &[(&str, Option<&str>)] = &[
    ("path_radiance_ratio", Some("thermal_path_radiance_ratio")),
    ("ambient_radiance", Some("thermal_ambient_radiance")),
    ("direct_radiance", None),
    (LIGHT, Some("thermal_radiance_harmonics")),
];
/// Degree: a table whose lowest source elevation is above says nothing of twilight.
const CIVIL_TWILIGHT: f64 = -6.0;
/// Codes 10 l + m of the harmonics, and of those without azimuth.
pub const HARMONICS: &[f64] = &[0.0, 10.0, 11.0, 20.0, 21.0, 22.0, 40.0, 41.0, 42.0, 43.0, 44.0];
const ZONES: &[f64] = &[0.0, 10.0, 20.0, 40.0];
const GROUND: [&str; 3] = ["ground_emissivity", "ground_temperature", "ground_radiance"];
const LAST_CODE: f64 = 65535.0;
/// Deflate packs at most 1032 bytes into one: a file that claims more does not hold it.
pub const PACKING: u64 = 1100;
pub const SMALL: u64 = 1 << 20;
const LONGEST: usize = 64;

/// How the format reads an axis: rules and period.
fn rules_of(axis: &str) -> (&'static [&'static str], f64) {
    match axis {
        "material" | "harmonic" | "zonal_harmonic" => (&["exact"], 0.0),
        "azimuth" => (&["linear_periodic"], 360.0),
        "source_azimuth" => (&["linear_folded"], 360.0),
        "time" => (&["linear_periodic", "linear"], 24.0),
        "response_hour" | "forcing_time" => (&["linear_periodic"], 24.0),
        _ => (&["linear"], 0.0),
    }
}

fn is_one_value(attribute: &hdf5::Attribute) -> bool {
    attribute.size() == 1 && attribute.space().is_ok_and(|space| !space.is_null())
}

/// A text attribute; empty where there is none, or it is not one short text in UTF-8.
pub fn text(place: &hdf5::Location, name: &str) -> Result<String> {
    let Some(attribute) = place.attr(name).ok().filter(is_one_value) else { return Ok(String::new()) };
    let bytes = match attribute.dtype()?.to_descriptor()? {
        TypeDescriptor::VarLenUnicode => attribute.read_raw::<VarLenUnicode>()?[0].as_bytes().to_vec(),
        TypeDescriptor::VarLenAscii => attribute.read_raw::<VarLenAscii>()?[0].as_bytes().to_vec(),
        TypeDescriptor::FixedUnicode(size) if size <= LONGEST => attribute.read_raw::<FixedUnicode<LONGEST>>()?[0].as_bytes().to_vec(),
        TypeDescriptor::FixedAscii(size) if size <= LONGEST => attribute.read_raw::<FixedAscii<LONGEST>>()?[0].as_bytes().to_vec(),
        _ => Vec::new(),
    };
    Ok(String::from_utf8(bytes).ok().filter(|text| text.len() <= LONGEST).unwrap_or_default())
}

/// A number attribute: 0 where there is none, NaN where it is not one number.
pub fn number(place: &hdf5::Location, name: &str) -> Result<f64> {
    let Ok(attribute) = place.attr(name) else { return Ok(0.0) };
    let kind = attribute.dtype()?.to_descriptor()?;
    let is_number = matches!(kind, TypeDescriptor::Integer(_) | TypeDescriptor::Unsigned(_) | TypeDescriptor::Float(_));
    Ok(if is_number && is_one_value(&attribute) { attribute.read_raw::<f64>()?[0] } else { f64::NAN })
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
    rule: String,
    period: f64,
    clamps: bool,
    /// Of source elevations: no light of the source is left there.
    dark_below: Option<f64>,
}

impl Axis {
    /// Refuse a rule or nodes that are not as the format has them.
    fn check(&self) -> Result<()> {
        let (rules, period) = rules_of(&self.name);
        let (first, last) = (self.nodes[0], self.nodes[self.nodes.len() - 1]);
        let (folded, periodic) = (self.rule == "linear_folded", self.rule == "linear_periodic");
        if !rules.contains(&self.rule.as_str()) {
            return Err(format!("the axis '{}' has interpolation '{}'; allowed: {}", self.name, self.rule, rules.join(" or ")).into());
        }
        if let Some(dark) = self.dark_below.filter(|dark| self.name == "source_elevation" && !(-90.0..=0.0).contains(dark)) {
            return Err(format!("the axis '{}' has dark_below {dark}; allowed: -90 to 0", self.name).into());
        }
        if self.period != period {
            return Err(format!("the axis '{}' has period {}; allowed: {period}", self.name, self.period).into());
        }
        if !self.nodes.iter().all(|node| node.is_finite()) || self.nodes.windows(2).any(|pair| pair[1] <= pair[0]) {
            return Err(format!("the axis '{}' has nodes that are not ascending numbers", self.name).into());
        }
        let outside = (folded && (first < 0.0 || last > period / 2.0)) || (periodic && last >= first + period);
        if outside || (period > 0.0 && last > first + period) {
            return Err(format!("the axis '{}' has nodes beyond its period", self.name).into());
        }
        let codes = match self.name.as_str() {
            "harmonic" => Some((HARMONICS, [6, 11])),
            "zonal_harmonic" => Some((ZONES, [3, 4])),
            _ => None,
        };
        if let Some((codes, counts)) = codes {
            let known = counts.contains(&self.nodes.len()) && codes.starts_with(&self.nodes);
            return if known { Ok(()) } else { Err(format!("the axis '{}' has codes that are not those of the format", self.name).into()) };
        }
        if self.rule == "exact" && (first < 1.0 || last > LAST_CODE) {
            return Err(format!("the axis '{}' has codes beyond 1 to {LAST_CODE}", self.name).into());
        }
        Ok(())
    }

    fn locate(&self, given: f64) -> Result<Place> {
        if !given.is_finite() {
            return Err(format!("{}: found {given}; allowed: finite numbers", self.name).into());
        }
        let (mut value, first, count) = (given, self.nodes[0], self.nodes.len());
        let mut last = self.nodes[count - 1];
        match self.rule.as_str() {
            "exact" => {
                let at = self.nodes.iter().position(|node| *node == value);
                let at = at.ok_or_else(|| format!("{}: found {value}; allowed: a code of the file", self.name))?;
                return Ok(Place { lower: at, upper: at, weight: 0.0 });
            }
            "linear_periodic" => {
                last = first + self.period;
                value = first + (value - first).rem_euclid(self.period);
            }
            "linear" if self.period > 0.0 => value -= self.period * ((value - first) / self.period).floor(),
            "linear_folded" => value = ((value + self.period / 2.0).rem_euclid(self.period) - self.period / 2.0).abs(),
            _ => {}
        }
        if !self.clamps && !(first..=last).contains(&value) {
            return Err(format!("{}: found {value}; allowed: {first} to {last}", self.name).into());
        }
        value = value.clamp(first, last);
        let closed = self.rule == "linear_periodic"; // after the last node comes the first again
        let cells = if closed { count } else { count - 1 };
        let below = self.nodes.partition_point(|node| *node <= value);
        let lower = below.saturating_sub(1).min(cells.saturating_sub(1));
        let upper = if cells == 0 { lower } else { (lower + 1) % count };
        let end = if lower + 1 < count { self.nodes[lower + 1] } else { last };
        let weight = if end > self.nodes[lower] { (value - self.nodes[lower]) / (end - self.nodes[lower]) } else { 0.0 };
        Ok(Place { lower, upper, weight })
    }
}

struct Array {
    axes: Vec<Axis>,
    values: Vec<f32>,
}

/// A file that is being read, with the kinds of the links in its root and the most bytes that an array can take.
struct Source<'a> {
    file: File,
    links: HashMap<String, LinkType>,
    bytes: u64,
    clamped: &'a [String],
}

impl Source<'_> {
    /// An array of this very file, of a type and so many axes.
    fn dataset(&self, name: &str, kind: &TypeDescriptor, rank: usize) -> Result<Dataset> {
        match self.links.get(name) {
            None => return Err(format!("lacks '{name}'").into()),
            Some(LinkType::Hard) => {}
            Some(_) => return Err(format!("'{name}' is a link to somewhere else").into()),
        }
        let dataset = self.file.dataset(name).map_err(|_| format!("'{name}' is not an array"))?;
        let how = dataset.dcpl()?;
        if how.get_layout()? == hdf5::dataset::Layout::Virtual || !how.get_external()?.is_empty() {
            return Err(format!("'{name}' is kept in another file").into());
        }
        if dataset.dtype()?.to_descriptor().ok().as_ref() != Some(kind) {
            return Err(format!("'{name}' has values of another type").into());
        }
        let shape = dataset.get_shape()?;
        if shape.len() != rank || dataset.space()?.is_null() || shape.contains(&0) {
            return Err(format!("'{name}' has the shape {shape:?}; allowed: {rank} axes, none empty").into());
        }
        let bytes = shape.iter().try_fold(kind.size() as u64, |product, length| product.checked_mul(*length as u64));
        if bytes.is_none_or(|bytes| bytes > self.bytes) {
            return Err(format!("'{name}' claims more bytes than the file can hold").into());
        }
        Ok(dataset)
    }

    /// The quantity's own axis where the file has one, else the one that quantities share; with its name in the file.
    fn axis(&self, quantity: &str, name: &str) -> Result<(String, Axis)> {
        let own = format!("{quantity}_{name}");
        let stored = if self.links.contains_key(&own) { own } else { name.to_owned() };
        let codes = rules_of(name).0 == ["exact"];
        let kind = if codes { TypeDescriptor::Integer(IntSize::U4) } else { TypeDescriptor::Float(FloatSize::U8) };
        let dataset = self.dataset(&stored, &kind, 1)?;
        let policy = if dataset.attr("out_of_range").is_ok() { text(&dataset, "out_of_range")? } else { "error".into() };
        if policy != "error" && policy != "clamp" {
            return Err(format!("the axis '{stored}' has out_of_range '{policy}'; allowed: error, clamp").into());
        }
        let axis = Axis {
            name: name.to_owned(),
            nodes: dataset.read_raw::<f64>()?,
            rule: text(&dataset, "interpolation")?,
            period: number(&dataset, "period")?,
            clamps: policy == "clamp" || self.clamped.iter().any(|each| each == name),
            dark_below: if dataset.attr("dark_below").is_ok() { Some(number(&dataset, "dark_below")?) } else { None },
        };
        axis.check()?;
        Ok((stored, axis))
    }

    /// Names of the first dimension scale of each axis, by the references of DIMENSION_LIST.
    fn scales(&self, dataset: &Dataset) -> Result<Vec<String>> {
        let Ok(attribute) = dataset.attr("DIMENSION_LIST") else { return Ok(Vec::new()) };
        let kind = TypeDescriptor::VarLenArray(Box::new(TypeDescriptor::Reference(Reference::Object)));
        if attribute.dtype()?.to_descriptor().ok() != Some(kind) || attribute.size() != dataset.ndim() {
            return Ok(Vec::new());
        }
        let lists = attribute.read_raw::<VarLenArray<ObjectReference1>>()?;
        let name = |list: &VarLenArray<ObjectReference1>| match list.first().map(|each| self.file.dereference(each)) {
            Some(Ok(ReferencedObject::Dataset(scale))) => scale.name(),
            _ => String::new(),
        };
        Ok(lists.iter().map(name).collect())
    }

    fn array(&self, (quantity, names, least, most): &Layout) -> Result<Array> {
        let dataset = self.dataset(quantity, &TypeDescriptor::Float(FloatSize::U4), names.len())?;
        let (shape, scales) = (dataset.shape(), self.scales(&dataset)?);
        let mut axes = Vec::new();
        for (k, name) in names.iter().enumerate() {
            let by_angle = *name == "source_azimuth" && self.links.contains_key("scattering_angle");
            let (stored, axis) = self.axis(quantity, if by_angle { "scattering_angle" } else { name })?;
            if shape[k] != axis.nodes.len() {
                return Err(format!("'{quantity}' has {} values along '{stored}', which has {} nodes", shape[k], axis.nodes.len()).into());
            }
            if scales.get(k) != Some(&format!("/{stored}")) {
                return Err(format!("'{quantity}' has other dimension scales than its axes").into());
            }
            axes.push(axis);
        }
        let values = dataset.read_raw::<f32>()?;
        if !values.iter().all(|value| value.is_finite() && (least..=most).contains(&value)) {
            return Err(format!("'{quantity}' holds values beyond {least} to {most}").into());
        }
        Ok(Array { axes, values })
    }

    /// Codes of the materials by name.
    fn names(&self, codes: &[f64]) -> Result<HashMap<String, f64>> {
        let dataset = self.dataset("material_name", &TypeDescriptor::VarLenUnicode, 1)?;
        let stored = dataset.read_raw::<VarLenUnicode>()?;
        let names: Vec<String> = stored.iter().map(|name| std::str::from_utf8(name.as_bytes()).unwrap_or("").to_owned()).collect();
        let by_name: HashMap<String, f64> = names.iter().cloned().zip(codes.iter().copied()).collect();
        if names.len() != codes.len() || by_name.len() != codes.len() || by_name.contains_key("") {
            return Err("'material_name' does not hold a name for each code".into());
        }
        Ok(by_name)
    }
}

pub struct Database {
    arrays: HashMap<&'static str, Array>,
    codes: HashMap<String, f64>,
    /// Emissivity, temperature and emitted radiance of the ground, where the file has harmonics.
    pub ground: Option<[f64; 3]>,
    /// Whether its source is the Moon.
    pub lunar: bool,
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
        let (layouts, major) = match filetypes[0] {
            "htt" => (SURFACE, "1."),
            "band" => (BAND, "1."),
            _ => (ATMOSPHERE, "2."),
        };
        if !filetypes.contains(&filetype.as_str()) || !version.starts_with(major) {
            return Err(format!("holds '{filetype}' {version}; allowed: {} {major}x", filetypes.join(" or ")).into());
        }
        let links = file.links(hdf5::IndexType::Name, IterationOrder::Native)?;
        let links = links.into_iter().map(|(name, link)| (name, link.link_type)).collect();
        let source = Source { file, links, bytes, clamped };
        let mut arrays = HashMap::new();
        let has = |part: &'static [Layout]| if source.links.contains_key(part[0].0) { part } else { &[] };
        let (surface, air) = (filetype == "htt", layouts[0].0 == ATMOSPHERE[0].0);
        let tilted = if air { has(TILTED) } else { &[] };
        let night = if air { has(NIGHT) } else { &[] };
        let night = if tilted.is_empty() && !night.is_empty() { night.split_at(2).0 } else { night };
        let (shade, tracks) = if surface { (has(SHADE), has(TRACKS)) } else { (&[] as &[Layout], &[] as &[Layout]) };
        for layout in [layouts, shade, tracks, tilted, night].into_iter().flatten() {
            arrays.insert(layout.0, source.array(layout)?);
        }
        if !night.is_empty() {
            let lit = WITHOUT_SOURCE.iter().filter_map(|(name, _)| arrays.get(name).map(|array| (name, array)));
            for (name, _) in lit.filter(|(_, array)| array.axes[3].dark_below.is_none()) {
                return Err(format!("the source elevations of '{name}' do not state dark_below").into());
            }
        }
        let mut ground = None;
        if !tilted.is_empty() {
            if (arrays[LIGHT].axes[4].nodes.len() == 6) != (arrays[GLOW].axes[4].nodes.len() == 3) {
                return Err(format!("'{LIGHT}' and '{GLOW}' are of different harmonics").into());
            }
            let mut stated = [0.0; 3];
            for (name, value) in GROUND.iter().zip(&mut stated) {
                *value = if source.file.attr(name).is_ok() { number(&source.file, name)? } else { f64::NAN };
                if !value.is_finite() || *value < 0.0 {
                    return Err(format!("does not state '{name}'").into());
                }
            }
            ground = Some(stated);
        }
        let codes = match arrays.get("reflectance") {
            Some(array) => source.names(&array.axes[0].nodes)?,
            None => HashMap::new(),
        };
        Ok(Database { arrays, codes, ground, lunar: filetype == "lunar_atmq" })
    }

    /// Nodes of the last axis of an array.
    pub fn last_nodes(&self, quantity: &str) -> &[f64] {
        let axes = &self.arrays[quantity].axes;
        &axes[axes.len() - 1].nodes
    }

    /// A quantity at a place; below the lowest elevation of the source, its light fades into what the air emits.
    pub fn value(&self, quantity: &str, place: &[(&str, f64)]) -> Result<f64> {
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

    /// Linear interpolation in every axis: the weighted sum over the corners of one cell.
    fn interpolated(&self, quantity: &str, place: &[(&str, f64)]) -> Result<f64> {
        let array = &self.arrays[quantity];
        let mut located = Vec::new();
        for axis in &array.axes {
            let given = place.iter().find(|(name, _)| *name == axis.name);
            let (_, value) = given.ok_or_else(|| format!("'{quantity}' needs the axis '{}'", axis.name))?;
            located.push((axis.locate(*value)?, axis.nodes.len()));
        }
        let mut total = 0.0;
        for corner in 0..1usize << located.len() {
            let (mut share, mut index) = (1.0, 0);
            for (k, (at, size)) in located.iter().enumerate() {
                let up = corner >> k & 1 == 1;
                share *= if up { at.weight } else { 1.0 - at.weight };
                index = index * size + if up { at.upper } else { at.lower };
            }
            if share != 0.0 {
                total += share * f64::from(array.values[index]);
            }
        }
        Ok(total)
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

    /// Code of a material of a name.
    pub fn material(&self, name: &str) -> Result<f64> {
        let code = self.codes.get(name).copied();
        Ok(code.ok_or_else(|| format!("material: found '{name}'; allowed: a name of the file"))?)
    }
}
