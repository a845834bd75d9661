// What the page knows, and how it talks to the program: every request has the token of the address, one score is in flight.
// The answers are those of `state.rs` and `answers.rs`.

const token = location.hash.replace(/^#(token=)?/, "");
const planner = { state: null, selected: -1, moment: 0, region: 0, dead: null, tool: "move", tab: "3d", draft: null, answer: null, judged: null, isLost: false, armed: null, object: null, carry: null };
const heard = new Map();
/** Calls a function whenever something of this name has changed. */
const on = (names, listener) => names.split(" ").forEach(name => heard.set(name, [...heard.get(name) ?? [], listener]));
const tell = name => (heard.get(name) ?? []).forEach(listener => listener());

/** An answer that is not the wanted one, in the program's words. */
class Refusal extends Error {
  constructor(status, answer) { super(answer.error ? plainError(answer.error) : `The planner answered ${status}.`); this.status = status; this.answer = answer; }
}

/** Sends a request; throws a `Refusal`, or whatever `fetch` throws when the program is gone. */
async function send(path, body, signal) {
  const headers = { "X-Perirobot-Token": token, ...(body === undefined ? {} : { "Content-Type": "application/json" }) };
  let answer;
  try {
    answer = await fetch(path, { method: body === undefined ? "GET" : "POST", headers, body: body === undefined ? undefined : JSON.stringify(body), cache: "no-store", signal });
  } catch (error) {
    if (error.name !== "AbortError") lose();
    throw error;
  }
  if (answer.ok) return answer;
  throw new Refusal(answer.status, await answer.json().catch(() => ({})));
}
const ask = async (path, body, signal) => (await send(path, body, signal)).json();

/** Calls a function for each line of an answer that grows, each of them JSON. */
async function eachLine(answer, listener) {
  const reader = answer.body.getReader(), decoder = new TextDecoder();
  for (let rest = ""; ;) {
    const { done, value } = await reader.read();
    if (done) break;
    const lines = (rest + decoder.decode(value, { stream: true })).split("\n");
    rest = lines.pop();
    lines.filter(line => line.trim()).forEach(line => listener(JSON.parse(line)));
  }
}

/** Says that the program is gone, lets nothing be edited, and waits for it to come back. */
function lose() {
  if (planner.isLost) return;
  planner.isLost = true;
  document.body.dataset.lost = "yes";
  tell("connection");
  const again = async () => {
    try {
      const answer = await fetch("/state", { headers: { "X-Perirobot-Token": token }, cache: "no-store" });
      if (!answer.ok) throw new Refusal(answer.status, await answer.json().catch(() => ({})));
      const state = await answer.json();
      // Another run of the program counts its versions anew.
      planner.isLost = false;
      planner.state = null;
      delete document.body.dataset.lost;
      tell("connection");
      take(state);
    } catch { setTimeout(again, 1500); }
  };
  setTimeout(again, 1000);
}

/** Whether something may be changed now. */
const mayEdit = () => !!planner.state && !planner.isLost && !planner.state.read_only;

/** Takes a state that the program has sent, unless a newer one is known. */
function take(state) {
  const before = planner.state;
  if (before && state.version < before.version) return;
  planner.state = state;
  document.body.dataset.version = state.version;
  const count = placed().length;
  if (planner.selected >= count) planner.selected = count - 1;
  if (planner.selected < 0 && count && !before) planner.selected = 0;
  // A sensor that is switched off stays so wherever it is in the list.
  const off = before?.placed?.[planner.dead], same = off ? placed().findIndex(one => one.sensor === off.sensor && one.pose === off.pose) : -1;
  planner.dead = same < 0 ? null : same;
  planner.region = Math.min(planner.region, Math.max(0, (state.regions ?? []).length - 1));
  const worlds = state => JSON.stringify(state && [state.worlds, state.scenes, state.regions, state.voxel_size_m, state.coarse_m]);
  if (worlds(before) !== worlds(state)) { cells.clear(); sceneries.clear(); tell("worlds"); }
  tell("state");
  if (!planner.draft) wantScore("fine");
}

// Another page's gestures, and those before a reload, are others.
let gesture = Math.floor(Math.random() * 2 ** 40);
/** Tells this window from others: newer work takes the place of its own older work only. */
const windowNumber = Math.floor(Math.random() * 2 ** 40);
/** Begins another gesture: edits of one are undone together. */
const nextGesture = () => ++gesture;

/** The status of a change that was made on an older version. */
const STALE = 412;
/** Edits are sent one after the other, in the order in which they were made. */
let lastEdit = Promise.resolve(), edits = 0;
/** For tests: what is being waited for. */
const markBusy = () => { document.body.dataset.busy = edits ? "edit" : scores.flying || scores.next ? "score" : ""; };

/** Sends a change with the version that it was made on; if another window has made a newer one, that is shown. */
async function askChange(path, change) {
  try { return await ask(path, { version: planner.state.version, ...change }); } catch (error) {
    if (error.status === STALE) { dropDraft(); take(await ask("/state")); }
    throw error;
  }
}
function edit(change, of = nextGesture()) {
  if (!mayEdit()) return Promise.resolve(false);
  edits += 1;
  stopEye();
  markBusy();
  const draft = planner.draft?.isSettling ? planner.draft : null, { moment } = planner;
  lastEdit = lastEdit.then(async () => {
    try {
      const state = await askChange("/edit", { ...change, gesture: of, moment });
      // What was a draft is in the study now.
      if (draft && planner.draft === draft) { keepPlace(draft); planner.draft = null; }
      take(state);
      if (typeof state.changed_index === "number") select(state.changed_index);
      return true;
    } catch (error) { complain(error); return false; } finally { edits -= 1; markBusy(); }
  });
  return lastEdit;
}

function step(path) {
  if (!mayEdit()) return;
  edits += 1;
  stopEye();
  markBusy();
  lastEdit = lastEdit.then(async () => {
    try { take(await askChange(path, {})); } catch (error) { complain(error); } finally { edits -= 1; markBusy(); }
  });
}

/** Shows for some seconds why something did not happen. */
function complain(error) {
  if (planner.isLost || error.name === "AbortError") return;
  notify(error.message, "bad");
}
let hidesNotice = 0;
function notify(words, kind = "") {
  const home = element("notice");
  home.textContent = words;
  home.className = kind;
  home.hidden = false;
  clearTimeout(hidesNotice);
  hidesNotice = setTimeout(() => { home.hidden = true; }, 6000);
}

const placed = () => planner.state?.placed ?? [];
const sensorOf = one => planner.state.sensors.find(sensor => sensor.name === one.sensor);
const chosenScene = () => planner.state.scenes.find(scene => planner.moment >= scene.moments[0] && planner.moment < scene.moments[1]) ?? planner.state.scenes[0];
const roomBox = () => chosenScene()?.room_m ?? [[-2, -2, 0], [2, 2, 3]];

function select(index) {
  if (planner.object !== null) { planner.object = null; tell("object"); }
  if (planner.selected === index) return;
  planner.selected = index;
  tell("selected");
}

// What is loaded once for a moment.
const cells = new Map(), sceneries = new Map();
const loadOnce = (known, key, load) => { if (!known.has(key)) known.set(key, load().catch(error => { known.delete(key); throw error; })); return known.get(key); };
const bytesOf = text => Uint8Array.from(atob(text), letter => letter.charCodeAt(0));

/** The scene's objects as triangles. */
const loadScenery = moment => loadOnce(sceneries, moment, () => ask(`/scenery?moment=${moment}`));

/** The cell in voxels: what is there, and which voxels are of a region. */
const loadCell = (moment, voxel) => loadOnce(cells, `${voxel} ${moment}`, async () => {
  const cell = await ask(`/cell?moment=${moment}&voxel=${voxel}`), count = cell.size.reduce((a, b) => a * b);
  const regions = cell.regions.map(runs => decoded(bytesOf(runs), 2, count)), anywhere = new Uint8Array(count);
  for (const region of regions) for (let i = 0; i < count; i++) if (region[i]) anywhere[i] = 1;
  let members = 0;
  for (let i = 0; i < count; i++) members += anywhere[i];
  return { ...cell, count, truth: decoded(bytesOf(cell.truth), 5, count), regions, anywhere, members, bounds: boundsOf(anywhere, one => one, cell.size) };
});
