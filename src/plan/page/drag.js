// Moves and aims sensors: a draft is shown and counted while it changes, and becomes one edit at its end.
const COMMIT_MS = 350;
let settles = 0;

/** Begins to change a sensor; null where it may not be changed. */
function beginDraft(index) {
  flushDraft();
  const one = placed()[index];
  if (!one?.at_m || !mayEdit()) return null;
  if (sensorOf(one)?.carried) { notify(`${letterAt(index)} moves with the robot: choose one of its listed poses.`); return null; }
  select(index);
  planner.draft = { index, at: poseNow(index), snapped: null, gesture: nextGesture(), problem: null };
  return planner.draft;
}

function changeDraft(at, snapped = null) {
  Object.assign(planner.draft, { at: snapped ? sixOf(snapped) : written(at), snapped: snapped?.name ?? null });
  tell("draft");
  wantScore("coarse");
}

/** Makes an edit of the draft. */
function commitDraft() {
  clearTimeout(settles);
  const { draft } = planner;
  if (!draft || draft.isSettling) return;
  draft.isSettling = true;
  const { index, at, snapped, gesture: of } = draft;
  const change = snapped ? { edit: "snap", index, pose: snapped } : { edit: "move", index, at: written(at) };
  edit(change, of).then(is => { if (!is) dropDraft(draft); });
}

/** Forgets a draft; what is counted then is what is written. */
function dropDraft(draft = planner.draft) {
  clearTimeout(settles);
  if (!draft || planner.draft !== draft) return;
  planner.draft = null;
  tell("draft");
  wantScore("fine");
}
const flushDraft = () => { if (planner.draft && planner.draft.index !== null) commitDraft(); if (planner.carry) commitCarry(); };

/** Moves the chosen sensor by a step, or turns it, and makes an edit of it when no other step follows soon. */
function nudge(change) {
  const { selected } = planner, isSame = planner.draft?.index === selected && !planner.draft.isSettling;
  if (!isSame && !beginDraft(selected)) return false;
  changeDraft(change(planner.draft.at));
  clearTimeout(settles);
  settles = setTimeout(commitDraft, COMMIT_MS);
  return true;
}

/** To 10 cm along a surface and to 5°, and as far off the surface as it is. */
function steppedOn(at, normal) {
  const next = stepped(at), axis = normal ? [0, 1, 2].find(n => Math.abs(normal[n]) > 0.99) : undefined;
  if (axis !== undefined) next.position_m[axis] = at.position_m[axis];
  return next;
}

const partNamed = name => scene.stage.parts.get(name);
const isPart = (found, name) => !!found && found.part === partNamed(name);

/** What a pointer that is pressed on the view drags. */
function grab(event) {
  if (!mayEdit() || planner.armed || planner.tool === "why" || planner.tool === "measure") return null;
  const found = scene.stage.pointed(event.offsetX, event.offsetY);
  const own = index => ({ index, begun: false, x: event.offsetX, y: event.offsetY });
  if (isPart(found, "aim: target")) return gestureOf(own(planner.selected), aiming());
  if (isPart(found, "axis: ends")) return gestureOf(own(planner.selected), along(found.n, event));
  if (!isPart(found, "sensor places")) return grabObject(event, found);
  const index = found.part.indices[found.n];
  if (index < 0) return null;
  select(index);
  return gestureOf(own(index), planner.tool === "aim" ? aiming() : sliding(index));
}

/** A drag that begins when the pointer has moved a little, so that a click chooses only. */
function gestureOf(own, change) {
  return {
    move(event) {
      if (own.isOver) return;
      if (!own.begun) {
        if (Math.hypot(event.offsetX - own.x, event.offsetY - own.y) < 3) return;
        own.draft = beginDraft(own.index);
        if (!own.draft) { own.isOver = true; return; }
        own.begun = true;
      }
      // Esc has ended it.
      if (planner.draft !== own.draft || own.draft.isSettling) { own.isOver = true; return; }
      change(event, own.draft);
    },
    end(_, isDropped) {
      if (!own.begun || own.isOver) return;
      if (isDropped) dropDraft(own.draft); else if (planner.draft === own.draft) commitDraft();
    },
  };
}

/** Slides the body on the surface under the pointer; near a listed pose it takes that. What a link carries slides on its robot only. */
function sliding(index) {
  let normal = null;
  const sensor = sensorOf(placed()[index]), at = poseNow(index);
  // The surface that it is mounted on now, behind it.
  const behind = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]].map(way => ({ way, met: scene.stage.meet(at.position_m, way) })).filter(({ met }) => met && met.distance < 0.25);
  behind.sort((a, b) => a.met.distance - b.met.distance);
  if (behind.length) normal = times(behind[0].way, -1);
  let last = at;
  return event => {
    const { stage } = scene, [x, y] = [event.offsetX, event.offsetY];
    if (!event.altKey && !event.shiftKey) {
      const near = nearestListed(sensor, last, place => { const on = stage.place(place); return on ? Math.hypot(on[0] - x, on[1] - y) : Infinity; }, 16);
      if (near) { changeDraft(null, near); return; }
    }
    const carrier = sensor.on?.object, isOwn = part => carrier ? part.thing === carrier || part.thing?.startsWith(`${carrier}/`) : part.role !== "human";
    const hit = stage.hit(x, y, isOwn);
    if (!hit && !carrier) return;
    if (!hit) {
      // Off its robot it is moved across the view, turned as before.
      const ray = stage.rayAt(x, y), place = onPlane(ray.from, ray.along, last.position_m, stage.axes().back);
      if (place) { last = { ...last, position_m: place }; changeDraft(event.shiftKey ? steppedOn(last, null) : last); }
      return;
    }
    last = sensor.level ? { ...last, position_m: hit.at } : mounted(last, hit, normal);
    normal = hit.normal;
    changeDraft(event.shiftKey ? steppedOn(last, normal) : last);
  };
}

