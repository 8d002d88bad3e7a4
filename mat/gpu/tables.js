// The textures of an export as numbers, and what the processor computes of them for a frame.
"use strict";

SKYSHINE.tables = (() => {
  const { files } = SKYSHINE;
  const KINDS = { R16F: [2, 1], RGBA16F: [2, 4], R32F: [4, 1], RGBA32F: [4, 4], R16UI: [2, 1], RGBA16UI: [2, 4], R8: [1, 1] };

  function bytesOf(file) {
    if (!file.bytes) {
      const text = atob(file.data);
      file.bytes = new Uint8Array(text.length);
      for (let k = 0; k < text.length; k++) file.bytes[k] = text.charCodeAt(k);
      file.data = null;
    }
    return file.bytes;
  }

  // Texels of a texture: 16-bit words, or single-precision numbers.
  function texels(name, part) {
    const entry = files[name].header.textures[part];
    const [size, channels] = KINDS[entry.format];
    const [width, height, depth] = entry.size;
    const count = width * height * depth * channels;
    const { buffer } = bytesOf(files[name]);
    return new { 1: Uint8Array, 2: Uint16Array, 4: Float32Array }[size](buffer, entry.offset, count);
  }

  const numbers = (name) => files[name].header.numbers;

  function halfToFloat(word) {
    const [sign, exponent, fraction] = [word & 0x8000 ? -1 : 1, (word >> 10) & 31, word & 1023];
    if (exponent === 0) return sign * fraction * 2 ** -24;
    return sign * (1 + fraction / 1024) * 2 ** (exponent - 15);
  }

  // Lower node of a value clamped to an axis, the node above, and the weight of that one.
  function cell(nodes, value) {
    if (nodes.length === 1) return [0, 0, 0];
    const bounded = Math.min(Math.max(value, nodes[0]), nodes[nodes.length - 1]);
    let lower = 0;
    while (lower < nodes.length - 2 && nodes[lower + 1] <= bounded) lower++;
    return [lower, lower + 1, (bounded - nodes[lower]) / (nodes[lower + 1] - nodes[lower])];
  }

  // Part of an array along its first axis, mixed of two neighbours.
  function mixed(values, count, [lower, upper, weight]) {
    const size = values.length / count;
    const result = new Float32Array(size);
    for (let k = 0; k < size; k++) result[k] = values[lower * size + k] * (1 - weight) + values[upper * size + k] * weight;
    return result;
  }

  // Where the source stands: elevation and azimuth from north eastward, degree.
  function track(surface, source, hour) {
    const { track_time: nodes } = numbers(surface);
    const place = cell(nodes, hour);
    const angles = mixed(texels(surface, "tracks"), nodes.length, place);
    return source === "sun" ? [angles[0], angles[1]] : [angles[2], angles[3]];
  }

  // Add what the ground emits at an hour to the light of the sky, by material, level value and harmonic.
  function addGround(name, sky, hour) {
    const own = numbers(name);
    const turned = hour - 24 * Math.floor((hour - own.ground_time[0]) / 24);
    const [lower, upper, weight] = cell(own.ground_time, turned);
    const [kelvin, radiance] = [own.ground_temperature, own.ground_radiance].map((values) => values[lower] * (1 - weight) + values[upper] * weight);
    const ground = mixed(texels(name, "ground"), own.ground_node.length, cell(own.ground_node, kelvin));
    const [count, terms] = [own.components, 1 + own.harmonic.length];
    own.material.forEach((_, m) =>
      own.zonal_harmonic.forEach((code, z) => {
        const to = (m * terms + 1 + own.harmonic.indexOf(code)) * count;
        const from = (m * own.zonal_harmonic.length + z) * count;
        for (let k = 0; k < count; k++) sky[to + k] += radiance * ground[from + k];
      }),
    );
  }

  // Coefficients of one source elevation and, of the ground, one hour, in the order of the rows that the shader reads.
  function termsOf(name, elevation, hour) {
    const own = numbers(name);
    const below = elevation < own.lowest_source_elevation;
    if (below && !own.fades && elevation > own.dark_below)
      throw new Error(`No table for a source at ${elevation.toFixed(1)} degree; it begins at ${own.lowest_source_elevation}.`);
    if (elevation > own.highest_source_elevation)
      throw new Error(`No table for a source at ${elevation.toFixed(1)} degree; it ends at ${own.highest_source_elevation}.`);
    const parts = [texels(name, "emission"), texels(name, "thermal_path")];
    for (const term of ["path", "sky", "direct"]) {
      const nodes = own.source_elevation[term];
      parts.push(mixed(texels(name, term), nodes.length, cell(nodes, elevation)));
    }
    if (own.ground_node) addGround(name, parts[3], hour);
    const values = new Float32Array(parts.reduce((total, part) => total + part.length, 0));
    parts.reduce((start, part) => (values.set(part, start), start + part.length), 0);
    return values;
  }

  // Height above the ground, effective radius, scale height, and the texture coordinate of the altitude.
  function observerOf(air, altitude) {
    const own = numbers(air);
    const layers = own.axes[2];
    const height = Math.max(altitude - own.ground_altitude_km, 0);
    const root = Math.cbrt(height);
    const [below, above, weight] = cell(own.height_root, root);
    const radius = own.effective_radius[below] * (1 - weight) + own.effective_radius[above] * weight;
    const [lower, , part] = cell(layers, root);
    return [height, radius, own.scale_height_km, (lower + part + 0.5) / layers.length];
  }

  return { texels, numbers, halfToFloat, cell, mixed, track, termsOf, observerOf };
})();
