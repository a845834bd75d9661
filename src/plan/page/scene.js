// The cell in three dimensions: what stands there, the sensors with their letters, what they watch and what stays blind.
const scene = { stage: null, faced: null, volumes: 0 };

function makeScene() {
  const home = element("view");
  try { scene.stage = stage(home, "The cell in three dimensions.", stageHooks()); } catch (error) { console.info(error.message); }
  home.stage = scene.stage ?? "none";
  if (!scene.stage) { planner.tab = "plan"; element("tab-3d").hidden = true; home.hidden = true; return; }
  on("worlds moment", () => showScenery().catch(complain));
  on("answer", showAnswer);
  on("state selected draft answer armed tool dead connection", showSensors);
  on("through", showSensors);
  on("selected dead through", () => { if (planner.answer) showViews(); });
  on("region", () => { if (planner.answer) showVolumes(); });
  on("state region", showRegions);
  on("worlds moment armed selected state dots region", showPoses);
  on("why measure", showWhy);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { showScenery(); showSensors(); showPoses(); });
}

/** Whether a thing bounds its room: it spans most of it in two directions. */
function isShell({ role, box }, [low, high]) {
  const spans = [0, 1, 2].filter(axis => box[1][axis] - box[0][axis] > 0.8 * (high[axis] - low[axis]));
  return role === "environment" && spans.length >= 2;
}

/** What is smaller than this has no name in the view. */
const LEAST_NAMED_M3 = 0.02;
const volumeOf = ([low, high]) => high.reduce((product, x, axis) => product * Math.max(0.02, x - low[axis]), 1);

async function showScenery() {
  if (!planner.state?.scenes?.length) return;
  const moment = planner.moment, { things } = await loadScenery(moment);
  if (moment !== planner.moment) return;
  const { stage } = scene, room = roomBox(), colours = { environment: hue("environment"), robot: hue("robot"), human: hue("person") };
  stage.clear("thing");
  stage.clear("edge");
  const names = [];
  things.forEach((thing, n) => {
    thing.box ??= boxOf({ at: thing.at });
    const shell = isShell(thing, room) ? room : undefined;
    stage.show(`thing ${n}`, { kind: "surface", at: thing.at, faces: thing.faces, colour: shell ? hue("wall") : colours[thing.role] ?? colours.environment, shell, isSolid: true, isCut: true, thing: thing.name, role: thing.role });
    thing.creases ??= thing.edges?.length ? thing.edges.flatMap(corner => thing.at.slice(3 * corner, 3 * corner + 3)) : thing.faces.length < 9000 ? creases(thing, thing.role === "environment" ? 25 : 40) : [];
    stage.show(`edge ${n}`, { kind: "lines", at: thing.creases, colour: hue(shell ? "frame" : "ink"), opacity: shell ? 0.5 : thing.role === "human" ? 0.12 : 0.42, width: shell ? 1.2 : 1, shell, isCut: true });
    if (!shell && thing.role !== "human" && volumeOf(thing.box) > LEAST_NAMED_M3) names.push({ at: [(thing.box[0][0] + thing.box[1][0]) / 2, (thing.box[0][1] + thing.box[1][1]) / 2, thing.box[1][2]], word: thing.name });
  });
  stage.show("name: things", { kind: "words", at: names.flatMap(one => one.at), words: names.map(one => one.word), isShown: layerOf("name").isOn });
  if (!things.some(thing => isShell(thing, room))) stage.show("edge room", { kind: "lines", at: edges(room), colour: hue("frame"), width: 1.2 });
  if (scene.faced !== chosenScene().name) { stage.face(room); scene.faced = chosenScene().name; }
  document.body.dataset.scenery = moment;
  const cell = await loadCell(moment, "coarse");
  if (moment !== planner.moment) return;
  cell.crowding ??= crowding(cell.truth.map(what => what > 0 && what < 4 ? 1 : 0), cell.size);
  stage.darken(cell, cell.voxel_size_m, cell.crowding);
}

const hueOfSensor = index => planner.dead === index ? hue("no-sensor") : problemOf(index) ? hue("bad") : index === planner.selected ? hue("picked") : hue("badge");

