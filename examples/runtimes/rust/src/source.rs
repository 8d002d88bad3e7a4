//! Arrays and attributes of a file, each checked before it is believed.

use crate::error::{Error, Result};
use crate::FORMAT;
use hdf5::types::{FixedAscii, FixedUnicode, Reference, TypeDescriptor, VarLenArray, VarLenAscii, VarLenUnicode};
use hdf5::{Dataset, File, Group, H5Type, IterationOrder, LinkType, Location, ObjectReference1, ReferencedObject};
use std::path::Path;

/// Deflate packs at most 1032 bytes into one: a file that claims more does not hold it.
const PACKING: u64 = 1100;
const SMALL: u64 = 1 << 20;
const LONGEST: usize = 64;

fn has_one_value(attribute: &hdf5::Attribute) -> bool {
    attribute.size() == 1 && attribute.space().is_ok_and(|space| !space.is_null())
}

/// A text attribute; empty where there is none, or it is not one short text in UTF-8.
pub fn text(place: &Location, name: &str) -> Result<String> {
    let Some(attribute) = place.attr(name).ok().filter(has_one_value) else { return Ok(String::new()) };
    let bytes = match attribute.dtype()?.to_descriptor()? {
        TypeDescriptor::VarLenUnicode => attribute.read_raw::<VarLenUnicode>()?[0].as_bytes().to_vec(),
        TypeDescriptor::VarLenAscii => attribute.read_raw::<VarLenAscii>()?[0].as_bytes().to_vec(),
        TypeDescriptor::FixedUnicode(size) if size <= LONGEST => attribute.read_raw::<FixedUnicode<LONGEST>>()?[0].as_bytes().to_vec(),
        TypeDescriptor::FixedAscii(size) if size <= LONGEST => attribute.read_raw::<FixedAscii<LONGEST>>()?[0].as_bytes().to_vec(),
        _ => Vec::new(),
    };
    Ok(String::from_utf8(bytes).ok().filter(|text| text.len() <= LONGEST).unwrap_or_default())
}

/// So many numbers of an attribute in one dimension, or one; none where it is absent, NaN where it is not that.
pub fn numbers(place: &Location, name: &str, count: usize) -> Result<Option<Vec<f64>>> {
    let Ok(attribute) = place.attr(name) else { return Ok(None) };
    let kind = attribute.dtype()?.to_descriptor()?;
    let is_number = matches!(kind, TypeDescriptor::Integer(_) | TypeDescriptor::Unsigned(_) | TypeDescriptor::Float(_));
    let fits = is_number && !attribute.space()?.is_null() && attribute.size() == count && attribute.ndim() <= 1;
    Ok(Some(if fits { attribute.read_raw::<f64>()? } else { vec![f64::NAN; count] }))
}

/// A number attribute: `absent` where there is none, NaN where it is not one number.
pub fn number(place: &Location, name: &str, absent: f64) -> Result<f64> {
    Ok(numbers(place, name, 1)?.map_or(absent, |values| values[0]))
}

/// A file that is being read, with the most bytes that an array of it can take.
pub struct Source {
    pub file: File,
    bytes: u64,
}

impl Source {
    /// A regular file of one of some types, of the major version of `FORMAT`.
    pub fn open(path: &Path, filetypes: &[&str]) -> Result<(Self, String)> {
        let unreadable = || Error::file("is not a readable HDF5 file");
        let on_disk = std::fs::metadata(path).ok().filter(|found| found.is_file()).ok_or_else(unreadable)?;
        let file = File::open(path).map_err(|_| unreadable())?;
        let (filetype, version) = (text(&file, "filetype")?, text(&file, "format_version")?);
        if !filetypes.contains(&filetype.as_str()) || version.split('.').next() != FORMAT.split('.').next() {
            return Err(Error::file(format!("has '{filetype}' {version}; allowed: {} in formats {}.x", filetypes.join(" or "), FORMAT.split('.').next().unwrap_or_default())));
        }
        Ok((Source { file, bytes: PACKING * on_disk.len() + SMALL }, filetype))
    }

    /// Whether the file has something of a name, a path of groups.
    pub fn has(&self, name: &str) -> bool {
        self.file.link_exists(name)
    }

