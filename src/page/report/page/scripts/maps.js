// Maps of the placements: where places come to lie on paper is in the data (walls and ceiling of the room unfolded into one,
// other groups of positions each in their own); here they get their size on the screen and the colours of the chosen score.

/** Maps to draw: those of the chosen member's sensor, in each part the best of each spot and the outlines of what stands there. */
function maps(found) {
  const sensor = data.sensors[combination().members[chosen.member]?.sensor];
  if (!sensor) return [];
  const { maps: number, covered } = sensor.maps.scenes[data.scenes.indexOf(sceneOf())];
  return sensor.maps.maps[number].map(({ parts, title, ...map }, n) => ({
    ...map,
    title: sensor.on ? `${title}, in the frame of ${frameOf(sensor)}` : title,
    parts: parts.map((part, p) => ({ ...part, ...bestOfSpots(part, found), things: covered[n][p].map((ends, thing) => ({ ...sceneOf().things[thing], ends })) })),
  })).filter(map => map.parts.some(part => part.count));
}

/** Of a part's spots those that have a score, each with its best choice, and how many places and spots there are. */
function bestOfSpots({ spots }, found) {
  const best = [], valued = new Set();
  let count = 0;
  for (const [at, candidates] of spots) {
    const here = candidates.map(candidate => found.get(candidate)).filter(one => one);
    count += here.length;
    const known = here.filter(one => !Number.isNaN(one.value));
    known.forEach(one => valued.add(one.key));
    if (known.length) best.push({ at, p: known.reduce((a, b) => isBetter(b.value, a.value) ? b : a) });
  }
  return { best, count, valued: valued.size };
}

/** Most pixels that a map is high. */
const HIGHEST_PX = 560;

/** Draws one map into an element. */
function drawMap(home, map, range, heading) {
  const [xs, ys] = [0, 1].map(r => map.ends.map(corner => corner[r])), isRoom = !map.axes;
  const colour = shades(range), whole = home.clientWidth || 640, least = isRoom ? 24 : 44;
  const room = whole - least - 24, unit = Math.min(room / (xs[1] - xs[0]), HIGHEST_PX / (ys[1] - ys[0]));
  const height = (ys[1] - ys[0]) * unit, bottom = height + 20, margin = Math.max(least, (whole - (xs[1] - xs[0]) * unit) / 2);
  const x = value => margin + (value - xs[0]) * unit, y = value => bottom - (value - ys[0]) * unit;
  const box = ([x0, x1], [y0, y1], kind, more) => shape("rect", { x: px(x(x0)), y: px(y(y1)), width: px((x1 - x0) * unit), height: px((y1 - y0) * unit), class: kind, ...more });
  const spot = ({ at: [across, up], p }, lattice) => {
    const size = lattice ?? [14 / unit, 14 / unit], gap = Math.min(1, size[0] * unit / 8) / unit;
    const [w, h] = size.map(metres => (metres - gap) / 2);
    return box([across - w, across + w], [up - h, up + h], "spot", { fill: colour(p.value), title: told(p), onclick: () => choose({ choice: p.choice }) });
  };
  const [low, high] = map.flat;
  const draw = () => [
    ...(isRoom ? [box([low[0], high[0]], ys, "face"), box(xs, [low[1], high[1]], "face")] : []),
    ...map.parts.flatMap(part => part.best.map(one => spot(one, part.size))),
    ...map.parts.flatMap((part, n) => outlinesOn(part, [xs, ys], { x, y, unit, box }, n === 0)),
    ...map.parts.flatMap(({ label }) => label ? [word(x(label.at[0]), y(label.at[1]), label.text, { "text-anchor": "middle", class: "strong halo", ...(label.is_turned ? { transform: `rotate(-90 ${px(x(label.at[0]))} ${px(y(label.at[1]))})` } : {}) })] : []),
    ...(isRoom ? [] : axes(map, [xs, ys], { x, y, bottom })),
    ...colourBar(range, [margin, bottom + (isRoom ? 22 : 44)], Math.min(320, room)),
    shape("g", { class: "rings" }),
  ];
  home.picture = picture(home, heading, bottom + (isRoom ? 50 : 72), draw);
  home.to = ([across, up]) => [x(across), y(up)];
}

