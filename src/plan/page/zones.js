// What curtains, mats and scanners guard: drawn from above, moved and resized as boxes are, and as numbers.

/** A sensor's frame from above: its place, and its own x and y there. One without poses has the world's. */
function levelFrame(at) {
  if (!at) return { origin: [0, 0, 0], x: [1, 0], y: [0, 1] };
  const ahead = turnedBy(at, [1, 0, 0]), up = turnedBy(at, [0, 0, 1]), level = Math.hypot(ahead[0], ahead[1]);
  const x = level < 1e-9 ? [1, 0] : [ahead[0] / level, ahead[1] / level], isOver = up[2] < -1e-9;
  return { origin: at.position_m, x, y: isOver ? [x[1], -x[0]] : [-x[1], x[0]] };
}
const outOf = ({ origin, x, y }, [u, v]) => [0, 1].map(axis => origin[axis] + x[axis] * u + y[axis] * v);
const into = ({ origin, x, y }, [a, b]) => [x, y].map(([p, q]) => p * (a - origin[0]) + q * (b - origin[1]));

const isThin = ({ min_m, max_m }) => [0, 1].findIndex(axis => max_m[axis] - min_m[axis] < 0.25);
const rectangle = ([x0, y0], [x1, y1]) => [[x0, y0], [x1, y0], [x1, y1], [x0, y1]];

/** The shape of a sensor, also while it is dragged. */
const shapeOf = sensor => plan.zone?.sensor === sensor.name ? plan.zone.shape : sensor.shape;

/** The parts of a shape: a name, corners from above in the sensor's frame, heights, and which handles it has. */
function partsOf(shape) {
  if (shape.shape === "pad") return [{ part: "size", corners: rectangle([0, 0], shape.size_m), z_m: [0, 0], handles: [{ at: shape.size_m, sides: [1, 1] }] }];
  if (shape.shape === "field") return [{ part: "field", corners: shape.polygon_m, z_m: [0, 0], handles: shape.polygon_m.map((at, corner) => ({ at, corner })) }];
  return ["zone", "box"].map(part => {
    const { min_m, max_m } = shape[part], thin = isThin(shape[part]), across = [0, 1].find(axis => axis !== thin), middle = times(plus(min_m, max_m), 0.5);
    const ends = thin >= 0 && part === "box";
    const handles = ends ? [0, 1].map(end => ({ at: middle.slice(0, 2).with(across, [min_m, max_m][end][across]), sides: [null, null].with(across, end) })) : [[0, 0], [0, 1], [1, 0], [1, 1]].map(sides => ({ at: sides.map((side, axis) => [min_m, max_m][side][axis]), sides }));
    return { part, corners: rectangle(min_m, max_m), z_m: [min_m[2], max_m[2]], handles };
  });
}

/** All shapes of placed sensors. */
function zonesNow() {
  return placed().flatMap((one, index) => {
    const sensor = sensorOf(one), at = poseNow(index);
    if (!sensor?.shape || !at && !sensor.is_fixed) return [];
    const frame = levelFrame(at);
    return [{ index, sensor, frame, parts: partsOf(shapeOf(sensor)) }];
  });
}

/** Zones from above; those of the chosen sensor have handles. A curtain without poses is dragged by its letter. */
function zoneShapes({ x, y }) {
  const screen = (frame, place) => { const [a, b] = outOf(frame, place); return [px(x(a)), px(y(b))]; };
  const all = layerOf("view").isOn ? zonesNow().filter(({ index }) => planner.dead !== index) : [];
  return all.flatMap(({ index, sensor, frame, parts }) => {
    const isChosen = index === planner.selected && planner.object === null, can = mayEdit();
    const bodies = parts.map(({ part, corners }) => shape("polygon", { points: corners.map(corner => screen(frame, corner).join()).join(" "), class: `zone of-${part}${isChosen ? " chosen" : ""}`, title: `${letterAt(index)} ${sensor.name}` }));
    const handles = isChosen && can ? parts.flatMap(({ part, handles }) => handles.map((handle, n) => {
      const [cx, cy] = screen(frame, handle.at), node = shape("rect", { x: cx - 4.5, y: cy - 4.5, width: 9, height: 9, class: "corner of-zone", id: `zone-${part}-${n}`, title: `Drag to resize the ${part === "size" ? "mat" : part} of ${sensor.name}` });
      node.zoned = { index, sensor, frame, part, handle };
      return node;
    })) : [];
    return [...bodies, ...handles];
  });
}
function zoneBadges({ x, y }) {
  return zonesNow().filter(({ sensor }) => sensor.is_fixed).map(({ index, sensor, frame }) => {
    const { min_m, max_m } = shapeOf(sensor).box, [a, b] = outOf(frame, times(plus(min_m, max_m), 0.5)), [cx, cy] = [px(x(a)), px(y(b))];
    const look = `badge${index === planner.selected && planner.object === null ? " chosen" : ""}${problemOf(index) ? " bad" : ""}${planner.dead === index ? " dead" : ""}`;
    const badge = shape("g", { class: look, title: wordsOf(index) }, shape("circle", { cx, cy, r: 11.5 }), word(cx, cy + 4.5, letterAt(index), { "text-anchor": "middle", class: "letter" }));
    badge.zoned = { index, sensor, frame, part: null };
    return badge;
  });
}

