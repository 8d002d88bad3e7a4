// Temperatures in the shade, beside a wall or under other heat: the formulas of schemas/formats/htt-1.md.
import { SkyshineError } from "./axis.js";
import { Film } from "./film.js";

const [STEPS, CORRECTIONS, DAY] = [288, 8, 24];
const STEFAN_BOLTZMANN = 5.670374419e-8;
export const WALL_EMISSIVITY = 0.95; // of masonry, concrete and foliage in the thermal infrared
const MELTING_RANGE = 0.01; // K below its melting point in which a surface counts as melting
const HOURS = Array.from({ length: STEPS }, (_, k) => (k * DAY) / STEPS);

const radians = (angle) => (angle * Math.PI) / 180;

// A function that gives the integral of step means, from the beginning of the first step to an hour of any day.
function integralOf(values) {
  const sums = [0];
  for (const value of values) sums.push(sums.at(-1) + value);
  const steps = values.length;
  return (hour) => {
    let place = (hour * steps) / DAY + 0.5;
    const day = Math.floor(place / steps);
    place -= day * steps;
    const before = Math.min(Math.floor(place), steps - 1);
    return ((sums[before] + (place - before) * values[before] + day * sums[steps]) * DAY) / steps;
  };
}

// Means over the steps of the day of values that are means over other equal steps.
function stepMeans(values) {
  if (values.length === STEPS) return values;
  const integral = integralOf(values);
  return HOURS.map((hour) => ((integral(hour + DAY / STEPS / 2) - integral(hour - DAY / STEPS / 2)) * STEPS) / DAY);
}

// Cell of the nodes in which a point lies, or that next to it.
function cell(nodes, at) {
  let lower = 0;
  while (lower < nodes.length - 2 && nodes[lower + 1] <= at) lower++;
  return lower;
}

// Value at a point, linear between nodes and beyond their ends.
function read(nodes, values, at) {
  const lower = cell(nodes, at);
  return values[lower] + ((at - nodes[lower]) * (values[lower + 1] - values[lower])) / (nodes[lower + 1] - nodes[lower]);
}

// Slope of what `read` reads.
function rise(nodes, values, at) {
  const lower = cell(nodes, at);
  return (values[lower + 1] - values[lower]) / (nodes[lower + 1] - nodes[lower]);
}

// Point at which ascending values are a wanted one.
function inverse(nodes, values, wanted) {
  const lower = Math.min(Math.max(values.filter((value) => value <= wanted).length - 1, 0), nodes.length - 2);
  const rise = values[lower + 1] - values[lower];
  return nodes[lower] + (rise > 0 ? (wanted - values[lower]) / rise : 0) * (nodes[lower + 1] - nodes[lower]);
}

const within = (axis, value) => Math.min(Math.max(value, axis.nodes[0]), axis.nodes.at(-1));

function needResponse(surface) {
  if (!surface.arrays.response_kernel) throw new SkyshineError("the surface file holds no response to shade");
}

// Temperature of the table at each step of the day; NaN at times that it does not hold.
function history(surface, face) {
  const { rule, nodes } = surface.arrays.temperature.axes[4];
  const held = (hour) => rule === "linear_periodic" || hour - nodes[0] - DAY * Math.floor((hour - nodes[0]) / DAY) <= nodes.at(-1) - nodes[0];
  return HOURS.map((hour) => (held(hour) ? surface.value("temperature", { ...face, time: hour }) : NaN));
}

