// The numbers of the page. Arrays are gzipped and in base64; what was done to them is described in encoding.py.

async function unpacked(id) {
  const text = document.getElementById(id).textContent.trim();
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Small differences of either sign are stored as 0, 1, 2, 3, ... for 0, -1, 1, -2, ...
const signed = (n) => (n >>> 1) ^ -(n & 1);

// Numbers of `size` bytes whose first bytes come first, then their second bytes, ...
function fromPlanes(bytes, begin, count, size) {
  const found = new Uint32Array(count);
  for (let plane = 0; plane < size; plane++) {
    const start = begin + plane * count;
    for (let i = 0; i < count; i++) found[i] |= bytes[start + i] << (8 * plane);
  }
  return found;
}

// Positions [rod, node, 3] of one frame, as whole numbers, from their second differences along each rod.
function rodPoints(bytes, frame, rods, nodes) {
  const count = rods * nodes * 3;
  const stored = fromPlanes(bytes, frame * count * 2, count, 2);
  const points = new Uint16Array(count);
  for (let rod = 0, k = 0; rod < rods; rod++) {
    for (let node = 0; node < nodes; node++) {
      for (let axis = 0; axis < 3; axis++, k++) {
        const before = node > 0 ? points[k - 3] : 0;
        const slope = node > 1 ? before - points[k - 6] : 0;
        points[k] = before + slope + signed(stored[k]);
      }
    }
  }
  return points;
}

// Colours [rod, node] of one frame, 0 to 254, and 255 where there is no value, from differences along each rod.
function rodValues(bytes, frame, rods, nodes) {
  const values = new Uint8Array(rods * nodes);
  for (let k = 0, start = frame * values.length; k < values.length; k++) {
    values[k] = (k % nodes ? values[k - 1] : 0) + bytes[start + k];
  }
  return values;
}

// Points of a membrane at all frames [frame][point × 3], as whole numbers, from differences from frame to frame.
function sheetPoints(bytes, frames, count) {
  const all = [];
  for (let frame = 0; frame < frames; frame++) {
    const stored = fromPlanes(bytes, frame * count * 2, count, 2);
    const points = new Uint16Array(count);
    for (let k = 0; k < count; k++) points[k] = (frame ? all[frame - 1][k] : 0) + signed(stored[k]);
    all.push(points);
  }
  return all;
}

function sheetTriangles(bytes, count) {
  const stored = fromPlanes(bytes, 0, count, 4);
  for (let k = 0; k < count; k++) stored[k] = (k ? stored[k - 1] : 0) + signed(stored[k]);
  return stored;
}

// Unit normals of a mesh [point × 3]: means over the triangles at each point, weighted by their areas.
function normalsOf(points, triangles) {
  const normals = new Float32Array(points.length);
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [3 * triangles[t], 3 * triangles[t + 1], 3 * triangles[t + 2]];
    const u = [0, 1, 2].map((i) => points[b + i] - points[a + i]);
    const v = [0, 1, 2].map((i) => points[c + i] - points[a + i]);
    const n = cross(u, v);
    for (const corner of [a, b, c]) for (let i = 0; i < 3; i++) normals[corner + i] += n[i];
  }
  for (let k = 0; k < normals.length; k += 3) {
    const size = Math.hypot(normals[k], normals[k + 1], normals[k + 2]) || 1;
    for (let i = 0; i < 3; i++) normals[k + i] /= size;
  }
  return normals;
}

async function loaded(facts) {
  const rods = [];
  for (const [index, ensemble] of facts.rods.entries()) {
    rods.push({ ...ensemble, points: await unpacked(`points${index}`),
      values: await unpacked(`values${index}`) });
  }
  const sheets = [];
  for (const [index, sheet] of facts.sheets.entries()) {
    const triangles = sheetTriangles(await unpacked(`triangles${index}`), sheet.triangles * 3);
    const tints = sheet.coloured ? await unpacked(`tints${index}`) : null;
    sheets.push({ ...sheet, triangles, tints,
      points: sheetPoints(await unpacked(`sheet${index}`), sheet.frames, sheet.points * 3) });
  }
  return { rods, sheets };
}
