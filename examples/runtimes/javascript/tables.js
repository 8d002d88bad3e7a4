// The tables of a state, a band and a source: opened, and read at one place or for many pixels.
import { AIR, BAND, Database, SURFACE } from "./database.js";
import { Kernel, kernelModule, SkyshineError } from "./kernel.js";
import { contentOf, ready } from "./source.js";
import { Texture } from "./texture.js";

export const SHADED_SKY = 0.5; // open share of the sky above what a texture shows in the shade, where a scene says nothing else
const [STEPS, DAY_H] = [288, 24]; // of a day
const BETA_FACTOR = 5.5;
const [BETA_STAR, PATH_RATIO, DIRECT] = [0, 1, 4]; // quantities, by the library's number
// Lists of a call for pixels, in the library's order, and those of them that are codes.
const LISTS = [
  "material", "share", "temperature", "surfaceAltitude", "surfaceAzimuth", "surfaceSlope", "time", "range", "centreRange", "altitude",
  "centreElevation", "sourceElevation", "sourceAzimuth", "sourceHeading", "normal", "toSource", "toObserver", "elevation", "heading", "lit",
  "skyView", "wallTemperature", "shade", "shadedSky", "shadedTemperature", "groundMaterial", "groundTemperature",
];
const CODES = new Set(["material", "groundMaterial"]);
const TERMS = [
  "temperature", "blackbodyRadiance", "betaStar", "transmittance", "thermal", "path", "skyshine", "diffuse", "specular", "radiance",
];

