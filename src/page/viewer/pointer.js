// What mouse, fingers and keys do to a stage, unless a hook wants them.

/** Listens to a canvas and turns, shifts and brings nearer what it shows. */
function handle(canvas, { hooks, pointed, turn, shift, nearer }) {
  const fingers = new Map();
  let moved = 0, held = null;
  const middleOf = all => [0, 1].map(i => all.reduce((sum, at) => sum + at[i], 0) / all.length);
  const apart = all => all.length > 1 ? Math.hypot(all[0][0] - all[1][0], all[0][1] - all[1][1]) : 0;
  const drop = (event, isDropped) => { const own = held; held = null; own?.end(event, isDropped); };
  canvas.addEventListener("pointerdown", event => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, [event.offsetX, event.offsetY]);
    if (fingers.size > 1) { drop(event, true); return; }
    moved = 0;
    held = event.button === 0 ? hooks.grab?.(event) ?? null : null;
  });
  canvas.addEventListener("pointermove", event => {
    if (!fingers.has(event.pointerId)) {
      const found = pointed(event.offsetX, event.offsetY);
      canvas.title = found ? found.part.words(found.n) : "";
      canvas.style.cursor = hooks.hover?.(event, found) ?? (found ? "pointer" : "grab");
      return;
    }
    const before = [...fingers.values()];
    fingers.set(event.pointerId, [event.offsetX, event.offsetY]);
    const after = [...fingers.values()], [dx, dy] = [0, 1].map(i => middleOf(after)[i] - middleOf(before)[i]);
    moved += Math.abs(dx) + Math.abs(dy);
    if (held) held.move(event);
    else if (after.length > 1) { shift(dx, dy); if (apart(after) > 0 && apart(before) > 0) nearer(apart(before) / apart(after)); }
    else if (event.shiftKey || event.buttons & 6) shift(dx, dy);
    else turn(-dx / 150, dy / 150);
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, event => {
    const isClick = end === "pointerup" && moved < 4 && fingers.size === 1 && event.button === 0;
    fingers.delete(event.pointerId);
    if (held) { drop(event, end === "pointercancel"); if (!isClick) return; }
    if (!isClick || hooks.click?.(event)) return;
    const found = pointed(event.offsetX, event.offsetY);
    found?.part.heard?.(found.n);
  });
  canvas.addEventListener("dblclick", event => hooks.double?.(event));
  canvas.addEventListener("wheel", event => { event.preventDefault(); nearer(Math.exp(Math.sign(event.deltaY) * 0.12)); }, { passive: false });
  canvas.addEventListener("contextmenu", event => event.preventDefault());
  const KEYS = { ArrowLeft: () => turn(-0.12, 0), ArrowRight: () => turn(0.12, 0), ArrowUp: () => turn(0, 0.08), ArrowDown: () => turn(0, -0.08), "+": () => nearer(0.88), "-": () => nearer(1.14) };
  canvas.addEventListener("keydown", event => {
    if (hooks.key?.(event)) return;
    const heard = KEYS[event.key];
    if (heard && !event.ctrlKey && !event.metaKey) { event.preventDefault(); heard(); }
  });
}
