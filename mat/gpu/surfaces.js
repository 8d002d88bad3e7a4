// What is drawn, a plan or triangles: the shaders around the include of the export, and the cameras of a scene.
"use strict";

SKYSHINE.surfaces = (() => {
  const include = document.getElementById("include").textContent;

  // Radiance, apparent temperature, mean surface temperature and number of the mixture, -1 without material.
  const SHADING = `#version 300 es
    ${include}
    precision highp usampler2D;
    uniform usampler2D codes;
    uniform sampler2D mixtures;
    uniform sampler2D shade;
    uniform vec3 around; // 1 where textures show shade; the hidden share of the sky there; temperature of the air
    uniform vec3 toSource;
    out vec4 result;

    vec4 seen(vec4 rows, vec4 shares, vec3 normal, vec3 way, float altitude, float number, float dark) {
      if (shares.x <= 0.0) return vec4(0.0, 0.0, 0.0, -1.0);
      SkyshineFace face;
      face.toSource = toSource;
      face.toObserver = normalize(way);
      face.normal = dot(normal, way) < 0.0 ? -normal : normal; // triangles have two sides
      float slope = skyshineAngle(length(face.normal.xy), face.normal.z);
      float azimuth = skyshineAngle(face.normal.x, face.normal.y);
      SkyshineAirOfPixel air = skyshineAirAt(length(way) * 0.001, face.toObserver);
      float radiance = skyshinePath(air, face);
      float warmth = 0.0;
      for (int k = 0; k < 3; k++) {
        if (shares[k] > 0.0) {
          float temperature = skyshineTemperature(int(rows[k]), altitude, azimuth, slope);
          float lit = skyshineSurfaceRadiance(air, int(rows[k]), temperature, face);
          radiance += shares[k] * (1.0 - dark) * lit;
          warmth += shares[k] * (1.0 - dark) * temperature;
          if (dark > 0.0) {
            float cool = temperature + skyshineShadedChangeOf(int(rows[k]), altitude, azimuth, slope);
            radiance += shares[k] * dark * skyshineShadedRadiance(air, int(rows[k]), cool, face, around.y, around.z);
            warmth += shares[k] * dark * cool;
          }
        }
      }
      return vec4(radiance, skyshineApparentTemperature(radiance), warmth, number);
    }

    vec4 mixed(int number, ivec2 texel, vec3 normal, vec3 way, float altitude) {
      ivec2 place = ivec2((number & 1023) * 2, number >> 10);
      vec4 rows = texelFetch(mixtures, place, 0);
      vec4 shares = texelFetch(mixtures, place + ivec2(1, 0), 0);
      float dark = around.x > 0.5 ? texelFetch(shade, texel, 0).r : 0.0;
      return seen(rows, shares, normal, way, altitude, float(number), dark);
    }`;

  const WHOLE = `#version 300 es
    void main() { gl_Position = vec4(float((gl_VertexID & 1) * 4 - 1), float((gl_VertexID & 2) * 2 - 1), 0.0, 1.0); }`;

  const PLAN = `${SHADING}
    uniform vec3 observer; // m from the centre of the plan, east, north, up
    uniform vec4 plan; // columns and rows of texels, metres a texel, altitude of the surface in km
    uniform float stride; // texels a pixel

    void main() {
      vec2 pixel = min(floor(gl_FragCoord.xy * stride), plan.xy - 1.0);
      ivec2 texel = ivec2(int(pixel.x), int(plan.y - pixel.y) - 1);
      vec2 aside = (pixel + 0.5 - 0.5 * plan.xy) * plan.z;
      int number = int(texelFetch(codes, texel, 0).r);
      result = mixed(number, texel, vec3(0.0, 0.0, 1.0), observer - vec3(aside, 0.0), plan.w);
    }`;

  const CORNERS = `#version 300 es
    layout(location = 0) in vec3 corner;
    layout(location = 1) in vec3 normal;
    layout(location = 2) in vec2 coordinates;
    layout(location = 3) in float covering;
    uniform mat4 view;
    out highp vec3 place;
    flat out highp vec3 side;
    out highp vec2 at;
    flat out highp float cover;
    void main() {
      place = corner;
      side = normal;
      at = coordinates;
      cover = covering;
      gl_Position = view * vec4(corner, 1.0);
    }`;

  const MESH = `${SHADING}
    in vec3 place;
    flat in vec3 side;
    in vec2 at;
    flat in float cover; // row of a material, or -1 less the number of a texture
    uniform vec3 observer; // m
    uniform vec2 scene; // 1 where every pixel is seen from straight above; altitude of height 0 in km
    uniform vec4 parts[8]; // of textures: first row of codes, width, height, first mixture

    void main() {
      vec3 way = scene.x > 0.5 ? vec3(0.0, 0.0, observer.z - place.z) : observer - place;
      float altitude = scene.y + place.z * 0.001;
      if (cover < -0.5) {
        vec4 part = parts[int(-cover - 0.5)];
        vec2 inside = vec2(at.x < -1e-6 || at.x > 1.000001 ? fract(at.x) : clamp(at.x, 0.0, 1.0),
                           at.y < -1e-6 || at.y > 1.000001 ? fract(at.y) : clamp(at.y, 0.0, 1.0));
        vec2 texel = min(floor(inside * part.yz), part.yz - 1.0);
        ivec2 cell = ivec2(int(texel.x), int(part.x + texel.y));
        int number = int(texelFetch(codes, cell, 0).r) + int(part.w);
        result = mixed(number, cell, side, way, altitude);
      } else {
        vec4 rows = vec4(cover, 0.0, 0.0, 0.0);
        result = seen(rows, vec4(1.0, 0.0, 0.0, 0.0), side, way, altitude, -2.0 - cover, 0.0);
      }
    }`;

  const PICTURE = `#version 300 es
    precision highp float;
    uniform highp sampler2D coarse;
    uniform highp sampler2D fine;
    uniform sampler2D palette;
    uniform vec3 levels; // first and last value of the palette, channel
    uniform ivec2 drawn; // stride of the coarse picture, finished rows of the fine one
    out vec4 colour;
    void main() {
      ivec2 place = ivec2(gl_FragCoord.xy);
      vec4 pixel = place.y < drawn.y ? texelFetch(fine, place, 0) : texelFetch(coarse, place / drawn.x, 0);
      float value = levels.z > 0.5 ? pixel.r : pixel.g;
      float share = clamp((value - levels.x) / (levels.y - levels.x), 0.0, 1.0);
      float count = float(textureSize(palette, 0).x);
      colour = pixel.a == -1.0 ? vec4(0.13, 0.15, 0.19, 1.0) : texture(palette, vec2((share * (count - 1.0) + 0.5) / count, 0.5));
    }`;

  const dot = (a, b) => a.reduce((total, value, k) => total + value * b[k], 0);
  const unit = (vector) => vector.map((part) => part / Math.hypot(...vector));
  const cross = ([a, b, c], [d, e, f]) => [b * f - c * e, c * d - a * f, a * e - b * d];

  // Column-major matrix of a camera: x to the right, y up, depth between two distances along `ahead`.
  function matrix({ right, up, ahead, origin, across, down, near, far, pinhole }) {
    const row = (vector, scale) => [...vector.map((part) => part * scale), -dot(vector, origin) * scale];
    const [x, y] = [row(right, 1 / across), row(up, 1 / down)];
    const depth = row(ahead, 1);
    const [scale, shift] = pinhole ? [(far + near) / (far - near), (-2 * far * near) / (far - near)] : [2 / (far - near), -(far + near) / (far - near)];
    const z = depth.map((value, k) => value * scale + (k === 3 ? shift : 0));
    const w = pinhole ? depth : [0, 0, 0, 1];
    return new Float32Array([0, 1, 2, 3].flatMap((column) => [x[column], y[column], z[column], w[column]]));
  }

  // Camera of a scene; `stretch` moves it away at its height and keeps the width of what it looks at.
  function camera({ camera: own, bounds }, columns, rows, stretch) {
    const [low, high] = bounds;
    if (own.kind === "plan_view") {
      const turn = (own.top_azimuth_deg * Math.PI) / 180;
      const axes = { right: [Math.cos(turn), -Math.sin(turn), 0], up: [Math.sin(turn), Math.cos(turn), 0], ahead: [0, 0, -1] };
      const origin = [...own.centre_m, own.height_m];
      const [across, down] = [own.width_m / 2, (own.width_m * rows) / columns / 2];
      const [near, far] = [own.height_m - high[2] - 1, own.height_m - low[2] + 1];
      return { observer: origin, view: matrix({ ...axes, origin, across, down, near, far, pinhole: false }), above: 1 };
    }
    const look = own.look_at_m;
    const origin = own.position_m.map((value, k) => (k < 2 ? look[k] + (value - look[k]) * stretch : value));
    const way = look.map((value, k) => value - origin[k]);
    const before = look.map((value, k) => value - own.position_m[k]);
    const ahead = unit(way);
    const level = Math.hypot(ahead[0], ahead[1]);
    const right = level > 1e-9 ? [ahead[1] / level, -ahead[0] / level, 0] : [1, 0, 0];
    const up = cross(right, ahead);
    const across = (Math.tan((own.field_of_view_deg * Math.PI) / 360) * Math.hypot(...before)) / Math.hypot(...way);
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((k) => [0, 1, 2].map((axis) => bounds[(k >> axis) & 1][axis] - origin[axis]));
    const depths = corners.map((corner) => dot(corner, ahead));
    const far = Math.max(...depths, 1) * 1.01;
    const near = Math.max(Math.min(...depths) * 0.99, far * 1e-5);
    return { observer: origin, view: matrix({ right, up, ahead, origin, across, down: (across * rows) / columns, near, far, pinhole: true }), above: 0 };
  }

  return { WHOLE, PLAN, CORNERS, MESH, PICTURE, camera };
})();
