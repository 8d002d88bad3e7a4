// A database, read and checked whole before the first pixel: files come from anywhere, and nothing in one is believed before.
import { readFileSync, statSync } from "node:fs";
import h5wasm, { FS } from "h5wasm";

const RESPONSE = ["material", "response_altitude", "response_slope", "response_hour"];
const OVERHEAD = ["altitude", "forcing_time"];
const PATH = ["range", "altitude", "elevation", "source_elevation", "source_azimuth"];
const FORMATS = { htt: "1.", band: "1.", atmq: "2." };
// What a file must hold: axes, least and largest value of each array.
const ARRAYS = {
  htt: { temperature: [["material", "altitude", "azimuth", "slope", "time"], 1, 1e4] },
  band: {
    blackbody_radiance: [["temperature"], 0, Infinity],
    reflectance: [["material"], 0, 1],
    specular_fraction: [["material"], 0, 1],
    shininess: [["material"], 0, Infinity],
    normalisation: [["material"], 0, Infinity],
  },
  atmq: {
    beta_star: [PATH.slice(0, 3), 1e-12, Infinity],
    path_radiance_ratio: [PATH, 0, Infinity],
    ambient_radiance: [PATH.slice(0, 4), 0, Infinity],
    direct_radiance: [PATH.slice(0, 4), 0, Infinity],
  },
};
// What an .htt that holds the first of them must hold, to shade surfaces.
const SHADE = {
  response_kernel: [[...RESPONSE, "lag"], -Infinity, Infinity],
  response_temperature: [RESPONSE, 0, 1e4],
  heat_loss_slope: [RESPONSE, 1e-6, Infinity],
  heat_loss_excess: [[...RESPONSE, "temperature_offset"], -Infinity, Infinity],
  solar_absorptance: [["material"], 0, 1],
  thermal_emissivity: [["material"], 0, 1],
  melting_heat: [RESPONSE, 0, Infinity],
  highest_temperature: [["material"], 1, 1e4],
  direct_normal_irradiance: [OVERHEAD, 0, Infinity],
  diffuse_irradiance: [OVERHEAD, 0, Infinity],
  sky_irradiance: [OVERHEAD, 0, Infinity],
  air_temperature: [OVERHEAD, 1, 1e4],
  solar_elevation: [["forcing_time"], -90, 90],
  solar_azimuth: [["forcing_time"], -360, 360],
  extraterrestrial_irradiance: [["forcing_time"], 1e-6, Infinity],
};
// Of an .htt that holds the first of them: where Sun and Moon stand.
const TRACKS = {
  sun_elevation: [["track_time"], -90, 90],
  sun_azimuth: [["track_time"], -1080, 1080],
  sun_distance: [["track_time"], 0.9, 1.1],
  moon_elevation: [["track_time"], -90, 90],
  moon_azimuth: [["track_time"], -1080, 1080],
  moon_distance: [["track_time"], 3e5, 4.5e5],
  moon_phase_angle: [["track_time"], 0, 180],
  moon_illuminated_fraction: [["track_time"], 0, 1],
};
// Of an .atmq file that has them: coefficients of the light around faces of any direction.
export const [LIGHT, GLOW] = ["ambient_radiance_harmonics", "ground_radiance_harmonics"];
const HARMONICS = {
  [LIGHT]: [[...PATH.slice(0, 4), "harmonic"], -Infinity, Infinity],
  [GLOW]: [[...PATH.slice(0, 3), "ground_temperature", "zonal_harmonic"], -Infinity, Infinity],
};
// Of an .atmq that holds the first of them: its quantities without the source.
const NIGHT = {
  thermal_path_radiance_ratio: [PATH.slice(0, 3), 0, Infinity],
  thermal_ambient_radiance: [PATH.slice(0, 3), 0, Infinity],
};
const NIGHT_HARMONICS = { thermal_radiance_harmonics: [[...PATH.slice(0, 3), "harmonic"], -Infinity, Infinity] };
const WITHOUT_SOURCE = {
  path_radiance_ratio: "thermal_path_radiance_ratio",
  ambient_radiance: "thermal_ambient_radiance",
  direct_radiance: "",
  [LIGHT]: "thermal_radiance_harmonics",
};
const CIVIL_TWILIGHT = -6; // degree: a table whose lowest source elevation is above says nothing of twilight
// Codes 10 l + m of the harmonics, and of those without azimuth; a file has as many as suit its l.
export const CODES = { harmonic: [0, 10, 11, 20, 21, 22, 40, 41, 42, 43, 44], zonal_harmonic: [0, 10, 20, 40] };
const COUNTS = { harmonic: [6, 11], zonal_harmonic: [3, 4] };
const GROUND = ["ground_emissivity", "ground_temperature", "ground_radiance"];
// How the format reads an axis: rules and period; others are linear and do not repeat.
const RULES = {
  material: [["exact"], 0],
  harmonic: [["exact"], 0],
  zonal_harmonic: [["exact"], 0],
  azimuth: [["linear_periodic"], 360],
  source_azimuth: [["linear_folded"], 360],
  time: [["linear_periodic", "linear"], 24],
  response_hour: [["linear_periodic"], 24],
  forcing_time: [["linear_periodic"], 24],
};
const LAST_CODE = 65535;
// Deflate packs at most 1032 bytes into one: a file that claims more does not hold it.
export const [PACKING, SMALL] = [1100, 1 << 20];
export const [INTEGER, FLOAT, TEXT, REFERENCE, LIST] = [0, 1, 3, 7, 9]; // type classes of HDF5
const UNREADABLE = "\ufffd"; // what bytes that are not UTF-8 are decoded to

