// Arrays and attributes of a file, each checked before it is believed.
import h5wasm, { FS } from "h5wasm";
import { SkyshineError } from "./kernel.js";

// Deflate packs at most 1032 bytes into one: a file that claims more does not hold it.
const [PACKING, SMALL] = [1100, 1 << 20];
export const [INTEGER, FLOAT, TEXT, REFERENCE, LIST] = [0, 1, 3, 7, 9]; // type classes of HDF5
const UNREADABLE = "\ufffd"; // what bytes that are not UTF-8 are decoded to
const PLACE = "/database.h5";

const refuse = (message) => {
  throw new SkyshineError(message, "file");
};

export async function ready() {
  const { activate_throwing_error_handler } = await h5wasm.ready;
  activate_throwing_error_handler();
}

// The name in messages and the bytes of a file: given as a path (in Node), or as bytes.
export async function contentOf(given, kind) {
  if (given instanceof Uint8Array) return [`the ${kind} file`, given];
  const { readFileSync, statSync } = await import("node:fs");
  try {
    if (statSync(given).isFile()) return [given, readFileSync(given)];
  } catch {
    // refused below
  }
  return refuse(`${given}: is not a readable HDF5 file`);
}

// Version of the formats that this version knows; it reads all minor versions of its major one.
export const FORMAT = "1.0";
const MAJOR = FORMAT.slice(0, FORMAT.indexOf(".") + 1);

// A file while it is read. The HDF5 library sees it alone, in memory: no link and no storage in it can reach another one.
export class Source {
  // What `read` makes of the bytes of a file, of which messages begin with its path.
  static read(path, content, filetypes, read) {
    try {
      FS.writeFile(PLACE, content);
      const file = new h5wasm.File(PLACE, "r");
      try {
        return read(new Source(file, PACKING * content.length + SMALL, filetypes));
      } finally {
        file.close();
      }
    } catch (error) {
      // The library tells the whole story of an error in many lines.
      const words = error instanceof SkyshineError ? error.message : "is not a readable HDF5 file, or is damaged";
      throw new SkyshineError(`${path}: ${words}`, "file");
    } finally {
      FS.unlink(PLACE);
    }
  }

  constructor(file, bytes, filetypes) {
    Object.assign(this, { file, bytes });
    this.filetype = this.text(file, "filetype");
    const version = this.text(file, "format_version");
    if (!filetypes.includes(this.filetype) || !version.startsWith(MAJOR))
      refuse(`has '${this.filetype}' ${version.slice(0, 20)}; allowed: ${filetypes.join(" or ")} in formats ${MAJOR}x`);
  }

  has(name) {
    const parts = name.split("/");
    return parts.every((part, depth) => (depth ? this.file.get(parts.slice(0, depth).join("/")) : this.file).keys().includes(part));
  }

  // A text attribute; empty where there is none, or it is not one short text.
  text(item, name) {
    const { metadata, value } = name in item.attrs ? item.attrs[name] : {};
    const whole = metadata?.type === TEXT && metadata.total_size === 1 ? value : "";
    const text = Array.isArray(whole) ? whole[0] : whole;
    return typeof text === "string" && text.length <= 64 && !text.includes(UNREADABLE) ? text : "";
  }

  // So many numbers of an attribute; none where it is absent, NaN where it is not that.
  numbers(item, name, count = 1) {
    if (!(name in item.attrs)) return [];
    const { metadata } = item.attrs[name];
    const plain = [INTEGER, FLOAT].includes(metadata.type) && metadata.shape?.length <= 1 && metadata.total_size === count;
    const { value } = plain ? item.attrs[name] : {};
    return plain ? (typeof value === "object" ? Array.from(value, Number) : [Number(value)]) : new Array(count).fill(NaN);
  }

  // An array of this very file, by its path, of a type class, a size in bytes, and so many axes.
  dataset(path, type, size, rank) {
    const parts = path.split("/");
    let place = this.file;
    parts.forEach((part, depth) => {
      const whole = parts.slice(0, depth + 1).join("/");
      if (!place?.keys?.().includes(part)) refuse(`lacks '${path}'`);
      if (this.file.get_link(whole) !== null) refuse(`'${path}' is a link to somewhere else`);
      place = this.file.get(whole);
    });
    if (place?.type !== "Dataset") refuse(`'${path}' is not an array`);
    const { metadata } = place;
    if (metadata.virtual_sources) refuse(`'${path}' is kept in another file`);
    const fits = metadata.type === type && metadata.size === size && (type !== TEXT || metadata.vlen);
    if (!fits) refuse(`'${path}' has values of another type`);
    const count = metadata.shape?.reduce((product, length) => product * length, 1) ?? 0;
    if (metadata.shape?.length !== rank || count < 1) refuse(`'${path}' has the shape ${metadata.shape}; allowed: ${rank} axes, none empty`);
    if (count * size > this.bytes) refuse(`'${path}' claims more bytes than the file can hold`);
    return place;
  }

  // Refuse an array whose dimension scales do not begin with axes of these names.
  checkScales(dataset, name, axes) {
    const list = dataset.attrs.DIMENSION_LIST?.metadata;
    const lists = list?.type === LIST && list.vlen_type?.type === REFERENCE && list.shape?.length === 1 && list.shape[0] === axes.length;
    if (!lists || !axes.every((axis, k) => dataset.get_attached_scales(k)[0] === `/${axis}`))
      refuse(`'${name}' has other dimension scales than its axes`);
  }

  // Codes and names of the materials, by ascending code.
  materials() {
    const codes = Array.from(this.dataset("material", INTEGER, 4, 1).value, Number);
    const names = Array.from(this.dataset("material_name", TEXT, 4, 1).value);
    const readable = names.every((name) => typeof name === "string" && name && !name.includes(UNREADABLE));
    if (!readable || names.length !== codes.length || new Set(names).size !== names.length)
      refuse("'material_name' does not hold a name for each code");
    return codes.map((code, k) => ({ code, name: names[k] }));
  }
}
