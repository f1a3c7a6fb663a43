const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const plus = (a, b, s = 1) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
const cross = (a, b) =>
  [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const clamp = (x, least, most) => Math.min(most, Math.max(least, x));

const STEEPEST = Math.PI / 2 - 1e-4;  // straight down there is no up
const MARGIN = 1.06;                  // around the scene, as in pictures
// In pictures of the plane: space around the scene, and below it for the scale bar.
const PLANE_MARGIN = 0.02, PLANE_FOOT = 0.05;
const START = {azimuth: -Math.PI / 2 + 35 * Math.PI / 180, rise: 22 * Math.PI / 180};

/** Turns about a point, z up, with the angle of view of the pictures. */
class SpaceCamera {
  constructor(scene, tangent) {
    this.scene = scene;
    this.tangent = tangent;  // of half the angle of view along the longer side
    this.least = 3 * scene.smallest;
  }
  /** The position and the axes of the picture for a canvas of this size. */
  frame(width, height) {
    const {azimuth, rise, pivot, distance, tangent} = this;
    const toward = [Math.cos(rise) * Math.cos(azimuth), Math.cos(rise) * Math.sin(azimuth),
      Math.sin(rise)];
    const right = [-Math.sin(azimuth), Math.cos(azimuth), 0];
    const eye = plus(pivot, toward, distance);
    const longer = Math.max(width, height);
    const far = dot(eye, toward) + this.scene.size;
    return {eye, right, up: cross(toward, right), toward,
      tanX: tangent * width / longer, tanY: tangent * height / longer,
      near: Math.max(1e-3 * this.scene.size, dot(eye, toward) - this.scene.size),
      far: Math.max(far, 2e-3 * this.scene.size)};
  }
  /** Shows all, from `azimuth` and `rise`; the margins are those of the pictures. */
  fit(width, height, kept) {
    this.pivot = [0, 0, 0];
    this.distance = 1;
    const {right, up, toward, tanX, tanY} = this.frame(width, height);
    const across = new Extent(tanX / MARGIN), along = new Extent(tanY / MARGIN);
    let nearest = -Infinity, farthest = Infinity;
    const add = (x, radius) => {
      const z = dot(x, toward);
      across.add(dot(x, right), z, radius);
      along.add(dot(x, up), z, radius);
      nearest = Math.max(nearest, z + radius);
      farthest = Math.min(farthest, z - radius);
    };
    const {spheres, outlines, wall} = this.scene;
    for (let i = 0; i < 4 * outlines; i += 4) {
      const x = [spheres[i], spheres[i + 1], spheres[i + 2]];
      if (!kept || kept(x) > -spheres[i + 3]) add(x, spheres[i + 3]);
    }
    if (wall)
      for (let i = 0; i < wall.points.length; i += 3) {
        const x = [wall.points[i], wall.points[i + 1], wall.points[i + 2]];
        if (!kept || kept(x) >= 0) add(x, 0);
      }
    if (nearest === -Infinity) return;
    const distance = Math.max(across.distance(), along.distance(),
                              nearest + 1e-3 * (nearest - farthest));
    this.distance = distance - (nearest + farthest) / 2;
    this.pivot = plus(plus(plus([0, 0, 0], toward, distance - this.distance),
                           right, across.shift()), up, along.shift());
  }
  /** The camera of a picture. */
  use({position, toward, target}, middle) {
    this.azimuth = Math.atan2(toward[1], toward[0]);
    this.rise = Math.asin(clamp(toward[2], -1, 1));
    this.distance = target;
    this.pivot = plus(plus(position, middle, -1), toward, -target);
  }
  turn(dx, dy) {
    this.azimuth -= dx;
    this.rise = clamp(this.rise + dy, -STEEPEST, STEEPEST);
  }
  /** Moves what is at the pivot by a share of the picture's longer half. */
  move(dx, dy, width, height) {
    const {right, up} = this.frame(width, height);
    const scale = this.tangent * this.distance;
    this.pivot = plus(plus(this.pivot, right, -dx * scale), up, dy * scale);
  }
  /** Comes nearer by a factor; what is seen at (x, y), shares of the half sides, stays there. */
  zoom(factor, x, y, width, height) {
    const {right, up, tanX, tanY} = this.frame(width, height);
    const distance = clamp(this.distance / factor, this.least, 20 * this.scene.size);
    const change = this.distance - distance;
    this.pivot = plus(plus(this.pivot, right, x * tanX * change), up, y * tanY * change);
    this.distance = distance;
  }
  /** The ray through a point of the picture: shares of its half sides, y up. */
  ray(x, y, width, height) {
    const {eye, right, up, toward, tanX, tanY} = this.frame(width, height);
    const along = plus(plus(plus([0, 0, 0], right, x * tanX), up, y * tanY), toward, -1);
    const size = Math.hypot(...along);
    return {from: eye, along: along.map(c => c / size)};
  }
  /** Pixels a millimeter at the pivot. */
  scale(width, height) { return Math.max(width, height) / (2 * this.tangent * this.distance); }
  /** Where a point is seen: shares of the half sides, y up. */
  project(point, width, height) {
    const {eye, right, up, toward, tanX, tanY} = this.frame(width, height);
    const d = plus(point, eye, -1), z = -dot(d, toward);
    return [dot(d, right) / (z * tanX), dot(d, up) / (z * tanY)];
  }
}

/** The extent of a scene along one axis of the picture: a camera at (shift, distance) sees it. */
class Extent {
  constructor(tangent) {
    this.tangent = tangent;
    this.slant = Math.sqrt(1 + tangent * tangent);
    this.high = this.low = -Infinity;
  }
  add(x, toward, radius) {
    const deep = toward * this.tangent + radius * this.slant;
    this.high = Math.max(this.high, x + deep);
    this.low = Math.max(this.low, deep - x);
  }
  distance() { return (this.high + this.low) / (2 * this.tangent); }
  shift() { return (this.high - this.low) / 2; }
}

/** Looks at the plane from above: moves and zooms. */
class PlaneCamera {
  constructor(scene) { this.scene = scene; }
  /** As pictures of the plane: with a margin, and space for the scale bar below. */
  fit(width, height) {
    const {lo, hi} = this.scene;
    this.pixel = Math.max((hi[0] - lo[0]) / (width * (1 - 2 * PLANE_MARGIN)),
                          (hi[1] - lo[1]) / (height * (1 - 2 * PLANE_MARGIN - PLANE_FOOT)), 1e-300);
    this.width = width;
    this.pivot = [(lo[0] + hi[0]) / 2, (lo[1] + hi[1]) / 2 - PLANE_FOOT / 2 * height * this.pixel];
    this.whole = this.pixel;
  }
  frame(width, height) {
    const pixel = this.pixel * this.width / width;
    return {eye: [this.pivot[0], this.pivot[1], 0], right: [1, 0, 0], up: [0, 1, 0],
      toward: [0, 0, 1], halfX: pixel * width / 2, halfY: pixel * height / 2};
  }
  move(dx, dy, width, height) {
    const half = this.pixel * this.width / width * Math.max(width, height) / 2;
    this.pivot = [this.pivot[0] - dx * half, this.pivot[1] + dy * half];
  }
  turn(dx, dy) { this.move(-dx, -dy, this.width, this.width); }
  zoom(factor, x, y, width, height) {
    const {halfX, halfY} = this.frame(width, height);
    const pixel = clamp(this.pixel / factor, this.scene.smallest / 2000, 4 * this.whole);
    const change = 1 - pixel / this.pixel;
    this.pivot = [this.pivot[0] + x * halfX * change, this.pivot[1] + y * halfY * change];
    this.pixel = pixel;
  }
  ray(x, y, width, height) {
    const {halfX, halfY} = this.frame(width, height);
    return {from: [this.pivot[0] + x * halfX, this.pivot[1] + y * halfY, this.scene.size],
      along: [0, 0, -1]};
  }
  scale(width) { return width / (this.pixel * this.width); }
  project(point, width, height) {
    const {halfX, halfY} = this.frame(width, height);
    return [(point[0] - this.pivot[0]) / halfX, (point[1] - this.pivot[1]) / halfY];
  }
}