export class SceneError extends Error {}

const modulo = (value, period) => value - period * Math.floor(value / period);

// An attribute of one value, of the type of `otherwise`; `otherwise` where there is none, null where it is of another kind.
export function attribute(item, name, otherwise) {
  if (!(name in item.attrs)) return otherwise;
  const { metadata, value } = item.attrs[name];
  const one = metadata.total_size === 1 && metadata.shape ? [value].flat()[0] : null;
  const plain = ArrayBuffer.isView(one) ? one[0] : one;
  return typeof plain === typeof otherwise || typeof plain === "bigint" ? (typeof otherwise === "number" ? Number(plain) : plain) : null;
}

class Axis {
  constructor(name, stored, dataset, clamped) {
    this.name = name;
    this.nodes = Array.from(dataset.value, Number);
    this.rule = attribute(dataset, "interpolation", "");
    this.period = attribute(dataset, "period", 0);
    const policy = attribute(dataset, "out_of_range", "error");
    this.clamps = clamped || policy === "clamp";
    // Of source elevations: no light of the source is left there; undefined where the file does not say.
    this.dark = "dark_below" in dataset.attrs ? (attribute(dataset, "dark_below", 0) ?? NaN) : undefined;
    const fault = ["error", "clamp"].includes(policy) ? this.fault() : "out_of_range that is neither error nor clamp";
    if (fault) throw new SceneError(`the axis '${stored}' has ${fault}`);
  }

  // What in the rule or the nodes is not as the format has it; empty where nothing is.
  fault() {
    const { nodes, rule } = this;
    const [rules, period] = RULES[this.name] ?? [["linear"], 0];
    const [first, last] = [nodes[0], nodes.at(-1)];
    if (!rules.includes(rule)) return `interpolation '${String(rule).slice(0, 40)}'; allowed: ${rules.join(" or ")}`;
    if (this.name === "source_elevation" && this.dark !== undefined && !(this.dark >= -90 && this.dark <= 0)) return `dark_below ${this.dark}; allowed: -90 to 0`;
    if (this.period !== period) return `period ${this.period}; allowed: ${period}`;
    if (!nodes.every((node, i) => Number.isFinite(node) && (i === 0 || node > nodes[i - 1]))) return "nodes that are not ascending numbers";
    const folded = rule === "linear_folded" && (first < 0 || last > period / 2);
    if (folded || (period && (last > first + period || (rule === "linear_periodic" && last === first + period)))) return "nodes beyond its period";
    if (this.name in CODES) {
      const known = COUNTS[this.name].includes(nodes.length) && nodes.every((node, i) => node === CODES[this.name][i]);
      return known ? "" : "codes that are not those of the format";
    }
    return rule === "exact" && (first < 1 || last > LAST_CODE) ? `codes beyond 1 to ${LAST_CODE}` : "";
  }

