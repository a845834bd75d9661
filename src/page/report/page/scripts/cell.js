// The cell in three dimensions: what is there, what the chosen pose makes of a region, where the sensors are and look; and
// their mounting sheets. Why voxels are unknown is in `causes.js`.
const LAYERS = [
  { name: "TP", word: "seen", what: "occupied, and called so", colour: hue("TP"), on: true },
  { name: "FN", word: "missed", what: "occupied, but called free", colour: hue("FN"), on: true },
  { name: "FP", word: "false", what: "free, but called occupied", colour: hue("FP"), on: true, opacity: 0.3 },
  { name: "TN", word: "free", what: "free, and called so", colour: hue("TN"), on: false, opacity: 0.2 },
  { name: "UO", word: "not seen", what: "occupied, and not known", colour: hue("UO"), on: true },
  { name: "UF", word: "blind", what: "free, and not known", colour: hue("UF"), on: true, opacity: 0.12 },
  { name: "environment", word: "the rest of the cell", what: "outside of the region", colour: hue("environment"), on: true, opacity: 0.08 },
  { name: "robot", word: "robot", what: "outside of the region", colour: hue("robot"), on: true, opacity: 0.6 },
  { name: "people", word: "people", what: "outside of the region", colour: hue("person"), on: true, opacity: 0.6 },
  { name: "sensors", word: "sensors", what: "where they are; names, walls", colour: hue("sensors"), on: true },
  { name: "approaches", word: "ways in", what: "how somebody comes nearest unnoticed", colour: hue("approaches"), on: true },
  { name: "views", word: "fields of view", what: "where sensors look, whatever stands in their way", colour: hue("sensors"), on: true },
];
// In the legend what matters comes first: what is blind, not seen, missed, false.
const LEGEND = ["UF", "UO", "FN", "FP", "TP", "TN", "robot", "people", "environment", "sensors", "approaches", "views"];
// What is seen, by whose it is: the environment, the robot, people.
const SEEN = ["TP", "robot", "person"].map(hue);
const VERDICTS = 6, REST = 3;
const KINDS_OF_TRUTH = 5;
const CALLED = 2;
const scenery = new Map();

/** The scene at a moment, its runs undone once. */
function cellAt(moment) {
  if (!scenery.has(moment)) {
    const found = data.cells.moments.find(one => one.moment === moment);
    const count = found.size.reduce((a, b) => a * b);
    const regions = found.regions.map(part => classes(part, 2, count));
    const anywhere = new Uint8Array(count);
    let members = 0;
    for (let i = 0; i < count; i++) if (regions.some(region => region[i])) { anywhere[i] = 1; members++; }
    scenery.set(moment, { ...found, count, truth: classes(found.truth, KINDS_OF_TRUTH, count), regions, anywhere, members });
  }
  return scenery.get(moment);
}

/** The moments at which the chosen scene can be shown: first those with labels of the chosen pose, its worst before others. */
function moments() {
  const { moments: [begin, end] } = sceneOf();
  const inside = all => all.map(one => one.moment).filter(moment => moment >= begin && moment < end);
  const labelled = inside(data.cells.labels.filter(one => one.series === chosen.series && one.choice === chosen.choice));
  return { labelled, all: [...new Set([...labelled, ...inside(data.cells.moments)])] };
}

/**
 * What the chosen pose makes of the chosen region: each voxel's layer plus one, and of the unknown ones their cause plus one;
 * null where the page does not hold it for this moment.
 */
function verdicts(cell) {
  const found = data.cells.labels.find(one => one.series === chosen.series && one.choice === chosen.choice && one.moment === cell.moment);
  if (!found) return null;
  const labels = classes(found.labels, CALLED + found.causes.length, cell.members), region = cell.regions[chosen.region];
  const layers = new Uint8Array(cell.count), causes = new Uint16Array(cell.count);
  // Called free, called occupied, unknown: for what is free, and for what is there.
  const names = [[4, 3, 6], [2, 1, 5]];
  for (let i = 0, n = 0; i < cell.count; i++) {
    if (!cell.anywhere[i]) continue;
    const label = labels[n++];
    if (!region[i]) continue;
    layers[i] = names[cell.truth[i] ? 1 : 0][Math.min(label, CALLED)];
    if (label >= CALLED) causes[i] = label - CALLED + 1;
  }
  return { layers, causes, names: found.causes };
}

