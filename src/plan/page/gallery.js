// Shows the templates. A click writes the files of one, and the same address then shows its planner.
const element = id => document.getElementById(id);
const token = location.hash.replace(/^#(token=)?/, "");

/** A new element with attributes and contents. */
function made(name, attributes = {}, ...contents) {
  const one = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) one.setAttribute(key, value);
  one.append(...contents);
  return one;
}

/** Sends a request; throws an error with the program's words. */
async function send(path, body) {
  const headers = { "X-Perirobot-Token": token, ...(body ? { "Content-Type": "application/json" } : {}) };
  let answer;
  try {
    answer = await fetch(path, { method: body ? "POST" : "GET", headers, body: body && JSON.stringify(body), cache: "no-store" });
  } catch { throw new Error("The planner has ended. Start it again, and open the address that it prints."); }
  if (!answer.ok) throw new Error((await answer.json().catch(() => ({}))).error ?? `The planner answered ${answer.status}.`);
  return answer;
}
function complain(error) {
  element("complaint").textContent = error?.message ?? "";
  element("complaint").hidden = !error;
}

/** Writes a template and goes on to its planner. */
async function open(template, folder) {
  const buttons = [...document.querySelectorAll("button")];
  buttons.forEach(button => { button.disabled = true; });
  complain(null);
  try {
    await send("/open", { template, folder });
    // The fragment has the token, so the address stays.
    location.reload();
  } catch (error) {
    complain(error);
    buttons.forEach(button => { button.disabled = false; });
  }
}

function card({ name, about, to_improve: toImprove }) {
  const sketch = made("div", { class: "sketch" }), title = `${name[0].toUpperCase()}${name.slice(1)}`;
  const folder = made("input", { id: `folder-${name}`, value: `./${name}`, spellcheck: "false", autocomplete: "off" });
  const form = made("form", {}, made("label", {}, "Folder", folder), made("button", { class: "primary", id: `open-${name}` }, "Plan this cell"));
  form.addEventListener("submit", event => { event.preventDefault(); open(name, folder.value.trim()); });
  const one = made("article", { id: `template-${name}` }, sketch, made("h2", {}, title), made("p", {}, `${about}.`), made("p", { class: "improve" }, toImprove), form);
  return { one, sketch, name };
}

/** The floor plan of a template, as the program draws it. */
async function showSketch({ sketch, name }) {
  const text = await (await send(`/sketch?template=${name}`)).text();
  sketch.replaceChildren(document.importNode(new DOMParser().parseFromString(text, "image/svg+xml").documentElement, true));
}

try {
  const { here, templates } = await (await send("/templates")).json();
  element("here").textContent = `Folders begin at ${here}; nothing that is there is overwritten.`;
  const cards = templates.map(card);
  element("templates").replaceChildren(...cards.map(({ one }) => one));
  for (const one of cards) await showSketch(one);
  document.body.dataset.ready = "yes";
} catch (error) { complain(error); }
