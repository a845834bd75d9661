// Why voxels are unknown: a switch for each cause, which takes its voxels out of the 3D view; their colours; and bars of how
// many there are. A cause is a reason and, where one is to blame, an object.
const UNKNOWN = [4, 5]; // UO and UF among the layers.
// An object has the same colour in every view.
const OBJECT_COLOURS = hues("object");
const blamed = [...new Set(data.cells.labels.flatMap(one => one.causes).filter(cause => !hue(cause.reason)).map(cause => cause.words))];
const colourOf = cause => hue(cause.reason) || OBJECT_COLOURS[blamed.indexOf(cause.words) % OBJECT_COLOURS.length];
const causes = { off: new Set(), coloured: false };

/** The causes of a region's unknown voxels, the most frequent first: number, words, colour, and how many are occupied or free. */
function causesOf(found) {
  const all = found.names.map((cause, number) => ({ ...cause, number, occupied: 0, free: 0 }));
  found.causes.forEach((cause, i) => { if (cause) all[cause - 1][found.layers[i] === UNKNOWN[0] + 1 ? "occupied" : "free"]++; });
  const here = all.filter(cause => cause.occupied + cause.free).sort((a, b) => b.occupied + b.free - a.occupied - a.free);
  return here.map(cause => ({ ...cause, colour: colourOf(cause) }));
}

/** The outside of the unknown voxels of a layer, cause by cause. */
function shapeOfUnknown(found, layer, cell) {
  const marks = found.causes.map((cause, i) => found.layers[i] === layer + 1 ? cause : 0);
  const whole = nothing(), colourIn = cause => causes.coloured ? cause.colour : LAYERS[layer].colour;
  causesOf(found).filter(cause => !causes.off.has(cause.words)).forEach(cause => join(whole, outside(marks, cause.number + 1, cell), colourIn(cause)));
  return whole;
}

/** The switches, and the bars. */
function drawCauses(found) {
  const home = element("causes"), plot = element("reasons");
  const all = found ? causesOf(found) : [];
  for (const part of [home, plot, element("reasons-note"), element("reasons-title")]) part.hidden = !all.length;
  if (!all.length) return home.replaceChildren();
  const total = all.reduce((sum, cause) => sum + cause.occupied + cause.free, 0);
  home.replaceChildren("Unknown, by cause:", ...all.map(cause => {
    const box = made("input", { type: "checkbox" });
    box.checked = !causes.off.has(cause.words);
    box.addEventListener("change", () => { causes.off[box.checked ? "delete" : "add"](cause.words); redrawUnknown(); });
    const colour = made("i", {});
    colour.style.background = cause.colour;
    return made("label", { class: "layer" }, box, colour, cause.words, made("span", { class: "note" }, String(cause.occupied + cause.free)));
  }), coloursSwitch());
  const share = cause => `${(100 * (cause.occupied + cause.free) / total).toFixed(1)} %`;
  const most = Math.max(...all.map(cause => cause.occupied + cause.free));
  const bar = (cause, key) => {
    const bar = made("i", { class: key, title: `${cause.words}, ${cause.monitored ? "monitored" : "not monitored"}: ${share(cause)} of the unknown; ${key}: ${cause[key]} voxels` });
    Object.assign(bar.style, { width: `${100 * cause[key] / most}%`, background: cause.colour });
    return bar;
  };
  const rows = all.map(cause => made("tr", {}, made("th", { scope: "row" }, cause.words), made("td", {}, String(cause.occupied + cause.free)), made("td", {}, share(cause)), made("td", { class: "bar" }, bar(cause, "occupied"), bar(cause, "free"))));
  const title = made("p", { class: "title" }, `${total} unknown voxels · region ${data.regions[chosen.region]} (dark edge: occupied)`);
  plot.replaceChildren(title, made("table", {}, ...rows));
}

function coloursSwitch() {
  const box = made("input", { type: "checkbox", id: "by-cause" });
  box.checked = causes.coloured;
  box.addEventListener("change", () => { causes.coloured = box.checked; redrawUnknown(); });
  return made("label", { class: "layer" }, box, "colour what is not known by its cause");
}

/** Draws UO and UF again, with the causes that are switched on. */
function redrawUnknown() {
  const cell = cellAt(chosen.moment), found = verdicts(cell);
  const scene = element("view").stage;
  if (scene !== "none") UNKNOWN.forEach(n => showLayer(scene, n, shapeOfUnknown(found, n, cell)));
}