/** The outside of a layer's voxels: what is seen in the colour of its role, unknown ones by their cause, as far as it is switched on. */
const shapeOf = (found, n, cell) => n === 0 ? shapeOfSeen(found, cell) : UNKNOWN.includes(n) ? shapeOfUnknown(found, n, cell) : outside(found.layers, n + 1, cell);

/** Adds triangles to others, in a colour; both know where their corners are. */
function join(whole, part, colour) {
  const first = whole.at.length / 3;
  for (const value of part.at) whole.at.push(value);
  for (const corner of part.faces) whole.faces.push(first + corner);
  for (let n = 0; n < part.at.length / 3; n++) whole.colours.push(colour);
}

function shapeOfSeen(found, cell) {
  const whole = nothing();
  const roles = found.layers.map((layer, i) => layer === 1 ? cell.truth[i] : 0);
  SEEN.forEach((colour, role) => join(whole, outside(roles, role + 1, cell), colour));
  return whole;
}

/** The outside of a class of the cell's voxels, as triangles. */
const outside = (voxels, wanted, cell) => mesh(voxels, wanted, cell, data.voxel_size_m);

/** No triangle at all. */
const nothing = () => ({ at: [], faces: [], colours: [] });

/** How far a ray goes until it leaves a box. */
function farthest(at, along, [low, high]) {
  const ends = along.map((d, axis) => d === 0 ? Infinity : ((d > 0 ? high[axis] : low[axis]) - at[axis]) / d);
  return Math.max(0, Math.min(...ends));
}

/** The names of furniture and robots, and the edges of the room. */
function showScenery(scene, isShown) {
  const { room_m: room, things } = sceneOf(), named = things.filter(one => one.role !== "human");
  scene.show("sensors: walls", { kind: "lines", at: edges(room), colour: hue("frame"), width: 1.5, isShown });
  const middle = ({ low_m: low, high_m: high }) => [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, high[2]];
  scene.show("sensors: names", { kind: "words", at: named.flatMap(middle), words: named.map(one => one.name), isShown });
}

/** Of what is recommended, the ways that somebody comes near without being noticed. */
function showApproaches(scene, { colour, on: isShown }) {
  const { series, choice } = data.recommended ?? {}, is = chosen.series === series && chosen.choice === choice;
  const own = is ? data.approaches.filter(one => data.scenes[one.scene] === sceneOf()) : [];
  const lines = own.flatMap(one => one.lines).flatMap(line => line.slice(1).flatMap((to, n) => [...line[n], ...to]));
  scene.show("approaches: ways", { kind: "lines", at: lines, colour, width: 3, isShown });
  scene.show("approaches: names", { kind: "words", at: own.flatMap(one => one.lines[0].at(-1)), words: own.map(one => one.words), isShown });
}

/** Places and axes of the chosen sensors, and, not to hide what is behind them, faint edges and rays of where they look. */
function showSensors(scene, cell, isShown, isViewShown) {
  const h = data.voxel_size_m, box = [times(cell.origin, h), cell.size.map((n, axis) => (cell.origin[axis] + n) * h)];
  const edge = [], ray = [], axes = [[], [], []], places = [], words = [];
  for (const [n, { sensor, pose }] of members(chosen.choice).entries()) {
    if (!pose.at_m) continue;
    const { at, turn } = inWorld(sensor, pose, cell.moment);
    places.push(...at);
    words.push(`${data.letters[n]} ${sensor.name}`);
    axes.forEach((own, n) => own.push(...at, ...plus(at, times(turn([0, 1, 2].map(axis => axis === n ? 1 : 0)), 0.3))));
    for (const ground of sensor.grounds) {
      const corners = ground.map(corner => plus(at, turn(corner)));
      corners.forEach((corner, n) => edge.push(...corner, ...corners[(n + 1) % corners.length]));
    }
    if (!sensor.rays) continue;
    const ends = sensor.rays.directions.map((direction, n) => {
      const along = turn(direction);
      return plus(at, times(along, Math.min(sensor.rays.reach_m[n], farthest(at, along, box))));
    });
    ends.forEach(end => (sensor.rays.is_picture ? edge : ray).push(...at, ...end));
    if (sensor.rays.is_picture) ends.forEach((end, n) => edge.push(...end, ...ends[(n + 1) % ends.length]));
  }
  scene.show("sensors: places", { kind: "points", at: places, colour: "ink", width: 6, isShown });
  scene.show("sensors: own names", { kind: "words", at: places, words, isShown });
  scene.show("views: edges", { kind: "lines", at: edge, colour: "ink", opacity: 0.45, width: 1.5, isShown: isViewShown });
  scene.show("views: rays", { kind: "lines", at: ray, colour: "ink", opacity: 0.12, width: 1, isShown: isViewShown });
  axes.forEach((at, n) => scene.show(`sensors: axis ${NAMES[n]}`, { kind: "lines", at, colour: hue(`axis-${NAMES[n]}`), width: 4, isShown }));
}

