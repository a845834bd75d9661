// Asks the program for the best set: the front appears while it is found, and a click on a point takes that set.
const found = { points: [], bound: null, words: "", controller: null, version: null, isTaking: false };

function closeFind() {
  element("find-panel").hidden = true;
  element("find").focus();
}

function openFind() {
  element("find-panel").hidden = false;
  element("find-ask").focus();
  const { regions = [] } = planner.state;
  element("find-region").replaceChildren(...regions.map(({ name }) => made("option", { value: name }, name)));
  showBudget();
  showFindKind();
}

/** The budget of the study, and the unit of all costs. */
function showBudget() {
  const { budget, currency } = planner.state, home = element("find-budget");
  if (document.activeElement !== home && (canBudget() || home.value === "")) home.value = budget ?? "";
  element("find-currency").textContent = currency ?? "";
}

/** Whether the study can hold a budget: it has one, or asks for the cheapest set. */
const canBudget = () => isKnown(planner.state.budget) || needsCost() && (planner.state.requirements ?? []).length > 0;

/** Writes the budget into the study, if it can hold one; else only the next search has it. */
function typeBudget() {
  const typed = element("find-budget").value, budget = typed === "" ? null : Number(typed);
  if (mayEdit() && canBudget() && budget !== (planner.state.budget ?? null)) edit({ edit: "set_budget", budget });
}

/** What can be asked besides, by what is asked. */
function showFindKind() {
  const isScore = element("find-ask").value === "score";
  document.querySelectorAll("#find-panel .of-score").forEach(part => { part.hidden = !isScore; });
}

async function find() {
  stopFind();
  await lastEdit;
  const budget = element("find-budget").value;
  if (element("find-keep").checked && budget !== "" && planner.state.cost > Number(budget)) {
    found.words = `The placed sensors alone cost ${money(planner.state.cost)}: let Find replace them (untick “Placed sensors stay”), or raise the budget.`;
    showFound();
    return;
  }
  const controller = found.controller = new AbortController(), isScore = element("find-ask").value === "score", numberOf = id => element(id).value === "" ? null : Number(element(id).value);
  Object.assign(found, { points: [], bound: null, words: "Searching…", version: planner.state.version, isKept: element("find-keep").checked, isScore, region: element("find-region").value, score: element("find-score").value });
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
    found.points = [...found.points.filter(one => !isOlder(one)), { ...line.point, version: found.version }];
  }
  if (line.front) found.points = line.front.map(point => ({ ...point, version: found.version }));
  if (line.search) found.words = line.search;
  if (line.bound) found.bound = line.bound;
  if (line.stage) found.words = `${line.stage.words}: ${grouped(line.stage.done)} of ${grouped(line.stage.total)}`;
  if (line.error) line.error = plainError(line.error);
  for (const name of ["done", "stopped", "error"]) if (line[name] !== undefined) found.words = typeof line[name] === "string" ? line[name] : line[name].words ?? (name === "done" ? "Done." : name === "stopped" ? "Stopped: this was found so far." : "It cannot be found.");
  showFound();
}

function stopFind() {
  if (!found.controller) return;
  ask("/stop", {}).catch(complain);
}

/** What was found, and what is known of it. */
function showFound() {
  const isBusy = !!document.body.dataset.finding, { points, bound, isScore } = found;
  // The button that begins gives way to the one that stops, and the focus goes along.
  const [shown, gone] = isBusy ? ["find-stop", "find-begin"] : ["find-begin", "find-stop"], hadFocus = document.activeElement === element(gone);
  element(shown).hidden = false;
  element(gone).hidden = true;
  if (hadFocus) element(shown).focus();
  const least = isKnown(bound?.cost) && !isScore && !isBusy ? ` No set of the listed poses that passes${found.isKept ? " with your sensors in it" : ""} costs less than ${money(bound.cost)}.` : "";
  element("find-words").textContent = (found.words && !/[.!?…]$/.test(found.words) ? `${found.words}.` : found.words) + (isFoundEarlier() && points.length && !isBusy ? " The study has changed since then: search again to be sure." : least);
  showFront();
  element("found").replaceChildren(...[...points].sort((a, b) => (a.part ?? 0) - (b.part ?? 0) || (a.cost ?? 0) - (b.cost ?? 0)).map(point => {
    const button = made("button", { type: "button", "data-edits": "" }, made("strong", {}, money(point.cost)), made("span", {}, point.words ?? point.placed?.map(one => `${one.sensor}: ${one.pose}`).join(", ") ?? ""), made("b", {}, "Use this set"), made("em", {}, isKnown(point.score) ? point.score.toFixed(3) : point.is_proven && !isFoundEarlier() ? "proven" : "so far"));
    button.disabled = !mayEdit();
    button.addEventListener("click", () => takeFound(point));
    return made("li", {}, button);
  }));
}

/** Puts a set that was found in place of the plan. */
function takeFound(point) {
  if (!point.placed) return;
  found.isTaking = !isFoundEarlier();
  edit({ edit: "set_plan", placed: point.placed }).then(is => { if (is) notify("The set is placed; undo brings yours back.", "good"); }).finally(() => { found.isTaking = false; });
}

/** Whether the study was changed since it was searched, other than by taking a set. */
const isFoundEarlier = () => isKnown(found.version) && found.version !== planner.state.version;

/** After a change a bound may no longer hold. */
function forgetBound() {
  if (found.isTaking) found.version = planner.state.version;
  if (!isFoundEarlier()) return;
  found.bound = null;
  showFound();
}

/** Poses that were dragged may be elsewhere by now: what was found with them no longer holds. */
function forgetDragged() {
  const kept = found.points.filter(point => !point.placed?.some(one => one.pose.startsWith("planned")) || point.version === planner.state.version);
  if (kept.length === found.points.length) return;
  found.points = kept;
  showFound();
}

function makeFind() {
  on("state", forgetBound);
  on("state", forgetDragged);
  on("state", () => { if (!element("find-panel").hidden) showBudget(); });
  on("state judged", showFront);
  element("find-budget").addEventListener("change", typeBudget);
  element("find").addEventListener("click", openFind);
  element("find-close").addEventListener("click", closeFind);
  element("find-ask").addEventListener("change", showFindKind);
  element("find-form").addEventListener("submit", event => { event.preventDefault(); find(); });
  element("find-stop").addEventListener("click", stopFind);
}
