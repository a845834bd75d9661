// Begins: makes the parts of the page, asks for the state, and shows it.

/** Shows one of the two tabs. */
function takeTab(name) {
  if (name === "3d" && !scene.stage) return;
  planner.tab = name;
  for (const one of ["3d", "plan"]) { element(`tab-${one}`).setAttribute("aria-selected", String(one === name)); element(`tab-${one}`).tabIndex = one === name ? 0 : -1; }
  element("view").hidden = name !== "3d";
  element("plan").hidden = name !== "plan";
  element("plan-legend").hidden = name !== "plan";
  element("cut").hidden = name !== "3d";
  document.body.dataset.tab = name;
  tell("tab");
}

function makeTabs() {
  for (const name of ["3d", "plan"]) {
    element(`tab-${name}`).addEventListener("click", () => takeTab(name));
    element(`tab-${name}`).addEventListener("keydown", event => {
      if (!["ArrowLeft", "ArrowRight"].includes(event.key)) return;
      event.preventDefault();
      takeTab(planner.tab === "3d" ? "plan" : "3d");
      element(`tab-${planner.tab}`).focus();
    });
  }
}

makeTabs();
makeLayers(layer => { switchLayer(layer); tell("layers"); });
makeScene();
makePlan();
makeTools();
makeDots();
makeInspector();
makeObjects();
makeZones();
makeStatus();
makeFiles();
makeLeaving();
makeFind();
makeKeys();
takeTab(scene.stage && innerWidth >= 640 ? "3d" : "plan");
document.body.planner = planner;
take(await ask("/state"));
showTime();
tell("tool");
// What is dragged by its place on the screen has to wait until the cell is in view.
if (scene.stage) await showScenery().catch(complain);
document.body.dataset.ready = "yes";
// The file may change on disk while the page is open.
setInterval(async () => {
  if (document.hidden || planner.isLost || planner.draft || planner.carry || plan.zone || document.body.dataset.busy) return;
  try { const state = await ask("/state"); if (state.version !== planner.state.version || state.disk_changed !== planner.state.disk_changed) take(state); } catch (error) { complain(error); }
}, 3000);