  // Index of the lower and the upper node, and the weight of the upper one.
  locate(given) {
    if (!Number.isFinite(given)) throw new SceneError(`${this.name}: found ${given}; allowed: finite numbers`);
    let value = given;
    let nodes = this.nodes;
    if (this.rule === "exact") {
      const at = nodes.indexOf(value);
      if (at < 0) throw new SceneError(`${this.name}: found ${value}; allowed: a code of the file`);
      return { lower: at, upper: at, weight: 0 };
    }
    if (this.rule === "linear_periodic") {
      nodes = [...nodes, nodes[0] + this.period];
      value = nodes[0] + modulo(value - nodes[0], this.period);
    } else if (this.rule === "linear" && this.period > 0) {
      value -= this.period * Math.floor((value - nodes[0]) / this.period);
    } else if (this.rule === "linear_folded") {
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

export class Database {
  constructor(path, filetypes, clamped) {
    Object.assign(this, { clamped, arrays: {}, codes: new Map(), ground: null });
    let content;
    try {
      if (!statSync(path).isFile()) throw new Error();
      content = readFileSync(path);
      // The library sees this file alone, in memory: no link and no storage in a file can reach another one.
      FS.writeFile("/database.h5", content);
      this.file = new h5wasm.File("/database.h5", "r");
    } catch {
      throw new SceneError(`${path}: is not a readable HDF5 file`);
    }
    this.bytes = PACKING * content.length + SMALL;
    try {
      this.read(filetypes);
    } catch (error) {
      // The library tells the whole story of an error in many lines.
      throw new SceneError(`${path}: ${error instanceof SceneError ? error.message : "is damaged: the HDF5 library cannot read it"}`);
    } finally {
      this.file.close();
      FS.unlink("/database.h5");
    }
  }

  read(filetypes) {
    const filetype = attribute(this.file, "filetype", "");
    const version = attribute(this.file, "format_version", "");
    const major = FORMATS[filetypes[0]];
    if (!filetypes.includes(filetype) || !version?.startsWith(major))
      throw new SceneError(`holds '${String(filetype).slice(0, 40)}' ${String(version).slice(0, 20)}; allowed: ${filetypes.join(" or ")} ${major}x`);
    this.stored = new Set(this.file.keys());
    this.filetype = filetype;
    for (const [name, [axes, least, most]] of Object.entries(this.layouts(filetypes[0]))) this.arrays[name] = this.array(name, axes, least, most);
    if (LIGHT in this.arrays) this.checkLight();
    if ("thermal_path_radiance_ratio" in this.arrays) {
      const unstated = Object.keys(WITHOUT_SOURCE).find((name) => name in this.arrays && this.arrays[name].axes[3].dark === undefined);
      if (unstated) throw new SceneError(`the source elevations of '${unstated}' do not state dark_below`);
    }
    if (filetype === "band") this.codes = this.names(this.arrays.reflectance.axes[0]);
  }

  // What the file must hold, by the first array of each part that may be absent.
  layouts(kind) {
    const has = (part) => this.stored.has(Object.keys(part)[0]);
    if (kind === "htt") return { ...ARRAYS.htt, ...(has(SHADE) ? SHADE : {}), ...(has(TRACKS) ? TRACKS : {}) };
    if (kind !== "atmq") return ARRAYS[kind];
    const lit = this.stored.has(LIGHT);
    const night = has(NIGHT) ? { ...NIGHT, ...(lit ? NIGHT_HARMONICS : {}) } : {};
    return { ...ARRAYS.atmq, ...(lit ? HARMONICS : {}), ...night };
  }

  // The harmonics go together, and the file states the ground.
  checkLight() {
    const [light, glow] = [LIGHT, GLOW].map((name) => this.arrays[name].axes[4].nodes.length);
    if ((light === 6) !== (glow === 3)) throw new SceneError(`'${LIGHT}' and '${GLOW}' are of different harmonics`);
    this.ground = GROUND.map((name) => attribute(this.file, name, NaN));
    if (!this.ground.every((value) => Number.isFinite(value) && value >= 0)) throw new SceneError(`does not state the ground: ${GROUND.join(", ")}`);
  }

  // An array of this very file, of a type class, a size in bytes, and so many axes.
  dataset(name, type, size, rank) {
    if (!this.stored.has(name)) throw new SceneError(`lacks '${name}'`);
    if (this.file.get_link(name) !== null) throw new SceneError(`'${name}' is a link to somewhere else`);
    const dataset = this.file.get(name);
    if (dataset?.type !== "Dataset") throw new SceneError(`'${name}' is not an array`);
    const { metadata } = dataset;
    if (metadata.virtual_sources) throw new SceneError(`'${name}' is kept in another file`);
    if (metadata.type !== type || metadata.size !== size || (type === TEXT && !metadata.vlen)) throw new SceneError(`'${name}' has values of another type`);
    const count = metadata.shape?.reduce((product, length) => product * length, 1) ?? 0;
    if (metadata.shape?.length !== rank || count < 1) throw new SceneError(`'${name}' has the shape ${metadata.shape}; allowed: ${rank} axes, none empty`);
    if (count * size > this.bytes) throw new SceneError(`'${name}' claims more bytes than the file can hold`);
    return dataset;
  }

  // Name of the quantity's own axis where the file has one, else of the one that quantities share; and the axis.
  axis(quantity, name) {
    const stored = this.stored.has(`${quantity}_${name}`) ? `${quantity}_${name}` : name;
    const codes = RULES[name]?.[0][0] === "exact";
    const dataset = codes ? this.dataset(stored, INTEGER, 4, 1) : this.dataset(stored, FLOAT, 8, 1);
    return [stored, new Axis(name, stored, dataset, this.clamped.includes(name))];
  }

  array(quantity, names, least, most) {
    const dataset = this.dataset(quantity, FLOAT, 4, names.length);
    const list = dataset.attrs.DIMENSION_LIST?.metadata;
    if (list?.type !== LIST || list.vlen_type?.type !== REFERENCE || list.shape?.length !== 1 || list.shape[0] !== names.length)
      throw new SceneError(`'${quantity}' has no dimension scales`);
    const axes = names.map((name, k) => {
      const byAngle = name === "source_azimuth" && this.stored.has("scattering_angle");
      const [stored, axis] = this.axis(quantity, byAngle ? "scattering_angle" : name);
      const length = dataset.shape[k];
      if (length !== axis.nodes.length) throw new SceneError(`'${quantity}' has ${length} values along '${stored}', which has ${axis.nodes.length} nodes`);
      if (dataset.get_attached_scales(k)[0] !== `/${stored}`) throw new SceneError(`'${quantity}' has other dimension scales than its axes`);
      return axis;
    });
    const values = Float32Array.from(dataset.value);
    if (!values.every((value) => Number.isFinite(value) && value >= least && value <= most))
      throw new SceneError(`'${quantity}' holds values beyond ${least} to ${most}`);
    return { axes, values };
  }

  // Codes of the materials by name.
  names(axis) {
    const names = Array.from(this.dataset("material_name", TEXT, 4, 1).value);
    const readable = names.every((name) => typeof name === "string" && name && !name.includes(UNREADABLE));
    if (!readable || names.length !== axis.nodes.length || new Set(names).size !== names.length)
      throw new SceneError("'material_name' does not hold a name for each code");
    return new Map(names.map((name, k) => [name, axis.nodes[k]]));
  }

  // A quantity at a place; below the lowest elevation of the source, its light fades into what the air emits.
  value(quantity, where) {
    if (quantity in WITHOUT_SOURCE && "thermal_path_radiance_ratio" in this.arrays) {
      const { nodes, dark } = this.arrays[quantity].axes[3];
      const [lowest, height] = [nodes[0], where.source_elevation];
      if (Number.isFinite(height) && height < lowest && (height <= dark || lowest <= CIVIL_TWILIGHT)) {
        const share = height > dark ? (height - dark) / (lowest - dark) : 0;
        const light = share * this.interpolated(quantity, { ...where, source_elevation: lowest });
        const emitted = WITHOUT_SOURCE[quantity];
        return emitted ? light + (1 - share) * this.interpolated(emitted, where) : light;
      }
    }
    return this.interpolated(quantity, where);
  }

  // Linear interpolation in every axis: the weighted sum over the corners of one cell.
  interpolated(quantity, where) {
    const { axes, values } = this.arrays[quantity];
    const located = axes.map((axis) => axis.locate(where[axis.name]));
    let total = 0;
    for (let corner = 0; corner < 1 << axes.length; corner++) {
      let share = 1;
      let index = 0;
      located.forEach((place, k) => {
        const up = (corner >> k) & 1;
        share *= up ? place.weight : 1 - place.weight;
        index = index * axes[k].nodes.length + (up ? place.upper : place.lower);
      });
      if (share) total += share * values[index];
    }
    return total;
  }

  // Code of a material given by code or by name.
  material(given) {
    if (typeof given !== "string") return given;
    if (!this.codes.has(given)) throw new SceneError(`material: found '${given}'; allowed: ${[...this.codes.keys()].join(", ").slice(0, 200)}`);
    return this.codes.get(given);
  }
}
