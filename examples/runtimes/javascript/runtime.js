// A runtime's reader of the databases with h5wasm: the radiance of the pixels of a scene.
// Usage: node runtime.js SCENE.json
// The scene and the result are described in ../README.md. Equation numbers are those of DSTO-TN-0193.
import { readFileSync } from "node:fs";
import { dirname, isAbsolute, join } from "node:path";
import h5wasm from "h5wasm";
import { absorbedChange, temperatureUnder } from "./shade.js";
import { Texture } from "./texture.js";
import { SceneError } from "./axis.js";
import { Database } from "./database.js";
import { CODES, GLOW, LIGHT } from "./layouts.js";

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

function unit(vector) {
  const length = Array.isArray(vector) && vector.length === 3 ? Math.sqrt(dot(vector, vector)) : 0;
  if (!Number.isFinite(length) || length === 0) throw new SceneError("a direction must be three finite numbers that are not all 0");
  return vector.map((part) => part / length);
}

// Angle between line of sight and source, all in degree.
function scatteringAngle(elevation, sourceElevation, azimuth) {
  const [line, source, turn] = [elevation, sourceElevation, azimuth].map((angle) => (angle * Math.PI) / 180);
  const half = Math.sin((line - source) / 2) ** 2 + Math.cos(line) * Math.cos(source) * Math.sin(turn / 2) ** 2;
  return (2 * Math.asin(Math.sqrt(Math.min(Math.max(half, 0), 1))) * 180) / Math.PI;
}

// Equations (37) and (38): chi of the half vector to the power of the shininess.
function lobe(normal, toSource, toObserver, shininess) {
  const between = toSource.map((part, k) => part + toObserver[k]);
  const length = Math.sqrt(dot(between, between));
  const chi = length > 0 ? Math.max(dot(between, normal) / length, 0) : 0;
  return Math.min(chi, 1) ** shininess;
}

// Equation (44), rounded to the nearest integer: the nearest to x - 1/2, halves upwards, is the floor of x.
function pixelValue(radiance, scene) {
  const size = 2 ** scene.bits;
  const share = Math.min(Math.max(radiance / scene.gain, 0), 1);
  const value = Math.floor(size * scene.buffer_gain * (share - scene.offset));
  return Math.min(Math.max(value, 0), size - 1);
}

// Temperature of the table, or with the heat or the surroundings that the pixel has.
function temperatureOf(surface, face, { absorbed_change: absorbed, surroundings }) {
  if (surroundings) return temperatureUnder(surface, face, absorbedChange(surface, face, surroundings));
  return absorbed ? temperatureUnder(surface, face, absorbed) : surface.value("temperature", face);
}

// A_l / pi times Y_lm of a unit normal, in the order of the codes.
function irradianceHarmonics([x, y, z]) {
  const even = x * x - y * y;
  return [
    0.28209479177387814,
    0.32573500793527993 * z,
    0.32573500793527993 * x,
    (0.15769578262626002 * (3 * z * z - 1)) / 2,
    0.2731371076480198 * x * z,
    0.1365685538240099 * even,
    (-0.03526184897173477 * (35 * z ** 4 - 30 * z * z + 3)) / 8,
    (-0.0557538786297741 * x * z * (7 * z * z - 3)) / 2,
    (-0.039423945656565 * even * (7 * z * z - 1)) / 2,
    (-0.14751089748166088 * x * z * (x * x - 3 * y * y)) / 2,
    -0.026076488977049006 * (even * even - 4 * x * x * y * y),
  ];
}

// L_ambient, as `light`, of a face with a normal in the frame of the source's azimuth; temperature of the ground and what it emits.
function ambient(air, where, normal, [temperature, emitted]) {
  const [codes, zones] = [LIGHT, GLOW].map((name) => air.codesOf(name));
  const total = codes.map((harmonic) => air.light(LIGHT, { ...where, harmonic }));
  for (const code of zones) {
    const place = { ...where, ground_temperature: temperature, zonal_harmonic: code };
    const [part, glow] = [total[CODES.harmonic.indexOf(code)], air.light(GLOW, place)];
    glow.forEach((value, b) => (part[b] += emitted * value));
  }
  const [facing, upright] = [normal, [0, 0, 1]].map(irradianceHarmonics);
  const sum = (basis, b) => total.reduce((all, part, k) => all + part[b] * basis[k], 0);
  const square = normal[2] ** 2;
  const share = codes.length === 6 ? ((35 * square - 30) * square + 3) / 8 : (((231 * square - 315) * square + 105) * square - 5) / 16;
  return air.light("ambient_radiance", where).map((level, b) => Math.max(sum(facing, b) + (level - sum(upright, b)) * share, 0));
}

// L_ambient of a pixel's face, as `light`; of a level one where the file or the pixel says no more.
function ambientOfPixel(surface, band, air, centre, given) {
  if (!air.ground || given.source_heading === undefined) return air.light("ambient_radiance", centre);
  let [emissivity, temperature, emitted] = air.ground;
  if (given.ground_material !== undefined) {
    const material = band.material(given.ground_material);
    temperature = surface.value("temperature", { material, altitude: given.surface_altitude, azimuth: 0, slope: 0, time: given.time });
    emitted = emissivity * band.value("blackbody_radiance", { temperature });
  }
  const [slope, turn] = [given.surface_slope, given.surface_azimuth - given.source_heading].map((angle) => (angle * Math.PI) / 180);
  const normal = [Math.sin(slope) * Math.cos(turn), Math.sin(slope) * Math.sin(turn), Math.cos(slope)];
  return ambient(air, centre, normal, [temperature, emitted]);
}

