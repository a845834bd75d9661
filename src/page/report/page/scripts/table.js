// The table of the poses: the best by some score, to be sorted and chosen from.
const STEP = 25;
const sorting = { by: 0, down: true, rows: STEP };

/** Columns besides the measures: a heading, and what is shown of a choice. */
const COLUMNS = [
  { title: "pose", of: choice => nameOf(choice) },
  { title: "place", of: placeOf },
];

/** The rows in order: places in the block. */
function ordered() {
  const all = values(sorting.by), places = Array.from(all, (_, i) => i);
  const sign = sorting.down ? -1 : 1;
  const missing = i => Number.isNaN(all[i]) ? 1 : 0;
  return places.sort((a, b) => missing(a) - missing(b) || sign * (all[a] - all[b]) || a - b);
}

function heading_cell(title, measure) {
  if (measure === undefined) return made("th", { scope: "col" }, title);
  const sorted = sorting.by === measure ? (sorting.down ? "descending" : "ascending") : "none";
  const button = made("button", { type: "button", "data-measure": measure, onclick: () => {
    Object.assign(sorting, sorting.by === measure ? { down: !sorting.down } : { by: measure, down: !data.measures[measure].less_is_better });
    drawTable();
    element("table").querySelector(`[data-measure="${measure}"]`).focus();
  } }, title, sorted === "none" ? "" : sorted === "descending" ? " ▼" : " ▲");
  return made("th", { scope: "col", "aria-sort": sorted }, button);
}

function drawTable() {
  if (!element("table")) return;
  const choices = choicesOf(series().scores.over), all = data.measures.map((_, m) => values(m));
  const floors = [0, 1].map(m => toBeat(m));
  const order = ordered();
  const rows = order.slice(0, sorting.rows).map(i => {
    const choice = choices[i];
    const below = floors.map((floor, m) => floor && all[m][i] < floor.value ? `${data.measures[m].title} below “${floor.name}”` : "").filter(Boolean).join(", ");
    const [name, ...rest] = COLUMNS.map(column => column.of(choice));
    const button = made("button", { type: "button", class: "choose", onclick: () => choose({ choice }) }, name);
    const cells = [made("td", {}, button), ...rest.map(text => made("td", {}, text)), ...all.map((column, m) => made("td", {}, scored(column[i], m))), made("td", { class: "mark" }, below ? `▼ ${below}` : "")];
    return made("tr", choice === chosen.choice ? { class: "chosen", "aria-current": "true" } : {}, ...cells);
  });
  const head = made("thead", {}, made("tr", {}, ...COLUMNS.map(column => heading_cell(column.title)), ...data.measures.map((one, m) => heading_cell(one.title, m)), heading_cell("")));
  element("table").replaceChildren(head, made("tbody", {}, ...rows));
  element("more").hidden = order.length <= sorting.rows;
  const kept = series().scores.over.choices ? " (the best; results.csv has all)" : "";
  element("table-note").textContent = `${series().title} · region ${data.regions[chosen.region]} · ${extents[chosen.extent]}: ${Math.min(order.length, sorting.rows)} of ${order.length} choices of poses${kept}, sorted by ${data.measures[sorting.by].title}. ▼ marks those that a sensor beats which always says the same.`;
}

element("more")?.addEventListener("click", () => { sorting.rows += 4 * STEP; drawTable(); });
