//! A program that uses the crate: prints the results of all calls at one place, as JSON.
//!
//! Usage: user FOLDER SURFACE BAND ATMOSPHERE

use serde_json::json;
use skyshine::{Error, ErrorKind, Face, Line, Pixel, Source, Surroundings, Tables};

fn main() -> Result<(), Error> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let listed = Tables::open(&arguments[0], 1, 1, Source::Sun, &["range"])?;
    let tables = Tables::open_files(&arguments[1], &arguments[2], &arguments[3], &[])?;
    let materials = tables.materials();
    let face = Face { material: materials[0].0, altitude: 0.5, azimuth: 200.0, slope: 20.0, time: 14.5 };
    let around = Surroundings { shade: vec![[10.0, 14.0]], sky_view: 0.6, facing: Some(310.0), ..Surroundings::default() };
    let line = Line { range: 1.3, altitude: 0.6, elevation: -12.0, source_elevation: 30.0, source_azimuth: 70.0 };
    let pixel = Pixel {
        materials: vec![(materials[0].0, 0.75), (materials[1].0, 0.25)],
        temperatures: vec![tables.temperature(&face)?, 301.0],
        surface_altitude: 0.5,
        surface_azimuth: 200.0,
        surface_slope: 20.0,
        time: 14.5,
        range: 1.2,
        centre_range: 1.3,
        centre_elevation: -12.0,
        altitude: 0.6,
        source_elevation: 30.0,
        source_azimuth: 70.0,
        source_heading: Some(150.0),
        ground_material: None,
        normal: [0.3, -0.2, 0.9],
        to_source: [0.5, 0.5, 0.6],
        to_observer: [-0.1, -0.9, 0.3],
        hidden_sky: 0.0,
        shade: None,
    };
    let terms = tables.pixel_radiance(&pixel)?;
    let alike = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..4).map(|_| scope.spawn(|| tables.pixel_radiance(&pixel))).collect();
        threads.into_iter().all(|thread| thread.join().is_ok_and(|found| found.is_ok_and(|found| found.radiance == terms.radiance)))
    });
    let number = |error: &Error| if error.kind() == ErrorKind::File { 1 } else { 2 };
    let shown = |error: Option<Error>| error.map(|error| json!([number(&error), error.to_string()]));
    let ranges = [-1.0, f64::NEG_INFINITY, f64::INFINITY, f64::NAN].map(|range| shown(listed.transmittance(&Line { range, ..line }).err()));
    let found = json!({
        "listed": listed.materials().len(),
        "materials": materials,
        "temperature": tables.temperature(&face)?,
        "shaded_temperature": tables.shaded_temperature(&face, &around)?,
        "transmittance": tables.transmittance(&line)?,
        "path_radiance": tables.path_radiance(&line)?,
        "ambient_radiance": tables.ambient_radiance(&line, 20.0, 50.0)?,
        "direct_radiance": tables.direct_radiance(&line)?,
        "pixel_radiance": terms.radiance,
        "apparent_temperature": tables.apparent_temperature(terms.radiance)?,
        "threads_alike": alike,
        "untouched": true,
        "refused": shown(tables.temperature(&Face { slope: 400.0, ..face }).err()),
        "ranges": ranges,
        "missing": shown(Tables::open("/nowhere", 1, 1, Source::Sun, &[]).err()),
    });
    println!("{found}");
    Ok(())
}
