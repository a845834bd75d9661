// Puts the page together: fills the selectors, and draws again what a choice changes.

/** The selectors of the one score that is chosen; a sensor alone has no maxima. */
const REGION_SELECTORS = ["region", "region-of-best"].filter(element);
const SCORE_SELECTORS = ["measure", "measure-of-distributions", "measure-of-maxima"].filter(element);

function fill(id, names, key) {
  const select = element(id);
  select.replaceChildren(...names.map((name, i) => made("option", { value: i }, name)));
  select.addEventListener("change", () => choose({ [key]: Number(select.value) }));
}

/** The sensors whose positions can be mapped. */
function fillMembers() {
  const all = posed();
  const of = i => data.sensors[combination().members[i].sensor].name;
  // Two of one sensor are told apart by their numbers.
  const named = i => {
    const same = all.filter(other => of(other) === of(i));
    return same.length > 1 ? `${of(i)} ${same.indexOf(i) + 1}` : of(i);
  };
  element("member").replaceChildren(...all.map(i => made("option", { value: i }, named(i))));
  element("member").value = chosen.member;
  element("member-label").hidden = all.length < 2;
}

function drawSelected() {
  const block = series().scores.over, place = placeIn(block, chosen.choice);
  const scores = place < 0 ? "" : data.measures.map((one, m) => `${one.title} ${scored(values(m)[place], m)}`).join(", ");
  element("selected").replaceChildren("Selected: ", made("strong", {}, nameOf(chosen.choice)), ` (${placeOf(chosen.choice)}) — ${scores}`);
  for (const id of ["extent", "series"]) element(id).value = chosen[id];
  for (const id of REGION_SELECTORS) element(id).value = chosen.region;
  for (const part of document.querySelectorAll("[data-of-region]")) part.hidden = Number(part.dataset.ofRegion) !== chosen.region;
  for (const id of SCORE_SELECTORS) element(id).value = chosen.measure;
}

/** Words, tables and plots follow a choice at once, the cell a moment later, as it takes longest: of haste only the last is drawn. */
const waiting = { changes: null };
function draw(changes) {
  const changed = (...keys) => keys.some(key => key in changes);
  // Another moment changes nothing but the cell.
  if (changed("series", "extent", "region", "measure", "member", "choice")) {
    drawSelected();
    if (changed("series")) fillMembers();
    if (changed("measure")) Object.assign(sorting, { by: chosen.measure, down: !measure().less_is_better });
    drawTable();
    drawScores();
    if (changed("series", "extent", "region", "measure", "member")) drawMaps(); else markMaps();
    drawPositions();
    drawTimes();
  }
  if (changed("series", "extent", "region", "choice", "moment")) {
    if (!waiting.changes) requestAnimationFrame(() => {
      const { changes } = waiting;
      waiting.changes = null;
      delete document.body.dataset.waits;
      try { drawCell("series" in changes || "choice" in changes); } catch (error) { failed(error); }
    });
    waiting.changes = { ...waiting.changes, ...changes };
    document.body.dataset.waits = "for the cell";
  }
}

/** Chooses what a button or a point of a chart stands for, and shows it: what the page tells of it, else the cell. */
function chooseNamed({ dataset }) {
  choose({ series: Number(dataset.series), region: Number(dataset.region), choice: Number(dataset.choice) });
  const own = element(dataset.opens);
  if (own) own.open = true;
  (own ?? element("cell")).scrollIntoView();
}

fill("extent", extents, "extent");
REGION_SELECTORS.forEach(id => fill(id, data.regions, "region"));
fill("series", data.series.map(one => one.title), "series");
SCORE_SELECTORS.forEach(id => fill(id, data.measures.map(one => one.title), "measure"));
fill("member", [], "member");
makeLayers();
document.querySelectorAll("[data-choice]").forEach(named => named.addEventListener("click", () => chooseNamed(named)));
// Paper has nothing to click on.
addEventListener("beforeprint", () => document.querySelectorAll("details").forEach(part => { part.open = !part.matches(".aside"); }));
Object.assign(chosen, data.recommended ?? {});
chosen.member = posed()[0] ?? 0;
listeners.push(draw);
draw({ series: 0, measure: 0 });
await new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)));
// What is scrolled to stands below the bar that sticks to the top.
const bar = element("choice");
const keepClear = () => { document.documentElement.style.scrollPaddingTop = getComputedStyle(bar).position === "sticky" ? `${bar.offsetHeight + 8}px` : "0"; };
new ResizeObserver(keepClear).observe(bar);
keepClear();
// Pictures are as wide as their places.
let width = innerWidth;
addEventListener("resize", () => { if (innerWidth !== width) { width = innerWidth; draw({ series: 0 }); } });
document.body.dataset.ready = "yes";
