// What is always in view: verdicts, the worst, cost; the banner; time.

/** The status bar, written at most once a second, as screen readers read it out. */
let wroteAt = 0, writes = 0;
function showStatusSoon() {
  clearTimeout(writes);
  const wait = Math.max(0, wroteAt + 1000 - performance.now());
  if (wait) writes = setTimeout(showStatus, wait); else showStatus();
}

function showStatus() {
  wroteAt = performance.now();
  const { judged, state } = planner;
  if (!state) return;
  const verdicts = judged?.verdicts ?? [], passed = verdicts.filter(one => one.passes === true).length, isAll = verdicts.length && passed === verdicts.length;
  const verdict = element("verdict"), isBad = placed().some((_, index) => problemOf(index));
  const isOld = !judged || judged.version !== state.version || state.problems?.length > 0 || planner.draft;
  verdict.textContent = !(state.requirements ?? verdicts).length ? "No requirements" : state.problems?.length ? "The text has errors" : isOld ? "Judging…" : isBad ? "A sensor is badly placed" : isAll ? `PASS ${passed} of ${verdicts.length}` : `FAIL: ${passed} of ${verdicts.length} met`;
  verdict.className = !verdicts.length || isOld ? "" : isAll && !isBad ? "PASS" : "FAIL";
  const say = (id, words) => { const home = element(id); if (home.lastChild.textContent !== words) home.lastChild.textContent = words; home.hidden = !words; };
  say("worst", judged?.worst?.words ?? "");
  const { nearest } = judged ?? {};
  say("nearest", nearest ? nearest.words ?? `${metres(nearest.metres)}: ${nearest.body} from ${nearest.entry}` : "");
  const { cost, budget } = state;
  const home = element("money");
  home.hidden = cost === null || cost === undefined;
  const marked = state.list_prices ? `${money(cost)} (with list prices, to be checked)` : money(cost);
  home.lastChild.textContent = budget === null || budget === undefined ? marked : `${marked} of ${money(budget)}`;
  home.title = state.list_prices ?? "";
  home.className = budget !== null && budget !== undefined && cost > budget ? "over" : "";
  element("requirements").replaceChildren(...verdicts.map(verdictLine));
  element("conditions").replaceChildren(...conditionLines(verdicts));
  element("verdicts").hidden = !verdicts.length;
  const disturbed = isOld ? [] : judged?.disturbed ?? [];
  element("disturb-note").hidden = !disturbed.length;
  element("disturb-note").className = disturbed.some(one => one.is_forbidden) ? "FAIL" : "";
  element("disturb-note").textContent = disturbed.map(one => one.words).join(". ");
  element("dead-note").hidden = planner.dead === null;
  element("dead-note").textContent = planner.dead === null ? "" : `Sensor ${letterAt(planner.dead)} is switched off: all numbers are without it.`;
}

/** What keeps somebody from editing. */
function showBanner() {
  const home = element("banner"), { state, isLost } = planner;
  const words = isLost ? "The planner does not answer: its window or terminal may be closed. Nothing can be edited until it is back; the file is as it was saved last." : state?.disk_changed ? "The file was changed by another program since it was opened. Saving asks before it overwrites." : state?.read_only ? "Read only: nothing can be edited." : "";
  home.hidden = !words;
  home.textContent = words;
  home.className = isLost ? "lost" : "";
  document.body.classList.toggle("locked", !mayEdit());
  document.querySelectorAll("[data-edits]").forEach(button => { button.disabled = !mayEdit(); });
}

function showTop() {
  const { state } = planner;
  element("find").disabled = !mayEdit() || state.can_find === false;
  element("find").title = state.can_find === false ? "Nothing can be searched in this study: its sensors have one pose each" : "";
  element("study").textContent = state.name;
  element("path").textContent = state.path;
  document.title = `${state.changed ? "• " : ""}${state.name} · perirobot plan`;
  element("undo").disabled = !mayEdit() || !state.can_undo;
  element("redo").disabled = !mayEdit() || !state.can_redo;
  element("save").disabled = !mayEdit() || !state.changed;
  element("save").classList.toggle("primary", !!state.changed);
}

// Time: the moments of the chosen scene.
const playing = { timer: 0 };
function goTo(moment) {
  if (planner.moment === moment) return;
  flushDraft();
  planner.moment = moment;
  planner.why = null;
  document.body.dataset.moment = moment;
  ["moment", "why"].forEach(tell);
  wantScore(playing.timer ? "coarse" : "fine");
}

function showTime() {
  const { state, judged } = planner, all = state.scenes ?? [], home = element("time"), own = all.length ? chosenScene() : null;
  home.hidden = !own || all.length < 2 && own.moments[1] - own.moments[0] < 2;
  if (home.hidden) return;
  const [begin, end] = own.moments, slider = element("moment"), select = element("scene");
  if (select.dataset.names !== all.map(one => one.name).join("\n")) { select.replaceChildren(...all.map(({ name }, n) => made("option", { value: n }, name))); select.dataset.names = all.map(one => one.name).join("\n"); }
  select.value = all.indexOf(own);
  element("scene-of").hidden = all.length < 2;
  Object.assign(slider, { min: begin, max: end - 1, value: planner.moment });
  // Snapshots count from 0, as in all tables.
  element("moment-words").textContent = `snapshot ${planner.moment - begin} of 0–${end - begin - 1}`;
  slider.setAttribute("aria-valuetext", element("moment-words").textContent);
  element("play").setAttribute("aria-pressed", String(!!playing.timer));
  element("play").disabled = end - begin < 2;
  const worst = judged?.worst?.moment, isHere = worst !== undefined && worst !== null && worst >= begin && worst < end;
  element("go-worst").hidden = worst === undefined || worst === null;
  const of = moment => { const found = planner.moments?.find(one => one.moment === moment); const counts = found?.counts?.[planner.region] ?? found; return counts?.human_seen ?? counts?.f1 ?? null; };
  const marks = Array.from({ length: end - begin }, (_, n) => { const value = of(begin + n), bar = made("i", { class: isHere && worst === begin + n ? "worst" : "", title: `snapshot ${n}${value === null ? "" : `: ${percent(value)}`}${isHere && worst === begin + n ? ", the worst" : ""}` }); bar.style.height = `${value === null ? 12 : 12 + 88 * value}%`; return bar; });
  element("marks").replaceChildren(...marks);
}

function play(is) {
  clearInterval(playing.timer);
  playing.timer = is ? setInterval(() => {
    // The next moment follows when this one is shown.
    if (scores.flying || scores.next) return;
    const [begin, end] = chosenScene().moments;
    goTo(planner.moment + 1 < end ? planner.moment + 1 : begin);
  }, 500) : 0;
  tell("moment");
  if (!is) wantScore("fine");
}

function makeStatus() {
  element("verdict").addEventListener("click", () => element("verdicts").scrollIntoView({ block: "nearest", behavior: "smooth" }));
  element("moment").addEventListener("input", event => goTo(Number(event.target.value)));
  element("scene").addEventListener("change", event => goTo(planner.state.scenes[event.target.value].moments[0]));
  element("play").addEventListener("click", () => play(!playing.timer));
  element("go-worst").addEventListener("click", () => goTo(planner.judged.worst.moment));
  on("state judged connection dead", showStatusSoon);
  on("state connection", showBanner);
  on("state connection", () => { if (planner.state) showTop(); });
  on("state moment judged region", showTime);
}
