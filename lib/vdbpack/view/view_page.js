const BEHIND = -0.2;          // ends of axes that point more away from the viewer are not named
const REST = 150;             // ms without change before a picture in full quality is drawn
const SLOW = 80, FAST = 25;   // ms of a frame: fewer or more spheres are drawn
const CLICK = 5;              // pixels that a click may move
const MOST_PIXELS = 2048;     // along a side of the canvas
// Where pictures look from, as azimuth and rise: without a cut, at a cut, and on the plane.
const DIRECTIONS = {'': [-55, 22], view: [-55, 22], x: [-28, 20], y: [-62, 20], z: [-62, 62],
  plane: [-90, 90]};

/** A color of the page's style, as shares. */
function sharesOf(color) {
  return color.match(/[\d.]+/g).slice(0, 3).map(c => c / 255);
}

/** 1, 2 or 5 times a power of ten, at most `most`. */
function roundLength(most) {
  const power = 10 ** Math.floor(Math.log10(most));
  return [5, 2, 1].find(k => k * power <= most) * power;
}

/** A plane that can be moved; keeps the side that the pictures keep, or the other. */
class Cut {
  constructor(scene, camera, first) {
    this.scene = scene;
    this.camera = camera;
    this.axis = first?.axis ?? '';
    this.at = {x: 0, y: 0, z: 0, view: scene.size};  // from the middle, or from the front, mm
    if (first) this.at[first.axis] = first.at - scene.middle['xyz'.indexOf(first.axis)];
    this.other = false;
  }
  /** Normal and offset: what is kept has n · x + offset >= 0; null: all is kept. */
  plane() {
    const {axis, other, at} = this;
    if (this.scene.plane) return {normal: [0, 0, -1], offset: 0};
    if (!axis) return null;
    const way = (axis === 'y' ? 1 : -1) * (other ? -1 : 1);
    if (axis !== 'view')
      return {normal: ['x', 'y', 'z'].map(name => name === axis ? way : 0), offset: -way * at[axis]};
    const {toward} = this.camera.frame();
    return {normal: toward.map(c => way * c), offset: way * (at.view - this.interval()[1] / 2)};
  }
  /** The interval in which it meets the scene. */
  interval() {
    const {half} = this.scene, d = 'xyz'.indexOf(this.axis);
    if (this.axis !== 'view') return [-half[d], half[d]];
    return [0, 2 * this.camera.frame().toward.reduce((sum, c, k) => sum + Math.abs(c) * half[k], 0)];
  }
  move(at) { this.at[this.axis] = clamp(at, ...this.interval()); }
  text() {
    const {axis, scene} = this, digits = clamp(2 - Math.floor(Math.log10(scene.size)), 0, 9);
    return ((scene.middle['xyz'.indexOf(axis)] ?? 0) + this.at[axis]).toFixed(digits) +
      (axis === 'view' ? ' mm deep' : ' mm');
  }
  /** Turns the camera to where pictures look at it from. */
  face() {
    const degree = Math.PI / 180, {axis, other, camera} = this;
    const [azimuth, rise] = DIRECTIONS[this.scene.plane ? 'plane' : axis];
    const isBehind = other && axis && axis !== 'view';
    camera.azimuth = (azimuth + (isBehind ? 180 : 0)) * degree;
    camera.rise = (isBehind ? -rise : rise) * degree;
  }
}

/** The view in a figure: its controls, and when what is drawn. */
class View {
  constructor(figure, facts, {rows, properties}, scene) {
    this.figure = figure;
    this.root = figure.querySelector('.view');
    this.canvas = this.part('canvas');
    Object.assign(this, {facts, rows, scene, all: properties});
    this.properties = properties.slice(3);  // that give colors
    this.gl = this.canvas.getContext('webgl2', {antialias: false, alpha: false,
      preserveDrawingBuffer: true, powerPreference: 'high-performance'});
    if (!this.gl) throw new Error('WebGL2 is not available');
    this.drawing = new Drawing(this.gl, scene);
    this.camera = new Camera(scene, this.canvas);
    this.cut = new Cut(scene, this.camera, facts.cut);
    this.chosen = -1;
    this.budget = 100000;
    this.down = new Map();  // fingers on the canvas, and where they were last
    figure.classList.add('viewing');
    this.root.hidden = false;
    this.part('.view-color').replaceChildren(...this.properties.map(p => new Option(p.name)));
    this.part('.view-words').textContent = facts.words;
    this.part('.view-wall').classList.toggle('none', !scene.wall);
    this.resize();
    this.home();
    this.setColor(Math.max(0, this.properties.findIndex(p => p.name === facts.color)));
    if (scene.solids) this.showSolids(scene.solids);
    this.listen();
    this.tick();
  }
  part(name) { return this.root.querySelector(name); }

