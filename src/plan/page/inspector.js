// The list of sensors, the chosen one in numbers and words, and the counts of the moment.
const FIELDS = [["x", "x", "m", 0.05], ["y", "y", "m", 0.05], ["z", "z", "m", 0.05], ["pan", "Pan", "°", 5], ["tilt", "Tilt", "°", 5], ["roll", "Roll", "°", 5]];

let shownProblems = "";
const problemsNow = () => JSON.stringify(placed().map((_, index) => problemOf(index)));

/** The placed sensors, each to be chosen with the keyboard, too. */
function showList() {
  const home = element("sensors"), had = home.contains(document.activeElement);
  shownProblems = problemsNow();
  home.replaceChildren(...placed().map((one, index) => {
    const isDead = planner.dead === index, problem = problemOf(index);
    const item = made("li", { role: "option", id: `sensor-${index}`, tabindex: index === Math.max(0, planner.selected) ? "0" : "-1", "aria-selected": String(index === planner.selected), class: `${problem ? "bad" : ""}${isDead ? " dead" : ""}` },
      made("b", { class: "letter" }, letterAt(index)), made("span", {}, made("strong", {}, one.sensor), made("small", {}, isDead ? "switched off" : problem ?? one.place ?? one.pose ?? "")), made("em", {}, one.cost === null || one.cost === undefined ? "" : money(one.cost)));
    item.addEventListener("click", () => { select(index); focusChosen(); });
    item.addEventListener("focus", () => select(index));
    item.addEventListener("dblclick", () => { const at = poseNow(index); if (at) scene.stage?.focus(at.position_m); });
    return item;
  }));
  element("no-sensors").hidden = placed().length > 0;
  element("sensor-count").textContent = placed().length || "";
  if (had) focusChosen();
}
const focusChosen = () => document.getElementById(`sensor-${planner.selected}`)?.focus({ preventScroll: false });

/** Marks the chosen one without making the list anew, which would lose a double click. */
function markList() {
  [...element("sensors").children].forEach((item, index) => { item.setAttribute("aria-selected", String(index === planner.selected)); item.tabIndex = index === Math.max(0, planner.selected) ? 0 : -1; });
}

function makeInspector() {
  element("pose").replaceChildren(...FIELDS.map(([name, title, unit, step], n) => {
    const input = made("input", { id: `pose-${name}`, type: "number", step: "any", inputmode: "decimal", "aria-label": `${title} in ${unit === "m" ? "metres" : "degrees"}` });
    input.addEventListener("change", () => typePose(n, input));
    input.addEventListener("keydown", event => {
      if (event.key === "Enter") typePose(n, input);
      const way = { ArrowUp: 1, ArrowDown: -1 }[event.key];
      if (!way) return;
      event.preventDefault();
      nudge(at => withField(at, n, fieldOf(at, n) + way * (event.shiftKey ? step / 5 : step)));
    });
    return made("label", {}, made("span", {}, title), input, made("i", {}, unit));
  }));
  element("model").addEventListener("change", async event => {
    const { value, selectedOptions: [chosen] } = event.target;
    // A model that is refused leaves the one that is there in the box.
    if (!await edit({ edit: "set_sensor", index: planner.selected, ...(chosen.dataset.model ? { model: value } : { sensor: value }) })) showChosen();
  });
  element("cost").addEventListener("change", event => { const cost = Number(event.target.value); if (event.target.value !== "" && cost >= 0) edit({ edit: "set_cost", sensor: placed()[planner.selected].sensor, cost }); else showChosen(); });
  element("copy").addEventListener("click", () => copySensor());
  element("remove").addEventListener("click", () => removeSensor());
  element("through").addEventListener("click", () => { if (planner.through === planner.selected && planner.through !== null) scene.stage.focus(roomBox()); else lookThrough(planner.selected); });
  element("dead").addEventListener("change", event => { planner.dead = event.target.checked ? planner.selected : null; tell("dead"); wantScore("fine"); });
  element("region").addEventListener("change", event => { planner.region = Number(event.target.value); tell("region"); });
  on("state dead", showList);
  // A list that is made anew forgets a double click: only where something else is wrong than before.
  on("answer", () => { if (!planner.draft && problemsNow() !== shownProblems) showList(); });
  on("selected", markList);
  on("state selected draft answer dead connection through object", showChosen);
  on("answer region state carry", showCounts);
  on("state region", fillRegions);
  on("answer selected", showEyeSoon);
}

