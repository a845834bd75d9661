// Distributions, maxima, positions in the room, scores over time. What they show is in `choice.js`, how in `svg.js` and `gl.js`.
const NAMES = ["x", "y", "z"];

/** The score that is chosen, by its number; with a claimed share its false alarms, without which it says nothing. */
const plotted = () => [chosen.measure, measure().name === "human_claimed" ? numberOf("false_alarm") : -1].filter(m => m >= 0);
const numberOf = name => data.measures.findIndex(one => one.name === name);

/** The chosen score first, then those that are always looked at. */
const compared = () => [...new Set([...plotted(), ...["f1", "kappa", "human_seen", "parts_detected"].map(numberOf)])];

const colourOfSeries = n => COLOURS[n % COLOURS.length];

/** Plots of all poses together, region by region. */
function drawScores() {
  const several = name => data.regions.length > 1 ? ` · region ${name}` : "";
  const home = element("distributions");
  home.replaceChildren();
  data.regions.forEach((region, r) => compared().forEach(m => {
    const plot = home.appendChild(made("div", { role: "img", "aria-label": `${data.measures[m].title} in region ${region}` }));
    drawDistributions(plot, `${data.measures[m].title}${several(region)}`, r, m);
  }));
  element("maxima")?.replaceChildren();
  if (element("maxima")) data.regions.forEach((region, r) => plotted().forEach(m => {
    const plot = element("maxima").appendChild(made("div", { role: "img", "aria-label": `Largest ${data.measures[m].title} in region ${region}` }));
    drawMaxima(plot, `Largest ${data.measures[m].title}${several(region)}`, r, m);
  }));
}

/** As many choices are drawn one by one; of more, how many there are in each part of the range. */
const MOST_SINGLE = 300;

/** The values of a score of a series in a scene and region; null where the page does not hold all of them or there are many. */
function single(m, r, scene, of) {
  const block = of.scores.over;
  if (block.choices || block.count > MOST_SINGLE) return null;
  return values(m, scene + 1, of, r);
}

/** Rows of one score: for each scene and series a distribution with its quartiles, beside the bound and the best trivial answer. */
function drawDistributions(home, heading, r, m) {
  const low = [], rows = [];
  let y = 20;
  for (const [scene, { name }] of data.scenes.entries()) {
    const first = y;
    if (data.scenes.length > 1) { low.push({ scene: name, y: y + 12 }); y += 18; }
    data.series.forEach((of, n) => { rows.push({ scene, of, n, y, spread: data.distributions[r][m][scene][n] }); y += 20; });
    const all = data.baselines[r][scene + 1], bound = all.at(-1)[1][m], best = toBeat(m, scene + 1, r);
    low.push({ from: first, to: y, bound, best, isFirst: scene === 0 });
    y += 8;
  }
  if (!rows.some(row => row.spread)) return home.replaceChildren(made("p", { class: "title" }, heading), made("p", { class: "none" }, "No choice of poses has a value here."));
  const known = rows.flatMap(row => row.spread ? [row.spread.five[0], row.spread.five[4]] : []).concat(low.flatMap(one => [one.bound, one.best?.value]).filter(value => value !== null && value !== undefined));
  const range = [Math.min(0, ...known), Math.max(0.01, ...known)];
  return picture(home, heading, y + 22, width => {
    const left = Math.min(width * 0.36, 12 + Math.max(...data.series.map(of => wide(of.title)))), at = scale(range, [left, width - 14]);
    return [
      ...axisBelow(range, at, [18, y]),
      ...low.flatMap(one => one.scene !== undefined ? [word(4, one.y, `scene ${one.scene}`, { class: "strong" })] : mark(one, at, width)),
      ...rows.flatMap(row => [word(left - 6, row.y + 14, cut(row.of.title, left - 6), { "text-anchor": "end" }), ...spreadOf(row, at, r, m)]),
    ];
  });
}

