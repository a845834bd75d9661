// Draws in two dimensions as SVG, in colours of the page's own scheme: axes, rows of bars or distributions, lines over time.
const SVG = "http://www.w3.org/2000/svg";

/** An element of a picture, as `made` makes those of the page; a title is told to whoever points at it. */
function shape(tag, { title, onclick, ...attributes } = {}, ...children) {
  const node = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) if (value !== undefined) node.setAttribute(name, value);
  if (title !== undefined) node.append(shape("title", {}, title));
  if (onclick) node.addEventListener("click", onclick);
  node.append(...children.filter(child => child !== null));
  return node;
}

/** Numbers in pictures need no more places than a screen has. */
const px = value => Number(value.toFixed(2));
const line = (x1, y1, x2, y2, kind, more) => shape("line", { x1: px(x1), y1: px(y1), x2: px(x2), y2: px(y2), class: kind, ...more });
const word = (x, y, text, more) => shape("text", { x: px(x), y: px(y), ...more }, text);

/** About how wide a letter of 12 pixels is; fonts differ, so rather more. */
const GLYPH_PX = 7.6;

/** About how wide a text of 12 pixels is, and the text cut to a width. */
const wide = text => [...text].length * GLYPH_PX;
const cut = (text, width) => wide(text) <= width ? text : `${[...text].slice(0, Math.max(1, Math.floor(width / GLYPH_PX) - 1)).join("")}…`;

/** A picture in an element, as wide as that is, with a heading. */
function picture(home, heading, height, draw) {
  const width = Math.max(240, Math.round(home.clientWidth || 640));
  const node = shape("svg", { viewBox: `0 0 ${width} ${height}`, width, height, "aria-hidden": "true" });
  node.append(...draw(width).filter(child => child !== null));
  home.replaceChildren(made("p", { class: "title" }, heading), node);
  return node;
}

/** Round numbers from `low` to `high`, about so many. */
function ticks(low, high, about) {
  const rough = (high - low) / Math.max(1, about), unit = 10 ** Math.floor(Math.log10(rough || 1));
  const step = unit * [1, 2, 5, 10].find(factor => unit * factor >= rough * 0.999);
  const all = [];
  for (let n = Math.ceil(low / step - 1e-9); n * step <= high + step * 1e-9; n++) all.push(Number((n * step).toPrecision(12)));
  return all;
}

/** A scale from numbers to pixels. */
const scale = ([low, high], [from, to]) => value => from + (value - low) / ((high - low) || 1) * (to - from);

/** An axis below a picture, with lines up through it. */
const axisBelow = (range, at, [top, bottom]) => ticks(...range, Math.abs(at(range[1]) - at(range[0])) / 70).flatMap(value => [
  line(at(value), top, at(value), bottom, "mesh"), word(at(value), bottom + 15, String(value), { "text-anchor": "middle" })]);

/**
 * Bars in rows: each with a name, parts one after the other (value, fill, title, and whether it is hatched), and what is written
 * at its end.
 */
function bars(home, heading, rows, unit) {
  const most = rows.reduce((sum, row) => Math.max(sum, row.parts.reduce((sum, part) => sum + Math.max(0, part.value ?? 0), 0)), 0) || 1;
  const high = 24, bottom = rows.length * high + 4;
  return picture(home, heading, bottom + (unit ? 38 : 22), width => {
    const left = Math.min(width * 0.42, 12 + Math.max(...rows.map(row => wide(row.name)))), room = 8 + Math.max(...rows.map(row => wide(row.text)));
    const at = scale([0, most], [left, width - room]);
    return [
      ...axisBelow([0, most], at, [0, bottom]),
      unit ? word(at(most), bottom + 32, unit, { "text-anchor": "end" }) : null,
      ...rows.flatMap((row, n) => {
        let from = 0;
        const y = n * high + 4;
        const parts = row.parts.map(({ value, fill, title, hatched }) => {
          const begin = from;
          from += Math.max(0, value ?? 0);
          return shape("rect", { x: px(at(begin)), y, width: px(at(from) - at(begin)), height: high - 8, fill, class: hatched ? "bar hatched" : "bar", title });
        });
        return [word(left - 6, y + 12, cut(row.name, left - 6), { "text-anchor": "end" }), ...parts, word(at(from) + 5, y + 12, row.text)];
      }),
    ];
  });
}

