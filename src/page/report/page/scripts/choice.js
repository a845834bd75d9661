// What is chosen, and what follows from it: the scores of choices of poses, their names and places. Whoever shows something
// listens here.
const chosen = { extent: 0, region: 0, series: 0, measure: 0, member: 0, choice: 0 };
const listeners = [];
const series = () => data.series[chosen.series];
const combination = () => data.combinations[series().combination];
const measure = () => data.measures[chosen.measure];
/** The chosen scene, or the first of all. */
const sceneOf = () => data.scenes[Math.max(0, chosen.extent - 1)];
const extents = ["all scenes", ...data.scenes.map(scene => scene.name)];

/** Changes what is chosen and tells everybody. Of another series, and by another score, the best is chosen unless one is named. */
function choose(changes) {
  const before = { ...chosen };
  Object.assign(chosen, changes);
  if (chosen.series !== before.series) chosen.member = posed()[0] ?? 0;
  const isOther = chosen.series !== before.series || chosen.measure !== before.measure;
  if (isOther && changes.choice === undefined) chosen.choice = bestChoice();
  listeners.forEach(listener => listener(isOther ? { ...changes, choice: chosen.choice } : changes));
}

/** The choices of a block of scores. */
const choicesOf = block => block.choices ?? Array.from({ length: block.count }, (_, i) => i);

/** Where a choice stands in a block; -1 where there was no room for it. */
const placeIn = (block, choice) => block.choices ? block.choices.indexOf(choice) : choice;

/** Each choice's value of a measure over an extent; of one scene alone there is no other extent than that. */
function values(measure = chosen.measure, extent = chosen.extent, of = series(), region = chosen.region) {
  const block = of.scores.over, kept = data.scenes.length > 1 ? extents.length : 1;
  const row = (region * kept + Math.min(extent, kept - 1)) * data.measures.length + measure;
  return numbers.subarray(block.begin + row * block.count, block.begin + (row + 1) * block.count);
}

/** The better of two values, where any is better than none. */
function isBetter(a, b, measure = chosen.measure) {
  if (Number.isNaN(a)) return false;
  return Number.isNaN(b) || (data.measures[measure].less_is_better ? a < b : a > b);
}

/** A score as the page writes it: a share as percent, not rounded to nothing or all unless it is. */
function scored(value, m = chosen.measure) {
  if (Number.isNaN(value) || !data.measures[m].is_share) return shown(value);
  const text = value === 0 || value === 1 ? String(value * 100) : shown(value * 100, 1);
  return `${text === "0.0" && value > 0 ? "<0.1" : text === "100.0" && value < 1 ? ">99.9" : text}\u00a0%`;
}

function bestChoice() {
  const all = values();
  let best = 0;
  all.forEach((value, i) => { if (isBetter(value, all[best])) best = i; });
  return choicesOf(series().scores.over)[best];
}

/** How many subsets of `size` numbers there are of `of` numbers. */
function subsets(of, size) {
  let count = 1;
  for (let n = 0; n < Math.min(size, of - size); n++) count = count * (of - n) / (n + 1);
  return count;
}

/** The subset of this number, as `study/choices.rs` numbers them. */
function nthSubset(number, of, size) {
  const found = [];
  for (let next = 0; found.length < size; next++) {
    const begun = subsets(of - 1 - next, size - 1 - found.length);
    if (number < begun) found.push(next); else number -= begun;
  }
  return found;
}

/** Which candidates each member of a choice has, as many as there are equal ones of it; those of the last vary fastest. */
function candidates(choice, of = combination()) {
  const found = [];
  for (let i = of.members.length - 1, rest = choice; i >= 0; i--) {
    const { candidates: all, count } = of.members[i], choices = subsets(all.length, count);
    found[i] = nthSubset(rest % choices, all.length, count).map(place => all[place]);
    rest = Math.floor(rest / choices);
  }
  return found;
}