/** Shows the outside of a layer's voxels. */
const showLayer = (scene, n, { at, faces, colours }) => scene.show(LAYERS[n].name, { kind: "surface", at, faces, colours, colour: LAYERS[n].colour, opacity: LAYERS[n].opacity, isShown: LAYERS[n].on, isSolid: (LAYERS[n].opacity ?? 1) > 0.5 });

/** Draws the cell at the chosen moment; of another pose than before at one that it has labels for, if any. */
function drawCell(isAnotherPose) {
  drawSheet();
  const { labelled, all } = moments();
  const fallsBack = isAnotherPose && labelled.length && !labelled.includes(chosen.moment);
  if (fallsBack || !all.includes(chosen.moment)) chosen.moment = all[0];
  const cell = cellAt(chosen.moment), found = verdicts(cell);
  drawCauses(found);
  drawMoments(all, labelled);
  counts(found);
  noteOf(found, labelled);
  const home = element("view");
  home.stage ??= stage(home, "The cell in three dimensions.") ?? "none";
  element("picture").hidden = home.stage !== "none";
  home.hidden = home.stage === "none";
  if (home.hidden) return;
  const scene = home.stage;
  LAYERS.slice(0, VERDICTS).forEach((_, n) => showLayer(scene, n, found ? shapeOf(found, n, cell) : nothing()));
  // What has a verdict is shown by that.
  const rest = found ? cell.truth.map((what, i) => cell.regions[chosen.region][i] ? 0 : what) : cell.truth;
  LAYERS.slice(VERDICTS, VERDICTS + REST).forEach((_, n) => showLayer(scene, VERDICTS + n, { ...outside(rest, n + 1, cell), colours: undefined }));
  const [sensors, approaches, views] = LAYERS.slice(VERDICTS + REST);
  showApproaches(scene, approaches);
  showScenery(scene, sensors.on);
  showSensors(scene, cell, sensors.on, views.on);
  if (home.faces !== sceneOf().room_m) scene.face(sceneOf().room_m);
  home.faces = sceneOf().room_m;
  // Corners are darkened when the rest is in view.
  setTimeout(() => {
    cell.crowding ??= crowding(cell.truth.map(what => what > 0 && what < KINDS_OF_TRUTH - 1 ? 1 : 0), cell.size);
    if (cell.moment === chosen.moment) scene.darken(cell, data.voxel_size_m, cell.crowding);
  });
}

/** How many voxels of each verdict there are, beside the switches. */
function counts(found) {
  const all = new Array(VERDICTS + 1).fill(0);
  found?.layers.forEach(verdict => all[verdict]++);
  LAYERS.slice(0, VERDICTS).forEach((layer, n) => {
    element(`count-${layer.name}`).textContent = found ? all[n + 1] : "";
    element(`layer-${layer.name}`).disabled = !found;
  });
}

