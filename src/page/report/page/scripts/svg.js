// Draws in two dimensions as SVG: elements, pictures as wide as their place, and the colours of values. Charts come drawn with the page.
/** About how wide a letter of 12 pixels is; fonts differ, so rather more. */
const GLYPH_PX = 7.6;

/** About how wide a text of 12 pixels is. */
const wide = text => [...text].length * GLYPH_PX;

/** A picture in an element, as wide as that is, with a heading. */
function picture(home, heading, height, draw) {
  const width = Math.max(240, Math.round(home.clientWidth || 640));
  const node = shape("svg", { viewBox: `0 0 ${width} ${height}`, width, height, "aria-hidden": "true" });
  node.append(...draw(width).filter(child => child !== null));
  home.replaceChildren(made("p", { class: "title" }, heading), node);
  return node;
}

/** The same colours as in figures. */
const RAMP = hues("ramp"), NO_VALUE = hue("no-value");

/** The colour of a share from 0 to 1. */
function shade(share) {
  const at = Math.max(0, Math.min(1, share)) * (RAMP.length - 1), first = Math.min(Math.floor(at), RAMP.length - 2);
  const [a, b] = [first, first + 1].map(n => rgba(RAMP[n]));
  return `#${[0, 1, 2].map(i => Math.round(255 * (a[i] + (b[i] - a[i]) * (at - first))).toString(16).padStart(2, "0")).join("")}`;
}

/** The colours of the chosen score from its smallest to its largest value, the better the brighter. */
const shades = ([low, high]) => value => Number.isNaN(value) ? NO_VALUE : shade((measure().less_is_better ? high - value : value - low) / ((high - low) || 1));

/** A bar that says which colours stand for which values. */
function colourBar([low, high], [x, y], width) {
  const steps = 32, colour = shades([low, high]);
  const patches = Array.from({ length: steps }, (_, n) => shape("rect", { x: px(x + n * width / steps), y, width: px(width / steps + 0.5), height: 8, fill: colour(low + (n + 0.5) / steps * (high - low)) }));
  return [...patches, word(x, y + 21, scored(low)), word(x + width, y + 21, scored(high), { "text-anchor": "end" }), word(x + width / 2, y + 21, measure().title, { "text-anchor": "middle" })];
}
