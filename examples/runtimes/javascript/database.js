// A database: the arrays of a file, handed to the library, which checks their values.
import { SkyshineError } from "./kernel.js";
import { FLOAT, INTEGER, Source } from "./source.js";

export const [SURFACE, BAND, AIR] = [0, 1, 2];
const FILETYPES = [["htt"], ["band"], ["atmq", "lunar_atmq"]];
const RULES = ["linear", "linear_periodic", "exact"]; // by the library's number
// Attributes of a file's root by the number that the library gives them, with how many numbers each has.
const NUMBERS = {
  ground_emissivity: [0, 1], ground_temperature: [1, 1], ground_radiance: [2, 1], ground_albedo: [3, 1],
  ground_altitude_km: [5, 1], scale_height_km: [6, 1], range_km: [7, 2], altitude_km: [9, 2],
};
const GROUND_CODE = 4;
const CLAMPS = { range: 11, altitude: 12, elevation: 13 }; // axes that no array has

export class Database {
  // Of the bytes of a file, which messages call by its path; values beyond the axes in `clamp` are read at the nearest node.
  constructor(kernel, kind, path, content, clamp) {
    Object.assign(this, { kernel, kind, path, clamp, memory: kernel.take(kernel.calls.skyshine_database_size()) });
    kernel.calls.skyshine_database_begin(this.memory, kind);
    Source.read(path, content, FILETYPES[kind], (source) => this.fill(source));
  }

  fill(source) {
    const { calls } = this.kernel;
    this.filetype = source.filetype;
    this.ground = source.text(source.file, "ground_material");
    const names = this.kernel.texts((array) => calls.skyshine_array_name(this.kind, array));
    names.forEach((name, array) => source.has(name) && this.fillArray(source, array, name));
    for (const [name, [first, count]] of Object.entries(NUMBERS))
      source.numbers(source.file, name, count).forEach((value, k) => calls.skyshine_set_number(this.memory, first + k, value));
    for (const [axis, number] of Object.entries(CLAMPS)) calls.skyshine_set_number(this.memory, number, Number(this.clamp.includes(axis)));
    const named = this.kind === BAND || (this.kind === SURFACE && source.has("material_name"));
    this.materials = named ? source.materials() : [];
    if (this.kind === SURFACE) this.setGround(this.materials);
  }

  // Say what the code of the ground's material is in a file of temperatures, where this file names one.
  setGround(materials) {
    if (!this.ground) return;
    const code = materials.find(({ name }) => name === this.ground)?.code ?? 0;
    this.kernel.calls.skyshine_set_number(this.memory, GROUND_CODE, code);
  }

  fillArray(source, array, name) {
    const { kernel, kind } = this;
    const axes = kernel.texts((axis) => kernel.calls.skyshine_axis_name(kind, array, axis));
    const dataset = source.dataset(name, FLOAT, 4, axes.length);
    source.checkScales(dataset, name, axes);
    axes.forEach((axis, k) => {
      const count = this.fillAxis(source, array, k, axis);
      if (count !== dataset.shape[k])
        throw new SkyshineError(`'${name}' has ${dataset.shape[k]} values along '${axis}', which has ${count} nodes`);
    });
    kernel.calls.skyshine_set_array(this.memory, array, kernel.put(Float32Array, this.sums(source, dataset, axes)));
  }

  // The values of an array, of which the file may have the differences along some axes.
  sums(source, dataset, axes) {
    if (!("differences" in dataset.attrs)) return dataset.value;
    const values = Float32Array.from(dataset.value);
    for (const axis of source.text(dataset, "differences").split(" ").map((name) => axes.indexOf(name))) {
      const stride = dataset.shape.slice(axis + 1).reduce((product, length) => product * length, 1);
      const block = stride * dataset.shape[axis];
      for (let i = 0; i < values.length; i++) if (i % block >= stride) values[i] += values[i - stride];
    }
    return values;
  }

  // Returns the number of nodes.
  fillAxis(source, array, axis, name) {
    const { kernel } = this;
    if (!source.has(name)) throw new SkyshineError(`lacks '${name}'`);
    const interpolation = source.text(source.file.get(name), "interpolation");
    const rule = RULES.indexOf(interpolation);
    if (rule < 0) throw new SkyshineError(`the axis '${name}' has interpolation '${interpolation}'; allowed: ${RULES.join(", ")}`);
    // Codes are integers of four bytes, other nodes floating-point numbers of eight.
    const stored = interpolation === "exact" ? source.dataset(name, INTEGER, 4, 1) : source.dataset(name, FLOAT, 8, 1);
    const policy = "out_of_range" in stored.attrs ? source.text(stored, "out_of_range") : "error";
    if (policy !== "error" && policy !== "clamp") throw new SkyshineError(`the axis '${name}' has out_of_range '${policy}'; allowed: error, clamp`);
    const clamps = policy === "clamp" || this.clamp.includes(name.replace(/^sky_/, ""));
    const [[period = 0], [darkBelow = NaN]] = ["period", "dark_below"].map((each) => source.numbers(stored, each));
    const nodes = Array.from(stored.value, Number);
    const at = kernel.put(Float64Array, nodes);
    kernel.calls.skyshine_set_axis(this.memory, array, axis, at, nodes.length, rule, period, darkBelow, Number(clamps));
    return nodes.length;
  }

  // Refuse what no file of the format has.
  check() {
    try {
      this.kernel.check("skyshine_database_check", "file", [this.memory]);
    } catch (error) {
      throw new SkyshineError(`${this.path}: ${error.message}`, "file");
    }
  }
}