/** Bodies and letters of the placed sensors, and of the chosen one where it looks. */
function showSensors() {
  const { stage } = scene, all = placed().map((one, index) => ({ one, index, at: poseNow(index) })).filter(({ at, index }) => at && planner.through !== index);
  const { draft } = planner;
  if (draft && draft.index === null) all.push({ one: { letter: "+" }, index: -1, at: draft.at });
  const bodies = { at: [], faces: [], colours: [] };
  for (const { index, at } of all) addBody(bodies, at, index < 0 ? hue("picked") : hueOfSensor(index));
  stage.show("sensor bodies", { kind: "surface", ...bodies });
  stage.show("sensor places", { kind: "points", at: all.flatMap(({ at }) => at.position_m), colours: all.map(({ index }) => index < 0 ? hue("picked") : hueOfSensor(index)), width: 22, isOver: true, words: n => wordsOf(all[n].index), indices: all.map(({ index }) => index) });
  stage.show("sensor letters", { kind: "words", at: all.flatMap(({ at }) => at.position_m), words: all.map(({ one, index }) => one.letter ?? letterOf(index)), look: "badge" });
  showHandles();
}

/** What a sensor is called when it is pointed at. */
function wordsOf(index) {
  const one = placed()[index];
  return one ? `${letterAt(index)} ${one.sensor}${one.place ? `, ${one.place}` : ""}` : "";
}

/** A small housing that looks along x. */
function addBody({ at, faces, colours }, pose, colour) {
  const corner = n => [n & 1 ? 0.05 : -0.045, n & 2 ? 0.065 : -0.065, n & 4 ? 0.032 : -0.032];
  const first = at.length / 3;
  for (let n = 0; n < 8; n++) { at.push(...plus(pose.position_m, turnedBy(pose, corner(n)))); colours.push(colour); }
  for (const [a, b, c, d] of [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]]) faces.push(...[a, b, c, a, c, d].map(n => first + n));
}

/** Handles of the chosen sensor: where its axis meets the scene, and along the axes of the cell. */
function showHandles() {
  const { stage } = scene, at = poseNow(planner.selected), isCarried = at && sensorOf(placed()[planner.selected])?.carried;
  const isThrough = planner.through === planner.selected, isShown = !!at && !isCarried && !isThrough && mayEdit() && !planner.armed;
  scene.handles = null;
  if (!isShown) { ["aim: line", "aim: target", "axis: lines", "axis: ends"].forEach(name => stage.show(name)); return; }
  const along = forwardOf(at), met = stage.meet(plus(at.position_m, times(along, 0.06)), along);
  const end = met ? met.at : plus(at.position_m, times(along, 3));
  const reach = 0.45, tips = [0, 1, 2].map(axis => plus(at.position_m, [0, 1, 2].map(n => n === axis ? reach : 0)));
  scene.handles = { end, tips, at };
  stage.show("aim: line", { kind: "lines", at: [...at.position_m, ...end], colour: hue("picked"), opacity: 0.9, width: 1.6, isOver: true });
  stage.show("aim: target", { kind: "points", at: end, colour: hue("picked"), width: planner.tool === "aim" ? 18 : 14, ring: true, isOver: true, words: () => "Drag to aim" });
  const isMoving = planner.tool === "move";
  stage.show("axis: lines", { kind: "lines", at: tips.flatMap(tip => [...at.position_m, ...tip]), colours: NAMES.map(name => hue(`axis-${name}`)), width: 3, isOver: true, isShown: isMoving });
  stage.show("axis: ends", { kind: "points", at: tips.flat(), colours: NAMES.map(name => hue(`axis-${name}`)), width: 11, isOver: true, isShown: isMoving, words: n => `Drag along ${NAMES[n]}` });
}

/** Fields of view, cut by what they hit first; then the volumes, a frame later. */
function showAnswer() {
  showViews();
  cancelAnimationFrame(scene.volumes);
  scene.volumes = requestAnimationFrame(showVolumes);
}

