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
  if (!sensor || sensor.carried || planner.draft || planner.isLost || planner.state.problems?.length) return;
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
