// A database, read and checked whole before the first pixel: files come from anywhere, and nothing in one is believed before.
import h5wasm, { FS } from "h5wasm";
import { attribute, Axis, SkyshineError } from "./axis.js";
import { Channels, STORED } from "./channels.js";
import {
  ARRAYS, CHANNEL_BENDING, CHANNEL_HARMONICS, CHANNEL_SHARES, CHANNELS, CIVIL_TWILIGHT, FILM, FILM_BEFORE, FORMATS, GLOW, GROUND, HARMONICS, LIGHT, NIGHT, NIGHT_HARMONICS, RULES,
  SHADE, SHARES, SPECTRA, STATED, TRACKS, WAVELENGTH_ROUNDING, WEIGHT_ROUNDING, WITHOUT_SOURCE,
} from "./layouts.js";

// Deflate packs at most 1032 bytes into one: a file that claims more does not hold it.
export const [PACKING, SMALL] = [1100, 1 << 20];
export const [INTEGER, FLOAT, TEXT, REFERENCE, LIST] = [0, 1, 3, 7, 9]; // type classes of HDF5
const UNREADABLE = "\ufffd"; // what bytes that are not UTF-8 are decoded to

// So many numbers of an attribute in one dimension, or one without; NaN where it is not that.
function numbers(item, name, count) {
  const { metadata, value } = name in item.attrs ? item.attrs[name] : {};
  const flat = metadata?.shape?.length === (count > 1 ? 1 : 0) && metadata.total_size === count;
  const plain = flat && [INTEGER, FLOAT].includes(metadata.type) ? (count > 1 ? Array.from(value, Number) : [Number(value)]) : [];
  return plain.length === count ? plain : new Array(count).fill(NaN);
}

export class Database {
  // Of the bytes of a file, which messages call by its path.
  constructor(path, content, filetypes, clamped) {
    Object.assign(this, { path, clamped, arrays: {}, codes: new Map(), ground: null, channels: null, parted: false });
    try {
      // The library sees this file alone, in memory: no link and no storage in a file can reach another one.
      FS.writeFile("/database.h5", content);
      this.file = new h5wasm.File("/database.h5", "r");
    } catch {
      throw new SkyshineError(`${path}: is not a readable HDF5 file`, "file");
    }
    this.bytes = PACKING * content.length + SMALL;
    try {
      this.read(filetypes);
    } catch (error) {
      // The library tells the whole story of an error in many lines.
      throw new SkyshineError(`${path}: ${error instanceof SkyshineError ? error.message : "is damaged: the HDF5 library cannot read it"}`, "file");
    } finally {
      this.file.close();
      FS.unlink("/database.h5");
    }
  }

  read(filetypes) {
    const filetype = attribute(this.file, "filetype", "");
    const version = attribute(this.file, "format_version", "");
    const majors = FORMATS[filetypes[0]];
    if (!filetypes.includes(filetype) || !majors.some((major) => version?.startsWith(major)))
      throw new SkyshineError(`holds '${String(filetype).slice(0, 40)}' ${String(version).slice(0, 20)}; allowed: ${filetypes.join(" or ")} ${majors.map((major) => `${major}x`).join(" or ")}`);
    this.stored = new Set(this.file.keys());
    this.filetype = filetype;
    const inChannels = filetypes.includes("atmq") && version.startsWith("3.");
    const named = filetypes.includes("atmq") ? attribute(this.file, "ground_material", "") : "";
    this.groundMaterial = typeof named === "string" ? named : "";
    this.groundTemperature = attribute(this.file, "ground_temperature", NaN);
    this.ownAxes = !inChannels; // an array may have axes of its own, named after it: not in format 3
    const stated = inChannels ? this.stated() : null;
    const layouts = inChannels ? this.channelLayouts() : this.layouts(filetypes[0]);
    for (const [name, [axes, least, most]] of Object.entries(layouts)) this.arrays[name] = this.array(name, axes, least, most);
    this.checkShares();
    if (inChannels) {
      this.checkChannels();
      this.channels = new Channels(this, stated);
    }
    if (this.codesOf(LIGHT).length) this.checkLight();
    if ("thermal_path_radiance_ratio" in this.arrays) {
      const unstated = Object.keys(WITHOUT_SOURCE).find((name) => name in this.arrays && this.arrays[name].axes[3].dark === undefined);
      if (unstated) throw new SkyshineError(`the source elevations of '${unstated}' do not state dark_below`);
    }
    if (filetype === "band") this.codes = this.names(this.arrays.reflectance.axes[0]);
  }

