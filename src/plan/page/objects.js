// Objects of the scenes: robots, people, furniture. A person moves them along the floor and turns them; the edit goes into
// the scene file. Only the outline follows the pointer: voxels are made and counted when it is let go.
const PLACE_FIELDS = [["x", "x", "m", 0.05], ["y", "y", "m", 0.05], ["z", "z", "m", 0.05], ["yaw", "Turn", "°", 5]];

/** The file of the chosen scene, and its objects by their names. */
const sceneFile = () => planner.state?.scene_files?.[chosenScene()?.file ?? 0];
const objectNamed = name => sceneFile()?.objects.find(one => one.name === name);

/** The object that a thing in the scene is, or is a part of. */
function objectOf({ whole_name, name }) {
  const whole = whole_name ?? name, all = sceneFile()?.objects ?? [];
  return all.find(one => one.name === whole) ?? all.find(one => whole.startsWith(`${one.name}/`));
}

/** Where an object is at the chosen moment, as its file says, and by which entries. */
function placeOf(one) {
  const snapshot = planner.moment - chosenScene().moments[0], [position_entry, yaw_entry] = [one.position_of, one.yaw_of].map(order => order[snapshot % order.length]);
  return { position_m: one.positions_m[position_entry], yaw_deg: one.yaws_deg[yaw_entry], position_entry, yaw_entry };
}
/** The same while it is dragged. */
const placeNow = one => planner.carry?.name === one.name ? { ...placeOf(one), ...planner.carry.at } : placeOf(one);

/** Whether a pointer may drag an object. One that is the cell itself, with its walls, is moved by its numbers only. */
const isDragged = one => !!one?.can_move && !plan.shells?.has(one.name);

function selectObject(name) {
  if (planner.object === name) return;
  planner.object = name;
  tell("object");
}

/** Begins to move an object; null where it may not be moved. */
function beginCarry(name) {
  flushDraft();
  const one = objectNamed(name);
  if (!one || !mayEdit()) return null;
  selectObject(name);
  if (!one.can_move) { notify(sceneFile().reason ?? one.words ?? "It cannot be moved."); return null; }
  const { position_m, yaw_deg } = placeOf(one);
  planner.carry = { name, at: { position_m, yaw_deg }, from: { position_m, yaw_deg }, gesture: nextGesture() };
  return planner.carry;
}

/** Moves it; what stays is not rounded. */
function changeCarry({ position_m, yaw_deg }) {
  const { from } = planner.carry, near = (value, old, places) => value === old ? old : rounded(value, places);
  planner.carry.at = { position_m: position_m.map((x, axis) => near(x, from.position_m[axis], 3)), yaw_deg: yaw_deg === from.yaw_deg ? yaw_deg : rounded(angle(yaw_deg), 1) };
  tell("carry");
}

/** Makes an edit of the move. Its outline stays until the picture has followed. */
async function commitCarry() {
  clearTimeout(settles);
  const { carry } = planner;
  if (!carry || carry.isSettling) return;
  carry.isSettling = true;
  const { position_entry, yaw_entry } = placeOf(objectNamed(carry.name)), { at, from } = carry;
  const position_m = at.position_m.some((x, axis) => x !== from.position_m[axis]) ? at.position_m : null, yaw_deg = at.yaw_deg === from.yaw_deg ? null : at.yaw_deg;
  if (position_m || yaw_deg !== null) {
    const isDone = await edit({ edit: "move_object", file: sceneFile().name, object: carry.name, position_m, yaw_deg, position_entry, yaw_entry }, carry.gesture);
    if (isDone) await loadThings().catch(complain);
  }
  dropCarry(carry);
}
function dropCarry(carry = planner.carry) {
  if (!carry || planner.carry !== carry) return;
  planner.carry = null;
  tell("carry");
}

/** Moves the chosen object by a step, and makes an edit of it when no other step follows soon. */
function nudgeObject(change) {
  const isSame = planner.carry && planner.carry.name === planner.object && !planner.carry.isSettling;
  if (!isSame && !beginCarry(planner.object)) return false;
  changeCarry(change(planner.carry.at));
  clearTimeout(settles);
  settles = setTimeout(commitCarry, COMMIT_MS);
  return true;
}

/** The convex outline of places, from above. */
function hullOf(at) {
  const points = [];
  for (let n = 0; n < at.length; n += 3) points.push([at[n], at[n + 1]]);
  points.sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const half = all => all.reduce((hull, point) => {
    const isRight = ([a, b]) => (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0]) <= 0;
    while (hull.length > 1 && isRight(hull.slice(-2))) hull.pop();
    hull.push(point);
    return hull;
  }, []);
  return [...half(points).slice(0, -1), ...half(points.reverse()).slice(0, -1)];
}

/** Where a place of an object is while that is moved and turned. */
function movePoint([x, y]) {
  const { at, from } = planner.carry, turn = (at.yaw_deg - from.yaw_deg) * RAD, [dx, dy] = [x - from.position_m[0], y - from.position_m[1]];
  return [at.position_m[0] + dx * Math.cos(turn) - dy * Math.sin(turn), at.position_m[1] + dx * Math.sin(turn) + dy * Math.cos(turn)];
}

