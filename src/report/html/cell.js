// The cell in three dimensions: what is there, what the chosen pose makes of a region, where the sensors are and look; and
// their mounting sheets. Why voxels are unknown is in `causes.js`.
// Blind space has the colour of the hatch in floor plans, people and the robot those of their roles.
const LAYERS = [
  { name: "TP", word: "seen", what: "occupied, and called so", colour: "#9db4c8", on: true },
  { name: "FN", word: "missed", what: "occupied, but called free", colour: "#7b2d8b", on: true },
  { name: "FP", word: "false", what: "free, but called occupied", colour: "#d81b60", on: true },
  { name: "TN", word: "free", what: "free, and called so", colour: "#56b4e9", on: false, opacity: 0.2 },
  { name: "UO", word: "not seen", what: "occupied, and not known", colour: "#8c1d0f", on: true },
  { name: "UF", word: "blind", what: "free, and not known", colour: "#d9745f", on: true, opacity: 0.12 },
  { name: "environment", word: "the rest of the cell", what: "outside of the region", colour: "#b8c0c8", on: true, opacity: 0.12 },
  { name: "robot", word: "robot", what: "outside of the region", colour: "#0072b2", on: true, opacity: 0.6 },
  { name: "people", word: "people", what: "outside of the region", colour: "#e69f00", on: true, opacity: 0.6 },
  { name: "sensors", word: "sensors", what: "where they are and look; names, walls", colour: "#000000", on: true },
];
// In the legend what matters comes first: what is blind, not seen, missed, false.
const LEGEND = ["UF", "UO", "FN", "FP", "TP", "TN", "robot", "people", "environment", "sensors"];
// What is seen, by whose it is: the environment, the robot, people.
const SEEN = ["#9db4c8", "#0072b2", "#e69f00"];
const VERDICTS = 6;
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
  const { moments: [begin, end] } = data.scenes[Math.max(0, chosen.extent - 1)];
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
const shapeOf = (found, n, cell) => n === 0 ? shapeOfSeen(found, cell) : UNKNOWN.includes(n) ? shapeOfUnknown(found, n, cell) : mesh(found.layers, n + 1, cell);

/** Adds triangles to others, in a colour; both know where their corners are. */
function join(whole, part, colour) {
  const first = whole.x.length;
  for (const axis of ["x", "y", "z"]) for (const value of part[axis]) whole[axis].push(value);
  for (const corner of ["i", "j", "k"]) for (const value of part[corner]) whole[corner].push(first + value);
  for (let n = 0; n < part.i.length; n++) whole.facecolor.push(colour);
}

function shapeOfSeen(found, cell) {
  const whole = { ...speck(cell), facecolor: [SEEN[0]] };
  const roles = found.layers.map((layer, i) => layer === 1 ? cell.truth[i] : 0);
  SEEN.forEach((colour, role) => join(whole, mesh(roles, role + 1, cell), colour));
  return whole;
}

/** The outside of the voxels of a class, as triangles; faces beside each other are one. */
function mesh(voxels, wanted, { size, origin }) {
  const h = data.voxel_size_m, step = [1, size[0], size[0] * size[1]];
  const x = [], y = [], z = [], i = [], j = [], k = [];
  const corner = at => { x.push((at[0] + origin[0]) * h); y.push((at[1] + origin[1]) * h); z.push((at[2] + origin[2]) * h); };
  for (let axis = 0; axis < 3; axis++) for (const side of [0, 1]) {
    const along = axis === 0 ? 1 : 0, across = 3 - axis - along, to = side ? step[axis] : -step[axis];
    const at = [0, 0, 0];
    for (at[axis] = 0; at[axis] < size[axis]; at[axis]++) {
      const edge = side ? at[axis] === size[axis] - 1 : at[axis] === 0;
      for (at[across] = 0; at[across] < size[across]; at[across]++) {
        let begin = -1;
        const row = at[axis] * step[axis] + at[across] * step[across];
        for (let n = 0; n <= size[along]; n++) {
          const here = row + n * step[along];
          const face = n < size[along] && voxels[here] === wanted && (edge || voxels[here + to] !== wanted);
          if (face && begin < 0) begin = n;
          if (face || begin < 0) continue;
          const first = x.length, low = [...at];
          low[axis] += side;
          for (const [a, b] of [[begin, 0], [n, 0], [n, 1], [begin, 1]]) {
            const point = [...low];
            point[along] = a;
            point[across] += b;
            corner(point);
          }
          i.push(first, first); j.push(first + 1, first + 2); k.push(first + 2, first + 3);
          begin = -1;
        }
      }
    }
  }
  return x.length ? { x, y, z, i, j, k } : speck({ origin });
}

