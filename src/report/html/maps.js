// Maps of the placements: ceiling and walls of the room unfolded into one, other groups of positions each in their own.

/** The two axes along which positions spread the most. */
function plane(all) {
  const spread = axis => Math.max(...all.map(p => p.at[axis])) - Math.min(...all.map(p => p.at[axis]));
  const normal = [0, 1, 2].reduce((least, axis) => spread(axis) < spread(least) - 1e-9 ? axis : least, 2);
  return [0, 1, 2].filter(axis => axis !== normal);
}

/**
 * The faces of a room that fold out: where they lie in the room, and where a place on them comes to lie on paper. The
 * ceiling is in the middle, as seen from above, and the walls hang on its edges.
 */
function facesOf([low, high]) {
  const h = high[2] - low[2], down = at => high[2] - at[2], middle = [0, 1].map(n => (low[n] + high[n]) / 2);
  // Names stand at the outer edge of a wall, and at the upper one of the ceiling.
  const beside = (x, anchor) => ({ x, y: middle[1], xanchor: anchor, textangle: -90 });
  return [
    { axis: 2, at: high[2], to: ([x, y]) => [x, y], label: { x: middle[0], y: high[1], yanchor: "top" } },
    { axis: 0, at: low[0], to: at => [low[0] - down(at), at[1]], label: beside(low[0] - h, "right") },
    { axis: 0, at: high[0], to: at => [high[0] + down(at), at[1]], label: beside(high[0] + h, "left") },
    { axis: 1, at: low[1], to: at => [at[0], low[1] - down(at)], label: { x: middle[0], y: low[1] - h, yanchor: "top" } },
    { axis: 1, at: high[1], to: at => [at[0], high[1] + down(at)], label: { x: middle[0], y: high[1] + h, yanchor: "bottom" } },
  ];
}

/** Farther apart than this, positions stand for themselves only: squares are drawn, no areas. */
const WIDEST_M = 2;

/** How far from a wall something still hangs on it. */
const NEAR_M = 0.5;

/** Maps to draw: each with parts, positions that lie in a plane and where they come to lie on paper. */
function maps() {
  const all = positions(), groups = new Map();
  for (const p of all) groups.has(p.group) ? groups.get(p.group).push(p) : groups.set(p.group, [p]);
  const onLink = data.sensors[combination().members[chosen.member]?.sensor]?.on;
  const room = data.scenes[Math.max(0, chosen.extent - 1)].room_m;
  const faces = onLink ? [] : facesOf(room).map(face => ({ ...face, positions: [], groups: [] }));
  const own = [];
  for (const [group, whole] of groups) {
    const face = faces.find(({ axis, at }) => whole.every(p => Math.abs(p.at[axis] - at) <= NEAR_M));
    if (face) { face.positions.push(...whole); face.groups.push(group); } else own.push([group, whole]);
  }
  const used = faces.filter(face => face.positions.length);
  if (used.length === 1) own.unshift([used[0].groups.join(", "), used[0].positions]);
  const found = own.map(([title, whole]) => {
    const [u, v] = plane(whole);
    if (onLink) title += `, in the frame of ${frameOf(data.sensors[combination().members[chosen.member].sensor])}`;
    return { title, axes: [u, v], parts: [{ whole, to: at => [at[u], at[v]] }] };
  });
  if (used.length > 1) {
    const parts = used.map(({ positions, groups, to, label }) => ({ whole: positions, to, label: { ...label, text: plain(groups.join(", ")) } }));
    found.unshift({ title: "Walls and ceiling unfolded, seen from above", room, parts });
  }
  return found;
}

/** Of positions that fall together on paper, the best. */
function bestOfEach({ whole, to }) {
  const found = new Map();
  for (const p of whole.filter(p => !Number.isNaN(p.value))) {
    const [x, y] = to(p.at).map(value => Math.round(value * 1e6) / 1e6), key = `${x}/${y}`, known = found.get(key);
    if (!known || isBetter(p.value, known.p.value)) found.set(key, { x, y, p });
  }
  return found;
}

const even = all => all.every((x, i) => i < 2 || Math.abs(x - 2 * all[i - 1] + all[i - 2]) < 1e-5);

/** What hovering over a position tells. */
const word = p => `${plain(nameOf(p.choice))}<br>${plain(p.pose.place)}<br>${measure().title} ${shown(p.value)}`;