// Change of temperature at each step of the day by a change of absorbed heat at each step.
function change(surface, face, given) {
  const [, altitudes, slopes, , lags] = surface.arrays.response_kernel.axes;
  const offsets = surface.arrays.heat_loss_excess.axes[4].nodes;
  const column = { material: face.material, response_altitude: within(altitudes, face.altitude), response_slope: within(slopes, face.slope) };
  const limit = surface.value("highest_temperature", face);
  const edges = [...lags.nodes, lags.nodes[0] + DAY];
  const temperature = history(surface, face);
  const absorbed = given.map((heat, k) => {
    const melts = temperature[k] >= limit - MELTING_RANGE;
    return melts ? Math.min(heat + surface.value("melting_heat", { ...column, response_hour: HOURS[k] }), 0) : heat;
  });
  const steps = HOURS.map((hour, k) => {
    const place = { ...column, response_hour: hour };
    const slope = surface.value("heat_loss_slope", place);
    const start = Number.isNaN(temperature[k]) ? 0 : temperature[k] - surface.value("response_temperature", place);
    const loss = offsets.map((offset) => slope * offset + surface.value("heat_loss_excess", { ...place, temperature_offset: offset }));
    const kernel = lags.nodes.map((lag) => surface.value("response_kernel", { ...place, lag }));
    return { hour, slope, start, loss, kernel, base: read(offsets, loss, start) };
  });
  const linear = (heat) => {
    const integral = integralOf(heat);
    return steps.map(({ hour, kernel }) => {
      const ends = edges.map((edge) => integral(hour - edge));
      return kernel.reduce((total, share, l) => total + (share * (ends[l] - ends[l + 1])) / (edges[l + 1] - edges[l]), 0);
    });
  };
  const film = filmOf(surface, face, column, offsets);
  if (film) return wetChange(film, linear, offsets, steps, absorbed);
  let [lowest, highest] = [0, 0];
  steps.forEach(({ loss, base, start }, k) => {
    const balanced = inverse(offsets, loss, base + absorbed[k]) - start;
    if (absorbed[k] < 0) lowest = Math.min(lowest, balanced);
    if (absorbed[k] > 0) highest = Math.max(highest, balanced);
  });
  const bounded = (value) => Math.min(Math.max(value, lowest), highest);
  let moved = linear(absorbed).map(bounded);
  for (let pass = 0; pass < CORRECTIONS; pass++) {
    const beyond = steps.map(({ loss, base, start, slope }, k) => read(offsets, loss, start + moved[k]) - base - slope * moved[k]);
    const target = linear(absorbed.map((heat, k) => heat - beyond[k]));
    moved = moved.map((old, k) => {
      const steeper = old !== 0 ? beyond[k] / (steps[k].slope * old) : 0;
      return bounded(old + (target[k] - old) / (1 + Math.max(steeper, 0)));
    });
  }
  return moved;
}

// The film on a face at its column of the response; none where no water stays.
function filmOf(surface, face, column, offsets) {
  if (!surface.arrays.film_heat_loss || !(surface.value("film_capacity", face) > 0)) return undefined;
  const upward = Math.max(Math.cos(radians(face.slope)), 0);
  const steps = HOURS.map((hour) => {
    const place = { ...column, response_hour: hour };
    const table = (name) => offsets.map((offset) => surface.value(name, { ...place, temperature_offset: offset }));
    const [sunlight, drySunlight] = ["film_sunlight", "absorbed_sunlight"].map((name) => surface.value(name, place));
    return { loss: table("film_heat_loss"), evaporation: table("film_evaporation"), sunlight, drySunlight, rain: surface.value("rain", { forcing_time: hour }) * upward };
  });
  return new Film(steps, surface.value("film_capacity", face), surface.arrays.film_before ? surface.value("film_before", column) : undefined);
}

// `change` of a face with a film.
function wetChange(film, linear, offsets, steps, absorbed) {
  const evaporation = (moved) => steps.map(({ start }, k) => read(offsets, film.steps[k].evaporation, start + moved[k]));
  let moved = absorbed.map(() => 0);
  const { covered: open, start: water, end } = film.inTheOpen(evaporation(moved));
  const base = steps.map((step, k) => step.base + open[k] * (read(offsets, film.steps[k].loss, step.start) - film.steps[k].sunlight));
  const light = film.light(absorbed);
  let [covered, before] = [open, water];
  for (let pass = 0; pass <= CORRECTIONS; pass++) {
    const whole = steps.map(({ loss }, k) => loss.map((value, i) => value + covered[k] * film.steps[k].loss[i]));
    const heat = absorbed.map((change, k) => change + covered[k] * light[k]);
    let [lowest, highest] = [0, 0];
    steps.forEach(({ start }, k) => {
      const surplus = heat[k] - (read(offsets, whole[k], start) - base[k]);
      const balanced = inverse(offsets, whole[k], base[k] + heat[k]) - start;
      if (surplus < 0) lowest = Math.min(lowest, balanced);
      if (surplus > 0) highest = Math.max(highest, balanced);
    });
    const bounded = (value) => Math.min(Math.max(value, lowest), highest);
    if (pass === 0) moved = linear(absorbed).map(bounded);
    else {
      const at = steps.map(({ start }, k) => start + moved[k]);
      const target = linear(heat.map((change, k) => change - (read(offsets, whole[k], at[k]) - base[k] - steps[k].slope * moved[k])));
      moved = moved.map((old, k) => bounded(old + (target[k] - old) / Math.max(rise(offsets, whole[k], at[k]) / steps[k].slope, 1)));
    }
    const day = film.shares(evaporation(moved), before);
    covered = day.covered;
    if (film.returns) before = Math.min(Math.max(water + (day.end - end), 0), 1);
  }
  return moved;
}

