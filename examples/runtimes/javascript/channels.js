// An atmosphere in channels (format 3): its quantities, computed from tables that have no axis of range.
// Light on surfaces is a list: one number for the whole band, or one for each of its wavelengths.
// The formulas are those of ../../../schemas/formats/atmq-3.md; lengths are in km.
import { SkyshineError } from "./axis.js";
import { CIVIL_TWILIGHT, GLOW, LIGHT } from "./layouts.js";

// The arrays that have the codes of the harmonics.
export const STORED = { [LIGHT]: "scattered_harmonics", [GLOW]: "ground_harmonics" };
const [SHORTEST, FARTHEST_BETA, EARTH_RADIUS] = [1e-12, 1e12, 6371.0088];
const SMALLEST = 2 ** -1022; // number of full precision

const limited = (value) => Math.min(Math.max(value, 0), 1);
const sum = (values, of) => values.reduce((total, value, k) => total + value * of(k), 0);
const added = (one, other, share) => one.map((value, b) => value + share * other[b]);
const bounded = (values) => values.map((value) => Math.max(value, 0));

// Height of the end of a straight line over an Earth of a radius.
const heightAt = (reach, earth, height, angle) => {
  const radius = earth + height;
  const step = reach * reach + 2 * radius * Math.sin(angle) * reach;
  return (step + height * (2 * earth + height)) / (earth + Math.sqrt(Math.max(radius * radius + step, 0)));
};

export class Channels {
  constructor(database, stated) {
    this.database = database;
    [this.ground, this.scale] = [stated.ground_altitude_km[0], stated.scale_height_km[0]];
    this.ends = { range: stated.range_km, altitude: stated.altitude_km, elevation: [-90, 90] };
    this.sourceElevation = database.arrays.source_factor.axes[1];
  }

  // A quantity of format 2 at a place.
  value(quantity, where) {
    const path = this.path(where);
    if (quantity === "beta_star") return this.betaStar(path, this.within("range", where));
    if (quantity === "path_radiance_ratio") return this.pathRadianceRatio(path, where);
    const undivided = { count: 1 };
    return this.onSurface(quantity, path, where, { thermal: undivided, source: undivided })[0];
  }

  // A quantity of light on surfaces at each wavelength.
  parted(quantity, where) {
    const [thermal, source] = ["thermal_wavelength_share", "source_wavelength_share"].map((name) => this.shares(name));
    return this.onSurface(quantity, this.path(where), where, { thermal, source });
  }

  // Shares of so many wavelengths in each channel.
  shares(name) {
    const { axes, values } = this.database.arrays[name];
    return { count: axes[1].nodes.length, values };
  }

  // Extinction per km of emitted light at each wavelength, a mean over the range of the place.
  extinction(where) {
    const { depth } = this.path(where);
    const { thermal_reference: emitted, channel_weight: weight } = this.database.arrays;
    const { count, values } = this.shares("thermal_wavelength_share");
    const reach = Math.max(this.within("range", where), SHORTEST);
    return Array.from({ length: count }, (_, b) => {
      const parts = depth.map((_, j) => emitted.values[j] * values[j * count + b]);
      const whole = parts.reduce((total, part) => total + part, 0);
      const mean = (of) => (whole > 0 ? sum(parts, of) / whole : sum(weight.values, of));
      const absorbed = mean((j) => -Math.expm1(-depth[j]));
      const thick = () => Math.log(Math.max(mean((j) => Math.exp(-depth[j])), SMALLEST));
      return -(absorbed < 0.5 ? Math.log1p(-absorbed) : thick()) / reach;
    });
  }

  onSurface(quantity, path, where, shares) {
    if (quantity === "direct_radiance") return bounded(this.direct(path, where.source_elevation, shares.source));
    if (quantity === "ambient_radiance") return bounded(this.sky("sky", path, where, shares));
    if (quantity === LIGHT) return this.sky("harmonics", path, where, shares);
    return this.light("ground_harmonics", path, where, shares.thermal, this.emission(where.ground_temperature));
  }

  // Range, altitude or elevation, which must be one that the file is for.
  within(name, where) {
    const [value, [first, last]] = [where[name], this.ends[name]];
    const inside = this.database.clamped.includes(name) || (value >= first && value <= last);
    if (!Number.isFinite(value) || !inside) throw new SkyshineError(`${name}: found ${value}; allowed: ${first} to ${last}`);
    return Math.min(Math.max(value, first), last);
  }

  // Values of all parts of an array at a place.
  parts(name, place) {
    const [first] = this.database.arrays[name].axes;
    return first.nodes.map((code) => this.database.interpolated(name, { ...place, [first.name]: code }));
  }

  // Place in the tables, length that mean extinction is multiplied by, and height of the end.
  line(where) {
    const [reach, altitude, elevation] = ["range", "altitude", "elevation"].map((name) => this.within(name, where));
    const height = Math.max(altitude - this.ground, 0);
    const [root, angle] = [Math.cbrt(height), (elevation * Math.PI) / 180];
    const rho = this.database.interpolated("effective_radius", { height_root: root });
    const [radius, fall] = [rho + height, height * (2 * rho + height)];
    const rise = radius * Math.sin(angle);
    const down = angle < 0 && rise * rise >= fall;
    const found = down ? this.intoGround(reach, height, rho, rise, fall) : this.intoSpace(reach, height, radius, angle, rise);
    const place = { height_root: root, ...found };
    return { ...place, end: this.end(place, reach, rho, height, angle) };
  }