export async function openFiles({ surface, band, atmosphere }, clamp = []) {
  await ready();
  const kernel = new Kernel(await kernelModule());
  const open = async (given, kind, name) => new Database(kernel, kind, ...(await contentOf(given, name)), clamp);
  const opened = [await open(surface, SURFACE, "surface"), await open(band, BAND, "band")];
  return new Tables(kernel, ...opened, await open(atmosphere, AIR, "atmosphere"));
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

// Share in the shade of each step of the day.
function shadedSteps(shade) {
  if (!shade.flat().every(Number.isFinite)) throw new SkyshineError("surroundings must be finite numbers");
  const step = DAY_H / STEPS;
  return Array.from({ length: STEPS }, (_, k) => {
    const hour = (k * DAY_H) / STEPS;
    const [first, last] = [hour - step / 2, hour + step / 2];
    const covered = shade.flatMap(([begin, given]) => {
      const end = given < begin ? given + DAY_H : given;
      return [-DAY_H, 0, DAY_H].map((turn) => Math.max(Math.min(last, end + turn) - Math.max(first, begin + turn), 0));
    });
    return Math.min(covered.reduce((total, hours) => total + hours, 0) / step, 1);
  });
}

export class Tables {
  constructor(kernel, surface, band, air) {
    Object.assign(this, { kernel, surface, band, air });
    air.setGround(surface.materials);
    kernel.ground = air.ground;
    const all = [surface, band, air];
    all.forEach((database) => database.check());
    const places = all.map(({ memory }) => memory);
    this.memory = kernel.take(kernel.calls.skyshine_tables_size(...places));
    try {
      kernel.check("skyshine_tables_make", "file", [this.memory, ...places]);
    } catch (error) {
      throw new SkyshineError(`${band.path}: ${error.message}`, "file");
    }
    this.scratch = kernel.take(kernel.calls.skyshine_scratch_size(this.memory));
  }

  materials() {
    return this.band.materials;
  }

  // The one value that a call of the library writes; `given` makes its arguments from the address of that value.
  one(name, given) {
    return this.kernel.within(() => {
      const to = this.kernel.take(8);
      this.kernel.check(name, "value", [this.memory, ...given(to)]);
      return this.kernel.view(Float64Array, to, 1)[0];
    });
  }

  // Address of a structure of addresses of lists.
  structure(lists, codes = new Set()) {
    const addresses = Object.entries(lists).map(([name, list]) => this.kernel.put(codes.has(name) ? Int32Array : Float64Array, list));
    return this.kernel.put(Uint32Array, addresses);
  }

  faces({ material, altitude, azimuth, slope }) {
    return this.structure({ material: [material], altitude: [altitude], azimuth: [azimuth], slope: [slope] }, CODES);
  }

  temperature(face) {
    return this.one("skyshine_temperatures", (to) => [1, this.faces(face), this.kernel.put(Float64Array, [face.time]), to]);
  }

  shadedTemperature(face, { shade = [], skyView = 1, facing, facingEmissivity } = {}) {
    const { kernel } = this;
    const absorbed = kernel.within(() => {
      const [shaded, heat] = [kernel.put(Float64Array, shadedSteps(shade)), kernel.take(8 * STEPS)];
      const others = [[skyView], facing ?? null, facingEmissivity ?? null].map((each) => kernel.put(Float64Array, each === null ? null : [each].flat()));
      const around = kernel.put(Uint32Array, [shaded, ...others]);
      kernel.check("skyshine_absorbed", "value", [this.memory, 1, this.faces(face), around, 1, heat, this.scratch]);
      return Array.from(kernel.view(Float64Array, heat, STEPS));
    });
    return this.heatedTemperature(face, absorbed);
  }

  heatedTemperature(face, absorbed) {
    if (!absorbed.length) throw new SkyshineError("absorbed_change must be a list of finite numbers");
    const put = (values) => this.kernel.put(Float64Array, values);
    return this.one("skyshine_heated", (to) => [1, this.faces(face), put(absorbed), absorbed.length, put([face.time]), 1, to, this.scratch]);
  }

  places({ range, altitude, elevation, sourceElevation, sourceAzimuth }) {
    return this.structure({ range: [range], altitude: [altitude], elevation: [elevation], sourceElevation: [sourceElevation], last: [sourceAzimuth] });
  }

  quantity(number, line) {
    return this.one("skyshine_quantity", (to) => [number, 0, 1, this.places(line), to, this.scratch]);
  }

  transmittance(line) {
    return Math.exp((-BETA_FACTOR * line.range) / this.quantity(BETA_STAR, line));
  }

  pathRadiance(line) {
    return this.quantity(PATH_RATIO, line) * -Math.expm1((-BETA_FACTOR * line.range) / this.quantity(BETA_STAR, line));
  }

  ambientRadiance(line, { slope = 0, azimuth = 0 } = {}) {
    const put = (value) => this.kernel.put(Float64Array, [value]);
    return this.one("skyshine_ambient", (to) => [0, 1, this.places(line), put(slope), put(azimuth), 0, to, this.scratch]);
  }

  directRadiance(line) {
    return this.quantity(DIRECT, line);
  }

  apparentTemperature(radiance) {
    return this.one("skyshine_apparent_temperatures", (to) => [1, this.kernel.put(Float64Array, [radiance]), to]);
  }

  sourcePosition(time) {
    const { kernel } = this;
    const source = this.air.filetype === "lunar_atmq" ? "moon" : "sun";
    const names = kernel.texts((array) => kernel.calls.skyshine_array_name(SURFACE, array));
    const read = (angle) => {
      const array = names.indexOf(`${source}_${angle}`);
      return this.one("skyshine_read", (to) => [SURFACE, array, 1, kernel.put(Float64Array, [time]), to]);
    };
    return { elevation: read("elevation"), heading: read("azimuth") };
  }

  // Terms of pixels by name: of lists of `count` values, one line of sight, and so many materials a pixel.
  terms(count, materials, given, wanted) {
    const { kernel } = this;
    return kernel.within(() => {
      const lists = this.structure(Object.fromEntries(LISTS.map((name) => [name, given[name]])), CODES);
      const to = TERMS.map((name) => (wanted.includes(name) ? kernel.take(8 * count) : 0));
      const terms = kernel.put(Uint32Array, to);
      kernel.check("skyshine_pixel_terms", "value", [this.memory, count, materials, 1, lists, terms, this.scratch], count > 1);
      return wanted.map((name) => kernel.view(Float64Array, to[TERMS.indexOf(name)], count));
    });
  }

  pixelRadiance(pixel) {
    const { materials, groundMaterial, normal, toSource, toObserver, ...numbers } = pixel;
    if (!materials.length) throw new SkyshineError("found a pixel without material; allowed: codes of the tables");
    const of = (name) => (materials.some((each) => each[name] !== undefined) ? materials.map((each) => each[name] ?? NaN) : undefined);
    const lists = Object.fromEntries(Object.entries(numbers).map(([name, value]) => [name, value === undefined ? undefined : [value]]));
    const given = {
      ...lists, normal, toSource, toObserver, material: of("code"), share: of("share"), temperature: of("temperature"),
      shadedTemperature: of("shadedTemperature"), groundMaterial: groundMaterial === undefined ? undefined : [groundMaterial],
    };
    return Object.fromEntries(this.terms(1, materials.length, given, TERMS).map(([value], k) => [TERMS[k], value]));
  }

  pixelValue(radiance, { bits, gain, bufferGain = 1, offset = 0 }) {
    return Number(this.kernel.calls.skyshine_value_of_pixel(radiance, bits, gain, bufferGain, offset));
  }

  frameRadiance(view, pixels, to = new Float64Array(pixels.material.length)) {
    const count = pixels.material.length;
    const unlike = Object.entries(pixels).find(([, list]) => list !== undefined && list.length !== count);
    if (unlike) throw new SkyshineError(`'${unlike[0]}' has ${unlike[1].length} values; allowed: ${count}, one for each pixel`);
    const { centreHeading, groundMaterial, groundAltitude = 0, time, ...line } = view;
    const all = (value) => new Float64Array(count).fill(value);
    const ground = { material: groundMaterial, altitude: groundAltitude, azimuth: 0, slope: 0, time };
    const [radiance] = this.terms(count, 1, {
      elevation: all(view.centreElevation), heading: all(centreHeading), ...pixels, time: all(time),
      ...Object.fromEntries(Object.entries(line).map(([name, value]) => [name, [value]])),
      sourceAzimuth: [view.sourceHeading - centreHeading],
      groundTemperature: groundMaterial === undefined ? undefined : all(this.temperature(ground)),
    }, ["radiance"]);
    to.set(radiance);
    return to;
  }
}
