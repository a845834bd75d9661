// What leaves the page: the report and the mounting sheets of the present plan, made by the program and opened in a new tab.
const PAPERS = { report: "Report", sheets: "Mounting sheets" };

/** Makes a paper of what the page shows; closing the dialog gives it up. */
async function makePaper(kind) {
  flushDraft();
  await lastEdit;
  const { path, changed } = planner.state, quoted = /^[\w./:+-]+$/.test(path) ? path : `'${path.replace(/'/g, `'\\''`)}'`;
  const judged = planner.state.requirements?.length ? ["perirobot judge out/planned"] : [];
  const lines = [`perirobot sweep ${quoted} --out out/planned`, ...judged, "perirobot report out/planned"];
  const words = made("p", { id: "paper-words", role: "status" }, "Reading…"), bar = made("progress", { id: "paper-bar", "aria-label": "Progress" });
  const controller = new AbortController();
  const dialog = openDialog(PAPERS[kind], [
    words, bar,
    ...(changed ? [made("p", { id: "paper-unsaved" }, "It is of what the page shows, with changes that are not saved.")] : []),
    made("p", { class: "soft" }, kind === "report" ? "The same of the saved study, in a terminal:" : "The report of the saved study has them, too; in a terminal:"), made("pre", { tabindex: "0" }, lines.join("\n"))],
    [["Copy the commands", () => navigator.clipboard.writeText(lines.join("\n")).then(() => notify("Copied.", "good"), complain)]]);
  dialog.addEventListener("close", () => { if (!dialog.open) controller.abort(); }, { signal: controller.signal });
  const end = said => { bar.hidden = true; words.replaceChildren(said); };
  try {
    await eachLine(await send("/paper", { kind }, controller.signal), ({ stage, ready, error }) => {
      if (stage) { Object.assign(bar, { max: Math.max(1, stage.total), value: stage.done }); words.textContent = `${stage.done} of ${stage.total} ${stage.words}`; }
      if (error) end(error);
      if (ready) {
        // A browser that opens no tab unasked leaves the link.
        end(made("a", { id: "paper-link", href: ready, target: "_blank" }, "Open it in a new tab"));
        open(ready, "_blank", "noopener");
      }
    });
  } catch (error) { if (error.name !== "AbortError") end(error.message); }
}

function makeLeaving() {
  for (const kind of Object.keys(PAPERS)) element(kind).addEventListener("click", () => makePaper(kind));
}
