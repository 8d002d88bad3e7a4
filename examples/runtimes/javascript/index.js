// Reading of the databases that `mat build` and `tmm build` write, for a scene runtime. Types and units: index.d.ts.
export { SkyshineError } from "./kernel.js";
export { open, openFiles, openTexture, SHADED_SKY } from "./tables.js";

// The newest formats that this version knows; it reads all minor versions of their major ones, of .band from 1.5 on.
export const FORMATS = [["htt", "1.9"], ["band", "1.6"], ["atmq", "4.0"], ["tmm", "1.6"]];
