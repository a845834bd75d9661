// What a pointer does on the floor plan: moves and turns sensors and objects, moves and resizes regions and entries, asks, measures.

/** The node under the pointer, or what it belongs to, that has such a property. */
const owner = (node, name) => { for (; node && node !== element("plan"); node = node.parentNode) if (node[name] !== undefined && node[name] !== null) return node; return null; };

/** How high above the floor a place is that is clicked on the plan, to aim at it or to ask about it. */
const ABOVE_FLOOR_M = 1;
const floorBelow = () => roomBox()[0][2];

/** What a place on the plan stands for, in metres. */
const planPlace = event => { const { left, top } = element("plan").getBoundingClientRect(); return planScale().at(event.clientX - left, event.clientY - top); };

function pressPlan(event) {
  if (event.button !== 0 && event.pointerType === "mouse") return;
  const begin = planPlace(event), home = element("plan");
  const turned = owner(event.target, "turned"), moved = owner(event.target, "moved"), dragged = owner(event.target, "dragged");
  const spun = owner(event.target, "spun"), object = owner(event.target, "object"), zoned = owner(event.target, "zoned"), isFree = !planner.armed && !["why", "measure"].includes(planner.tool);
  home.setPointerCapture(event.pointerId);
  const own = { x: event.clientX, y: event.clientY, begin, hasMoved: false, isOver: false, target: event.target };
  if (mayEdit() && !planner.armed && turned) Object.assign(own, { index: turned.turned, change: turnOnPlan });
  else if (mayEdit() && !planner.armed && moved) { Object.assign(own, { index: moved.moved, change: moveOnPlan(begin) }); select(moved.moved); }
  else if (mayEdit() && isFree && zoned) { select(zoned.zoned.index); Object.assign(own, { zone: zoned.zoned }); }
  else if (mayEdit() && isFree && spun) Object.assign(own, { name: spun.spun, carry: spinOnFloor() });
  else if (mayEdit() && !planner.armed && dragged) Object.assign(own, { box: dragged.dragged });
  else if (mayEdit() && isFree && isDragged(objectNamed(object?.object))) Object.assign(own, { name: object.object, carry: carryOnFloor(begin) });
  else Object.assign(own, { middle: plan.middle ?? [0, 1].map(axis => (roomBox()[0][axis] + roomBox()[1][axis]) / 2) });
  plan.drag = own;
}

function movePlan(event) {
  const own = plan.drag;
  if (!own) { if (planner.armed) ghostOnPlan(planPlace(event)); return; }
  if (!own.hasMoved && Math.hypot(event.clientX - own.x, event.clientY - own.y) < 3) return;
  if (!own.hasMoved) {
    own.hasMoved = true;
    if (own.carry) { own.draft = beginCarry(own.name); if (!own.draft) own.isOver = true; }
    if (own.change) { own.draft = beginDraft(own.index); if (!own.draft) own.isOver = true; }
  }
  if (own.isOver) return;
  if (own.carry) {
    if (planner.carry !== own.draft || own.draft.isSettling) { own.isOver = true; return; }
    own.carry(planPlace(event), event);
  } else if (own.change) {
    if (planner.draft !== own.draft || own.draft.isSettling) { own.isOver = true; return; }
    own.change(event, own.draft);
  } else if (own.zone) moveZone(own.zone, [own.begin, planPlace(event)], event);
  else if (own.box) moveBox(own, event);
  else {
    const { unit } = planScale();
    plan.middle = [own.middle[0] - (event.clientX - own.x) / unit, own.middle[1] + (event.clientY - own.y) / unit];
    drawPlanSoon();
  }
}

function releasePlan(event) {
  const own = plan.drag;
  plan.drag = null;
  if (!own || own.isOver) return;
  if (!own.hasMoved) { clickPlan(event, own); return; }
  if (event.type === "pointercancel") { plan.box = null; plan.zone = null; if (own.carry) dropCarry(own.draft); else if (own.draft) dropDraft(own.draft); drawPlanSoon(); return; }
  if (own.zone) { commitZone(); return; }
  if (own.carry) { if (planner.carry === own.draft) commitCarry(); return; }
  if (own.draft && planner.draft === own.draft) commitDraft();
  if (plan.box) { const { table, name, shape: { min_m, max_m, center_m, radius_m } } = plan.box; edit({ edit: "set_box", table, name, ...(center_m ? { center_m, radius_m } : { min_m, max_m }) }).then(() => { plan.box = null; drawPlanSoon(); }); }
}

function clickPlan(event, own) {
  const [a, b] = own.begin, dot = own.target.closest?.(".dot");
  if (planner.armed && !dot) { ghostOnPlan(own.begin); placeGhost(); return; }
  if (planner.tool === "why") { askWhy([a, b, floorBelow() + ABOVE_FLOOR_M]); return; }
  if (planner.tool === "measure") { measure([a, b, 0]); return; }
  // Captured pointers send no click to what was pressed.
  if (own.zone) return;
  if (dot) { dot.dispatchEvent(new MouseEvent("click")); return; }
  if (planner.tool === "aim" && own.change === undefined && beginDraft(planner.selected)) {
    turnDraft(aimedAt(planner.draft.at, [a, b, floorBelow() + ABOVE_FLOOR_M]), event);
    commitDraft();
    return;
  }
  const object = owner(own.target, "object");
  if (object) { selectObject(object.object); return; }
  if (own.box?.table === "region") { planner.region = planner.state.regions.findIndex(({ name }) => name === own.box.name); tell("region"); }
}

