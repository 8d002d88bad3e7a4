// Many pixels of one observer, one source and one time: what they share is resolved once.
import { SkyshineError } from "./axis.js";
import { ambientWeights, bases, hasFourthDegree, normalOf } from "./light.js";
import { placeOf } from "./line.js";

// Panels of the lattice of ranges: in each octave of range + NEAREST equally many of equal length, each with a cubic.
const [IN_OCTAVE, OCTAVES] = [16, 22];
const PANELS = IN_OCTAVE * OCTAVES;
const [NEAREST, FARTHEST] = [1 / 1024, 4095]; // km
const [BASES, CUBIC, CELLS_LIMIT] = [12, 4, 65536];
const RADIAN = Math.PI / 180;
const EDGES = Float64Array.from({ length: PANELS + 1 }, (_, k) => NEAREST * 2 ** Math.floor(k / IN_OCTAVE) * (1 + (k % IN_OCTAVE) / IN_OCTAVE));

// An axis whose cells are found by one division and few comparisons. A periodic one has its first node again at its end; one of a
// single node has a second one, at which the same values stand.
class Grid {
  constructor(axis) {
    const closed = axis.rule === "linear_periodic";
    const [first, count] = [axis.nodes[0], axis.nodes.length];
    const extra = closed ? [first + axis.period] : count === 1 ? [first + 1] : [];
    const nodes = Float64Array.from([...axis.nodes, ...extra]);
    const length = nodes.at(-1) - first;
    const shortest = nodes.reduce((least, node, k) => (k ? Math.min(least, node - nodes[k - 1]) : least), length);
    const parts = Math.min(Math.ceil((2 * length) / shortest), CELLS_LIMIT);
    Object.assign(this, { name: axis.name, nodes, first, last: closed ? nodes.at(-1) : axis.nodes[count - 1], clamps: axis.clamps });
    Object.assign(this, { period: closed ? axis.period : 0, scale: parts / length, cell: new Int32Array(parts + 1), lower: 0, weight: 0 });
    for (let part = 0, at = 0; part <= parts; part++) {
      // One part earlier, for the division that finds the part may round.
      while (at + 2 < nodes.length && nodes[at + 1] <= first + (part - 1) / this.scale) at++;
      this.cell[part] = at;
    }
  }

  // Set `lower` node and `weight` of the upper one.
  locate(given, pixel) {
    const { nodes, first, last, period } = this;
    let value = period > 0 ? given - period * Math.floor((given - first) / period) : given;
    if (!Number.isFinite(value) || !(this.clamps || (value >= first && value <= last)))
      throw new SkyshineError(`pixel ${pixel}: ${this.name}: found ${given}; allowed: ${first} to ${last}`);
    value = Math.min(Math.max(value, first), last);
    let lower = this.cell[Math.floor((value - first) * this.scale)];
    while (lower + 2 < nodes.length && value >= nodes[lower + 1]) lower++;
    this.lower = lower;
    this.weight = (value - nodes[lower]) / (nodes[lower + 1] - nodes[lower]);
  }
}

// Sum over wavelengths of weight times e^(-extinction range), as cubics of the place in each panel, written from `from` on.
function writeCubics(weight, extinction, to, from, stride) {
  for (let panel = 0; panel < PANELS; panel++) {
    const [begin, length] = [EDGES[panel], EDGES[panel + 1] - EDGES[panel]];
    const [low, rise, high, fall] = [0, 1].flatMap((end) => {
      let [value, slope] = [0, 0];
      weight.forEach((each, b) => {
        const part = each * Math.exp(-extinction[b] * (begin - NEAREST + end * length));
        value += part;
        slope -= part * extinction[b] * length;
      });
      return [value, slope];
    });
    to.set([low, rise, 3 * (high - low) - 2 * rise - fall, 2 * (low - high) + rise + fall], from + panel * stride);
  }
}

// Whether light may fall below 0, or near it, in some direction of a face.
function mayBeBounded(weights, level, fourthDegree) {
  if (level) return weights[0] < 0;
  let [least, most] = [Infinity, 0];
  for (let tilt = 0; tilt <= 180; tilt += 6)
    for (let turn = 0; turn <= 180; turn += 6) {
      const at = bases(fourthDegree, normalOf(tilt, turn));
      const light = weights.reduce((all, weight, k) => all + weight * at[k], 0);
      [least, most] = [Math.min(least, light), Math.max(most, Math.abs(light))];
    }
  return least < 0.02 * most;
}

// Temperatures of a material at a time, with the nodes that grids have beyond those of the axes.
function temperaturesOf(tables, material, time, grids) {
  const { axes } = tables.surface.arrays.temperature;
  const [rows, columns, slopes] = grids.map(({ nodes }) => nodes.length);
  const node = (k, i) => axes[k].nodes[i % axes[k].nodes.length];
  return Float64Array.from({ length: rows * columns * slopes }, (_, at) => {
    const [altitude, azimuth, slope] = [node(1, Math.floor(at / (columns * slopes))), node(2, Math.floor(at / slopes) % columns), node(3, at % slopes)];
    return tables.temperature({ material, altitude, azimuth, slope, time });
  });
}