// Temperature of a face that absorbs other heat than the table's: means over equal steps of the day, W m^-2.
export function temperatureUnder(surface, face, absorbed) {
  needResponse(surface);
  if (!Array.isArray(absorbed) || !absorbed.length || !absorbed.every(Number.isFinite)) throw new SkyshineError("absorbed_change must be a list of finite numbers");
  const moved = change(surface, face, stepMeans(absorbed));
  const place = ((face.time - DAY * Math.floor(face.time / DAY)) * STEPS) / DAY;
  const before = Math.floor(place) % STEPS;
  const weight = place - Math.floor(place);
  const sunlit = surface.value("temperature", face);
  const limit = surface.value("highest_temperature", face);
  return Math.min(sunlit + moved[before] * (1 - weight) + moved[(before + 1) % STEPS] * weight, Math.max(limit, sunlit));
}

// Share of a step of the day in the shade, of intervals that do not overlap.
function shadedShare(intervals, hour) {
  const [first, last] = [hour - DAY / STEPS / 2, hour + DAY / STEPS / 2];
  let covered = 0;
  for (const [begin, end] of intervals) {
    for (const turn of [-DAY, 0, DAY])
      covered += Math.max(Math.min(last, (end < begin ? end + DAY : end) + turn) - Math.max(first, begin + turn), 0);
  }
  return Math.min((covered * STEPS) / DAY, 1);
}

// Temperature of the air over surfaces at an altitude and a time.
export function airTemperature(surface, altitude, time) {
  needResponse(surface);
  return surface.value("air_temperature", { altitude: within(surface.arrays.air_temperature.axes[0], altitude), forcing_time: time });
}

// Change of the heat that a face absorbs at each step of the day, by shade and a wall: see `Surroundings` in index.d.ts.
export function absorbedChange(surface, face, { shade = [], skyView: open = 1, facing, facingEmissivity: emissivity = WALL_EMISSIVITY }) {
  needResponse(surface);
  const numbers = [open, emissivity, facing ?? 300, ...shade.flat()];
  if (!numbers.every(Number.isFinite) || !shade.every((interval) => interval.length === 2)) throw new SkyshineError("surroundings must be finite numbers");
  const property = (name) => surface.value(name, face);
  const [absorbs, emits] = [property("solar_absorptance"), property("thermal_emissivity")];
  const altitude = within(surface.arrays.air_temperature.axes[0], face.altitude);
  const [cosine, sine] = [Math.cos(radians(face.slope)), Math.sin(radians(face.slope))];
  const view = 0.5 * (1 + cosine);
  return HOURS.map((hour) => {
    const at = (name) => surface.value(name, { altitude, forcing_time: hour });
    const [elevation, turn] = [radians(at("solar_elevation")), radians(at("solar_azimuth") - face.azimuth)];
    const [normal, level, sky] = [at("direct_normal_irradiance"), at("diffuse_irradiance"), at("sky_irradiance")];
    const incidence = Math.max(cosine * Math.sin(elevation) + sine * Math.cos(elevation) * Math.cos(turn), 0);
    const index = normal / at("extraterrestrial_irradiance");
    const ratio = incidence / Math.max(Math.sin(elevation), Math.sin(radians(1)));
    const diffuse = level * ((1 - index) * view + index * ratio);
    const spread = Math.min(diffuse, view * level);
    const beam = normal * incidence + diffuse - spread;
    const air = STEFAN_BOLTZMANN * at("air_temperature") ** 4;
    const emitted = facing === undefined || facing === null ? air : STEFAN_BOLTZMANN * facing ** 4;
    const wall = emissivity * emitted + ((1 - emissivity) * (sky + air)) / 2;
    return -absorbs * (shadedShare(shade, hour) * beam + (1 - open) * spread) + emits * (1 - open) * view * (wall - sky);
  });
}
