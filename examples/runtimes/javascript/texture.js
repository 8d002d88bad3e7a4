// A texture, from whose texels materials are read; each level is read and checked whole when the first pixel asks for it.
import h5wasm, { FS } from "h5wasm";
import { attribute, SkyshineError } from "./axis.js";
import { INTEGER, PACKING, SMALL } from "./database.js";

const TOTAL = 65535; // what the weights of a texel sum to
const SHADE_TOTAL = 255; // of a texel that lies in the shade as a whole
const COMPONENTS = 3;

export class Texture {
  // Of the bytes of a file, which messages call by its path.
  constructor(path, content) {
    Object.assign(this, { path, content, levels: new Map() });
    this.read(0);
  }

  // Codes and shares of the materials at a point, in texels of level 0 from the top left corner of the image.
  mixture(across, down, level = 0) {
    const { texel, codes, weights } = this.place(across, down, level);
    const first = texel * COMPONENTS;
    if (codes[first] === 0) throw new SkyshineError(`texel: [${across}, ${down}] has no material`);
    const all = Array.from({ length: COMPONENTS }, (_, k) => [codes[first + k], weights[first + k] / TOTAL]);
    return all.filter(([, share]) => share > 0);
  }

  // Share of the texel at that point in the shade of its photograph; 0 where the file has no such layer.
  shade(across, down, level = 0) {
    const { texel, shade } = this.place(across, down, level);
    return shade ? shade[texel] / SHADE_TOTAL : 0;
  }

  // A level, which is read where it was not yet, and the number of the texel at a point in it.
  place(across, down, level) {
    const [height, width] = this.levels.get(0).shape;
    if (!(across >= 0 && across <= width && down >= 0 && down <= height))
      throw new SkyshineError(`texel: found [${across}, ${down}]; allowed: 0 to ${width}, 0 to ${height}`);
    if (!this.levels.has(level)) this.read(level);
    const found = this.levels.get(level);
    const { shape } = found;
    const row = Math.min(Math.floor((down * shape[0]) / height), shape[0] - 1);
    const column = Math.min(Math.floor((across * shape[1]) / width), shape[1] - 1);
    return { ...found, texel: row * shape[1] + column };
  }

  read(level) {
    try {
      FS.writeFile("/texture.h5", this.content);
      this.file = new h5wasm.File("/texture.h5", "r");
    } catch {
      throw new SkyshineError(`${this.path}: is not a readable HDF5 file`, "file");
    }
    this.bytes = PACKING * this.content.length + SMALL;
    try {
      this.levels.set(level, this.level(level));
    } catch (error) {
      throw new SkyshineError(`${this.path}: ${error instanceof SkyshineError ? error.message : "is damaged: the HDF5 library cannot read it"}`, "file");
    } finally {
      this.file.close();
      FS.unlink("/texture.h5");
    }
  }

  level(level) {
    const filetype = attribute(this.file, "filetype", "");
    const version = attribute(this.file, "format_version", "");
    if (filetype !== "tmm" || !version?.startsWith("1.")) throw new SkyshineError(`holds '${String(filetype).slice(0, 40)}'; allowed: tmm 1.x`);
    const known = this.plane("materials/material", 1, 2).values;
    if (known[0] < 1 || !known.every((code, k) => k === 0 || code > known[k - 1])) throw new SkyshineError("the codes of its materials do not ascend from 1");
    const [code, mixed, weighted] = ["code", "mix_code", "mix_weight"].map((name) => this.plane(`levels/${level}/${name}`, name === "code" ? 2 : 3, 2));
    const shape = code.shape;
    const fits = ({ shape: other }) => other[0] === shape[0] && other[1] === shape[1] && other[2] === COMPONENTS;
    if (!fits(mixed) || !fits(weighted)) throw new SkyshineError(`the arrays of level ${level} do not fit each other`);
    if (attribute(weighted.dataset, "total", 0) !== TOTAL) throw new SkyshineError(`the weights of level ${level} do not state their total, ${TOTAL}`);
    const [codes, weights, allowed] = [mixed.values, weighted.values, new Set([0, ...known])];
    code.values.forEach((first, texel) => {
      let sum = 0;
      for (let k = texel * COMPONENTS; k < (texel + 1) * COMPONENTS; k++) {
        sum += weights[k];
        if (!allowed.has(codes[k])) throw new SkyshineError(`level ${level} has codes that are not those of its materials`);
        if (first !== 0 && codes[k] === 0 && weights[k] > 0) throw new SkyshineError(`level ${level} gives weight to no material`);
      }
      if (codes[texel * COMPONENTS] !== first) throw new SkyshineError(`level ${level} has codes that are not those of its materials`);
      if (sum !== TOTAL) throw new SkyshineError(`the weights of level ${level} do not sum to ${TOTAL}`);
    });
    return { shape, codes, weights, shade: this.shadeOf(level, shape) };
  }

  // The layer of shade, which a file has on all levels or on none: null where it has none.
  shadeOf(level, shape) {
    if (!this.file.get("levels/0").keys().includes("shade")) return null;
    const shade = this.plane(`levels/${level}/shade`, 2, 1);
    if (shade.shape[0] !== shape[0] || shade.shape[1] !== shape[1]) throw new SkyshineError(`the arrays of level ${level} do not fit each other`);
    if (attribute(shade.dataset, "total", 0) !== SHADE_TOTAL) throw new SkyshineError(`the shade of level ${level} does not state its total, ${SHADE_TOTAL}`);
    return shade.values;
  }

  // An array of unsigned integers of a size in bytes, of this very file.
  plane(name, rank, size) {
    const parts = name.split("/");
    let place = this.file;
    parts.forEach((part, depth) => {
      const whole = parts.slice(0, depth + 1).join("/");
      if (!place?.keys?.().includes(part)) throw new SkyshineError(`lacks '${name}'`);
      if (this.file.get_link(whole) !== null) throw new SkyshineError(`'${name}' is a link to somewhere else`);
      place = this.file.get(whole);
    });
    if (place?.type !== "Dataset") throw new SkyshineError(`'${name}' is not an array`);
    const { metadata } = place;
    if (metadata.virtual_sources) throw new SkyshineError(`'${name}' is kept in another file`);
    if (metadata.type !== INTEGER || metadata.size !== size || metadata.signed) throw new SkyshineError(`'${name}' has values of another type`);
    const count = metadata.shape?.reduce((product, length) => product * length, 1) ?? 0;
    if (metadata.shape?.length !== rank || count < 1) throw new SkyshineError(`'${name}' has the shape ${metadata.shape}; allowed: ${rank} axes, none empty`);
    if (count * size > this.bytes) throw new SkyshineError(`'${name}' claims more bytes than the file can hold`);
    return { dataset: place, shape: metadata.shape, values: (size === 1 ? Uint8Array : Uint16Array).from(place.value) };
  }
}
