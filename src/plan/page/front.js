// What was found, drawn: what sets cost against their scores, or against what they pass, a row each. Today's plan is a
// diamond beside them, the proven bound is dashed.
const isKnown = value => value !== null && value !== undefined;
const FRONT = { width: 320, left: 42, right: 14, top: 16, bottom: 30 };

/** The plan of today, as the question has it; null if its verdicts or its score are not known yet. */
function ownPoint() {
  const { state, judged } = planner;
  if (!state || !placed().length || judged?.version !== state.version || planner.dead !== null) return null;
  const { verdicts = [] } = judged, passed = verdicts.filter(one => one.passes === true).length;
  const score = judged.scores?.find(one => one.region === found.region && one.score === found.score)?.value ?? null;
  const known = found.isScore ? `score ${isKnown(score) ? score.toFixed(3) : "unknown"}` : `meets ${passed} of ${verdicts.length}`;
  return { cost: state.cost, sensors: placed().length, score, passes: passed === verdicts.length, words: `Your plan: ${isKnown(state.cost) ? `${money(state.cost)}, ` : ""}${known}` };
}

function showFront() {
  const home = element("front"), { points, bound, isScore } = found, own = ownPoint();
  // Without costs sets are compared by how many sensors they have.
  const hasCost = points.length > 0 && points.every(one => isKnown(one.cost)), acrossOf = one => hasCost ? one.cost : one.sensors ?? one.placed.length;
  const isDrawn = one => isKnown(acrossOf(one)) && (!isScore || isKnown(one.score)), drawn = points.filter(isDrawn), ownDrawn = own && isDrawn(own) ? own : null;
  home.hidden = !drawn.length;
  if (home.hidden) return;
  const parts = [...new Set(drawn.map(one => one.part ?? 0))].sort((a, b) => a - b), { width, left, right, top, bottom } = FRONT;
  const height = isScore ? 180 : top + bottom + 26 * Math.max(2, parts.length), floor = height - bottom;
  const all = [...drawn, ...ownDrawn ? [ownDrawn] : []], most = Math.max(...all.map(acrossOf), isScore || !hasCost ? 0 : bound?.cost ?? 0) * 1.08 || 1;
  const heights = [...all.map(one => one.score), bound?.score].filter(isKnown), low = Math.min(...heights), high = Math.max(...heights), room = (high - low) * 0.12 || 0.01;
  const x = value => left + value / most * (width - left - right);
  const y = one => isScore ? floor - (one.score - low + room) / (high - low + 2 * room) * (floor - top) : top + 13 + 26 * Math.max(0, parts.indexOf(one.part ?? 0));
  const unit = hasCost ? `cost${planner.state.currency ? ` in ${planner.state.currency}` : ""}` : "sensors";
  const nodes = [shape("path", { d: `M${left} 8V${floor}H${width - 8}`, class: "frame" }), word(left, height - 4, unit), word(x(most / 1.08), floor + 13, grouped(most / 1.08), { "text-anchor": "middle" }), word(left, floor + 13, "0", { "text-anchor": "middle" })];
  if (isScore) nodes.push(word(4, y({ score: high }) + 4, high.toFixed(2)), word(4, y({ score: low }) + 4, low.toFixed(2)));
  if (isScore && isKnown(bound?.score)) nodes.push(shape("path", { d: `M${left} ${px(y(bound))}H${width - 8}`, class: "bound" }), word(left + 4, y(bound) - 4, `no set is above ${bound.score.toFixed(3)}`));
  if (!isScore && hasCost && isKnown(bound?.cost)) nodes.push(shape("path", { d: `M${px(x(bound.cost))} 8V${floor}`, class: "bound", title: `No set that passes costs less than ${money(bound.cost)}` }), word(Math.min(x(bound.cost) + 4, width - 90), 12, `none below ${grouped(bound.cost)}`));
  drawn.forEach(point => nodes.push(shape("circle", { cx: px(x(acrossOf(point))), cy: px(y(point)), r: 5.5, class: point.is_proven ? "proven" : "open", title: `${isKnown(point.cost) ? `${money(point.cost)}, ` : ""}${point.words ?? ""}`, onclick: () => takeFound(point) })));
  if (ownDrawn) {
    const [cx, cy] = [x(acrossOf(ownDrawn)), y(ownDrawn)], isLeft = cx > width - 80;
    nodes.push(shape("path", { d: `M${px(cx)} ${px(cy - 7)}l7 7l-7 7l-7 -7z`, class: `own${isScore || ownDrawn.passes ? "" : " fails"}`, title: ownDrawn.words }), word(cx + (isLeft ? 8 : 10), cy + (isLeft ? 19 : 4), "your plan", { "text-anchor": isLeft ? "end" : "start", class: "of-own" }));
  }
  const picture = shape("svg", { viewBox: `0 0 ${width} ${height}`, width, height, role: "img", "aria-label": ownDrawn ? ownDrawn.words : "Sets that were found" });
  picture.append(...nodes);
  home.replaceChildren(picture);
}