  // What is drawn

  look() {
    return {frame: this.camera.frame(), cut: this.cut.plane(), chosen: this.chosen,
      wall: this.part('.view-wall input').checked, paper: this.paper, ink: this.ink};
  }
  /** To be called after anything that is seen has changed. */
  change() {
    this.showCut();
    this.isDirty = true;
    this.changed = performance.now();
    this.drawing.work = null;
    this.root.dataset.state = 'moving';
  }
  /** Draws what there is to draw once the last work is done; runs before each frame. */
  tick() {
    requestAnimationFrame(() => this.tick());
    if (this.gl.isContextLost() || this.isBusy()) return;
    const isFrame = this.isDirty;
    if (isFrame)
      this.drawNow();
    else if (this.root.dataset.state === 'still' || performance.now() - this.changed < REST)
      return;
    else if (this.drawing.stepBest(this.look()))
      this.root.dataset.state = 'still';
    this.begun = isFrame ? performance.now() : null;
    this.fence = this.gl.fenceSync(this.gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    this.gl.flush();
  }
  /** Whether the last work is not done. Where frames are slow, fewer spheres are drawn in them. */
  isBusy() {
    const {gl, fence, begun} = this;
    if (!fence) return false;
    if (gl.clientWaitSync(fence, 0, 0) === gl.TIMEOUT_EXPIRED) return true;
    gl.deleteSync(fence);
    this.fence = null;
    const time = performance.now() - begun;
    if (begun && time > SLOW && this.budget > 20000) this.budget *= 0.7;
    if (begun && time < FAST && this.budget < 4e6) this.budget *= 1.3;
    return false;
  }
  drawNow() {
    this.isDirty = false;
    this.drawing.draw(this.look(), this.budget);
    this.showScale();
    if (!this.scene.plane) this.showSides();
  }
  /** Completes the picture in full quality. */
  drawBest() {
    if (this.isDirty) this.drawNow();
    while (!this.drawing.stepBest(this.look()));
    this.root.dataset.state = 'still';
  }
  resize() {
    const box = this.canvas.getBoundingClientRect();
    const longer = Math.max(box.width, box.height, 1);
    const ratio = Math.min(window.devicePixelRatio || 1, MOST_PIXELS / longer);
    const width = Math.max(1, Math.round(box.width * ratio));
    const height = Math.max(1, Math.round(box.height * ratio));
    const style = getComputedStyle(this.figure);
    this.paper = sharesOf(style.backgroundColor);
    this.ink = sharesOf(style.color);
    if (this.canvas.width !== width || this.canvas.height !== height)
      Object.assign(this.canvas, {width, height});
    this.change();
  }
  /** Shows all, as pictures do. */
  home() {
    const {cut} = this;
    cut.face();
    this.camera.fit(cut.axis === 'view' ? null : cut.plane());
    this.change();
  }
  showScale() {
    const {width, clientWidth} = this.canvas, scale = this.camera.scale() * clientWidth / width;
    const length = roundLength(clientWidth / 5 / scale);
    this.part('.view-scale i').style.width = `${length * scale}px`;
    this.part('.view-scale span').textContent = `${Number(length.toPrecision(1))} mm`;
  }

  /** The ends of the axes that one sees. */
  showSides() {
    const {right, up, toward} = this.camera.frame();
    const ends = this.facts.sides.flatMap((names, k) => names.map((name, end) => {
      const sign = end ? -1 : 1;
      return {name, x: sign * right[k], y: -sign * up[k], near: sign * toward[k]};
    })).filter(end => end.near > BEHIND).sort((a, b) => a.near - b.near);
    this.part('.view-sides').innerHTML = ends.map(({name, x, y}) =>
      `<path d="M0 0L${30 * x} ${30 * y}"/><text x="${42 * x}" y="${42 * y}">${name}</text>`).join('');
  }

  // Colors

  setColor(index) {
    this.color = index;
    this.part('.view-color').selectedIndex = index;
    const property = this.properties[index], {colors, numbers, lo, none, least, most} = property;
    const {ramp} = this.facts, end = ramp.length - 1;
    const shadeOf = n => Math.round(most > least ? n === none ? 0 : end * (n - least) / (most - least)
      : end / 2);
    this.colors = new Uint8Array(4 * numbers.length);
    for (let i = 0; i < numbers.length; ++i)
      this.colors.set(colors ? colors[lo + numbers[i]] : ramp[shadeOf(numbers[i])], 4 * i);
    this.drawing.setColors(this.colors);
    this.showLegend(property);
    this.change();
  }
  showSolids(solids) {
    const several = solids.length > 1;
    this.showLegend({colors: several ? solids.map(s => s.color) : [], names: solids.map(s => s.name),
      lo: 0, least: 0, most: solids.length});
  }
  showLegend({colors, names, lo, least, most, unit, step, whole}) {
    const bar = (background, className = '') => {
      const i = Object.assign(document.createElement('i'), {className});
      i.style.background = background;
      return i;
    };
    const ramp = this.facts.ramp.map(color => `rgb(${color})`);
    const text = n => String(whole ? lo + n : Number((lo + step * n).toPrecision(4)));
    const range = most > least
      ? [text(least), bar(`linear-gradient(to right, ${ramp})`), `${text(most)} ${unit}`]
      : [least <= most ? `${text(least)} ${unit}` : '–'];
    const kind = (color, k) => {
      const span = document.createElement('span');
      span.append(bar(`rgb(${color})`, 'kind'), names[k]);
      return span;
    };
    this.part('.view-legend').replaceChildren(...!colors ? range : colors.flatMap((color, k) =>
      k < lo + least || k > lo + most ? [] : [kind(color, k)]));
  }

  // The sphere that is chosen

  choose(index) {
    this.chosen = index;
    this.change();
    this.part('.view-row').replaceChildren(...index < 0 ? [] : [this.tableOf(index)]);
  }
  /** What is known of a sphere. */
  tableOf(index) {
    const table = document.createElement('table');
    const shown = this.all.filter((property, k) => k !== 2 || !this.scene.plane);
    for (const texts of [['row, from 0', this.rows[index]],
                         ...shown.map(p => [p.name, p.textOf(index)])]) {
      const row = table.insertRow();
      for (const text of texts) row.insertCell().textContent = text;
    }
    return table;
  }
  /** The sphere at a point of the canvas, CSS pixels from its upper left; -1: none. */
  at(x, y) {
    const {clientWidth, clientHeight} = this.canvas;
    const ray = this.camera.ray(2 * x / clientWidth - 1, 1 - 2 * y / clientHeight);
    return this.drawing.pick(ray, this.cut.plane());
  }

  // Controls

  showCut() {
    const {cut} = this, slider = this.part('.view-at');
    this.part('.view-axis').value = cut.axis;
    this.part('.view-other').checked = cut.other;
    for (const name of ['.view-where', '.view-flip'])
      this.part(name).classList.toggle('none', !cut.axis);
    if (!cut.axis) return;
    [slider.min, slider.max] = cut.interval();
    slider.value = cut.at[cut.axis];
    this.part('.view-position').textContent = cut.text();
  }
  listen() {
    const {canvas, cut} = this;
    const on = (name, event, use) => this.part(name).addEventListener(event, ({target}) => {
      use(target);
      this.change();
    });
    on('.view-color', 'change', list => this.setColor(list.selectedIndex));
    on('.view-wall input', 'change', () => {});
    on('.view-all', 'click', () => this.home());
    on('.view-save', 'click', () => this.save());
    on('.view-axis', 'change', list => { cut.axis = list.value; });
    on('.view-at', 'input', slider => cut.move(Number(slider.value)));
    on('.view-other', 'change', box => { cut.other = box.checked; });
    const listeners = {
      keydown: this.key, wheel: this.wheel, pointerdown: this.press, pointermove: this.drag,
      pointerup: this.release, pointercancel: this.release,
      contextmenu: event => event.preventDefault(),
      webglcontextlost: () => giveWay(this.figure, 'the graphics device was lost')
    };
    for (const [name, use] of Object.entries(listeners))
      canvas.addEventListener(name, event => use.call(this, event), {passive: false});
    new ResizeObserver(() => this.resize()).observe(canvas);
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.resize());
  }
  /** Shares of the half sides of the canvas, y up. */
  shares(event) {
    const {clientWidth, clientHeight} = this.canvas;
    return [2 * event.offsetX / clientWidth - 1, 1 - 2 * event.offsetY / clientHeight];
  }
  wheel(event) {
    // A page that scrolls keeps its wheel until the view is clicked.
    if (!this.root.classList.contains('view-large') && document.activeElement !== this.canvas) return;
    event.preventDefault();
    const pixels = event.deltaY * [1, 16, 400][event.deltaMode];
    this.zoom(Math.exp(-clamp(pixels, -400, 400) / 500), ...this.shares(event));
  }
  zoom(factor, x = 0, y = 0) {
    this.camera.zoom(factor, x, y);
    this.change();
  }
  /** Turns by angles, or moves on the plane. */
  turn(dx, dy) {
    if (this.scene.plane) return this.move(dx, dy);
    this.camera.turn(dx, dy);
    this.change();
  }
  move(dx, dy) {
    this.camera.move(dx, dy);
    this.change();
  }
  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const {cut, scene} = this;
    const arrow = (x, y) => () => event.shiftKey ? this.move(x, y) : this.turn(x, y);
    const keys = {
      ArrowLeft: arrow(0.1, 0), ArrowRight: arrow(-0.1, 0), ArrowUp: arrow(0, 0.1),
      ArrowDown: arrow(0, -0.1),
      '+': () => this.zoom(1.25), '=': () => this.zoom(1.25), '-': () => this.zoom(0.8),
      c: () => this.setColor((this.color + 1) % this.properties.length),
      w: () => this.part('.view-wall input').click(),
      r: () => this.home(), Home: () => this.home(), p: () => this.save(),
      Escape: () => this.choose(-1)
    };
    if (!scene.plane)
      for (const [name, axis] of [['x', 'x'], ['y', 'y'], ['z', 'z'], ['v', 'view']])
        keys[name] = () => { cut.axis = cut.axis === axis ? '' : axis; };
    if (cut.axis) {
      const [from, to] = cut.interval(), step = (to - from) / 100, at = cut.at[cut.axis];
      keys['['] = () => cut.move(at - step);
      keys[']'] = () => cut.move(at + step);
      keys.o = () => { cut.other = !cut.other; };
    }
    const act = keys[event.key] ?? keys[event.key.toLowerCase()];
    if (!act) return;
    event.preventDefault();
    act();
    this.change();
  }
  save() {
    this.drawBest();
    this.canvas.toBlob(blob => {
      const link = Object.assign(document.createElement('a'), {href: URL.createObjectURL(blob),
        download: document.title.replace(/[^\w.-]+/g, '-') + '.png'});
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    });
  }

  // Mouse, pen and fingers on the canvas: one turns or moves, two move and zoom, a click chooses

  press(event) {
    this.canvas.focus({preventScroll: true});
    this.canvas.setPointerCapture(event.pointerId);
    this.pressed = [event.clientX, event.clientY];
    this.down.set(event.pointerId, this.pressed);
    this.isClick = this.down.size === 1 && event.button === 0;
    event.preventDefault();
  }
  /** The distance between two fingers. */
  spread() {
    const [a, b] = [...this.down.values()];
    return Math.hypot(a[0] - b[0], a[1] - b[1]);
  }
  drag(event) {
    const {canvas, down, pressed} = this, last = down.get(event.pointerId);
    if (!last) return;
    if (Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > CLICK)
      this.isClick = false;
    if (this.isClick) return;
    const half = Math.max(canvas.clientWidth, canvas.clientHeight) / 2;
    const dx = (event.clientX - last[0]) / half, dy = (event.clientY - last[1]) / half;
    const before = down.size > 1 ? this.spread() : 0;
    down.set(event.pointerId, [event.clientX, event.clientY]);
    if (before > 0) {
      this.move(dx / 2, dy / 2);
      this.zoom(this.spread() / before, ...this.shares(event));
    } else if (this.scene.plane || event.shiftKey || (event.buttons & 6) !== 0) {
      this.move(dx, dy);
    } else {
      this.turn(Math.PI / 2 * dx, Math.PI / 2 * dy);
    }
  }
  release(event) {
    if (!this.down.delete(event.pointerId) || !this.isClick || event.type !== 'pointerup') return;
    this.choose(this.at(event.offsetX, event.offsetY));
    this.isClick = false;
  }
}

/** Shows the picture in place of the view, and says why. */
function giveWay(figure, reason) {
  figure.querySelector('.view').hidden = true;
  figure.classList.remove('viewing');
  figure.append(Object.assign(document.createElement('p'), {className: 'words',
    textContent: `This browser shows no view that can be turned: ${reason}.`}));
}

async function startView(figure) {
  try {
    if (typeof DecompressionStream === 'undefined')
      throw new Error('it cannot inflate data (DecompressionStream)');
    const facts = JSON.parse(figure.querySelector('.view-facts').textContent);
    const data = await propertiesOf(facts);
    figure.view = new View(figure, facts, data, await sceneOf(facts, data.properties));
  } catch (error) {
    giveWay(figure, error.message);
  }
}

startView(document.currentScript.parentElement);
})();
