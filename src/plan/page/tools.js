// Tools: adding from the catalogue, listed poses, copies; why a place is seen or not; measuring; the cut plane.

/** Takes a tool; the one that is taken again is put away. */
function takeTool(name) {
  const isSame = planner.tool === name;
  disarm();
  planner.tool = isSame && name !== "move" ? "move" : name;
  if (planner.tool !== "why") planner.why = null;
  if (planner.tool !== "measure") planner.measured = null;
  ["why", "measure", "tool"].forEach(tell);
}

/** Holds a model or one of the study's sensors, to be placed by a click. */
function arm(what) {
  disarm();
  const own = what.sensor && planner.state.sensors.find(one => one.name === what.sensor);
  // It has one place: that of its own keys.
  if (own?.is_fixed) { element("catalogue").hidden = true; edit({ edit: "place", sensor: own.name, pose: own.poses[0].name }); return; }
  planner.armed = what;
  element("catalogue").hidden = true;
  notify(`Click a surface to place ${what.sensor ?? what.model}, or move it with the arrow keys and press Enter. Esc puts it away.`);
  ["armed", "tool"].forEach(tell);
  // The keyboard goes on where the pointer would: in the middle of the view.
  if (planner.tab === "plan") { element("plan").focus(); ghostOnPlan([0, 1].map(axis => (roomBox()[0][axis] + roomBox()[1][axis]) / 2)); return; }
  const { canvas } = scene.stage;
  canvas.focus();
  ghost(scene.stage.hit(canvas.clientWidth / 2, canvas.clientHeight / 2, isMount));
}
/** Asks before a device of unknown noise is held beside sensors whose noise is known. */
function armMixed(what) {
  const device = what.model && planner.state.catalogue.find(one => one.model === what.model);
  if (!device?.mixes_noise) { arm(what); return; }
  openDialog(`Add ${device.model}?`, [
    made("p", {}, "The noise of some sensors is known and that of others is not. A sensor of unknown noise is counted as if it had none, so it looks better than it is beside the others."),
    made("p", { class: "soft" }, "The study gets mixed_noise = true. To compare them fairly, write the noise of the device into the study as text instead.")],
    [["Add it all the same", () => { closeDialog(); arm({ ...what, mixesNoise: true }); }, true, "mix-noise"]]);
}

function disarm() {
  if (!planner.armed) return;
  planner.armed = null;
  if (planner.draft?.index === null) dropDraft();
  ["armed", "tool"].forEach(tell);
}

/** Shows where the held sensor would be. */
function ghost(hit) {
  if (!hit || !mayEdit()) return;
  planner.draft = { index: null, add: { ...planner.armed }, at: written(firstPose(hit)), snapped: null };
  tell("draft");
  wantScore("coarse");
}

/** Hides the held sensor where a click would take a listed pose. */
function hideGhost() { if (planner.draft?.index === null) dropDraft(); }

/** What one of a device of the catalogue costs, as it was typed; a study with prices needs it. */
function costOfModel() {
  const typed = element("model-cost").value;
  return typed === "" ? {} : { cost: Number(typed) };
}
const needsCost = () => (planner.state?.sensors ?? []).length > 0 && planner.state.sensors.every(one => one.cost !== null && one.cost !== undefined);

/** Places the held sensor where it is shown. */
async function placeGhost() {
  const { armed, draft } = planner;
  if (!armed || draft?.index !== null || !draft) return;
  const { sensor, model, mixesNoise } = armed, gesture = nextGesture();
  planner.armed = null;
  draft.isSettling = true;
  if (mixesNoise) edit({ edit: "mix_noise" }, gesture);
  const isDone = await edit({ edit: "add", ...(sensor ? { sensor } : { model, ...costOfModel() }), at: written(draft.at) }, gesture);
  if (!isDone) dropDraft(draft);
  ["armed", "tool"].forEach(tell);
}

/** Places a sensor at a listed pose. */
async function placeListed(sensor, pose) {
  disarm();
  await edit({ edit: "place", sensor: sensor.name, pose: pose.name });
}

