// Why voxels are unknown: a switch for each cause, which takes its voxels out of the 3D view; their colours; and bars of how
// many there are. A cause is a reason and, where one is to blame, an object.
const UNKNOWN = [4, 5]; // UO and UF among the layers.
// Paul Tol's muted colours, apart from those of the verdicts; an object has the same in every view.
const CAUSE_COLOURS = { out_of_view: "#888888", out_of_range: "#000000", silent: "#999933", between_rays: "#88ccee", no_return: "#44aa99", misread: "#332288", cancelled: "#117733" };
const OBJECT_COLOURS = ["#cc6677", "#aa4499", "#ddcc77", "#882255", "#661100", "#6699cc"];
const blamed = [...new Set(data.cells.labels.flatMap(one => one.causes).filter(cause => !(cause.reason in CAUSE_COLOURS)).map(cause => cause.words))];
const colourOf = cause => CAUSE_COLOURS[cause.reason] ?? OBJECT_COLOURS[blamed.indexOf(cause.words) % OBJECT_COLOURS.length];
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
  causesOf(found).filter(cause => !causes.off.has(cause.words)).forEach(cause => join(whole, mesh(marks, cause.number + 1, cell), colourIn(cause)));
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
  const part = (cause, key, hatched) => ({ value: cause[key], fill: cause.colour, hatched, title: `${cause.words}, ${cause.monitored ? "monitored" : "not monitored"}: ${share(cause)} of the unknown; ${key}: ${cause[key]} voxels` });
  const rows = all.map(cause => ({ name: cause.words, text: share(cause), parts: [part(cause, "occupied", true), part(cause, "free", false)] }));
  bars(plot, `${total} unknown voxels · region ${data.regions[chosen.region]} (dark edge: occupied)`, rows, "voxels");
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
