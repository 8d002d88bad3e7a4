//! Light of the sky on a face from which something hides a part of it: the formula of schemas/formats/atmq-2.md.

use crate::axis::Result;
use crate::light::Place;
use crate::pixel::Pixel;
use crate::shade::{air_temperature, WALL_EMISSIVITY};
use crate::tables::{Face, Tables};

impl Tables {
    /// Put what hides a share of the sky, as warm as the air, in the place of that share.
    pub(crate) fn hide_sky(&self, pixel: &Pixel, centre: &Place, hidden: f64, sky: &mut [f64]) -> Result<()> {
        let level = self.air.light("ambient_radiance", centre)?;
        let wall = self.glow(centre, air_temperature(&self.surface, pixel.surface_altitude, pixel.time)?)?;
        let ground = self.glow(centre, self.ground_before_walls(pixel)?)?;
        let share = hidden * 0.5 * (1.0 + pixel.surface_slope.to_radians().cos());
        for (b, light) in sky.iter_mut().enumerate() {
            let shine = WALL_EMISSIVITY * wall[b] + (1.0 - WALL_EMISSIVITY) * 0.5 * (level[b] + ground[b]);
            *light = (*light + share * (shine - level[b])).max(0.0);
        }
        Ok(())
    }

    /// What black bodies beside a pixel emit, at each wavelength as `Database::light` gives light there.
    fn glow(&self, centre: &Place, temperature: f64) -> Result<Vec<f64>> {
        let radiance = self.band.value("blackbody_radiance", &[("temperature", temperature)])?;
        if !self.air.parted {
            return Ok(vec![radiance]);
        }
        let range = centre.iter().find(|(name, _)| *name == "range").map_or(0.0, |(_, value)| *value);
        let tau = (-5.5 * range / self.air.value("beta_star", centre)?).exp();
        let extinction = self.air.extinction(centre)?;
        let share = self.band.spectrum("emission_share", ("planck_temperature", temperature))?;
        let weight = |extinction: f64| if tau > 0.0 { (-extinction * range).exp() / tau } else { 0.0 };
        Ok(share.iter().zip(extinction).map(|(share, extinction)| radiance * share * weight(extinction)).collect())
    }

    /// Temperature of the ground that what hides the sky reflects: of the pixel's material, of the file's, or as that states it.
    fn ground_before_walls(&self, pixel: &Pixel) -> Result<f64> {
        let (mut material, mut altitude) = (pixel.ground_material, pixel.surface_altitude);
        if let (None, Some(name)) = (material, &self.air.ground_material) {
            let found = self.materials().iter().find(|(_, each)| each == name);
            material = Some(found.ok_or_else(|| format!("the air is over '{name}', a material that the band lacks"))?.0);
            altitude = self.surface.nodes("temperature", 1)[0];
        }
        let Some(material) = material else {
            return self.air.ground_temperature.ok_or_else(|| "the air does not state the temperature of the ground".into());
        };
        self.surface.value("temperature", &Face { material, altitude, azimuth: 0.0, slope: 0.0, time: pixel.time }.place())
    }
}
