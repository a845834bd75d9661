// Makes charts live: shows those of the chosen score, marks the chosen pose in them, draws its curves over time; and positions
// in the room. What they show is in `choice.js`, how in `svg.js` and `gl.js`.

/** The score that is chosen, by its number; with a claimed share its false alarms, without which it says nothing. */
const plotted = () => [chosen.measure, measure().name === "human_claimed" ? numberOf("false_alarm") : -1].filter(m => m >= 0);
const numberOf = name => data.measures.findIndex(one => one.name === name);

/** The chosen score first, then those that are always looked at. */
const compared = () => [...new Set([...plotted(), ...data.always])];

/** The charts of a place, each of one score in one region: those that the page shows when it opens, and the others. */
const others = new DOMParser().parseFromString(new TextDecoder().decode(await unpacked("charts")), "text/html");
const chartsIn = id => [...element(id)?.children ?? [], ...others.querySelectorAll(`[data-place="${id}"] > div`)];
const charts = { distributions: chartsIn("distributions"), maxima: chartsIn("maxima") };

/** Shows the charts of some scores in the chosen region. */
function showCharts(id, measures) {
  const of = m => charts[id].find(({ dataset }) => Number(dataset.region) === chosen.region && Number(dataset.score) === m);
  element(id)?.replaceChildren(...measures.map(of));
}

/** Where a chart that holds the places of 0 and 1 has a value. */
const placed = ({ zero, one }, value) => px(Number(zero) + value * (one - zero));

/** Charts of all poses together, with the chosen one among them. */
function drawScores() {
  showCharts("distributions", compared());
  showCharts("maxima", plotted());
  const place = placeIn(series().scores.over, chosen.choice);
  for (const chart of element("distributions").children) {
    chart.querySelectorAll(".own").forEach(mark => mark.remove());
    if (place < 0) continue;
    for (const row of chart.querySelectorAll(`[data-series="${chosen.series}"]`)) {
      const value = values(Number(chart.dataset.score), Number(row.dataset.scene) + 1)[place], at = placed(row.closest("[data-zero]").dataset, value);
      if (!Number.isNaN(value)) row.after(shape("path", { d: `M${at} ${Number(row.getAttribute("y")) + 2}l6 7l-6 7l-6-7Z`, class: "own", title: `selected: ${nameOf(chosen.choice)}, ${scored(value, Number(chart.dataset.score))}` }));
    }
  }
}

/** Smallest and largest of some numbers, apart from each other. */
function span(all) {
  const known = all.filter(value => !Number.isNaN(value));
  if (!known.length) return [0, 1];
  const [low, high] = [known.reduce((a, b) => Math.min(a, b)), known.reduce((a, b) => Math.max(a, b))];
  return high > low ? [low, high] : [low - 0.01, high + 0.01];
}

/** The room of a scene, with metres along its lowest edges. */
function showRoom(stage, { room_m: [low, high], metres }) {
  stage.show("room edges", { kind: "lines", at: edges([low, high]), colour: NO_VALUE, width: 1 });
  const all = metres.flatMap((own, axis) => own.map(text => ({ at: low.with(axis, Number(text)), text: `${NAMES[axis]} ${text}` })));
  stage.show("room metres", { kind: "words", at: all.flatMap(one => one.at), words: all.map(one => one.text) });
}