  // What the file must hold, by the first array of each part that may be absent.
  layouts(kind) {
    const has = (part) => this.stored.has(Object.keys(part)[0]);
    if (kind === "htt") return Object.assign({ ...ARRAYS.htt }, ...[SHADE, FILM, FILM_BEFORE, TRACKS].filter(has));
    if (kind === "band") return { ...ARRAYS.band, ...this.whole(SPECTRA) };
    const lit = this.stored.has(LIGHT);
    const night = has(NIGHT) ? { ...NIGHT, ...(lit ? NIGHT_HARMONICS : {}) } : {};
    return { ...ARRAYS.atmq, ...(lit ? HARMONICS : {}), ...night };
  }

  // Layouts that stand together or not at all.
  whole(part) {
    return Object.keys(part).some((name) => this.stored.has(name)) ? part : {};
  }

  // What a file in channels must hold.
  channelLayouts() {
    return { ...CHANNELS, ...this.whole(CHANNEL_HARMONICS), ...this.whole(CHANNEL_BENDING), ...this.whole(CHANNEL_SHARES) };
  }

  // The shares of the wavelengths sum to 1.
  checkShares() {
    for (const name of SHARES.filter((each) => each in this.arrays)) {
      const { axes, values } = this.arrays[name];
      const count = axes[1].nodes.length;
      axes[0].nodes.forEach((_, i) => {
        const total = values.subarray(i * count, (i + 1) * count).reduce((all, share) => all + share, 0);
        if (!(Math.abs(total - 1) <= WEIGHT_ROUNDING)) throw new SkyshineError(`a row of '${name}' sums to ${total}; allowed: 1`);
      });
    }
  }

  // Wavelengths of the band at which the file parts light; none where it does not.
  get wavelengths() {
    const name = SHARES.find((each) => each in this.arrays);
    return name ? this.arrays[name].axes[1].nodes : [];
  }

  // Read the light of this atmosphere at each wavelength, where it and the file of the band hold what that takes; they are then of one band.
  partLight(band) {
    const [ours, theirs] = [this.wavelengths, band.wavelengths];
    this.parted = ours.length > 0 && theirs.length > 0;
    const same = ours.length === theirs.length && ours.every((node, b) => Math.abs(node - theirs[b]) <= WAVELENGTH_ROUNDING * Math.abs(theirs[b]));
    if (!this.parted || same) return;
    const [found, allowed] = [theirs, ours].map((nodes) => `${nodes.length} from ${nodes[0]} to ${nodes.at(-1)} um`);
    throw new SkyshineError(`${band.path}: has the wavelengths ${found}; allowed: those of the air, ${allowed}`, "file");
  }

  // What a file in channels says of the air and of the paths that it is for.
  stated() {
    const layout = attribute(this.file, "layout", "");
    if (layout !== "channels") throw new SkyshineError(`has the layout '${String(layout).slice(0, 40)}'; allowed: channels`);
    return Object.fromEntries(
      Object.entries(STATED).map(([name, [count, least, most]]) => {
        const values = numbers(this.file, name, count);
        if (!values.every((value, i) => value >= least && value <= most && (i === 0 || value >= values[i - 1])))
          throw new SkyshineError(`does not state '${name}', in ${least} to ${most} and ascending`);
        return [name, values];
      }),
    );
  }

  // The weights sum to 1, and the source elevations say where it is dark.
  checkChannels() {
    const sum = this.arrays.channel_weight.values.reduce((total, weight) => total + weight, 0);
    if (!(Math.abs(sum - 1) <= WEIGHT_ROUNDING)) throw new SkyshineError(`'channel_weight' sums to ${sum}; allowed: 1`);
    if (this.arrays.source_factor.axes[1].dark === undefined) throw new SkyshineError("the source elevations of 'source_factor' do not state dark_below");
  }

  // Codes of the coefficients of LIGHT or GLOW; none where the file has no harmonics.
  codesOf(harmonics) {
    return this.arrays[this.channels ? STORED[harmonics] : harmonics]?.axes.at(-1).nodes ?? [];
  }

  // The harmonics go together, and the file states the ground.
  checkLight() {
    const [light, glow] = [LIGHT, GLOW].map((name) => this.codesOf(name).length);
    if ((light === 6) !== (glow === 3)) throw new SkyshineError(`'${LIGHT}' and '${GLOW}' are of different harmonics`);
    this.ground = GROUND.map((name) => attribute(this.file, name, NaN));
    if (!this.ground.every((value) => Number.isFinite(value) && value >= 0)) throw new SkyshineError(`does not state the ground: ${GROUND.join(", ")}`);
  }

