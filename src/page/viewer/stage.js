// Draws in three dimensions with WebGL: surfaces, points, lines and words, to be turned with mouse, fingers or keys. What is
// drawn is decided by others: a stage shows parts by name, and each part may be switched off.

/** The width of a letter and the height of a line, about. */
const LETTER_PX = 7, LINE_PX = 17;

/** How far the eye opens, as the tangent of half its angle. */
const OPENING = Math.tan(20 * Math.PI / 180);

/** How many of the pixels across are drawn while something moves, where all of them take too long. */
const FINENESS = [1, 0.65, 0.45];

/** Whether pictures are drawn without a graphics card, which takes many times as long; null where they are not drawn at all. */
function drawsInSoftware() {
  const gl = document.createElement("canvas").getContext("webgl2"), known = gl?.getExtension("WEBGL_debug_renderer_info");
  if (!gl) return null;
  const name = known ? String(gl.getParameter(known.UNMASKED_RENDERER_WEBGL)) : "";
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}

/** Nothing is cut away. */
const UNCUT = [0, 0, 0, 1];

/**
 * A stage in an element; null where the browser has no WebGL. Parts are
 *   { kind: "surface", at: [x, y, z, ...], faces: [corner, ...], colour | colours: a colour for each corner, opacity }
 *   { kind: "lines", at: [x, y, z, ...] two ends for each line, colour, width in pixels }
 *   { kind: "points", at, colour | colours, width, ring, heard: number => what happens on a click, words: number => a text }
 *   { kind: "words", at, words: [text, ...], look: a class of the page's style, with which they stand on their place and above all }
 * with metres for places and "#rrggbb" for colours, or "ink" for that of words; `isShown: false` hides one. Of surfaces and
 * lines `shell: [low, high]` gives those of a room that hide nothing from outside of it, `isSolid` those that a pointer meets,
 * `isCut` those that a plane cuts; `isOver` are above all others.
 *
 * What else happens is decided by `hooks`, all of which may be missing: `grab(event)` is what a pointer that is pressed drags
 * instead of turning the view, as { move(event), end(event, isDropped) }; `click(event)`, `double(event)`, `hover(event)`, the
 * latter with the cursor to show; `key(event)`, true where it is answered.
 */
