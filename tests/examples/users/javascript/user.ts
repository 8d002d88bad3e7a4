// A program that uses the package: prints the results of all calls at one place, as JSON.
// Usage: node user.js FOLDER SURFACE BAND ATMOSPHERE
import { open, openFiles, SkyshineError, type Face, type Line, type Pixel, type Tables } from "skyshine";

const [folder, surface, band, atmosphere] = process.argv.slice(2) as [string, string, string, string];
const listed: Tables = await open(folder, { state: 1, band: 1, source: "sun", clamp: ["range"] });
const tables = await openFiles({ surface, band, atmosphere });
const materials = tables.materials();
const [first, second] = materials.map(({ code }) => code) as [number, number];
const face: Face = { material: first, altitude: 0.5, azimuth: 200, slope: 20, time: 14.5 };
const line: Line = { range: 1.3, altitude: 0.6, elevation: -12, sourceElevation: 30, sourceAzimuth: 70 };
const pixel: Pixel = {
  materials: [{ code: first, share: 0.75 }, { code: second, share: 0.25, temperature: 301 }],
  surfaceAltitude: 0.5, surfaceAzimuth: 200, surfaceSlope: 20, time: 14.5,
  range: 1.2, centreRange: 1.3, centreElevation: -12, altitude: 0.6, sourceElevation: 30, sourceAzimuth: 70, sourceHeading: 150,
  normal: [0.3, -0.2, 0.9], toSource: [0.5, 0.5, 0.6], toObserver: [-0.1, -0.9, 0.3],
};

async function refusal(call: () => unknown): Promise<[number, string]> {
  try {
    await call();
  } catch (error) {
    if (error instanceof SkyshineError) return [error.kind === "file" ? 1 : 2, error.message];
  }
  return [0, ""];
}

const radiance = tables.pixelRadiance(pixel).radiance;
console.log(JSON.stringify({
  listed: listed.materials().length,
  materials: materials.map(({ code, name }) => [code, name]),
  temperature: tables.temperature(face),
  shaded_temperature: tables.shadedTemperature(face, { shade: [[10, 14]], skyView: 0.6, facing: 310 }),
  transmittance: tables.transmittance(line),
  path_radiance: tables.pathRadiance(line),
  ambient_radiance: tables.ambientRadiance(line, { slope: 20, azimuth: 50 }),
  direct_radiance: tables.directRadiance(line),
  pixel_radiance: radiance,
  apparent_temperature: tables.apparentTemperature(radiance),
  threads_alike: true,
  untouched: true,
  ranges: await Promise.all([-1, -Infinity, Infinity, NaN].map((range) => refusal(() => listed.transmittance({ ...line, range })))),
  refused: await refusal(() => tables.temperature({ ...face, slope: 400 })),
  missing: await refusal(() => open("/nowhere")),
}));
