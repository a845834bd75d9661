// The program's words as the page says them: sensors by their letters, scores and conditions explained.

/** What the program calls a thing, what the page calls it, and what it means. */
const EXPLAINED = [
  ["as planned", "as planned", "Every sensor works and sits exactly where it is planned."],
  ["one sensor dead", "one sensor dead", "Any one of the sensors has failed; the worst of these cases counts."],
  ["two sensors dead", "two sensors dead", "Any two of the sensors have failed; the worst of these cases counts."],
  ["mounting error", "mounting error", "Sensors sit a little off their places, as [mounting_error] draws them; the worst draw counts."],
  ["postures", "postures", "People stand, kneel or lie as [postures] lists; the worst case counts."],
  ["parts_detected", "body parts detected", "The share of people's body parts that sensors hit often enough to notice (parts_detected)."],
  ["people_detected", "people detected", "The share of people of whom sensors notice any body part (people_detected)."],
  ["human_seen", "people seen", "The share of people's voxels that sensors hit (human_seen)."],
  ["seen_twice", "seen twice", "The share of the region that at least two sensors see (seen_twice)."],
  ["false_alarm", "false alarms", "The share of free voxels that sensors call occupied (false_alarm)."],
  ["nearest_unnoticed_m", "nearest unnoticed approach in m", "How close a body gets before any sensor notices it (nearest_unnoticed_m)."],
  ["approach_margin_m", "margin to the stopping distance in m", "How much farther than the robot needs to stop a body is when it is noticed (approach_margin_m)."],
  ["unnoticed_m2", "unnoticed floor in m²", "The floor that a body reaches without being noticed (unnoticed_m2)."],
  ["F1", "F1", "How well occupied space is recognised: 1 is perfect, 0 is useless. Missed and false voxels both lower it."],
];
const explanationOf = name => EXPLAINED.find(([own]) => own === name);

/** A word with its meaning on pointing at it. */
const explainedWord = name => { const [, words, meaning] = explanationOf(name); return made("abbr", { title: meaning }, words); };

/** A sentence of the program as nodes, its terms explained. */
function explained(words) {
  const terms = new RegExp(`(?<![\\w/])(${EXPLAINED.map(([name]) => name).join("|")})(?![\\w/])`);
  return words.split(terms).filter(part => part).map(part => explanationOf(part) ? explainedWord(part) : part);
}

/** Kinds of sensors that are not called by an English word. */
const KINDS_IN_WORDS = { rgbd: "RGB-D camera", rgb: "colour camera", lidar: "LIDAR", pad: "pressure mat", gate: "light curtain", cover: "proximity cover", rays: "rays of its own", recorded: "recorded map" };
const kindInWords = kind => KINDS_IN_WORDS[kind] ?? kind.replaceAll("_", " ");

/** Fields of the page by the keys of the study that an error names. */
const FIELDS_OF_KEYS = { "choose.budget": "Budget", "choose.at_most": "At most", "choose.always": "Placed sensors" };

/** An error of the program without the path of the study, which the page shows, and with the names of the page's fields. */
function plainError(words) {
  const bare = words.replaceAll(`${planner.state?.path}: `, "");
  return Object.entries(FIELDS_OF_KEYS).reduce((text, [key, name]) => text.replace(new RegExp(`${escaped(key)} = ([^:]*): `), `${name} $1 `), bare);
}

const escaped = text => text.replace(/[.*+?^${}()|[\]\\]/g, "\\$&");

/** A sentence with sensors of the plan as "B (camera)" in place of "camera:planned/1". */
const lettered = words => placed().reduce((text, one, index) => text.replace(new RegExp(`(?<![\\w:/-])${escaped(`${one.sensor}:${one.pose}`)}(?![\\w/-])`, "g"), () => `${letterAt(index)} (${one.sensor})`), words);

/** A verdict: its name, and in words how it comes about. */
function verdictLine(one) {
  const word = one.passes === true ? "PASS" : one.passes === false ? "FAIL" : "OPEN";
  const when = String(one.condition ?? "").replaceAll("_", " "), begin = `${one.name} (${when}): `, bare = (one.words ?? "").replace(/^[A-Z]+ +/, "");
  const words = bare.startsWith(begin) ? `${when}: ${bare.slice(begin.length)}` : bare;
  return made("li", { class: word }, made("b", {}, word), made("span", {}, made("strong", {}, one.name), made("small", {}, ...explained(lettered(words)))));
}

/** Below the verdicts the conditions under which they were judged. */
function conditionLines(verdicts) {
  const used = [...new Set(verdicts.map(one => String(one.condition ?? "").replaceAll("_", " ")))].map(explanationOf).filter(one => one);
  return used.map(([, words, meaning]) => made("p", { class: "soft" }, made("strong", {}, `${words[0].toUpperCase()}${words.slice(1)}`), `: ${meaning[0].toLowerCase()}${meaning.slice(1)}`));
}