/** While a view changes it does not heed the mouse: until it is drawn, plotly.js looks for what was there before, and fails. */
let changes = 0;
async function deaf(plot, change) {
  changes++;
  plot.style.pointerEvents = "none";
  await change();
  setTimeout(() => { if (--changes === 0) plot.style.pointerEvents = ""; }, 500);
}

/** A triangle that nobody sees, for a layer that is empty. */
const speck = ({ origin }) => {
  const [x, y, z] = times(origin, data.voxel_size_m).map(value => [value, value, value]);
  return { x, y, z, i: [0], j: [1], k: [2] };
};

const surface = (layer, shape) => ({ type: "mesh3d", ...shape, name: layer.name, color: layer.colour, opacity: layer.opacity ?? 1, flatshading: true, hoverinfo: "name", visible: layer.on, lighting: { ambient: 0.72, diffuse: 0.45, specular: 0.05 }, lightposition: { x: 4000, y: -6000, z: 9000 } });

/** How far a ray goes until it leaves a box. */
function farthest(at, along, [low, high]) {
  const ends = along.map((d, axis) => d === 0 ? Infinity : ((d > 0 ? high[axis] : low[axis]) - at[axis]) / d);
  return Math.max(0, Math.min(...ends));
}

/** The names of furniture and robots, and the edges of the room. */
function sceneryTraces() {
  const on = LAYERS.at(-1).on, { room_m: [low, high], names } = data.scenes[Math.max(0, chosen.extent - 1)];
  const corner = n => [0, 1, 2].map(axis => n >> axis & 1 ? high[axis] : low[axis]), walls = [];
  for (let n = 0; n < 8; n++) for (let axis = 0; axis < 3; axis++) if (!(n >> axis & 1)) walls.push(corner(n), corner(n | 1 << axis), [null, null, null]);
  const [x, y, z] = [0, 1, 2].map(axis => names.map(one => one.at_m[axis]));
  return [
    lines3d(walls, { line: { width: 2, color: "#7c8894" }, visible: on }),
    { type: "scatter3d", mode: "text", x, y, z, text: names.map(one => plain(one.name)), textposition: "top center", textfont: { size: 13, color: "#3f4a57" }, hoverinfo: "skip", visible: on },
  ];
}

/** Places, axes and frustums of the chosen sensors. */
function sensorTraces(cell) {
  const h = data.voxel_size_m, box = [times(cell.origin, h), cell.size.map((n, axis) => (cell.origin[axis] + n) * h)];
  const traces = [], on = LAYERS.at(-1).on;
  for (const { sensor, pose } of members(chosen.choice)) {
    if (!pose.at_m) continue;
    const { at, turn } = inWorld(sensor, pose, cell.moment);
    traces.push({ type: "scatter3d", mode: "markers+text", x: [at[0]], y: [at[1]], z: [at[2]], text: [plain(sensor.name)], textposition: "top center", hoverinfo: "text", marker: { size: 6, color: "#000", symbol: "diamond" }, visible: on });
    [[1, 0, 0], [0, 1, 0], [0, 0, 1]].forEach((axis, n) => traces.push(lines3d([at, plus(at, times(turn(axis), 0.3))], { line: { width: 6, color: ["#d55e00", "#009e73", "#0072b2"][n] }, visible: on })));
    for (const ground of sensor.grounds) {
      const corners = [...ground, ground[0]].map(corner => plus(at, turn(corner)));
      traces.push(lines3d(corners, { line: { width: 5, color: "#222" }, visible: on }));
    }
    if (!sensor.rays) continue;
    const ends = sensor.rays.directions.map(direction => {
      const along = turn(direction);
      return plus(at, times(along, Math.min(sensor.rays.range_m[1], farthest(at, along, box))));
    });
    const rays = ends.flatMap(end => [at, end, [null, null, null]]);
    const rim = sensor.rays.is_picture ? [...ends, ends[0]] : [];
    traces.push(lines3d([...rays, ...rim], { line: { width: sensor.rays.is_picture ? 4 : 1.5, color: "#222" }, visible: on }));
  }
  return traces;
}

