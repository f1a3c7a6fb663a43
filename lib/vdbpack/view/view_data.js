'use strict';
(() => {
// One view in its page: numbers are decoded, drawn, and turned by mouse, fingers and keys.

/** Bytes of base 64. */
function bytesOf(text) {
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; ++i) bytes[i] = letters.charCodeAt(i);
  return bytes;
}

async function inflated(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Whole numbers from their byte planes, lowest first. */
function joined(planes, count, width) {
  const numbers = width <= 2 ? new Uint16Array(count)
    : width <= 4 ? new Uint32Array(count) : new Float64Array(count);
  let factor = 1;
  for (let plane = 0; plane < width; ++plane, factor *= 256) {
    const from = plane * count;
    for (let i = 0; i < count; ++i) numbers[i] += planes[from + i] * factor;
  }
  return numbers;
}

/** All arrays of a view by name. */
async function arraysOf(facts, bytes) {
  let at = 0;
  const parts = facts.arrays.map(array => {
    const part = bytes.subarray(at, at + array.bytes);
    at += array.bytes;
    return inflated(part).then(planes => [array.name, joined(planes, array.count, array.planes)]);
  });
  return new Map(await Promise.all(parts));
}

/** Every third bit of 12, for each of the three places: x in the lowest 4 bits, then y, then z. */
const PLACES_OF_BITS = (() => {
  const table = new Uint16Array(4096);
  for (let bits = 0; bits < 4096; ++bits)
    for (let bit = 0; bit < 12; ++bit)
      if (bits >> bit & 1) table[bits] |= 1 << (bit % 3 * 4 + Math.floor(bit / 3));
  return table;
})();

/** Centers (relative to `middle`, as x, y, z, radius) from differences of Morton codes. */
function spheresOf(facts, arrays, middle) {
  const {count, outer, inner, lo, step, radius} = facts;
  const codes = arrays.get('code'), radii = arrays.get('radius');
  const spheres = new Float32Array(4 * count);
  const from = lo.map((low, d) => low - middle[d]);
  let code = 0;
  for (let i = 0; i < count; ++i) {
    code = i === outer || i === outer + inner ? codes[i] : code + codes[i];
    let high = Math.floor(code / 16777216), low = code - high * 16777216;
    const a = PLACES_OF_BITS[low & 4095], b = PLACES_OF_BITS[low >> 12];
    const c = PLACES_OF_BITS[high & 4095], d = PLACES_OF_BITS[high >> 12];
    for (let k = 0; k < 3; ++k) {
      const shift = 4 * k;
      const place = (a >> shift & 15) | (b >> shift & 15) << 4 | (c >> shift & 15) << 8 |
        (d >> shift & 15) << 12;
      spheres[4 * i + k] = from[k] + step * place;
    }
    spheres[4 * i + 3] = radius.lo + radius.step * radii[i];
  }
  return spheres;
}

/** Points of the wall or an outline, relative to `middle`. */
function pointsOf(name, facts, arrays, middle) {
  const parts = ['x', 'y', 'z'].map(axis => arrays.get(`${name}-${axis}`));
  const points = new Float32Array(3 * parts[0].length);
  parts.forEach((part, d) => {
    for (let i = 0; i < part.length; ++i)
      points[3 * i + d] = facts.lo[d] - middle[d] + facts.step * part[i];
  });
  return points;
}

function makeUnit(normals) {
  for (let i = 0; i < normals.length; i += 3) {
    const size = Math.hypot(normals[i], normals[i + 1], normals[i + 2]) || 1;
    for (let d = 0; d < 3; ++d) normals[i + d] /= size;
  }
  return normals;
}

/** Sums of the normals of the triangles around each vertex, of unit length. */
function normalsOf(points, corners) {
  const normals = new Float32Array(points.length);
  for (let t = 0; t < corners.length; t += 3) {
    const [a, b, c] = [0, 1, 2].map(k => 3 * corners[t + k]);
    const u = [0, 1, 2].map(d => points[b + d] - points[a + d]);
    const v = [0, 1, 2].map(d => points[c + d] - points[a + d]);
    const n = cross(u, v);
    for (const at of [a, b, c]) for (let d = 0; d < 3; ++d) normals[at + d] += n[d];
  }
  return makeUnit(normals);
}

/** Means with the neighbors: coarse walls have slivers, which would glitter. */
function smoothed(normals, corners) {
  const sums = new Float32Array(normals.length);
  for (let t = 0; t < corners.length; t += 3)
    for (let k = 0; k < 3; ++k)
      for (let j = 0; j < 3; ++j)
        for (let d = 0; d < 3; ++d)
          sums[3 * corners[t + k] + d] += normals[3 * corners[t + j] + d];
  return makeUnit(sums);
}

/** The wall as points, normals and corners of triangles; null: none. */
function wallOf(facts, arrays, middle) {
  if (!facts.wall) return null;
  const points = pointsOf('wall', facts.wall, arrays, middle);
  const parts = ['a', 'b', 'c'].map(corner => arrays.get(`wall-${corner}`));
  const corners = new Uint32Array(3 * parts[0].length);
  parts.forEach((part, k) => part.forEach((vertex, i) => { corners[3 * i + k] = vertex; }));
  // Flat walls of few triangles, such as a box, keep their edges: each triangle has its own corners.
  if (parts[0].length <= 500) {
    const own = new Float32Array(3 * corners.length);
    corners.forEach((vertex, i) => own.set(points.subarray(3 * vertex, 3 * vertex + 3), 3 * i));
    const each = corners.map((vertex, i) => i);
    return {points: own, normals: normalsOf(own, each), corners: each};
  }
  let normals = normalsOf(points, corners);
  if (facts.wall.triangles < facts.wall.of)
    for (let pass = 0; pass < 2; ++pass) normals = smoothed(normals, corners);
  return {points, normals, corners};
}

/** A property of the spheres by which they can be colored: radius or a column of the pack. */
class Property {
  constructor(facts, numbers) {
    Object.assign(this, facts);
    this.numbers = numbers;
    this.none = !facts.whole && !facts.isRow ? 65535 : -1;  // stands for no number
    let least = Infinity, most = -Infinity;
    for (const n of numbers)
      if (n !== this.none) {
        if (n < least) least = n;
        if (n > most) most = n;
      }
    this.least = least;
    this.most = most;
  }
  valueOf(number) { return (this.lo ?? 0) + (this.step ?? 1) * number; }
  /** The value of a sphere as text. */
  textOf(i) {
    const n = this.numbers[i];
    if (n === this.none) return '–';
    if (this.words) return this.words[n];
    return this.format(this.valueOf(n)) + (this.unit ? ' ' + this.unit : '');
  }
  /** As many digits as the steps between values resolve. */
  format(value) {
    if (this.whole || this.isRow) return String(value);
    if (!(this.step > 0)) return String(Number(value.toPrecision(6)));
    return value.toFixed(Math.min(12, Math.max(0, 1 - Math.floor(Math.log10(this.step)))));
  }
}

function propertiesOf(facts, arrays) {
  const radius = new Property({name: 'radius', unit: 'mm', ...facts.radius}, arrays.get('radius'));
  const columns = facts.columns.map(column => new Property(
    column, column.isRow ? arrays.get('row') : arrays.get(':' + column.name)));
  return [radius, ...columns];
}

