// Saving, the difference, and the text of the study.
let hasSaved = false;

/** Opens the dialog with a title, its contents, and buttons: [words, what happens, whether it is the main one]. */
function openDialog(title, contents, buttons = []) {
  const dialog = element("dialog");
  element("dialog-title").textContent = title;
  element("dialog-body").replaceChildren(...contents);
  element("dialog-buttons").replaceChildren(...[...buttons, ["Close", null]].map(([words, heard, isMain, id]) => {
    const button = made("button", { type: "button", class: isMain ? "primary" : "", ...(id ? { id } : {}) }, words);
    button.addEventListener("click", () => { if (heard) heard(); else dialog.close(); });
    return button;
  }));
  if (!dialog.open) dialog.showModal();
  return dialog;
}
const closeDialog = () => element("dialog").close();

/** Saves; before the first time with the difference in view. */
async function save() {
  flushDraft();
  await lastEdit;
  if (!mayEdit() || !planner.state.changed) return;
  try {
    const lines = await ask("/difference"), files = lines.filter(({ kind }) => kind === "file").map(({ text }) => text);
    const names = files.join(" and ") || planner.state.name;
    if (hasSaved || planner.state.saved) { write(names); return; }
    openDialog(`Save ${names}?`, [made("p", {}, `This changes ${names}; comments and order stay as they are.`), differenceOf(lines)], [["Save", () => write(names), true, "save-now"]]);
  } catch (error) { complain(error); }
}
const SIGNS = { same: " ", old: "−", new: "+", gap: "…", file: "" };
const differenceOf = lines => made("div", { class: "difference", tabindex: "0", role: "region", "aria-label": "Difference" }, ...lines.map(({ kind, text }) => made("div", { class: kind }, made("b", {}, SIGNS[kind] ?? " "), made("code", {}, text ?? ""))));

/** Writes the files of these names. */
async function write(names, overwrite = false) {
  try {
    const state = await askChange("/save", { overwrite });
    hasSaved = true;
    closeDialog();
    take(state);
    notify(`Saved ${names}.`, "good");
  } catch (error) {
    if (error.status === 409) openDialog("The file has changed on disk", [made("p", {}, `${error.message[0].toUpperCase()}${error.message.slice(1)}. Overwriting loses that change.`)], [["Read theirs", reload, false, "reload"], ["Overwrite", () => write(names, true), false, "overwrite"]]);
    else complain(error);
  }
}

/** Takes the files as other programs have written them; undo does not bring this page's changes back. */
async function reload() {
  try {
    const state = await askChange("/reload", {});
    closeDialog();
    take(state);
    notify("The file was read again.", "good");
  } catch (error) { complain(error); }
}

/** The whole study as text, to be repaired by hand. */
async function openText() {
  try {
    const { text, version } = await ask("/text"), area = made("textarea", { id: "text", spellcheck: "false", rows: 24, "aria-label": "The study as TOML" });
    area.value = text;
    area.readOnly = !mayEdit();
    const problems = planner.state.problems ?? [];
    const list = made("ul", { class: "problems" }, ...problems.map(one => problemLine(one, area)));
    openDialog(planner.state.name, [...(problems.length ? [list] : []), area], mayEdit() ? [["Apply", async () => { if (await edit({ edit: "set_text", text: area.value, version })) closeDialog(); }, true, "apply-text"]] : []);
    if (problems[0]?.line) goToLine(area, problems[0].line);
  } catch (error) { complain(error); }
}
function goToLine(area, line) {
  const lines = area.value.split("\n"), begin = lines.slice(0, line - 1).join("\n").length + (line > 1 ? 1 : 0);
  area.focus();
  area.setSelectionRange(begin, begin + (lines[line - 1] ?? "").length);
  area.scrollTop = Math.max(0, (line - 8) * area.scrollHeight / lines.length);
}
function problemLine({ line, place, words }, area) {
  const button = made("button", { type: "button", class: "link" }, line ? `Line ${line}` : "Study");
  button.addEventListener("click", () => { if (area) goToLine(area, line ?? 1); else openText(); });
  return made("li", {}, button, made("span", {}, place ? made("code", {}, place) : "", place ? " " : "", words));
}

/** What keeps the study from being counted. */
function showProblems() {
  const { problems = [] } = planner.state;
  element("problems").hidden = !problems.length;
  element("problem-list").replaceChildren(...problems.map(one => problemLine(one)));
}

async function copyPlan() {
  try {
    const { plan: text } = await ask("/text");
    try { await navigator.clipboard.writeText(text); notify("The plan is copied as TOML.", "good"); } catch {
      const area = made("textarea", { rows: 16, readonly: "", "aria-label": "The plan as TOML" });
      area.value = text;
      openDialog("Copy as TOML", [area]);
      area.select();
    }
  } catch (error) { complain(error); }
}

function makeFiles() {
  element("save").addEventListener("click", save);
  element("undo").addEventListener("click", () => { flushDraft(); lastEdit.then(() => step("/undo")); });
  element("redo").addEventListener("click", () => { flushDraft(); lastEdit.then(() => step("/redo")); });
  element("text-open").addEventListener("click", openText);
  element("repair").addEventListener("click", openText);
  element("toml").addEventListener("click", copyPlan);
  element("difference-open").addEventListener("click", async () => { try { const lines = await ask("/difference"); openDialog("Changes since the file was saved", [lines.length ? differenceOf(lines) : made("p", {}, "Nothing has changed.")]); } catch (error) { complain(error); } });
  on("state", showProblems);
  addEventListener("beforeunload", event => { if (planner.state?.changed && !planner.isLost) event.preventDefault(); });
}