/** The upper bound and the best answer without a sensor as lines across the rows of a scene, named above the first. */
function mark({ from, to, bound, best, isFirst }, at, width) {
  const named = (x, text, y) => isFirst ? word(Math.min(Math.max(x, wide(text) / 2 + 2), width - wide(text) / 2 - 2), y, text, { "text-anchor": "middle", class: "soft" }) : null;
  const found = [];
  const meet = bound !== null && best && Math.abs(at(bound) - at(best.value)) < (wide("upper bound") + wide(best.name)) / 2 + 12;
  if (bound !== null) found.push(line(at(bound), from, at(bound), to, "bound"), named(at(bound) + (meet ? (wide(best.name) + 16) / 2 : 0), "upper bound", 13));
  if (best) found.push(line(at(best.value), from, at(best.value), to, "floor"), named(at(best.value) - (meet ? (wide("upper bound") + 16) / 2 : 0), best.name, 13));
  return found;
}

/** A row's choices, its quartiles, and the chosen one among them. */
function spreadOf({ scene, of, n, y, spread }, at, r, m) {
  if (!spread) return [];
  const [min, lower, median, upper, max] = spread.five, colour = colourOfSeries(n), middle = y + 10;
  const told = `${of.title}, ${data.scenes[scene].name}: ${shown(min)} to ${shown(max)}, half of all from ${shown(lower)} to ${shown(upper)}, median ${shown(median)}`;
  const each = single(m, r, scene, of), parts = [];
  if (each) {
    const path = Array.from(each).filter(value => !Number.isNaN(value)).map(value => `M${px(at(value))} ${y + 4}v12`).join("");
    parts.push(shape("path", { d: path, stroke: colour, class: "strip" }));
  } else {
    // Roots, so that the few best are seen beside the many that see nothing.
    const most = Math.sqrt(Math.max(...spread.bins)), step = (max - min) / spread.bins.length || 0.002;
    const height = count => px(y + 17 - 15 * Math.sqrt(count) / most);
    const path = spread.bins.map((count, i) => `L${px(at(min + i * step))} ${height(count)}L${px(at(min + (i + 1) * step))} ${height(count)}`).join("");
    parts.push(shape("path", { d: `M${px(at(min))} ${y + 17}${path}L${px(at(max))} ${y + 17}Z`, fill: colour, class: "hill" }));
  }
  parts.push(line(at(lower), each ? middle : y + 18, at(upper), each ? middle : y + 18, "half", { stroke: colour }), line(at(median), y + 2, at(median), y + 19, "median"));
  parts.push(shape("rect", { x: px(at(min)), y, width: px(Math.max(2, at(max) - at(min))), height: 20, class: "feel", title: told }));
  const place = of === series() && r === chosen.region ? placeIn(of.scores.over, chosen.choice) : -1;
  const own = place < 0 ? NaN : values(m, scene + 1, of, r)[place];
  if (!Number.isNaN(own)) parts.push(shape("path", { d: `M${px(at(own))} ${y + 3}l6 7l-6 7l-6 -7Z`, class: "own", title: `selected: ${nameOf(chosen.choice)}, ${shown(own)}` }));
  return parts;
}

/** Bars of the maxima of combinations by a score, and what part of the full set's they are. */
function drawMaxima(home, heading, r, m) {
  const maxima = data.maxima[r][m], full = data.full_set === null ? null : maxima[data.full_set];
  const rows = data.combinations.map(({ name }, i) => {
    const value = maxima[i], part = full && value !== null ? ` · ${Math.round(100 * value / full)} %` : "";
    return { name, text: shown(value) + part, parts: [{ value, fill: COLOURS[i === data.full_set ? 1 : 0], title: `${name}: ${shown(value)}` }] };
  });
  bars(home, heading, rows);
}

/** Smallest and largest of some numbers, apart from each other. */
function span(all) {
  const known = all.filter(value => !Number.isNaN(value));
  if (!known.length) return [0, 1];
  const [low, high] = [known.reduce((a, b) => Math.min(a, b)), known.reduce((a, b) => Math.max(a, b))];
  return high > low ? [low, high] : [low - 0.01, high + 0.01];
}

/** Lines along the edges of a box, as pairs of places. */
function edges([low, high]) {
  const corner = n => [0, 1, 2].map(axis => n >> axis & 1 ? high[axis] : low[axis]);
  const found = [];
  for (let n = 0; n < 8; n++) for (let axis = 0; axis < 3; axis++) if (!(n >> axis & 1)) found.push(...corner(n), ...corner(n | 1 << axis));
  return found;
}