/** Each sensor of a choice, with the number of its member and the pose it has. */
const members = (choice, of = combination()) => candidates(choice, of).flatMap((own, member) => {
  const sensor = data.sensors[of.members[member].sensor];
  return own.map(candidate => ({ member, sensor, pose: sensor.poses[candidate] }));
});

/** As in the column `poses` of results.csv. */
const fullName = (choice, of = combination()) => members(choice, of).map(({ sensor, pose }) => `${sensor.name}:${pose.name}`).join(data.between_members);

/** As in tables: without the name of an only sensor, and without what there is one of. */
function nameOf(choice, of = combination()) {
  const all = members(choice, of);
  if (all.length === 1) return all[0].pose.name;
  return all.filter(({ member }) => of.members[member].candidates.length > 1).map(({ sensor, pose }) => `${sensor.name}: ${pose.name}`).join(", ") || fullName(choice, of);
}

/** Where the sensors of a choice are, in words: of several, those that could stand elsewhere, each with its name. */
function placeOf(choice) {
  const which = posed(), all = members(choice).filter(({ member }) => which.includes(member));
  return all.filter(({ pose }) => pose.place).map(({ sensor, pose }) => all.length > 1 ? `${sensor.name}: ${pose.place}` : pose.place).join("; ") || "–";
}

/** Numbers of the members that stand somewhere and could stand elsewhere; else of those that stand anywhere. */
function posed(of = combination()) {
  const with_place = of.members.map((_, i) => i).filter(i => data.sensors[of.members[i].sensor].poses.some(pose => pose.at_m));
  const several = with_place.filter(i => of.members[i].candidates.length > 1);
  return several.length ? several : with_place;
}

/** The best answer without a sensor, by a measure over an extent. */
function toBeat(measure = chosen.measure, extent = chosen.extent, region = chosen.region) {
  const all = data.baselines[region][extent].slice(0, 3).filter(([, values]) => values[measure] !== null);
  return all.map(([name, values]) => ({ name, value: values[measure] })).reduce((best, next) => !best || isBetter(next.value, best.value, measure) ? next : best, null);
}

/** Of each candidate of a member that stands somewhere, by its number, the best choice that has it there. */
function bestOfCandidates(member = chosen.member) {
  const of = combination(), poses = data.sensors[of.members[member]?.sensor]?.poses ?? [];
  const all = values(), found = new Map();
  choicesOf(series().scores.over).forEach((choice, i) => {
    for (const candidate of candidates(choice)[member] ?? []) {
      const pose = poses[candidate], known = found.get(candidate);
      if (!pose.at_m) continue;
      if (!known) found.set(candidate, { at: pose.at_m, pose, choice, value: all[i], key: keyOf(pose) });
      else if (isBetter(all[i], known.value)) Object.assign(known, { choice, value: all[i] });
    }
  });
  return found;
}

/** Positions of a member: for each the best choice that has it there. */
function positions(candidates = bestOfCandidates()) {
  const found = new Map();
  for (const one of candidates.values()) {
    const known = found.get(one.key);
    if (!known || isBetter(one.value, known.value)) found.set(one.key, one);
  }
  return [...found.values()];
}

/** What tells a position from others. */
const keyOf = pose => `${pose.group}/${pose.at_m}`;

/** The keys of where the chosen member stands in the chosen choice: of several equal sensors, several. */
const chosenPositions = () => members(chosen.choice).filter(({ member, pose }) => member === chosen.member && pose.at_m).map(({ pose }) => keyOf(pose));

/** What a sensor is mounted on, in whose frame its poses are. */
const frameOf = sensor => `${sensor.on.object}, link ${sensor.on.link}`;

/** Where a pose is in the world at a moment: a place, and how directions are turned. */
function inWorld(sensor, pose, moment) {
  if (!sensor.on) return { at: pose.at_m, turn: v => turned(pose.turn, v) };
  const carrier = sensor.on.frames[moment];
  return { at: plus(carrier.at_m, turned(carrier.turn, pose.at_m)), turn: v => turned(carrier.turn, turned(pose.turn, v)) };
}