export class Frame {
  constructor(tables, view) {
    const { air, band, surface } = tables;
    const line = { range: view.centreRange, altitude: view.altitude, elevation: view.centreElevation, sourceElevation: view.sourceElevation };
    const centre = placeOf({ ...line, sourceAzimuth: view.sourceHeading - view.centreHeading });
    if (!Number.isFinite(centre.source_azimuth)) throw new SkyshineError("heading: found a value that is not finite; allowed: finite numbers");
    const ground = tables.groundOf(view.groundMaterial, view.groundAltitude, view.time);
    const byBasis = ambientWeights(air, centre, ground, true);
    const weights = byBasis[0].map((_, b) => byBasis.map((weight) => weight[b]));
    this.level = !ground;
    this.fourthDegree = Boolean(ground) && hasFourthDegree(air);
    this.view = view;
    this.pathRatio = air.value("path_radiance_ratio", centre);
    this.extinction = 5.5 / air.value("beta_star", centre);
    [this.sine, this.cosine] = [Math.sin(view.sourceElevation * RADIAN), Math.cos(view.sourceElevation * RADIAN)];
    // Wavelengths at which light may fall below 0, where it is bounded.
    const limited = weights.map((weight) => mayBeBounded(weight, this.level, this.fourthDegree));
    this.bounded = weights.filter((_, b) => limited[b]);
    const { axes } = surface.arrays.temperature;
    [this.altitude, this.azimuth, this.slope] = axes.slice(1, 4).map((axis) => new Grid(axis));
    this.kelvin = new Grid(band.arrays.blackbody_radiance.axes[0]);
    this.blackbody = Float64Array.from(this.kelvin.nodes, (_, k) => band.arrays.blackbody_radiance.values[k % band.arrays.blackbody_radiance.values.length]);
    const undivided = { name: "planck_temperature", rule: "linear", nodes: [1], period: 0, clamps: true };
    this.planck = new Grid(air.parted ? band.arrays.emission_share.axes[0] : undivided);
    const light = { weights, limited, beam: air.light("direct_radiance", centre), extinction: air.extinction(centre) };
    this.materials = new Map(tables.materials().map(({ code }, m) => [code, this.material(tables, code, m, light)]));
  }

  material(tables, code, m, { weights, limited, beam, extinction }) {
    const { arrays } = tables.band;
    const parts = beam.length;
    const nodes = this.planck.nodes.length;
    const shares = tables.air.parted ? arrays.emission_share : null;
    const rho = Array.from(arrays[shares ? "reflectance_spectrum" : "reflectance"].values.subarray(m * parts, (m + 1) * parts));
    const emission = new Float64Array(PANELS * nodes * CUBIC);
    for (let n = 0; n < nodes; n++) {
      const row = shares ? (n % shares.axes[0].nodes.length) * parts : 0;
      const weight = rho.map((reflected, b) => (1 - reflected) * (shares ? shares.values[row + b] : 1));
      writeCubics(weight, extinction, emission, n * CUBIC, nodes * CUBIC);
    }
    const sky = new Float64Array(BASES);
    weights.forEach((weight, b) => limited[b] || weight.forEach((value, k) => (sky[k] += rho[b] * value)));
    const direct = Math.max(rho.reduce((all, reflected, b) => all + reflected * beam[b], 0), 0);
    const fraction = arrays.specular_fraction.values[m];
    const known = tables.surface.arrays.temperature.axes[0].nodes.includes(code);
    return {
      emission, sky,
      bounded: rho.filter((_, b) => limited[b]),
      diffuse: direct * (1 - fraction),
      specular: direct * fraction * arrays.normalisation.values[m],
      shininess: arrays.shininess.values[m],
      temperature: known ? temperaturesOf(tables, code, this.view.time, [this.altitude, this.azimuth, this.slope]) : null,
    };
  }

