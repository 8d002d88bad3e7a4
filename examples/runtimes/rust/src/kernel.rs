//! The C library of `mat/kernel`: what pixels.h declares.

use std::ffi::{c_char, c_void};
use std::ptr::null;

pub const SURFACE: i32 = 0;
pub const BAND: i32 = 1;
pub const AIR: i32 = 2;

/// `interpolation` of an axis, by the number of its rule.
pub const RULES: &[&str] = &["linear", "linear_periodic", "exact"];

/// Attributes of a file's root by the number that the library gives them, with how many numbers each has; None: no attribute.
pub const NUMBERS: &[Option<(&str, usize)>] = &[
    Some(("ground_emissivity", 1)),
    Some(("ground_temperature", 1)),
    Some(("ground_radiance", 1)),
    Some(("ground_albedo", 1)),
    None,
    Some(("ground_altitude_km", 1)),
    Some(("scale_height_km", 1)),
    Some(("range_km", 2)),
    None,
    Some(("altitude_km", 2)),
];
pub const GROUND_CODE: i32 = 4;
/// Axes that no array has, by the number that says whether values beyond them are read at their ends.
pub const CLAMPS: &[(&str, i32)] = &[("range", 11), ("altitude", 12), ("elevation", 13)];

/// Status of a ground that the surface file lacks.
pub const NO_GROUND: i32 = 9;

/// Steps of a day.
pub const STEPS: usize = 288;

pub const BETA_STAR: i32 = 0;
pub const PATH_RATIO: i32 = 1;
pub const DIRECT: i32 = 4;

#[repr(C)]
pub struct Failure {
    pub status: i32,
    pub kind: i32,
    pub row: usize,
    pub name: *const c_char,
    pub found: f64,
    pub least: f64,
    pub most: f64,
}

impl Failure {
    pub fn none() -> Self {
        Failure { status: 0, kind: 0, row: 0, name: null(), found: 0.0, least: 0.0, most: 0.0 }
    }
}

#[repr(C)]
pub struct Faces {
    pub material: *const i32,
    pub altitude: *const f64,
    pub azimuth: *const f64,
    pub slope: *const f64,
}

#[repr(C)]
pub struct Surroundings {
    pub shaded: *const f64,
    pub sky_view: *const f64,
    pub facing: *const f64,
    pub facing_emissivity: *const f64,
}

#[repr(C)]
pub struct Places {
    pub range: *const f64,
    pub altitude: *const f64,
    pub elevation: *const f64,
    pub source_elevation: *const f64,
    pub last: *const f64,
}

#[repr(C)]
pub struct Pixels {
    pub material: *const i32,
    pub share: *const f64,
    pub temperature: *const f64,
    pub surface_altitude: *const f64,
    pub surface_azimuth: *const f64,
    pub surface_slope: *const f64,
    pub time: *const f64,
    pub range: *const f64,
    pub line_range: *const f64,
    pub altitude: *const f64,
    pub elevation: *const f64,
    pub source_elevation: *const f64,
    pub source_azimuth: *const f64,
    pub source_heading: *const f64,
    pub normal: *const f64,
    pub to_source: *const f64,
    pub to_observer: *const f64,
    pub sight_elevation: *const f64,
    pub sight_heading: *const f64,
    pub lit: *const f64,
    pub sky_view: *const f64,
    pub wall_temperature: *const f64,
    pub shade: *const f64,
    pub shaded_sky: *const f64,
    pub shaded_temperature: *const f64,
    pub ground_material: *const i32,
    pub ground_temperature: *const f64,
}

#[repr(C)]
pub struct Terms {
    pub temperature: *mut f64,
    pub blackbody_radiance: *mut f64,
    pub beta_star: *mut f64,
    pub transmittance: *mut f64,
    pub thermal: *mut f64,
    pub path: *mut f64,
    pub skyshine: *mut f64,
    pub diffuse: *mut f64,
    pub specular: *mut f64,
    pub radiance: *mut f64,
}

extern "C" {
    pub fn skyshine_database_size() -> usize;
    pub fn skyshine_database_begin(database: *mut c_void, kind: i32);
    pub fn skyshine_array_name(kind: i32, array: i32) -> *const c_char;
    pub fn skyshine_axis_name(kind: i32, array: i32, axis: i32) -> *const c_char;
    pub fn skyshine_set_array(database: *mut c_void, array: i32, values: *const f32);
    pub fn skyshine_set_axis(
        database: *mut c_void,
        array: i32,
        axis: i32,
        nodes: *const f64,
        count: usize,
        rule: i32,
        period: f64,
        dark_below: f64,
        clamps: i32,
    );
    pub fn skyshine_set_number(database: *mut c_void, number: i32, value: f64);
    pub fn skyshine_has(database: *const c_void, array: *const c_char) -> i32;
    pub fn skyshine_database_check(database: *const c_void, failure: *mut Failure) -> i32;
    pub fn skyshine_tables_size(surface: *const c_void, band: *const c_void, air: *const c_void) -> usize;
    pub fn skyshine_tables_make(
        tables: *mut c_void,
        surface: *const c_void,
        band: *const c_void,
        air: *const c_void,
        failure: *mut Failure,
    ) -> i32;
    pub fn skyshine_scratch_size(tables: *const c_void) -> usize;
    pub fn skyshine_read(
        tables: *const c_void,
        kind: i32,
        array: i32,
        count: usize,
        at: *const f64,
        values: *mut f64,
        failure: *mut Failure,
    ) -> i32;
    pub fn skyshine_temperatures(
        tables: *const c_void,
        count: usize,
        faces: *const Faces,
        time: *const f64,
        temperature: *mut f64,
        failure: *mut Failure,
    ) -> i32;
    pub fn skyshine_absorbed(
        tables: *const c_void,
        count: usize,
        faces: *const Faces,
        around: *const Surroundings,
        each: i32,
        absorbed: *mut f64,
        scratch: *mut c_void,
        failure: *mut Failure,
    ) -> i32;
    pub fn skyshine_heated(
        tables: *const c_void,
        count: usize,
        faces: *const Faces,
        absorbed: *const f64,
        steps: usize,
        hours: *const f64,
        times: usize,
        temperature: *mut f64,
        scratch: *mut c_void,
        failure: *mut Failure,
    ) -> i32;
    pub fn skyshine_quantity(
        tables: *const c_void,
        quantity: i32,
        by_wavelength: i32,
        count: usize,
        places: *const Places,
        values: *mut f64,
        scratch: *mut c_void,
        failure: *mut Failure,
    ) -> i32;
    pub fn skyshine_ambient(
        tables: *const c_void,
        by_wavelength: i32,
        count: usize,
        places: *const Places,
        slope: *const f64,
        azimuth: *const f64,
        ground_temperature: *const f64,
        values: *mut f64,
        scratch: *mut c_void,
        failure: *mut Failure,
    ) -> i32;
    pub fn skyshine_pixel_terms(
        tables: *const c_void,
        count: usize,
        materials: usize,
        lines: usize,
        pixels: *const Pixels,
        terms: *const Terms,
        scratch: *mut c_void,
        failure: *mut Failure,
    ) -> i32;
    pub fn skyshine_apparent_temperatures(
        tables: *const c_void,
        count: usize,
        radiance: *const f64,
        temperature: *mut f64,
        failure: *mut Failure,
    ) -> i32;
    pub fn skyshine_value_of_pixel(radiance: f64, bits: i32, gain: f64, buffer_gain: f64, offset: f64) -> i64;
}