const fieldOf = (at, n) => n < 3 ? at.position_m[n] : at[["pan_deg", "tilt_deg", "roll_deg"][n - 3]];
const withField = (at, n, value) => n < 3 ? { ...at, position_m: at.position_m.with(n, value) } : { ...at, [["pan_deg", "tilt_deg", "roll_deg"][n - 3]]: value };

/** Takes a number that was typed. */
function typePose(n, input) {
  const at = poseNow(planner.selected), value = Number(input.value.replace(",", "."));
  if (!at || input.value.trim() === "" || !Number.isFinite(value)) { showChosen(); return; }
  if (Math.abs(fieldOf(at, n) - value) < 1e-9) return;
  const draft = beginDraft(planner.selected);
  if (!draft) return;
  changeDraft(withField(draft.at, n, value));
  commitDraft();
}

/** The chosen sensor. */
function showChosen() {
  const one = placed()[planner.selected], home = element("chosen"), at = poseNow(planner.selected);
  home.hidden = !one || planner.object !== null && !!objectNamed(planner.object);
  if (!one) return;
  const sensor = sensorOf(one), isFree = !!at && !sensor?.carried && mayEdit(), problem = problemOf(planner.selected);
  element("chosen-letter").textContent = letterAt(planner.selected);
  element("chosen-name").textContent = one.sensor;
  const snapped = planner.draft?.index === planner.selected ? planner.draft.snapped : one.pose;
  element("chosen-place").textContent = [planner.draft?.index === planner.selected ? null : one.place, snapped && !snapped.startsWith("planned/") ? `pose ${snapped}` : null].filter(x => x).join(" · ") || "dragged";
  if (sensor?.is_fixed) element("chosen-place").textContent = "It has no poses: it is where its box is. Drag its letter on the floor plan.";
  element("pose").hidden = !!sensor?.is_fixed;
  element("chosen-problem").textContent = problem ?? "";
  element("chosen-problem").hidden = !problem;
  element("chosen-carried").hidden = !sensor?.carried && !sensor?.on;
  element("chosen-carried").textContent = sensor?.on ? `On ${sensor.on.object}/${sensor.on.link}, and moves with it. The numbers are those of this moment; the study gets the pose on the link.` : "It moves with the robot: choose one of its listed poses.";
  element("chosen-place").hidden = !!problem;
  FIELDS.forEach(([name, , unit], n) => {
    const input = element(`pose-${name}`);
    input.disabled = !isFree;
    if (document.activeElement !== input || planner.draft) input.value = at ? rounded(fieldOf(at, n), unit === "m" ? 3 : 1) : "";
  });
  const select = element("model"), names = [...planner.state.sensors, ...planner.state.catalogue ?? []].map(one => one.name ?? one.model);
  if (select.dataset.names !== names.join("\n")) { select.replaceChildren(...planner.state.sensors.map(one => made("option", { value: one.name }, one.model && one.model !== one.name ? `${one.name} (${one.model})` : one.name)), ...(planner.state.catalogue?.length ? [made("optgroup", { label: "Catalogue" }, ...planner.state.catalogue.map(one => made("option", { value: one.model, "data-model": "yes" }, one.model)))] : [])); select.dataset.names = names.join("\n"); }
  select.selectedIndex = planner.state.sensors.findIndex(({ name }) => name === one.sensor);
  select.disabled = element("cost").disabled = element("copy").disabled = element("remove").disabled = !mayEdit();
  if (!at) element("copy").disabled = true;
  if (document.activeElement !== element("cost")) element("cost").value = one.cost ?? "";
  element("currency").textContent = planner.state.currency ?? "";
  element("dead").checked = planner.dead === planner.selected;
  element("through").textContent = planner.through === planner.selected && planner.through !== undefined ? "Back to the cell" : "Look through";
  element("through").disabled = !at || !scene.stage;
  const adds = countsNow()?.adds?.[planner.selected];
  // The line stays when it has nothing to say, so that what is below it does not jump.
  element("adds").textContent = !adds ? " " : `${grouped(adds.seen)} voxels of the region are known through this sensor alone${adds.human_seen ? `, ${grouped(adds.human_seen)} of them people's` : ""}.`;
}