/** Copies a sensor beside itself. */
async function copySensor(index = planner.selected) {
  flushDraft();
  const at = poseNow(index);
  if (!at || !mayEdit()) return;
  const level = Math.hypot(...forwardOf(at).slice(0, 2)) > 0.1, side = level ? unitOf([-forwardOf(at)[1], forwardOf(at)[0], 0]) : [0, 1, 0];
  const [low, high] = roomBox(), there = [0.4, -0.4].map(way => plus(at.position_m, times(side, way)));
  const position_m = there.find(place => place.every((x, axis) => x >= low[axis] && x <= high[axis])) ?? there[0];
  await edit({ edit: "copy", index, at: written({ ...at, position_m }) });
}
function removeSensor(index = planner.selected) {
  flushDraft();
  if (placed()[index]) edit({ edit: "remove", index });
}

/** Asks which sensors see a place. */
async function askWhy(at_m) {
  const n = ++scores.n;
  planner.why = { n, at_m: at_m.map(x => rounded(x, 3)), sensors: null };
  tell("why");
  try {
    const answer = await ask("/why", { n, moment: planner.moment, at_m: planner.why.at_m });
    if (planner.why?.n === n) { Object.assign(planner.why, answer); tell("why"); }
  } catch (error) { complain(error); }
}

const WHY_AXES = ["x", "y", "z"];

/** The fields of a place, so that the keyboard asks, too, and at any height. */
function makeWhy() {
  const fields = WHY_AXES.map(name => made("label", {}, made("span", {}, name), made("input", { id: `why-${name}`, type: "number", step: "any", inputmode: "decimal", "aria-label": `${name} in metres` }), made("i", {}, "m")));
  element("why-form").append(...fields, made("button", { type: "submit" }, "Ask"));
  element("why-form").addEventListener("submit", event => {
    event.preventDefault();
    const typed = WHY_AXES.map(name => element(`why-${name}`).value);
    if (typed.every(text => text !== "" && Number.isFinite(Number(text)))) askWhy(typed.map(Number)); else notify("Write x, y and z of the place in metres.");
  });
}

function showWhyWords() {
  const home = element("why"), { why } = planner;
  home.hidden = planner.tool !== "why";
  if (home.hidden) return;
  if (why) WHY_AXES.forEach((name, axis) => { const input = element(`why-${name}`); if (document.activeElement !== input) input.value = why.at_m[axis]; });
  const rows = (why?.sensors ?? []).map(one => made("li", { class: one.sees ? "sees" : "blind" }, made("b", { class: "letter" }, letterAt(one.index)), made("span", {}, one.index === planner.dead ? "is switched off" : one.words || (one.sees ? "sees it" : "does not see it"))));
  const lines = why ? (why.object ? [made("p", {}, `In ${why.object}`)] : []) : [made("p", {}, "Click a place, or type one: which sensors see it, and what stops the others.")];
  if (why && !why.sensors) lines.push(made("p", { class: "soft" }, "Asking…"));
  if (why?.sensors && !why.sensors.length) lines.push(made("p", { class: "soft" }, "No sensor is placed yet."));
  element("why-words").replaceChildren(...lines, made("ul", {}, ...rows));
}

/** Takes an end of what is measured; a third click begins again. */
function measure(at) {
  const ends = planner.measured?.ends ?? [];
  planner.measured = { ends: ends.length === 1 ? [ends[0], at] : [at] };
  tell("measure");
}
function showMeasured() {
  const home = element("measured"), ends = planner.measured?.ends ?? [];
  home.hidden = planner.tool !== "measure";
  if (home.hidden) return;
  const [a, b] = ends, off = b ? minus(b, a) : null;
  const lines = off ? [made("p", { id: "distance", class: "large" }, metres(lengthOf(off), 3)), made("p", { class: "soft" }, `level ${metres(Math.hypot(off[0], off[1]), 3)}, up ${metres(off[2], 3)}; Δx ${off[0].toFixed(3)}, Δy ${off[1].toFixed(3)}`)] : [made("p", {}, a ? "Click the other end." : "Click two places.")];
  element("measured-words").replaceChildren(...lines);
}

