// A plan of materials in the infrared, from textures of `mat export --to gpu`, by the shader of that export.
"use strict";

(() => {
  const { settings, files } = SKYSHINE;
  const element = (id) => document.getElementById(id);
  const { texels, numbers, halfToFloat, cell, mixed, track, termsOf, observerOf } = SKYSHINE.tables;

  const canvas = element("picture");
  const gl = canvas.getContext("webgl2", { antialias: false, preserveDrawingBuffer: true });
  if (!gl || !gl.getExtension("EXT_color_buffer_float")) {
    element("message").textContent = "This browser draws no floating-point pictures (WebGL2 with EXT_color_buffer_float).";
    return;
  }
  const debug = gl.getExtension("WEBGL_debug_renderer_info");
  const renderer = gl.getParameter(debug ? debug.UNMASKED_RENDERER_WEBGL : gl.RENDERER);
  element("renderer").textContent = (/SwiftShader|llvmpipe/.exec(renderer) ?? [renderer.slice(0, 60)])[0]; // software, by its name

  const { WHOLE, PLAN, CORNERS, MESH, PICTURE, camera } = SKYSHINE.surfaces;

  function program(vertex, fragment) {
    const made = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text.trim());
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(made, shader);
    }
    gl.linkProgram(made);
    if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made));
    const uniforms = {};
    const count = gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS);
    for (let k = 0; k < count; k++) {
      const name = gl.getActiveUniform(made, k).name.replace("[0]", "");
      uniforms[name] = gl.getUniformLocation(made, name);
    }
    return { made, uniforms };
  }

  const UPLOADS = {
    R16F: [gl.R16F, gl.RED, gl.HALF_FLOAT],
    RGBA16F: [gl.RGBA16F, gl.RGBA, gl.HALF_FLOAT],
    R32F: [gl.R32F, gl.RED, gl.FLOAT],
    RGBA32F: [gl.RGBA32F, gl.RGBA, gl.FLOAT],
    R16UI: [gl.R16UI, gl.RED_INTEGER, gl.UNSIGNED_SHORT],
    R8: [gl.R8, gl.RED, gl.UNSIGNED_BYTE],
    RGBA8: [gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE],
  };

  function texture(format, [width, height, depth], values, { solid = false, linear = false } = {}) {
    const target = solid ? gl.TEXTURE_3D : gl.TEXTURE_2D;
    const made = gl.createTexture();
    gl.bindTexture(target, made);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    const filter = linear ? gl.LINEAR : gl.NEAREST;
    for (const [name, value] of [
      [gl.TEXTURE_MIN_FILTER, filter],
      [gl.TEXTURE_MAG_FILTER, filter],
      [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE],
      [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE],
      [gl.TEXTURE_WRAP_R, gl.CLAMP_TO_EDGE],
    ]) gl.texParameteri(target, name, value);
    let [inside, order, type] = UPLOADS[format];
    if (values instanceof Float32Array) type = gl.FLOAT; // GL rounds to half floats
    if (solid) gl.texImage3D(target, 0, inside, width, height, depth, 0, order, type, values);
    else gl.texImage2D(target, 0, inside, width, height, 0, order, type, values);
    return { target, made };
  }

  const stored = (name, part, options) => {
    const { format, size } = files[name].header.textures[part];
    return texture(format, size, texels(name, part), options);
  };

  // Mixtures with rows of the tables in place of material codes.
  function mixtureTexture(name, materials) {
    const { size } = files[name].header.textures.mixtures;
    const words = texels(name, "mixtures");
    const values = new Float32Array(words.length);
    const total = numbers(name).share_total;
    const rows = new Map(materials.map((code, row) => [code, row]));
    for (let k = 0; k < words.length; k += 8) {
      for (let part = 0; part < 3; part++) {
        const share = words[k + 4 + part] / total;
        values[k + part] = rows.get(words[k + part]) ?? 0;
        values[k + 4 + part] = rows.has(words[k + part]) ? share : 0;
      }
    }
    return texture("RGBA32F", size, values);
  }

  const { columns, rows } = settings;
  canvas.width = columns;
  canvas.height = rows;
  const { mesh } = settings;
  const [scenePass, picturePass] = [mesh ? program(CORNERS, MESH) : program(WHOLE, PLAN), program(WHOLE, PICTURE)];

  // A picture of every `stride`-th pixel for the moment, and the picture itself, with the values that were read back.
  function newTarget() {
    const { made } = texture("RGBA32F", [columns, rows, 1], null);
    const framebuffer = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, made, 0);
    if (mesh) {
      const depth = gl.createRenderbuffer();
      gl.bindRenderbuffer(gl.RENDERBUFFER, depth);
      gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT24, columns, rows);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, depth);
    }
    return { made, framebuffer, values: new Float32Array(4 * columns * rows) };
  }
  const [coarse, fine] = [newTarget(), newTarget()];
  const palettes = settings.palettes.map(({ colours }) =>
    texture("RGBA8", [colours.length, 1, 1], Uint8Array.from(colours.flatMap((colour) => [...colour, 255])), { linear: true }),
  );

  // Triangles: corner, normal, texture coordinates and covering of each vertex.
  const VERTEX = [3, 3, 2, 1];
  const triangles = mesh ? texels(mesh.data, "corners") : new Float32Array(0);
  const [vertices, coverings] = [gl.createBuffer(), Array.from({ length: triangles.length / 9 }, (_, k) => triangles[9 * k + 8])];

  // Triangles whose coverings name rows of the tables of a band in place of codes.
  function uploadTriangles(materials) {
    const values = Float32Array.from(triangles);
    coverings.forEach((code, k) => (values[9 * k + 8] = code < 0 ? code : materials.indexOf(code)));
    gl.bindBuffer(gl.ARRAY_BUFFER, vertices);
    gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
    VERTEX.reduce((offset, count, place) => {
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, count, gl.FLOAT, false, 36, 4 * offset);
      return offset + count;
    }, 0);
  }

  function setTriangles(at, materials, stretch) {
    const { observer, view, above } = camera(mesh, columns, rows, stretch);
    uploadTriangles(materials);
    gl.uniformMatrix4fv(at.view, false, view);
    gl.uniform3f(at.observer, ...observer);
    gl.uniform2f(at.scene, above, settings.surface_km);
    if (mesh.parts.length > 0) gl.uniform4fv(at.parts, mesh.parts.flat());
    return () => {
      gl.enable(gl.DEPTH_TEST);
      gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, -1]);
      gl.clear(gl.DEPTH_BUFFER_BIT);
      gl.drawArrays(gl.TRIANGLES, 0, triangles.length / 9);
      gl.disable(gl.DEPTH_TEST);
    };
  }

  function setPlan(at, range) {
    const up = (settings.altitude_km - settings.surface_km) * 1000;
    gl.uniform3f(at.observer, 0, -Math.sqrt(Math.max((range * 1000) ** 2 - up * up, 0)), up);
    gl.uniform4f(at.plan, columns, rows, settings.metres_per_texel, settings.surface_km);
    return () => gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  const kept = new Map(); // textures by what they hold
  function keep(name, make) {
    if (!kept.has(name)) kept.set(name, make());
    return kept.get(name);
  }
  const changing = new Map(); // textures of a frame, replaced by those of the next
  function replaced(name, made) {
    if (changing.has(name)) gl.deleteTexture(changing.get(name).made);
    changing.set(name, made);
    return made;
  }

  // The air file of a band and the source that stands for an hour.
  function airOf(band, wanted, hour) {
    const has = (source) => band.air[source] !== undefined;
    let source = wanted;
    if (wanted === "auto") source = track(band.surface, "sun", hour)[0] < -6 && has("moon") ? "moon" : "sun";
    if (!has(source)) source = Object.keys(band.air)[0];
    return { source, name: band.air[source] };
  }

  // Nodes of the axes, one a row.
  function nodesOf(air, surface) {
    const [own, faces] = [numbers(air), numbers(surface)];
    const axes = [own.axes[0], own.axes[1], own.emission_temperature, own.angle, faces.azimuth, faces.slope, faces.altitude];
    axes.push(faces.shaded_azimuth ?? [0], faces.shaded_slope ?? [0]);
    const width = Math.max(...axes.map((axis) => axis.length));
    const values = new Float32Array(width * axes.length);
    axes.forEach((axis, row) => values.set(axis, row * width));
    return texture("R32F", [width, axes.length, 1], values);
  }

  const shaded = files[settings.texture].header.textures.shade0 !== undefined;

  // Temperatures of an hour: those of two times of the table, mixed. Returns what is around faces in the shade.
  function temperaturesOf(surface, hour) {
    const own = numbers(surface);
    const times = own.time_repeats ? [...own.time, own.time[0] + 24] : own.time;
    const first = own.time[0];
    const turned = hour - 24 * Math.floor((hour - first) / 24);
    if (turned > times[times.length - 1]) throw new Error("The table has no temperatures of this hour.");
    const [lower, upper, weight] = cell(times, turned);
    const place = [lower, upper % own.time.length, weight];
    const floats = keep(`floats ${surface}`, () => Float32Array.from(texels(surface, "temperature"), halfToFloat));
    const { size } = files[surface].header.textures.temperature;
    const layers = size[2] / own.time.length;
    const above = mixed(floats, own.time.length, place);
    const reference = mixed(texels(surface, "reference"), own.time.length, place);
    replaced("temperatures", texture("R16F", [size[0], size[1], layers], above, { solid: true, linear: true }));
    replaced("reference", texture("R32F", [layers, 1, 1], reference));
    return shaded ? changeOf(surface, own, turned, layers) : [0, 0, 0];
  }

  // The change of temperatures in the shade, as the temperatures; returns what is around faces there.
  function changeOf(surface, own, turned, layers) {
    const size = [own.shaded_azimuth.length, own.shaded_slope.length, layers];
    const count = own.shaded_time.length;
    const hours = own.time_repeats ? [...own.shaded_time, own.shaded_time[0] + 24] : own.shaded_time;
    const [lower, upper, weight] = cell(hours, own.time_repeats ? turned % 24 : turned);
    const place = [lower, upper % count, weight];
    const floats = keep(`change ${surface}`, () => Float32Array.from(texels(surface, "shaded_change"), halfToFloat));
    replaced("shaded_change", texture("R16F", size, mixed(floats, count, place), { solid: true, linear: true }));
    const air = mixed(own.air_temperature.flat(), count, place);
    return [1, 1 - own.shaded_sky, air.reduce((total, kelvin) => total + kelvin, 0) / air.length];
  }

  // Sets textures and numbers of a frame; returns the direction of the source and a function that draws radiances.
  function setScene({ band, hour, wanted, range }) {
    const { source, name } = airOf(band, wanted, hour);
    const [elevation, azimuth] = track(band.surface, source, hour);
    const [own, faces, glow] = [numbers(name), numbers(band.surface), numbers(band.band)];
    const terms = termsOf(name, elevation, hour);
    replaced("terms", texture("RGBA32F", [own.components / 4, terms.length / own.components, 1], terms));
    const around = temperaturesOf(band.surface, hour);
    const groups = own.components / 4;
    const air = [0, 1, 2, 3].map((k) => {
      const part = `air${Math.min(k, groups - 1)}`;
      return keep(`${name} ${part}`, () => stored(name, part, { solid: true, linear: true }));
    });
    const bound = {
      skyshineNodes: keep(`nodes ${name}`, () => nodesOf(name, band.surface)),
      skyshineTerms: changing.get("terms"),
      skyshineBlackbody: keep(`blackbody ${band.band}`, () => stored(band.band, "blackbody")),
      skyshineMaterials: keep(`materials ${band.band}`, () => stored(band.band, "materials")),
      skyshineTemperatures: changing.get("temperatures"),
      skyshineReference: changing.get("reference"),
      skyshineShadedChange: changing.get(shaded ? "shaded_change" : "temperatures"),
      shade: keep("shade", () => (shaded ? stored(settings.texture, "shade0") : texture("R8", [1, 1, 1], new Uint8Array(1)))),
      codes: keep("codes", () => stored(settings.texture, "level0")),
      mixtures: keep(`mixtures ${band.band}`, () => mixtureTexture(settings.texture, glow.material)),
    };
    air.forEach((part, k) => (bound[`skyshineAir${k}`] = part));
    gl.useProgram(scenePass.made);
    const at = scenePass.uniforms;
    Object.entries(bound).forEach(([uniform, part], unit) => {
      if (at[uniform] === undefined) return;
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(part.target, part.made);
      gl.uniform1i(at[uniform], unit);
    });
    const { axes } = own;
    gl.uniform4i(at.skyshineSize, axes[0].length, axes[1].length, axes[2].length, groups);
    gl.uniform4i(at.skyshineCount, own.material.length, own.emission_temperature.length, 1 + own.harmonic.length, own.angle.length);
    gl.uniform4i(at.skyshineSurface, faces.azimuth.length, faces.slope.length, faces.altitude.length, faces.azimuth_repeats ? 1 : 0);
    gl.uniform2i(at.skyshineShaded, ...(shaded ? [faces.shaded_azimuth.length, faces.shaded_slope.length] : [1, 1]));
    gl.uniform4f(at.skyshineObserver, ...observerOf(name, settings.altitude_km));
    gl.uniform3f(at.skyshineBand, glow.first_temperature, glow.temperature_step, glow.temperatures);
    const [e, a] = [elevation, azimuth].map((angle) => (angle * Math.PI) / 180);
    gl.uniform3f(at.around, ...around);
    gl.uniform3f(at.toSource, Math.cos(e) * Math.sin(a), Math.cos(e) * Math.cos(a), Math.sin(e));
    const draw = mesh ? setTriangles(at, glow.material, range / settings.range_km[0]) : setPlan(at, range);
    return { source, elevation, azimuth, bound, draw };
  }

  // Draws rows `from` to `to` of every `stride`-th pixel, reads them back, and returns the milliseconds that it took.
  function drawRows({ bound, draw }, target, stride, from, to) {
    const begun = performance.now();
    const across = Math.ceil(columns / stride);
    gl.useProgram(scenePass.made);
    Object.values(bound).forEach((part, unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(part.target, part.made);
    });
    if (!mesh) gl.uniform1f(scenePass.uniforms.stride, stride);
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.framebuffer);
    gl.viewport(0, 0, across, Math.ceil(rows / stride));
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(0, from, across, to - from);
    draw();
    gl.disable(gl.SCISSOR_TEST);
    gl.readPixels(0, from, across, to - from, gl.RGBA, gl.FLOAT, target.values, 4 * across * from);
    return performance.now() - begun;
  }

  // Values of a pixel, from row 0 at the bottom, from what was drawn of it last.
  function valuesAt(x, y) {
    const { stride, finished } = shown;
    const across = Math.ceil(columns / stride);
    const offset = y < finished ? 4 * (y * columns + x) : 4 * (Math.floor(y / stride) * across + Math.floor(x / stride));
    return (y < finished ? fine : coarse).values.subarray(offset, offset + 4);
  }

  const SAMPLES = 4000; // pixels of which black and white are taken
  function levelsOf(band, gain) {
    const channel = band.relative ? 0 : 1;
    const step = Math.max(Math.floor((columns * rows) / SAMPLES), 1);
    const sample = [];
    for (let k = 0; k < columns * rows; k += step) {
      const values = valuesAt(k % columns, Math.floor(k / columns));
      if (values[3] !== -1) sample.push(values[channel]);
    }
    sample.sort((a, b) => a - b);
    const at = (share) => sample[Math.min(Math.floor(share * sample.length), sample.length - 1)] ?? 0;
    const [low, high] = [at(0.01), at(0.99)];
    const middle = (low + high) / 2;
    const half = Math.max((high - low) / 2, 1e-6 * Math.abs(middle), 1e-9) / 2 ** gain;
    return [middle - half, middle + half];
  }

  function drawPicture({ band, gain, palette }) {
    const levels = levelsOf(band, gain);
    const at = picturePass.uniforms;
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, columns, rows);
    gl.useProgram(picturePass.made);
    [coarse.made, fine.made, palettes[palette].made].forEach((made, unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, made);
    });
    ["coarse", "fine", "palette"].forEach((name, unit) => gl.uniform1i(at[name], unit));
    gl.uniform3f(at.levels, ...levels, band.relative ? 1 : 0);
    gl.uniform2i(at.drawn, shown.stride, shown.finished);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    drawBar(levels, band, settings.palettes[palette].colours);
  }

  // The colour bar: a continuous gradient with round numbers beside it.
  function drawBar([low, high], band, colours) {
    element("ramp").style.background = `linear-gradient(to right, ${colours.map((colour) => `rgb(${colour})`)})`;
    const rough = (high - low) / 8;
    const power = 10 ** Math.floor(Math.log10(rough));
    const step = power * [1, 2, 5, 10].find((factor) => factor * power >= rough);
    const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    const ticks = [];
    for (let value = Math.ceil(low / step) * step; value <= high; value += step) {
      const tick = document.createElement("span");
      tick.textContent = value.toFixed(digits);
      tick.style.left = `${(100 * (value - low)) / (high - low)}%`;
      ticks.push(tick);
    }
    element("ticks").replaceChildren(...ticks);
    element("unit").textContent = band.relative ? "radiance, W m⁻² sr⁻¹" : "apparent temperature, K";
  }

  const written = (value, band) => (band.relative ? `${value.toPrecision(4)} W m⁻² sr⁻¹` : `${value.toFixed(2)} K`);
  const clock = (hour) => `${String(Math.floor(hour) % 24).padStart(2, "0")}:${String(Math.floor((hour % 1) * 60 + 1e-6)).padStart(2, "0")}`;

  function chosen() {
    const [near, far] = settings.range_km;
    return {
      band: settings.bands[element("band").selectedIndex],
      hour: Number(element("hour").value),
      wanted: element("source").value,
      range: near * (far / near) ** Number(element("range").value),
      gain: Number(element("gain").value),
      palette: element("palette").selectedIndex,
    };
  }

  const [AT_ONCE_MS, STRIP_MS, FIRST_PIXELS] = [250, 150, 20000]; // of a coarse frame, of a strip; pixels of the first frame
  const shown = { stride: 1, finished: 0 };
  let perPixel = null; // ms, of the last drawing
  let pointed = [Math.floor(columns / 2), Math.floor(rows / 2)];
  let current = 0; // number of the frame, so that strips of the one before stop

  function guarded(action) {
    try {
      return action();
    } catch (error) {
      element("message").textContent = error.message;
      return NaN;
    }
  }

  function recolour() {
    element("gainText").textContent = `× ${(2 ** chosen().gain).toFixed(2)}`;
    drawPicture(chosen());
  }

  // Draws a frame: at once, where pixels are quick; else every so many pixels at once and the others by strips.
  function draw({ complete = false } = {}) {
    const now = chosen();
    const frame = ++current;
    element("hourText").textContent = clock(now.hour);
    element("rangeText").textContent = `${now.range.toFixed(2)} km`;
    element("message").textContent = "";
    return guarded(() => {
      const scene = setScene(now);
      const { source, elevation, azimuth } = scene;
      element("direction").textContent = `${source === "sun" ? "Sun" : "Moon"} ${elevation.toFixed(1)}°, ${(azimuth - 360 * Math.floor(azimuth / 360)).toFixed(0)}°`;
      const most = perPixel === null ? FIRST_PIXELS : AT_ONCE_MS / perPixel;
      const stride = complete ? 1 : Math.ceil(Math.sqrt((columns * rows) / most));
      const begun = performance.now();
      const height = Math.ceil(rows / stride);
      const taken = drawRows(scene, stride > 1 ? coarse : fine, stride, 0, height);
      perPixel = taken / (height * Math.ceil(columns / stride));
      Object.assign(shown, { stride, finished: stride > 1 ? 0 : rows });
      show(performance.now() - begun);
      if (stride > 1) requestAnimationFrame(() => refine(frame, scene, taken));
      return taken;
    });
  }

  // The next strip; `rate` is the time of a pixel in the strip before: those of the sky are quick.
  function refine(frame, scene, coarseTime, fineTime = 0, rate = perPixel) {
    if (frame !== current) return;
    guarded(() => {
      const from = shown.finished;
      const to = Math.min(rows, from + Math.max(Math.floor(STRIP_MS / (rate * columns)), 1));
      const taken = drawRows(scene, fine, 1, from, to);
      const total = fineTime + taken;
      shown.finished = to;
      show(coarseTime + total);
      if (to < rows) requestAnimationFrame(() => refine(frame, scene, coarseTime, total, taken / ((to - from) * columns)));
      else perPixel = total / (rows * columns);
    });
  }

  function show(spent) {
    recolour();
    element("time").textContent = `${spent.toFixed(0)} ms${shown.finished < rows ? ", drawing" : ""}`;
    point();
  }

  // What lies under the pointer, from the values that were read back: nothing is drawn for it.
  function point() {
    const { band } = chosen();
    const [radiance, apparent, warmth, mixture] = valuesAt(pointed[0], rows - 1 - pointed[1]);
    const none = mixture === -1;
    element("pointer").textContent = none ? "no material" : written(band.relative ? radiance : apparent, band);
    element("surface").textContent = none ? "-" : `${warmth.toFixed(2)} K`;
    element("material").textContent = none ? "-" : namesOf(mixture, band);
  }

  function namesOf(mixture, band) {
    if (mixture < 0) return numbers(band.band).material_name[-2 - mixture];
    const words = texels(settings.texture, "mixtures").subarray(mixture * 8, mixture * 8 + 8);
    const own = numbers(settings.texture);
    const parts = [];
    for (let k = 0; k < 3; k++) {
      const share = Math.round((100 * words[4 + k]) / own.share_total);
      if (share > 0) parts.push(`${own.material_name[own.material.indexOf(words[k])]} ${share} %`);
    }
    return parts.join(", ");
  }

  settings.palettes.forEach(({ name }) => element("palette").add(new Option(name)));
  settings.bands.forEach((band) => element("band").add(new Option(band.title)));
  let waiting = false;
  element("controls").addEventListener("input", (event) => {
    element("stage").classList.toggle("photo", element("showPhoto").checked);
    if (["showPhoto", "palette", "gain"].includes(event.target.id)) {
      recolour(); // radiances stay
      return;
    }
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => {
      waiting = false;
      draw();
    });
  });
  element("stage").addEventListener("pointermove", (event) => {
    const box = canvas.getBoundingClientRect();
    const place = [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
    if (place.every((share) => share >= 0 && share < 1)) {
      pointed = [Math.floor(place[0] * columns), Math.floor(place[1] * rows)];
      point();
    }
  });

  // #probe={...} sets the controls and writes every so many pixels of the frame into the page, for tests.
  function probe(wanted) {
    const band = settings.bands.findIndex((one) => one.name === wanted.band);
    element("band").selectedIndex = band;
    for (const name of ["hour", "source", "range", "gain"]) if (wanted[name] !== undefined) element(name).value = wanted[name];
    const frames = Array.from({ length: wanted.frames ?? 1 }, () => draw({ complete: true }));
    if (wanted.coarse) {
      drawRows(setScene(chosen()), coarse, wanted.coarse, 0, Math.ceil(rows / wanted.coarse));
      Object.assign(shown, { stride: wanted.coarse, finished: 0 });
    }
    const [picked, stride] = [[], wanted.stride ?? 1];
    for (let y = 0; y < rows; y += stride) {
      for (let x = 0; x < columns; x += stride) {
        picked.push(...valuesAt(x, rows - 1 - y));
      }
    }
    const bytes = new Uint8Array(new Float32Array(picked).buffer);
    let text = "";
    for (const byte of bytes) text += String.fromCharCode(byte);
    const now = chosen();
    const result = { hour: now.hour, range: now.range, renderer, frames, message: element("message").textContent, error: gl.getError(), pixels: btoa(text) };
    element("probe").textContent = JSON.stringify(result);
  }

  if (location.hash.startsWith("#probe=")) probe(JSON.parse(decodeURIComponent(location.hash.slice(7))));
  else draw();
})();
