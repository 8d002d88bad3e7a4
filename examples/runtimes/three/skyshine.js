// Textures and numbers of one frame of `mat export FOLDER --to gpu --hour HOUR --altitude KM`, as uniforms of three.js.
import * as THREE from "three";

const { RedFormat, RGBAFormat, HalfFloatType, FloatType } = THREE;
const FORMATS = {
  R16F: [Uint16Array, 1, RedFormat, HalfFloatType],
  RGBA16F: [Uint16Array, 4, RGBAFormat, HalfFloatType],
  R32F: [Float32Array, 1, RedFormat, FloatType],
  RGBA32F: [Float32Array, 4, RGBAFormat, FloatType],
};

async function opened(folder, name) {
  const answers = await Promise.all(["json", "bin"].map((end) => fetch(`${folder}/${name}.gpu.${end}`)));
  if (answers.some((answer) => !answer.ok)) throw new Error(`${folder}/${name}.gpu.json: is missing; write it with 'mat export --to gpu'`);
  const [header, bytes] = [await answers[0].json(), await answers[1].arrayBuffer()];
  const texels = (part) => {
    const { format, size, offset } = header.textures[part];
    const [Kind, channels] = FORMATS[format];
    return new Kind(bytes, offset, size[0] * size[1] * size[2] * channels);
  };
  return { ...header.numbers, sizeOf: (part) => header.textures[part].size, formatOf: (part) => header.textures[part].format, texels };
}

function texture(values, [width, height, depth], format, linear) {
  const made = linear ? new THREE.Data3DTexture(values, width, height, depth) : new THREE.DataTexture(values, width, height);
  [, , made.format, made.type] = FORMATS[format];
  made.minFilter = made.magFilter = linear ? THREE.LinearFilter : THREE.NearestFilter;
  made.needsUpdate = true;
  return made;
}

const stored = (file, part, linear = false) => texture(file.texels(part), file.sizeOf(part), file.formatOf(part), linear);

// Lower node of a value on an axis, and the weight of the node above.
function cell(nodes, value) {
  if (nodes.length === 1) return [0, 0];
  let lower = 0;
  while (lower < nodes.length - 2 && nodes[lower + 1] <= value) lower++;
  return [lower, Math.min(Math.max((value - nodes[lower]) / (nodes[lower + 1] - nodes[lower]), 0), 1)];
}

// Nodes of the axes, one a row, in the order of the include.
function nodes(air, surface) {
  const axes = [air.axes[0], air.axes[1], air.emission_temperature, air.angle, surface.azimuth, surface.slope, surface.altitude];
  const width = Math.max(...axes.map((axis) => axis.length));
  const values = new Float32Array(width * axes.length);
  axes.forEach((axis, row) => values.set(axis, row * width));
  return texture(values, [width, axes.length, 1], "R32F");
}

function terms(air) {
  const parts = ["emission", "thermal_path", "path", "sky", "direct"].map(air.texels);
  const values = new Float32Array(parts.reduce((total, part) => total + part.length, 0));
  parts.reduce((start, part) => (values.set(part, start), start + part.length), 0);
  return texture(values, [air.components / 4, values.length / air.components, 1], "RGBA32F");
}

// Height above the ground, effective radius, scale height (km), and the texture coordinate of the altitude.
function observer(air) {
  const height = air.altitude_km[0] - air.ground_altitude_km;
  const [below, weight] = cell(air.height_root, Math.cbrt(height));
  const above = Math.min(below + 1, air.height_root.length - 1);
  return [height, air.effective_radius[below] * (1 - weight) + air.effective_radius[above] * weight, air.scale_height_km, 0.5];
}

// Uniforms of the include for a state and a band; names of materials by row; direction to the source (east, north, up).
export async function loadFrame(folder, { state = "s01", band = "b02", source = "" } = {}) {
  const names = [`${state}${band}.${source}atmq`, `${band}.band`, `${state}.htt`];
  const [[air, glow, surface], include] = await Promise.all([
    Promise.all(names.map((name) => opened(folder, name))),
    fetch(`${folder}/skyshine.glsl`).then((answer) => answer.text()),
  ]);
  const groups = air.components / 4;
  const values = {
    skyshineNodes: nodes(air, surface),
    skyshineTerms: terms(air),
    skyshineBlackbody: stored(glow, "blackbody"),
    skyshineMaterials: stored(glow, "materials"),
    skyshineTemperatures: stored(surface, "temperature", true),
    skyshineReference: stored(surface, "reference"),
    skyshineSize: [...air.axes.map((axis) => axis.length), groups],
    skyshineCount: [air.material.length, air.emission_temperature.length, 1 + air.harmonic.length, air.angle.length],
    skyshineSurface: [surface.azimuth.length, surface.slope.length, surface.altitude.length, surface.azimuth_repeats ? 1 : 0],
    skyshineObserver: observer(air),
    skyshineBand: [glow.first_temperature, glow.temperature_step, glow.temperatures],
  };
  const parts = Array.from({ length: groups }, (_, k) => stored(air, `air${k}`, true));
  for (let k = 0; k < 4; k++) values[`skyshineAir${k}`] = parts[Math.min(k, groups - 1)];
  values.skyshineShadedChange = values.skyshineTemperatures; // this example draws no shade
  values.skyshineShaded = [1, 1];
  const uniforms = Object.fromEntries(Object.entries(values).map(([name, value]) => [name, { value }]));
  const [up, along] = [air.source_elevation.path[0], air.source_azimuth].map((angle) => (angle * Math.PI) / 180);
  const toSource = [Math.cos(up) * Math.sin(along), Math.cos(up) * Math.cos(along), Math.sin(up)];
  return { include, uniforms, materials: surface.material_name, ground: surface.altitude[0], height: 1000 * observer(air)[0], toSource, hour: air.hour, wavelength: air.wavelength_um };
}