/** The outline of a thing on the plan, where it is dragged to. */
function outlineOf(thing) {
  const { low_m: [x0, y0], high_m: [x1, y1] } = thing, hull = thing.hull?.length > 2 ? thing.hull : [[x0, y0], [x1, y0], [x1, y1], [x0, y1]];
  return planner.carry && objectOf(thing)?.name === planner.carry.name ? hull.map(movePoint) : hull;
}

/** The chosen object: its outline, its own frame, and a handle that turns it. */
function objectMarks({ x, y }, things) {
  const one = objectNamed(planner.object);
  if (!one) return [];
  const parts = things.filter(thing => objectOf(thing) === one), { position_m: [a, b], yaw_deg } = placeNow(one), points = hull => hull.map(([u, v]) => `${px(x(u))},${px(y(v))}`).join(" ");
  const nodes = parts.map(thing => shape("polygon", { points: points(outlineOf(thing)), class: `carried${one.can_move ? "" : " stays"}` }));
  if (!one.can_turn || !isDragged(one) || !mayEdit()) return nodes;
  const far = Math.max(0, ...parts.flatMap(thing => outlineOf(thing).map(([u, v]) => Math.hypot(x(u) - x(a), y(v) - y(b))))), reach = Math.min(90, Math.max(34, far + 16)), [ux, uy] = [Math.cos(yaw_deg * RAD), -Math.sin(yaw_deg * RAD)];
  const handle = shape("circle", { cx: px(x(a) + ux * reach), cy: px(y(b) + uy * reach), r: 7, class: "aim", id: "object-turn", title: `Drag to turn ${one.name}` });
  handle.spun = one.name;
  return [...nodes, shape("path", { d: `M${px(x(a))} ${px(y(b))}l${px(ux * reach)} ${px(uy * reach)}`, class: "look chosen" }), shape("circle", { cx: px(x(a)), cy: px(y(b)), r: 3, class: "origin" }), handle];
}

/** Moves an object along the floor, from where the pointer took it. */
function carryOnFloor(begin) {
  return (now, event) => {
    const { from } = planner.carry, step = event.shiftKey ? 0.1 : event.altKey ? 0.001 : 0.01;
    changeCarry({ ...planner.carry.at, position_m: from.position_m.map((x, axis) => axis === 2 || now[axis] === begin[axis] ? x : Math.round((x + now[axis] - begin[axis]) / step) * step) });
  };
}
/** Turns it towards the pointer. */
function spinOnFloor() {
  return (now, event) => {
    const { at } = planner.carry, step = event.shiftKey ? 5 : event.altKey ? 0.1 : 1;
    changeCarry({ ...at, yaw_deg: Math.round(Math.atan2(now[1] - at.position_m[1], now[0] - at.position_m[0]) / RAD / step) * step });
  };
}

/** What a pointer that is pressed on the chosen object in the view drags: along the floor, from the height at which it is held. */
function grabObject(event, found) {
  const { stage } = scene, one = objectNamed(planner.object), hit = found ? null : stage.hit(event.offsetX, event.offsetY);
  const isHandle = isPart(found, "object: place");
  if (!isDragged(one) || !isHandle && !(hit?.part.thing && objectOf({ name: hit.part.thing }) === one)) return null;
  const height = isHandle ? placeNow(one).position_m : hit.at, where = ({ offsetX, offsetY }) => { const ray = stage.rayAt(offsetX, offsetY); return onPlane(ray.from, ray.along, height, [0, 0, 1]); };
  const begin = where(event), change = carryOnFloor(begin), own = { x: event.offsetX, y: event.offsetY };
  return begin && {
    move(event) {
      if (own.isOver) return;
      if (!own.carry) {
        if (Math.hypot(event.offsetX - own.x, event.offsetY - own.y) < 3) return;
        own.carry = beginCarry(one.name);
      }
      if (!own.carry || planner.carry !== own.carry || own.carry.isSettling) { own.isOver = true; return; }
      const now = where(event);
      if (now) change(now, event);
    },
    end(_, isDropped) {
      if (!own.carry || own.isOver || planner.carry !== own.carry) return;
      if (isDropped) dropCarry(); else commitCarry();
    },
  };
}

/** The chosen object in the view: a handle at its place, and while it is moved its outline on the floor. */
async function showObject() {
  const { stage } = scene, one = planner.state && objectNamed(planner.object);
  stage.show("object: place", isDragged(one) && mayEdit() && !planner.armed ? { kind: "points", at: placeNow(one).position_m, colour: hue("picked"), width: 14, ring: true, isOver: true, words: () => `Drag ${one.name} along the floor` } : null);
  if (!planner.carry) { stage.show("object: outline"); return; }
  if (planner.carry.isSettling) return;
  const { things } = await loadScenery(planner.moment), own = things.filter(thing => thing.at.length && objectOf(thing)?.name === planner.carry?.name);
  const lines = own.flatMap(thing => {
    thing.box ??= boxOf({ at: thing.at });
    const around = (thing.hull ??= hullOf(thing.at)).map(movePoint), lift = planner.carry.at.position_m[2] - planner.carry.from.position_m[2];
    return [0, 1].flatMap(end => around.flatMap((point, n) => [point, around[(n + 1) % around.length]].flatMap(([x, y]) => [x, y, thing.box[end][2] + lift])));
  });
  stage.show("object: outline", planner.carry ? { kind: "lines", at: lines, colour: hue("picked"), width: 2, isOver: true } : null);
}