function stage(home, label, hooks = {}) {
  const canvas = made("canvas", { tabindex: 0, role: "img", "aria-label": `${label} ${hooks.keyWords ?? "Arrow keys turn it, plus and minus bring it nearer."}` });
  const isSlow = drawsInSoftware();
  const gl = isSlow === null ? null : canvas.getContext("webgl2", { antialias: !isSlow, preserveDrawingBuffer: true });
  if (!gl) return null;
  const words = made("div", { class: "words" });
  home.classList.add("stage");
  home.replaceChildren(canvas, words);
  const parts = new Map(), drawn = new Map(), programs = {};
  const view = { pan: -1.05, tilt: 0.55, away: 8, middle: [0, 0, 0], from: null };
  const air = { texture: null, pairs: null, low: [0, 0, 0], size: [1, 1, 1], step: 0 };
  let asked = 0, isOnPaper = false, cut = UNCUT, coarseness = isSlow ? 1 : 0, pace = 0, sharpens = 0;

  const prepare = () => {
    Object.entries(KINDS).forEach(([kind, name]) => { programs[kind] = program(gl, name); });
    air.texture = air.pairs ? block(gl, air.count, air.pairs) : block(gl);
  };
  prepare();

  /** A colour as four numbers; ink is dark on paper, and elsewhere follows the scheme. */
  const paintOf = (colour, opacity) => rgba(colour !== "ink" ? colour : hue(isOnPaper ? "print" : "ink"), opacity);

  const forget = name => {
    const known = drawn.get(name);
    if (known) { gl.deleteVertexArray(known.array); known.held.forEach(buffer => gl.deleteBuffer(buffer)); }
    drawn.delete(name);
  };

  /** From the world to the screen, and where the eye is. */
  function looking() {
    const { pan, tilt, away, middle, from } = view;
    const back = from ? times(from.along, -1) : [Math.cos(tilt) * Math.cos(pan), Math.cos(tilt) * Math.sin(pan), Math.sin(tilt)];
    const right = from ? unitOf(crossed(from.up, back)) : [-Math.sin(pan), Math.cos(pan), 0];
    const up = crossed(back, right), eye = from ? from.at : plus(middle, times(back, away));
    // A narrow screen sees as much across as a wide one.
    const near = from ? 0.03 : away / 50, far = from ? 200 : away * 20, wide = Math.max(1, canvas.clientWidth) / Math.max(1, canvas.clientHeight);
    const f = from ? Math.min(1 / from.opening[1], wide / from.opening[0]) : Math.min(1, wide / 1.3) / OPENING;
    const turned = [...[0, 1, 2].flatMap(i => [right[i], up[i], back[i], 0]), -dot(right, eye), -dot(up, eye), -dot(back, eye), 1];
    const bent = [f / wide, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, 2 * far * near / (near - far), 0];
    return { seen: product(bent, turned), eye, right, up, back, f, wide };
  }

  /** Where a place is on the screen, in pixels of the page, and how deep; null behind the eye. */
  function onScreen(seen, [x, y, z]) {
    const [u, v, , w] = [0, 1, 2, 3].map(r => seen[r] * x + seen[4 + r] * y + seen[8 + r] * z + seen[12 + r]);
    return w > 0 ? [(u / w + 1) / 2 * canvas.clientWidth, (1 - v / w) / 2 * canvas.clientHeight, w] : null;
  }

  function drawPart([name, part], { seen, eye }, [width, height], isThrough) {
    if (!drawn.has(name)) drawn.set(name, buffers(gl, part, paintOf));
    const { array, count } = drawn.get(name), { made: used, place } = programs[part.kind];
    gl.useProgram(used);
    gl.uniformMatrix4fv(place("seen"), false, seen);
    gl.uniform3fv(place("eye"), eye);
    gl.uniform2f(place("window"), width, height);
    gl.uniform1f(place("size"), part.width ?? 2);
    gl.uniform1i(place("ring"), part.ring ? 1 : 0);
    gl.uniform4fv(place("cut"), part.isCut ? cut : UNCUT);
    gl.uniform1i(place("isShell"), part.shell ? 1 : 0);
    if (part.shell) { gl.uniform3fv(place("roomLow"), part.shell[0]); gl.uniform3fv(place("roomHigh"), part.shell[1]); }
    if (part.kind === "surface") {
      gl.uniform1i(place("air"), 0);
      gl.uniform1f(place("airStep"), part.isSolid ? air.step : 0);
      gl.uniform3fv(place("airLow"), air.low);
      gl.uniform3fv(place("airSize"), air.size);
    }
    gl.depthMask(!isThrough && !part.isOver);
    // Edges stand before the surfaces that they belong to.
    gl[part.kind === "surface" && !isThrough ? "enable" : "disable"](gl.POLYGON_OFFSET_FILL);
    gl[part.isOver ? "disable" : "enable"](gl.DEPTH_TEST);
    gl.bindVertexArray(array);
    gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 0);
  }

  /** Draws what has changed: with fewer pixels where frames come late, as without a graphics card, and with all of them at rest. */
  function paintSoon() {
    const late = performance.now() - asked;
    // Another size takes time, too: it follows several frames that agree.
    pace = late > 50 ? Math.max(0, pace) + 1 : late < 22 ? Math.min(0, pace) - 0.1 : 0;
    if (pace >= 3 || pace <= -3) { coarseness = Math.max(0, Math.min(FINENESS.length - 1, coarseness + Math.sign(pace))); pace = 0; }
    paint(FINENESS[coarseness]);
    clearTimeout(sharpens);
    // Without the card's smoothing, more pixels than the screen has smooth the edges of what is at rest.
    if (coarseness || isSlow) sharpens = setTimeout(() => paint(isSlow ? 1.5 : 1), 220);
  }

  function paint(share = 1) {
    asked = 0;
    const dense = Math.min(2, devicePixelRatio || 1) * share, [width, height] = [canvas.clientWidth, canvas.clientHeight].map(n => Math.max(1, Math.round(n * dense)));
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.depthMask(true);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.BLEND);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.polygonOffset(1, 1);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_3D, air.texture);
    const now = looking();
    const all = [...parts].filter(([, part]) => part.isShown !== false && part.kind !== "words" && part.at.length);
    // What can be seen through comes after the rest and hides nothing behind it; last what is above all.
    const rank = ([, part]) => part.isOver ? 2 : (part.opacity ?? 1) < 1 ? 1 : 0;
    for (const wanted of [0, 1, 2]) all.filter(entry => rank(entry) === wanted).forEach(entry => drawPart(entry, now, [width / dense, height / dense], (entry[1].opacity ?? 1) < 1));
    gl.bindVertexArray(null);
    drawWords(now.seen);
  }

  function drawWords(seen) {
    const texts = [...parts.values()].filter(part => part.kind === "words" && part.isShown !== false);
    const taken = [];
    // What stands on its place takes it first.
    texts.sort((a, b) => (b.look ? 1 : 0) - (a.look ? 1 : 0));
    words.replaceChildren(...texts.flatMap(part => part.words.map((text, n) => {
      const at = onScreen(seen, part.at.slice(3 * n, 3 * n + 3));
      const word = made("span", part.look ? { class: part.look } : {}, text);
      // A word that would cover another is left out until the view is turned.
      const isFree = at && (part.look || taken.every(one => Math.abs(one.x - at[0]) > (one.letters + text.length) * LETTER_PX / 2 || Math.abs(one.y - at[1]) > LINE_PX));
      if (isFree) taken.push({ x: at[0], y: at[1] + (part.look ? 14 : 0), letters: text.length }); else word.hidden = true;
      if (at) word.style.transform = `translate(${at[0].toFixed(1)}px, ${at[1].toFixed(1)}px) translate(-50%, ${part.look ? "-50%" : "-120%"})`;
      return word;
    })));
  }

  const soon = () => { if (!asked) { asked = performance.now(); requestAnimationFrame(paintSoon); } };

  /** The ray from the eye through a place of the element. */
  function rayAt(x, y) {
    const { eye, right, up, back, f, wide } = looking();
    const [u, v] = [(2 * x / Math.max(1, canvas.clientWidth) - 1) * wide / f, (1 - 2 * y / Math.max(1, canvas.clientHeight)) / f];
    return { from: eye, along: unitOf(plus(plus(times(right, u), times(up, v)), times(back, -1))) };
  }

  /** Whether a place of a part is cut away, or in a wall before the eye. */
  const hiddenFrom = eye => (place, part) => {
    if (part.isCut && dot(cut.slice(0, 3), place) > cut[3]) return true;
    const [low, high] = part.shell ?? [[], []];
    return low.some((x, axis) => eye[axis] < x && place[axis] < x + 0.16 || eye[axis] > high[axis] && place[axis] > high[axis] - 0.16);
  };

  /** Where a ray meets what is solid; what is hidden from an eye may be left out. */
  function meet({ from, along }, isHidden, isWanted = () => true) {
    let best = null;
    for (const [name, part] of parts) if (part.kind === "surface" && part.isSolid && part.isShown !== false && part.at.length && isWanted(part)) {
      const found = meeting(from, along, part, isHidden, best?.distance);
      if (found) best = { ...found, part, name };
    }
    return best;
  }

  /** The point of some wanted part nearest to a place on the screen: its part and number. */
  function pointed(x, y, isWanted = () => true) {
    const { seen } = looking();
    let best = null;
    for (const part of parts.values()) if (part.kind === "points" && part.words && part.isShown !== false && isWanted(part)) for (let n = 0; 3 * n < part.at.length; n++) {
      const at = onScreen(seen, part.at.slice(3 * n, 3 * n + 3));
      const off = at ? Math.hypot(at[0] - x, at[1] - y) : Infinity;
      if (off < 14 && (!best || (part.isOver && !best.part.isOver) || off < best.off - 1 || off < best.off + 1 && at[2] < best.deep)) best = { part, n, off, deep: at[2] };
    }
    return best;
  }

  const turn = (pan, tilt) => { leave(); view.pan += pan; view.tilt = Math.max(-1.55, Math.min(1.55, view.tilt + tilt)); soon(); };
  const nearer = factor => { leave(); view.away = Math.max(0.3, Math.min(300, view.away * factor)); soon(); };
  function shift(x, y) {
    leave();
    const { right, up } = looking(), metres = 2 * OPENING * view.away / Math.max(1, canvas.clientHeight);
    view.middle = plus(view.middle, plus(times(right, -x * metres), times(up, y * metres)));
    soon();
  }
  const leave = () => { if (view.from) { view.from = null; hooks.left?.(); } };

  /** Goes to another view in some frames, or at once where motion is unwelcome. */
  function glide(wanted) {
    const begin = { ...view }, start = performance.now(), ms = matchMedia("(prefers-reduced-motion: reduce)").matches ? 0 : 260;
    leave();
    const step = now => {
      const share = ms ? Math.min(1, Math.max(0, (now - start) / ms)) : 1, smooth = share * share * (3 - 2 * share);
      for (const [key, end] of Object.entries(wanted)) view[key] = Array.isArray(end) ? end.map((x, i) => begin[key][i] + smooth * (x - begin[key][i])) : begin[key] + smooth * (end - begin[key]);
      soon();
      if (share < 1) requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  handle(canvas, { hooks, pointed, turn, shift, nearer });
  new ResizeObserver(soon).observe(canvas);
  const again = () => { drawn.forEach((_, name) => forget(name)); paint(); };
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", again);
  for (const [name, is] of [["beforeprint", true], ["afterprint", false]]) addEventListener(name, () => { isOnPaper = is; again(); });
  canvas.addEventListener("webglcontextlost", event => event.preventDefault());
  canvas.addEventListener("webglcontextrestored", () => { drawn.clear(); prepare(); soon(); });

  /** The view of a whole box from a side: its middle, and as far away as it takes to see every corner. */
  function whole([low, high], { pan = view.pan, tilt = view.tilt } = {}) {
    const middle = times(plus(low, high), 0.5), wide = canvas.clientWidth / Math.max(1, canvas.clientHeight) || 1.3, f = Math.min(1, wide / 1.3) / OPENING;
    const back = [Math.cos(tilt) * Math.cos(pan), Math.cos(tilt) * Math.sin(pan), Math.sin(tilt)], right = [-Math.sin(pan), Math.cos(pan), 0], up = crossed(back, right);
    const corners = Array.from({ length: 8 }, (_, n) => minus([0, 1, 2].map(axis => n >> axis & 1 ? high[axis] : low[axis]), middle));
    const away = Math.max(...corners.map(corner => dot(corner, back) + 1.06 * Math.max(Math.abs(dot(corner, right)) * f / wide, Math.abs(dot(corner, up)) * f)));
    return { middle, away };
  }

  return {
    parts,
    canvas,
    /** Shows a part under a name, in the place of what had it before; nothing takes it away. */
    show(name, part) { forget(name); if (part) parts.set(name, part); else parts.delete(name); soon(); },
    /** Shows or hides a part as it is. */
    switch(name, isShown) { const part = parts.get(name); if (part) part.isShown = isShown; soon(); },
    /** Takes away all parts whose names begin so. */
    clear(begin) { [...parts.keys()].filter(name => name.startsWith(begin)).forEach(name => { forget(name); parts.delete(name); }); soon(); },
    /** Looks at a box, from its lowest to its highest corner, all of it. */
    face(box) { Object.assign(view, { ...whole(box), from: null }); soon(); },
    /** Goes to where a box or a place is seen, from another side where one is given. */
    focus(at, side = {}) { glide({ ...(Array.isArray(at[0]) ? whole(at, side) : { middle: at, away: Math.min(view.away, 4) }), ...side }); },
    /** Looks from a place along a direction, as far to the sides and up as these tangents say; null looks as before. */
    lookFrom(from) { view.from = from; soon(); },
    /** Cuts away what is beyond a plane, of the parts that can be cut: a normal and how far it is from the origin. */
    cut(normal, distance) { cut = normal ? [...normal, distance] : UNCUT; soon(); },
    /** Darkens surfaces where the air before them is crowded: a grid of pairs of bytes, as `crowding` makes them. */
    darken({ origin, size }, step, pairs) {
      gl.deleteTexture(air.texture);
      Object.assign(air, { pairs, count: size, step, low: times(origin, step), size: times(size, step), texture: block(gl, size, pairs) });
      soon();
    },
    /** Where a place is on the screen, in pixels of the element. */
    place: at => onScreen(looking().seen, at),
    rayAt,
    /** What a pointer meets at a place of the element: place, normal, part and name, or null. */
    hit(x, y, isWanted) { const ray = rayAt(x, y); return meet(ray, hiddenFrom(ray.from), isWanted); },
    /** Where a ray in the cell meets something solid. */
    meet: (from, along) => meet({ from, along }),
    pointed,
    /** The directions to the right and up on the screen. */
    axes() { const { right, up, back } = looking(); return { right, up, back }; },
  };
}