function noteOf(found, labelled) {
  const of = combination(), scene = sceneOf();
  const text = `${fullName(chosen.choice)} in scene ${scene.name}`;
  const note = element("cell-note");
  const repeat = data.repeats > 1 ? ", in the first of the repeats" : "";
  if (found) return note.replaceChildren(`${text}: what it makes of region ${data.regions[chosen.region]}, in voxels${repeat}.`);
  const quoted = word => /^[\w./:+-]+$/.test(word) ? word : `'${word.replace(/'/g, `'\\''`)}'`;
  const words = [...data.render, "--pose", fullName(chosen.choice), "--combination", of.name, "--representation", of.representations[series().representation], "--scene", scene.name, "--snapshot", String(chosen.moment - scene.moments[0]), "--out", "pose.png"];
  const why = labelled.length ? "at this snapshot (only at its worst and the scene's first)" : "as it is not among those looked at";
  note.replaceChildren(`${text}: its voxels are not in this page, ${why}. This draws them: `, made("code", {}, words.map(quoted).join(" ")));
}

/** The moments to choose from, where there are several. */
function drawMoments(all, labelled) {
  const home = element("moment"), [begin] = sceneOf().moments;
  const slider = element("moment-slider"), inOrder = [...all].sort((a, b) => a - b);
  home.parentElement.hidden = slider.parentElement.hidden = all.length < 2;
  Object.assign(slider, { max: inOrder.length - 1, value: inOrder.indexOf(chosen.moment) });
  slider.setAttribute("aria-valuetext", `snapshot ${chosen.moment - begin}`);
  home.replaceChildren(...inOrder.map(moment => {
    const option = made("option", { value: moment }, `${moment - begin}${labelled.includes(moment) ? "" : " (no labels)"}`);
    option.selected = moment === chosen.moment;
    return option;
  }));
}

/** What a mounting sheet tells of a sensor that stands somewhere. */
function linesOf(sensor, pose, metres) {
  const next = found => found ? `${metres(found[0])} to ${data.objects[found[1]]}` : "nothing";
  const places = sensor.on ? [["mounted on", frameOf(sensor)]] : pose.around.map((found, n) => [data.ways[n], next(found)]);
  const [pan, tilt, roll] = pose.turned_deg.map(degrees => `${degrees.toFixed(1)}°`), height = `${Math.abs(pose.turned_deg[1]).toFixed(1)}°`;
  const turns = [["pan", pan], ["tilt", height === "0.0°" ? `${height}, level` : `${height} ${tilt.startsWith("-") ? "down" : "up"}`], ["roll", roll]].slice(0, sensor.level ? 1 : 3);
  const position = NAMES.map((name, axis) => `${name} ${metres(pose.at_m[axis])}`).join(", ");
  return [[sensor.level ? "corner" : "position", position], ...places, ...turns];
}

/** A mounting sheet for each chosen sensor that stands somewhere. */
function drawSheet() {
  const sheets = members(chosen.choice).map((one, n) => ({ ...one, letter: data.letters[n] })).filter(({ pose }) => pose.at_m || pose.senses_m).map(({ sensor, pose, letter }) => {
    const metres = value => `${value.toFixed(3)} m`;
    const lines = pose.at_m ? linesOf(sensor, pose, metres) : [["senses up to", metres(pose.senses_m)]];
    return made("table", { class: "sheet" }, made("caption", {}, `Mounting sheet ${letter}: ${sensor.name}, ${pose.name}`), ...lines.map(([name, value]) => made("tr", {}, made("th", { scope: "row" }, name), made("td", {}, value))));
  });
  element("sheet").replaceChildren(...sheets);
}

/** The switches of the layers. */
function makeLayers() {
  const home = element("layers");
  const shown = LEGEND.filter(name => name !== "approaches" || data.approaches.length);
  shown.map(name => LAYERS.findIndex(layer => layer.name === name)).forEach(n => {
    const layer = LAYERS[n];
    const box = made("input", { type: "checkbox", id: `layer-${layer.name}` });
    box.checked = layer.on;
    box.addEventListener("change", () => {
      layer.on = box.checked;
      const scene = element("view").stage;
      if (scene !== "none") [...scene.parts.keys()].filter(name => name.split(":")[0] === layer.name).forEach(name => scene.switch(name, layer.on));
    });
    const colour = made("i", {});
    colour.style.background = layer.colour;
    home.append(made("label", { class: "layer" }, box, colour, made("strong", {}, layer.word), made("span", { class: "note" }, n < VERDICTS ? `${layer.what} (${layer.name})` : layer.what), made("span", { id: `count-${layer.name}`, class: "note" })));
  });
  const moment = made("select", { id: "moment" });
  moment.addEventListener("change", () => { chosen.moment = Number(moment.value); draw({ moment: 0 }); });
  const slider = made("input", { type: "range", id: "moment-slider", min: 0, value: 0, step: 1 });
  slider.addEventListener("input", () => {
    const options = [...moment.options];
    chosen.moment = Number(options[slider.value].value);
    draw({ moment: 0 });
  });
  home.append(made("label", {}, "Snapshot ", moment), made("label", {}, "Through time ", slider));
}
