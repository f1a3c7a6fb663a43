'use strict';
(() => {
// One view in its page: numbers are decoded, drawn, and turned by mouse, fingers and keys.

/** Whole numbers of the facts: 16-bit words, the low ones of all numbers before any high ones. */
async function wholeNumbers({data, count}) {
  const letters = atob(data), bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; ++i) bytes[i] = letters.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
  const words = new Uint16Array(await new Response(stream).arrayBuffer());
  if (words.length === count) return words;
  return Uint32Array.from({length: count}, (_, i) => words[i] + 65536 * words[count + i]);
}

/** A property of the spheres: a coordinate, the radius, or a column of the pack. */
class Property {
  constructor(facts, numbers) {
    Object.assign(this, facts);
    this.numbers = numbers;
    this.none = facts.whole ? -1 : 65535;  // stands for no number
    this.least = Infinity;
    this.most = -Infinity;
    for (const n of numbers)
      if (n !== this.none) {
        if (n < this.least) this.least = n;
        if (n > this.most) this.most = n;
      }
  }
  valueOf(number) { return this.lo + this.step * number; }
  /** The value of a sphere as text. */
  textOf(i) {
    const n = this.numbers[i];
    if (n === this.none) return '–';
    if (this.names) return this.names[this.valueOf(n)];
    return this.format(n) + (this.unit ? ' ' + this.unit : '');
  }
  /** As many digits as the steps between values resolve. */
  format(number) {
    const value = this.valueOf(number);
    if (this.whole) return String(value);
    if (!(this.step > 0)) return String(Number(value.toPrecision(6)));
    return value.toFixed(Math.min(12, Math.max(0, 1 - Math.floor(Math.log10(this.step)))));
  }
}

/** Rows of the spheres, and their properties: x, y, z, radius, columns. */
async function propertiesOf({spheres, rows: list, columns}) {
  let row = 0;
  const rows = list ? Uint32Array.from(await wholeNumbers(list), n => row += list.lo + n)
    : Uint32Array.from({length: spheres[0].count}, (_, i) => i);
  const named = spheres.map((part, d) => ({name: ['x', 'y', 'z', 'radius'][d], unit: 'mm', ...part}));
  return {rows, properties: await Promise.all([...named, ...columns].map(
    async part => new Property(part, part.data ? await wholeNumbers(part) : rows)))};
}

/** Coordinates less `middle`, and other parts of points, one after the other. */
function joined(parts, middle) {
  const points = new Float32Array(parts.length * parts[0].numbers.length);
  parts.forEach(({numbers, lo, step}, d) => {
    const from = lo - (middle[d] ?? 0);
    for (let i = 0; i < numbers.length; ++i) points[parts.length * i + d] = from + step * numbers[i];
  });
  return points;
}

/** What there is to draw, around its middle. */
async function sceneOf(facts, properties) {
  const {plane, middle, half} = facts;
  const spheres = joined(properties.slice(0, 4), middle);
  let squares = 0, cubes = 0;
  for (let i = 3; i < spheres.length; i += 4) {
    squares += spheres[i] ** 2;
    cubes += spheres[i] ** 3;
  }
  // Of triangles; in the plane, without corners, the ends of lines.
  const {points, corners} = facts.wall ?? {points: []};
  const parts = await Promise.all(points.map(
    async part => ({...part, numbers: await wholeNumbers(part)})));
  return {
    plane, middle, half, size: Math.hypot(...half), count: spheres.length / 4, spheres,
    smallest: properties[3].lo,
    optical: cubes / squares,  // the radius that sets how far one looks into a pack
    wall: facts.wall && {points: joined(parts, middle),
      corners: corners && Uint32Array.from(await wholeNumbers(corners))}
  };
}
