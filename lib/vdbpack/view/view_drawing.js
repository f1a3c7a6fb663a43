const WIDE = 2048;       // spheres in a row of the textures that hold them
const CHUNK = 40000;     // spheres of one step towards a picture in full quality
const MOST_SIDE = 4096;  // pixels of such a picture
const BONE = [0.925, 0.886, 0.812];

function programOf(gl, vertex, fragment) {
  const program = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost())
    throw new Error(gl.getAttachedShaders(program).map(s => gl.getShaderInfoLog(s)).join());
  return program;
}

/** Draws a scene on a canvas. */
class Drawing {
  constructor(gl, scene) {
    this.gl = gl;
    this.scene = scene;
    this.programs = {
      spheres: programOf(gl, SPHERE_VERTEX, SPHERE_FRAGMENT),
      wall: programOf(gl, WALL_VERTEX, WALL_FRAGMENT),
      present: programOf(gl, PRESENT_VERTEX, PRESENT_FRAGMENT)
    };
    [this.spheres, this.colors] = [gl.createTexture(), gl.createTexture()];
    this.fillSpheres(this.spheres, gl.RGBA32F, gl.FLOAT, scene.spheres);
    this.array = gl.createVertexArray();  // empty: vertices know their places by their numbers
    if (scene.wall) this.addWall(scene.wall);
    this.work = null;
    // Pictures in full quality, before they are shown.
    this.target = {colors: gl.createTexture(), depths: gl.createTexture(),
      buffer: gl.createFramebuffer()};
  }
  addWall({points, corners}) {
    const {gl} = this;
    this.wallArray = gl.createVertexArray();
    gl.bindVertexArray(this.wallArray);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, points, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
    if (!corners) return;
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, corners, gl.STATIC_DRAW);
  }
  fill(texture, filter, ...image) {
    const {gl} = this;
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, ...image);
    for (const kind of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER])
      gl.texParameteri(gl.TEXTURE_2D, kind, filter);
    for (const axis of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T])
      gl.texParameteri(gl.TEXTURE_2D, axis, gl.CLAMP_TO_EDGE);
  }
  /** Puts four numbers a sphere into a texture, WIDE in a row. */
  fillSpheres(texture, format, type, data) {
    const {gl} = this, rows = Math.ceil(this.scene.count / WIDE);
    const padded = new data.constructor(4 * WIDE * rows);
    padded.set(data);
    this.fill(texture, gl.NEAREST, format, WIDE, rows, 0, gl.RGBA, type, padded);
  }
  /** RGBA of each sphere. */
  setColors(colors) { this.fillSpheres(this.colors, this.gl.RGBA8, this.gl.UNSIGNED_BYTE, colors); }

  /** A program with textures, and the camera and the cut of `look`; gives the places of its
   *  further numbers by name. */
  use(name, {frame, cut}, textures = {}) {
    const {gl} = this, program = this.programs[name];
    const place = number => gl.getUniformLocation(program, number);
    gl.useProgram(program);
    for (const axis of ['eye', 'right', 'up', 'toward']) gl.uniform3fv(place(axis), frame[axis]);
    gl.uniform2f(place('scale'), frame.tanX, frame.tanY);
    gl.uniform2f(place('range'), frame.near, frame.far);
    gl.uniform1f(place('pixel'), 2 * frame.tanX / this.width);
    gl.uniform1i(place('plane'), this.scene.plane);
    const n = cut ? [frame.right, frame.up, frame.toward].map(axis => dot(axis, cut.normal)) : [0, 0, 0];
    gl.uniform4f(place('cut'), ...n, cut ? dot(cut.normal, frame.eye) + cut.offset : 1);
    Object.entries(textures).forEach(([key, texture], unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.uniform1i(place(key), unit);
    });
    return place;
  }
  /** Draws to a target from now on; null: the canvas. */
  aim(target) {
    const {gl} = this;
    this.width = target ? target.width : gl.canvas.width;
    this.height = target ? target.height : gl.canvas.height;
    gl.bindFramebuffer(gl.FRAMEBUFFER, target ? target.buffer : null);
    gl.viewport(0, 0, this.width, this.height);
  }
  clear({paper}) {
    const {gl} = this;
    gl.clearColor(...paper, 1);
    gl.depthMask(true);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
  }
  /** Draws every `skip`-th of the spheres from `first` on, enlarged to fill some of the gaps. */
  drawSpheres(look, first, count, skip = 1) {
    if (count === 0) return;
    const {gl, spheres, colors} = this, place = this.use('spheres', look, {spheres, colors});
    gl.bindVertexArray(this.array);
    gl.uniform2f(place('size'), this.width, this.height);
    gl.uniform1i(place('first'), first);
    gl.uniform1i(place('skip'), skip);
    gl.uniform1i(place('chosen'), look.chosen);
    gl.uniform1f(place('growth'), Math.min(2, Math.cbrt(skip)));
    gl.drawArrays(gl.TRIANGLES, 0, 3 * Math.ceil(count / skip));
  }
  drawWall(look) {
    const {gl} = this, {wall, plane, solids} = this.scene;
    if (!(look.wall || solids) || !wall) return;
    const place = this.use('wall', look);
    gl.uniform1i(place('solid'), Boolean(solids));
    gl.uniform3fv(place('bone'), BONE);
    gl.uniform3fv(place('ink'), look.ink);
    gl.uniform1f(place('line'), 1.3 * this.width / gl.canvas.width);
    gl.bindVertexArray(this.wallArray);
    if (solids) return this.drawSolids(place);
    gl.depthMask(false);
    if (plane) return gl.drawArrays(gl.LINES, 0, wall.points.length / 3);
    gl.enable(gl.BLEND);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ZERO, gl.ONE);
    gl.enable(gl.CULL_FACE);
    // The far side first.
    for (const side of [gl.FRONT, gl.BACK]) {
      gl.cullFace(side);
      gl.drawElements(gl.TRIANGLES, wall.corners.length, gl.UNSIGNED_INT, 0);
    }
    gl.disable(gl.CULL_FACE);
    gl.disable(gl.BLEND);
  }

  /** Draws the parts of the wall that solids have, each in its color. */
  drawSolids(place) {
    const {gl} = this, {solids} = this.scene;
    let first = 0;
    for (const {corners, color} of solids) {
      if (solids.length > 1) gl.uniform3fv(place('bone'), color.map(c => c / 255));
      gl.drawElements(gl.TRIANGLES, corners, gl.UNSIGNED_INT, 4 * first);
      first += corners;
    }
  }

  /** Draws while the camera moves: about `budget` spheres at most. */
  draw(look, budget) {
    const {count} = this.scene;
    this.work = null;
    this.aim(null);
    this.clear(look);
    this.drawSpheres(look, 0, count, Math.ceil(count / budget));
    this.drawWall(look);
  }

  /** Gives the target twice the pixels of the canvas each way, where there is memory for it. */
  sizeTarget() {
    const {gl, target} = this, {width, height} = gl.canvas;
    const scale = 2 * Math.max(width, height) <= MOST_SIDE ? 2 : 1;
    const size = [scale * width, scale * height];
    if (target.width === size[0] && target.height === size[1]) return;
    [target.width, target.height] = size;
    this.fill(target.colors, gl.LINEAR, gl.RGBA8, ...size, 0, gl.RGBA, gl.UNSIGNED_BYTE, null);
    this.fill(target.depths, gl.NEAREST, gl.DEPTH_COMPONENT24, ...size, 0, gl.DEPTH_COMPONENT,
              gl.UNSIGNED_INT, null);
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.buffer);
    for (const [texture, part] of [[target.colors, gl.COLOR_ATTACHMENT0],
                                   [target.depths, gl.DEPTH_ATTACHMENT]])
      gl.framebufferTexture2D(gl.FRAMEBUFFER, part, gl.TEXTURE_2D, texture, 0);
  }

  /** Draws a part of a picture in full quality: all spheres, smooth edges, shade. The canvas keeps
   *  what it shows until the last step; returns whether that was it. */
  stepBest(look) {
    const {count} = this.scene;
    if (!this.work) this.sizeTarget();
    this.work ??= {look, next: 0};
    const {work} = this;
    this.aim(this.target);
    if (work.next === 0) this.clear(work.look);
    if (work.next < count) {
      this.drawSpheres(work.look, work.next, Math.min(CHUNK, count - work.next));
      work.next += CHUNK;
      return false;
    }
    this.drawWall(work.look);
    this.present(work.look);
    this.work = null;
    return true;
  }
  present(look) {
    const {gl, target: {colors, depths}} = this, {optical} = this.scene;
    this.aim(null);
    gl.disable(gl.DEPTH_TEST);
    const place = this.use('present', look, {colors, depths});
    gl.uniform1f(place('reach'), 2.5 * optical / (2 * look.frame.tanY));
    gl.uniform1f(place('aspect'), this.height / this.width);
    gl.uniform1f(place('radius'), optical);
    gl.bindVertexArray(this.array);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  /** The index of the sphere that a ray meets first, -1: none. */
  pick({from, along}, cut) {
    let found = -1, nearest = Infinity;
    const slope = cut ? dot(cut.normal, along) : 0;
    const start = cut ? dot(cut.normal, from) + cut.offset : 0;
    const {spheres, count, plane} = this.scene;
    for (let i = 0; i < count; ++i) {
      const c = [spheres[4 * i] - from[0], spheres[4 * i + 1] - from[1], spheres[4 * i + 2] - from[2]];
      const middle = dot(c, along), r = spheres[4 * i + 3];
      const square = r * r - dot(c, c) + middle * middle;
      if (square < 0) continue;
      const half = Math.sqrt(square);
      let t = middle - half;
      if (cut && start + slope * t < 0) {
        t = -start / slope;
        if (slope <= 0 || t > middle + half) continue;
      } else if (plane) {
        continue;
      }
      if (t > 0 && t < nearest) {
        nearest = t;
        found = i;
      }
    }
    return found;
  }
}
