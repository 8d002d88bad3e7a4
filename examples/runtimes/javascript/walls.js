// Light of the sky on a face from which something hides a part of it: the formula of schemas/formats/atmq-2.md.
import { SkyshineError } from "./axis.js";
import { airTemperature, WALL_EMISSIVITY } from "./shade.js";

// What black bodies beside a pixel emit, at each wavelength as `Database.light` gives light there.
function glow({ air, band }, centre, temperature) {
  const radiance = band.value("blackbody_radiance", { temperature });
  if (!air.parted) return [radiance];
  const tau = Math.exp((-5.5 * centre.range) / air.value("beta_star", centre));
  const extinction = air.extinction(centre);
  return band.spectrum("emission_share", { planck_temperature: temperature })
    .map((share, b) => (tau > 0 ? (radiance * share * Math.exp(-extinction[b] * centre.range)) / tau : 0));
}

// Temperature of the ground that what hides the sky reflects: of the pixel's material, of the file's, or as that states it.
function groundBeforeWalls(tables, pixel) {
  const level = { azimuth: 0, slope: 0, time: pixel.time };
  const { groundMaterial, groundTemperature } = tables.air;
  if (pixel.groundMaterial !== undefined && pixel.groundMaterial !== null)
    return tables.temperature({ ...level, material: pixel.groundMaterial, altitude: pixel.surfaceAltitude });
  if (groundMaterial) {
    const material = tables.band.codes.get(groundMaterial);
    if (material === undefined) throw new SkyshineError(`the air is over '${groundMaterial}', a material that the band lacks`);
    return tables.temperature({ ...level, material, altitude: tables.surface.arrays.temperature.axes[1].nodes[0] });
  }
  if (!(groundTemperature >= 0 && Number.isFinite(groundTemperature))) throw new SkyshineError("the air does not state the temperature of the ground");
  return groundTemperature;
}

// Light of the sky, with what hides a share of it, as warm as the air, in its place.
export function hideSky(tables, pixel, centre, hidden, sky) {
  const level = tables.air.light("ambient_radiance", centre);
  const wall = glow(tables, centre, airTemperature(tables.surface, pixel.surfaceAltitude, pixel.time));
  const ground = glow(tables, centre, groundBeforeWalls(tables, pixel));
  const share = hidden * 0.5 * (1 + Math.cos((pixel.surfaceSlope * Math.PI) / 180));
  const shine = (b) => WALL_EMISSIVITY * wall[b] + (1 - WALL_EMISSIVITY) * 0.5 * (level[b] + ground[b]);
  return sky.map((light, b) => Math.max(light + share * (shine(b) - level[b]), 0));
}
