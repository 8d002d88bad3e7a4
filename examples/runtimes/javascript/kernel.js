// The C library of mat/kernel as WebAssembly: its memory, and its failures as lines of text.

// What was found, and what is allowed, in one line.
export class SkyshineError extends Error {
  constructor(message, kind = "value") {
    super(String(message).replace(/[\p{C}\p{Zl}\p{Zp}]/gu, "?").slice(0, 600));
    this.name = "SkyshineError";
    this.kind = kind;
  }
}

const FAILURE_BYTES = 40; // of a SkyFailure: status, kind, row, name as 32 bits each, then found, least, most as 64
const ALIGNMENT = 64;
const PAGE = 65536;

let compiled;

async function fromDisk(place) {
  const { readFile } = await import("node:fs/promises");
  try {
    return await readFile(place);
  } catch {
    throw new SkyshineError(`${place.pathname}: is not there yet; compile it with: python3 build.py (needs pip install ziglang)`, "file");
  }
}

// The module, compiled once: from a file in Node, by a request in a browser.
export function kernelModule() {
  const place = new URL("./kernel.wasm", import.meta.url);
  const bytes = async () => (place.protocol === "file:" ? fromDisk(place) : (await fetch(place)).arrayBuffer());
  compiled ??= bytes().then((content) => WebAssembly.compile(content));
  return compiled;
}

// Lines of text by the status of a failure, from 1.
const TEXTS = [
  ({ name, found, least, most }) => `${name}: found ${found}; allowed: ${least} to ${most}`,
  ({ name, found }) => `${name}: found ${found}; allowed: a code of the file`,
  ({ name, found, least, most }) => `${name}: found ${found}; allowed: ${least} and above, or ${most} and below`,
  ({ name }) => `${name}: found a direction without length; allowed: three finite numbers that are not all 0`,
  ({ name, found }) => `${name}: found ${found}; allowed: 0 to 1`,
  ({ name, found }) => `${name}: found ${found}; allowed: finite numbers from 0`,
  () => "found a pixel without material; allowed: codes of the tables",
  () => "the surface file has no response to shade",
  ({ ground }) => `the surface file lacks the ground '${ground}'; build all files from one job`,
  ({ name }) => `${name}: found what is not a finite number; allowed: finite numbers`,
  ({ name }) => `lacks '${name}'`,
  ({ name }) => `the axis '${name}' has nodes, a rule or a period that are not those of the format`,
  ({ name, found, least, most }) => `'${name}' holds ${found}; allowed: ${least} to ${most}`,
  ({ name, found }) => `a row of '${name}' sums to ${found}; allowed: 1`,
  ({ name, least, most }) => `does not state '${name}', in ${least} to ${most}`,
  ({ found, least, most }) => `has ${found} wavelengths from ${least} to ${most} um; allowed: those of the air`,
];

// The library with memory of its own. Values that stay are placed one behind the other; those of a call are freed with it.
export class Kernel {
  constructor(module) {
    this.calls = new WebAssembly.Instance(module, {}).exports;
    this.end = this.calls.__heap_base.value;
    this.failure = this.take(FAILURE_BYTES);
  }

  // Address of so many bytes, which are 0 where the memory was never used.
  take(bytes) {
    const at = Math.ceil(this.end / ALIGNMENT) * ALIGNMENT;
    const missing = at + bytes - this.calls.memory.buffer.byteLength;
    if (missing > 0) this.calls.memory.grow(Math.ceil(missing / PAGE));
    this.end = at + bytes;
    return at;
  }

  // Address of a copy of values, by the type of their array; 0 where there are none.
  put(type, values) {
    if (values === undefined || values === null) return 0;
    const at = this.take(values.length * type.BYTES_PER_ELEMENT);
    new type(this.calls.memory.buffer, at, values.length).set(values);
    return at;
  }

  // A view of values, until the memory grows.
  view(type, at, count) {
    return new type(this.calls.memory.buffer, at, count);
  }

  text(at) {
    if (at === 0) return null;
    const bytes = new Uint8Array(this.calls.memory.buffer, at);
    return new TextDecoder().decode(bytes.subarray(0, bytes.indexOf(0)));
  }

  // Texts of a list of the library, which ends with none.
  texts(each) {
    const found = [];
    for (let text = this.text(each(0)); text !== null; text = this.text(each(found.length))) found.push(text);
    return found;
  }

  // Do something whose memory is free again behind it.
  within(work) {
    const { end } = this;
    try {
      return work();
    } finally {
      this.end = end;
    }
  }

  // Call a function that may fail; its failure is the last argument. Of `many` places the message has the number.
  check(name, kind, given, many = false) {
    if (this.calls[name](...given, this.failure) === 0) return;
    const memory = new DataView(this.calls.memory.buffer, this.failure, FAILURE_BYTES);
    const [status, row, text] = [memory.getInt32(0, true), memory.getUint32(8, true), this.text(memory.getUint32(12, true))];
    const [found, least, most] = [16, 24, 32].map((place) => memory.getFloat64(place, true));
    const line = TEXTS[status - 1]({ name: text ?? "", found, least, most, ground: this.ground });
    throw new SkyshineError(many ? `pixel ${row}: ${line}` : line, kind);
  }
}
