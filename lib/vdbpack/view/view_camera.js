const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const plus = (a, b, s = 1) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
const cross = (a, b) =>
  [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const clamp = (x, least, most) => Math.min(most, Math.max(least, x));

const TANGENT = Math.tan(Math.PI / 12);  // of half the angle of view along the longer side
const STEEPEST = Math.PI / 2 - 1e-4;     // straight down there is no up
const MARGIN = 1.06;                     // around the scene, as in pictures
// In pictures of the plane: space around the scene, and below it for the scale bar.
const PLANE_MARGIN = 0.02, PLANE_FOOT = 0.05;

/** Turns about a point, z up, with the angle of view of the pictures. */
class Camera {
  constructor(scene, canvas) {
    this.scene = scene;
    this.canvas = canvas;
    this.pivot = [0, 0, 0];
    this.distance = 1;
  }
  /** The position and the axes of the picture. */
  frame() {
    const {azimuth, rise, pivot, distance} = this, {size} = this.scene, {width, height} = this.canvas;
    const toward = [Math.cos(rise) * Math.cos(azimuth), Math.cos(rise) * Math.sin(azimuth),
      Math.sin(rise)];
    const right = [-Math.sin(azimuth), Math.cos(azimuth), 0];
    const eye = plus(pivot, toward, distance), longer = Math.max(width, height);
    return {eye, right, up: cross(toward, right), toward,
      tanX: TANGENT * width / longer, tanY: TANGENT * height / longer,
      near: Math.max(1e-3 * size, dot(eye, toward) - size),
      far: Math.max(2e-3 * size, dot(eye, toward) + size)};
  }
  /** Shows all that `cut` keeps, with the margins of the pictures. */
  fit(cut) {
    const {right, up, toward, tanX, tanY} = this.frame(), {scene} = this;
    if (scene.plane) return this.fitPlane();
    // A camera at (shift, distance) sees the extent of the scene along an axis of the picture.
    const axes = [[right, tanX / MARGIN], [up, tanY / MARGIN]].map(([axis, tangent]) => (
      {axis, tangent, slant: Math.hypot(1, tangent), high: -Infinity, low: -Infinity}));
    let nearest = -Infinity, farthest = Infinity;
    const add = (points, stride) => {
      for (let i = 0; i < points.length; i += stride) {
        const x = [points[i], points[i + 1], points[i + 2]], radius = stride > 3 ? points[i + 3] : 0;
        if (cut && dot(cut.normal, x) + cut.offset < -radius) continue;
        const z = dot(x, toward);
        for (const a of axes) {
          const along = dot(x, a.axis), deep = z * a.tangent + radius * a.slant;
          a.high = Math.max(a.high, deep + along);
          a.low = Math.max(a.low, deep - along);
        }
        nearest = Math.max(nearest, z + radius);
        farthest = Math.min(farthest, z - radius);
      }
    };
    add(scene.spheres, 4);
    if (scene.wall) add(scene.wall.points, 3);
    if (nearest === -Infinity) return;
    const distance = Math.max(...axes.map(a => (a.high + a.low) / (2 * a.tangent)),
                              nearest + 1e-3 * (nearest - farthest));
    const eye = axes.reduce((sum, a) => plus(sum, a.axis, (a.high - a.low) / 2),
                            toward.map(c => distance * c));
    this.distance = distance - (nearest + farthest) / 2;
    if (cut) {
      // The camera looks at the cut face.
      const face = (dot(cut.normal, eye) + cut.offset) / dot(cut.normal, toward);
      if (face > distance - nearest && face < distance - farthest) this.distance = face;
    }
    this.pivot = plus(eye, toward, -this.distance);
  }
  fitPlane() {
    const {width, height} = this.canvas, {half} = this.scene;
    const pixel = Math.max(2 * half[0] / (width * (1 - 2 * PLANE_MARGIN)),
                           2 * half[1] / (height * (1 - 2 * PLANE_MARGIN - PLANE_FOOT)), 1e-300);
    this.distance = pixel * Math.max(width, height) / (2 * TANGENT);
    this.pivot = [0, -PLANE_FOOT / 2 * height * pixel, 0];
  }
  turn(dx, dy) {
    this.azimuth -= dx;
    this.rise = clamp(this.rise + dy, -STEEPEST, STEEPEST);
  }
  /** Moves what is at the pivot by a share of the picture's longer half. */
  move(dx, dy) {
    const {right, up} = this.frame(), scale = TANGENT * this.distance;
    this.pivot = plus(plus(this.pivot, right, -dx * scale), up, dy * scale);
  }
  /** Comes nearer by a factor; what is seen at (x, y), shares of the half sides, stays there. */
  zoom(factor, x, y) {
    const {right, up, tanX, tanY} = this.frame(), {smallest, size} = this.scene;
    const distance = clamp(this.distance / factor, 3 * smallest, 20 * size);
    const change = this.distance - distance;
    this.pivot = plus(plus(this.pivot, right, x * tanX * change), up, y * tanY * change);
    this.distance = distance;
  }
  /** The ray through a point of the picture: shares of its half sides, y up. */
  ray(x, y) {
    const {eye, right, up, toward, tanX, tanY} = this.frame();
    const along = plus(plus(toward.map(c => -c), right, x * tanX), up, y * tanY);
    return {from: eye, along: along.map(c => c / Math.hypot(...along))};
  }
  /** Pixels a millimeter at the pivot. */
  scale() {
    return Math.max(this.canvas.width, this.canvas.height) / (2 * TANGENT * this.distance);
  }
}
