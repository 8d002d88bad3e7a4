// One axis of an array, and the error of a value or a file that does not fit.
import { CLAMPED, CODES, COUNTS, LAST_CODE, RULES } from "./layouts.js";

export class SkyshineError extends Error {
  // `kind` is "file" or "value".
  constructor(message, kind = "value") {
    super(message.replace(/[\p{C}\p{Zl}\p{Zp}]/gu, "?"));
    this.name = "SkyshineError";
    this.kind = kind;
  }
}

const modulo = (value, period) => value - period * Math.floor(value / period);

// An attribute of one value, of the type of `otherwise`; `otherwise` where there is none, null where it is of another kind.
export function attribute(item, name, otherwise) {
  if (!(name in item.attrs)) return otherwise;
  const { metadata, value } = item.attrs[name];
  const one = metadata.total_size === 1 && metadata.shape ? [value].flat()[0] : null;
  const plain = ArrayBuffer.isView(one) ? one[0] : one;
  return typeof plain === typeof otherwise || typeof plain === "bigint" ? (typeof otherwise === "number" ? Number(plain) : plain) : null;
}

export class Axis {
  constructor(name, stored, dataset, clamped) {
    this.name = name;
    this.nodes = Array.from(dataset.value, Number);
    this.rule = attribute(dataset, "interpolation", "");
    this.period = attribute(dataset, "period", 0);
    const policy = attribute(dataset, "out_of_range", "error");
    this.clamps = clamped || CLAMPED.includes(name) || policy === "clamp";
    // Of source elevations: no light of the source is left there; undefined where the file does not say.
    this.dark = "dark_below" in dataset.attrs ? (attribute(dataset, "dark_below", 0) ?? NaN) : undefined;
    const fault = ["error", "clamp"].includes(policy) ? this.fault() : "out_of_range that is neither error nor clamp";
    if (fault) throw new SkyshineError(`the axis '${stored}' has ${fault}`);
  }

  // What in the rule or the nodes is not as the format has it; empty where nothing is.
  fault() {
    const { nodes, rule } = this;
    const [rules, period] = RULES[this.name] ?? [["linear"], 0];
    const [first, last] = [nodes[0], nodes.at(-1)];
    if (!rules.includes(rule)) return `interpolation '${String(rule).slice(0, 40)}'; allowed: ${rules.join(" or ")}`;
    if (this.name === "source_elevation" && this.dark !== undefined && !(this.dark >= -90 && this.dark <= 0)) return `dark_below ${this.dark}; allowed: -90 to 0`;
    if (this.period !== period) return `period ${this.period}; allowed: ${period}`;
    if (!nodes.every((node, i) => Number.isFinite(node) && (i === 0 || node > nodes[i - 1]))) return "nodes that are not ascending numbers";
    const folded = rule === "linear_folded" && (first < 0 || last > period / 2);
    if (folded || (period && (last > first + period || (rule === "linear_periodic" && last === first + period)))) return "nodes beyond its period";
    if (this.name in CODES) {
      const known = COUNTS[this.name].includes(nodes.length) && nodes.every((node, i) => node === CODES[this.name][i]);
      return known ? "" : "codes that are not those of the format";
    }
    return rule === "exact" && (first < 1 || last > LAST_CODE) ? `codes beyond 1 to ${LAST_CODE}` : "";
  }

  // Index of the lower and the upper node, and the weight of the upper one.
  locate(given) {
    if (!Number.isFinite(given)) throw new SkyshineError(`${this.name}: found ${given}; allowed: finite numbers`);
    let value = given;
    let nodes = this.nodes;
    if (this.rule === "exact") {
      const at = nodes.indexOf(value);
      if (at < 0) throw new SkyshineError(`${this.name}: found ${value}; allowed: a code of the file`);
      return { lower: at, upper: at, weight: 0 };
    }
    if (this.rule === "linear_periodic") {
      nodes = [...nodes, nodes[0] + this.period];
      value = nodes[0] + modulo(value - nodes[0], this.period);
    } else if (this.rule === "linear" && this.period > 0) {
      value -= this.period * Math.floor((value - nodes[0]) / this.period);
    } else if (this.rule === "linear_folded") {
      value = Math.abs(modulo(value + this.period / 2, this.period) - this.period / 2);
    }
    const last = nodes.length - 1;
    if (!this.clamps && !(value >= nodes[0] && value <= nodes[last]))
      throw new SkyshineError(`${this.name}: found ${value}; allowed: ${nodes[0]} to ${nodes[last]}`);
    value = Math.min(Math.max(value, nodes[0]), nodes[last]);
    let lower = 0;
    let above = Math.max(last, 1);
    while (above - lower > 1) {
      const middle = (lower + above) >> 1;
      if (nodes[middle] <= value) lower = middle;
      else above = middle;
    }
    const upper = Math.min(lower + 1, last);
    const weight = upper > lower ? (value - nodes[lower]) / (nodes[upper] - nodes[lower]) : 0;
    return { lower, upper: upper % this.nodes.length, weight };
  }
}
