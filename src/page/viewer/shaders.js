// What the graphics card computes: surfaces with light and the darkness of corners, lines as wide on the screen as wanted, points.
const VERTEX = `#version 300 es
uniform mat4 seen; uniform vec2 window; uniform float size;
in vec3 at; in vec4 colour; in vec3 to; in vec2 corner;
out vec3 place; out vec4 paint; out vec2 inside;
void main() {
  place = at; paint = colour; inside = vec2(0);
  gl_Position = seen * vec4(at, 1);
#ifdef LINES
  // A line is as wide on the screen as wanted, however far away; what is behind the eye is cut off.
  vec4 a = gl_Position, b = seen * vec4(to, 1);
  place = mix(at, to, corner.x);
  if (a.w < 0.01) a = mix(b, a, (b.w - 0.01) / (b.w - a.w));
  if (b.w < 0.01) b = mix(a, b, (a.w - 0.01) / (a.w - b.w));
  vec2 along = (b.xy / b.w - a.xy / a.w) * window, unit = along / max(length(along), 1e-6);
  gl_Position = mix(a, b, corner.x);
  gl_Position.xy += vec2(-unit.y, unit.x) * corner.y * size / window * gl_Position.w;
#endif
#ifdef POINTS
  gl_Position.xy += corner * size / window * gl_Position.w;
  inside = corner;
#endif
}`;
const FRAGMENT = `#version 300 es
precision highp float;
precision highp sampler3D;
in vec3 place; in vec4 paint; in vec2 inside;
uniform vec3 eye; uniform bool ring;
uniform vec4 cut; uniform bool isShell; uniform vec3 roomLow, roomHigh;
uniform sampler3D air; uniform vec3 airLow, airSize; uniform float airStep;
out vec4 painted;
void main() {
  if (dot(cut.xyz, place) > cut.w) discard;
  // Walls and the ceiling of a room hide nothing from an eye outside of it.
  if (isShell) {
    vec3 near = vec3(0.16);
    if (any(lessThan(max(eye - roomLow, place - roomLow - near), vec3(0))) || any(lessThan(max(roomHigh - eye, roomHigh - place - near), vec3(0)))) discard;
  }
  float light = 1.0;
#ifdef SURFACE
  // Flat shading, brightest from above.
  vec3 normal = normalize(cross(dFdx(place), dFdy(place)));
  normal *= sign(dot(normal, eye - place));
  light = 0.72 + 0.2 * normal.z + 0.12 * normal.x - 0.06 * normal.y;
  if (airStep > 0.0) {
    // Where much of the air before a surface is taken, less light comes.
    vec3 before = (place + normal * airStep * 2.6 - airLow) / airSize, farther = (place + normal * airStep * 5.6 - airLow) / airSize;
    float close = all(equal(before, clamp(before, 0.0, 1.0))) ? texture(air, before).r : 0.0;
    float wide = all(equal(farther, clamp(farther, 0.0, 1.0))) ? texture(air, farther).g : 0.0;
    light = (light + 0.05) * (1.0 - 0.3 * min(1.0, 2.0 * close) - 0.22 * min(1.0, 2.0 * wide));
  }
#endif
  float away = length(inside);
  if (away > 1.0 || ring && away < 0.62) discard;
  painted = vec4(paint.rgb * light, paint.a);
}`;

/** The kinds of parts that are drawn, and what their programs are called. */
const KINDS = { surface: "SURFACE", lines: "LINES", points: "POINTS" };

/** A program of the graphics card for one kind of part, with the places of its uniforms. */
function program(gl, kind) {
  const made = gl.createProgram();
  for (const [type, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, text.replace("\n", `\n#define ${kind}\n`));
    gl.compileShader(shader);
    gl.attachShader(made, shader);
  }
  ["at", "colour", "to", "corner"].forEach((name, place) => gl.bindAttribLocation(made, place, name));
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made) || "no shader");
  const places = new Map();
  return { made, place: name => places.get(name) ?? (places.set(name, gl.getUniformLocation(made, name)), places.get(name)) };
}

/** The buffers of a part: corners, colours, and which corners make triangles. */
function buffers(gl, part, paintOf) {
  const corners = part.at.length / 3, each = part.kind === "surface" ? 1 : 4;
  const count = part.kind === "lines" ? corners / 2 : corners;
  const at = new Float32Array(count * each * 3), to = part.kind === "lines" ? new Float32Array(at.length) : null;
  const colour = new Uint8Array(count * each * 4), corner = each === 4 ? new Float32Array(count * each * 2) : null;
  const stride = part.kind === "lines" ? 6 : 3;
  let last = "", paint = [0, 0, 0, 0];
  for (let n = 0; n < count; n++) {
    const hex = part.colours ? part.colours[n] : part.colour;
    if (hex !== last) { last = hex; paint = paintOf(hex, part.opacity).map(x => 255 * x); }
    for (let c = 0; c < each; c++) {
      const place = n * each + c;
      for (let r = 0; r < 3; r++) {
        at[3 * place + r] = part.at[stride * n + r];
        if (to) to[3 * place + r] = part.at[stride * n + 3 + r];
      }
      for (let r = 0; r < 4; r++) colour[4 * place + r] = paint[r];
      // Along a line and beside it; or the corners of a square.
      if (corner) { corner[2 * place] = part.kind === "lines" ? c >> 1 : c >> 1 ? 1 : -1; corner[2 * place + 1] = c & 1 ? 1 : -1; }
    }
  }
  const faces = part.kind === "surface" ? Uint32Array.from(part.faces) : Uint32Array.from({ length: count * 6 }, (_, i) => 4 * Math.floor(i / 6) + [0, 1, 2, 2, 1, 3][i % 6]);
  const array = gl.createVertexArray(), held = [];
  gl.bindVertexArray(array);
  [[at, 3], [colour, 4], [to, 3], [corner, 2]].forEach(([values, width], place) => {
    if (!values) return;
    held.push(gl.createBuffer());
    gl.bindBuffer(gl.ARRAY_BUFFER, held.at(-1));
    gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, width, values instanceof Uint8Array ? gl.UNSIGNED_BYTE : gl.FLOAT, values instanceof Uint8Array, 0, 0);
  });
  held.push(gl.createBuffer());
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, held.at(-1));
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, faces, gl.STATIC_DRAW);
  gl.bindVertexArray(null);
  return { array, held, count: faces.length };
}

/** A block of bytes that surfaces look up how crowded the air before them is in; of nothing, a single empty one. */
function block(gl, [nx, ny, nz] = [1, 1, 1], pairs = new Uint8Array(2)) {
  const texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_3D, texture);
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  gl.texImage3D(gl.TEXTURE_3D, 0, gl.RG8, nx, ny, nz, 0, gl.RG, gl.UNSIGNED_BYTE, pairs);
  for (const name of ["MIN", "MAG"]) gl.texParameteri(gl.TEXTURE_3D, gl[`TEXTURE_${name}_FILTER`], gl.LINEAR);
  for (const name of ["S", "T", "R"]) gl.texParameteri(gl.TEXTURE_3D, gl[`TEXTURE_WRAP_${name}`], gl.CLAMP_TO_EDGE);
  return texture;
}
