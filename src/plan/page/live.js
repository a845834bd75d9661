// Scores while something is dragged: one request in flight, the newest pose next, answers in order; and verdicts after a rest.
const scores = { n: 0, flying: false, next: null, controller: null };
const REST_MS = 300;
let rests = 0;

/** Asks for the counts of what is shown now: coarse while something is dragged, and of the study's voxels at rest. */
function wantScore(voxel) {
  if (!planner.state || planner.isLost || planner.state.problems?.length && !placed().length) return;
  scores.n += 1;
  scores.next = { n: scores.n, moment: planner.moment, voxel, move: planner.draft ? moveOf(planner.draft) : null, dead: planner.dead };
  clearTimeout(rests);
  if (!planner.draft) rests = setTimeout(judge, REST_MS);
  fly();
}

/** How a draft is written in a request. */
const moveOf = draft => draft.index === null ? { add: draft.add, at: written(draft.at) } : { index: draft.index, at: written(draft.at), ...(draft.snapped ? { pose: draft.snapped } : {}) };

async function fly() {
  if (scores.flying || !scores.next) return;
  const wanted = scores.next;
  Object.assign(scores, { flying: true, next: null });
  markBusy();
  try {
    const answer = await ask("/score", wanted);
    // What is older than what is shown, or of a moment that is left, is of no use.
    if (answer.n === wanted.n && answer.moment === planner.moment && !(wanted.move && !planner.draft)) {
      const cell = await loadCell(answer.moment, answer.voxel);
      planner.answer = { ...answer, cell, isDraft: !!wanted.move };
      document.body.dataset.n = answer.n;
      document.body.dataset.voxel = answer.voxel;
      tell("answer");
      if (!wanted.move && answer.voxel === "fine") countMoments();
    }
  } catch (error) { complain(error); }
  scores.flying = false;
  markBusy();
  fly();
}

/** Counts every moment, as soon as nothing is dragged. */
async function countMoments() {
  scores.moments?.abort();
  const controller = scores.moments = new AbortController(), n = scores.n;
  try {
    const answer = await ask("/moments", { n, dead: planner.dead, window: windowNumber }, controller.signal);
    if (scores.moments !== controller || answer.superseded) return;
    planner.moments = answer.moments;
    document.body.dataset.moments = answer.n;
    tell("judged");
  } catch (error) { complain(error); }
}

/** Counts every moment and asks for verdicts; an older question is given up. */
async function judge() {
  scores.controller?.abort();
  const controller = scores.controller = new AbortController(), n = scores.n;
  document.body.dataset.judging = n;
  const { version } = planner.state;
  try {
    const answer = await ask("/judge", { n, dead: planner.dead, window: windowNumber }, controller.signal);
    if (scores.controller !== controller || answer.superseded) return;
    planner.judged = { ...answer, version };
    planner.moments = answer.moments;
    document.body.dataset.judged = answer.n;
    tell("judged");
  } catch (error) { complain(error); }
  if (scores.controller === controller) delete document.body.dataset.judging;
}

/** The counts of the chosen region. */
const countsNow = () => planner.answer?.counts?.[planner.region] ?? null;

/** What a label makes of a voxel: free and called so, seen, missed, false, not seen, blind. */
const OUTCOMES = [["TN", "FP", "UF"], ["FN", "TP", "UO"]];
const OUTCOME_NUMBER = { TN: 1, FP: 2, UF: 3, FN: 4, TP: 5, UO: 6 };

/** The outcome of each voxel of the chosen region, by the numbers above, 0 elsewhere; in the smallest grid that holds all regions. */
function outcomes({ labels, cell }) {
  const all = decoded(bytesOf(labels), 3, cell.members), region = cell.regions[planner.region] ?? cell.anywhere;
  const [low, high] = cell.bounds, size = minus(high, low), found = new Uint8Array(size[0] * size[1] * size[2]);
  const numbers = OUTCOMES.map(row => row.map(name => OUTCOME_NUMBER[name])), [nx, ny] = cell.size;
  for (let z = low[2], n = 0, to = 0; z < high[2]; z++) for (let y = low[1]; y < high[1]; y++) {
    const row = nx * (y + ny * z);
    for (let i = row + low[0]; i < row + high[0]; i++, to++) {
      if (!cell.anywhere[i]) continue;
      const label = all[n++];
      if (region[i] && cell.truth[i] !== 4) found[to] = numbers[cell.truth[i] ? 1 : 0][label];
    }
  }
  return { voxels: found, grid: { size, origin: plus(cell.origin, low) } };
}
