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
  const step = [1, size[0], size[0] * size[1]];
  const places = [], faces = [];
  for (let axis = 0; axis < 3; axis++) for (const side of [0, 1]) {
    const along = axis === 0 ? 1 : 0, across = 3 - axis - along, to = side ? step[axis] : -step[axis];
    const at = [0, 0, 0];
    for (at[axis] = 0; at[axis] < size[axis]; at[axis]++) {
      const edge = side ? at[axis] === size[axis] - 1 : at[axis] === 0;
      for (at[across] = 0; at[across] < size[across]; at[across]++) {
        let begin = -1;
        const row = at[axis] * step[axis] + at[across] * step[across];
        for (let n = 0; n <= size[along]; n++) {
          const here = row + n * step[along];
          const face = n < size[along] && voxels[here] === wanted && (edge || voxels[here + to] !== wanted);
          if (face && begin < 0) begin = n;
          if (face || begin < 0) continue;
          const first = places.length / 3, low = [...at];
          low[axis] += side;
          for (const [a, b] of [[begin, 0], [n, 0], [n, 1], [begin, 1]]) {
            const point = [...low];
            point[along] = a;
            point[across] += b;
            for (let r = 0; r < 3; r++) places.push((point[r] + origin[r]) * h);
          }
          faces.push(first, first + 1, first + 2, first, first + 2, first + 3);
          begin = -1;
        }
      }
    }
  }
  return { at: places, faces };
}

/** The lowest voxel of a class and the one beyond the highest, and only what is within: a smaller grid of the same voxels. */
function cropped(voxels, isWanted, { size, origin }) {
  const [nx, ny, nz] = size, low = [nx, ny, nz], high = [0, 0, 0];
  for (let z = 0, i = 0; z < nz; z++) for (let y = 0; y < ny; y++) for (let x = 0; x < nx; x++, i++) {
    if (!isWanted(voxels[i])) continue;
    if (x < low[0]) low[0] = x;
    if (x >= high[0]) high[0] = x + 1;
    if (y < low[1]) low[1] = y;
    if (y >= high[1]) high[1] = y + 1;
    if (z < low[2]) low[2] = z;
    high[2] = z + 1;
  }
  const own = high.map((n, axis) => Math.max(0, n - low[axis]));
  const part = new Uint8Array(own[0] * own[1] * own[2]);
  for (let z = 0, i = 0; z < own[2]; z++) for (let y = 0; y < own[1]; y++) {
    const row = low[0] + nx * (low[1] + y + ny * (low[2] + z));
    for (let x = 0; x < own[0]; x++) part[i++] = voxels[row + x];
  }
  return { voxels: part, grid: { size: own, origin: origin.map((n, axis) => n + (part.length ? low[axis] : 0)) } };
}

/** How much of the air around each voxel is taken, near it and farther off, as two bytes: what darkens corners. */
function crowding(isTaken, [nx, ny, nz]) {
  const pairs = new Uint8Array(2 * nx * ny * nz);
  [2, 5].forEach((reach, channel) => {
    let field = Float32Array.from(isTaken, taken => taken ? 255 : 0);
    [[nx, 1], [ny, nx], [nz, nx * ny]].forEach(([count, step]) => {
      const next = new Float32Array(field.length);
      for (let i = 0; i < field.length; i++) {
        if (Math.floor(i / step) % count) continue;
        let sum = 0;
        for (let n = 0; n < Math.min(reach, count); n++) sum += field[i + n * step];
        for (let n = 0; n < count; n++) {
          if (n + reach < count) sum += field[i + (n + reach) * step];
          if (n - reach > 0) sum -= field[i + (n - reach - 1) * step];
          next[i + n * step] = sum / (2 * reach + 1);
        }
      }
      field = next;
    });
    for (let i = 0; i < field.length; i++) pairs[2 * i + channel] = field[i];
  });
  return pairs;
}
