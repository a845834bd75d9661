// Where a ray meets surfaces: what a pointer points at.

/** A box around a part's corners, found once. */
function boxOf(part) {
  if (!part.box) {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i < part.at.length; i++) { const axis = i % 3; if (part.at[i] < low[axis]) low[axis] = part.at[i]; if (part.at[i] > high[axis]) high[axis] = part.at[i]; }
    part.box = [low, high];
  }
  return part.box;
}

/** Whether a ray meets a box before a distance. */
function meetsBox(from, along, [low, high], most) {
  let first = 0, last = most;
  for (let axis = 0; axis < 3; axis++) {
    const inverse = 1 / along[axis];
    const a = (low[axis] - 1e-6 - from[axis]) * inverse, b = (high[axis] + 1e-6 - from[axis]) * inverse;
    if (Number.isNaN(a) || Number.isNaN(b)) continue;
    first = Math.max(first, Math.min(a, b));
    last = Math.min(last, Math.max(a, b));
  }
  return first <= last;
}

/** Where a ray first meets a surface: distance, place and a normal towards the ray's begin; null where it does not. What is hidden counts for nothing. */
function meeting(from, along, part, isHidden = () => false, most = Infinity) {
  if (!meetsBox(from, along, boxOf(part), most)) return null;
  const { at, faces } = part;
  let best = most, found = null;
  const [ox, oy, oz] = from, [dx, dy, dz] = along;
  for (let f = 0; f < faces.length; f += 3) {
    const a = 3 * faces[f], b = 3 * faces[f + 1], c = 3 * faces[f + 2];
    const ux = at[b] - at[a], uy = at[b + 1] - at[a + 1], uz = at[b + 2] - at[a + 2];
    const vx = at[c] - at[a], vy = at[c + 1] - at[a + 1], vz = at[c + 2] - at[a + 2];
    const px = dy * vz - dz * vy, py = dz * vx - dx * vz, pz = dx * vy - dy * vx;
    const area = ux * px + uy * py + uz * pz;
    if (area > -1e-12 && area < 1e-12) continue;
    const tx = ox - at[a], ty = oy - at[a + 1], tz = oz - at[a + 2];
    const u = (tx * px + ty * py + tz * pz) / area;
    if (u < 0 || u > 1) continue;
    const qx = ty * uz - tz * uy, qy = tz * ux - tx * uz, qz = tx * uy - ty * ux;
    const v = (dx * qx + dy * qy + dz * qz) / area;
    if (v < 0 || u + v > 1) continue;
    const distance = (vx * qx + vy * qy + vz * qz) / area;
    if (distance <= 1e-6 || distance >= best) continue;
    const place = [ox + distance * dx, oy + distance * dy, oz + distance * dz];
    if (isHidden(place, part)) continue;
    const normal = unitOf([uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx]);
    best = distance;
    found = { distance, at: place, normal: dot(normal, along) > 0 ? times(normal, -1) : normal };
  }
  return found;
}

/** How far along a line the place is that comes nearest to a ray; both directions are units. */
function nearestAlong(begin, direction, from, along) {
  const between = minus(begin, from), cosine = dot(direction, along), apart = 1 - cosine * cosine;
  return apart < 1e-4 ? 0 : (cosine * dot(between, along) - dot(between, direction)) / apart;
}

/** Where a ray meets a plane through a place; null where it runs away from it. */
function onPlane(from, along, through, normal) {
  const slope = dot(along, normal), distance = dot(minus(through, from), normal) / slope;
  return Math.abs(slope) > 1e-4 && distance > 0 ? plus(from, times(along, distance)) : null;
}

/** The edges of triangles at which their surface bends or ends, as pairs of places. */
function creases({ at, faces }, degrees = 25) {
  const known = new Map(), least = Math.cos(degrees * Math.PI / 180), found = [];
  const key = corner => `${Math.round(at[3 * corner] * 1e4)},${Math.round(at[3 * corner + 1] * 1e4)},${Math.round(at[3 * corner + 2] * 1e4)}`;
  const place = corner => [at[3 * corner], at[3 * corner + 1], at[3 * corner + 2]];
  const keys = Array.from({ length: at.length / 3 }, (_, n) => key(n));
  for (let f = 0; f < faces.length; f += 3) {
    const three = [faces[f], faces[f + 1], faces[f + 2]], [a, b, c] = three.map(place), across = crossed(minus(b, a), minus(c, a));
    if (lengthOf(across) < 1e-12) continue;
    const normal = unitOf(across);
    three.forEach((corner, n) => {
      const other = three[(n + 1) % 3], name = keys[corner] < keys[other] ? `${keys[corner]} ${keys[other]}` : `${keys[other]} ${keys[corner]}`;
      const edge = known.get(name);
      if (edge) edge.normals.push(normal); else known.set(name, { ends: [...place(corner), ...place(other)], normals: [normal] });
    });
  }
  for (const { ends, normals } of known.values()) if (normals.length === 1 || normals.some(normal => Math.abs(dot(normal, normals[0])) < least)) found.push(...ends);
  return found;
}
