// A road with two cabins in the infrared: three.js draws it, the include of the export computes each pixel's radiance.
import * as THREE from "three";
import { loadFrame } from "./skyshine.js";

const SIZE = [960, 540];
const VERTEX = `
in vec3 position;
in vec3 normal;
uniform mat4 modelMatrix, viewMatrix, projectionMatrix;
out vec3 place;
out vec3 side;
void main() {
  place = (modelMatrix * vec4(position, 1.0)).xyz;
  side = mat3(modelMatrix) * normal;
  gl_Position = projectionMatrix * viewMatrix * vec4(place, 1.0);
}`;
// The frame of the scene is east, north, up, in metres.
const FRAGMENT = `
in vec3 place;
in vec3 side;
uniform vec3 cameraPosition, toSource;
uniform int row;
uniform float ground;
out vec4 result;
void main() {
  SkyshineFace face;
  vec3 way = cameraPosition - place;
  face.toObserver = normalize(way);
  face.toSource = toSource;
  face.normal = normalize(side);
  float slope = skyshineAngle(length(face.normal.xy), face.normal.z);
  float azimuth = skyshineAngle(face.normal.x, face.normal.y);
  SkyshineAirOfPixel air = skyshineAirAt(length(way) * 0.001, face.toObserver);
  float kelvin = skyshineTemperature(row, ground + place.z * 0.001, azimuth, slope);
  float radiance = skyshineSurfaceRadiance(air, row, kelvin, face) + skyshinePath(air, face);
  result = vec4(radiance, skyshineApparentTemperature(radiance), kelvin, 1.0);
}`;
const SCREEN = `
precision highp float;
uniform highp sampler2D scene;
uniform vec2 levels;
out vec4 colour;
void main() {
  vec4 pixel = texelFetch(scene, ivec2(gl_FragCoord.xy), 0);
  float white = clamp((pixel.g - levels.x) / (levels.y - levels.x), 0.0, 1.0);
  colour = vec4(pixel.a > 0.0 ? vec3(white) : vec3(0.13, 0.15, 0.19), 1.0);
}`;

const frame = await loadFrame(new URLSearchParams(location.search).get("data") ?? "gpu");

const scene = new THREE.Scene();
function add(geometry, material, [x, y, z], turn = 0) {
  const row = frame.materials.indexOf(material);
  if (row < 0) throw new Error(`the tables lack ${material}; they have ${frame.materials.join(", ")}`);
  const uniforms = { ...frame.uniforms, toSource: { value: frame.toSource }, row: { value: row }, ground: { value: frame.ground } };
  const shader = new THREE.RawShaderMaterial({ glslVersion: THREE.GLSL3, vertexShader: VERTEX, fragmentShader: frame.include + FRAGMENT, uniforms });
  const mesh = new THREE.Mesh(geometry, shader);
  mesh.position.set(x, y, z);
  mesh.rotation.z = turn;
  scene.add(mesh);
}
add(new THREE.PlaneGeometry(4000, 4000), "grass_green", [0, 0, 0]);
add(new THREE.PlaneGeometry(12, 4000), "asphalt_road", [0, 0, 0.3], -0.3);
for (const [x, y] of [[-40, 10], [45, -30]]) add(new THREE.BoxGeometry(30, 18, 12), "wood_pine_weathered", [x, y, 6], 0.4);
for (let k = 0; k < 60; k++) {
  const [x, y] = [((k * 97) % 400) - 200, ((k * 61) % 380) - 120];
  if (Math.abs(x - 0.31 * y) > 25 && Math.hypot(x + 40, y - 10) > 35 && Math.hypot(x - 45, y + 30) > 35) {
    add(new THREE.ConeGeometry(6, 18, 24).rotateX(Math.PI / 2), "conifer", [x, y, 9]);
  }
}

// The air of the frame is that of its altitude: the camera keeps it.
const camera = new THREE.PerspectiveCamera(18, SIZE[0] / SIZE[1], 10, 20000);
camera.up.set(0, 0, 1);
camera.position.set(250, -500, frame.height);
camera.lookAt(0, 20, 0);

const renderer = new THREE.WebGLRenderer({ canvas: document.getElementById("picture") });
renderer.setSize(...SIZE);
const target = new THREE.WebGLRenderTarget(...SIZE, { type: THREE.FloatType, format: THREE.RGBAFormat, minFilter: THREE.NearestFilter, magFilter: THREE.NearestFilter });
renderer.setRenderTarget(target);
renderer.setClearColor(0x000000, 0);
renderer.render(scene, camera);
const values = new Float32Array(4 * SIZE[0] * SIZE[1]);
renderer.readRenderTargetPixels(target, 0, 0, ...SIZE, values);

const apparent = Array.from({ length: SIZE[0] * SIZE[1] }, (_, k) => values[4 * k + 1]).filter((kelvin, k) => values[4 * k + 3] > 0);
const sorted = apparent.sort((a, b) => a - b);
const levels = [0.01, 0.99].map((share) => sorted[Math.floor(share * (sorted.length - 1))]);
const screen = new THREE.Mesh(
  new THREE.PlaneGeometry(2, 2),
  new THREE.RawShaderMaterial({
    glslVersion: THREE.GLSL3,
    vertexShader: "in vec3 position; void main() { gl_Position = vec4(position, 1.0); }",
    fragmentShader: SCREEN,
    uniforms: { scene: { value: target.texture }, levels: { value: levels } },
  }),
);
renderer.setRenderTarget(null);
renderer.render(screen, camera);

const hour = `${String(Math.floor(frame.hour)).padStart(2, "0")}:00`;
const text = `${frame.wavelength.join(" to ")} µm at ${hour}: apparent temperature, black ${levels[0].toFixed(1)} K, white ${levels[1].toFixed(1)} K`;
document.getElementById("text").textContent = text;

// Values of the pixel over a place of the scene, for tests; rows count from the top.
window.probe = (x, y, z) => {
  const at = new THREE.Vector3(x, y, z).project(camera);
  const [column, row] = [Math.floor(((at.x + 1) / 2) * SIZE[0]), Math.floor(((at.y + 1) / 2) * SIZE[1])];
  return { camera: camera.position.toArray(), column, row: SIZE[1] - 1 - row, values: [...values.slice(4 * (row * SIZE[0] + column), 4 * (row * SIZE[0] + column) + 4)] };
};
