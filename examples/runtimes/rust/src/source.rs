//! Arrays and attributes of a file, each checked before it is believed.

use crate::axis::{Axis, Result};
use crate::layouts::{rules_of, Layout, CLAMPED};
use hdf5::types::{FixedAscii, FixedUnicode, FloatSize, IntSize, Reference, TypeDescriptor, VarLenArray, VarLenAscii, VarLenUnicode};
use hdf5::{Dataset, File, LinkType, ObjectReference1, ReferencedObject};
use std::collections::HashMap;

/// Deflate packs at most 1032 bytes into one: a file that claims more does not hold it.
pub const PACKING: u64 = 1100;
pub const SMALL: u64 = 1 << 20;
const LONGEST: usize = 64;

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

/// So many numbers of an attribute in one dimension, or one without; NaN where it is not that.
pub fn numbers(place: &hdf5::Location, name: &str, count: usize) -> Result<Vec<f64>> {
    let wrong = vec![f64::NAN; count];
    let Ok(attribute) = place.attr(name) else { return Ok(wrong) };
    let kind = attribute.dtype()?.to_descriptor()?;
    let is_number = matches!(kind, TypeDescriptor::Integer(_) | TypeDescriptor::Unsigned(_) | TypeDescriptor::Float(_));
    let shape: &[usize] = if count > 1 { &[count] } else { &[] };
    let fits = is_number && !attribute.space()?.is_null() && attribute.shape() == shape;
    Ok(if fits { attribute.read_raw::<f64>()? } else { wrong })
}

/// A number attribute: 0 where there is none, NaN where it is not one number.
pub fn number(place: &hdf5::Location, name: &str) -> Result<f64> {
    let Ok(attribute) = place.attr(name) else { return Ok(0.0) };
    let kind = attribute.dtype()?.to_descriptor()?;
    let is_number = matches!(kind, TypeDescriptor::Integer(_) | TypeDescriptor::Unsigned(_) | TypeDescriptor::Float(_));
    Ok(if is_number && is_one_value(&attribute) { attribute.read_raw::<f64>()?[0] } else { f64::NAN })
}

pub struct Array {
    pub axes: Vec<Axis>,
    pub values: Vec<f32>,
}

/// A file that is being read, with the kinds of the links in its root and the most bytes that an array can take.
pub struct Source<'a> {
    pub file: File,
    pub links: HashMap<String, LinkType>,
    pub bytes: u64,
    pub clamped: &'a [String],
    /// An array may have axes of its own, named after it: not in format 3.
    pub own_axes: bool,
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

    /// Whether values beyond an axis are read at its ends, by the format or by the scene.
    fn is_clamped(&self, axis: &str) -> bool {
        let asked = axis.strip_prefix("sky_").unwrap_or(axis);
        CLAMPED.contains(&axis) || self.clamped.iter().any(|each| each == asked)
    }

    /// The quantity's own axis where the file has one, else the one that quantities share; with its name in the file.
    fn axis(&self, quantity: &str, name: &str) -> Result<(String, Axis)> {
        let own = format!("{quantity}_{name}");
        let stored = if self.own_axes && self.links.contains_key(&own) { own } else { name.to_owned() };
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
            clamps: policy == "clamp" || self.is_clamped(name),
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

    pub fn array(&self, (quantity, names, least, most): &Layout) -> Result<Array> {
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
    pub fn names(&self, codes: &[f64]) -> Result<HashMap<String, f64>> {
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