/** All objects of the scene, each to be chosen with the keyboard, too. */
function showObjects() {
  const home = element("object-list"), had = home.contains(document.activeElement), all = sceneFile()?.objects ?? [];
  home.replaceChildren(...all.map((one, n) => {
    const isChosen = one.name === planner.object, item = made("li", { role: "option", tabindex: isChosen || !objectNamed(planner.object) && n === 0 ? "0" : "-1", "aria-selected": String(isChosen) }, made("strong", {}, one.name), made("small", {}, one.can_move ? one.what : `${one.what}, stays`));
    item.addEventListener("click", () => selectObject(one.name));
    item.addEventListener("focus", () => selectObject(one.name));
    return item;
  }));
  element("object-count").textContent = all.length || "";
  if (had) home.querySelector("[aria-selected=true]")?.focus();
}

/** The chosen object in numbers and words. */
function showPlace() {
  const one = planner.state ? objectNamed(planner.object) : null, file = sceneFile();
  element("object").hidden = !one;
  if (!one) return;
  const now = placeNow(one), values = [...now.position_m, now.yaw_deg];
  element("object-name").textContent = one.name;
  element("object-what").textContent = `${one.role === "human" ? "person" : one.role}, ${one.what} · ${file.name}`;
  const several = one.positions_m.length > 1 || one.yaws_deg.length > 1;
  element("object-words").textContent = [
    one.can_move && several ? `Place ${Math.max(now.position_entry, now.yaw_entry) + 1} of ${Math.max(one.positions_m.length, one.yaws_deg.length)}, that of this moment: the others stay.` : "",
    one.can_move && file.scenes.length > 1 ? `${file.scenes.length} scenes are made of ${file.name} (${file.scenes.join(", ")}): it moves in all of them.` : "",
    one.words ?? "",
    file.reason ? `It cannot be moved: ${file.reason}.` : "",
  ].filter(words => words).join(" ");
  PLACE_FIELDS.forEach(([name, , unit], n) => {
    const input = element(`place-${name}`);
    input.disabled = !mayEdit() || !(n < 3 ? one.can_move : one.can_turn);
    if (document.activeElement !== input || planner.carry) input.value = rounded(values[n], unit === "m" ? 3 : 1);
  });
}

const withPlace = (at, n, value) => n < 3 ? { ...at, position_m: at.position_m.with(n, value) } : { ...at, yaw_deg: value };

/** Takes a number that was typed. */
function typePlace(n, input) {
  const one = objectNamed(planner.object), value = Number(input.value.replace(",", "."));
  if (!one || input.value.trim() === "" || !Number.isFinite(value)) { showPlace(); return; }
  const { position_m, yaw_deg } = placeNow(one), old = [...position_m, yaw_deg][n];
  if (Math.abs(rounded(old, n < 3 ? 3 : 1) - value) < 1e-9 || !beginCarry(one.name)) return;
  changeCarry(withPlace(planner.carry.at, n, value));
  commitCarry();
}

function makeObjects() {
  element("place").replaceChildren(...PLACE_FIELDS.map(([name, title, unit, step], n) => {
    const input = made("input", { id: `place-${name}`, type: "number", step: "any", inputmode: "decimal", "aria-label": `${title} of the object in ${unit === "m" ? "metres" : "degrees"}` });
    input.addEventListener("change", () => typePlace(n, input));
    input.addEventListener("keydown", event => {
      if (event.key === "Enter") typePlace(n, input);
      const way = { ArrowUp: 1, ArrowDown: -1 }[event.key];
      if (!way) return;
      event.preventDefault();
      nudgeObject(at => withPlace(at, n, [...at.position_m, at.yaw_deg][n] + way * (event.shiftKey ? step / 5 : step)));
    });
    return made("label", {}, made("span", {}, title), input, made("i", {}, unit));
  }));
  element("object-list").addEventListener("keydown", event => {
    const items = [...event.currentTarget.children], at = items.indexOf(document.activeElement);
    const next = { ArrowUp: at - 1, ArrowDown: at + 1, Home: 0, End: items.length - 1 }[event.key];
    if (next === undefined && event.key !== "Enter") return;
    event.preventDefault();
    if (event.key === "Enter") { element("place-x").focus(); element("place-x").select(); } else items[Math.max(0, Math.min(items.length - 1, next))]?.focus();
  });
  on("state moment object connection", showObjects);
  on("state moment object carry connection", showPlace);
  if (scene.stage) on("state moment object carry connection armed worlds", () => showObject().catch(complain));
}
