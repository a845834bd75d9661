// Reads what the page holds: names as JSON, numbers and voxels, all as base64 of gzip. Nothing is drawn here.
const element = id => document.getElementById(id);
/** The bytes that an element of the page holds. */
async function unpacked(id) {
  const letters = element(id).textContent.trim();
  const bytes = Uint8Array.from(atob(letters), letter => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

const data = JSON.parse(new TextDecoder().decode(await unpacked("data")));
const numbers = new Float32Array(await unpacked("numbers"));
const bytes = new Uint8Array(await unpacked("cells"));

/** Classes from their runs, as many as are wanted; there are so many kinds of them. */
function classes([begin, end], kinds, count) {
  const all = new Uint16Array(count);
  let at = 0;
  for (let i = begin; i < end;) {
    let number = 0, unit = 1, byte;
    do { byte = bytes[i++]; number += (byte & 127) * unit; unit *= 128; } while (byte > 127);
    const length = Math.floor(number / kinds);
    all.fill(number % kinds, at, at += length);
  }
  return all;
}

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