/** A box with metres along its lowest edges, under names that begin so. */
function showBox(stage, begin, [low, high]) {
  stage.show(`${begin}edges`, { kind: "lines", at: edges([low, high]), colour: "#9aa5b1", width: 1 });
  const at = [], words = [];
  for (let axis = 0; axis < 3; axis++) for (const value of ticks(low[axis], high[axis], 4)) {
    at.push(...[0, 1, 2].map(r => r === axis ? value : low[r]));
    words.push(`${NAMES[axis]} ${value}`);
  }
  stage.show(`${begin}metres`, { kind: "words", at, words });
}

/** All positions in the room, with their best scores. */
function drawPositions() {
  const plot = element("positions"), sensor = data.sensors[combination().members[chosen.member]?.sensor], [moment] = sceneOf().moments;
  // What is on a link stands where the link is at the scene's first moment.
  const all = positions().map(p => ({ ...p, at: inWorld(sensor, p.pose, moment).at }));
  plot.hidden = !all.length;
  if (!all.length) return;
  if (!plot.stage) {
    const view = made("div", { class: "view" });
    plot.replaceChildren(made("p", { class: "title" }, "All positions in the room"), view);
    plot.stage = stage(view, "All positions in the room, as points") ?? "none";
    if (plot.stage === "none") view.append("This browser has no WebGL; the maps above show the same.");
    plot.bar = plot.appendChild(made("div", {}));
  }
  const range = span(all.map(p => p.value)), colour = shades(range);
  picture(plot.bar, "", 26, width => colourBar(range, [10, 0], Math.min(320, width - 20)));
  if (plot.stage === "none") return;
  const keys = chosenPositions(), here = all.filter(p => keys.includes(p.key));
  const { room_m: room } = sceneOf();
  plot.stage.show("all", { kind: "points", at: all.flatMap(p => p.at), colours: all.map(p => colour(p.value)), width: 5, words: n => told(all[n]), heard: n => choose({ choice: all[n].choice }) });
  plot.stage.show("chosen", { kind: "points", at: here.flatMap(p => p.at), colour: "#d55e00", width: 11, ring: true });
  showBox(plot.stage, "room ", room);
  if (plot.room !== room) plot.stage.face(room);
  plot.room = room;
}

/** What pointing at a position tells. */
const told = p => `${nameOf(p.choice)}\n${p.pose.place}\n${measure().title} ${shown(p.value)}`;

/** The compared scores of the chosen pose at each moment of scenes that move, beside the best answer without a sensor. */
function drawTimes() {
  const home = element("times"), block = series().scores.at_moments;
  if (!home || !block) return;
  const place = placeIn(block, chosen.choice), moments = data.scenes.at(-1).moments[1];
  const at = (m, moment) => numbers[block.begin + ((chosen.region * moments + moment) * data.measures.length + m) * block.count + place];
  const moving = data.scenes.map((scene, n) => ({ ...scene, n })).filter(({ moments: [begin, end] }) => end - begin > 1);
  if (place < 0) return home.replaceChildren(made("p", {}, `No scores over time are kept for ${nameOf(chosen.choice)}: see results.csv.`));
  home.replaceChildren(...moving.map(({ name, moments: [begin, end], n }) => {
    const plot = made("div", { role: "img", "aria-label": `Scores over time in scene ${name}` });
    requestAnimationFrame(() => {
      const steps = Array.from({ length: end - begin }, (_, i) => begin + i), floor = toBeat(chosen.measure, n + 1);
      const lines = compared().map(m => ({ name: data.measures[m].title, values: steps.map(moment => at(m, moment)), colour: COLOURS[m], isStrong: m === chosen.measure }));
      if (floor) lines.push({ name: floor.name, values: steps.map(() => floor.value), colour: "#8a8a8a", isDashed: true });
      overSteps(plot, `${nameOf(chosen.choice)} · region ${data.regions[chosen.region]} · scene ${name}`, lines, "snapshot");
    });
    return plot;
  }));
}
