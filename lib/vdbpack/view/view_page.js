const REST = 150;             // ms without change before a picture in full quality is drawn
const SLOW = 80, FAST = 25;   // ms of a frame: fewer or more spheres are drawn
const CLICK = 5;              // pixels that a click may move
const MOST_PIXELS = 2048;     // along a side of the canvas
const CHOSEN = [255, 45, 110];
const DEGREE = Math.PI / 180;

function rgbOf(color) {
  const number = parseInt(color.slice(1), 16);
  return [number >> 16, number >> 8 & 255, number & 255];
}

/** A color of the page's style, as shares. */
function styleColor(element, name) {
  const probe = document.createElement('i');
  probe.style.color = `var(${name})`;
  element.append(probe);
  const parts = getComputedStyle(probe).color.match(/[\d.]+/g).map(Number);
  probe.remove();
  return parts.slice(0, 3).map(c => c / 255);
}

/** 1, 2 or 5 times a power of ten, at most `most`. */
function roundLength(most) {
  const power = 10 ** Math.floor(Math.log10(most));
  return [5, 2, 1].find(k => k * power <= most) * power;
}

/** What there is to draw, around its middle. */
function sceneOf(facts, arrays) {
  const [lo, hi] = facts.bounds;
  const middle = lo.map((c, d) => (c + hi[d]) / 2);
  const spheres = spheresOf(facts, arrays, middle);
  let smallest = Infinity, squares = 0, cubes = 0;
  for (let i = 3; i < spheres.length; i += 4) {
    const r = spheres[i];
    if (r < smallest) smallest = r;
    squares += r * r;
    cubes += r * r * r;
  }
  return {
    plane: facts.dim === 2, count: facts.count, outer: facts.outer, inner: facts.inner,
    outlines: facts.outer || facts.count, spheres, middle, smallest, optical: cubes / squares,
    depth: facts.depth, lo: lo.map((c, d) => c - middle[d]), hi: hi.map((c, d) => c - middle[d]),
    size: Math.hypot(...lo.map((c, d) => hi[d] - c)) / 2,
    wall: wallOf(facts, arrays, middle),
    outline: facts.outline ? pointsOf('outline', facts.outline, arrays, middle) : null
  };
}

/** A plane that can be moved; keeps the side that the pictures keep, or the other. */
class Cut {
  constructor(scene) {
    this.scene = scene;
    this.axis = '';
    this.at = {x: 0, y: 0, z: 0, view: 0};  // from the middle, mm
    this.other = false;
  }
  /** Normal and offset: what is kept has n · x + offset >= 0; null: all is kept. */
  plane(camera) {
    if (!this.axis) return null;
    const at = this.at[this.axis];
    if (this.axis === 'view') {
      const {toward} = camera.frame(1, 1);
      const way = this.other ? 1 : -1;
      return {normal: toward.map(c => way * c), offset: -way * at};
    }
    const d = 'xyz'.indexOf(this.axis), way = (this.axis === 'y' ? 1 : -1) * (this.other ? -1 : 1);
    return {normal: [0, 1, 2].map(k => k === d ? way : 0), offset: -way * at};
  }
  /** The interval in which it meets the scene. */
  interval(camera) {
    const {lo, hi} = this.scene;
    if (this.axis !== 'view') return [lo['xyz'.indexOf(this.axis)], hi['xyz'.indexOf(this.axis)]];
    const {toward} = camera.frame(1, 1);
    const half = toward.reduce((sum, c, d) => sum + Math.abs(c) * (hi[d] - lo[d]) / 2, 0);
    return [half, -half];  // the slider goes into the scene
  }
  share(camera) {
    const [from, to] = this.interval(camera);
    return (this.at[this.axis] - from) / (to - from);
  }
  setShare(share, camera) {
    const [from, to] = this.interval(camera);
    this.at[this.axis] = from + clamp(share, 0, 1) * (to - from);
  }
  text(camera) {
    const [from] = this.interval(camera), at = this.at[this.axis];
    const digits = clamp(2 - Math.floor(Math.log10(this.scene.size)), 0, 9);
    if (this.axis === 'view') return `${(from - at).toFixed(digits)} mm deep`;
    return `${(at + this.scene.middle['xyz'.indexOf(this.axis)]).toFixed(digits)} mm`;
  }
  /** Where a picture looks at it from: azimuth and rise. */
  direction() {
    let turned = {x: {azimuth: -28 * DEGREE, rise: 20 * DEGREE},
      y: {azimuth: -62 * DEGREE, rise: 20 * DEGREE},
      z: {azimuth: -62 * DEGREE, rise: 62 * DEGREE}}[this.axis];
    if (!turned) return START;
    if (this.other) turned = {azimuth: turned.azimuth + Math.PI, rise: -turned.rise};
    return turned;
  }
}

