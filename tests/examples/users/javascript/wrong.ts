// What the types must refuse: a face without its slope.
import { openFiles } from "skyshine";

const tables = await openFiles({ surface: "a", band: "b", atmosphere: "c" });
console.log(tables.temperature({ material: 1, altitude: 0, azimuth: 0, time: 12 }));
