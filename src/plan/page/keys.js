// Keys: everything that a pointer does, the keyboard does, too.
const MOVES_M = 0.05, TURNS_DEG = 5;

/** Moves or turns the chosen sensor where the view has the focus; false where the key means something else. */
function moveByKey(event) {
  const way = { ArrowLeft: [-1, 0, 0], ArrowRight: [1, 0, 0], ArrowUp: [0, 1, 0], ArrowDown: [0, -1, 0], PageUp: [0, 0, 1], PageDown: [0, 0, -1] }[event.key];
  const isHeld = planner.armed && planner.draft?.index === null, isObject = !isHeld && planner.object !== null && !!objectNamed(planner.object);
  if (!way || event.ctrlKey || event.metaKey || !mayEdit() || !isHeld && (planner.armed || !isObject && !poseNow(planner.selected))) return false;
  event.preventDefault();
  const finely = event.shiftKey ? 0.2 : 1;
  if (planner.tool === "aim" && isObject) return nudgeObject(at => ({ ...at, yaw_deg: at.yaw_deg - way[0] * TURNS_DEG * finely }));
  if (planner.tool === "aim" && !isHeld) return nudge(at => ({ ...at, pan_deg: at.pan_deg - way[0] * TURNS_DEG * finely, tilt_deg: at.tilt_deg + (way[1] + way[2]) * TURNS_DEG * finely }));
  const across = planner.tab === "plan" ? [1, 0, 0] : levelAxis(scene.stage.axes().right), ahead = planner.tab === "plan" ? [0, 1, 0] : crossed([0, 0, 1], across);
  const step = plus(plus(times(across, way[0]), times(ahead, way[1])), [0, 0, way[2]]);
  const moved = at => ({ ...at, position_m: plus(at.position_m, times(step, MOVES_M * finely)) });
  if (isObject) return nudgeObject(moved);
  if (!isHeld) return nudge(moved);
  changeDraft(moved(planner.draft.at));
  return true;
}

/** The axis of the cell that is most like a direction. */
function levelAxis([x, y]) {
  return Math.abs(x) >= Math.abs(y) ? [Math.sign(x) || 1, 0, 0] : [0, Math.sign(y), 0];
}

let copied = null;
const isTyping = target => target.closest?.("input, textarea, select, [contenteditable]") && target.type !== "checkbox" && target.type !== "range";

/** Menus close on Escape and on a click elsewhere. */
function closeMenus(but = null) {
  const open = [...document.querySelectorAll("details.menu[open]")].filter(menu => menu !== but);
  open.forEach(menu => { menu.open = false; });
  return open.length > 0;
}
addEventListener("pointerdown", event => closeMenus(event.target.closest?.("details.menu")), true);

function press(event) {
  if (element("dialog").open || event.defaultPrevented) return;
  if (event.key === "Escape" && closeMenus()) { event.preventDefault(); return; }
  const { target, key } = event, command = event.ctrlKey || event.metaKey;
  if (command && key.toLowerCase() === "s") { event.preventDefault(); save(); return; }
  if (isTyping(target)) { if (key === "Escape") target.blur(); return; }
  if (command && key.toLowerCase() === "z") { event.preventDefault(); element(event.shiftKey ? "redo" : "undo").click(); return; }
  if (command && key.toLowerCase() === "y") { event.preventDefault(); element("redo").click(); return; }
  if (command && key.toLowerCase() === "c" && !String(getSelection())) { copied = planner.selected; return; }
  if (command && key.toLowerCase() === "v") { if (copied !== null && placed()[copied]) copySensor(copied); return; }
  if (command || event.altKey) return;
  const inList = target.closest?.("#sensors");
  if (inList && ["ArrowUp", "ArrowDown", "Home", "End"].includes(key)) {
    event.preventDefault();
    const last = placed().length - 1;
    select({ ArrowUp: Math.max(0, planner.selected - 1), ArrowDown: Math.min(last, planner.selected + 1), Home: 0, End: last }[key]);
    focusChosen();
    return;
  }
  if (inList && key === "Enter") { element("pose-x").focus(); element("pose-x").select(); return; }
  const heard = KEYS_OF_PAGE[key.length === 1 ? key.toLowerCase() : key];
  if (heard && !(["Enter", " "].includes(key) && target.closest?.("button, summary, a"))) { event.preventDefault(); heard(); }
}

const KEYS_OF_PAGE = {
  w: () => { disarm(); planner.tool = "move"; planner.why = planner.measured = null; ["tool", "why", "measure", "selected"].forEach(tell); },
  e: () => { if (planner.tool !== "aim") takeTool("aim"); tell("selected"); },
  a: openCatalogue,
  q: () => takeTool("why"),
  m: () => takeTool("measure"),
  d: () => copySensor(),
  f: () => { const at = poseNow(planner.selected); if (at) scene.stage?.focus(at.position_m); },
  v: () => element("through").click(),
  h: () => element("whole").click(),
  1: () => takeTab("3d"),
  2: () => takeTab("plan"),
  Delete: removeChosen,
  Backspace: removeChosen,
  Enter: placeGhost,
  Escape: escape,
  "?": openKeys,
};

/** Objects are not removed here. */
function removeChosen() {
  if (isKnown(planner.object)) notify("Objects stay: only sensors are removed.");
  else removeSensor();
}

/** Ends what is being done, the last thing first. */
function escape() {
  if (planner.draft && planner.draft.index !== null && !planner.draft.isSettling) dropDraft();
  else if (planner.carry && !planner.carry.isSettling) { clearTimeout(settles); dropCarry(); }
  else if (planner.armed) disarm();
  else if (!element("pose-list").hidden) closePoses();
  else if (!element("catalogue").hidden) openCatalogue();
  else if (!element("find-panel").hidden) closeFind();
  else if (planner.tool !== "move") KEYS_OF_PAGE.w();
  else if (planner.through !== null && planner.through !== undefined) scene.stage.focus(roomBox());
}

const KEY_WORDS = [["Drag a sensor", "moves it on the surface under the pointer; takes a listed pose that is near"], ["Shift, Alt", "while dragging: steps of 10 cm and 5°; freely"], ["W, E", "move, aim"], ["Drag an object", "on the floor plan, or where it is chosen: moves it along the floor; its handle turns it"], ["Arrow keys, Page up, Page down", "in the view: move by 5 cm, or turn by 5° while aiming; Shift: by 1 cm, 1°"], ["A", "add a sensor; Enter places it, Esc puts it away"], ["D, Ctrl+C and Ctrl+V", "copy"], ["Delete", "remove"], ["Ctrl+Z, Ctrl+Shift+Z", "undo, redo"], ["Ctrl+S", "save"], ["Q", "why is a place seen or not: click it, or type it"], ["M", "measure"], ["F, double click", "go nearer to the sensor, to a place"], ["V", "look through the sensor"], ["H", "the whole cell"], ["1, 2", "3D, floor plan"], ["Tab", "through everything; in the lists of sensors and objects up and down choose, Enter goes to the numbers"]];
function openKeys() {
  openDialog("Keys and pointer", [made("dl", { class: "keys" }, ...KEY_WORDS.flatMap(([key, words]) => [made("dt", {}, key), made("dd", {}, words)]))]);
}

function makeKeys() {
  addEventListener("keydown", press);
  element("keys").addEventListener("click", openKeys);
}