/** The view in a figure: its controls, and when what is drawn. */
class View {
  constructor(figure, facts, arrays) {
    this.figure = figure;
    this.root = figure.querySelector('.view');
    this.facts = facts;
    this.canvas = this.part('canvas');
    this.scene = sceneOf(facts, arrays);
    this.rows = arrays.get('row');
    this.properties = propertiesOf(facts, arrays);
    const gl = this.canvas.getContext('webgl2',
                                      {antialias: false, alpha: false, preserveDrawingBuffer: true,
                                       powerPreference: 'high-performance'});
    if (!gl) throw new Error('WebGL2 is not available');
    this.gl = gl;
    this.drawing = new Drawing(gl, this.scene);
    this.camera = this.scene.plane ? new PlaneCamera(this.scene)
      : new SpaceCamera(this.scene, facts.camera.tangent);
    this.cut = new Cut(this.scene);
    this.ramp = this.rampOf(facts.colors.ramp);
    this.chosen = -1;
    this.budget = 300000;
    this.isDirty = true;
    this.changed = 0;
    this.fence = null;
    this.frameTimes = [];
  }
  part(name) { return this.root.querySelector(name); }

  start() {
    const {facts} = this;
    if (facts.cut) {
      this.cut.axis = facts.cut.axis;
      this.cut.at[facts.cut.axis] = facts.cut.at - this.scene.middle['xyz'.indexOf(facts.cut.axis)];
    }
    this.figure.classList.add('viewing');
    this.root.hidden = false;
    this.fillControls();
    this.color = Math.max(0, this.properties.findIndex(p => p.name === facts.color));
    this.setColor(this.color);
    this.resize();
    this.home();
    this.showCut();
    this.listen();
    this.tick();
  }

  // What is drawn