// The pixel with the source from the tracks of the surface file, where it does not say where the source is.
function withSource(surface, air, given) {
  if (given.source_elevation !== undefined) return given;
  if (!surface.arrays.sun_elevation) throw new SceneError("the surface file holds no tracks of Sun and Moon");
  const source = air.filetype === "lunar_atmq" ? "moon" : "sun";
  const [elevation, azimuth] = ["elevation", "azimuth"].map((angle) => surface.value(`${source}_${angle}`, { track_time: given.time }));
  if (!Number.isFinite(given.line_heading)) throw new SceneError("the scene lacks 'line_heading'");
  const [up, turn] = [elevation, azimuth].map((angle) => (angle * Math.PI) / 180);
  return {
    source_elevation: elevation,
    source_azimuth: azimuth - given.line_heading,
    source_heading: azimuth,
    to_source: [Math.cos(up) * Math.sin(turn), Math.cos(up) * Math.cos(turn), Math.sin(up)],
    ...given,
  };
}

// Codes and shares of the materials that the pixel sees: those of a texel, or one.
function materialsOf(band, texture, { material, texel, level = 0 }) {
  if (texel === undefined) return [[band.material(material), 1]];
  if (!texture) throw new SceneError("the scene lacks 'texture'");
  if (!Array.isArray(texel) || texel.length !== 2) throw new SceneError("'texel' must be two numbers");
  return texture.mixture(...texel, level);
}

// Reflectance of a material, and the share in what a black body emits, at each wavelength or in the whole band.
function reflectanceAndEmission(band, parted, material, temperature) {
  if (!parted) return [[band.value("reflectance", { material })], [1]];
  return [band.spectrum("reflectance_spectrum", { material }), band.spectrum("emission_share", { planck_temperature: temperature })];
}

// Equations (1) to (44) for one pixel.
function pixel(scene, surface, band, air, texture, asked) {
  const given = withSource(surface, air, asked);
  const centre = { ...given, range: given.centre_range, elevation: given.centre_elevation };
  const beta = air.value("beta_star", centre);
  const depth = (5.5 * given.range) / beta;
  const tau = Math.exp(-depth); // (9)
  centre.scattering_angle = scatteringAngle(centre.elevation, centre.source_elevation, centre.source_azimuth);
  const sky = ambientOfPixel(surface, band, air, centre, given);
  const [normal, toSource, toObserver] = [given.normal, given.to_source, given.to_observer].map(unit);
  const incidence = Math.max(dot(normal, toSource), 0);
  const beam = incidence > 0 ? air.light("direct_radiance", centre) : sky.map(() => 0);
  const through = air.transmittance(centre, given.range);
  const sums = { temperature: 0, blackbody_radiance: 0, thermal: 0, skyshine: 0, diffuse: 0, specular: 0 };
  const materials = materialsOf(band, texture, given);
  for (const [code, share] of materials) {
    const face = {
      material: code,
      altitude: given.surface_altitude,
      azimuth: given.surface_azimuth,
      slope: given.surface_slope,
      time: given.time,
    };
    const temperature = temperatureOf(surface, face, given);
    const blackbody = band.value("blackbody_radiance", { temperature }); // (7)
    const property = (name) => band.value(name, { material: code });
    const fraction = property("specular_fraction");
    const [rho, emission] = reflectanceAndEmission(band, air.parted, code, temperature);
    const emitted = rho.reduce((all, reflected, b) => all + (1 - reflected) * emission[b] * through[b], 0);
    const reflect = (light) => Math.max(rho.reduce((all, reflected, b) => all + reflected * light[b], 0), 0);
    const direct = reflect(beam) * tau;
    sums.temperature += share * temperature;
    sums.blackbody_radiance += share * blackbody;
    sums.thermal += share * blackbody * emitted; // (5), or (6)
    sums.skyshine += share * reflect(sky) * tau; // (18), or (19)
    sums.diffuse += share * direct * incidence * (1 - fraction); // (34)
    const shape = lobe(normal, toSource, toObserver, property("shininess"));
    sums.specular += share * direct * shape * fraction * property("normalisation"); // (35)
  }
  const path = air.value("path_radiance_ratio", centre) * -Math.expm1(-depth); // (11)
  const radiance = sums.diffuse + sums.specular + sums.skyshine + sums.thermal + path; // (1)
  return {
    material: materials[0][0], ...sums, beta_star: beta, transmittance: tau, path, radiance,
    pixel_value: pixelValue(radiance, scene),
  };
}

async function main(path) {
  const { activate_throwing_error_handler } = await h5wasm.ready;
  activate_throwing_error_handler();
  const scene = JSON.parse(readFileSync(path, "utf-8"));
  const clamped = scene.clamp ?? [];
  const place = (name) => (isAbsolute(name) ? name : join(dirname(path), name));
  const open = (name, filetypes) => new Database(place(name), filetypes, clamped);
  const surface = open(scene.surface, ["htt"]);
  const band = open(scene.band, ["band"]);
  const air = open(scene.atmosphere, ["atmq", "lunar_atmq"]);
  air.partLight(band);
  const texture = scene.texture === undefined ? null : new Texture(place(scene.texture));
  console.log(JSON.stringify({ pixels: scene.pixels.map((given) => pixel(scene, surface, band, air, texture, given)) }));
}

main(process.argv[2]).catch((error) => {
  console.error(String(error.message).replace(/[\p{C}\p{Zl}\p{Zp}]/gu, "?"));
  process.exitCode = 1;
});
