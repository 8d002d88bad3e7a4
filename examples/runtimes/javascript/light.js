// The light of the sky on faces of any direction, as weights of functions of that direction.
import { CODES, GLOW, LIGHT } from "./layouts.js";

// A_l / pi times Y_lm of a unit normal, in the order of the codes.
function irradianceHarmonics([x, y, z]) {
  const even = x * x - y * y;
  return [
    0.28209479177387814,
    0.32573500793527993 * z,
    0.32573500793527993 * x,
    (0.15769578262626002 * (3 * z * z - 1)) / 2,
    0.2731371076480198 * x * z,
    0.1365685538240099 * even,
    (-0.03526184897173477 * (35 * z ** 4 - 30 * z * z + 3)) / 8,
    (-0.0557538786297741 * x * z * (7 * z * z - 3)) / 2,
    (-0.039423945656565 * even * (7 * z * z - 1)) / 2,
    (-0.14751089748166088 * x * z * (x * x - 3 * y * y)) / 2,
    -0.026076488977049006 * (even * even - 4 * x * x * y * y),
  ];
}

// Functions of a unit normal in the frame of the source's azimuth: the first for the light that no harmonic holds, then the harmonics.
export function bases(fourthDegree, normal) {
  const square = normal[2] ** 2;
  const rest = fourthDegree ? (((231 * square - 315) * square + 105) * square - 5) / 16 : ((35 * square - 30) * square + 3) / 8;
  return [rest, ...irradianceHarmonics(normal)];
}

export const hasFourthDegree = (air) => air.codesOf(LIGHT).length > 6;

// Unit normal of a face with an azimuth from that of the source, in degree.
export function normalOf(slope, azimuth) {
  const [tilt, turn] = [slope, azimuth].map((angle) => (angle * Math.PI) / 180);
  return [Math.sin(tilt) * Math.cos(turn), Math.sin(tilt) * Math.sin(turn), Math.cos(tilt)];
}

// L_ambient as weights of the bases, each a list of wavelengths, or of one value for the whole band; `ground` is the temperature of the
// ground and what it emits. One weight, of level faces, where there is no ground.
export function ambientWeights(air, where, ground, byWavelength) {
  const light = (name, place) => (byWavelength ? air.light(name, place) : [air.value(name, place)]);
  const level = light("ambient_radiance", where);
  if (!ground) return [level];
  const [temperature, emitted] = ground;
  const harmonics = air.codesOf(LIGHT).map((harmonic) => light(LIGHT, { ...where, harmonic }));
  for (const code of air.codesOf(GLOW)) {
    const glow = light(GLOW, { ...where, ground_temperature: temperature, zonal_harmonic: code });
    const part = harmonics[CODES.harmonic.indexOf(code)];
    glow.forEach((value, b) => (part[b] += emitted * value));
  }
  const upright = irradianceHarmonics([0, 0, 1]);
  const rest = level.map((value, b) => value - harmonics.reduce((all, part, k) => all + part[b] * upright[k], 0));
  return [rest, ...harmonics];
}

// Light at each wavelength, at least 0.
export function summed(weights, at) {
  return weights[0].map((_, b) => Math.max(weights.reduce((all, part, k) => all + part[b] * at[k], 0), 0));
}
