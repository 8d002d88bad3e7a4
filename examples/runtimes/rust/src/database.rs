//! A database: the arrays of a file, handed to the C library, which checks their values.

use crate::error::{check, Error, ErrorKind, Result};
use crate::kernel::*;
use crate::source::{number, numbers, text, Source};
use hdf5::types::{FloatSize, IntSize, TypeDescriptor};
use std::ffi::{c_void, CStr};
use std::path::Path;

/// Memory as the C library wants it: aligned to 64 bytes, zero at first.
pub struct Memory(Vec<Line>);

#[derive(Clone)]
#[repr(C, align(64))]
struct Line([u8; 64]);

impl Memory {
    pub fn of(bytes: usize) -> Self {
        Memory(vec![Line([0; 64]); bytes.div_ceil(64)])
    }

    pub fn read(&self) -> *const c_void {
        self.0.as_ptr().cast()
    }

    pub fn write(&mut self) -> *mut c_void {
        self.0.as_mut_ptr().cast()
    }
}

/// A database with the arrays that it reads.
pub struct Database {
    memory: Memory,
    _arrays: Vec<Vec<f32>>,
    _axes: Vec<Vec<f64>>,
    /// The type of the file.
    pub filetype: String,
    /// Codes and names of the materials, where the file names any.
    pub materials: Vec<(i32, String)>,
    /// Name of the ground's material; empty where the file names none.
    pub ground: String,
}

fn name_of(name: *const std::ffi::c_char) -> Option<&'static str> {
    if name.is_null() { None } else { unsafe { CStr::from_ptr(name) }.to_str().ok() }
}

/// Name of an array of a kind of database by its number, as the format lists them.
pub fn array_name(kind: i32, array: i32) -> Option<&'static str> {
    name_of(unsafe { skyshine_array_name(kind, array) })
}

fn axis_names(kind: i32, array: i32) -> Vec<&'static str> {
    (0..).map_while(|axis| name_of(unsafe { skyshine_axis_name(kind, array, axis) })).collect()
}

/// Number of an array by its name.
pub fn array_number(kind: i32, name: &str) -> i32 {
    (0..).find(|array| array_name(kind, *array).is_none_or(|each| each == name)).unwrap_or(0)
}

impl Database {
    /// Read a file of a kind. Values beyond the axes in `clamp` are read at the nearest node.
    pub fn open(path: &Path, kind: i32, clamp: &[&str]) -> Result<Self> {
        let filetypes: &[&str] = match kind {
            SURFACE => &["htt"],
            BAND => &["band"],
            _ => &["atmq", "lunar_atmq"],
        };
        let opened = Source::open(path, filetypes).and_then(|(source, filetype)| {
            let mut database = Database {
                memory: Memory::of(unsafe { skyshine_database_size() }),
                _arrays: Vec::new(),
                _axes: Vec::new(),
                filetype,
                materials: Vec::new(),
                ground: text(&source.file, "ground_material")?,
            };
            unsafe { skyshine_database_begin(database.memory.write(), kind) };
            database.fill(&source, kind, clamp)?;
            Ok(database)
        });
        opened.map_err(|error| Error::file(format!("{}: {error}", path.display())))
    }

    pub fn read(&self) -> *const c_void {
        self.memory.read()
    }

    /// Whether the file has an array.
    pub fn has(&self, array: &CStr) -> bool {
        unsafe { skyshine_has(self.read(), array.as_ptr()) != 0 }
    }

    /// Say what the code of the ground's material is in a file of temperatures, where this file names one.
    pub fn set_ground(&mut self, materials: &[(i32, String)]) {
        if !self.ground.is_empty() {
            let code = materials.iter().find(|(_, name)| *name == self.ground).map_or(0, |(code, _)| *code);
            unsafe { skyshine_set_number(self.memory.write(), GROUND_CODE, f64::from(code)) };
        }
    }

    /// Refuse what no file of the format has.
    pub fn check(&self) -> Result<()> {
        let mut failure = Failure::none();
        check(unsafe { skyshine_database_check(self.read(), &mut failure) }, &failure, ErrorKind::File, false)
    }

