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
  return [
    { axis: 2, at: high[2], to: ([x, y]) => [x, y], label: [middle[0], high[1]], turned: false },
    { axis: 0, at: low[0], to: at => [low[0] - down(at), at[1]], label: [low[0] - h, middle[1]], turned: true },
    { axis: 0, at: high[0], to: at => [high[0] + down(at), at[1]], label: [high[0] + h, middle[1]], turned: true },
    { axis: 1, at: low[1], to: at => [at[0], low[1] - down(at)], label: [middle[0], low[1] - h], turned: false },
    { axis: 1, at: high[1], to: at => [at[0], high[1] + down(at)], label: [middle[0], high[1] + h], turned: false },
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
  const room = sceneOf().room_m;
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
    return { title, axes: [u, v], parts: [{ whole, to: at => [at[u], at[v]] }], outlines: !onLink };
  });
  if (used.length > 1) {
    const parts = used.map(({ positions, groups, to, label, turned }) => ({ whole: positions, to, label, turned, text: groups.join(", ") }));
    found.unshift({ title: "Walls and ceiling unfolded, seen from above", room, parts, outlines: true });
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

/** How wide and high a spot is: that of the lattice where positions form one, else null. */
function latticeOf(spots) {
  const all = [...spots.values()], axis = key => [...new Set(all.map(spot => spot[key]))].sort((a, b) => a - b);
  const [xs, ys] = [axis("x"), axis("y")];
  const close = all => all.length > 1 && all[1] - all[0] <= WIDEST_M && even(all);
  const isLattice = close(xs) && close(ys) && all.length >= 0.6 * xs.length * ys.length;
  return isLattice ? [xs[1] - xs[0], ys[1] - ys[0]] : null;
}

/** The outlines of what stands in the first scene, where they come to lie on paper, and how a map names them. */
function standing({ to }) {
  return sceneOf().things.map(({ name, role, low_m, high_m }) => {
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map(n => to([0, 1, 2].map(r => n >> r & 1 ? high_m[r] : low_m[r])));
    const ends = [0, 1].map(r => [Math.min(...corners.map(at => at[r])), Math.max(...corners.map(at => at[r]))]);
    return { name, role, x: ends[0], y: ends[1] };
  });
}

/** Most pixels that a map is high. */
const HIGHEST_PX = 560;

/** Draws one map into an element; `spots` are those of its parts. */
function drawMap(home, map, spots, range, heading) {
  const lattices = spots.map(latticeOf), all = spots.flatMap(of => [...of.values()]);
  let [xs, ys] = [all.map(spot => spot.x), all.map(spot => spot.y)].map(values => span(values));
  if (map.room) {
    const [low, high] = map.room, h = high[2] - low[2];
    [xs, ys] = [[low[0] - h, high[0] + h], [low[1] - h, high[1] + h]];
  } else {
    const more = [0, 1].map(r => (lattices[0]?.[r] ?? 0.4) / 2);
    [xs, ys] = [[xs[0] - more[0], xs[1] + more[0]], [ys[0] - more[1], ys[1] + more[1]]];
  }
  const colour = shades(range), whole = home.clientWidth || 640, least = map.room ? 24 : 44;
  const room = whole - least - 24, unit = Math.min(room / (xs[1] - xs[0]), HIGHEST_PX / (ys[1] - ys[0]));
  const height = (ys[1] - ys[0]) * unit, bottom = height + 20, margin = Math.max(least, (whole - (xs[1] - xs[0]) * unit) / 2);
  const x = value => margin + (value - xs[0]) * unit, y = value => bottom - (value - ys[0]) * unit;
  const box = ([x0, x1], [y0, y1], kind, more) => shape("rect", { x: px(x(x0)), y: px(y(y1)), width: px((x1 - x0) * unit), height: px((y1 - y0) * unit), class: kind, ...more });
  const spot = (one, lattice) => {
    const size = lattice ?? [14 / unit, 14 / unit], gap = Math.min(1, size[0] * unit / 8) / unit;
    const [w, h] = size.map(metres => metres - gap);
    return box([one.x - w / 2, one.x + w / 2], [one.y - h / 2, one.y + h / 2], "spot", { fill: colour(one.p.value), title: told(one.p), onclick: () => choose({ choice: one.p.choice }) });
  };
  const draw = () => [
    ...(map.room ? [box([map.room[0][0], map.room[1][0]], ys, "face"), box(xs, [map.room[0][1], map.room[1][1]], "face")] : []),
    ...spots.flatMap((of, n) => [...of.values()].map(one => spot(one, lattices[n]))),
    ...(map.outlines ? map.parts.flatMap((part, n) => outlinesOn(part, [xs, ys], { x, y, unit, box }, n === 0)) : []),
    ...map.parts.flatMap(part => part.label ? [word(x(part.label[0]), y(part.label[1]), part.text, { "text-anchor": "middle", class: "strong halo", ...(part.turned ? { transform: `rotate(-90 ${px(x(part.label[0]))} ${px(y(part.label[1]))})` } : {}) })] : []),
    ...(map.axes ? axes(map, [xs, ys], { x, y, bottom }) : []),
    ...colourBar(range, [margin, bottom + (map.axes ? 44 : 22)], Math.min(320, room)),
    shape("g", { class: "rings" }),
  ];
  home.picture = picture(home, heading, bottom + (map.axes ? 72 : 50), draw);
  home.to = at => [x(at[0]), y(at[1])];
}

/** Metres beside a map of one plane. */
function axes({ axes: [u, v] }, [xs, ys], { x, y, bottom }) {
  const below = ticks(...xs, 6).map(value => word(x(value), bottom + 14, String(value), { "text-anchor": "middle" }));
  const beside = ticks(...ys, 5).map(value => word(x(xs[0]) - 4, y(value) + 4, String(value), { "text-anchor": "end" }));
  return [...below, ...beside, word(x(xs[1]), bottom + 30, `${NAMES[u]} in m`, { "text-anchor": "end" }), word(4, 12, `${NAMES[v]} in m`)];
}

/** Furniture, doors, robots and people on a face, as far as they lie inside the map; named once. */
function outlinesOn(part, [xs, ys], { x, y, unit, box }, isNamed) {
  const inside = ([low, high], [from, to]) => [Math.max(low, from), Math.min(high, to)];
  return standing(part).flatMap(one => {
    const [across, up] = [inside(one.x, xs), inside(one.y, ys)];
    if (across[0] >= across[1] || up[0] >= up[1]) return [];
    const isWide = (across[1] - across[0]) * unit > wide(one.name) * 0.8;
    return [box(across, up, `outline ${one.role}`), isNamed && isWide ? word(x((across[0] + across[1]) / 2), y((up[0] + up[1]) / 2) + 4, one.name, { "text-anchor": "middle", class: "halo" }) : null];
  });
}

/** Draws all maps of the chosen member. */
function drawMaps() {
  const home = element("maps"), all = maps();
  home.replaceChildren();
  home.hidden = !all.length;
  const range = span(all.flatMap(map => map.parts.flatMap(part => part.whole.map(p => p.value))));
  for (const map of all) {
    const spots = map.parts.map(bestOfEach);
    const valued = map.parts.map(part => part.whole.filter(p => !Number.isNaN(p.value)).length);
    const behind = spots.some((of, n) => valued[n] > of.size) ? " (of positions behind each other the best)" : "";
    const none = valued.every(count => !count) ? ` (no ${measure().title} here)` : "";
    const plot = home.appendChild(made("div", { role: "group", "aria-label": `Map: ${map.title}`, class: map.room ? "room" : "" }));
    plot.parts = map.parts;
    drawMap(plot, map, spots, range, map.title + behind + none);
  }
  markMaps();
}

/** Rings the chosen positions. */
function markMaps() {
  const keys = chosenPositions();
  for (const plot of element("maps").children) {
    const here = plot.parts.flatMap(({ whole, to }) => whole.filter(p => keys.includes(p.key)).map(p => plot.to(to(p.at))));
    plot.querySelector(".rings").replaceChildren(...here.map(([cx, cy]) => shape("circle", { cx: px(cx), cy: px(cy), r: 11, class: "ring" })));
  }
}
