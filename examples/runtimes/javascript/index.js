// Reading of the databases that `mat build` and `tmm build` write, for a scene runtime. Types and units: index.d.ts.
export { SkyshineError } from "./axis.js";
export { pixelValue, SHADED_SKY } from "./pixel.js";
export { open, openFiles, openTexture } from "./tables.js";

// The newest formats that this version knows; it reads all minor versions of their major ones.
export const FORMATS = [["htt", "1.8"], ["band", "1.5"], ["atmq", "2.4"], ["atmq", "3.4"], ["tmm", "1.5"]];
