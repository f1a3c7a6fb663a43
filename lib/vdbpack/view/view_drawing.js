const BLOCK = 32;        // spheres that are tested as one
const COMPACT = 9;       // optical radii: half the diagonal of most boxes around BLOCK spheres is 6 to 9
const WIDE = 2048;       // spheres in a row of the textures that hold them
const LARGEST = 30;      // radius of points, pixels
const CHUNK = 40000;     // spheres of one step towards a picture in full quality
const LIFT = 0.1;        // of the wall, in smallest radii
const MOST_SIDE = 4096;  // pixels of such a picture

/** A program with its uniforms by name, for some macros. */
function programOf(gl, vertex, fragment, macros) {
  const head = '#version 300 es\n' + macros.map(macro => `#define ${macro}\n`).join('');
  const program = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, head + text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost())
    throw new Error(gl.getAttachedShaders(program).map(s => gl.getShaderInfoLog(s)).join('\n') +
                    gl.getProgramInfoLog(program));
  const uniforms = {};
  const count = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS) || 0;
  for (let i = 0; i < count; ++i) {
    const {name} = gl.getActiveUniform(program, i);
    uniforms[name] = gl.getUniformLocation(program, name);
  }
  return {program, uniforms};
}

function fillBuffer(gl, target, data) {
  gl.bindBuffer(target, gl.createBuffer());
  gl.bufferData(target, data, gl.STATIC_DRAW);
}

/** Boxes around runs of spheres: middle and half sides, and the largest radius, seven numbers. */
class Blocks {
  constructor(spheres, first, end) {
    this.first = first;
    this.end = end;
    this.count = Math.ceil((end - first) / BLOCK);
    this.boxes = new Float32Array(7 * this.count);
    for (let b = 0, i = first; i < end; ++b) {
      const lo = [Infinity, Infinity, Infinity], hi = [-Infinity, -Infinity, -Infinity];
      let largest = 0;
      for (const last = Math.min(end, i + BLOCK); i < last; ++i) {
        const r = spheres[4 * i + 3];
        if (r > largest) largest = r;
        for (let d = 0; d < 3; ++d) {
          const x = spheres[4 * i + d];
          if (x - r < lo[d]) lo[d] = x - r;
          if (x + r > hi[d]) hi[d] = x + r;
        }
      }
      for (let d = 0; d < 3; ++d) {
        this.boxes[7 * b + d] = (lo[d] + hi[d]) / 2;
        this.boxes[7 * b + 3 + d] = (hi[d] - lo[d]) / 2;
      }
      this.boxes[7 * b + 6] = largest;
    }
  }
  /** Calls use(blocks, b) for blocks that reach above all planes (normal, offset). */
  above(planes, use) {
    for (let b = 0; b < this.count; ++b) {
      let above = true;
      for (let k = 0; k < planes.length && above; ++k)
        above = this.height(b, planes[k], 1) >= 0;
      if (above) use(this, b);
    }
  }
  /** Height of the highest (way 1) or lowest (way -1) corner above a plane. */
  height(b, [n, offset], way) {
    const {boxes} = this, at = 7 * b;
    return n[0] * boxes[at] + n[1] * boxes[at + 1] + n[2] * boxes[at + 2] + offset +
      way * (Math.abs(n[0]) * boxes[at + 3] + Math.abs(n[1]) * boxes[at + 4] +
             Math.abs(n[2]) * boxes[at + 5]);
  }
  middle(b) { return this.boxes.subarray(7 * b, 7 * b + 3); }
  reach(b) { return Math.hypot(...this.boxes.subarray(7 * b + 3, 7 * b + 6)); }
  run(b) {
    const first = this.first + b * BLOCK;
    return [first, Math.min(BLOCK, this.end - first)];
  }
}

/** Which blocks others hide: the nearest ones on a coarse grid over the picture. Compact blocks count
 *  as opaque, though one may look through a few; what is missed is there in full quality. */