  look() {
    const {width, height} = this.canvas;
    return {frame: this.camera.frame(width, height), cut: this.cut.plane(this.camera),
      wall: this.part('.view-wall input').checked, paper: this.paper, ink: this.ink};
  }
  /** To be called after anything that is seen has changed. */
  change() {
    this.isDirty = true;
    this.changed = performance.now();
    this.drawing.work = null;
    this.root.dataset.state = 'moving';
  }
  /** Draws what there is to draw once the last work is done; runs before each frame. */
  tick() {
    requestAnimationFrame(() => this.tick());
    if (this.gl.isContextLost() || this.isBusy()) return;
    if (this.isDirty) {
      this.drawNow();
      this.fence = this.gl.fenceSync(this.gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
      this.begun = performance.now();
    } else if (this.root.dataset.state === 'moving' && performance.now() - this.changed > REST) {
      if (!this.drawing.work) this.drawing.startBest(this.look());
      if (this.drawing.stepBest()) this.root.dataset.state = 'still';
      this.fence = this.gl.fenceSync(this.gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
      this.begun = null;
    }
    this.gl.flush();
  }
  isBusy() {
    const {gl} = this;
    if (!this.fence) return false;
    if (gl.clientWaitSync(this.fence, 0, 0) === gl.TIMEOUT_EXPIRED) return true;
    gl.deleteSync(this.fence);
    this.fence = null;
    if (this.begun) this.adapt(performance.now() - this.begun);
    return false;
  }
  /** Draws fewer spheres while the camera moves where that is slow. */
  adapt(time) {
    if (time > SLOW && this.budget > 20000) this.budget *= 0.7;
    if (time < FAST && this.budget < 4e6) this.budget *= 1.3;
  }
  drawNow() {
    this.isDirty = false;
    this.seen = this.drawing.draw(this.look(), this.budget);
    this.showScale();
  }
  /** Completes the picture in full quality. */
  drawBest() {
    if (this.isDirty) this.drawNow();
    this.drawing.startBest(this.look());
    while (!this.drawing.stepBest());
    this.root.dataset.state = 'still';
  }
  resize() {
    const box = this.canvas.getBoundingClientRect();
    const longer = Math.max(box.width, box.height, 1);
    const ratio = Math.min(window.devicePixelRatio || 1, MOST_PIXELS / longer);
    const width = Math.max(1, Math.round(box.width * ratio));
    const height = Math.max(1, Math.round(box.height * ratio));
    this.paper = styleColor(this.root, '--card');
    this.ink = styleColor(this.root, '--ink');
    if (this.canvas.width !== width || this.canvas.height !== height)
      Object.assign(this.canvas, {width, height});
    this.change();
  }
  /** Shows all; as the picture does where the canvas has its sides. */
  home() {
    const {width, height} = this.canvas, {facts, camera, cut} = this;
    const isFirst = cut.axis === (facts.cut?.axis ?? '') && !cut.other &&
      (!facts.cut || this.scene.middle['xyz'.indexOf(cut.axis)] + cut.at[cut.axis] === facts.cut.at);
    if (facts.camera && isFirst && Math.abs(3 * width / (4 * height) - 1) < 0.01) {
      camera.use(facts.camera, this.scene.middle);
    } else {
      Object.assign(camera, cut.direction());
      const plane = cut.axis === 'view' ? null : cut.plane(camera);
      camera.fit(width, height, plane && (x => dot(plane.normal, x) + plane.offset));
    }
    this.change();
  }
  showScale() {
    const scale = this.camera.scale(this.canvas.width, this.canvas.height) *
      this.canvas.clientWidth / this.canvas.width;
    const length = roundLength(this.canvas.clientWidth / 5 / scale);
    this.part('.view-scale i').style.width = `${length * scale}px`;
    this.part('.view-scale span').textContent = `${Number(length.toPrecision(1))} mm`;
  }

  // Colors

  rampOf(colors) {
    const stops = colors.map(rgbOf), ramp = new Uint8Array(3 * 256);
    for (let i = 0; i < 256; ++i) {
      const at = i / 255 * (stops.length - 1), low = Math.min(Math.floor(at), stops.length - 2);
      for (let d = 0; d < 3; ++d)
        ramp[3 * i + d] = Math.round(stops[low][d] + (at - low) * (stops[low + 1][d] - stops[low][d]));
    }
    return ramp;
  }
  /** Colors of kinds, for properties that have few values; null: a ramp. */
  kindsOf(property) {
    const {kinds, regions} = this.facts.colors;
    if (property.name === 'region' && property.whole && property.lo + property.most <= 1)
      return {colors: regions, names: ['cortical', 'trabecular']};
    if (property.words) return {colors: property.words.map((word, i) => kinds[i % kinds.length]),
      names: property.words};
    if (property.kinds) return {colors: kinds, names: kinds.map((color, i) => String(i))};
    return null;
  }
  setColor(index) {
    this.color = index;
    this.part('.view-color').selectedIndex = index;
    const property = this.properties[index], kinds = this.kindsOf(property);
    const {numbers, none, least, most} = property;
    const colors = this.colors = new Uint8Array(4 * numbers.length);
    const table = kinds && kinds.colors.map(rgbOf);
    const first = kinds ? property.lo : 0;
    for (let i = 0; i < numbers.length; ++i) {
      const n = numbers[i];
      if (table) {
        colors.set(table[n + first], 4 * i);
      } else {
        const share = most > least ? (n === none ? 0 : (n - least) / (most - least)) : 0.5;
        const at = 3 * Math.round(255 * share);
        colors[4 * i] = this.ramp[at];
        colors[4 * i + 1] = this.ramp[at + 1];
        colors[4 * i + 2] = this.ramp[at + 2];
      }
    }
    this.drawing.setColors(this.withChosen());
    this.showLegend(property, kinds);
    this.change();
  }
  withChosen() {
    if (this.chosen < 0) return this.colors;
    const colors = this.colors.slice();
    colors.set(CHOSEN, 4 * this.chosen);
    return colors;
  }
  showLegend(property, kinds) {
    const legend = this.part('.view-legend');
    const bar = background => {
      const i = document.createElement('i');
      i.style.background = background;
      return i;
    };
    if (kinds) {
      const used = kinds.names.map((name, n) => n).filter(
        n => n >= property.lo + property.least && n <= property.lo + property.most);
      legend.replaceChildren(...used.slice(0, 8).flatMap(n => {
        const i = bar(kinds.colors[n]);
        i.className = 'kind';
        return [i, kinds.names[n]];
      }));
      return;
    }
    const text = n => property.whole || property.isRow ? property.format(property.valueOf(n))
      : String(Number(property.valueOf(n).toPrecision(4)));
    const unit = property.unit ? ' ' + property.unit : '';
    legend.replaceChildren(...property.most > property.least
      ? [text(property.least), bar(`linear-gradient(to right, ${this.facts.colors.ramp.join(', ')})`),
         text(property.most) + unit]
      : [property.least <= property.most ? text(property.least) + unit : '–']);
  }

  // The sphere that is chosen

  choose(index) {
    this.chosen = index;
    this.drawing.setColors(this.withChosen());
    this.change();
    const panel = this.part('.view-row');
    panel.replaceChildren();
    if (index < 0) return;
    const table = document.createElement('table');
    for (const [name, value] of this.rowOf(index)) {
      const row = table.insertRow(), head = document.createElement('th');
      head.textContent = name;
      row.append(head);
      row.insertCell().textContent = value;
    }
    panel.append(table);
  }
  /** Names and values of what is known of a sphere. */
  rowOf(index) {
    const {facts, scene, rows} = this;
    const digits = clamp(-Math.floor(Math.log10(facts.step)), 0, 12);
    const position = ['x', 'y', 'z'].slice(0, facts.dim).map((axis, d) => [
      axis, (scene.spheres[4 * index + d] + scene.middle[d]).toFixed(digits) + ' mm']);
    return [['row, from 0', String(rows[index])], ...position,
      ...this.properties.map(property => [property.name, property.textOf(index)])];
  }
  /** The sphere at a point of the canvas, CSS pixels from its upper left; -1: none. */
  at(x, y) {
    const {clientWidth, clientHeight, width, height} = this.canvas;
    const ray = this.camera.ray(2 * x / clientWidth - 1, 1 - 2 * y / clientHeight, width, height);
    return this.drawing.pick(ray, this.cut.plane(this.camera));
  }

  // The cut

  setCut(axis) {
    this.cut.axis = axis;
    this.showCut();
    this.change();
  }
  moveCut(share) {
    this.cut.setShare(share, this.camera);
    this.showCut();
    this.change();
  }
  showCut() {
    if (this.scene.plane) return;
    const {cut, camera} = this;
    this.part('.view-axis').value = cut.axis;
    this.part('.view-other').checked = cut.other;
    for (const name of ['.view-where', '.view-flip'])
      this.part(name).classList.toggle('none', !cut.axis);
    if (!cut.axis) return;
    this.part('.view-at').value = Math.round(1000 * cut.share(camera));
    this.part('.view-position').textContent = cut.text(camera);
  }

  // Controls

  fillControls() {
    const {facts} = this;
    this.part('.view-color').replaceChildren(
      ...this.properties.map(property => new Option(property.name)));
    this.part('.view-wall').classList.toggle('none', !facts.wall && !facts.outline);
    const words = [];
    if (facts.words) words.push(facts.words);
    if (facts.leftOut) words.push(`Not in this page, which would be too large: ${facts.leftOut}`);
    if (facts.wall && facts.wall.triangles < facts.wall.of)
      words.push(`The wall is shown with ${facts.wall.triangles.toLocaleString('en')} of ` +
                 `${facts.wall.of.toLocaleString('en')} triangles`);
    words.push(`Positions are rounded to ${facts.step.toPrecision(1)} mm`);
    this.part('.view-words').textContent = words.join('. ') + '.';
  }
  listen() {
    const {canvas} = this;
    const on = (name, event, use) => this.part(name)?.addEventListener(event, use);
    on('.view-color', 'change', event => this.setColor(event.target.selectedIndex));
    on('.view-wall input', 'change', () => this.change());
    on('.view-all', 'click', () => this.home());
    on('.view-save', 'click', () => this.save());
    on('.view-axis', 'change', event => this.setCut(event.target.value));
    on('.view-at', 'input', event => this.moveCut(event.target.value / 1000));
    on('.view-other', 'change', event => {
      this.cut.other = event.target.checked;
      this.change();
    });
    canvas.addEventListener('keydown', event => this.key(event));
    canvas.addEventListener('wheel', event => this.wheel(event), {passive: false});
    canvas.addEventListener('contextmenu', event => event.preventDefault());
    canvas.addEventListener('webglcontextlost', () => this.leave('the graphics device was lost'));
    new Fingers(this);
    new ResizeObserver(() => this.resize()).observe(canvas);
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.resize());
  }
  /** Shares of the half sides of the canvas, y up. */
  shares(event) {
    const box = this.canvas.getBoundingClientRect();
    return [2 * (event.clientX - box.left) / box.width - 1,
      1 - 2 * (event.clientY - box.top) / box.height];
  }
  wheel(event) {
    // A page that scrolls keeps its wheel until the view is clicked.
    if (!this.root.classList.contains('view-large') && document.activeElement !== this.canvas) return;
    event.preventDefault();
    const pixels = event.deltaY * [1, 16, 400][event.deltaMode];
    this.zoom(Math.exp(-clamp(pixels, -400, 400) / 500), ...this.shares(event));
  }
  zoom(factor, x = 0, y = 0) {
    this.camera.zoom(factor, x, y, this.canvas.width, this.canvas.height);
    this.change();
  }
  turn(dx, dy) {
    this.camera.turn(dx, dy);
    this.showCut();
    this.change();
  }
  move(dx, dy) {
    this.camera.move(dx, dy, this.canvas.width, this.canvas.height);
    this.change();
  }
  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const {cut, scene} = this;
    const arrows = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]};
    const keys = {
      '+': () => this.zoom(1.25), '=': () => this.zoom(1.25), '-': () => this.zoom(0.8),
      c: () => this.setColor((this.color + 1) % this.properties.length),
      w: () => {
        const box = this.part('.view-wall input');
        box.checked = !box.checked;
        this.change();
      },
      r: () => this.home(), Home: () => this.home(), p: () => this.save(),
      Escape: () => this.choose(-1)
    };
    if (!scene.plane) {
      for (const [name, axis] of [['x', 'x'], ['y', 'y'], ['z', 'z'], ['v', 'view']])
        keys[name] = () => this.setCut(cut.axis === axis ? '' : axis);
      if (cut.axis)
        Object.assign(keys, {
          '[': () => this.moveCut(cut.share(this.camera) - 0.01),
          ']': () => this.moveCut(cut.share(this.camera) + 0.01),
          o: () => {
            cut.other = !cut.other;
            this.showCut();
            this.change();
          }
        });
    }
    const arrow = arrows[event.key];
    const act = arrow
      ? () => event.shiftKey || scene.plane ? this.move(-0.1 * arrow[0], -0.1 * arrow[1])
        : this.turn(-0.1 * arrow[0], -0.1 * arrow[1])
      : keys[event.key] ?? keys[event.key.toLowerCase()];
    if (!act) return;
    event.preventDefault();
    act();
  }
  save() {
    this.drawBest();
    this.canvas.toBlob(blob => {
      const link = document.createElement('a');
      link.href = URL.createObjectURL(blob);
      link.download = document.title.replace(/[^\w.-]+/g, '-') + '.png';
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    });
  }
  /** Gives way to the picture. */
  leave(reason) {
    this.root.hidden = true;
    this.figure.classList.remove('viewing');
    explain(this.figure, reason);
  }
}