function showViews() {
  const { stage } = scene, { frustums = [] } = planner.answer;
  stage.clear("view");
  frustums.forEach((one, index) => {
    const at = poseNow(index);
    if (!one?.ends?.length || !at?.position_m || planner.dead === index || planner.through === index) return;
    // What falls on a wall that hides nothing is left out, as the wall is.
    const shell = roomBox(), isChosen = index === planner.selected, colour = isChosen ? hue("picked") : hue("sensors"), isShown = layerOf("view").isOn;
    stage.show(`view ${index}: rim`, { kind: "lines", at: rimOf(one, at.position_m), colour, opacity: (isChosen ? 0.85 : 0.2) * (isGrid(one) ? 1 : 0.3), width: isChosen && isGrid(one) ? 1.6 : 1.1, shell, isShown });
    stage.show(`view ${index}: ends`, { kind: "points", at: isGrid(one) || !isChosen ? [] : one.ends.flat(), colour, width: 3, isShown });
    // Only the chosen one is filled: several veils over each other hide what they are drawn for.
    const fan = isChosen ? fanOf(one, at.position_m) : null;
    if (fan) stage.show(`view ${index}: fan`, { kind: "surface", ...fan, colour, opacity: 0.13, shell, isShown });
  });
}

const isGrid = ({ rows, columns }) => rows > 1 && columns > 1;

/** The places at the rim of a grid of ends, in order around it. */
function rim({ rows, columns }) {
  const across = Array.from({ length: columns }, (_, n) => n), down = Array.from({ length: rows }, (_, n) => n);
  return [...across, ...down.slice(1).map(row => row * columns + columns - 1), ...across.slice(0, -1).reverse().map(column => (rows - 1) * columns + column), ...down.slice(1, -1).reverse().map(row => row * columns)];
}

function rimOf(one, at) {
  const ends = one.ends;
  // Rays that are no picture are drawn each.
  if (!isGrid(one)) return ends.flatMap(end => [...at, ...end]);
  const around = rim(one);
  const lines = around.flatMap((n, i) => [...ends[n], ...ends[around[(i + 1) % around.length]]]);
  const corners = [0, one.columns - 1, (one.rows - 1) * one.columns, one.rows * one.columns - 1];
  return [...lines, ...corners.flatMap(n => [...at, ...ends[n]])];
}

/** The sides of a field of view, and what it falls on. */
function fanOf({ ends, rows, columns }, at) {
  if (!isGrid({ rows, columns })) return null;
  const faces = [], apex = ends.length, around = rim({ rows, columns });
  for (let row = 0; row + 1 < rows; row++) for (let column = 0; column + 1 < columns; column++) {
    const a = row * columns + column, c = a + columns;
    faces.push(a, a + 1, c + 1, a, c + 1, c);
  }
  around.forEach((n, i) => faces.push(apex, n, around[(i + 1) % around.length]));
  return { at: [...ends.flat(), ...at], faces };
}

/** The outsides of what is blind, not seen, missed and false, in the chosen region. */
function showVolumes() {
  const { answer } = planner, { stage } = scene;
  if (!answer || answer.moment !== planner.moment) return;
  const found = outcomes(answer), h = answer.cell.voxel_size_m;
  for (const layer of LAYERS.filter(layer => layer.outcome)) {
    const number = OUTCOME_NUMBER[layer.name];
    if (!layer.isOn) { stage.show(layer.name); continue; }
    const { voxels, grid } = cropped(found.voxels, one => one === number, found.grid);
    stage.show(layer.name, { kind: "surface", ...mesh(voxels, number, grid, h), colour: hue(layer.colour), opacity: layer.opacity, isCut: true, shell: undefined });
  }
  document.body.dataset.volumes = answer.n;
}

/** Three circles around a ball, as pairs of places. */
function circles({ center_m, radius_m }) {
  const steps = 48, at = (n, [a, b]) => { const turn = 2 * Math.PI * n / steps; return center_m.map((x, axis) => x + radius_m * (axis === a ? Math.cos(turn) : axis === b ? Math.sin(turn) : 0)); };
  return [[0, 1], [1, 2], [0, 2]].flatMap(plane => Array.from({ length: steps }, (_, n) => [...at(n, plane), ...at(n + 1, plane)]).flat());
}

