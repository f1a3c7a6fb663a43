'use strict';
(() => {
// One view in its page: numbers are decoded, drawn, and turned by mouse, fingers and keys.

/** Whole numbers of the facts, of 16 or 32 bits. */
async function wholeNumbers({data, count}) {
  const letters = atob(data), bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; ++i) bytes[i] = letters.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
  const buffer = await new Response(stream).arrayBuffer();
  return new (buffer.byteLength > 2 * count ? Uint32Array : Uint16Array)(buffer);
}

/** A property of the spheres: a coordinate, the radius, or a column of the pack. */
class Property {
  constructor(facts, numbers) {
    Object.assign(this, facts);
    this.numbers = numbers;
    this.none = facts.whole ? -1 : 65535;  // stands for no number
    const known = numbers.filter(n => n !== this.none);
    this.least = known.reduce((least, n) => Math.min(least, n), Infinity);
    this.most = known.reduce((most, n) => Math.max(most, n), -Infinity);
  }
  /** The value of a sphere as text, with as many digits as the steps between values resolve. */
  textOf(i) {
    const {lo, step, names, unit} = this, n = this.numbers[i], value = lo + step * n;
    if (n === this.none) return '–';
    if (names) return names[value];
    const text = this.whole ? value : !(step > 0) ? Number(value.toPrecision(6))
      : value.toFixed(clamp(1 - Math.floor(Math.log10(step)), 0, 12));
    return text + (unit && ' ' + unit);
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
    // Of solids, which have no spheres, lengths that suit their size.
    solids: facts.solids, smallest: facts.solids ? 1e-4 * Math.hypot(...half) : properties[3].lo,
    // The radius that sets how far one looks into a pack.
    optical: facts.solids ? 0.006 * Math.hypot(...half) : cubes / squares,
    wall: facts.wall && {points: joined(parts, middle),
      corners: corners && Uint32Array.from(await wholeNumbers(corners))}
  };
}
