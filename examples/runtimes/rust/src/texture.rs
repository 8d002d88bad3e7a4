//! A texture, from whose texels materials are read; each level is read and checked whole when the first pixel asks for it.

use crate::axis::Result;
use crate::error::{of_file, of_value};
use crate::source::{number, text, PACKING, SMALL};
use hdf5::types::{IntSize, TypeDescriptor};
use hdf5::{Dataset, File, Group, IterationOrder, LinkType};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// What the weights of a texel sum to.
const TOTAL: u32 = 65535;
/// Of a texel that lies in the shade as a whole.
const SHADE_TOTAL: u8 = 255;
const COMPONENTS: usize = 3;

/// One mip level: three codes and three weights a texel, and its share in the shade where the file has that.
struct Level {
    height: usize,
    width: usize,
    codes: Vec<u16>,
    weights: Vec<u16>,
    shade: Option<Vec<u8>>,
}

/// A texture, from whose texels materials are read.
pub struct Texture {
    path: PathBuf,
    levels: HashMap<u32, Level>,
}

impl Texture {
    /// Open a .tmm file and read its level 0.
    ///
    /// # Errors
    /// The file is not a readable .tmm file of format 1.
    pub fn open(path: impl AsRef<Path>) -> crate::Result<Self> {
        let path = path.as_ref();
        let levels = HashMap::from([(0, of_file(read(path, 0))?)]);
        Ok(Texture { path: path.to_owned(), levels })
    }

    /// Codes and shares of the materials at a point, in texels of level 0 from the top left corner of the image. A level is
    /// read with the first request.
    ///
    /// # Errors
    /// The point lies outside the image or has no material; the texture has no such level.
    pub fn mixture(&mut self, point: [f64; 2], level: u32) -> crate::Result<Vec<(i32, f64)>> {
        self.need(point, level)?;
        of_value(self.mixture_at(point, level))
    }

    /// Share of the texel at that point in the shade of its photograph; 0 where the file has no such layer. A level is read
    /// with the first request.
    ///
    /// # Errors
    /// The point lies outside the image; the texture has no such level.
    pub fn shade(&mut self, point: [f64; 2], level: u32) -> crate::Result<f64> {
        self.need(point, level)?;
        let (level, texel) = of_value(self.texel(point, level))?;
        Ok(level.shade.as_ref().map_or(0.0, |shade| f64::from(shade[texel]) / f64::from(SHADE_TOTAL)))
    }

    /// Read a level where it was not yet.
    fn need(&mut self, point: [f64; 2], level: u32) -> crate::Result<()> {
        if !self.levels.contains_key(&level) && point.iter().all(|value| *value >= 0.0) {
            self.levels.insert(level, of_file(read(&self.path, level))?);
        }
        Ok(())
    }

    /// The level of a number, and the number of the texel at a point in it.
    fn texel(&self, [across, down]: [f64; 2], number: u32) -> Result<(&Level, usize)> {
        let (height, width) = (self.levels[&0].height, self.levels[&0].width);
        if !(0.0..=width as f64).contains(&across) || !(0.0..=height as f64).contains(&down) {
            return Err(format!("texel: found [{across}, {down}]; allowed: 0 to {width}, 0 to {height}").into());
        }
        let level = self.levels.get(&number).ok_or_else(|| format!("level: found {number}; allowed: a level of the texture"))?;
        let place = |at: f64, whole: usize, count: usize| ((at * count as f64 / whole as f64) as usize).min(count - 1);
        let (row, column) = (place(down, height, level.height), place(across, width, level.width));
        Ok((level, row * level.width + column))
    }

    fn mixture_at(&self, point: [f64; 2], number: u32) -> Result<Vec<(i32, f64)>> {
        let (level, texel) = self.texel(point, number)?;
        let first = COMPONENTS * texel;
        if level.codes[first] == 0 {
            return Err(format!("texel: [{}, {}] has no material", point[0], point[1]).into());
        }
        let parts = (first..first + COMPONENTS).filter(|k| level.weights[*k] > 0);
        Ok(parts.map(|k| (i32::from(level.codes[k]), f64::from(level.weights[k]) / f64::from(TOTAL))).collect())
    }
}

fn read(path: &Path, number: u32) -> Result<Level> {
    let shown = path.display();
    let unreadable = || format!("{shown}: is not a readable HDF5 file");
    let on_disk = std::fs::metadata(path).ok().filter(|found| found.is_file()).ok_or_else(unreadable)?;
    let file = File::open(path).map_err(|_| unreadable())?;
    read_level(&file, PACKING * on_disk.len() + SMALL, number).map_err(|error| {
        let words = error.to_string().replace(char::is_control, "?");
        let damaged = if error.is::<hdf5::Error>() { "is damaged: " } else { "" };
        format!("{shown}: {damaged}{}", words.chars().take(200).collect::<String>()).into()
    })
}

