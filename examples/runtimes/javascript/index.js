// Reading of the databases that `mat build` and `tmm classify` write, for a scene runtime. Types and units: index.d.ts.
export { SkyshineError } from "./kernel.js";
export { open, openFiles, openTexture, SHADED_SKY } from "./tables.js";

export { FORMAT } from "./source.js";