/** Mouse, pen and fingers on the canvas: one turns or moves, two move and zoom, a click chooses. */
class Fingers {
  constructor(view) {
    this.view = view;
    this.down = new Map();
    const {canvas} = view;
    canvas.addEventListener('pointerdown', event => this.press(event));
    canvas.addEventListener('pointermove', event => this.drag(event));
    for (const end of ['pointerup', 'pointercancel'])
      canvas.addEventListener(end, event => this.release(event));
  }
  press(event) {
    this.view.canvas.focus({preventScroll: true});
    this.view.canvas.setPointerCapture(event.pointerId);
    this.down.set(event.pointerId, [event.clientX, event.clientY]);
    if (this.down.size === 1) this.start = [event.clientX, event.clientY];
    this.isClick = this.down.size === 1 && event.button === 0;
    event.preventDefault();
  }
  drag(event) {
    const last = this.down.get(event.pointerId);
    if (!last) return;
    const {view} = this, {clientWidth, clientHeight} = view.canvas;
    const half = Math.max(clientWidth, clientHeight) / 2;
    const dx = event.clientX - last[0], dy = event.clientY - last[1];
    const spread = () => {
      const [a, b] = [...this.down.values()];
      return Math.hypot(a[0] - b[0], a[1] - b[1]);
    };
    if (Math.hypot(event.clientX - this.start[0], event.clientY - this.start[1]) > CLICK)
      this.isClick = false;
    if (this.isClick) return;
    if (this.down.size >= 2) {
      const before = spread();
      this.down.set(event.pointerId, [event.clientX, event.clientY]);
      view.move(dx / half / 2, dy / half / 2);
      if (before > 0) view.zoom(spread() / before, ...view.shares(event));
      return;
    }
    this.down.set(event.pointerId, [event.clientX, event.clientY]);
    if (view.scene.plane || event.shiftKey || (event.buttons & 6) !== 0)
      view.move(dx / half, dy / half);
    else
      view.turn(Math.PI * dx / (2 * half), Math.PI * dy / (2 * half));
  }
  release(event) {
    if (!this.down.delete(event.pointerId)) return;
    if (!this.isClick || event.type !== 'pointerup') return;
    const box = this.view.canvas.getBoundingClientRect();
    this.view.choose(this.view.at(event.clientX - box.left, event.clientY - box.top));
    this.isClick = false;
  }
}

/** Says why there is no view. */
function explain(figure, reason) {
  const words = document.createElement('p');
  words.className = 'words';
  words.textContent = `This browser shows no view that can be turned: ${reason}.`;
  figure.append(words);
}

async function startView(figure) {
  const text = name => figure.querySelector(name).textContent;
  try {
    if (typeof DecompressionStream === 'undefined')
      throw new Error('it cannot inflate data (DecompressionStream)');
    const facts = JSON.parse(text('.view-facts'));
    const arrays = await arraysOf(facts, bytesOf(text('.view-bytes')));
    figure.view = new View(figure, facts, arrays);
    figure.view.start();
  } catch (error) {
    explain(figure, error.message);
  }
}

startView(document.currentScript.parentElement);
})();
