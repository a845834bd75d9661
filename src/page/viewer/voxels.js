// Classes of voxels: how they come over the wire, and their outsides as triangles. Voxels follow with x fastest, then y, then z.

/** Classes from their runs, as many as are wanted; there are so many kinds of them. */
function decoded(bytes, kinds, count) {
  const all = new Uint16Array(count);
  let at = 0;
  for (let i = 0; i < bytes.length;) {
    let number = 0, unit = 1, byte;
    do { byte = bytes[i++]; number += (byte & 127) * unit; unit *= 128; } while (byte > 127);
    const length = Math.floor(number / kinds);
    all.fill(number % kinds, at, at += length);
  }
  return all;
}

/** The outside of the voxels of a class, as triangles; faces beside each other are one. */
function mesh(voxels, wanted, { size, origin }, h) {
  const step = [1, size[0], size[0] * size[1]], at = [0, 0, 0], point = [0, 0, 0];
  let places = new Float32Array(1 << 12), faces = new Uint32Array(1 << 11), corners = 0;
  const grow = (old, make) => { const next = make(2 * old.length); next.set(old); return next; };
  const put = (axis, along, across, from, to, side) => {
    if (3 * corners + 12 > places.length) places = grow(places, n => new Float32Array(n));
    if (1.5 * corners + 6 > faces.length) faces = grow(faces, n => new Uint32Array(n));
    for (let c = 0; c < 4; c++) {
      point[axis] = at[axis] + side;
      point[along] = c === 0 || c === 3 ? from : to;
      point[across] = at[across] + (c > 1 ? 1 : 0);
      for (let r = 0; r < 3; r++) places[3 * (corners + c) + r] = (point[r] + origin[r]) * h;
    }
    const face = 1.5 * corners;
    for (let n = 0; n < 6; n++) faces[face + n] = corners + (n < 3 ? n : n === 3 ? 0 : n - 2);
    corners += 4;
  };
  for (let axis = 0; axis < 3; axis++) for (const side of [0, 1]) {
    const along = axis === 0 ? 1 : 0, across = 3 - axis - along, to = side ? step[axis] : -step[axis];
    for (at[axis] = 0; at[axis] < size[axis]; at[axis]++) {
      const edge = side ? at[axis] === size[axis] - 1 : at[axis] === 0;
      for (at[across] = 0; at[across] < size[across]; at[across]++) {
        let begin = -1, here = at[axis] * step[axis] + at[across] * step[across];
        for (let n = 0; n <= size[along]; n++, here += step[along]) {
          const face = n < size[along] && voxels[here] === wanted && (edge || voxels[here + to] !== wanted);
          if (face && begin < 0) begin = n;
          if (face || begin < 0) continue;
          put(axis, along, across, begin, n, side);
          begin = -1;
        }
      }
    }
  }
  return { at: places.subarray(0, 3 * corners), faces: faces.subarray(0, 1.5 * corners) };
}

/** The lowest wanted voxel and the one beyond the highest. */
function boundsOf(voxels, isWanted, [nx, ny, nz]) {
  const low = [nx, ny, nz], high = [0, 0, 0];
  for (let z = 0, i = 0; z < nz; z++) for (let y = 0; y < ny; y++) for (let x = 0; x < nx; x++, i++) {
    if (!isWanted(voxels[i])) continue;
    if (x < low[0]) low[0] = x;
    if (x >= high[0]) high[0] = x + 1;
    if (y < low[1]) low[1] = y;
    if (y >= high[1]) high[1] = y + 1;
    if (z < low[2]) low[2] = z;
    high[2] = z + 1;
  }
  return high[0] ? [low, high] : [[0, 0, 0], [0, 0, 0]];
}

/** The smallest grid that holds all wanted voxels, and what is in it. */
function cropped(voxels, isWanted, { size, origin }) {
  const [nx, ny] = size, [low, high] = boundsOf(voxels, isWanted, size);
  const own = minus(high, low);
  const part = new Uint8Array(own[0] * own[1] * own[2]);
  for (let z = 0, i = 0; z < own[2]; z++) for (let y = 0; y < own[1]; y++) {
    const row = low[0] + nx * (low[1] + y + ny * (low[2] + z));
    for (let x = 0; x < own[0]; x++) part[i++] = voxels[row + x];
  }
  return { voxels: part, grid: { size: own, origin: plus(origin, low) } };
}

/** How much of the air around each voxel is taken, near it and farther off, as two bytes: what darkens corners. */
function crowding(isTaken, [nx, ny, nz]) {
  const pairs = new Uint8Array(2 * nx * ny * nz);
  const axes = [[nx, 1, ny, nx, nz, nx * ny], [ny, nx, nx, 1, nz, nx * ny], [nz, nx * ny, nx, 1, ny, nx]];
  [2, 5].forEach((reach, channel) => {
    let field = new Float32Array(isTaken.length), next = new Float32Array(isTaken.length);
    for (let i = 0; i < field.length; i++) field[i] = isTaken[i] ? 255 : 0;
    // The mean over a box, an axis after the other.
    for (const [count, step, outer, outerStep, inner, innerStep] of axes) {
      const share = 1 / (2 * reach + 1);
      for (let a = 0; a < outer; a++) for (let b = 0; b < inner; b++) {
        const begin = a * outerStep + b * innerStep;
        let sum = 0;
        for (let n = 0; n < Math.min(reach, count); n++) sum += field[begin + n * step];
        for (let n = 0, i = begin; n < count; n++, i += step) {
          if (n + reach < count) sum += field[i + reach * step];
          if (n > reach) sum -= field[i - (reach + 1) * step];
          next[i] = sum * share;
        }
      }
      [field, next] = [next, field];
    }
    for (let i = 0; i < field.length; i++) pairs[2 * i + channel] = field[i];
  });
  return pairs;
}