/** Draws the cell at the chosen moment; of another pose than before at one that it has labels for, if any. */
async function drawCell(isAnotherPose) {
  drawSheet();
  const { labelled, all } = moments();
  const fallsBack = isAnotherPose && labelled.length && !labelled.includes(chosen.moment);
  if (fallsBack || !all.includes(chosen.moment)) chosen.moment = all[0];
  const cell = cellAt(chosen.moment), found = verdicts(cell);
  drawCauses(found);
  const traces = LAYERS.slice(0, VERDICTS).map((layer, n) => surface(layer, found ? shapeOf(found, n, cell) : speck(cell)));
  // What has a verdict is shown by that.
  const rest = found ? cell.truth.map((what, i) => cell.regions[chosen.region][i] ? 0 : what) : cell.truth;
  LAYERS.slice(VERDICTS, -1).forEach((layer, n) => traces.push(surface(layer, mesh(rest, n + 1, cell))));
  traces.push(...sceneryTraces(), ...sensorTraces(cell));
  const view = element("view");
  drawMoments(all, labelled);
  counts(found);
  noteOf(found, labelled);
  element("picture").hidden = hasWebGL;
  view.hidden = !hasWebGL;
  if (!hasWebGL) return;
  const layout = { ...LAYOUT, margin: { l: 0, r: 0, t: 0, b: 0 }, showlegend: false, scene: { ...SCENE, uirevision: 1 } };
  await deaf(view, () => Plotly.react(view, traces, layout, CONFIG));
}

/** Without WebGL the picture that the program has drawn stands in the place of the 3D view. */
const hasWebGL = Boolean(document.createElement("canvas").getContext("webgl"));

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
  const of = combination(), scene = data.scenes[Math.max(0, chosen.extent - 1)];
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
  const home = element("moment"), [begin] = data.scenes[Math.max(0, chosen.extent - 1)].moments;
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
  const turns = ["pan, from x to y", "tilt, up", "roll"].slice(0, sensor.level ? 1 : 3).map((name, n) => [name, `${pose.turned_deg[n].toFixed(1)}°`]);
  const position = NAMES.map((name, axis) => `${name} ${metres(pose.at_m[axis])}`).join(", ");
  return [[sensor.level ? "corner" : "position", position], ...places, ...turns];
}

/** A mounting sheet for each chosen sensor that stands somewhere. */
function drawSheet() {
  const sheets = members(chosen.choice).filter(({ pose }) => pose.at_m || pose.senses_m).map(({ sensor, pose }) => {
    const metres = value => `${value.toFixed(3)} m`;
    const lines = pose.at_m ? linesOf(sensor, pose, metres) : [["senses up to", metres(pose.senses_m)]];
    return made("table", { class: "sheet" }, made("caption", {}, `Mounting sheet: ${sensor.name}, ${pose.name}`), ...lines.map(([name, value]) => made("tr", {}, made("th", { scope: "row" }, name), made("td", {}, value))));
  });
  element("sheet").replaceChildren(...sheets);
}

/** The switches of the layers. */
function makeLayers() {
  const home = element("layers");
  LEGEND.map(name => LAYERS.findIndex(layer => layer.name === name)).forEach(n => {
    const layer = LAYERS[n];
    const box = made("input", { type: "checkbox", id: `layer-${layer.name}` });
    box.checked = layer.on;
    box.addEventListener("change", () => {
      layer.on = box.checked;
      const traces = n < LAYERS.length - 1 ? [n] : element("view").data.map((_, i) => i).slice(LAYERS.length - 1);
      deaf(element("view"), () => Plotly.restyle(element("view"), { visible: layer.on }, traces));
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