    fn fill(&mut self, source: &Source, kind: i32, clamp: &[&str]) -> Result<()> {
        for array in 0.. {
            let Some(name) = array_name(kind, array) else { break };
            if source.has(name) {
                self.fill_array(source, kind, array, name, clamp)?;
            }
        }
        for (k, entry) in NUMBERS.iter().enumerate() {
            let Some((name, count)) = entry else { continue };
            for (step, value) in numbers(&source.file, name, *count)?.into_iter().flatten().enumerate() {
                unsafe { skyshine_set_number(self.memory.write(), (k + step) as i32, value) };
            }
        }
        for (axis, place) in CLAMPS {
            let clamps = f64::from(u8::from(clamp.contains(axis)));
            unsafe { skyshine_set_number(self.memory.write(), *place, clamps) };
        }
        if kind == BAND || (kind == SURFACE && source.has("material_name")) {
            self.materials = source.materials()?;
        }
        if kind == SURFACE {
            self.set_ground(&self.materials.clone());
        }
        Ok(())
    }

    fn fill_array(&mut self, source: &Source, kind: i32, array: i32, name: &str, clamp: &[&str]) -> Result<()> {
        let axes = axis_names(kind, array);
        let (dataset, shape) = source.dataset(name, &TypeDescriptor::Float(FloatSize::U4), axes.len())?;
        source.check_scales(&dataset, name, &axes)?;
        for (k, axis) in axes.iter().enumerate() {
            self.fill_axis(source, (array, k as i32), axis, clamp)?;
            let count = self._axes[self._axes.len() - 1].len();
            if count != shape[k] {
                return Err(Error::file(format!("'{name}' has {} values along '{axis}', which has {count} nodes", shape[k])));
            }
        }
        let mut values = dataset.read_raw::<f32>()?;
        if dataset.attr("differences").is_ok() {
            // The file has the differences along some axes.
            for name in text(&dataset, "differences")?.split(' ') {
                if let Some(k) = axes.iter().position(|axis| *axis == name) {
                    let stride: usize = shape[k + 1..].iter().product();
                    for i in 0..values.len() {
                        if i % (stride * shape[k]) >= stride {
                            values[i] += values[i - stride];
                        }
                    }
                }
            }
        }
        self._arrays.push(values);
        let values = self._arrays[self._arrays.len() - 1].as_ptr();
        unsafe { skyshine_set_array(self.memory.write(), array, values) };
        Ok(())
    }

    fn fill_axis(&mut self, source: &Source, (array, axis): (i32, i32), name: &str, clamp: &[&str]) -> Result<()> {
        let stored = source.file.dataset(name).map_err(|_| Error::file(format!("lacks '{name}'")))?;
        let interpolation = text(&stored, "interpolation")?;
        let Some(rule) = RULES.iter().position(|rule| *rule == interpolation) else {
            return Err(Error::file(format!("the axis '{name}' has interpolation '{interpolation}'; allowed: {}", RULES.join(", "))));
        };
        // Codes are integers of four bytes, other nodes floating-point numbers of eight.
        let codes = interpolation == "exact";
        let kind = if codes { TypeDescriptor::Integer(IntSize::U4) } else { TypeDescriptor::Float(FloatSize::U8) };
        let nodes = source.dataset(name, &kind, 1)?.0.read_raw::<f64>()?;
        let policy = if stored.attr("out_of_range").is_ok() { text(&stored, "out_of_range")? } else { "error".into() };
        if policy != "error" && policy != "clamp" {
            return Err(Error::file(format!("the axis '{name}' has out_of_range '{policy}'; allowed: error, clamp")));
        }
        let clamps = policy == "clamp" || clamp.contains(&name.strip_prefix("sky_").unwrap_or(name));
        let (period, dark_below) = (number(&stored, "period", 0.0)?, number(&stored, "dark_below", f64::NAN)?);
        self._axes.push(nodes);
        let nodes = &self._axes[self._axes.len() - 1];
        unsafe {
            let memory = self.memory.write();
            skyshine_set_axis(memory, array, axis, nodes.as_ptr(), nodes.len(), rule as i32, period, dark_below, clamps.into());
        }
        Ok(())
    }
}