/** Aims at what is under the pointer. */
function aiming() {
  return (event, draft) => {
    const { stage } = scene, ray = stage.rayAt(event.offsetX, event.offsetY), hit = stage.hit(event.offsetX, event.offsetY);
    const target = hit?.at ?? onPlane(ray.from, ray.along, scene.handles?.end ?? draft.at.position_m, stage.axes().back);
    if (!target || lengthOf(minus(target, draft.at.position_m)) < 0.1) return;
    turnDraft(aimedAt(draft.at, target), event);
  };
}

/** Turns the draft: to a listed pose at its place that is turned nearly so, to 5°, or freely. */
function turnDraft(next, event) {
  if (event.shiftKey) { changeDraft({ ...next, pan_deg: Math.round(next.pan_deg / 5) * 5, tilt_deg: Math.round(next.tilt_deg / 5) * 5 }); return; }
  const here = event.altKey ? null : nearestListed(sensorOf(placed()[planner.draft.index]), next, place => lengthOf(minus(place, next.position_m)), 0.002);
  const isAlike = here && dot(forwardOf(sixOf(here)), forwardOf(next)) > Math.cos(4 * RAD);
  changeDraft(next, isAlike ? here : null);
}

/** Moves along an axis of the cell. */
function along(axis, event) {
  const direction = [0, 1, 2].map(n => n === axis ? 1 : 0), start = poseNow(planner.selected);
  const where = ({ offsetX, offsetY }) => { const ray = scene.stage.rayAt(offsetX, offsetY); return nearestAlong(start.position_m, direction, ray.from, ray.along); };
  const begin = where(event);
  return event => {
    const place = start.position_m[axis] + where(event) - begin, step = event.shiftKey ? 0.1 : event.altKey ? 0.001 : 0.01;
    changeDraft({ ...start, position_m: start.position_m.with(axis, Math.round(place / step) * step) });
  };
}

/** What a sensor can be mounted on: everything but people. */
const isMount = part => part.role !== "human";

/** What happens to the view beside turning it. */
function stageHooks() {
  const isPicking = () => planner.armed || ["why", "measure"].includes(planner.tool);
  // The held sensor is shown under the pointer: it must not hide the dots there.
  const dotAt = ({ offsetX, offsetY }) => scene.stage.pointed(offsetX, offsetY, part => part === partNamed("pose dots"));
  return {
    grab,
    hover(event, found) {
      if (planner.armed) {
        const dot = dotAt(event);
        scene.stage.canvas.title = dot ? dot.part.words(dot.n) : "";
        if (dot) hideGhost(); else ghost(scene.stage.hit(event.offsetX, event.offsetY, isMount));
        return dot ? "pointer" : "crosshair";
      }
      if (isPicking()) return "crosshair";
      return isPart(found, "sensor places") || isPart(found, "aim: target") || isPart(found, "axis: ends") || isPart(found, "object: place") ? "move" : found ? "pointer" : null;
    },
    click(event) {
      const { offsetX: x, offsetY: y } = event, found = scene.stage.pointed(x, y), hit = scene.stage.hit(x, y);
      if (planner.armed) {
        const dot = dotAt(event);
        if (dot) dot.part.heard(dot.n); else { ghost(scene.stage.hit(x, y, isMount)); placeGhost(); }
        return true;
      }
      if (planner.tool === "why") { if (hit) askWhy(hit.at); return true; }
      if (planner.tool === "measure") { if (hit) measure(hit.at); return true; }
      if (isPart(found, "sensor places")) return true;
      if (planner.tool === "aim" && !found && hit && poseNow(planner.selected)) {
        const draft = beginDraft(planner.selected);
        if (draft) { turnDraft(aimedAt(draft.at, hit.at), event); commitDraft(); }
        return true;
      }
      const own = !found && hit?.part.thing && !hit.part.shell ? objectOf({ name: hit.part.thing }) : null;
      if (own) selectObject(own.name);
      return !!own;
    },
    double(event) {
      if (isPicking()) return;
      const found = scene.stage.pointed(event.offsetX, event.offsetY), hit = scene.stage.hit(event.offsetX, event.offsetY);
      const at = isPart(found, "sensor places") ? poseNow(found.part.indices[found.n])?.position_m : hit?.at;
      if (at) scene.stage.focus(at);
    },
    key: event => moveByKey(event),
    keyWords: "Arrow keys move the chosen sensor or object, page up and down raise and lower it; with nothing chosen they turn the view. Plus and minus bring it nearer.",
    left() { planner.through = null; tell("through"); },
  };
}
