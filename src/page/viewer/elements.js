// Elements of the page and its colours.
const element = id => document.getElementById(id);

/** A value as it stands in tables. */
const shown = (value, digits = 3) => value === null || Number.isNaN(value) ? "–" : (Math.abs(value) < 0.5 * 10 ** -digits ? 0 : value).toFixed(digits);

/** An element with attributes and children; text is never taken for HTML. */
function made(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name === "onclick") node.addEventListener("click", value); else node.setAttribute(name, value);
  }
  node.append(...children);
  return node;
}

/** A colour of the page's style, and all of those that are numbered. */
const hue = name => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
function hues(name) {
  const all = [];
  for (let next; (next = hue(`${name}-${all.length}`)); all.push(next));
  return all;
}

/** A colour of six hexadecimal digits, and how much of what is behind it it hides, as four numbers from 0 to 1. */
const rgba = (hex, opacity = 1) => [1, 3, 5].map(i => parseInt(hex.slice(i, i + 2), 16) / 255).concat(opacity);

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
const word = (x, y, text, more) => shape("text", { x: px(x), y: px(y), ...more }, text);
