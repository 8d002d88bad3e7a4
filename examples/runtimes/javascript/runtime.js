// A runtime's reader of the databases with h5wasm: the radiance of the pixels of a scene.
// Usage: node runtime.js SCENE.json
// The scene and the result are described in ../README.md. Equation numbers are those of DSTO-TN-0193.
import { readFileSync } from "node:fs";
import { dirname, isAbsolute, join } from "node:path";
import h5wasm from "h5wasm/node";

const VIEW = ["range", "altitude", "elevation"];
const SOURCE = [...VIEW, "source_elevation"];
const FORMATS = { htt: "1", band: "1", atmq: "2" };
const FACE = ["material", "altitude", "azimuth", "slope", "time"];

class SceneError extends Error {}

const attribute = (item, name, otherwise) => (name in item.attrs ? item.attrs[name].value : otherwise);
const modulo = (value, period) => value - period * Math.floor(value / period);

class Axis {
  constructor(name, dataset, clamped) {
    this.name = name;
    this.nodes = Array.from(dataset.value, Number);
    this.interpolation = attribute(dataset, "interpolation", "linear");
    this.period = Number(attribute(dataset, "period", 0));
    this.clamps = clamped || attribute(dataset, "out_of_range", "error") === "clamp";
  }

  // Index of the lower and the upper node, and the weight of the upper one.
  locate(given) {
    if (!Number.isFinite(given)) throw new SceneError(`${this.name}: found ${given}; allowed: finite numbers`);
    let value = given;
    let nodes = this.nodes;
    if (this.interpolation === "exact") {
      const at = nodes.indexOf(value);
      if (at < 0) throw new SceneError(`${this.name}: found ${value}; allowed: a code of the file`);
      return { lower: at, upper: at, weight: 0 };
    }
    if (this.interpolation === "linear_periodic") {
      nodes = [...nodes, nodes[0] + this.period];
      value = nodes[0] + modulo(value - nodes[0], this.period);
    } else if (this.interpolation === "linear" && this.period > 0) {
      value -= this.period * Math.floor((value - nodes[0]) / this.period);
    } else if (this.interpolation === "linear_folded") {
      value = Math.abs(modulo(value + this.period / 2, this.period) - this.period / 2);
    }
    const last = nodes.length - 1;
    if (!this.clamps && !(value >= nodes[0] && value <= nodes[last]))
      throw new SceneError(`${this.name}: found ${value}; allowed: ${nodes[0]} to ${nodes[last]}`);
    value = Math.min(Math.max(value, nodes[0]), nodes[last]);
    let lower = 0;
    let above = Math.max(last, 1);
    while (above - lower > 1) {
      const middle = (lower + above) >> 1;
      if (nodes[middle] <= value) lower = middle;
      else above = middle;
    }
    const upper = Math.min(lower + 1, last);
    const weight = upper > lower ? (value - nodes[lower]) / (nodes[upper] - nodes[lower]) : 0;
    return { lower, upper: upper % this.nodes.length, weight };
  }
}

class Database {
  constructor(path, filetypes, clamped) {
    try {
      this.file = new h5wasm.File(path, "r");
      this.filetype = attribute(this.file, "filetype", "");
    } catch {
      throw new SceneError(`${path}: is not a readable HDF5 file`);
    }
    const version = String(attribute(this.file, "format_version", ""));
    const major = FORMATS[filetypes[0]];
    if (!filetypes.includes(this.filetype) || version.split(".")[0] !== major)
      throw new SceneError(`${path}: holds '${this.filetype}' ${version}; allowed: ${filetypes.join(" or ")} ${major}.x`);
    Object.assign(this, { clamped, axes: {}, arrays: {}, names: new Set(this.file.keys()) });
  }

  // The quantity's own axis where the file has one, else the one that quantities share.
  axis(quantity, name) {
    const own = this.names.has(`${quantity}_${name}`) ? `${quantity}_${name}` : name;
    return (this.axes[own] ??= new Axis(name, this.file.get(own), this.clamped.includes(name)));
  }

  // Linear interpolation in every axis: the weighted sum over the corners of one cell.
  value(quantity, axes, where) {
    const array = (this.arrays[quantity] ??= this.file.get(quantity).value);
    const located = axes.map((name) => this.axis(quantity, name).locate(where[name]));
    let total = 0;
    for (let corner = 0; corner < 1 << axes.length; corner++) {
      let share = 1;
      let index = 0;
      located.forEach((place, k) => {
        const up = (corner >> k) & 1;
        share *= up ? place.weight : 1 - place.weight;
        index = index * this.axis(quantity, axes[k]).nodes.length + (up ? place.upper : place.lower);
      });
      if (share) total += share * array[index];
    }
    return total;
  }

  // Code of a material given by code or by name.
  material(given) {
    if (typeof given !== "string") return given;
    const names = Array.from(this.file.get("material_name").value);
    const at = names.indexOf(given);
    if (at < 0) throw new SceneError(`material: found '${given}'; allowed: ${names.join(", ")}`);
    return this.axis("material_name", "material").nodes[at];
  }
}

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

// Equation (44).
function pixelValue(radiance, scene) {
  const size = 2 ** scene.bits;
  const share = Math.min(Math.max(radiance / scene.gain, 0), 1);
  const value = Math.trunc(size * scene.buffer_gain * (share - scene.offset) - 0.5);
  return Math.min(Math.max(value, 0), size - 1);
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
  const temperature = surface.value("temperature", FACE, face);
  const blackbody = band.value("blackbody_radiance", ["temperature"], { temperature }); // (7)
  const property = (name) => band.value(name, ["material"], { material: code });
  const rho = property("reflectance");
  const fraction = property("specular_fraction");
  const centre = { ...given, range: given.centre_range, elevation: given.centre_elevation };
  const beta = air.value("beta_star", VIEW, centre);
  const depth = (5.5 * given.range) / beta;
  const tau = Math.exp(-depth); // (9)
  const source = air.names.has("scattering_angle") ? "scattering_angle" : "source_azimuth";
  centre.scattering_angle = scatteringAngle(centre.elevation, centre.source_elevation, centre.source_azimuth);
  const path = air.value("path_radiance_ratio", [...SOURCE, source], centre) * -Math.expm1(-depth); // (11)
  const skyshine = air.value("ambient_radiance", SOURCE, centre) * rho * tau; // (19)
  const [normal, toSource, toObserver] = [given.normal, given.to_source, given.to_observer].map(unit);
  const incidence = Math.max(dot(normal, toSource), 0);
  const direct = incidence > 0 ? air.value("direct_radiance", SOURCE, centre) * rho * tau : 0;
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
  console.error(error.message);
  process.exitCode = 1;
});