class CoarseDepths {
  constructor() {
    this.columns = 96;
    this.rows = 96;
    this.depths = new Float32Array(this.columns * this.rows);
  }
  /** Of blocks (pairs of Blocks and number), those that may be seen.
   *  @param depth  through which one sees, mm. @param optical  radius of the spheres, mm */
  visible(blocks, frame, depth, optical) {
    const {eye, right, up, toward, tanX, tanY} = frame, {columns, rows, depths} = this;
    depths.fill(Infinity);
    const places = blocks.map(([of, b]) => {
      const d = plus(of.middle(b), eye, -1), z = -dot(d, toward), reach = of.reach(b);
      return {z, reach, x: (dot(d, right) / (z * tanX) + 1) / 2 * columns,
        y: (dot(d, up) / (z * tanY) + 1) / 2 * rows, across: reach / (2 * z * tanX) * columns,
        along: reach / (2 * z * tanY) * rows};
    });
    for (const place of places)
      // The middle of a block hides what is behind it. Others than compact ones, where the curve
      // jumps, may have nothing there.
      if (place.reach < COMPACT * optical)
        this.each(place, 0.4, at => { depths[at] = Math.min(depths[at], place.z); });
    return blocks.filter((block, i) => {
      const place = places[i];
      if (place.z < 2 * place.reach) return true;
      let seen = false;
      this.each(place, 1, at => { seen = seen || depths[at] > place.z - place.reach - depth; });
      return seen;
    });
  }
  /** Calls use(cell) for the cells of a share of a place. */
  each({x, y, across, along, z}, share, use) {
    const {columns, rows} = this;
    const i1 = Math.min(columns - 1, Math.floor(x + share * across));
    const j1 = Math.min(rows - 1, Math.floor(y + share * along));
    for (let j = Math.max(0, Math.floor(y - share * along)); j <= j1; ++j)
      for (let i = Math.max(0, Math.floor(x - share * across)); i <= i1; ++i)
        use(j * columns + i);
  }
}

/** The sides of what a camera sees, as planes. */
function sidesOf(frame, plane) {
  const {eye, right, up, toward} = frame;
  const sides = [];
  for (const [axis, tangent, half] of [[right, frame.tanX, frame.halfX], [up, frame.tanY, frame.halfY]])
    for (const way of [1, -1]) {
      const n = plane ? axis.map(c => way * c) : plus(axis.map(c => way * c), toward, -tangent);
      sides.push([n, (plane ? half : 0) - dot(n, eye)]);
    }
  return sides;
}