/** Moves a sensor level; near a listed pose it takes that. */
function moveOnPlan(begin) {
  let own = null;
  return (event, draft) => {
    own ??= { ...draft.at };
    const now = planPlace(event), { unit } = planScale(), step = event.shiftKey ? 0.1 : event.altKey ? 0.001 : 0.01;
    const place = [0, 1].map(axis => Math.round((own.position_m[axis] + now[axis] - begin[axis]) / step) * step);
    const at = { ...own, position_m: [...place, own.position_m[2]] };
    const near = event.altKey || event.shiftKey ? null : nearestOnPlan(sensorOf(placed()[draft.index]), at, 12 / unit);
    changeDraft(at, near);
  };
}

/** The listed pose nearest from above; of several there the one at the most similar height. */
function nearestOnPlan(sensor, at, most) {
  const level = place => Math.hypot(place[0] - at.position_m[0], place[1] - at.position_m[1]);
  const near = listed(sensor).filter(pose => level(pose.at_m) < most);
  const unlike = pose => level(pose.at_m) + 0.2 * Math.abs(pose.at_m[2] - at.position_m[2]) + 0.05 * (1 - dot(forwardOf(at), forwardOf(sixOf(pose))));
  return near.sort((a, b) => unlike(a) - unlike(b))[0] ?? null;
}

function turnOnPlan(event, draft) {
  const [a, b] = planPlace(event), [x, y] = draft.at.position_m, pan = Math.atan2(b - y, a - x) / RAD;
  const step = event.shiftKey ? 5 : event.altKey ? 0.1 : 1;
  turnDraft({ ...draft.at, pan_deg: Math.round(pan / step) * step }, { shiftKey: false, altKey: event.altKey });
}

/** Moves a ball, or makes it larger, to 5 cm. */
function moveBall(own, event) {
  const now = planPlace(event), step = event.altKey ? 0.01 : 0.05, { center_m, radius_m } = own.box.shape, to = value => rounded(Math.round(value / step) * step, 3);
  const isLarger = own.box.corner !== null, by = minus(now, own.begin);
  const next = isLarger ? { radius_m: Math.max(step, to(Math.hypot(now[0] - center_m[0], now[1] - center_m[1]))) } : { center_m: [to(center_m[0] + by[0]), to(center_m[1] + by[1]), center_m[2]] };
  plan.box = { table: own.box.table, name: own.box.name, shape: { ...own.box.shape, ...next } };
  drawPlanSoon();
}

/** Moves a region or an entry, or one of its corners, to 5 cm. */
function moveBox(own, event) {
  if (own.box.shape.center_m) { moveBall(own, event); return; }
  const now = planPlace(event), step = event.altKey ? 0.01 : 0.05, { min_m, max_m } = own.box.shape;
  const by = [0, 1].map(axis => Math.round((now[axis] - own.begin[axis]) / step) * step), low = [...min_m], high = [...max_m];
  for (const axis of [0, 1]) {
    const corner = own.box.corner?.[axis];
    if (corner !== 1) low[axis] = rounded(min_m[axis] + by[axis], 3);
    if (corner !== 0) high[axis] = rounded(max_m[axis] + by[axis], 3);
    if (high[axis] - low[axis] < step) { if (corner === 0) low[axis] = rounded(high[axis] - step, 3); else high[axis] = rounded(low[axis] + step, 3); }
  }
  plan.box = { table: own.box.table, name: own.box.name, shape: { ...own.box.shape, min_m: low, max_m: high } };
  drawPlanSoon();
}

/** A new sensor from above: on a wall if one is near, else under the ceiling. */
function ghostOnPlan([a, b]) {
  if (isLevelArmed()) { ghost({ at: [a, b, roomBox()[0][2]], normal: [0, 0, 1] }); return; }
  const [low, high] = roomBox(), walls = [[a - low[0], [1, 0, 0]], [high[0] - a, [-1, 0, 0]], [b - low[1], [0, 1, 0]], [high[1] - b, [0, -1, 0]]].sort((one, other) => one[0] - other[0]);
  const [near, normal] = walls[0], z = Math.min(high[2] - 0.1, 2.5);
  if (near < 0.4) {
    const at = [Math.max(low[0], Math.min(high[0], a)), Math.max(low[1], Math.min(high[1], b)), z], axis = normal.findIndex(x => x);
    at[axis] = normal[axis] > 0 ? low[axis] : high[axis];
    ghost({ at, normal });
  } else ghost({ at: [a, b, high[2]], normal: [0, 0, -1] });
}

function makePlan() {
  const home = element("plan");
  home.addEventListener("pointerdown", pressPlan);
  home.addEventListener("pointermove", movePlan);
  for (const end of ["pointerup", "pointercancel"]) home.addEventListener(end, releasePlan);
  home.addEventListener("wheel", event => {
    event.preventDefault();
    const [a, b] = planPlace(event), [cx, cy] = plan.middle ?? [0, 1].map(axis => (roomBox()[0][axis] + roomBox()[1][axis]) / 2), factor = Math.exp(-Math.sign(event.deltaY) * 0.15);
    const zoom = Math.max(1, Math.min(20, plan.zoom * factor)), share = 1 - plan.zoom / zoom;
    plan.middle = zoom === 1 ? null : [cx + (a - cx) * share, cy + (b - cy) * share];
    plan.zoom = zoom;
    drawPlanSoon();
  }, { passive: false });
  home.addEventListener("keydown", event => moveByKey(event));
  on("worlds state selected draft answer armed why measure region tab moment layers object carry zone", drawPlanSoon);
  new ResizeObserver(drawPlanSoon).observe(home);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { plan.of = null; drawPlanSoon(); });
}
