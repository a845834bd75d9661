// The floor plan: the same state from above, drawn as SVG in pixels; it edits what the 3D view edits.
const plan = { zoom: 1, middle: null, picture: null, drag: null };
const WATCHED = [["blind", 0.34], ["sensors", 0.2], ["sensors", 0.5]];

/** How metres become pixels of the plan. */
function planScale() {
  const home = element("plan"), [low, high] = roomBox(), pad = 34;
  const width = Math.max(200, home.clientWidth), height = Math.max(200, home.clientHeight);
  const unit = Math.min((width - 2 * pad) / (high[0] - low[0]), (height - 2 * pad) / (high[1] - low[1])) * plan.zoom;
  const [cx, cy] = plan.middle ?? [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2];
  return { unit, width, height, x: value => width / 2 + (value - cx) * unit, y: value => height / 2 - (value - cy) * unit, at: (x, y) => [cx + (x - width / 2) / unit, cy - (y - height / 2) / unit] };
}

/** The watched floor as a picture of one pixel a column: by none, one, two sensors or more. */
function watchedPicture() {
  const { answer } = planner;
  if (!answer?.seen_by || plan.of === answer) return plan.picture;
  const columns = bytesOf(answer.seen_by), [nx, ny] = (answer.seen_window ?? answer.cell).size, canvas = made("canvas", { width: nx, height: ny }), context = canvas.getContext("2d");
  const image = context.createImageData(nx, ny), paints = WATCHED.map(([name, opacity]) => rgba(hue(name), opacity).map(x => Math.round(255 * x)));
  for (let y = 0; y < ny; y++) for (let x = 0; x < nx; x++) {
    const paint = paints[columns[x + nx * y]];
    if (paint) image.data.set(paint, 4 * (x + nx * (ny - 1 - y)));
  }
  context.putImageData(image, 0, 0);
  plan.of = answer;
  if (answer.floor) element("plan-floor").textContent = answer.floor;
  return (plan.picture = canvas.toDataURL());
}

let planAsked = false;
const drawPlanSoon = () => { if (!planAsked) { planAsked = true; requestAnimationFrame(drawPlan); } };

/** Loads what stands where at the chosen moment, with outlines. */
async function loadThings() {
  const { moment } = planner, { worlds } = planner.state, own = chosenScene(), { things } = await loadScenery(moment);
  const ends = ({ at }, worse) => [0, 1, 2].map(axis => at.reduce((end, x, n) => n % 3 === axis ? worse(end, x) : end, at[axis]));
  const short = name => own.things.find(one => one.whole_name === name)?.name ?? name;
  const boxed = thing => ({ name: short(thing.name), whole_name: thing.name, role: thing.role, low_m: ends(thing, Math.min), high_m: ends(thing, Math.max), hull: thing.hull ??= hullOf(thing.at) });
  const room = roomBox(), isWall = thing => isShell({ role: thing.role, box: [ends(thing, Math.min), ends(thing, Math.max)] }, room);
  plan.shells = new Set(things.filter(thing => thing.at.length && isWall(thing)).map(thing => objectOf(thing)?.name));
  plan.things = { moment, worlds, all: things.filter(thing => thing.at.length).map(boxed) };
  drawPlanSoon();
}

/** What stands where: until that of the chosen moment is loaded, what was shown before. */
function thingsNow() {
  if (plan.things?.moment !== planner.moment || plan.things.worlds !== planner.state.worlds) loadThings().catch(complain);
  return plan.things?.all ?? chosenScene().things ?? [];
}

