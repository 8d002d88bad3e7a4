// Equations (1) to (44) for one pixel.
import { SkyshineError } from "./axis.js";
import { ambientWeights, bases, hasFourthDegree, normalOf, summed } from "./light.js";
import { placeOf } from "./line.js";
import { hideSky } from "./walls.js";

// Open share of the sky above what a texture shows in the shade, where a scene says nothing else.
export const SHADED_SKY = 0.5;

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

function unit(vector) {
  const length = Array.isArray(vector) && vector.length === 3 ? Math.sqrt(dot(vector, vector)) : 0;
  if (!Number.isFinite(length) || length === 0) throw new SkyshineError("a direction must be three finite numbers that are not all 0");
  return vector.map((part) => part / length);
}

// Equations (37) and (38): chi of the half vector to the power of the shininess.
function lobe(normal, toSource, toObserver, shininess) {
  const between = toSource.map((part, k) => part + toObserver[k]);
  const length = Math.sqrt(dot(between, between));
  const chi = length > 0 ? Math.max(dot(between, normal) / length, 0) : 0;
  return Math.min(chi, 1) ** shininess;
}

// Equation (44), rounded to the nearest integer: the nearest to x - 1/2, halves upwards, is the floor of x.
export function pixelValue(radiance, { bits, gain, bufferGain = 1, offset = 0 }) {
  const size = 2 ** bits;
  const share = Math.min(Math.max(radiance / gain, 0), 1);
  return Math.min(Math.max(Math.floor(size * bufferGain * (share - offset)), 0), size - 1);
}

// L_ambient of a pixel's face at each wavelength; of a level one where the file or the pixel says no more.
function ambientOf(tables, pixel, centre) {
  const ground = tables.groundOf(pixel.groundMaterial, pixel.surfaceAltitude, pixel.time);
  if (!ground || pixel.sourceHeading === undefined || pixel.sourceHeading === null) return tables.air.light("ambient_radiance", centre);
  const normal = normalOf(pixel.surfaceSlope, pixel.surfaceAzimuth - pixel.sourceHeading);
  return summed(ambientWeights(tables.air, centre, ground, true), bases(hasFourthDegree(tables.air), normal));
}

// Reflectance of a material at each wavelength or in the whole band.
const reflectanceOf = (band, parted, material) => (parted ? band.spectrum("reflectance_spectrum", { material }) : [band.value("reflectance", { material })]);

// Share of each wavelength in what a black body emits, or of the whole band.
const emissionOf = (band, parted, temperature) => (parted ? band.spectrum("emission_share", { planck_temperature: temperature }) : [1]);

function shareOf(name, value) {
  if (!(value >= 0 && value <= 1)) throw new SkyshineError(`${name}: found ${value}; allowed: 0 to 1`);
  return value;
}

export function pixelRadiance(tables, pixel) {
  const { air, band } = tables;
  const centre = placeOf({ ...pixel, range: pixel.centreRange, elevation: pixel.centreElevation });
  const betaStar = air.value("beta_star", centre);
  const depth = (5.5 * pixel.range) / betaStar;
  const tau = Math.exp(-depth); // (9)
  const shade = shareOf("shade", pixel.shade ?? 0);
  const open = shareOf("skyView", pixel.skyView ?? 1);
  const under = Math.min(open, shareOf("shadedSky", pixel.shadedSky ?? SHADED_SKY));
  const hidden = 1 - open + shade * (open - under);
  const whole = ambientOf(tables, pixel, centre);
  const sky = hidden > 0 ? hideSky(tables, pixel, centre, hidden, whole) : whole;
  const [normal, toSource, toObserver] = [pixel.normal, pixel.toSource, pixel.toObserver].map(unit);
  const incidence = Math.max(dot(normal, toSource), 0);
  const beam = incidence > 0 ? air.light("direct_radiance", centre) : sky.map(() => 0);
  const through = air.extinction(centre).map((extinction) => Math.exp(-extinction * pixel.range));
  const sums = { temperature: 0, blackbodyRadiance: 0, thermal: 0, skyshine: 0, diffuse: 0, specular: 0 };
  if (!pixel.materials?.length) throw new SkyshineError("a pixel has a material");
  for (const { code, share, temperature: given, shadedTemperature } of pixel.materials) {
    const face = { material: code, altitude: pixel.surfaceAltitude, azimuth: pixel.surfaceAzimuth, slope: pixel.surfaceSlope, time: pixel.time };
    const parts = [[share * (1 - shade), given ?? tables.temperature(face)]];
    if (shade > 0) parts.push([share * shade, shadedTemperature ?? tables.shadedTemperature(face, { shade: [[0, 24]], skyView: under })]);
    const property = (name) => band.value(name, { material: code });
    const fraction = property("specular_fraction");
    const rho = reflectanceOf(band, air.parted, code);
    for (const [part, temperature] of parts) {
      const blackbody = band.value("blackbody_radiance", { temperature }); // (7)
      const emission = emissionOf(band, air.parted, temperature);
      const emitted = rho.reduce((all, reflected, b) => all + (1 - reflected) * emission[b] * through[b], 0);
      sums.temperature += part * temperature;
      sums.blackbodyRadiance += part * blackbody;
      sums.thermal += part * blackbody * emitted; // (5), or (6)
    }
    const reflect = (light) => Math.max(rho.reduce((all, reflected, b) => all + reflected * light[b], 0), 0);
    const direct = reflect(beam) * tau * (1 - shade);
    sums.skyshine += share * reflect(sky) * tau; // (18), or (19)
    sums.diffuse += share * direct * incidence * (1 - fraction); // (34)
    const shape = lobe(normal, toSource, toObserver, property("shininess"));
    sums.specular += share * direct * shape * fraction * property("normalisation"); // (35)
  }
  const path = air.value("path_radiance_ratio", centre) * -Math.expm1(-depth); // (11)
  const radiance = sums.diffuse + sums.specular + sums.skyshine + sums.thermal + path; // (1)
  return { ...sums, betaStar, transmittance: tau, path, radiance };
}
