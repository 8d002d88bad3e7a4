//! A texture, from whose texels materials are read; each level is read and checked whole when the first pixel asks for it.

use crate::error::{Error, Result};
use crate::source::{number, Source};
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
    pub fn open(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        Ok(Texture { path: path.to_owned(), levels: HashMap::from([(0, read(path, 0)?)]) })
    }

    /// Codes and shares of the materials at a point, in texels of level 0 from the top left corner of the image. A level is
    /// read with the first request.
    ///
    /// # Errors
    /// The point lies outside the image or has no material; the texture has no such level.
    pub fn mixture(&mut self, point: [f64; 2], level: u32) -> Result<Vec<(i32, f64)>> {
        let (level, texel) = self.texel(point, level)?;
        let first = COMPONENTS * texel;
        if level.codes[first] == 0 {
            return Err(Error::value(format!("texel: [{}, {}] has no material", point[0], point[1])));
        }
        let parts = (first..first + COMPONENTS).filter(|k| level.weights[*k] > 0);
        Ok(parts.map(|k| (i32::from(level.codes[k]), f64::from(level.weights[k]) / f64::from(TOTAL))).collect())
    }

    /// Share of the texel at that point in the shade of its photograph; 0 where the file has no such layer. A level is read
    /// with the first request.
    ///
    /// # Errors
    /// The point lies outside the image; the texture has no such level.
    pub fn shade(&mut self, point: [f64; 2], level: u32) -> Result<f64> {
        let (level, texel) = self.texel(point, level)?;
        Ok(level.shade.as_ref().map_or(0.0, |shade| f64::from(shade[texel]) / f64::from(SHADE_TOTAL)))
    }

    /// The level of a number, which is read where it was not yet, and the number of the texel at a point in it.
    fn texel(&mut self, [across, down]: [f64; 2], number: u32) -> Result<(&Level, usize)> {
        let (height, width) = (self.levels[&0].height, self.levels[&0].width);
        if !(0.0..=width as f64).contains(&across) || !(0.0..=height as f64).contains(&down) {
            return Err(Error::value(format!("texel: found [{across}, {down}]; allowed: 0 to {width}, 0 to {height}")));
        }
        if !self.levels.contains_key(&number) {
            self.levels.insert(number, read(&self.path, number)?);
        }
        let level = &self.levels[&number];
        let place = |at: f64, whole: usize, count: usize| ((at * count as f64 / whole as f64) as usize).min(count - 1);
        let (row, column) = (place(down, height, level.height), place(across, width, level.width));
        Ok((level, row * level.width + column))
    }
}

fn read(path: &Path, number: u32) -> Result<Level> {
    let opened = Source::open(path, &["tmm"]).and_then(|(source, _)| read_level(&source, number));
    opened.map_err(|error| Error::file(format!("{}: {error}", path.display())))
}

fn read_level(source: &Source, level: u32) -> Result<Level> {
    let place = |name: &str| format!("levels/{level}/{name}");
    let (known, _) = source.values::<u16>("materials/material", 1)?;
    if known[0] < 1 || known.windows(2).any(|pair| pair[1] <= pair[0]) {
        return Err(Error::file("the codes of its materials do not ascend from 1"));
    }
    let (code, shape) = source.values::<u16>(&place("code"), 2)?;
    let (codes, mixed) = source.values::<u16>(&place("mix_code"), 3)?;
    let (weights, weighted) = source.values::<u16>(&place("mix_weight"), 3)?;
    let unfit = || Error::file(format!("the arrays of level {level} do not fit each other"));
    if mixed != [shape[0], shape[1], COMPONENTS] || weighted != mixed {
        return Err(unfit());
    }
    check_total(source, &place("mix_weight"), f64::from(TOTAL))?;
    for ((first, codes), weights) in code.iter().zip(codes.chunks(COMPONENTS)).zip(weights.chunks(COMPONENTS)) {
        let unknown = |code: &u16| *code != 0 && known.binary_search(code).is_err();
        if codes[0] != *first || codes.iter().any(unknown) {
            return Err(Error::file(format!("level {level} has codes that are not those of its materials")));
        }
        if *first != 0 && codes.iter().zip(weights).any(|(code, weight)| *code == 0 && *weight > 0) {
            return Err(Error::file(format!("level {level} gives weight to no material")));
        }
        if weights.iter().map(|weight| u32::from(*weight)).sum::<u32>() != TOTAL {
            return Err(Error::file(format!("the weights of level {level} do not sum to {TOTAL}")));
        }
    }
    // A file has this layer on all levels or on none.
    if !source.has("levels/0/shade") {
        return Ok(Level { height: shape[0], width: shape[1], codes, weights, shade: None });
    }
    let (shade, size) = source.values::<u8>(&place("shade"), 2)?;
    check_total(source, &place("shade"), f64::from(SHADE_TOTAL))?;
    if size != shape {
        return Err(unfit());
    }
    Ok(Level { height: shape[0], width: shape[1], codes, weights, shade: Some(shade) })
}

fn check_total(source: &Source, name: &str, total: f64) -> Result<()> {
    let array = source.file.dataset(name)?;
    if number(&array, "total", 0.0)? == total {
        return Ok(());
    }
    Err(Error::file(format!("'{name}' does not state its total, {total}")))
}