fn read_level(file: &File, most: u64, level: u32) -> Result<Level> {
    let (filetype, version) = (text(file, "filetype")?, text(file, "format_version")?);
    if filetype != "tmm" || !version.starts_with("1.") {
        return Err(format!("holds '{filetype}' {version}; allowed: tmm 1.x").into());
    }
    let plane = |name: &str, size: IntSize, rank: usize| plane(file, name, size, rank, most);
    let (_, known) = plane("materials/material", IntSize::U2, 1)?;
    let known = known.read_raw::<u16>()?;
    if known[0] < 1 || known.windows(2).any(|pair| pair[1] <= pair[0]) {
        return Err("the codes of its materials do not ascend from 1".into());
    }
    let (shape, code) = plane(&format!("levels/{level}/code"), IntSize::U2, 2)?;
    let (mixed, mix_code) = plane(&format!("levels/{level}/mix_code"), IntSize::U2, 3)?;
    let (weighted, mix_weight) = plane(&format!("levels/{level}/mix_weight"), IntSize::U2, 3)?;
    let unfit = || format!("the arrays of level {level} do not fit each other");
    if mixed != [shape[0], shape[1], COMPONENTS] || weighted != mixed {
        return Err(unfit().into());
    }
    if number(&mix_weight, "total")? != f64::from(TOTAL) {
        return Err(format!("the weights of level {level} do not state their total, {TOTAL}").into());
    }
    let (code, codes, weights) = (code.read_raw::<u16>()?, mix_code.read_raw::<u16>()?, mix_weight.read_raw::<u16>()?);
    for ((first, codes), weights) in code.iter().zip(codes.chunks(COMPONENTS)).zip(weights.chunks(COMPONENTS)) {
        let unknown = |code: &u16| *code != 0 && known.binary_search(code).is_err();
        if codes[0] != *first || codes.iter().any(unknown) {
            return Err(format!("level {level} has codes that are not those of its materials").into());
        }
        if *first != 0 && codes.iter().zip(weights).any(|(code, weight)| *code == 0 && *weight > 0) {
            return Err(format!("level {level} gives weight to no material").into());
        }
        if weights.iter().map(|weight| u32::from(*weight)).sum::<u32>() != TOTAL {
            return Err(format!("the weights of level {level} do not sum to {TOTAL}").into());
        }
    }
    let mut shade = None;
    // A file has this layer on all levels or on none.
    if file.group("levels")?.group("0")?.link_exists("shade") {
        let (size, array) = plane(&format!("levels/{level}/shade"), IntSize::U1, 2)?;
        if size != shape {
            return Err(unfit().into());
        }
        if number(&array, "total")? != f64::from(SHADE_TOTAL) {
            return Err(format!("the shade of level {level} does not state its total, {SHADE_TOTAL}").into());
        }
        shade = Some(array.read_raw::<u8>()?);
    }
    Ok(Level { height: shape[0], width: shape[1], codes, weights, shade })
}

/// Shape and array of unsigned integers of a size, of this very file.
fn plane(file: &File, name: &str, size: IntSize, rank: usize, most: u64) -> Result<(Vec<usize>, Dataset)> {
    let parts: Vec<&str> = name.split('/').collect();
    let mut place: Group = file.group("/")?;
    for (k, part) in parts.iter().enumerate() {
        let links = place.links(hdf5::IndexType::Name, IterationOrder::Native)?;
        match links.into_iter().find(|(each, _)| each == part) {
            None => return Err(format!("lacks '{name}'").into()),
            Some((_, link)) if link.link_type == LinkType::Hard => {}
            Some(_) => return Err(format!("'{name}' is a link to somewhere else").into()),
        }
        if k + 1 < parts.len() {
            place = place.group(part).map_err(|_| format!("lacks '{name}'"))?;
        }
    }
    let array = place.dataset(parts[parts.len() - 1]).map_err(|_| format!("'{name}' is not an array"))?;
    let how = array.dcpl()?;
    if how.get_layout()? == hdf5::dataset::Layout::Virtual || !how.get_external()?.is_empty() {
        return Err(format!("'{name}' is kept in another file").into());
    }
    if array.dtype()?.to_descriptor().ok() != Some(TypeDescriptor::Unsigned(size)) {
        return Err(format!("'{name}' has values of another type").into());
    }
    let shape = array.get_shape()?;
    if shape.len() != rank || array.space()?.is_null() || shape.contains(&0) {
        return Err(format!("'{name}' has the shape {shape:?}; allowed: {rank} axes, none empty").into());
    }
    let bytes = shape.iter().try_fold(size as u64, |product, length| product.checked_mul(*length as u64));
    if bytes.is_none_or(|bytes| bytes > most) {
        return Err(format!("'{name}' claims more bytes than the file can hold").into());
    }
    Ok((shape, array))
}