  // An array of this very file, of a type class, a size in bytes, and so many axes.
  dataset(name, type, size, rank) {
    if (!this.stored.has(name)) throw new SkyshineError(`lacks '${name}'`);
    if (this.file.get_link(name) !== null) throw new SkyshineError(`'${name}' is a link to somewhere else`);
    const dataset = this.file.get(name);
    if (dataset?.type !== "Dataset") throw new SkyshineError(`'${name}' is not an array`);
    const { metadata } = dataset;
    if (metadata.virtual_sources) throw new SkyshineError(`'${name}' is kept in another file`);
    if (metadata.type !== type || metadata.size !== size || (type === TEXT && !metadata.vlen)) throw new SkyshineError(`'${name}' has values of another type`);
    const count = metadata.shape?.reduce((product, length) => product * length, 1) ?? 0;
    if (metadata.shape?.length !== rank || count < 1) throw new SkyshineError(`'${name}' has the shape ${metadata.shape}; allowed: ${rank} axes, none empty`);
    if (count * size > this.bytes) throw new SkyshineError(`'${name}' claims more bytes than the file can hold`);
    return dataset;
  }

  // Name of the quantity's own axis where the file has one, else of the one that quantities share; and the axis.
  axis(quantity, name) {
    const stored = this.ownAxes && this.stored.has(`${quantity}_${name}`) ? `${quantity}_${name}` : name;
    const codes = RULES[name]?.[0][0] === "exact";
    const dataset = codes ? this.dataset(stored, INTEGER, 4, 1) : this.dataset(stored, FLOAT, 8, 1);
    return [stored, new Axis(name, stored, dataset, this.clamped.includes(name.replace(/^sky_/, "")))];
  }

  array(quantity, names, least, most) {
    const dataset = this.dataset(quantity, FLOAT, 4, names.length);
    const list = dataset.attrs.DIMENSION_LIST?.metadata;
    if (list?.type !== LIST || list.vlen_type?.type !== REFERENCE || list.shape?.length !== 1 || list.shape[0] !== names.length)
      throw new SkyshineError(`'${quantity}' has no dimension scales`);
    const axes = names.map((name, k) => {
      const byAngle = name === "source_azimuth" && this.stored.has("scattering_angle");
      const [stored, axis] = this.axis(quantity, byAngle ? "scattering_angle" : name);
      const length = dataset.shape[k];
      if (length !== axis.nodes.length) throw new SkyshineError(`'${quantity}' has ${length} values along '${stored}', which has ${axis.nodes.length} nodes`);
      if (dataset.get_attached_scales(k)[0] !== `/${stored}`) throw new SkyshineError(`'${quantity}' has other dimension scales than its axes`);
      return axis;
    });
    const values = Float32Array.from(dataset.value);
    if (!values.every((value) => Number.isFinite(value) && value >= least && value <= most))
      throw new SkyshineError(`'${quantity}' holds values beyond ${least} to ${most}`);
    return { axes, values };
  }

  // Codes of the materials by name.
  names(axis) {
    const names = Array.from(this.dataset("material_name", TEXT, 4, 1).value);
    const readable = names.every((name) => typeof name === "string" && name && !name.includes(UNREADABLE));
    if (!readable || names.length !== axis.nodes.length || new Set(names).size !== names.length)
      throw new SkyshineError("'material_name' does not hold a name for each code");
    return new Map(names.map((name, k) => [name, axis.nodes[k]]));
  }

  // A quantity at a place; below the lowest elevation of the source, its light fades into what the air emits.
  value(quantity, where) {
    if (this.channels) return this.channels.value(quantity, where);
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

  // Light on surfaces at each wavelength; one number for the whole band where light is not parted.
  light(quantity, where) {
    return this.parted ? this.channels.parted(quantity, where) : [this.value(quantity, where)];
  }

  // Extinction per km of emitted light over the range of the place, as (8) and (9) have it; of the band where light is not parted.
  extinction(where) {
    return this.parted ? this.channels.extinction(where) : [5.5 / this.value("beta_star", where)];
  }

  // A quantity of this file of a band at each of its wavelengths.
  spectrum(quantity, where) {
    return this.wavelengths.map((node) => this.interpolated(quantity, { ...where, band_wavelength: node }));
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
}