/** All positions in the room, with their best scores. */
function drawPositions() {
  const plot = element("positions");
  if (!plot) return;
  const sensor = data.sensors[combination().members[chosen.member]?.sensor], [moment] = sceneOf().moments;
  // What is on a link stands where the link is at the scene's first moment.
  const all = positions().map(p => ({ ...p, at: inWorld(sensor, p.pose, moment).at }));
  plot.hidden = !all.length;
  if (!all.length) return;
  if (!plot.stage) {
    const view = made("div", { class: "view" });
    plot.replaceChildren(made("p", { class: "title" }, "All positions in the room"), view);
    plot.stage = stage(view, "All positions in the room, as points.") ?? "none";
    if (plot.stage === "none") view.append("This browser has no WebGL; the maps above show the same.");
    plot.bar = plot.appendChild(made("div", {}));
  }
  const range = span(all.map(p => p.value)), colour = shades(range);
  picture(plot.bar, "", 26, width => colourBar(range, [10, 0], Math.min(320, width - 20)));
  if (plot.stage === "none") return;
  const keys = chosenPositions(), here = all.filter(p => keys.includes(p.key));
  plot.stage.show("all", { kind: "points", at: all.flatMap(p => p.at), colours: all.map(p => colour(p.value)), width: 5, words: n => told(all[n]), heard: n => choose({ choice: all[n].choice }) });
  plot.stage.show("chosen", { kind: "points", at: here.flatMap(p => p.at), colour: hue("picked"), width: 11, ring: true });
  const scene = sceneOf();
  showRoom(plot.stage, scene);
  if (plot.scene !== scene) plot.stage.face(scene.room_m);
  plot.scene = scene;
}

/** What pointing at a position tells. */
const told = p => `${nameOf(p.choice)}\n${p.pose.place}\n${measure().title} ${scored(p.value)}`;

/** The compared scores of the chosen pose at each moment of scenes that move, beside the best answer without a sensor. */
function drawTimes() {
  const home = element("times"), block = series().scores.at_moments;
  if (!home || !block) return;
  const place = placeIn(block, chosen.choice), moments = data.scenes.at(-1).moments[1];
  const at = (m, moment) => place < 0 ? NaN : numbers[block.begin + ((chosen.region * moments + moment) * data.measures.length + m) * block.count + place];
  for (const chart of home.children) {
    const n = Number(chart.dataset.scene), { name, moments: [begin, end] } = data.scenes[n], axes = chart.querySelector("[data-first]").dataset;
    const steps = Array.from({ length: end - begin }, (_, i) => begin + i), floor = toBeat(chosen.measure, n + 1);
    const lines = compared().map(m => ({ m, name: data.measures[m].title, values: steps.map(moment => at(m, moment)), colour: hue(`series-${m}`), isChosen: m === chosen.measure }));
    if (floor) lines.push({ m: chosen.measure, name: floor.name, values: steps.map(() => floor.value), colour: hue("no-sensor"), isDashed: true });
    const none = place < 0 ? ": no scores over time are kept, see results.csv" : "";
    chart.querySelector(".title").textContent = `${nameOf(chosen.choice)} · region ${data.regions[chosen.region]} · scene ${name}${none}`;
    chart.querySelector(".lines").replaceChildren(...lines.flatMap(line => curve(line, axes)));
    chart.querySelector(".legend").replaceChildren(...lines.map(({ name, colour }) => {
      const swatch = made("i");
      swatch.style.background = colour;
      return made("li", {}, swatch, name);
    }));
  }
}

/** A line over the snapshots, broken where there is no value, and a point for each. */
function curve({ m, name, values, colour, isChosen, isDashed }, axes) {
  const x = step => px(Number(axes.first) + step * (axes.second - axes.first));
  const points = values.map((value, step) => Number.isNaN(value) ? null : [x(step), placed(axes, value)]);
  const path = points.map((point, step) => point ? `${points[step - 1] ? "L" : "M"}${point.join(" ")}` : "").join("");
  const dots = points.flatMap((point, step) => point ? [shape("circle", { cx: point[0], cy: point[1], r: isChosen ? 3.5 : 2, fill: colour, title: `${name}, snapshot ${step}: ${scored(values[step], m)}` })] : []);
  return [shape("path", { d: path, class: "curve", stroke: colour, "stroke-width": isChosen ? 3.5 : undefined, "stroke-dasharray": isDashed ? "6 4" : undefined }), ...dots];
}