/** Draws a scene on a canvas. */
class Drawing {
  constructor(gl, scene) {
    this.gl = gl;
    this.scene = scene;
    const {spheres, count, outer, inner} = scene;
    this.outer = new Blocks(spheres, 0, outer);
    this.inner = new Blocks(spheres, outer, outer + inner);
    this.buried = new Blocks(spheres, outer + inner, count);
    this.programs = new Map();
    this.rowsOfSpheres = Math.ceil(count / WIDE);
    this.spheres = this.textureOf(gl.RGBA32F, gl.FLOAT, spheres);
    this.colors = this.textureOf(gl.RGBA8, gl.UNSIGNED_BYTE, new Uint8Array(4 * count));
    this.array = gl.createVertexArray();  // empty: vertices know their places by their numbers
    this.coarse = new CoarseDepths();
    if (scene.wall) this.addWall(scene.wall);
    if (scene.outline) this.addOutline(scene.outline);
    this.bestTarget = null;
    this.work = null;
  }
  addWall({points, normals, corners}) {
    const {gl} = this;
    this.wallArray = gl.createVertexArray();
    gl.bindVertexArray(this.wallArray);
    [points, normals].forEach((data, location) => {
      fillBuffer(gl, gl.ARRAY_BUFFER, data);
      gl.enableVertexAttribArray(location);
      gl.vertexAttribPointer(location, 3, gl.FLOAT, false, 0, 0);
    });
    fillBuffer(gl, gl.ELEMENT_ARRAY_BUFFER, corners);
    this.corners = corners.length;
  }
  addOutline(points) {
    const {gl} = this;
    this.wallArray = gl.createVertexArray();
    gl.bindVertexArray(this.wallArray);
    fillBuffer(gl, gl.ARRAY_BUFFER, points);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
    this.ends = points.length / 3;
  }
  /** Four numbers a sphere, WIDE in a row. */
  textureOf(format, type, data) {
    const {gl} = this;
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, format, WIDE, this.rowsOfSpheres);
    for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER])
      gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST);
    this.fill(texture, type, data);
    return texture;
  }
  fill(texture, type, data) {
    const {gl} = this, {count} = this.scene, whole = Math.floor(count / WIDE);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    if (whole > 0)
      gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, WIDE, whole, gl.RGBA, type, data);
    if (count > whole * WIDE)
      gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, whole, count - whole * WIDE, 1, gl.RGBA, type, data,
                       4 * whole * WIDE);
  }
  /** RGBA of each sphere. */
  setColors(colors) { this.fill(this.colors, this.gl.UNSIGNED_BYTE, colors); }

  /** Runs of spheres that may be seen, as first, count, and whether they are drawn as points.
   *  @param all  also those that others hide */
  runs(look, all, width) {
    const {frame, cut} = look, {plane, lo, hi, depth} = this.scene;
    const sides = sidesOf(frame, plane), planes = [...sides];
    if (cut) planes.push([cut.normal, cut.offset]);
    let blocks = [];
    const use = (of, b) => blocks.push([of, b]);
    this.outer.above(planes, use);
    const inside = !plane && frame.eye.every((x, d) => x > lo[d] && x < hi[d]);
    if (cut || all || inside) this.inner.above(planes, use);
    if (all || inside)
      this.buried.above(planes, use);
    else if (cut)
      this.buried.above([...planes, [cut.normal.map(c => -c), depth - cut.offset]], use);
    if (!all && !plane && !inside) blocks = this.coarse.visible(blocks, frame, depth / 2, this.scene.optical);
    const pixel = 2 * (plane ? frame.halfX : frame.tanX) / width;
    const runs = [];
    for (const [of, b] of blocks) {
      const near = plane ? 1 : of.height(b, [frame.toward.map(c => -c), dot(frame.toward, frame.eye)],
                                         -1);
      const isPoint = near > 0 && of.boxes[7 * b + 6] < LARGEST * pixel * near &&
        sides.every(side => of.height(b, side, -1) >= 0);
      const [first, count] = of.run(b), last = runs[runs.length - 1];
      if (last && last[0] + last[1] === first && last[2] === isPoint)
        last[1] += count;
      else
        runs.push([first, count, isPoint]);
    }
    return runs;
  }

  /** A program of shaders by their name, made when it is first used. */
  program(name, macros) {
    const key = [name, ...macros].join(' ');
    if (!this.programs.has(key)) {
      const [vertex, fragment] = {spheres: [SPHERE_VERTEX, SPHERE_FRAGMENT],
        wall: [WALL_VERTEX, WALL_FRAGMENT], present: [PRESENT_VERTEX, PRESENT_FRAGMENT]}[name];
      this.programs.set(key, programOf(this.gl, vertex, fragment, macros));
    }
    const program = this.programs.get(key);
    this.gl.useProgram(program.program);
    return program.uniforms;
  }
  macros(look) { return this.scene.plane ? ['PLANE'] : look.cut ? ['CUT'] : []; }
  setCamera(uniforms, look, width) {
    const {gl} = this, {frame, cut} = look;
    for (const name of ['eye', 'right', 'up', 'toward']) gl.uniform3fv(uniforms[name], frame[name]);
    if (this.scene.plane) {
      gl.uniform2f(uniforms.scale, frame.halfX, frame.halfY);
      gl.uniform1f(uniforms.pixel, 2 * frame.halfX / width);
    } else {
      gl.uniform2f(uniforms.scale, frame.tanX, frame.tanY);
      gl.uniform2f(uniforms.range, frame.near, frame.far);
      gl.uniform1f(uniforms.pixel, 2 * frame.tanX / width);
    }
    if (cut) {
      const n = [frame.right, frame.up, frame.toward].map(axis => dot(axis, cut.normal));
      gl.uniform4f(uniforms.cut, ...n, dot(cut.normal, frame.eye) + cut.offset);
    }
  }
  clear(look, width, height) {
    const {gl} = this;
    gl.viewport(0, 0, width, height);
    gl.clearColor(...look.paper, 1);
    gl.depthMask(true);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.disable(gl.BLEND);
  }
  /** Draws runs of spheres; roughly, with every `skip`-th, or in full quality. */
  drawSpheres(runs, look, width, height, skip = 0) {
    const {gl} = this, step = Math.max(1, skip);
    gl.bindVertexArray(this.array);
    for (const isPoint of [true, false]) {
      const some = runs.filter(run => run[2] === isPoint);
      if (some.length === 0) continue;
      const isRough = skip > 0 && isPoint && !this.scene.plane;
      const uniforms = this.program('spheres', [
        ...this.macros(look), ...isPoint ? ['POINTS'] : [], ...isRough ? ['ROUGH'] : []]);
      this.setCamera(uniforms, look, width);
      gl.uniform2f(uniforms.size, width, height);
      gl.uniform1i(uniforms.skip, step);
      this.setTextures(uniforms, {spheres: this.spheres, colors: this.colors});
      for (const [first, count] of some) {
        const n = Math.ceil(count / step);
        gl.uniform1i(uniforms.first, first);
        gl.drawArrays(isPoint ? gl.POINTS : gl.TRIANGLES, 0, isPoint ? n : 3 * n);
      }
    }
  }
  setTextures(uniforms, textures) {
    const {gl} = this;
    Object.entries(textures).forEach(([name, texture], unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.uniform1i(uniforms[name], unit);
    });
  }
  drawWall(look, width, isRough) {
    const {gl} = this;
    if (!look.wall || !this.wallArray) return;
    const uniforms = this.program('wall', [...this.macros(look), ...isRough ? ['ROUGH'] : []]);
    this.setCamera(uniforms, look, width);
    gl.uniform3fv(uniforms.bone, [0.925, 0.886, 0.812]);
    gl.uniform3fv(uniforms.ink, look.ink);
    gl.uniform1f(uniforms.line, 1.3 * width / gl.canvas.width);
    gl.uniform1f(uniforms.lift, this.ends ? 0 : LIFT * this.scene.smallest);
    gl.bindVertexArray(this.wallArray);
    gl.depthMask(false);
    if (this.ends) {
      gl.drawArrays(gl.LINES, 0, this.ends);
      return;
    }
    gl.enable(gl.BLEND);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ZERO, gl.ONE);
    gl.enable(gl.CULL_FACE);
    // The far side first; not while it moves.
    for (const side of isRough ? [gl.BACK] : [gl.FRONT, gl.BACK]) {
      gl.cullFace(side);
      gl.drawElements(gl.TRIANGLES, this.corners, gl.UNSIGNED_INT, 0);
    }
    gl.disable(gl.CULL_FACE);
    gl.disable(gl.BLEND);
  }

  /** Draws while the camera moves: no more than `budget` spheres. Returns how many were seen. */
  draw(look, budget) {
    const {gl} = this, {width, height} = gl.canvas;
    this.work = null;
    const runs = this.runs(look, false, width);
    const seen = runs.reduce((sum, run) => sum + run[1], 0);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    this.clear(look, width, height);
    this.drawSpheres(runs, look, width, height, Math.ceil(seen / budget));
    this.drawWall(look, width, true);
    return seen;
  }

  /** A target of twice the pixels each way, where there is memory for it. */
  targetOf(width, height) {
    const {gl} = this;
    const scale = 2 * Math.max(width, height) <= MOST_SIDE ? 2 : 1;
    const [w, h] = [width * scale, height * scale];
    if (this.bestTarget?.width === w && this.bestTarget?.height === h) return this.bestTarget;
    this.dropTarget();
    const target = {width: w, height: h, buffer: gl.createFramebuffer()};
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.buffer);
    for (const [name, format, filter, place] of [
      ['colors', gl.RGBA8, gl.LINEAR, gl.COLOR_ATTACHMENT0],
      ['depths', gl.DEPTH_COMPONENT24, gl.NEAREST, gl.DEPTH_ATTACHMENT]]) {
      target[name] = gl.createTexture();
      gl.bindTexture(gl.TEXTURE_2D, target[name]);
      gl.texStorage2D(gl.TEXTURE_2D, 1, format, w, h);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, filter);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, filter);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, place, gl.TEXTURE_2D, target[name], 0);
    }
    this.bestTarget = target;
    return target;
  }
  dropTarget() {
    const {gl, bestTarget} = this;
    if (!bestTarget) return;
    gl.deleteTexture(bestTarget.colors);
    gl.deleteTexture(bestTarget.depths);
    gl.deleteFramebuffer(bestTarget.buffer);
    this.bestTarget = null;
  }

  /** Starts a picture in full quality: all spheres, smooth edges, shade. The canvas keeps what it
   *  shows until the last step. */
  startBest(look) {
    const {gl} = this, {width, height} = gl.canvas;
    const target = this.targetOf(width, height);
    const chunks = [[]];
    let room = CHUNK;
    for (let [first, count, isPoint] of this.runs(look, true, target.width))
      while (count > 0) {
        const n = Math.min(count, room);
        chunks[chunks.length - 1].push([first, n, isPoint]);
        first += n;
        count -= n;
        room -= n;
        if (room > 0) continue;
        chunks.push([]);
        room = CHUNK;
      }
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.buffer);
    this.clear(look, target.width, target.height);
    this.work = {look, target, chunks, next: 0};
  }
  /** Draws a part of it; returns whether it is complete, and on the canvas. */
  stepBest() {
    const {gl, work} = this;
    if (!work) return true;
    const {target, chunks, look} = work;
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.buffer);
    gl.viewport(0, 0, target.width, target.height);
    if (work.next < chunks.length) {
      this.drawSpheres(chunks[work.next++], look, target.width, target.height);
      return false;
    }
    this.drawWall(look, target.width, false);
    this.present(target, look);
    this.work = null;
    return true;
  }
  present(target, {frame}) {
    const {gl} = this, {width, height} = gl.canvas, {plane, optical} = this.scene;
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, width, height);
    gl.disable(gl.DEPTH_TEST);
    const uniforms = this.program('present', []);
    this.setTextures(uniforms, {colors: target.colors, depths: target.depths});
    gl.uniform1i(uniforms.plane, plane ? 1 : 0);
    if (!plane) {
      gl.uniform2f(uniforms.range, frame.near, frame.far);
      gl.uniform1f(uniforms.reach, 2.5 * optical / (2 * frame.tanY));
      gl.uniform1f(uniforms.aspect, height / width);
      gl.uniform1f(uniforms.radius, optical);
    }
    gl.bindVertexArray(this.array);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  /** The index of the sphere that a ray meets first, -1: none. */
  pick({from, along}, cut) {
    let found = -1, nearest = Infinity;
    const slope = cut ? dot(cut.normal, along) : 0;
    const start = cut ? dot(cut.normal, from) + cut.offset : 0;
    const {spheres} = this.scene;
    const test = i => {
      const c = [spheres[4 * i] - from[0], spheres[4 * i + 1] - from[1], spheres[4 * i + 2] - from[2]];
      const middle = dot(c, along), r = spheres[4 * i + 3];
      const square = r * r - dot(c, c) + middle * middle;
      if (square < 0) return;
      const half = Math.sqrt(square);
      let t = middle - half;
      if (cut && start + slope * t < 0) {
        t = -start / slope;
        if (slope <= 0 || t > middle + half) return;
      }
      if (t > 0 && t < nearest) {
        nearest = t;
        found = i;
      }
    };
    for (const blocks of [this.outer, this.inner, this.buried])
      for (let b = 0; b < blocks.count; ++b)
        if (meetsBox(blocks.boxes, 7 * b, from, along)) {
          const first = blocks.first + b * BLOCK;
          for (let i = first; i < Math.min(blocks.end, first + BLOCK); ++i) test(i);
        }
    return found;
  }
}

function meetsBox(boxes, at, from, along) {
  let enter = 0, leave = Infinity;
  for (let d = 0; d < 3; ++d) {
    const a = (boxes[at + d] - boxes[at + 3 + d] - from[d]) / along[d];
    const b = (boxes[at + d] + boxes[at + 3 + d] - from[d]) / along[d];
    if (Number.isNaN(a) || Number.isNaN(b)) continue;  // along a side
    enter = Math.max(enter, Math.min(a, b));
    leave = Math.min(leave, Math.max(a, b));
  }
  return enter <= leave;
}