    /// An array of this very file by its path, of values of a type and of so many axes, with their lengths.
    pub fn dataset(&self, path: &str, kind: &TypeDescriptor, rank: usize) -> Result<(Dataset, Vec<usize>)> {
        let (mut place, mut dataset): (Group, _) = (self.file.group("/")?, None);
        let parts: Vec<&str> = path.split('/').collect();
        for (k, part) in parts.iter().enumerate() {
            let links = place.links(hdf5::IndexType::Name, IterationOrder::Native)?;
            let link = links.into_iter().find(|(name, _)| name == part).map(|(_, link)| link.link_type);
            match link {
                None => return Err(Error::file(format!("lacks '{path}'"))),
                Some(LinkType::Hard) => {}
                Some(_) => return Err(Error::file(format!("'{path}' is a link to somewhere else"))),
            }
            if k + 1 < parts.len() {
                place = place.group(part).map_err(|_| Error::file(format!("lacks '{path}'")))?;
            } else {
                dataset = Some(place.dataset(part).map_err(|_| Error::file(format!("'{path}' is not an array")))?);
            }
        }
        let dataset = dataset.ok_or_else(|| Error::file(format!("lacks '{path}'")))?;
        let how = dataset.dcpl()?;
        if how.get_layout()? == hdf5::dataset::Layout::Virtual || !how.get_external()?.is_empty() {
            return Err(Error::file(format!("'{path}' is kept in another file")));
        }
        if dataset.dtype()?.to_descriptor().ok().as_ref() != Some(kind) {
            return Err(Error::file(format!("'{path}' has values of another type")));
        }
        let shape = dataset.get_shape()?;
        if shape.len() != rank || dataset.space()?.is_null() || shape.contains(&0) {
            return Err(Error::file(format!("'{path}' has the shape {shape:?}; allowed: {rank} axes, none empty")));
        }
        let bytes = shape.iter().try_fold(kind.size() as u64, |product, length| product.checked_mul(*length as u64));
        if bytes.is_none_or(|bytes| bytes > self.bytes) {
            return Err(Error::file(format!("'{path}' claims more bytes than the file can hold")));
        }
        Ok((dataset, shape))
    }

    /// Values of such an array, with its lengths.
    pub fn values<T: H5Type>(&self, path: &str, rank: usize) -> Result<(Vec<T>, Vec<usize>)> {
        let (dataset, shape) = self.dataset(path, &T::type_descriptor(), rank)?;
        Ok((dataset.read_raw::<T>()?, shape))
    }

    /// Refuse an array whose dimension scales, by the references of DIMENSION_LIST, do not begin with axes of these names.
    pub fn check_scales(&self, dataset: &Dataset, name: &str, axes: &[&str]) -> Result<()> {
        let wrong = || Error::file(format!("'{name}' has other dimension scales than its axes"));
        let attribute = dataset.attr("DIMENSION_LIST").map_err(|_| wrong())?;
        let kind = TypeDescriptor::VarLenArray(Box::new(TypeDescriptor::Reference(Reference::Object)));
        if attribute.dtype()?.to_descriptor().ok() != Some(kind) || attribute.size() != axes.len() {
            return Err(wrong());
        }
        for (list, axis) in attribute.read_raw::<VarLenArray<ObjectReference1>>()?.iter().zip(axes) {
            match list.first().map(|each| self.file.dereference(each)) {
                Some(Ok(ReferencedObject::Dataset(scale))) if scale.name() == format!("/{axis}") => {}
                _ => return Err(wrong()),
            }
        }
        Ok(())
    }

    /// Codes and names of the materials, by ascending code.
    pub fn materials(&self) -> Result<Vec<(i32, String)>> {
        let (codes, _) = self.values::<i32>("material", 1)?;
        let (dataset, _) = self.dataset("material_name", &TypeDescriptor::VarLenUnicode, 1)?;
        let stored = dataset.read_raw::<VarLenUnicode>()?;
        let names: Vec<String> = stored.iter().map(|name| std::str::from_utf8(name.as_bytes()).unwrap_or("").to_owned()).collect();
        let differ = names.iter().collect::<std::collections::HashSet<_>>().len() == names.len();
        if names.len() != codes.len() || !differ || names.iter().any(String::is_empty) {
            return Err(Error::file("'material_name' does not hold a name for each code"));
        }
        Ok(codes.into_iter().zip(names).collect())
    }
}
