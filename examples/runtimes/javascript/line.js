// Lines of sight as places in the tables.
const radians = (angle) => (angle * Math.PI) / 180;

// Angle between line of sight and source, all in degree.
function scatteringAngle(elevation, sourceElevation, azimuth) {
  const [line, source, turn] = [elevation, sourceElevation, azimuth].map(radians);
  const half = Math.sin((line - source) / 2) ** 2 + Math.cos(line) * Math.cos(source) * Math.sin(turn / 2) ** 2;
  return (2 * Math.asin(Math.sqrt(Math.min(Math.max(half, 0), 1))) * 180) / Math.PI;
}

// A line as values of the axes of the tables.
export function placeOf({ range, altitude, elevation, sourceElevation, sourceAzimuth }) {
  const scattering_angle = scatteringAngle(elevation, sourceElevation, sourceAzimuth);
  return { range, altitude, elevation, source_elevation: sourceElevation, source_azimuth: sourceAzimuth, scattering_angle };
}