/** A heatmap where positions form a lattice, else squares. */
function trace(spots, [low, high], showscale) {
  const all = [...spots.values()], axis = key => [...new Set(all.map(spot => spot[key]))].sort((a, b) => a - b);
  const [xs, ys] = [axis("x"), axis("y")], at = (x, y) => spots.get(`${x}/${y}`);
  const common = { hovertemplate: "%{text}<extra></extra>", showlegend: false };
  const colours = { colorscale: MAP, reversescale: measure().less_is_better, showscale, colorbar: colourBar() };
  const close = all => all.length > 1 && all[1] - all[0] <= WIDEST_M && even(all);
  const lattice = close(xs) && close(ys) && all.length >= 0.6 * xs.length * ys.length;
  if (!lattice) return { ...common, type: "scatter", mode: "markers", x: all.map(spot => spot.x), y: all.map(spot => spot.y), text: all.map(spot => word(spot.p)), marker: { ...colours, symbol: "square", size: 16, color: all.map(spot => spot.p.value), cmin: low, cmax: high } };
  const table = of => ys.map(y => xs.map(x => of(at(x, y))));
  return { ...common, ...colours, type: "heatmap", x: xs, y: ys, z: table(spot => spot?.p.value ?? null), text: table(spot => spot ? word(spot.p) : ""), zmin: low, zmax: high, xgap: xs.length > 30 ? 0 : 1, ygap: ys.length > 30 ? 0 : 1 };
}

/** The outlines of the unfolded faces, and their names. */
function outlines({ room: [low, high], parts }) {
  const h = high[2] - low[2], line = { color: "#9aa5b1", width: 1 };
  const box = (x0, x1, y0, y1) => ({ type: "rect", x0, x1, y0, y1, line, layer: "below" });
  const shapes = [box(low[0] - h, high[0] + h, low[1], high[1]), box(low[0], high[0], low[1] - h, high[1] + h)];
  const annotations = parts.map(({ label }) => ({ ...label, showarrow: false, font: { size: 12 }, bgcolor: "#ffffffd0" }));
  return { shapes, annotations };
}

function axesOf({ axes }, isLattice) {
  const plainAxis = { zeroline: false, showgrid: false, constrain: "domain" };
  const label = axis => ({ ...plainAxis, title: { text: `${NAMES[axis]} in m` }, automargin: true });
  if (axes) return { xaxis: label(axes[0]), yaxis: { ...label(axes[1]), scaleanchor: isLattice ? "x" : undefined } };
  return { xaxis: { ...plainAxis, visible: false }, yaxis: { ...plainAxis, visible: false, scaleanchor: "x" } };
}

/** Draws all maps of the chosen member. */
async function drawMaps() {
  const home = element("maps"), all = maps();
  [...home.children].forEach(plot => Plotly.purge(plot));
  home.replaceChildren();
  const range = span(all.flatMap(map => map.parts.flatMap(part => part.whole.map(p => p.value))));
  for (const map of all) {
    const spots = map.parts.map(bestOfEach);
    const traces = spots.map((of, n) => trace(of, range, n === 0));
    const valued = map.parts.map(part => part.whole.filter(p => !Number.isNaN(p.value)).length);
    const behind = spots.some((of, n) => valued[n] > of.size) ? " (of positions behind each other the best)" : "";
    const none = valued.every(count => !count) ? ` (no ${measure().title} here)` : "";
    const plot = home.appendChild(made("div", { role: "img", "aria-label": `Map: ${map.title}`, class: map.room ? "room" : "" }));
    Object.assign(plot, { parts: map.parts, spots });
    const ring = { type: "scatter", mode: "markers", x: [], y: [], hoverinfo: "skip", showlegend: false, marker: { symbol: "circle-open", size: 20, color: "#d55e00", line: { width: 4 } } };
    const margin = map.room ? { l: 8, r: 8, t: 36, b: 8 } : LAYOUT.margin;
    await Plotly.newPlot(plot, [...traces, ring], { ...LAYOUT, margin, title: heading(map.title + behind + none), ...axesOf(map, traces[0].type === "heatmap"), ...(map.room ? outlines(map) : {}) }, CONFIG);
    plot.on("plotly_click", ({ points: [point] }) => {
      const spot = plot.spots[point.curveNumber]?.get(`${point.x}/${point.y}`);
      if (spot) choose({ choice: spot.p.choice });
    });
  }
  home.hidden = !all.length;
  await markMaps();
}

/** Rings the chosen positions. */
async function markMaps() {
  const keys = chosenPositions();
  for (const plot of element("maps").children) {
    const here = plot.parts.flatMap(({ whole, to }) => whole.filter(p => keys.includes(p.key)).map(p => to(p.at)));
    await Plotly.restyle(plot, { x: [here.map(at => at[0])], y: [here.map(at => at[1])] }, [plot.parts.length]);
  }
}