function drawPlan() {
  planAsked = false;
  const home = element("plan");
  if (planner.tab !== "plan" || !planner.state?.scenes?.length) return;
  const scale = planScale(), { x, y, unit, width, height } = scale;
  const box = (low, high, look, more = {}) => shape("rect", { x: px(x(low[0])), y: px(y(high[1])), width: px(Math.max(0, (high[0] - low[0]) * unit)), height: px(Math.max(0, (high[1] - low[1]) * unit)), class: look, ...more });
  const [low, high] = roomBox(), watched = watchedPicture(), { answer } = planner;
  const h = answer?.cell.voxel_size_m, begin = answer?.seen_window?.min ?? [0, 0], from = answer && [0, 1].map(axis => (answer.cell.origin[axis] + begin[axis]) * h), to = answer && plus(from, times((answer.seen_window ?? answer.cell).size.slice(0, 2), h));
  const things = [...thingsNow()].sort((a, b) => area(b) - area(a)).filter(thing => !isShell({ role: thing.role, box: [thing.low_m, thing.high_m] }, [low, high]));
  const inside = things.filter(thing => thing.role !== "human").filter(thing => (thing.high_m[0] - thing.low_m[0]) * unit > [...thing.name].length * 7.6 && (thing.high_m[1] - thing.low_m[1]) * unit > 16);
  const nodes = [
    box(low, high, "floor"),
    ...gridLines(scale, [low, high]),
    ...things.map(thing => thingShape(thing, scale)),
    watched ? shape("image", { href: watched, x: px(x(from[0])), y: px(y(to[1])), width: px((to[0] - from[0]) * unit), height: px((to[1] - from[1]) * unit), preserveAspectRatio: "none", class: "watched" }) : null,
    box(low, high, "room"),
    ...regionBoxes(box, scale),
    ...views(scale),
    ...zoneShapes(scale),
    ...thingNames(inside, scale),
    ...boxHandles(scale),
    ...poseDots(scale),
    ...whyMarks(scale),
    ...objectMarks(scale, things),
    ...zoneBadges(scale),
    ...badges(scale),
    ruler(scale),
  ];
  const picture = shape("svg", { viewBox: `0 0 ${width} ${height}`, width, height, class: "plan" });
  picture.append(...nodes.filter(node => node));
  home.replaceChildren(picture);
  home.place = ([a, b]) => [x(a), y(b)];
}
/** A thing from above; one that can be moved is dragged by it. */
function thingShape(thing, { x, y }) {
  const look = thing.role === "human" ? "person" : thing.role === "robot" ? "robot" : thing.low_m[2] > 2 ? "high" : "low", own = objectOf(thing);
  const node = shape("polygon", { points: outlineOf(thing).map(([a, b]) => `${px(x(a))},${px(y(b))}`).join(" "), class: `${look}${isDragged(own) && mayEdit() ? " drags" : ""}`, title: thing.name });
  node.object = own?.name ?? null;
  return node;
}

/** Names of what stands here, as far as none covers another or a sensor. */
function thingNames(things, { x, y }) {
  const taken = placed().map((_, index) => poseNow(index)).filter(at => at).map(({ position_m: [a, b] }) => [x(a) - 14, y(b) - 14, x(a) + 14, y(b) + 14]);
  if (!layerOf("name").isOn) return [];
  return things.flatMap(({ name, low_m, high_m }) => {
    const [cx, cy] = [x((low_m[0] + high_m[0]) / 2), y((low_m[1] + high_m[1]) / 2)], half = [...name].length * 3.8, own = [cx - half, cy - 9, cx + half, cy + 8];
    if (taken.some(one => one[0] < own[2] && own[0] < one[2] && one[1] < own[3] && own[1] < one[3])) return [];
    taken.push(own);
    return [word(cx, cy + 4, name, { "text-anchor": "middle", class: "named" })];
  });
}
const area = ({ low_m, high_m }) => (high_m[0] - low_m[0]) * (high_m[1] - low_m[1]);

function gridLines({ x, y, unit }, [low, high]) {
  const lines = [], step = unit > 24 ? 1 : 2, last = { anchor: "middle" };
  for (let n = Math.ceil(low[0] / step) * step; n <= high[0]; n += step) lines.push(shape("path", { d: `M${px(x(n))} ${px(y(low[1]))}V${px(y(high[1]))}`, class: "grid" }), word(x(n), y(low[1]) + 16, String(n), { "text-anchor": last.anchor, class: "axis" }));
  for (let n = Math.ceil(low[1] / step) * step; n <= high[1]; n += step) lines.push(shape("path", { d: `M${px(x(low[0]))} ${px(y(n))}H${px(x(high[0]))}`, class: "grid" }), word(x(low[0]) - 7, y(n) + 4, String(n), { "text-anchor": "end", class: "axis" }));
  return lines;
}

