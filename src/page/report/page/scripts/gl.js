// Draws in three dimensions with WebGL: surfaces, points, lines and words, to be turned with mouse, fingers or keys. What is
// drawn is decided by others: a stage shows parts by name, and each part may be switched off.

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
in vec3 place; in vec4 paint; in vec2 inside;
uniform vec3 eye; uniform bool ring;
out vec4 painted;
void main() {
  float light = 1.0;
#ifdef SURFACE
  // Flat shading, brightest from above.
  vec3 normal = normalize(cross(dFdx(place), dFdy(place)));
  normal *= sign(dot(normal, eye - place));
  light = 0.72 + 0.2 * normal.z + 0.12 * normal.x - 0.06 * normal.y;
#endif
  float away = length(inside);
  if (away > 1.0 || ring && away < 0.62) discard;
  painted = vec4(paint.rgb * light, paint.a);
}`;

/** A colour of six hexadecimal digits, and how much of what is behind it it hides, as four numbers from 0 to 1. */
const rgba = (hex, opacity = 1) => [1, 3, 5].map(i => parseInt(hex.slice(i, i + 2), 16) / 255).concat(opacity);

/** A program of the graphics card for one kind of part. */
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
  return made;
}

// Products of 4 × 4 matrices, column by column.
const product = (a, b) => Array.from({ length: 16 }, (_, n) => [0, 1, 2, 3].reduce((sum, k) => sum + a[4 * k + n % 4] * b[4 * Math.floor(n / 4) + k], 0));
const dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);
const crossed = (a, b) => [0, 1, 2].map(i => a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3]);

/** The width of a letter and the height of a line, about. */
const LETTER_PX = 7, LINE_PX = 17;

/** How far the eye opens, as the tangent of half its angle. */
const OPENING = Math.tan(20 * Math.PI / 180);

/**
 * A stage in an element; null where the browser has no WebGL. Parts are
 *   { kind: "surface", at: [x, y, z, ...], faces: [corner, ...], colour | colours: a colour for each corner, opacity }
 *   { kind: "lines", at: [x, y, z, ...] two ends for each line, colour, width in pixels }
 *   { kind: "points", at, colour | colours, width, ring, heard: number => what happens on a click, words: number => a text }
 *   { kind: "words", at, words: [text, ...] }
 * with metres for places and "#rrggbb" for colours, or "ink" for that of words; `isShown: false` hides one.
 */
function stage(home, label) {
  const canvas = made("canvas", { tabindex: 0, role: "img", "aria-label": `${label}. Arrow keys turn it, plus and minus bring it nearer.` });
  const gl = canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
  if (!gl) return null;
  const words = made("div", { class: "words" });
  home.classList.add("stage");
  home.replaceChildren(canvas, words);
  const programs = Object.fromEntries([["surface", "SURFACE"], ["lines", "LINES"], ["points", "POINTS"]].map(([kind, name]) => [kind, program(gl, name)]));
  const parts = new Map(), drawn = new Map();
  const view = { pan: -1.05, tilt: 0.55, away: 8, middle: [0, 0, 0] };
  let asked = false, isOnPaper = false;

  /** A colour as four numbers; ink is dark on paper, and elsewhere follows the scheme. */
  const paintOf = (colour, opacity) => rgba(colour !== "ink" ? colour : hue(isOnPaper ? "print" : "ink"), opacity);

  function buffers(part) {
    const corners = part.at.length / 3, each = part.kind === "surface" ? 1 : 4;
    const count = part.kind === "lines" ? corners / 2 : corners;
    const at = new Float32Array(count * each * 3), to = part.kind === "lines" ? new Float32Array(at.length) : null;
    const colour = new Uint8Array(count * each * 4), corner = each === 4 ? new Float32Array(count * each * 2) : null;
    const stride = part.kind === "lines" ? 6 : 3;
    let last = "", paint = [0, 0, 0, 0];
    for (let n = 0; n < count; n++) for (let c = 0; c < each; c++) {
      const place = n * each + c, hex = part.colours ? part.colours[n] : part.colour;
      if (hex !== last) { last = hex; paint = paintOf(hex, part.opacity).map(x => 255 * x); }
      for (let r = 0; r < 3; r++) {
        at[3 * place + r] = part.at[stride * n + r];
        if (to) to[3 * place + r] = part.at[stride * n + 3 + r];
      }
      colour.set(paint, 4 * place);
      // Along a line and beside it; or the corners of a square.
      if (corner) corner.set(part.kind === "lines" ? [c >> 1, c & 1 ? 1 : -1] : [c >> 1 ? 1 : -1, c & 1 ? 1 : -1], 2 * place);
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

  const forget = name => {
    const known = drawn.get(name);
    if (known) { gl.deleteVertexArray(known.array); known.held.forEach(buffer => gl.deleteBuffer(buffer)); }
    drawn.delete(name);
  };

  /** From the world to the screen, and where the eye is. */
  function looking() {
    const { pan, tilt, away, middle } = view;
    const back = [Math.cos(tilt) * Math.cos(pan), Math.cos(tilt) * Math.sin(pan), Math.sin(tilt)];
    const right = [-Math.sin(pan), Math.cos(pan), 0], up = crossed(back, right), eye = plus(middle, times(back, away));
    // A narrow screen sees as much across as a wide one.
    const near = away / 50, far = away * 20, wide = canvas.width / Math.max(1, canvas.height), f = Math.min(1, wide / 1.3) / OPENING;
    const turned = [...[0, 1, 2].flatMap(i => [right[i], up[i], back[i], 0]), -dot(right, eye), -dot(up, eye), -dot(back, eye), 1];
    const bent = [f / wide, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, 2 * far * near / (near - far), 0];
    return { seen: product(bent, turned), eye, right, up };
  }

  /** Where a place is on the screen, in pixels of the page; null behind the eye. */
  function onScreen(seen, [x, y, z]) {
    const [u, v, , w] = [0, 1, 2, 3].map(r => seen[r] * x + seen[4 + r] * y + seen[8 + r] * z + seen[12 + r]);
    return w > 0 ? [(u / w + 1) / 2 * canvas.clientWidth, (1 - v / w) / 2 * canvas.clientHeight, w] : null;
  }

  function paint() {
    asked = false;
    const dense = Math.min(2, devicePixelRatio || 1), [width, height] = [canvas.clientWidth, canvas.clientHeight].map(n => Math.max(1, Math.round(n * dense)));
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    const { seen, eye } = looking();
    const all = [...parts].filter(([, part]) => part.isShown !== false && part.kind !== "words" && part.at.length);
    // What can be seen through comes last and hides nothing behind it.
    const through = ([, part]) => (part.opacity ?? 1) < 1;
    for (const entry of [...all.filter(one => !through(one)), ...all.filter(through)]) {
      const [name, part] = entry;
      if (!drawn.has(name)) drawn.set(name, buffers(part));
      const { array, count } = drawn.get(name), used = programs[part.kind];
      gl.useProgram(used);
      gl.uniformMatrix4fv(gl.getUniformLocation(used, "seen"), false, seen);
      gl.uniform3fv(gl.getUniformLocation(used, "eye"), eye);
      gl.uniform2f(gl.getUniformLocation(used, "window"), width / dense, height / dense);
      gl.uniform1f(gl.getUniformLocation(used, "size"), part.width ?? 2);
      gl.uniform1i(gl.getUniformLocation(used, "ring"), part.ring ? 1 : 0);
      gl.depthMask(!through(entry));
      gl.bindVertexArray(array);
      gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 0);
    }
    gl.depthMask(true);
    gl.bindVertexArray(null);
    const texts = [...parts.values()].filter(part => part.kind === "words" && part.isShown !== false);
    const taken = [];
    words.replaceChildren(...texts.flatMap(part => part.words.map((text, n) => {
      const at = onScreen(seen, part.at.slice(3 * n, 3 * n + 3));
      const word = made("span", {}, text);
      // A word that would cover another is left out until the view is turned.
      const isFree = at && taken.every(one => Math.abs(one.x - at[0]) > (one.letters + text.length) * LETTER_PX / 2 || Math.abs(one.y - at[1]) > LINE_PX);
      if (isFree) taken.push({ x: at[0], y: at[1], letters: text.length }); else word.hidden = true;
      if (at) word.style.transform = `translate(${at[0].toFixed(1)}px, ${at[1].toFixed(1)}px) translate(-50%, -120%)`;
      return word;
    })));
  }

  const soon = () => { if (!asked) { asked = true; requestAnimationFrame(paint); } };

  /** The point of some part nearest to a place on the screen: its part and number. */
  function pointed(x, y) {
    const { seen } = looking();
    let best = null;
    for (const part of parts.values()) if (part.kind === "points" && part.words && part.isShown !== false) for (let n = 0; 3 * n < part.at.length; n++) {
      const at = onScreen(seen, part.at.slice(3 * n, 3 * n + 3));
      const off = at ? Math.hypot(at[0] - x, at[1] - y) : Infinity;
      if (off < 14 && (!best || off < best.off - 1 || off < best.off + 1 && at[2] < best.deep)) best = { part, n, off, deep: at[2] };
    }
    return best;
  }

  const turn = (pan, tilt) => { view.pan += pan; view.tilt = Math.max(-1.55, Math.min(1.55, view.tilt + tilt)); soon(); };
  const nearer = factor => { view.away *= factor; soon(); };
  function shift(x, y) {
    const { right, up } = looking(), metres = 2 * OPENING * view.away / Math.max(1, canvas.clientHeight);
    view.middle = plus(view.middle, plus(times(right, -x * metres), times(up, y * metres)));
    soon();
  }

  const fingers = new Map();
  let moved = 0;
  const middleOf = all => [0, 1].map(i => all.reduce((sum, at) => sum + at[i], 0) / all.length);
  const apart = all => all.length > 1 ? Math.hypot(all[0][0] - all[1][0], all[0][1] - all[1][1]) : 0;
  canvas.addEventListener("pointerdown", event => { canvas.setPointerCapture(event.pointerId); fingers.set(event.pointerId, [event.offsetX, event.offsetY]); if (fingers.size === 1) moved = 0; });
  canvas.addEventListener("pointermove", event => {
    if (!fingers.has(event.pointerId)) {
      const found = pointed(event.offsetX, event.offsetY);
      canvas.title = found ? found.part.words(found.n) : "";
      canvas.style.cursor = found ? "pointer" : "grab";
      return;
    }
    const before = [...fingers.values()];
    fingers.set(event.pointerId, [event.offsetX, event.offsetY]);
    const after = [...fingers.values()], [dx, dy] = [0, 1].map(i => middleOf(after)[i] - middleOf(before)[i]);
    moved += Math.abs(dx) + Math.abs(dy);
    if (after.length > 1) { shift(dx, dy); if (apart(after) > 0 && apart(before) > 0) nearer(apart(before) / apart(after)); }
    else if (event.shiftKey || event.buttons & 6) shift(dx, dy);
    else turn(-dx / 150, dy / 150);
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, event => {
    const found = end === "pointerup" && moved < 4 && fingers.size === 1 ? pointed(event.offsetX, event.offsetY) : null;
    fingers.delete(event.pointerId);
    found?.part.heard?.(found.n);
  });
  canvas.addEventListener("wheel", event => { event.preventDefault(); nearer(Math.exp(Math.sign(event.deltaY) * 0.12)); }, { passive: false });
  canvas.addEventListener("contextmenu", event => event.preventDefault());
  const KEYS = { ArrowLeft: () => turn(-0.12, 0), ArrowRight: () => turn(0.12, 0), ArrowUp: () => turn(0, 0.08), ArrowDown: () => turn(0, -0.08), "+": () => nearer(0.88), "-": () => nearer(1.14) };
  canvas.addEventListener("keydown", event => { const heard = KEYS[event.key]; if (heard) { event.preventDefault(); heard(); } });
  new ResizeObserver(soon).observe(canvas);
  const again = () => { drawn.forEach((_, name) => forget(name)); paint(); };
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", again);
  for (const [name, is] of [["beforeprint", true], ["afterprint", false]]) addEventListener(name, () => { isOnPaper = is; again(); });
  canvas.addEventListener("webglcontextlost", event => event.preventDefault());
  canvas.addEventListener("webglcontextrestored", () => { drawn.clear(); Object.entries({ surface: "SURFACE", lines: "LINES", points: "POINTS" }).forEach(([kind, name]) => { programs[kind] = program(gl, name); }); soon(); });

  return {
    parts,
    /** Shows a part under a name, in the place of what had it before; nothing takes it away. */
    show(name, part) { forget(name); if (part) parts.set(name, part); else parts.delete(name); soon(); },
    /** Shows or hides a part as it is. */
    switch(name, isShown) { const part = parts.get(name); if (part) part.isShown = isShown; soon(); },
    /** Takes away all parts whose names begin so. */
    clear(begin) { [...parts.keys()].filter(name => name.startsWith(begin)).forEach(name => { forget(name); parts.delete(name); }); soon(); },
    /** Looks at a box, from its lowest to its highest corner, all of it. */
    face([low, high]) { Object.assign(view, { middle: times(plus(low, high), 0.5), away: Math.hypot(...low.map((x, i) => high[i] - x)) / 2 / OPENING * 0.85 }); soon(); },
    /** Where a place is on the screen, in pixels of the element. */
    place: at => onScreen(looking().seen, at),
  };
}