/** Moves a curtain with its zone, or one handle of a shape, to 5 cm. */
function moveZone({ sensor, frame, part, handle }, [from, to], event) {
  const step = event.altKey ? 0.01 : 0.05, near = value => Math.round(value / step) * step, by = minus([...into(frame, to), 0], [...into(frame, from), 0]).map(near), { shape } = sensor;
  const next = structuredClone(shape);
  if (part === null) for (const one of ["box", "zone"]) for (const axis of [0, 1]) for (const end of ["min_m", "max_m"]) next[one][end][axis] = rounded(shape[one][end][axis] + by[axis], 3);
  else if (part === "field") next.polygon_m[handle.corner] = handle.at.map((value, axis) => rounded(value + by[axis], 3));
  else if (part === "size") next.size_m = shape.size_m.map((value, axis) => Math.max(step, rounded(value + by[axis], 3)));
  else for (const axis of [0, 1]) {
    const side = handle.sides[axis], { min_m, max_m } = next[part];
    if (side === 0) min_m[axis] = Math.min(rounded(min_m[axis] + by[axis], 3), rounded(max_m[axis] - step, 3));
    if (side === 1) max_m[axis] = Math.max(rounded(max_m[axis] + by[axis], 3), rounded(min_m[axis] + step, 3));
  }
  plan.zone = { sensor: sensor.name, shape: next };
  ["zone"].forEach(tell);
}
async function commitZone() {
  const { zone } = plan;
  if (!zone) return;
  await edit({ edit: "set_sensor_shape", sensor: zone.sensor, ...zone.shape });
  if (plan.zone === zone) { plan.zone = null; tell("zone"); }
}

/** The zones in the view, as lines. */
function showZones() {
  const { stage } = scene, isShown = layerOf("view").isOn;
  stage.clear("zone");
  zonesNow().forEach(({ index, frame, parts }) => {
    if (planner.dead === index) return;
    const isChosen = index === planner.selected, [, , height] = frame.origin;
    parts.forEach(({ part, corners, z_m }) => {
      const at = z => corners.map(corner => [...outOf(frame, corner), height + z]), [low, high] = z_m.map(at), round = ring => ring.flatMap((place, n) => [...place, ...ring[(n + 1) % ring.length]]);
      const lines = [...round(low), ...(z_m[0] === z_m[1] ? [] : [...round(high), ...low.flatMap((place, n) => [...place, ...high[n]])])];
      stage.show(`zone ${index} ${part}`, { kind: "lines", at: lines, colour: isChosen ? hue("picked") : hue("sensors"), opacity: part === "zone" ? 0.5 : 0.95, width: part === "box" ? 2 : 1.3, isShown });
    });
  });
}

/** What a sensor guards as rows of numbers: words, the numbers, their names, and the shape with other ones. */
function shapeRows(shape) {
  if (shape.shape === "pad") return [{ words: "Size along and across", names: ["along", "across"], values: shape.size_m, put: size_m => ({ ...shape, size_m }) }];
  if (shape.shape === "field") return shape.polygon_m.map((corner, n) => ({ words: `Corner ${n + 1} of the field`, names: ["x", "y"], values: corner, put: values => ({ ...shape, polygon_m: shape.polygon_m.with(n, values) }) }));
  return ["box", "zone"].flatMap(part => [["min_m", "from"], ["max_m", "to"]].map(([end, word]) => ({ words: `${part === "box" ? "Curtain" : "Zone"} ${word}`, names: NAMES, values: shape[part][end], put: values => ({ ...shape, [part]: { ...shape[part], [end]: values } }) })));
}

/** The numbers of the chosen sensor's shape. */
function showShape() {
  const one = placed()[planner.selected], sensor = one && sensorOf(one), home = element("shape"), rows = sensor?.shape ? shapeRows(shapeOf(sensor)) : [];
  home.hidden = !rows.length;
  const key = rows.map(({ words }) => words).join("\n");
  if (home.dataset.rows !== key) {
    home.dataset.rows = key;
    home.replaceChildren(...rows.map(({ words, names }, row) => made("fieldset", {}, made("legend", {}, `${words} (m)`), ...names.map((name, n) => {
      const input = made("input", { id: `shape-${row}-${n}`, type: "number", step: "any", inputmode: "decimal", "aria-label": `${words}: ${name} in metres` });
      input.addEventListener("change", () => typeShape(row, n, input));
      return input;
    }))));
  }
  rows.forEach(({ values }, row) => values.forEach((value, n) => {
    const input = element(`shape-${row}-${n}`);
    input.disabled = !mayEdit();
    if (document.activeElement !== input || plan.zone) input.value = rounded(value, 3);
  }));
}
function typeShape(row, n, input) {
  const sensor = sensorOf(placed()[planner.selected]), { values, put } = shapeRows(sensor.shape)[row], value = Number(input.value.replace(",", "."));
  if (input.value.trim() === "" || !Number.isFinite(value)) { showShape(); return; }
  if (Math.abs(rounded(values[n], 3) - value) < 1e-9) return;
  edit({ edit: "set_sensor_shape", sensor: sensor.name, ...put(values.with(n, value)) }).then(showShape);
}

function makeZones() {
  on("state selected zone connection", showShape);
  if (scene.stage) on("state selected draft zone dead layers", showZones);
}
