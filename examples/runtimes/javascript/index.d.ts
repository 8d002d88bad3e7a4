/**
 * Reading of the databases that `mat build` and `tmm classify` write, for a scene runtime.
 *
 * Radiances are in W m^-2 sr^-1, lengths in km, angles in degree, times in hours of the local clock, temperatures in K.
 * Elevations of lines of sight are apparent, those of Sun and Moon geometric; headings are azimuths from north eastward.
 * Equation numbers are those of DSTO-TN-0193. Every call throws a {@link SkyshineError} where it cannot answer.
 */

/** What was found, and what is allowed, in one line. */
export class SkyshineError extends Error {
  /** `file`: a file is missing, damaged, of another format, or does not fit the others; `value`: one that the tables do not hold. */
  readonly kind: "file" | "value";
}

/** Version of the formats that this version knows; it reads all minor versions of its major one. */
export const FORMAT: string;

/** Open share of the sky above what a texture shows in the shade, where a scene says nothing else: 0.5. */
export const SHADED_SKY: number;

/** Names of axes on which values outside are read at the nearest node. */
export type Clamp = readonly string[];

export interface Selection {
  /** Number of the state, from 1 (the default), as in the names of the files. */
  state?: number;
  /** Number of the band, from 1 (the default). */
  band?: number;
  /** `sun` by default. */
  source?: "sun" | "moon";
  clamp?: Clamp;
}

/** A path (in Node), or the bytes of a file. */
export type File = string | Uint8Array;

export interface Files {
  /** .htt */
  surface: File;
  /** .band */
  band: File;
  /** .atmq or .lunar_atmq */
  atmosphere: File;
}

export interface Material {
  code: number;
  name: string;
}

/** A face of a material. */
export interface Face {
  /** Code. */
  material: number;
  altitude: number;
  azimuth: number;
  slope: number;
  time: number;
}

/** What keeps sunlight and sky from a face. */
export interface Surroundings {
  /** Hours from first to last, over midnight where the first is later; they do not overlap. */
  shade?: readonly (readonly [first: number, last: number])[];
  /** Open share of the sky, 1 by default. */
  skyView?: number;
  /** Temperature of the wall that hides the rest; by default that of the air. */
  facing?: number;
  /** Of that wall, 0.95 by default. */
  facingEmissivity?: number;
}

/** A line of sight, and the source: its azimuth relative to the line. */
export interface Line {
  range: number;
  /** Of the observer. */
  altitude: number;
  elevation: number;
  sourceElevation: number;
  sourceAzimuth: number;
}

export type Direction = readonly [number, number, number];

/** A pixel; the atmosphere is read at the range and elevation of the centre. */
export interface Pixel {
  /**
   * Shares sum to 1; a temperature in place of that of the tables, and one of what of the material lies in the shade in place of that
   * by the response of the surface file.
   */
  materials: readonly { code: number; share: number; temperature?: number; shadedTemperature?: number }[];
  surfaceAltitude: number;
  surfaceAzimuth: number;
  surfaceSlope: number;
  time: number;
  range: number;
  centreRange: number;
  centreElevation: number;
  altitude: number;
  sourceElevation: number;
  /** Relative to the line of sight. */
  sourceAzimuth: number;
  /** Without it, the sky of a level face is taken. */
  sourceHeading?: number;
  /** Code; without it, the ground that the atmosphere file states. */
  groundMaterial?: number;
  /** Directions from the surface point, of any length, in any frame. */
  normal: Direction;
  toSource: Direction;
  toObserver: Direction;
  /** Open share of the sky above it, 1 by default; what hides the rest is as warm as the air. */
  skyView?: number;
  /** Share of it in the shade all day, of {@link Texture.shade}; none by default. No direct light falls there. */
  shade?: number;
  /** Open share of the sky there, {@link SHADED_SKY} by default and never more than `skyView`. */
  shadedSky?: number;
}

