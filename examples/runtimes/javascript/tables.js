// The tables of a state, a band and a source: opened, and read at one place.
import h5wasm from "h5wasm";
import { SkyshineError } from "./axis.js";
import { Database } from "./database.js";
import { Frame } from "./frame.js";
import { ambientWeights, bases, hasFourthDegree, normalOf, summed } from "./light.js";
import { placeOf } from "./line.js";
import { pixelRadiance } from "./pixel.js";
import { absorbedChange, temperatureUnder } from "./shade.js";
import { Texture } from "./texture.js";

async function ready() {
  const { activate_throwing_error_handler } = await h5wasm.ready;
  activate_throwing_error_handler();
}

// The name in messages and the bytes of a file: given as a path (in Node), or as bytes.
async function contentOf(given, kind) {
  if (given instanceof Uint8Array) return [`the ${kind} file`, given];
  const { readFileSync, statSync } = await import("node:fs");
  try {
    if (statSync(given).isFile()) return [given, readFileSync(given)];
  } catch {
    // refused below
  }
  throw new SkyshineError(`${given}: is not a readable HDF5 file`, "file");
}

export async function openFiles({ surface, band, atmosphere }, clamp = []) {
  await ready();
  const open = async (given, kind, filetypes) => new Database(...(await contentOf(given, kind)), filetypes, clamp);
  const opened = [await open(surface, "surface", ["htt"]), await open(band, "band", ["band"])];
  return new Tables(...opened, await open(atmosphere, "atmosphere", ["atmq", "lunar_atmq"]));
}

export async function open(folder, { state = 1, band = 1, source = "sun", clamp = [] } = {}) {
  const { readFileSync } = await import("node:fs");
  let files;
  try {
    ({ files } = JSON.parse(readFileSync(`${folder}/catalog.json`, "utf-8")));
  } catch {
    throw new SkyshineError(`${folder}/catalog.json: is not a catalogue of databases`, "file");
  }
  const listed = (filetype, wanted) => {
    const entry = Array.isArray(files) && files.find((each) => each?.filetype === filetype && Object.keys(wanted).every((key) => each[key] === wanted[key]));
    if (!entry) throw new SkyshineError(`${folder}/catalog.json: lists no '${filetype}' of state ${state} and band ${band}`, "file");
    if (typeof entry.file !== "string" || /[/\\]/.test(entry.file)) throw new SkyshineError(`${folder}/catalog.json: names a file elsewhere`, "file");
    return `${folder}/${entry.file}`;
  };
  const air = listed(source === "moon" ? "lunar_atmq" : "atmq", { state, band });
  return openFiles({ surface: listed("htt", { state }), band: listed("band", { band }), atmosphere: air }, clamp);
}

export async function openTexture(given) {
  await ready();
  return new Texture(...(await contentOf(given, "texture")));
}

export class Tables {
  constructor(surface, band, air) {
    air.partLight(band);
    Object.assign(this, { surface, band, air });
  }

  materials() {
    return [...this.band.codes].map(([name, code]) => ({ code, name })).sort((one, other) => one.code - other.code);
  }

  temperature(face) {
    return this.surface.value("temperature", face);
  }

  shadedTemperature(face, surroundings) {
    return temperatureUnder(this.surface, face, absorbedChange(this.surface, face, surroundings));
  }

  heatedTemperature(face, absorbed) {
    return temperatureUnder(this.surface, face, absorbed);
  }

  transmittance(line) {
    return Math.exp((-5.5 * line.range) / this.air.value("beta_star", placeOf(line)));
  }

  pathRadiance(line) {
    const place = placeOf(line);
    return this.air.value("path_radiance_ratio", place) * -Math.expm1((-5.5 * line.range) / this.air.value("beta_star", place));
  }

  ambientRadiance(line, { slope = 0, azimuth = 0 } = {}) {
    const { ground } = this.air;
    if (!Number.isFinite(slope) || !Number.isFinite(azimuth) || (!ground && slope !== 0))
      throw new SkyshineError(`slope: found ${slope}; allowed: ${ground ? "finite numbers" : "0, as the file holds no harmonics"}`);
    const weights = ambientWeights(this.air, placeOf(line), ground?.slice(1), false);
    return summed(weights, ground ? bases(hasFourthDegree(this.air), normalOf(slope, azimuth)) : [1])[0];
  }

  directRadiance(line) {
    return this.air.value("direct_radiance", placeOf(line));
  }

  pixelRadiance(pixel) {
    return pixelRadiance(this, pixel);
  }

  apparentTemperature(radiance) {
    const { axes, values } = this.band.arrays.blackbody_radiance;
    const { nodes } = axes[0];
    const [first, last] = [values[0], values.at(-1)];
    if (!(radiance >= first && radiance <= last)) throw new SkyshineError(`radiance: found ${radiance}; allowed: ${first} to ${last}`);
    let [lower, above] = [0, nodes.length];
    while (above - lower > 1) {
      const middle = (lower + above) >> 1;
      if (values[middle] <= radiance) lower = middle;
      else above = middle;
    }
    if (above === nodes.length) return nodes[lower];
    return nodes[lower] + ((radiance - values[lower]) / (values[above] - values[lower])) * (nodes[above] - nodes[lower]);
  }

  sourcePosition(time) {
    if (!this.surface.arrays.sun_elevation) throw new SkyshineError("the surface file holds no tracks of Sun and Moon");
    const source = this.air.filetype === "lunar_atmq" ? "moon" : "sun";
    const [elevation, heading] = ["elevation", "azimuth"].map((angle) => this.surface.value(`${source}_${angle}`, { track_time: time }));
    return { elevation, heading };
  }

  frame(view) {
    return new Frame(this, view);
  }

  // Temperature of the ground around a face, and what it emits: of a material, or as the file states it; null where the file has no harmonics.
  groundOf(material, altitude, time) {
    if (!this.air.ground) return null;
    const [emissivity, temperature, emitted] = this.air.ground;
    if (material === undefined || material === null) return [temperature, emitted];
    const kelvin = this.temperature({ material, altitude, azimuth: 0, slope: 0, time });
    return [kelvin, emissivity * this.band.value("blackbody_radiance", { temperature: kelvin })];
  }
}
