// A texture, from whose texels materials are read; each level is read and checked whole when the first pixel asks for it.
import { SkyshineError } from "./kernel.js";
import { INTEGER, Source } from "./source.js";

const TOTAL = 65535; // what the weights of a texel sum to
const SHADE_TOTAL = 255; // of a texel that lies in the shade as a whole
const COMPONENTS = 3;

// Values of an array of unsigned integers of a size in bytes, with its shape; `total` of its attributes must be this one.
function plane(source, name, rank, size, total) {
  const array = source.dataset(name, INTEGER, size, rank);
  if (array.metadata.signed) throw new SkyshineError(`'${name}' has values of another type`);
  if (total !== undefined && source.numbers(array, "total")[0] !== total) throw new SkyshineError(`'${name}' does not state its total, ${total}`);
  return { shape: array.metadata.shape, values: (size === 1 ? Uint8Array : Uint16Array).from(array.value) };
}

function readLevel(source, level) {
  const known = plane(source, "materials/material", 1, 2).values;
  if (known[0] < 1 || !known.every((code, k) => k === 0 || code > known[k - 1])) throw new SkyshineError("the codes of its materials do not ascend from 1");
  const place = (name) => `levels/${level}/${name}`;
  const code = plane(source, place("code"), 2, 2);
  const [mixed, weighted] = [plane(source, place("mix_code"), 3, 2), plane(source, place("mix_weight"), 3, 2, TOTAL)];
  // A file has this layer on all levels or on none.
  const shaded = source.has("levels/0/shade") ? plane(source, place("shade"), 2, 1, SHADE_TOTAL) : null;
  const [height, width] = code.shape;
  const fits = ({ shape }) => shape[0] === height && shape[1] === width && (shape.length === 2 || shape[2] === COMPONENTS);
  if (![mixed, weighted, shaded ?? code].every(fits)) throw new SkyshineError(`the arrays of level ${level} do not fit each other`);
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
  return { shape: code.shape, codes, weights, shade: shaded?.values };
}

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
    this.levels.set(level, Source.read(this.path, this.content, ["tmm"], (source) => readLevel(source, level)));
  }
}
