// Places and directions of sensors: as they are written, and the nearest that is listed.
const RAD = Math.PI / 180;
const LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ";
const letterOf = index => (index < 26 ? "" : letterOf(Math.floor(index / 26) - 1)) + LETTERS[index % 26];
const letterAt = index => placed()[index]?.letter ?? letterOf(index);

/** Millimetres and tenths of a degree: what the study will hold, so that it is counted as it is written. */
const rounded = (value, places) => Number(value.toFixed(places)) + 0;
const angle = degrees => { const turn = ((degrees + 180) % 360 + 360) % 360 - 180; return turn === -180 ? 180 : turn; };
const written = at => ({ position_m: at.position_m.map(x => rounded(x, 3)), pan_deg: rounded(angle(at.pan_deg), 1), tilt_deg: rounded(Math.max(-90, Math.min(90, at.tilt_deg)), 1), roll_deg: rounded(angle(at.roll_deg), 1) });

/** Where a placed sensor or a listed pose is, as six numbers. */
const sixOf = ({ at_m, turned_deg }) => ({ position_m: at_m, pan_deg: turned_deg[0], tilt_deg: turned_deg[1], roll_deg: turned_deg[2] });

/** What is wrong with a placed sensor where it is, as the state or the newest counts say; null if nothing is. */
function problemOf(index) {
  const of = answer => answer?.problems?.find(one => one.index === index)?.words;
  if (planner.draft?.index === index) return planner.draft.problem;
  return placed()[index]?.problem ?? (planner.answer?.isDraft ? null : of(planner.answer)) ?? null;
}

/** Where a sensor is at this moment that a link carries; the state has the first moment only. */
function placeOnLink(index) {
  const { answer, moment } = planner, one = placed()[index], place = one && sensorOf(one)?.on && answer?.moment === moment ? answer.places?.[index] : null;
  return place ? sixOf(place) : null;
}
/** A sensor on a link stays where it was dragged to until it is counted there. */
function keepPlace({ index, at }) {
  if (planner.answer?.places?.[index]) planner.answer.places[index] = { at_m: at.position_m, turned_deg: [at.pan_deg, at.tilt_deg, at.roll_deg] };
}

/** Where a placed sensor is now, also while it is dragged. */
const poseNow = index => planner.draft?.index === index ? planner.draft.at : placeOnLink(index) ?? (placed()[index]?.at_m ? sixOf(placed()[index]) : null);

const forwardOf = ({ pan_deg: pan, tilt_deg: tilt }) => [Math.cos(tilt * RAD) * Math.cos(pan * RAD), Math.cos(tilt * RAD) * Math.sin(pan * RAD), Math.sin(tilt * RAD)];
/** How a direction in a sensor's frame (x ahead, y left, z up) is turned into the world. */
function turnedBy({ pan_deg, tilt_deg, roll_deg }, [x, y, z]) {
  const [cr, sr, ct, st, cp, sp] = [roll_deg, tilt_deg, pan_deg].flatMap(one => [Math.cos(one * RAD), Math.sin(one * RAD)]);
  const [y1, z1] = [cr * y - sr * z, sr * y + cr * z];
  const [x2, z2] = [ct * x - st * z1, st * x + ct * z1];
  return [cp * x2 - sp * y1, sp * x2 + cp * y1, z2];
}

/** Pan and tilt of a direction; straight up or down keeps the pan. */
function aimed(at, along) {
  const [x, y, z] = unitOf(along), level = Math.hypot(x, y);
  return { ...at, pan_deg: level < 1e-3 ? at.pan_deg : Math.atan2(y, x) / RAD, tilt_deg: Math.asin(Math.max(-1, Math.min(1, z))) / RAD };
}
const aimedAt = (at, target) => aimed(at, minus(target, at.position_m));

/** How far a body is off its surface. */
const OFF_M = 0.05;

/** A pose on a surface: off it, turned as before where that looks away from it, else along its normal; from a wall to the next the turn goes along. */
function mounted(at, hit, before) {
  const position_m = plus(hit.at, times(hit.normal, OFF_M));
  let next = { ...at, position_m };
  const isUpright = normal => Math.abs(normal[2]) < 0.7;
  if (before && isUpright(before) && isUpright(hit.normal)) next.pan_deg = at.pan_deg + (Math.atan2(hit.normal[1], hit.normal[0]) - Math.atan2(before[1], before[0])) / RAD;
  if (dot(forwardOf(next), hit.normal) < 0.12) next = { ...aimed(next, hit.normal), roll_deg: 0 };
  return next;
}

/** Whether what is held lies or stands level, with its origin at a corner. */
function isLevelArmed() {
  const { sensor, model } = planner.armed ?? {}, { sensors, catalogue } = planner.state;
  return sensor ? !!sensors.find(one => one.name === sensor)?.level : ["pad", "gate"].includes(catalogue.find(one => one.model === model)?.kind);
}

/** A new sensor's pose on a surface: along the normal of a wall and somewhat down, straight down from a ceiling. */
function firstPose(hit) {
  if (isLevelArmed()) return { position_m: hit.at, pan_deg: 0, tilt_deg: 0, roll_deg: 0 };
  const at = { position_m: plus(hit.at, times(hit.normal, OFF_M)), pan_deg: 0, tilt_deg: 0, roll_deg: 0 };
  const along = aimed(at, hit.normal);
  return Math.abs(hit.normal[2]) < 0.7 ? { ...along, tilt_deg: hit.at[2] > 1.5 ? -25 : 0 } : along;
}

/** To steps of 10 cm and 5°. */
const stepped = at => ({ position_m: at.position_m.map(x => Math.round(x * 10) / 10), pan_deg: Math.round(at.pan_deg / 5) * 5, tilt_deg: Math.round(at.tilt_deg / 5) * 5, roll_deg: Math.round(at.roll_deg / 5) * 5 });

/** The listed poses of a sensor that stand somewhere; those that were dragged count, too. On a link they are known at the first moment only. */
const listed = sensor => (sensor?.poses ?? []).filter(pose => pose.at_m && (!sensor.on || planner.moment === 0));

/** The listed pose that is nearest to a place on the screen, of those at one place the one that is turned most alike; null where none is near. */
function nearestListed(sensor, at, distance, most) {
  let best = null;
  for (const pose of listed(sensor)) {
    const off = distance(pose.at_m);
    if (off > most) continue;
    const unlike = 1 - dot(forwardOf(at), forwardOf(sixOf(pose)));
    if (!best || off < best.off - 1e-6 || off < best.off + 1e-6 && unlike < best.unlike) best = { pose, off, unlike };
  }
  return best?.pose ?? null;
}

const metres = (value, digits = 2) => `${value.toFixed(digits)} m`;
const money = value => value === null || value === undefined ? "–" : `${value.toLocaleString("en-US", { maximumFractionDigits: 2 })}${planner.state?.currency ? ` ${planner.state.currency}` : ""}`;
const grouped = value => value === null || value === undefined ? "–" : Math.round(value).toLocaleString("en-US");
const percent = value => value === null || value === undefined ? "–" : `${(100 * value).toFixed(1)} %`;
