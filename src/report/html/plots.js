// Distributions, maxima, positions in the room, scores over time. What they show is in `choice.js`.
const NAMES = ["x", "y", "z"];
const heading = text => ({ text: plain(text), font: { size: 13 }, x: 0, xref: "paper", xanchor: "left" });

/** The score that is chosen, by its number; with a claimed share its false alarms, without which it says nothing. */
const plotted = () => [chosen.measure, measure().name === "human_claimed" ? data.measures.findIndex(one => one.name === "false_alarm") : -1].filter(m => m >= 0);

/** Plots of the chosen score, of all poses together. */
async function drawScores() {
  for (const home of ["distributions", "maxima"].map(element).filter(Boolean)) {
    [...home.children].forEach(plot => Plotly.purge(plot));
    home.replaceChildren();
  }
  await drawDistributions();
  await drawMaxima();
}

/** Boxes of the chosen score in each region: scenes side by side, a colour for each series. */
async function drawDistributions() {
  const home = element("distributions");
  for (const [r, region] of data.regions.entries()) for (const [n, m] of plotted().entries()) {
    const score = data.measures[m].title;
    const traces = data.series.map((one, i) => {
      const five = data.scenes.map((_, scene) => data.distributions[r][m][scene][i]?.five ?? [null, null, null, null, null]);
      const row = n => five.map(numbers => numbers[n]);
      return { type: "box", name: plain(one.title), x: data.scenes.map(scene => plain(scene.name)), lowerfence: row(0), q1: row(1), median: row(2), q3: row(3), upperfence: row(4), marker: { color: COLOURS[i % COLOURS.length] }, line: { width: 1.5 }, offsetgroup: String(i) };
    });
    const floor = data.scenes.map((_, scene) => toBeat(m, scene + 1, r));
    const dash = { color: "#8a3c00", width: 2.5 };
    traces.push({ type: "scatter", mode: "markers", name: "best without a sensor", x: data.scenes.map(scene => plain(scene.name)), y: floor.map(f => f?.value ?? null), text: floor.map(f => f ? plain(f.name) : ""), hovertemplate: "%{text}: %{y:.3f}<extra></extra>", marker: { symbol: "line-ew-open", size: 12, line: dash, color: dash.color } });
    const shapes = floor.flatMap((f, n) => f ? [{ type: "line", x0: n - 0.45, x1: n + 0.45, y0: f.value, y1: f.value, line: dash }] : []);
    const plot = home.appendChild(made("div", { "aria-label": `${score} in region ${region}`, role: "img" }));
    const many = traces.length > 6, hasLegend = r === 0 && n === 0 || !many;
    // A legend of many lines gets room of its own.
    if (many && hasLegend) Object.assign(plot.style, { gridColumn: "1 / -1", height: `${20 + 1.4 * Math.ceil(traces.length / 4)}rem` });
    await Plotly.newPlot(plot, traces, { ...LAYOUT, title: heading(`${score} · region ${region}`), shapes, boxmode: "group", showlegend: hasLegend, legend: { orientation: "h", y: -0.18, font: { size: 11 } }, yaxis: { rangemode: "tozero", gridcolor: "#e3e8ed", zerolinecolor: "#b5bec8" }, xaxis: { type: "category" } }, CONFIG);
  }
}

/** Bars of the maxima of combinations by the chosen score, and what part of the full set's they are. */
async function drawMaxima() {
  const home = element("maxima");
  if (!home) return;
  for (const [r, region] of data.regions.entries()) for (const m of plotted()) {
    const score = data.measures[m].title;
    const maxima = data.maxima[r][m], full = data.full_set === null ? null : maxima[data.full_set];
    const text = maxima.map(value => full && value !== null ? `${Math.round(100 * value / full)} %` : shown(value));
    const names = data.combinations.map(combination => plain(combination.name));
    const bars = { type: "bar", orientation: "h", y: names, x: maxima, text, textposition: "auto", hovertemplate: "%{y}: %{x:.3f}<extra></extra>", marker: { color: names.map((_, i) => i === data.full_set ? COLOURS[1] : COLOURS[0]) } };
    const plot = home.appendChild(made("div", { role: "img", "aria-label": `Largest ${score} in region ${region}` }));
    await Plotly.newPlot(plot, [bars], { ...LAYOUT, title: heading(`Largest ${score} · region ${region}`), yaxis: { autorange: "reversed", automargin: true }, xaxis: { gridcolor: "#e3e8ed" } }, CONFIG);
  }
}

/** Smallest and largest of some numbers, apart from each other. */
function span(all) {
  const known = all.filter(value => !Number.isNaN(value));
  if (!known.length) return [0, 1];
  const [low, high] = [known.reduce((a, b) => Math.min(a, b)), known.reduce((a, b) => Math.max(a, b))];
  return high > low ? [low, high] : [low - 0.01, high + 0.01];
}