function ruler({ unit, height }) {
  const metre = unit > 120 ? 0.5 : 1;
  return shape("g", {}, shape("path", { d: `M14 ${height - 10}v5h${px(metre * unit)}v-5`, class: "ruler" }), word(14 + metre * unit / 2, height - 9, metres(metre, metre < 1 ? 1 : 0), { "text-anchor": "middle", class: "axis" }));
}

/** Regions and entries, and what of them can be dragged. */
const planBoxes = () => [
  ...(planner.state.regions ?? []).map(({ name, shape: one, editable }, n) => ({ table: "region", name, label: name, shape: one, editable: editable !== false, isChosen: n === planner.region, look: "region" })).filter(one => one.shape),
  ...(planner.state.entries ?? []).map(one => ({ table: "entry", name: one.name, label: `entry ${one.name}`, shape: one, editable: one.editable !== false, look: "entry" })),
].map(one => plan.box?.table === one.table && plan.box.name === one.name ? { ...one, shape: plan.box.shape } : one);

function regionBoxes(box, { x, y, unit }) {
  if (!layerOf("region").isOn) return [];
  return planBoxes().map(one => {
    const look = `${one.look}${one.isChosen ? " chosen" : ""}`, { center_m: middle, radius_m: radius } = one.shape;
    return middle ? shape("circle", { cx: px(x(middle[0])), cy: px(y(middle[1])), r: px(radius * unit), class: look }) : box(one.shape.min_m, one.shape.max_m, look);
  });
}

/** The box around a shape. */
const cornersOf = ({ min_m, max_m, center_m, radius_m }) => center_m ? [center_m.map(x => x - radius_m), center_m.map(x => x + radius_m)] : [min_m, max_m];

/** Names and corners of regions and entries; a corner resizes, a name moves. */
function boxHandles({ x, y, width }) {
  if (!layerOf("region").isOn) return [];
  return planBoxes().flatMap(one => {
    const { center_m: middle, radius_m: radius } = one.shape, [low, high] = cornersOf(one.shape), can = one.editable && mayEdit() ? " drags" : "";
    // A name that would leave the picture ends at the right corner.
    const isWide = x(low[0]) + 5 + [...one.label].length * 7.6 > width, label = word(isWide ? x(high[0]) - 5 : x(low[0]) + 5, y(high[1]) + 15, one.label, { class: `of-${one.look}${can}`, "text-anchor": isWide ? "end" : "start" });
    label.dragged = can ? { ...one, corner: null } : null;
    const corners = can ? (middle ? [[2, 2]] : [[0, 0], [0, 1], [1, 0], [1, 1]]).map(([i, j]) => {
      const [a, b] = middle ? [middle[0] + radius, middle[1]] : [[low, high][i][0], [low, high][j][1]];
      const node = shape("rect", { x: px(x(a)) - 4, y: px(y(b)) - 4, width: 8, height: 8, class: `corner of-${one.look}`, title: `Drag to resize ${one.label}` });
      node.dragged = { ...one, corner: [i, j] };
      return node;
    }) : [];
    return [label, ...corners];
  });
}

/** Of rays in any order the farthest in each direction, around. */
function farthestAround(ends, [ax, ay]) {
  const best = new Map();
  for (const end of ends) {
    const off = Math.hypot(end[0] - ax, end[1] - ay), way = Math.round(Math.atan2(end[1] - ay, end[0] - ax) / RAD / 15);
    if (off > 0.05 && !(best.get(way)?.off > off)) best.set(way, { end, off });
  }
  return [...best].sort(([a], [b]) => a - b).map(([, { end }]) => end);
}

/** What each sensor watches, from above: for each direction the farthest first hit. */
function views({ x, y }) {
  if (!layerOf("view").isOn || !planner.answer) return [];
  return (planner.answer.frustums ?? []).map((one, index) => {
    const at = poseNow(index);
    if (!at || !one?.ends?.length || planner.dead === index) return null;
    const [ax, ay] = at.position_m, far = ([ex, ey]) => Math.hypot(ex - ax, ey - ay);
    const columns = isGrid(one) ? Array.from({ length: one.columns }, (_, c) => Array.from({ length: one.rows }, (_, r) => one.ends[r * one.columns + c]).reduce((a, b) => far(b) > far(a) ? b : a)) : farthestAround(one.ends, [ax, ay]);
    const looksDown = Math.abs(forwardOf(at)[2]) > 0.95, ends = looksDown && isGrid(one) ? rim(one).map(n => one.ends[n]) : columns;
    const points = [...(looksDown || !isGrid(one) ? [] : [[ax, ay]]), ...ends].map(([a, b]) => `${px(x(a))},${px(y(b))}`).join(" ");
    return shape("polygon", { points, class: `field${index === planner.selected ? " chosen" : ""}` });
  });
}

