// A runtime's reader of the databases with h5wasm: the radiance of the pixels of a scene.
// Usage: node runtime.js SCENE.json
// The scene and the result are described in ../README.md. Equation numbers are those of DSTO-TN-0193.
import { readFileSync } from "node:fs";
import { dirname, isAbsolute, join } from "node:path";
import h5wasm from "h5wasm";
import { Database, SceneError } from "./database.js";
import { absorbedChange, temperatureUnder } from "./shade.js";

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

// Equations (1) to (44) for one pixel.
function pixel(scene, surface, band, air, given) {
  const code = band.material(given.material);
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
  const rho = property("reflectance");
  const fraction = property("specular_fraction");
  const centre = { ...given, range: given.centre_range, elevation: given.centre_elevation };
  const beta = air.value("beta_star", centre);
  const depth = (5.5 * given.range) / beta;
  const tau = Math.exp(-depth); // (9)
  centre.scattering_angle = scatteringAngle(centre.elevation, centre.source_elevation, centre.source_azimuth);
  const path = air.value("path_radiance_ratio", centre) * -Math.expm1(-depth); // (11)
  const skyshine = air.value("ambient_radiance", centre) * rho * tau; // (19)
  const [normal, toSource, toObserver] = [given.normal, given.to_source, given.to_observer].map(unit);
  const incidence = Math.max(dot(normal, toSource), 0);
  const direct = incidence > 0 ? air.value("direct_radiance", centre) * rho * tau : 0;
  const thermal = blackbody * (1 - rho) * tau; // (6)
  const diffuse = direct * incidence * (1 - fraction); // (34)
  const specular = direct * lobe(normal, toSource, toObserver, property("shininess")) * fraction * property("normalisation"); // (35)
  const radiance = diffuse + specular + skyshine + thermal + path; // (1)
  return {
    temperature, blackbody_radiance: blackbody, beta_star: beta, transmittance: tau,
    thermal, path, skyshine, diffuse, specular, radiance, pixel_value: pixelValue(radiance, scene),
  };
}

async function main(path) {
  const { activate_throwing_error_handler } = await h5wasm.ready;
  activate_throwing_error_handler();
  const scene = JSON.parse(readFileSync(path, "utf-8"));
  const clamped = scene.clamp ?? [];
  const open = (name, filetypes) => new Database(isAbsolute(name) ? name : join(dirname(path), name), filetypes, clamped);
  const surface = open(scene.surface, ["htt"]);
  const band = open(scene.band, ["band"]);
  const air = open(scene.atmosphere, ["atmq", "lunar_atmq"]);
  console.log(JSON.stringify({ pixels: scene.pixels.map((given) => pixel(scene, surface, band, air, given)) }));
}

main(process.argv[2]).catch((error) => {
  console.error(String(error.message).replace(/[\p{C}\p{Zl}\p{Zp}]/gu, "?"));
  process.exitCode = 1;
});