const colourBar = () => ({ title: { text: measure().title, side: "right" }, thickness: 12, len: 0.9 });

/** Lines along the edges of a box. */
function edges([low, high]) {
  const corner = n => [0, 1, 2].map(axis => n >> axis & 1 ? high[axis] : low[axis]);
  const lines = [];
  for (let n = 0; n < 8; n++) for (let axis = 0; axis < 3; axis++) if (!(n >> axis & 1)) lines.push(corner(n), corner(n | 1 << axis), [null, null, null]);
  return lines;
}
const lines3d = (points, more) => ({ type: "scatter3d", mode: "lines", x: points.map(p => p[0]), y: points.map(p => p[1]), z: points.map(p => p[2]), hoverinfo: "skip", showlegend: false, ...more });
const SCENE = { aspectmode: "data", xaxis: { title: { text: "x" } }, yaxis: { title: { text: "y" } }, zaxis: { title: { text: "z" } }, camera: { eye: { x: 0.9, y: -1.5, z: 1.1 } } };

/** All positions in the room, with their best scores. */
async function drawPositions() {
  // What is on a link stands where the link is at the scene's first moment.
  const sensor = data.sensors[combination().members[chosen.member]?.sensor], [moment] = data.scenes[Math.max(0, chosen.extent - 1)].moments;
  const plot = element("positions"), all = positions().map(p => ({ ...p, at: inWorld(sensor, p.pose, moment).at }));
  plot.hidden = !all.length;
  if (!all.length) return;
  const keys = chosenPositions(), here = all.filter(p => keys.includes(p.key));
  const [cmin, cmax] = span(all.map(p => p.value));
  const column = axis => of => of.map(p => p.at[axis]);
  const [x, y, z] = [0, 1, 2].map(column);
  const traces = [
    { type: "scatter3d", mode: "markers", x: x(all), y: y(all), z: z(all), text: all.map(p => `${plain(nameOf(p.choice))}<br>${plain(p.pose.place)}<br>${measure().title} ${shown(p.value)}`), hovertemplate: "%{text}<extra></extra>", marker: { size: 5, color: all.map(p => p.value), colorscale: MAP, reversescale: measure().less_is_better, cmin, cmax, colorbar: colourBar() } },
    { type: "scatter3d", mode: "markers", x: x(here), y: y(here), z: z(here), hoverinfo: "skip", marker: { size: 11, color: "#d55e00", symbol: "circle-open", line: { width: 3 } } },
    lines3d(edges(data.scenes[Math.max(0, chosen.extent - 1)].room_m), { line: { color: "#9aa5b1", width: 2 } }),
  ];
  const fresh = !plot.data;
  plot.all = all;
  await Plotly.react(plot, traces, { ...LAYOUT, margin: { l: 0, r: 0, t: 30, b: 0 }, title: heading("All positions in the room"), showlegend: false, scene: { ...SCENE, uirevision: 1 } }, CONFIG);
  if (fresh) plot.on("plotly_click", event => {
    const point = event.points[0];
    if (point.curveNumber === 0) choose({ choice: plot.all[point.pointNumber].choice });
  });
}

/** The chosen score of the chosen pose at each moment, beside the best answer without a sensor. */
async function drawTimes() {
  const plot = element("times"), block = series().scores.at_moments;
  if (!plot || !block) return;
  const place = placeIn(block, chosen.choice), moving = data.scenes.filter(scene => scene.moments[1] - scene.moments[0] > 1);
  const moments = data.scenes.at(-1).moments[1];
  const at = (measure, moment) => numbers[block.begin + ((chosen.region * moments + moment) * data.measures.length + measure) * block.count + place];
  const traces = [];
  if (place >= 0) for (const scene of moving) data.measures.forEach((one, m) => {
    const steps = Array.from({ length: scene.moments[1] - scene.moments[0] }, (_, i) => i);
    const name = moving.length > 1 ? `${one.title}, ${scene.name}` : one.title;
    traces.push({ type: "scatter", mode: "lines+markers", name: plain(name), x: steps, y: steps.map(i => at(m, scene.moments[0] + i)), line: { color: COLOURS[m], width: m === chosen.measure ? 4 : 1.5, dash: ["solid", "dash", "dot", "dashdot", "longdash", "longdashdot", "2px,6px", "10px,3px"][m] } });
  });
  const title = place < 0 ? `No scores over time are kept for ${nameOf(chosen.choice)}: see results.csv` : `${nameOf(chosen.choice)} · region ${data.regions[chosen.region]}`;
  await Plotly.react(plot, traces, { ...LAYOUT, title: heading(title), xaxis: { title: { text: "snapshot" }, tickformat: "d", rangemode: "tozero" }, yaxis: { rangemode: "tozero", gridcolor: "#e3e8ed" }, legend: { orientation: "h", y: -0.25 } }, CONFIG);
}
