// What each listed pose of a sensor would show alone, counted while nothing else is: the dots light up by it.
const dots = { scores: new Map(), controller: null, wait: 0 };

/** The sensor whose listed poses are shown: the one to be placed, the chosen one, or the first. */
function sensorOfDots() {
  const name = planner.armed?.sensor ?? placed()[planner.selected]?.sensor ?? (planner.armed ? null : planner.state?.sensors?.[0]?.name);
  return planner.state?.sensors?.find(one => one.name === name);
}

const keyOfDots = sensor => JSON.stringify([planner.state.worlds, sensor, planner.moment, planner.region]);

/** The scores of a sensor's listed poses, as far as they are known. */
const scoresOfPoses = sensor => sensor ? dots.scores.get(keyOfDots(sensor)) ?? new Map() : new Map();

/** Counts the listed poses of the shown sensor, a while after anything has changed. */
function countDotsSoon() {
  clearTimeout(dots.wait);
  dots.wait = setTimeout(countDots, 900);
}

async function countDots() {
  const sensor = sensorOfDots();
  // While an edit is on its way the program may have other sensors than the page; its answer begins this anew.
  if (!sensor || sensor.carried || edits || planner.draft || planner.isLost || planner.state.problems?.length) return;
  const key = keyOfDots(sensor), known = dots.scores.get(key);
  if (known?.isWhole) return;
  dots.controller?.abort();
  const controller = dots.controller = new AbortController(), scores = new Map();
  if (dots.scores.size > 20) dots.scores.clear();
  dots.scores.set(key, scores);
  const index = planner.state.sensors.indexOf(sensor);
  try {
    const answer = await send(`/listed?sensor=${index}&moment=${planner.moment}&region=${planner.region}`, undefined, controller.signal);
    await eachLine(answer, ({ pose, score }) => { scores.set(pose, score); tell("dots"); });
    scores.isWhole = scores.size === sensor.poses.length;
    document.body.dataset.dots = scores.size;
  } catch (error) { if (error.name !== "AbortError") complain(error); }
}
on("state selected moment region draft", countDotsSoon);

/** The listed poses of a sensor by where they are seen, by a key of their place. */
function posesByPlace(sensor, keyOf) {
  const places = new Map();
  for (const pose of listed(sensor)) places.set(keyOf(pose.at_m), [...places.get(keyOf(pose.at_m)) ?? [], pose]);
  return [...places.values()];
}

/** What a dot says: its pose, or how many there are. */
const wordsOfDot = (sensor, poses, share) => poses.length > 1 ? `${poses.length} poses of ${sensor.name} here: click to choose one` : `${sensor.name} at ${poses[0].name}${poses[0].place ? `, ${poses[0].place}` : ""}${share === null || share === undefined ? "" : `, shows ${percent(share)} alone`}: click to place it here`;

/** Places a sensor at the pose of a dot; of several poses one is chosen from a list, the highest first, beside the dot. */
function chooseListed(sensor, poses, [x, y]) {
  const home = element("pose-list");
  home.hidden = poses.length < 2;
  if (home.hidden) { placeListed(sensor, poses[0]); return; }
  const scores = scoresOfPoses(sensor), worth = pose => scores.get(pose.name) ?? -1;
  const rows = [...poses].sort((a, b) => b.at_m[2] - a.at_m[2] || worth(b) - worth(a)).map(pose => {
    const share = scores.get(pose.name), isTaken = placed().some(one => one.sensor === sensor.name && one.pose === pose.name);
    const button = made("button", { type: "button", class: "model" }, made("strong", {}, metres(pose.at_m[2]), " high"), made("em", {}, isTaken ? "placed" : share === null || share === undefined ? "" : `shows ${percent(share)} alone`), made("span", {}, pose.place || pose.name));
    button.disabled = isTaken;
    button.addEventListener("click", () => { home.hidden = true; placeListed(sensor, pose); });
    return button;
  });
  element("poses-here").replaceChildren(...rows);
  const { clientWidth: width, clientHeight: height } = home.parentElement;
  home.style.left = `${Math.max(8, Math.min(x + 14, width - home.offsetWidth - 8))}px`;
  home.style.top = `${Math.max(8, Math.min(y - 20, height - home.offsetHeight - 8))}px`;
  home.querySelector("button.model:not(:disabled)")?.focus();
}
const closePoses = () => { element("pose-list").hidden = true; };
function makeDots() {
  element("pose-list-close").addEventListener("click", closePoses);
  on("state armed tool moment", closePoses);
}
