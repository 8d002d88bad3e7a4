#!/usr/bin/env node
// The program of this folder: the radiance of the pixels of a scene, by the public calls alone.
// Usage: node runtime.js SCENE.json
// The scene and the result are described in ../README.md.
import { readFileSync } from "node:fs";
import { dirname, isAbsolute, join } from "node:path";
import { openFiles, openTexture, SHADED_SKY, SkyshineError } from "./index.js";

// Code of a material given by code or by name.
function codeOf(tables, given) {
  const found = typeof given === "string" ? tables.materials().find(({ name }) => name === given)?.code : given;
  if (found === undefined) throw new SkyshineError(`material: found '${given}'; allowed: a name of the file`);
  return found;
}

// The source of a pixel: as it says, or by the tracks of the surface file.
function sourceOf(tables, given) {
  if (given.source_elevation !== undefined)
    return { sourceElevation: given.source_elevation, sourceAzimuth: given.source_azimuth, sourceHeading: given.source_heading, toSource: given.to_source };
  const { elevation, heading } = tables.sourcePosition(given.time);
  if (!Number.isFinite(given.line_heading)) throw new SkyshineError("the scene lacks 'line_heading'");
  const [up, turn] = [elevation, heading].map((angle) => (angle * Math.PI) / 180);
  return {
    sourceElevation: elevation,
    sourceAzimuth: given.source_azimuth ?? heading - given.line_heading,
    sourceHeading: given.source_heading ?? heading,
    toSource: given.to_source ?? [Math.cos(up) * Math.sin(turn), Math.cos(up) * Math.cos(turn), Math.sin(up)],
  };
}

// Codes and shares of the materials that the pixel sees, and its share in the shade: of a texel, or of one material.
function materialsOf(tables, texture, { material, texel, level = 0 }) {
  if (texel === undefined) return [[{ code: codeOf(tables, material), share: 1 }], 0];
  if (!texture) throw new SkyshineError("the scene lacks 'texture'");
  if (!Array.isArray(texel) || texel.length !== 2) throw new SkyshineError("'texel' must be two numbers");
  return [texture.mixture(...texel, level).map(([code, share]) => ({ code, share })), texture.shade(...texel, level)];
}

// Temperature of a material where the pixel has surroundings or other heat.
function temperatureOf(tables, face, { absorbed_change: absorbed, surroundings: around }) {
  if (around) {
    const { shade, sky_view: skyView, facing, facing_emissivity: facingEmissivity } = around;
    return tables.shadedTemperature(face, { shade, skyView, facing, facingEmissivity });
  }
  return absorbed ? tables.heatedTemperature(face, absorbed) : undefined;
}

// Temperature of a material in the shade all day, under no more of the sky than `open`, where the pixel has surroundings.
function temperatureInShade(tables, face, { absorbed_change: absorbed, surroundings: around }, open) {
  if (!around && absorbed) throw new SkyshineError("a texel in the shade takes 'surroundings' in place of 'absorbed_change'");
  if (!around) return undefined;
  const { sky_view: skyView = 1, facing, facing_emissivity: facingEmissivity } = around;
  return tables.shadedTemperature(face, { shade: [[0, 24]], skyView: Math.min(skyView, open), facing, facingEmissivity });
}

function pixel(scene, tables, texture, given) {
  const place = { surfaceAltitude: given.surface_altitude, surfaceAzimuth: given.surface_azimuth, surfaceSlope: given.surface_slope, time: given.time };
  const face = { altitude: given.surface_altitude, azimuth: given.surface_azimuth, slope: given.surface_slope, time: given.time };
  const [materials, shade] = materialsOf(tables, texture, given);
  const sky = { shade, skyView: given.sky_view ?? 1, shadedSky: scene.shaded_sky ?? SHADED_SKY };
  for (const each of materials) {
    each.temperature = temperatureOf(tables, { ...face, material: each.code }, given);
    if (shade > 0) each.shadedTemperature = temperatureInShade(tables, { ...face, material: each.code }, given, Math.min(sky.skyView, sky.shadedSky));
  }
  const terms = tables.pixelRadiance({
    ...place, ...sourceOf(tables, given), ...sky, materials,
    range: given.range, centreRange: given.centre_range, centreElevation: given.centre_elevation, altitude: given.altitude,
    groundMaterial: given.ground_material === undefined ? undefined : codeOf(tables, given.ground_material),
    normal: given.normal, toObserver: given.to_observer,
  });
  const { blackbodyRadiance: blackbody_radiance, betaStar: beta_star, ...rest } = terms;
  const pixel_value = tables.pixelValue(terms.radiance, { bits: scene.bits, gain: scene.gain, bufferGain: scene.buffer_gain, offset: scene.offset });
  return { material: materials[0].code, ...rest, blackbody_radiance, beta_star, pixel_value };
}

// Radiances of a frame, computed as often as the scene says.
function frame(tables, given) {
  const view = {
    altitude: given.altitude, centreRange: given.centre_range, centreElevation: given.centre_elevation, centreHeading: given.centre_heading,
    sourceElevation: given.source_elevation, sourceHeading: given.source_heading, time: given.time,
    groundMaterial: given.ground_material === undefined ? undefined : codeOf(tables, given.ground_material), groundAltitude: given.ground_altitude,
  };
  const list = (name) => (given[name] ? Float64Array.from(given[name]) : undefined);
  const pixels = {
    material: Int32Array.from(given.material, (material) => codeOf(tables, material)), range: list("range"),
    elevation: list("elevation"), heading: list("heading"), surfaceAltitude: list("surface_altitude"),
    surfaceAzimuth: list("surface_azimuth"), surfaceSlope: list("surface_slope"), temperature: list("temperature"),
  };
  const radiance = new Float64Array(pixels.material.length);
  for (let turn = 0; turn < (given.repeat ?? 1); turn++) tables.frameRadiance(view, pixels, radiance);
  return { radiance: Array.from(radiance) };
}

async function main(path) {
  const scene = JSON.parse(readFileSync(path, "utf-8"));
  const place = (name) => (isAbsolute(name) ? name : join(dirname(path), name));
  const files = { surface: place(scene.surface), band: place(scene.band), atmosphere: place(scene.atmosphere) };
  const tables = await openFiles(files, scene.clamp ?? []);
  const texture = scene.texture === undefined ? null : await openTexture(place(scene.texture));
  const shown = scene.frame ? frame(tables, scene.frame) : { pixels: scene.pixels.map((given) => pixel(scene, tables, texture, given)) };
  console.log(JSON.stringify(shown));
}

main(process.argv[2]).catch((error) => {
  console.error(String(error.message).replace(/[\p{C}\p{Zl}\p{Zp}]/gu, "?"));
  process.exitCode = 1;
});