function poseDots({ x, y }) {
  const sensor = sensorOfDots();
  if (!layerOf("pose").isOn || !sensor || sensor.carried || !mayEdit()) return [];
  return posesByPlace(sensor, at => at.slice(0, 2).join()).map(poses => {
    const [cx, cy] = [x(poses[0].at_m[0]), y(poses[0].at_m[1])];
    return shape("circle", { cx: px(cx), cy: px(cy), r: 4, class: "dot", title: wordsOfDot(sensor, poses), onclick: () => chooseListed(sensor, poses, [cx, cy]) });
  });
}

function whyMarks({ x, y }) {
  const { why, measured } = planner, marks = [];
  for (const one of why?.sensors ?? []) { const at = poseNow(one.index); if (at) marks.push(shape("path", { d: `M${px(x(at.position_m[0]))} ${px(y(at.position_m[1]))}L${px(x(why.at_m[0]))} ${px(y(why.at_m[1]))}`, class: one.sees ? "sees" : "blocked" })); }
  if (why) marks.push(shape("circle", { cx: px(x(why.at_m[0])), cy: px(y(why.at_m[1])), r: 6, class: "asked" }));
  const ends = measured?.ends ?? [];
  if (ends.length > 1) marks.push(shape("path", { d: `M${ends.map(end => `${px(x(end[0]))} ${px(y(end[1]))}`).join("L")}`, class: "measured" }), word(x((ends[0][0] + ends[1][0]) / 2), y((ends[0][1] + ends[1][1]) / 2) - 6, metres(lengthOf(minus(ends[1], ends[0])), 3), { "text-anchor": "middle" }));
  ends.forEach(end => marks.push(shape("circle", { cx: px(x(end[0])), cy: px(y(end[1])), r: 4, class: "measured" })));
  return marks;
}

/** The sensors with their letters; of the chosen one a handle that turns it. */
function badges(scale) {
  const { x, y } = scale, all = placed().map((one, index) => ({ letter: letterAt(index), index, at: poseNow(index), problem: problemOf(index) })).filter(({ at }) => at);
  if (planner.draft?.index === null) all.push({ letter: "+", index: null, at: planner.draft.at });
  return all.flatMap(({ letter, index, at, problem }) => {
    const [cx, cy] = [x(at.position_m[0]), y(at.position_m[1])], isChosen = index === planner.selected, along = forwardOf(at), level = Math.hypot(along[0], along[1]);
    const look = `badge${isChosen ? " chosen" : ""}${problem ? " bad" : ""}${planner.dead === index ? " dead" : ""}`;
    const [ux, uy] = level > 0.05 ? [along[0] / level, -along[1] / level] : [Math.cos(at.pan_deg * RAD), -Math.sin(at.pan_deg * RAD)], nodes = [];
    const reach = isChosen ? 40 : 18;
    nodes.push(shape("path", { d: `M${px(cx)} ${px(cy)}l${px(ux * reach)} ${px(uy * reach)}`, class: `look${isChosen ? " chosen" : ""}${index === null ? " held" : ""}` }));
    if (isChosen && index !== null && mayEdit()) { const handle = shape("circle", { cx: px(cx + ux * reach), cy: px(cy + uy * reach), r: 7, class: "aim", title: "Drag to turn" }); handle.turned = index; nodes.push(handle); }
    const badge = shape("g", { class: index === null ? `${look} held` : look, title: index === null ? "" : wordsOf(index) }, shape("circle", { cx: px(cx), cy: px(cy), r: 11.5 }), word(cx, cy + 4.5, letter, { "text-anchor": "middle", class: "letter" }));
    badge.moved = index;
    return [...nodes, badge];
  });
}