/** The models that can be added, and the study's own sensors. */
function showCatalogue() {
  const { sensors = [], catalogue = [] } = planner.state, wanted = element("catalogue-filter").value.toLowerCase();
  const row = (name, words, cost, what) => {
    const button = made("button", { type: "button", class: "model" }, made("strong", {}, name), made("span", {}, words), made("em", {}, cost === null || cost === undefined ? "" : money(cost)));
    button.addEventListener("click", () => {
      if (!mayEdit()) return;
      if (what.model && (cost === null || cost === undefined) && needsCost() && element("model-cost").value === "") {
        element("model-cost").focus();
        notify("Every sensor of this study has a cost: write first what one of the catalogue's devices costs.", "bad");
        return;
      }
      armMixed(what);
    });
    return button;
  };
  const isWanted = (...texts) => !wanted || texts.join(" ").toLowerCase().includes(wanted);
  const own = sensors.filter(one => one.rays || one.grounds?.length || listed(one).length).filter(one => isWanted(one.name, one.model ?? "", one.kind, kindInWords(one.kind)));
  const models = catalogue.filter(one => isWanted(one.model, one.kind, kindInWords(one.kind), one.words));
  element("models").replaceChildren(
    ...(own.length ? [made("h3", {}, "Sensors of this study")] : []), ...own.map(one => row(one.name, [kindInWords(one.kind), one.model].filter(x => x).join(", "), one.cost, { sensor: one.name })),
    ...(models.length ? [made("h3", {}, "Catalogue")] : []), ...models.map(one => row(one.model, [kindInWords(one.kind), one.words].filter(x => x).join(", "), one.cost, { model: one.model })),
    ...(own.length + models.length ? [] : [made("p", { class: "soft" }, "No sensor has this in its name or kind.")]));
}

/** Cuts the cell open at a height, or does not. */
function cutAt() {
  const is = element("cut-on").checked, axis = Number(element("cut-axis").value), [low, high] = roomBox(), slider = element("cut-place");
  const at = low[axis] + slider.value / 1000 * (high[axis] - low[axis]);
  element("cut-words").textContent = is ? `${NAMES[axis]} < ${at.toFixed(2)} m` : "whole cell";
  slider.disabled = !is;
  scene.stage?.cut(is ? [0, 1, 2].map(n => n === axis ? 1 : 0) : null, at);
}

function makeTools() {
  makeWhy();
  document.querySelectorAll("[data-closes-tool]").forEach(button => button.addEventListener("click", () => { const { tool } = planner; takeTool(tool); document.querySelector(`#tools [data-tool=${tool}]`).focus(); }));
  document.querySelectorAll("#tools [data-tool]").forEach(button => button.addEventListener("click", () => takeTool(button.dataset.tool)));
  element("add").addEventListener("click", openCatalogue);
  element("catalogue-close").addEventListener("click", openCatalogue);
  element("catalogue-filter").addEventListener("input", showCatalogue);
  element("whole").addEventListener("click", () => scene.stage?.focus(roomBox(), { pan: -1.05, tilt: 0.55 }));
  element("top-view").addEventListener("click", () => scene.stage?.focus(roomBox(), { pan: -Math.PI / 2, tilt: 1.55 }));
  for (const id of ["cut-on", "cut-axis", "cut-place"]) element(id).addEventListener("input", cutAt);
  element("add").setAttribute("aria-expanded", "false");
  on("state", showCatalogue);
  on("why tool", showWhyWords);
  on("measure tool", showMeasured);
  on("tool connection", () => document.querySelectorAll("#tools [data-tool]").forEach(button => button.setAttribute("aria-pressed", String(!planner.armed && planner.tool === button.dataset.tool))));
}
function openCatalogue() {
  const home = element("catalogue");
  home.hidden = !home.hidden;
  element("add").setAttribute("aria-expanded", String(!home.hidden));
  element(home.hidden ? "add" : "catalogue-filter").focus();
}