/** Words at heights, moved apart until none covers another. */
function apart(all, room) {
  const sorted = all.map((one, n) => ({ ...one, n })).sort((a, b) => a.y - b.y);
  sorted.forEach((one, i) => { if (i && one.y < sorted[i - 1].y + room) one.y = sorted[i - 1].y + room; });
  return sorted;
}

/** Lines over steps, each with its name at its end: `lines` have name, values, colour, isStrong, isDashed. */
function overSteps(home, heading, lines, unit) {
  const known = lines.flatMap(one => one.values).filter(value => value !== null && !Number.isNaN(value));
  const range = [Math.min(0, ...known), Math.max(0.01, ...known)], bottom = 250, steps = Math.max(2, ...lines.map(one => one.values.length));
  return picture(home, heading, bottom + 36, width => {
    const right = width - 10 - Math.max(...lines.map(one => wide(one.name))), x = scale([0, steps - 1], [40, Math.max(right, width * 0.5)]), y = scale(range, [bottom, 10]);
    const ends = apart(lines.map(one => ({ ...one, y: y(one.values.findLast(value => !Number.isNaN(value)) ?? 0) + 4 })), 14);
    return [
      ...ticks(...range, 5).flatMap(value => [line(40, y(value), x(steps - 1), y(value), "mesh"), word(34, y(value) + 4, String(value), { "text-anchor": "end" })]),
      ...ticks(0, steps - 1, 8).filter(Number.isInteger).map(value => word(x(value), bottom + 15, String(value), { "text-anchor": "middle" })),
      word(x(steps - 1), bottom + 31, unit, { "text-anchor": "end" }),
      ...lines.flatMap(one => {
        let open = false;
        const path = one.values.map((value, step) => { if (Number.isNaN(value)) { open = false; return ""; } const text = `${open ? "L" : "M"}${px(x(step))} ${px(y(value))}`; open = true; return text; }).join("");
        const dots = one.values.flatMap((value, step) => Number.isNaN(value) ? [] : [shape("circle", { cx: px(x(step)), cy: px(y(value)), r: one.isStrong ? 3.5 : 2, fill: one.colour, title: `${one.name}, ${unit} ${step}: ${shown(value)}` })]);
        return [shape("path", { d: path, fill: "none", stroke: one.colour, "stroke-width": one.isStrong ? 3.5 : 1.5, "stroke-dasharray": one.isDashed ? "6 4" : undefined }), ...dots];
      }),
      ...ends.map(one => word(x(steps - 1) + 8, one.y, one.name, { fill: one.colour, class: one.isStrong ? "strong" : undefined })),
    ];
  });
}

// Cividis, which people with any colour vision read alike (Nuñez, Anderton and Renslow 2018).
const CIVIDIS = ["#00204c", "#00346e", "#3c4a6b", "#5b5f6d", "#757575", "#928c78", "#b0a572", "#d1bf66", "#f3db4f", "#ffe945"];

/** The colour of a share from 0 to 1. */
function shade(share) {
  const at = Math.max(0, Math.min(1, share)) * (CIVIDIS.length - 1), first = Math.min(Math.floor(at), CIVIDIS.length - 2);
  const [a, b] = [first, first + 1].map(n => rgba(CIVIDIS[n]));
  return `#${[0, 1, 2].map(i => Math.round(255 * (a[i] + (b[i] - a[i]) * (at - first))).toString(16).padStart(2, "0")).join("")}`;
}

/** The colours of the chosen score from its smallest to its largest value, the better the brighter. */
const shades = ([low, high]) => value => Number.isNaN(value) ? "#9aa5b1" : shade((measure().less_is_better ? high - value : value - low) / ((high - low) || 1));

/** A bar that says which colours stand for which values. */
function colourBar([low, high], [x, y], width) {
  const steps = 32, colour = shades([low, high]);
  const patches = Array.from({ length: steps }, (_, n) => shape("rect", { x: px(x + n * width / steps), y, width: px(width / steps + 0.5), height: 8, fill: colour(low + (n + 0.5) / steps * (high - low)) }));
  return [...patches, word(x, y + 21, shown(low)), word(x + width, y + 21, shown(high), { "text-anchor": "end" }), word(x + width / 2, y + 21, measure().title, { "text-anchor": "middle" })];
}
