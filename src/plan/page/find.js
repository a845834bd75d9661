// Asks the program for the best set: the front appears while it is found, and a click on a point takes that set.
const found = { points: [], bound: null, words: "", controller: null, isOpen: false };

function openFind() {
  element("find-panel").hidden = false;
  element("find-ask").focus();
  const { regions = [], budget } = planner.state;
  element("find-region").replaceChildren(...regions.map(({ name }) => made("option", { value: name }, name)));
  if (!element("find-budget").value && budget) element("find-budget").value = budget;
  showFindKind();
}

/** What can be asked besides, by what is asked. */
function showFindKind() {
  const isScore = element("find-ask").value === "score";
  document.querySelectorAll("#find-panel .of-score").forEach(part => { part.hidden = !isScore; });
}

async function find() {
  stopFind();
  const budget = element("find-budget").value;
  if (element("find-keep").checked && budget !== "" && planner.state.cost > Number(budget)) {
    found.words = `The placed sensors alone cost ${money(planner.state.cost)}: let Find replace them (untick “Placed sensors stay”), or raise the budget.`;
    showFound();
    return;
  }
  const controller = found.controller = new AbortController(), isScore = element("find-ask").value === "score", numberOf = id => element(id).value === "" ? null : Number(element(id).value);
  Object.assign(found, { points: [], bound: null, words: "Searching…" });
  document.body.dataset.finding = "yes";
  showFound();
  const question = { ask: isScore ? "score" : "cheapest", ...(isScore ? { region: element("find-region").value, score: element("find-score").value } : {}), budget: numberOf("find-budget"), at_most: numberOf("find-most"), keep: element("find-keep").checked ? placed().map(one => `${one.sensor}:${one.pose}`) : [] };
  try {
    await eachLine(await send("/choose", question, controller.signal), hear);
  } catch (error) {
    if (error.name !== "AbortError") { found.words = error.message; complain(error); }
  }
  if (found.controller === controller) { found.controller = null; delete document.body.dataset.finding; }
  showFound();
}

/** A line of the answer. */
function hear(line) {
  if (line.point) {
    const { part, cost, score } = line.point, isOlder = one => part === null ? one.cost === cost && one.score === score : one.part === part;
    found.points = [...found.points.filter(one => !isOlder(one)), { ...line.point, version: planner.state.version }];
  }
  if (line.search) found.words = line.search;
  if (line.bound) found.bound = line.bound;
  if (line.stage) found.words = `${line.stage.words}: ${grouped(line.stage.done)} of ${grouped(line.stage.total)}`;
  for (const name of ["done", "stopped", "error"]) if (line[name] !== undefined) found.words = typeof line[name] === "string" ? line[name] : line[name].words ?? (name === "done" ? "Done." : name === "stopped" ? "Stopped: this was found so far." : "It cannot be found.");
  showFound();
}

function stopFind() {
  if (!found.controller) return;
  ask("/stop", {}).catch(complain);
}

/** The front: cost across, score up; the proven bound is dashed. */
function showFound() {
  const isBusy = !!document.body.dataset.finding;
  const { points, bound } = found;
  element("find-stop").hidden = !isBusy;
  element("find-begin").hidden = isBusy;
  element("find-words").textContent = found.words;
  const home = element("front"), width = 320, height = 170, isNumber = value => value !== null && value !== undefined, scored = points.filter(one => isNumber(one.score) && isNumber(one.cost));
  home.hidden = !scored.length;
  if (scored.length) {
    const own = planner.judged?.score ?? null, costs = scored.map(one => one.cost), scores = [...scored.map(one => one.score), ...(bound?.score !== undefined && bound?.score !== null ? [bound.score] : [])];
    const [c0, c1, s0, s1] = [0, Math.max(...costs) * 1.08 || 1, Math.min(...scores), Math.max(...scores)], room = (s1 - s0) * 0.12 || 0.01;
    const x = cost => 42 + (cost - c0) / (c1 - c0) * (width - 56), y = score => height - 28 - (score - s0 + room) / (s1 - s0 + 2 * room) * (height - 42);
    const nodes = [shape("path", { d: `M42 8V${height - 28}H${width - 8}`, class: "frame" }), word(42, height - 12, `cost${planner.state.currency ? ` in ${planner.state.currency}` : ""}`), word(4, 16, s1.toFixed(2)), word(4, height - 30, s0.toFixed(2)), word(x(c1 / 1.08), height - 12, grouped(c1 / 1.08), { "text-anchor": "middle" })];
    if (bound?.score !== undefined && bound?.score !== null) nodes.push(shape("path", { d: `M42 ${px(y(bound.score))}H${width - 8}`, class: "bound" }), word(width - 10, y(bound.score) - 4, `no set is above ${bound.score.toFixed(3)}`, { "text-anchor": "end" }));
    if (own !== null) nodes.push(shape("path", { d: `M42 ${px(y(own))}H${width - 8}`, class: "own" }));
    scored.forEach(point => nodes.push(shape("circle", { cx: px(x(point.cost)), cy: px(y(point.score)), r: 5.5, class: point.is_proven ? "proven" : "open", title: point.words ?? "", onclick: () => takeFound(point) })));
    const picture = shape("svg", { viewBox: `0 0 ${width} ${height}`, width, height });
    picture.append(...nodes);
    home.replaceChildren(picture);
  }
  element("found").replaceChildren(...[...points].sort((a, b) => (a.cost ?? 0) - (b.cost ?? 0)).map(point => {
    const button = made("button", { type: "button", "data-edits": "" }, made("strong", {}, money(point.cost)), made("span", {}, point.words ?? point.placed?.map(one => `${one.sensor}: ${one.pose}`).join(", ") ?? ""), made("em", {}, point.score === null || point.score === undefined ? point.is_proven ? "proven" : "" : point.score.toFixed(3)));
    button.disabled = !mayEdit();
    button.addEventListener("click", () => takeFound(point));
    return made("li", {}, button);
  }));
  if (bound?.cost !== undefined && bound?.cost !== null && !scored.length) element("find-words").textContent = `${found.words} No set that passes costs less than ${money(bound.cost)}.`;
}

/** Puts a set that was found in place of the plan. */
function takeFound(point) {
  if (point.placed) edit({ edit: "set_plan", placed: point.placed }).then(is => { if (is) notify("The set is placed; undo brings yours back.", "good"); });
}

/** Poses that were dragged may be elsewhere by now: what was found with them no longer holds. */
function forgetDragged() {
  const kept = found.points.filter(point => !point.placed?.some(one => one.pose.startsWith("planned")) || point.version === planner.state.version);
  if (kept.length === found.points.length) return;
  found.points = kept;
  showFound();
}

function makeFind() {
  on("state", forgetDragged);
  element("find").addEventListener("click", openFind);
  element("find-close").addEventListener("click", () => { element("find-panel").hidden = true; });
  element("find-ask").addEventListener("change", showFindKind);
  element("find-form").addEventListener("submit", event => { event.preventDefault(); find(); });
  element("find-stop").addEventListener("click", stopFind);
}
