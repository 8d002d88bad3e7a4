// Reads one frame of `mat export --gpu`: the radiance of pixels from its textures, without HDF5.
// Usage: node gpu.js AIR.gpu.json BAND.gpu.json < PIXELS
// A line of PIXELS is a pixel: code of its material, temperature (K), range (km), then the unit vectors normal, to the
// source and to the observer (east, north, up). A line of the result is its radiance, its path radiance (W m^-2 sr^-1)
// and its apparent temperature (K). The steps are those of skyshine.glsl; schemas/formats/gpu-1.md describes the files.
import { readFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { pathToFileURL } from "node:url";

const CHANNELS = { R16F: 1, RGBA16F: 4, R32F: 1, RGBA32F: 4 };

function half(word) {
  const [sign, exponent, fraction] = [word & 0x8000 ? -1 : 1, (word >> 10) & 31, word & 1023];
  return exponent === 0 ? sign * fraction * 2 ** -24 : sign * (1 + fraction / 1024) * 2 ** (exponent - 15);
}

// A header with the numbers of its textures in `values`.
export function readGpu(path, kind) {
  const header = JSON.parse(readFileSync(path, "utf-8"));
  if (header.format !== "skyshine-gpu" || !header.format_version.startsWith("1.") || header.kind !== kind)
    throw new Error(`${path}: is no skyshine-gpu 1.x file of the kind '${kind}'`);
  const data = readFileSync(join(dirname(path), header.data));
  if (data.length !== header.bytes) throw new Error(`${path}: its data have ${data.length} bytes, not ${header.bytes}`);
  const values = {};
  for (const [name, { format, size, offset }] of Object.entries(header.textures)) {
    if (!(format in CHANNELS)) continue;
    const count = size[0] * size[1] * size[2] * CHANNELS[format];
    const single = format.endsWith("32F");
    values[name] = Float64Array.from({ length: count }, (_, k) => (single ? data.readFloatLE(offset + 4 * k) : half(data.readUInt16LE(offset + 2 * k))));
  }
  return { ...header, values };
}

// Lower node of a value clamped to an axis, the node above, and the weight of that one.
function cell(nodes, value) {
  if (nodes.length === 1) return [0, 0, 0];
  const bounded = Math.min(Math.max(value, nodes[0]), nodes.at(-1));
  let lower = 0;
  while (lower < nodes.length - 2 && nodes[lower + 1] <= bounded) lower++;
  return [lower, lower + 1, (bounded - nodes[lower]) / (nodes[lower + 1] - nodes[lower])];
}

const dot = (a, b) => a.reduce((total, value, k) => total + value * b[k], 0);
const cross = ([a, b, c], [d, e, f]) => [b * f - c * e, c * d - a * f, a * e - b * d];
const length = (vector) => Math.sqrt(dot(vector, vector));
const degrees = (angle) => (angle * 180) / Math.PI;
const limited = (value) => Math.min(Math.max(value, 0), 1);

export class GpuFrame {
  constructor(air, band) {
    const { numbers } = air;
    Object.assign(this, { air, band, numbers });
    if (Object.values(numbers.source_elevation).some((nodes) => nodes.length !== 1) || numbers.axes[2].length !== 1)
      throw new Error("is not the export of one frame");
    const [materials, temperatures] = [numbers.material.length, numbers.emission_temperature.length];
    const light = 1 + numbers.harmonic.length;
    const order = ["emission", "thermal_path", "path", "sky", "direct"];
    this.terms = order.flatMap((name) => [...air.values[name]]);
    const path = materials * temperatures;
    const sky = path + 1 + numbers.angle.length;
    this.rows = { path, sky, direct: sky + materials * light, temperatures, light };
  }

  // Share of the way and direction, or range and elevation, of a line of sight.
  place(range, sine) {
    if (this.numbers.coordinates !== "ray") return [range, degrees(Math.asin(sine))];
    const { ground_altitude_km: ground, scale_height_km: scale, height_root: roots, effective_radius: radii } = this.numbers;
    const height = Math.max(this.numbers.altitude_km[0] - ground, 0);
    const [lower, upper, weight] = cell(roots, Math.cbrt(height));
    const rho = radii[lower] * (1 - weight) + radii[upper] * weight;
    const radius = rho + height;
    const [rise, fall] = [radius * sine, height * (2 * rho + height)];
    const inside = rise * rise - fall;
    if (sine < 0 && inside >= 0) {
      const below = fall / (Math.sqrt(inside) - rise);
      const across = 2 * rho * height;
      return [below > 0 ? Math.min(range / below, 1) : 1, across > 0 ? limited(((below - height) * (below + height)) / across) : 0];
    }
    const above = scale * (2 * radius + scale);
    const [way, level] = [above / (rise + Math.sqrt(rise * rise + above)), Math.sqrt(above)];
    const share = -Math.expm1(-range / way);
    const drop = 2 * radius * Math.sin(Math.asin(sine) / 2) ** 2;
    return [share, sine < 0 ? 3 - Math.sqrt(limited(drop / Math.max(height, 1e-9))) : 3 + limited((level - way) / (level - scale))];
  }

  // Components of the air between the observer and a point.
  components(range, toObserver) {
    const [first, second] = this.place(range, Math.min(Math.max(-toObserver[2], -1), 1));
    const [axis, rows] = this.numbers.axes;
    const [left, right, across] = cell(axis, first);
    const [top, bottom, down] = cell(rows, second);
    const result = [];
    for (let group = 0; group < this.numbers.components / 4; group++) {
      const texels = this.air.values[`air${group}`];
      const at = (row, column, part) => texels[4 * (row * axis.length + column) + part];
      for (let part = 0; part < 4; part++) {
        const [upper, lower] = [top, bottom].map((row) => at(row, left, part) * (1 - across) + at(row, right, part) * across);
        result.push(upper * (1 - down) + lower * down);
      }
    }
    return result;
  }

  field(row, air) {
    return air.reduce((total, value, k) => total + value * this.terms[row * air.length + k], 0);
  }

  blackbody(temperature) {
    const { first_temperature: first, temperature_step: step, temperatures } = this.band.numbers;
    const place = Math.min(Math.max((temperature - first) / step, 0), temperatures - 1);
    const lower = Math.min(Math.floor(place), temperatures - 2);
    const [below, above] = [this.band.values.blackbody[lower], this.band.values.blackbody[lower + 1]];
    return below + (above - below) * (place - lower);
  }

  apparentTemperature(radiance) {
    const { first_temperature: first, temperature_step: step, temperatures } = this.band.numbers;
    const [lower, , weight] = cell([...this.band.values.blackbody.subarray(0, temperatures)], radiance);
    return first + step * (lower + weight);
  }

  path(air, { toSource, toObserver }) {
    const sight = toObserver.map((part) => -part);
    const turn = Math.atan2(sight[0] * toSource[1] - sight[1] * toSource[0], sight[0] * toSource[0] + sight[1] * toSource[1]);
    const between = Math.atan2(length(cross(sight, toSource)), dot(sight, toSource));
    const angle = degrees(this.numbers.angle_axis === "scattering_angle" ? between : Math.abs(turn));
    const [lower, upper, weight] = cell(this.numbers.angle, angle);
    const scattered = [lower, upper].map((k) => this.field(this.rows.path + 1 + k, air));
    return Math.max(this.field(this.rows.path, air), 0) + Math.max(scattered[0] * (1 - weight) + scattered[1] * weight, 0);
  }

  sky(air, material, { normal, toSource }) {
    const row = this.rows.sky + material * this.rows.light;
    const weights = lightWeights(normal, toSource, this.rows.light - 1);
    return Math.max(weights.reduce((total, weight, k) => total + weight * this.field(row + k, air), 0), 0);
  }

  // Radiance and path radiance of a pixel of one material.
  radiance({ code, temperature, range, normal, toSource, toObserver }) {
    const material = this.numbers.material.indexOf(code);
    if (material < 0) throw new Error(`the material ${code} is not in the export`);
    const [air, face] = [this.components(range, toObserver), { normal, toSource, toObserver }];
    const [lower, upper, weight] = cell(this.numbers.emission_temperature, temperature);
    const [below, above] = [lower, upper].map((k) => this.field(material * this.rows.temperatures + k, air));
    let total = (below * (1 - weight) + above * weight) * this.blackbody(temperature) + this.sky(air, material, face);
    const incidence = dot(normal, toSource);
    if (incidence > 0) {
      const beam = Math.max(this.field(this.rows.direct + material, air), 0);
      const [fraction, shininess, normalisation] = this.band.values.materials.subarray(4 * material, 4 * material + 3);
      const half = toSource.map((part, k) => part + toObserver[k]);
      const chi = length(half) > 0 ? limited(dot(half, normal) / length(half)) : 0;
      total += beam * (incidence * (1 - fraction) + chi ** shininess * fraction * normalisation);
    }
    const path = this.path(air, face);
    return [total + path, path];
  }
}

// Weights of the level value and of the harmonics in the ambient light of a face.
function lightWeights(normal, toSource, count) {
  if (count === 0) return [1];
  const across = Math.hypot(toSource[0], toSource[1]);
  const [east, north] = across > 0 ? [toSource[0] / across, toSource[1] / across] : [0, 1];
  const turned = [normal[0] * east + normal[1] * north, normal[0] * north - normal[1] * east, normal[2]];
  const square = normal[2] ** 2;
  const share = count === 6 ? ((35 * square - 30) * square + 3) / 8 : (((231 * square - 315) * square + 105) * square - 5) / 16;
  const [facing, upright] = [turned, [0, 0, 1]].map(irradianceHarmonics);
  return [share, ...facing.slice(0, count).map((value, k) => value - share * upright[k])];
}

// A_l / pi times Y_lm of a unit normal, in the order of the codes: schemas/formats/atmq-2.md.
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

function main([air, band]) {
  const frame = new GpuFrame(readGpu(air, "atmosphere"), readGpu(band, "band"));
  for (const line of readFileSync(0, "utf-8").trim().split("\n")) {
    const [code, temperature, range, ...v] = line.trim().split(/\s+/).map(Number);
    if (v.length !== 9 || ![code, temperature, range, ...v].every(Number.isFinite)) throw new Error("a pixel must be twelve numbers");
    const pixel = { code, temperature, range, normal: v.slice(0, 3), toSource: v.slice(3, 6), toObserver: v.slice(6) };
    const [radiance, path] = frame.radiance(pixel);
    console.log(`${radiance} ${path} ${frame.apparentTemperature(radiance)}`);
  }
}

if (process.argv[1] && import.meta.url === pathToFileURL(process.argv[1]).href) {
  try {
    main(process.argv.slice(2));
  } catch (error) {
    console.error(error.message);
    process.exitCode = 1;
  }
}
