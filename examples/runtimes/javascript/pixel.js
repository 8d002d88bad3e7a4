// Equations (1) to (44) for one pixel.
import { SkyshineError } from "./axis.js";
import { ambientWeights, bases, hasFourthDegree, normalOf, summed } from "./light.js";
import { placeOf } from "./line.js";

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

// Reflectance of a material, and the share in what a black body emits, at each wavelength or in the whole band.
function reflectanceAndEmission(band, parted, material, temperature) {
  if (!parted) return [[band.value("reflectance", { material })], [1]];
  return [band.spectrum("reflectance_spectrum", { material }), band.spectrum("emission_share", { planck_temperature: temperature })];
}

export function pixelRadiance(tables, pixel) {
  const { air, band } = tables;
  const centre = placeOf({ ...pixel, range: pixel.centreRange, elevation: pixel.centreElevation });
  const betaStar = air.value("beta_star", centre);
  const depth = (5.5 * pixel.range) / betaStar;
  const tau = Math.exp(-depth); // (9)
  const sky = ambientOf(tables, pixel, centre);
  const [normal, toSource, toObserver] = [pixel.normal, pixel.toSource, pixel.toObserver].map(unit);
  const incidence = Math.max(dot(normal, toSource), 0);
  const beam = incidence > 0 ? air.light("direct_radiance", centre) : sky.map(() => 0);
  const through = air.extinction(centre).map((extinction) => Math.exp(-extinction * pixel.range));
  const sums = { temperature: 0, blackbodyRadiance: 0, thermal: 0, skyshine: 0, diffuse: 0, specular: 0 };
  if (!pixel.materials?.length) throw new SkyshineError("a pixel has a material");
  for (const { code, share, temperature: given } of pixel.materials) {
    const face = { material: code, altitude: pixel.surfaceAltitude, azimuth: pixel.surfaceAzimuth, slope: pixel.surfaceSlope, time: pixel.time };
    const temperature = given ?? tables.temperature(face);
    const blackbody = band.value("blackbody_radiance", { temperature }); // (7)
    const property = (name) => band.value(name, { material: code });
    const fraction = property("specular_fraction");
    const [rho, emission] = reflectanceAndEmission(band, air.parted, code, temperature);
    const emitted = rho.reduce((all, reflected, b) => all + (1 - reflected) * emission[b] * through[b], 0);
    const reflect = (light) => Math.max(rho.reduce((all, reflected, b) => all + reflected * light[b], 0), 0);
    const direct = reflect(beam) * tau;
    sums.temperature += share * temperature;
    sums.blackbodyRadiance += share * blackbody;
    sums.thermal += share * blackbody * emitted; // (5), or (6)
    sums.skyshine += share * reflect(sky) * tau; // (18), or (19)
    sums.diffuse += share * direct * incidence * (1 - fraction); // (34)
    const shape = lobe(normal, toSource, toObserver, property("shininess"));
    sums.specular += share * direct * shape * fraction * property("normalisation"); // (35)
  }
  const path = air.value("path_radiance_ratio", centre) * -Math.expm1(-depth); // (11)
  const radiance = sums.diffuse + sums.specular + sums.skyshine + sums.thermal + path; // (1)
  return { ...sums, betaStar, transmittance: tau, path, radiance };
}