/** Metres beside a map of one plane. */
function axes({ axes: [u, v], metres: [across, up] }, [xs, ys], { x, y, bottom }) {
  const below = across.map(text => word(x(Number(text)), bottom + 14, text, { "text-anchor": "middle" }));
  const beside = up.map(text => word(x(xs[0]) - 4, y(Number(text)) + 4, text, { "text-anchor": "end" }));
  return [...below, ...beside, word(x(xs[1]), bottom + 30, `${NAMES[u]} in m`, { "text-anchor": "end" }), word(4, 12, `${NAMES[v]} in m`)];
}

/** Furniture, doors, robots and people on a part, as far as they lie inside the map; named once. */
function outlinesOn({ things }, [xs, ys], { x, y, unit, box }, isNamed) {
  const inside = ([low, high], [from, to]) => [Math.max(low, from), Math.min(high, to)];
  return things.flatMap(({ name, role, ends: [low, high] }) => {
    const [across, up] = [inside([low[0], high[0]], xs), inside([low[1], high[1]], ys)];
    if (across[0] >= across[1] || up[0] >= up[1]) return [];
    const isWide = (across[1] - across[0]) * unit > wide(name) * 0.8;
    return [box(across, up, `outline ${role}`), isNamed && isWide ? word(x((across[0] + across[1]) / 2), y((up[0] + up[1]) / 2) + 4, name, { "text-anchor": "middle", class: "halo" }) : null];
  });
}

/** Why the recommended place is not the best of the map, if it is not. */
function drawMapNote(found) {
  const home = element("map-note"), { series: of, choice, why } = data.recommended ?? {};
  const own = chosen.series === of ? values()[placeIn(series().scores.over, choice)] ?? NaN : NaN;
  const best = positions(found).reduce((best, one) => best && !isBetter(one.value, best.value) ? best : one, null);
  home.hidden = Number.isNaN(own) || !best || !isBetter(best.value, own);
  if (home.hidden) return;
  const where = `${measure().title} in region ${data.regions[chosen.region]}, ${data.scenes.length > 1 ? extents[chosen.extent] : extents[1]}`;
  home.textContent = `The recommended place is not the best of this map, which shows ${where}: ${nameOf(choice)} has ${scored(own)}, ${nameOf(best.choice)} ${scored(best.value)}. It is ${why}.`;
}

/** Draws all maps of the chosen member. */
function drawMaps() {
  const home = element("maps");
  if (!home) return;
  const found = bestOfCandidates(), all = maps(found);
  home.replaceChildren();
  home.hidden = !all.length;
  const range = span(positions(found).map(p => p.value));
  for (const map of all) {
    const behind = map.parts.some(part => part.valued > part.best.length) ? " (of positions behind each other the best)" : "";
    const none = map.parts.every(part => !part.best.length) ? ` (no ${measure().title} here)` : "";
    const plot = home.appendChild(made("div", { role: "group", "aria-label": `Map: ${map.title}`, class: map.axes ? "" : "room" }));
    plot.parts = map.parts;
    drawMap(plot, map, range, map.title + behind + none);
  }
  markMaps(found);
}

/** Rings the chosen positions. */
function markMaps(found = bestOfCandidates()) {
  const own = candidates(chosen.choice)[chosen.member] ?? [];
  if (!element("maps")) return;
  drawMapNote(found);
  for (const plot of element("maps").children) {
    const here = plot.parts.flatMap(({ spots }) => spots.filter(([, there]) => there.some(candidate => own.includes(candidate))).map(([at]) => plot.to(at)));
    plot.querySelector(".rings").replaceChildren(...here.map(([cx, cy]) => shape("circle", { cx: px(cx), cy: px(cy), r: 11, class: "ring" })));
  }
}