/** The terms of a pixel. */
export interface Terms {
  temperature: number;
  /** (7) */
  blackbodyRadiance: number;
  betaStar: number;
  /** (9) */
  transmittance: number;
  /** (6) */
  thermal: number;
  /** (11) */
  path: number;
  /** (19) */
  skyshine: number;
  /** (34) */
  diffuse: number;
  /** (35), with the lobe of (37) and (38) */
  specular: number;
  /** (1) */
  radiance: number;
}

/** What all pixels of a frame share: one observer, one source, one time. */
export interface View {
  /** Of the observer. */
  altitude: number;
  /** The line of sight at which the atmosphere is read. */
  centreRange: number;
  centreElevation: number;
  centreHeading: number;
  sourceElevation: number;
  sourceHeading: number;
  time: number;
  /** Code; without it, the ground that the atmosphere file states. */
  groundMaterial?: number;
  /** Of that material. */
  groundAltitude?: number;
}

/** Pixels of a frame: lists with one value for each. */
export interface Pixels {
  /** Codes. */
  material: ArrayLike<number>;
  range: ArrayLike<number>;
  /** Of the lines of sight, for the lobe; by default those of the centre. */
  elevation?: ArrayLike<number>;
  heading?: ArrayLike<number>;
  surfaceAltitude: ArrayLike<number>;
  surfaceAzimuth: ArrayLike<number>;
  surfaceSlope: ArrayLike<number>;
  /** By default those of the tables. */
  temperature?: ArrayLike<number>;
}

/** The tables of a state, a band and a source. */
export interface Tables {
  /** Materials of the band, by ascending code. */
  materials(): Material[];
  /** Temperature of a face in full sun under the whole sky. */
  temperature(face: Face): number;
  /** Temperature of a face with surroundings. */
  shadedTemperature(face: Face, surroundings: Surroundings): number;
  /** Transmittance of the band along a line, (9). Its source is not read. */
  transmittance(line: Line): number;
  /** What the air along a line emits and scatters to its beginning, (11). */
  pathRadiance(line: Line): number;
  /**
   * Light of the sky on a face at the end of a line, over pi; `azimuth` of the face is relative to that of the source. A tilted
   * face needs a file with harmonics; its ground is that which the file states.
   */
  ambientRadiance(line: Line, face?: { slope?: number; azimuth?: number }): number;
  /** Light of the source on a surface normal to it at the end of a line, over pi. */
  directRadiance(line: Line): number;
  /** The terms of a pixel, (1). */
  pixelRadiance(pixel: Pixel): Terms;
  /** Temperature of the black body that has a radiance in the band. */
  apparentTemperature(radiance: number): number;
  /** Radiances of the pixels of a frame, into `to` where it is given; the atmosphere is read once, at the centre. */
  frameRadiance(view: View, pixels: Pixels, to?: Float64Array): Float64Array;
  /** Pixel value of a radiance, (44), rounded to the nearest integer. */
  pixelValue(radiance: number, camera: { bits: number; gain: number; bufferGain?: number; offset?: number }): number;
  /**
   * Temperature of a face that absorbs other heat than that of the tables: means over equal steps of the day, each centred on its
   * time, the first on midnight, in W m^-2.
   */
  heatedTemperature(face: Face, absorbed: number[]): number;
  /** Elevation and heading of the tables' source at a time, 0 to 36 h, from the tracks of the surface file. */
  sourcePosition(time: number): { elevation: number; heading: number };
}

/** A texture, from whose texels materials are read. */
export interface Texture {
  /** Codes and shares at a point, in texels of level 0 from the top left corner of the image. */
  mixture(across: number, down: number, level?: number): [code: number, share: number][];
  /** Share of the texel at that point in the shade of its photograph; 0 where the file has no such layer. */
  shade(across: number, down: number, level?: number): number;
}

/** Open a state, a band and a source in the folder of a build, by its `catalog.json` (in Node). */
export function open(folder: string, selection?: Selection): Promise<Tables>;
/** {@link open} of named files. */
export function openFiles(files: Files, clamp?: Clamp): Promise<Tables>;
/** Open a .tmm file and read its level 0. */
export function openTexture(file: File): Promise<Texture>;