  // Height of the end of a line that has its place in the tables.
  end(place, reach, rho, height, angle) {
    if (place.grounded) return 0;
    if (!("end_rise" in this.database.arrays)) return Math.max(heightAt(reach, rho, height, angle), 0);
    const straight = heightAt(reach, EARTH_RADIUS + this.ground, height, angle);
    return Math.max(straight + reach * this.database.interpolated("end_rise", place), 0);
  }

  intoGround(reach, height, rho, rise, fall) {
    const distance = fall / (Math.sqrt(rise * rise - fall) - rise);
    const across = 2 * rho * height;
    const direction = across > 0 ? limited((distance * distance - height * height) / across) : 0;
    const share = distance > 0 ? Math.min(reach / distance, 1) : 1;
    return { share, direction, length: reach, grounded: reach >= distance };
  }

  intoSpace(reach, height, radius, angle, rise) {
    const above = this.scale * (2 * radius + this.scale);
    const [level, way] = [Math.sqrt(above), above / (rise + Math.sqrt(rise * rise + above))];
    const share = -Math.expm1(-reach / way);
    const passing = 3 - Math.sqrt(limited((2 * radius * Math.sin(angle / 2) ** 2) / height));
    const direction = angle < 0 ? passing : 3 + limited((level - way) / (level - this.scale));
    return { share, direction, length: way * share };
  }

  // A line with the optical depth and mean extinction of its channels.
  path(where) {
    const line = this.line(where);
    const mean = this.parts("log_mean_extinction", line).map(Math.exp);
    const { axes, values } = this.database.arrays.absorber_factor;
    const extinction = axes[0].nodes.map((_, j) => Math.max(sum(mean, (i) => values[j * mean.length + i]), 0));
    const depth = extinction.map((value) => value * Math.max(line.length, SHORTEST));
    const least = depth.reduce((lowest, value) => Math.min(lowest, value), Infinity);
    return { line, depth, extinction, least, through: depth.map((value) => Math.exp(least - value)) };
  }

  // Sum over the channels of a spectrum.
  over(spectrum, of) {
    return sum(this.database.arrays[spectrum].values, of);
  }

  absorbed(spectrum, { depth }) {
    return this.over(spectrum, (j) => -Math.expm1(-depth[j]));
  }

  betaStar(path, reach) {
    const absorptance = this.absorbed("channel_weight", path);
    const through = this.over("channel_weight", (j) => path.through[j]);
    const depth = absorptance < 0.5 ? -Math.log1p(-absorptance) : path.least - Math.log(through);
    const extinction = reach > 0 ? depth / reach : this.over("channel_weight", (j) => path.extinction[j]);
    return extinction > 0 ? Math.min(5.5 / extinction, FARTHEST_BETA) : FARTHEST_BETA;
  }

  pathRadianceRatio(path, { source_elevation: height, scattering_angle }) {
    const factor = this.parts("source_factor", { source_elevation: this.lit(height), scattering_angle });
    const ratio = this.parts("scattered_ratio", path.line);
    const scattered = this.night(height) * Math.max(sum(factor, (k) => ratio[k]), 0) * this.absorbed("source_reference", path);
    const thermal = this.database.interpolated("thermal_ratio", path.line) * this.absorbed("thermal_reference", path);
    const absorptance = this.absorbed("channel_weight", path);
    return absorptance > 0 ? (thermal + scattered) / absorptance : 0;
  }

  direct(path, height, shares) {
    this.lit(height);
    const above = height - this.database.interpolated("source_rise", { target_height: path.line.end });
    if (!(above >= 0)) return new Array(shares.count).fill(0);
    return this.light("direct_light", path, { target_height: path.line.end, elevation_above_rise: above }, shares);
  }

  // What the air emits, and what it scatters.
  sky(kind, path, where, shares) {
    const lit = { ...where, sky_source_elevation: this.lit(where.source_elevation) };
    const emitted = this.light(`thermal_${kind}`, path, where, shares.thermal);
    return added(emitted, this.light(`scattered_${kind}`, path, lit, shares.source), this.night(where.source_elevation));
  }

  // Light on the surface at the end of a path as the path weighs it, over its transmittance, parted by the shares.
  light(name, path, where, { count, values: shares }, spectrum = null) {
    const value = this.parts(name, { ...where, surface_height: path.line.end });
    const factor = this.database.arrays[`${name}_factor`].values;
    const lit = path.through.map((through, j) => through * (spectrum ? spectrum[j] : 1) * sum(value, (q) => factor[j * value.length + q]));
    const mean = this.over("channel_weight", (j) => path.through[j]);
    return Array.from({ length: count }, (_, b) => sum(lit, (j) => (shares ? shares[j * count + b] : 1)) / mean);
  }

  // What the ground emits in the channels.
  emission(kelvin) {
    const { axes, values } = this.database.arrays.ground_emission;
    const { lower, upper, weight } = axes[0].locate(kelvin);
    const count = axes[1].nodes.length;
    return axes[1].nodes.map((_, j) => (1 - weight) * values[lower * count + j] + weight * values[upper * count + j]);
  }

  // The elevation of the source, or the first node where it is below.
  lit(height) {
    const lit = Number.isFinite(height) ? Math.max(height, this.sourceElevation.nodes[0]) : height;
    this.sourceElevation.locate(lit); // refuses what the file is not for
    return lit;
  }

  // Share of the light of the first node that the source gives below it; 1 above.
  night(height) {
    const { nodes, dark } = this.sourceElevation;
    if (!(height < nodes[0])) return 1;
    if (height <= dark) return 0;
    if (nodes[0] <= CIVIL_TWILIGHT) return (height - dark) / (nodes[0] - dark);
    this.sourceElevation.locate(height); // refuses it, or clamps
    return 1;
  }
}