/** The picture that the program makes of what the chosen sensor sees, after a rest. */
let eyeWaits = 0, eyeAsked = new AbortController();
/** Gives a picture up of a plan that changes now. */
function stopEye() { clearTimeout(eyeWaits); eyeAsked.abort(); eyeAsked = new AbortController(); }
function showEyeSoon() {
  stopEye();
  const index = planner.selected, one = placed()[index], home = element("eye");
  const can = !!one?.at_m && sensorOf(one)?.rays && !planner.isLost;
  element("eye-of").hidden = !can;
  if (can && !planner.draft) eyeWaits = setTimeout(async () => {
    if (edits || planner.selected !== index || !placed()[index]) return;
    try {
      const picture = await (await send(`/eye?index=${index}&moment=${planner.moment}`, undefined, eyeAsked.signal)).blob();
      if (planner.selected !== index) return;
      URL.revokeObjectURL(home.src);
      home.src = URL.createObjectURL(picture);
      element("eye-words").textContent = `${letterAt(index)} sees`;
      home.alt = `What ${letterAt(index)} sees: depth, people tinted`;
    } catch (error) { if (error.name !== "AbortError") element("eye-of").hidden = true; }
  }, 250);
}

function fillRegions() {
  const select = element("region"), { regions = [] } = planner.state, names = regions.map(one => one.name).join("\n");
  if (select.dataset.names !== names) { select.replaceChildren(...regions.map(({ name }, n) => made("option", { value: n }, name))); select.dataset.names = names; }
  select.value = planner.region;
}

/** What is counted, in words and numbers. */
const COUNTED = [["unknown", "Unknown", "UF"], ["seen", "Seen", "TP"], ["missed", "Called free", "FN"], ["false", "False", "FP"]];

const MEASURED = { "People seen": "human_seen", "Body parts": "parts_detected", "Seen twice": "seen_twice", F1: "F1" };

function showCounts() {
  const counts = countsNow(), { answer } = planner;
  const values = counts && { unknown: counts.unknown ?? counts.uo + counts.uf, seen: counts.tp, missed: counts.fn, false: counts.fp };
  const all = counts ? counts.tp + counts.fp + counts.fn + counts.tn + counts.uo + counts.uf : 0;
  for (const [name] of COUNTED) {
    element(`count-${name}`).textContent = counts ? grouped(values[name]) : "–";
    element(`count-${name}`).dataset.value = counts ? values[name] : "";
  }
  const parts = counts ? [["TP", counts.tp], ["TN", counts.tn], ["FP", counts.fp], ["FN", counts.fn], ["UO", counts.uo], ["UF", counts.uf]] : [];
  element("share").replaceChildren(...parts.filter(([, value]) => value).map(([name, value]) => { const bar = made("i", { title: `${grouped(value)} ${name}` }); bar.style.flexGrow = value; bar.style.background = hue(name); return bar; }));
  const known = all ? (all - values.unknown) / all : null;
  const measures = counts ? [["Known", percent(known)], ["People seen", percent(counts.human_seen)], ["Body parts", counts.parts ? `${counts.parts_detected} of ${counts.parts}` : "–"], ["Seen twice", counts.seen_twice === null || counts.seen_twice === undefined ? "–" : counts.seen_twice <= 1 ? percent(counts.seen_twice) : grouped(counts.seen_twice)], ["F1", counts.f1 === null || counts.f1 === undefined ? "–" : counts.f1.toFixed(3)]] : [];
  element("measures").replaceChildren(...measures.flatMap(([name, value]) => [made("dt", {}, MEASURED[name] ? made("abbr", { title: explanationOf(MEASURED[name])[2] }, name) : name), made("dd", {}, value)]));
  const missed = counts?.parts_missed ?? [];
  element("parts-missed").textContent = missed.length ? `Not detected: ${missed.slice(0, 6).join(", ")}${missed.length > 6 ? ` and ${missed.length - 6} more` : ""}.` : "";
  const voxel = answer?.cell?.voxel_size_m;
  element("resolution").textContent = !answer ? "" : planner.carry && !planner.carry.isSettling ? "counted again when the object is let go" : answer.voxel === "coarse" && answer.isDraft ? `coarse while dragging: voxels of ${Math.round(100 * voxel)} cm` : `exact: the study's voxels of ${rounded(100 * voxel, 1)} cm`;
  element("resolution").className = answer?.voxel === "coarse" ? "coarse" : "exact";
  if (planner.draft && answer?.problems) {
    const own = answer.problems.find(one => one.index === planner.draft.index)?.words ?? null;
    if (own !== planner.draft.problem && answer.isDraft) { planner.draft.problem = own; tell("draft"); }
  }
}