  radiance(pixels, to = new Float64Array(pixels.material.length)) {
    const lists = [pixels.range, pixels.surfaceAzimuth, pixels.surfaceSlope, pixels.temperature ?? pixels.surfaceAltitude];
    if (pixels.elevation) lists.push(pixels.elevation, pixels.heading);
    if (lists.some((list) => list?.length !== pixels.material.length) || to.length !== pixels.material.length)
      throw new SkyshineError("the lists of a frame must have a value for each pixel");
    const { materials, planck, kelvin, view, cosine, sine, extinction, pathRatio } = this;
    const width = planck.nodes.length * CUBIC;
    for (let i = 0; i < to.length; i++) {
      const material = materials.get(pixels.material[i]);
      const range = pixels.range[i];
      if (!material) throw new SkyshineError(`pixel ${i}: material: found ${pixels.material[i]}; allowed: a code of the file`);
      if (!(range >= 0 && range <= FARTHEST)) throw new SkyshineError(`pixel ${i}: range: found ${range}; allowed: 0 to ${FARTHEST}`);
      const temperature = pixels.temperature ? pixels.temperature[i] : this.temperature(material, pixels, i);
      kelvin.locate(temperature, i);
      const blackbody = this.blackbody[kelvin.lower] + kelvin.weight * (this.blackbody[kelvin.lower + 1] - this.blackbody[kelvin.lower]);
      planck.locate(temperature, i);
      const tilt = pixels.surfaceSlope[i] * RADIAN;
      const turn = (pixels.surfaceAzimuth[i] - view.sourceHeading) * RADIAN;
      const across = Math.sin(tilt);
      const [x, y, z] = [across * Math.cos(turn), across * Math.sin(turn), Math.cos(tilt)];
      const incidence = cosine * x + sine * z;
      const lobe = incidence > 0 && material.specular ? this.lobe(material, pixels, i, x, y, z) : 0;
      const beam = incidence > 0 ? incidence * material.diffuse + lobe : 0;
      const tau = Math.exp(-extinction * range);
      const emitted = blackbody * this.emitted(material.emission, range, width);
      to[i] = emitted + (this.sky(material, x, y, z) + beam) * tau + pathRatio * (1 - tau);
    }
    return to;
  }

  // Share of a black body that comes through the air.
  emitted(emission, range, width) {
    const far = range + NEAREST;
    let octave = Math.floor(Math.log2(far / NEAREST));
    if (EDGES[octave * IN_OCTAVE] > far) octave--; // the logarithm rounds
    if (octave + 1 < OCTAVES && EDGES[(octave + 1) * IN_OCTAVE] <= far) octave++;
    const place = (far / EDGES[octave * IN_OCTAVE] - 1) * IN_OCTAVE;
    const inside = Math.min(Math.floor(place), IN_OCTAVE - 1);
    const [t, at] = [place - inside, (octave * IN_OCTAVE + inside) * width + this.planck.lower * CUBIC];
    const cold = emission[at] + t * (emission[at + 1] + t * (emission[at + 2] + t * emission[at + 3]));
    const warm = emission[at + 4] + t * (emission[at + 5] + t * (emission[at + 6] + t * emission[at + 7]));
    return cold + this.planck.weight * (warm - cold);
  }

  temperature(material, pixels, i) {
    const { altitude, azimuth, slope } = this;
    const values = material.temperature;
    if (!values) throw new SkyshineError(`pixel ${i}: the surface file lacks the material`);
    altitude.locate(pixels.surfaceAltitude[i], i);
    azimuth.locate(pixels.surfaceAzimuth[i], i);
    slope.locate(pixels.surfaceSlope[i], i);
    const row = slope.nodes.length;
    const plane = row * azimuth.nodes.length;
    const from = altitude.lower * plane + azimuth.lower * row + slope.lower;
    const [v, w] = [azimuth.weight, slope.weight];
    const a = values[from] + w * (values[from + 1] - values[from]);
    const b = values[from + row] + w * (values[from + row + 1] - values[from + row]);
    const c = values[from + plane] + w * (values[from + plane + 1] - values[from + plane]);
    const d = values[from + plane + row] + w * (values[from + plane + row + 1] - values[from + plane + row]);
    const lower = a + v * (b - a);
    return lower + altitude.weight * (c + v * (d - c) - lower);
  }

  // Reflected light of the sky.
  sky({ sky, bounded }, x, y, z) {
    if (this.level && !this.bounded.length) return Math.max(sky[0], 0);
    if (this.fourthDegree || this.bounded.length || this.level) {
      const at = this.level ? [1] : bases(this.fourthDegree, [x, y, z]);
      const sum = (weights) => at.reduce((all, value, k) => all + value * (weights[k] ?? 0), 0);
      return Math.max(this.bounded.reduce((all, weights, b) => all + bounded[b] * Math.max(sum(weights), 0), sum(sky)), 0);
    }
    const square = z * z;
    let light = (((35 * square - 30) * square + 3) / 8) * sky[0] + 0.28209479177387814 * sky[1];
    light += 0.32573500793527993 * (z * sky[2] + x * sky[3]) + 0.07884789131313001 * (3 * square - 1) * sky[4];
    return Math.max(light + 0.2731371076480198 * x * z * sky[5] + 0.1365685538240099 * (x * x - y * y) * sky[6], 0);
  }

  // The beam in the direction of the observer, (35).
  lobe({ specular, shininess }, pixels, i, nx, ny, nz) {
    const elevation = (pixels.elevation ? pixels.elevation[i] : this.view.centreElevation) * RADIAN;
    const turn = ((pixels.elevation ? pixels.heading[i] : this.view.centreHeading) - this.view.sourceHeading) * RADIAN;
    const level = Math.cos(elevation);
    const [x, y, z] = [this.cosine - level * Math.cos(turn), -level * Math.sin(turn), this.sine - Math.sin(elevation)];
    const length = Math.sqrt(x * x + y * y + z * z);
    const chi = length > 0 ? Math.min(Math.max((x * nx + y * ny + z * nz) / length, 0), 1) : 0;
    return chi ** shininess * specular;
  }
}