/** The outlines of regions and entries. */
function showRegions() {
  const { stage } = scene, { regions = [], entries = [] } = planner.state, isShown = layerOf("region").isOn;
  const boxes = [...regions.map(({ name, shape }, n) => ({ name, shape, colour: hue("approaches"), isChosen: n === planner.region })).filter(({ shape }) => shape).map(one => ({ ...one, low: cornersOf(one.shape)[0], high: cornersOf(one.shape)[1] })), ...entries.map(({ name, min_m, max_m }) => ({ name, low: min_m, high: max_m, colour: hue("series-3"), isEntry: true }))];
  stage.clear("region");
  boxes.forEach(({ low, high, shape: own, colour, isChosen, isEntry }, n) => stage.show(`region ${n}`, { kind: "lines", at: own?.center_m ? circles(own) : edges([low, high]), colour, opacity: isChosen || isEntry ? 0.9 : 0.35, width: isChosen ? 1.8 : 1.2, isShown }));
  stage.show("region names", { kind: "words", at: boxes.flatMap(({ low, high, isEntry }) => isEntry ? [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]] : [low[0], low[1], high[2]]), words: boxes.map(({ name, isEntry }) => isEntry ? `entry ${name}` : name), isShown });
}

/** Dots at the listed poses of the chosen sensor, or of the one to be placed. */
function showPoses() {
  const { stage } = scene, sensor = sensorOfDots(), own = sensor && !sensor.carried ? listed(sensor) : [], scores = scoresOfPoses(sensor);
  const groups = own.length ? posesByPlace(sensor, at => at.join()) : [];
  // Of several ways to look from a place the one that shows most.
  const best = poses => poses.reduce((a, b) => (scores.get(b.name) ?? -1) > (scores.get(a.name) ?? -1) ? b : a);
  const dots = groups.map(best), values = dots.map(pose => scores.get(pose.name) ?? null), known = values.filter(value => value !== null);
  const [low, high] = [Math.min(...known), Math.max(...known)], ramp = hues("ramp");
  const colours = values.map(value => value === null ? hue("mount") : ramp[Math.min(ramp.length - 1, Math.floor((value - low) / ((high - low) || 1) * ramp.length))]);
  stage.show("pose dots", { kind: "points", at: dots.flatMap(pose => pose.at_m), colours, width: 8, isShown: layerOf("pose").isOn && mayEdit(), words: n => wordsOfDot(sensor, groups[n], values[n]), heard: n => chooseListed(sensor, groups[n], stage.place(dots[n].at_m)) });
}

/** The place that was asked about, lines to it, and what was measured. */
function showWhy() {
  const { stage } = scene, { why, measured } = planner;
  const lines = why?.sensors?.filter(one => poseNow(one.index)) ?? [];
  stage.show("why lines", { kind: "lines", at: lines.flatMap(one => [...poseNow(one.index).position_m, ...why.at_m]), colours: lines.map(one => hue(one.sees ? "good" : "bad")), width: 2 });
  stage.show("why place", { kind: "points", at: why?.at_m ?? [], colour: hue("picked"), width: 12, ring: true, isOver: true });
  const ends = measured?.ends ?? [];
  stage.show("measure ends", { kind: "points", at: ends.flat(), colour: hue("accent"), width: 8, isOver: true });
  stage.show("measure line", { kind: "lines", at: ends.length > 1 ? ends.flat() : [], colour: hue("accent"), width: 2.4, isOver: true });
  stage.show("measure words", { kind: "words", at: ends.length > 1 ? times(plus(ends[0], ends[1]), 0.5) : [], words: ends.length > 1 ? [metres(lengthOf(minus(ends[1], ends[0])), 3)] : [], look: "measure" });
}

/** Switches the parts of a layer. */
function switchLayer(layer) {
  if (!scene.stage) return;
  if (layer.outcome) showVolumes();
  else [...scene.stage.parts.keys()].filter(name => name.startsWith(layer.name)).forEach(name => scene.stage.switch(name, layer.isOn));
}

/** Looks through a sensor's eyes, or back into the cell. */
function lookThrough(index) {
  const at = poseNow(index), sensor = placed()[index] && sensorOf(placed()[index]);
  if (!scene.stage || !at) return;
  const corners = sensor?.rays?.is_picture ? sensor.rays.directions : null;
  const reach = axis => corners ? Math.max(...corners.map(([x, y, z]) => Math.abs((axis ? z : y) / Math.max(0.05, x)))) : [1.2, 0.8][axis];
  planner.through = index;
  scene.stage.lookFrom({ at: plus(at.position_m, times(forwardOf(at), 0.06)), along: forwardOf(at), up: turnedBy(at, [0, 0, 1]), opening: [reach(0), reach(1)] });
  tell("through");
}
