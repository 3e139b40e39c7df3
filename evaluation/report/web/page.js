// The script of all our pages: sortable tables, viewers that flip between pictures and maps in place, and all other
// pictures enlarged.
// evaluation/report/page.cpp inlines it; evaluation/report/viewer.cpp writes what a viewer shows. docs/viewer.md is
// the manual.
'use strict';

// ---------------------------------------------------------------------------------------------------- small parts

/// An element with attributes, event listeners (on...: function) and children; text is never parsed as HTML.
function element(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith('on')) node.addEventListener(name.slice(2), value);
    else if (value !== undefined) node.setAttribute(name, value);
  }
  node.append(...children);
  return node;
}

const clamp = (value, low, high) => Math.min(Math.max(value, low), high);

// ------------------------------------------------------------------------------------------------ sortable tables

function makeSortable(table) {
  const heads = [...table.rows[0].cells];
  heads.forEach((head, column) => {
    if (!head.textContent) return;
    const sort = () => {
      const descending = head.getAttribute('aria-sort') === 'ascending';
      for (const other of heads) other.removeAttribute('aria-sort');
      head.setAttribute('aria-sort', descending ? 'descending' : 'ascending');
      const textOf = row => row.cells[column].textContent;
      const numberOf = row => parseFloat(textOf(row).replace('−', '-'));
      const order = (a, b) => {
        const x = numberOf(a), y = numberOf(b);
        if (isNaN(x) && isNaN(y)) return textOf(a).localeCompare(textOf(b)) * (descending ? -1 : 1);
        if (isNaN(x) || isNaN(y)) return isNaN(x) ? 1 : -1;  // what has no figure comes last
        return descending ? y - x : x - y;
      };
      const rows = [...table.rows].slice(1).sort(order);
      rows[0]?.parentElement.append(...rows);
    };
    const button = element('button', {type: 'button', title: 'Sort', onclick: sort}, ...head.childNodes);
    head.append(button);
  });
}

// ------------------------------------------------------------------------------------------------- values of maps

// The namespace of SVG, from the browser: a page that holds no address plainly loads nothing.
const kSvg = (() => {
  const box = document.createElement('template');
  box.innerHTML = '<svg></svg>';
  return box.content.firstChild.namespaceURI;
})();
const kMissing = -32768;  // of a packed map: NaN

/// Undoes pack_map() of viewer.cpp: deflated bytes, low then high, of each value's difference from what its neighbors
/// predict (Weinberger et al. 1996, "LOCO-I": the median of left, above and left + above - above left).
async function unpack({w, h, data}, step) {
  const deflated = Uint8Array.from(atob(data), digit => digit.charCodeAt(0));
  const stream = new Blob([deflated]).stream().pipeThrough(new DecompressionStream('deflate'));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const count = w * h, codes = new Int16Array(count), values = new Float32Array(count);
  for (let i = 0, y = 0; y < h; ++y) {
    for (let x = 0; x < w; ++x, ++i) {
      const left = x ? codes[i - 1] : y ? codes[i - w] : 0;
      const above = y ? codes[i - w] : left;
      const corner = x && y ? codes[i - w - 1] : above;
      const predicted = corner >= Math.max(left, above) ? Math.min(left, above)
                      : corner <= Math.min(left, above) ? Math.max(left, above) : left + above - corner;
      const folded = bytes[i] | bytes[count + i] << 8;
      codes[i] = predicted + (folded >> 1 ^ -(folded & 1));
      values[i] = codes[i] === kMissing ? NaN : codes[i] * step;
    }
  }
  return {w, h, values};
}

/// The pixels of an <img>, with their luma as values.
async function pixelsOf(image) {
  await image.decode();
  const w = image.naturalWidth, h = image.naturalHeight;
  const canvas = element('canvas');
  canvas.width = w;
  canvas.height = h;
  const context = canvas.getContext('2d', {willReadFrequently: true});
  context.drawImage(image, 0, 0);
  const rgba = context.getImageData(0, 0, w, h).data;
  const values = new Float32Array(w * h);
  for (let i = 0; i < values.length; ++i) {
    values[i] = 0.2126 * rgba[4 * i] + 0.7152 * rgba[4 * i + 1] + 0.0722 * rgba[4 * i + 2];
  }
  return {w, h, values, rgba};
}

/// a * scale + offset - b, where b may have another grid.
function difference(a, b, scale = 1, offset = 0) {
  const values = new Float32Array(a.w * a.h);
  for (let i = 0, y = 0; y < a.h; ++y) {
    const row = Math.floor((y + 0.5) * b.h / a.h) * b.w;
    for (let x = 0; x < a.w; ++x, ++i) {
      values[i] = a.values[i] * scale + offset - b.values[row + Math.floor((x + 0.5) * b.w / a.w)];
    }
  }
  return {w: a.w, h: a.h, values};
}

/// Blocks of the grid with the largest mean of |value|, none beside another: {x, y: middle, share of the grid; mean}.
function worstRegions({w, h, values}, count) {
  const columns = Math.min(32, w), rows = Math.max(1, Math.min(h, Math.round(columns * h / w)));
  const sums = new Float64Array(columns * rows), counts = new Float64Array(columns * rows);
  for (let i = 0, y = 0; y < h; ++y) {
    const row = Math.floor(y * rows / h) * columns;
    for (let x = 0; x < w; ++x, ++i) {
      if (isNaN(values[i])) continue;
      const block = row + Math.floor(x * columns / w);
      sums[block] += Math.abs(values[i]);
      ++counts[block];
    }
  }
  const full = w * h / (columns * rows) / 4;  // a block with fewer values says little
  const blocks = [...sums.keys()].filter(i => counts[i] >= full)
      .map(i => ({column: i % columns, row: Math.floor(i / columns), mean: sums[i] / counts[i]}))
      .sort((a, b) => b.mean - a.mean);
  const found = [];
  for (const block of blocks) {
    if (found.length === count) break;
    if (found.some(f => Math.abs(f.column - block.column) <= 1 && Math.abs(f.row - block.row) <= 1)) continue;
    found.push({...block, x: (block.column + 0.5) / columns, y: (block.row + 0.5) / rows});
  }
  return found;
}

const srgbFromLinear = v => v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055;
const linearFromSrgb = v => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;

// ------------------------------------------------------------------------------------------------------- a viewer

const kMostCached = 12;     // colored pictures that are kept
const kBlinkMs = 500;
const kMostZoom = 48;       // CSS pixels per pixel of the picture
const kHistogramBins = 96;
const kKeys = [
  ['1 … 9, 0', 'show a layer'], [', .', 'layer before, after'], ['[ ]', 'result before, after'],
  ['wheel, + −, two fingers', 'zoom, once the picture was clicked or focused'], ['drag, arrow keys', 'move'],
  ['f, double click', 'whole picture; double click in it zooms in'], ['s', 'results side by side'],
  ['b', 'blink with the layer chosen under Compare'], ['d', 'difference from it'],
  ['w', 'wipe: it is to the right of the pointer'], ['p', 'profile along a line; drag to draw it'],
  ['e q', 'exposure up, down by half a stop; for maps, a narrower or wider scale'], ['r', 'exposure as it was'],
];

class Viewer {
  constructor(figure) {
    this.figure = figure;
    this.images = [...figure.querySelectorAll(':scope > img')];
    // width, height, results, layers, signs
    Object.assign(this, JSON.parse(figure.querySelector('script').textContent));
    this.signs = Uint8Array.from(atob(this.signs), digit => digit.charCodeAt(0));  // colors of -1 ... 1, RGB
    this.byName = new Map(this.layers.map((layer, i) => [layer.name, i]));
    for (const layer of this.layers.filter(layer => layer.of)) {  // a difference lies on the grid of its first layer
      const {every, width, height} = this.layers[this.byName.get(layer.of[0])];
      Object.assign(layer, {every, width, height});
    }
    this.layer = this.byName.get('Portrait') ?? 0;
    this.result = 0;
    this.reference = this.counterpart();
    this.mode = 'off';
    this.sideBySide = false;
    this.stops = 0;
    this.zoom = 1;                                              // over that of the whole picture
    this.center = {x: this.width / 2, y: this.height / 2};      // in the picture's pixels
    this.pointer = null;                                        // likewise; null: none
    this.line = null;                                           // of the profile
    this.blinked = false;
    this.grids = new Map();                                     // promises of values
    this.colored = new Map();                                   // canvases, the latest last
    this.build();
    this.update();
  }

  // ---- what is shown

  comparable(reference = this.reference) {
    const a = this.layers[this.layer], b = this.layers[reference];
    return a.unit === b.unit && (a.colors === 'picture') === (b.colors === 'picture');
  }

  /// What the layer that is shown is compared with until the user chooses.
  counterpart() {
    const named = this.byName.get(this.layers[this.layer].against);
    if (named !== undefined) return named;
    const found = this.layers.findIndex((_, i) => i !== this.layer && this.comparable(i));
    return found < 0 ? this.layer : found;
  }

  /// The number of the plane that a layer shows of a result; undefined: none.
  planeIndex(layer, result) {
    const planes = this.layers[layer].planes;
    const index = planes.length === 1 ? 0 : result;
    return planes[index] ? index : undefined;
  }

  has(layer, result) {
    const {of} = this.layers[layer];
    return of ? of.every(name => this.has(this.byName.get(name), result))
              : this.planeIndex(layer, result) !== undefined;
  }

  /// A promise of {w, h, values, rgba of pictures}; null where the result has none.
  grid(layer, result) {
    if (!this.has(layer, result)) return Promise.resolve(null);
    const {of, fits, planes, step} = this.layers[layer];
    const key = of ? `${layer} ${result}` : `${layer} ${this.planeIndex(layer, result)}`;
    if (!this.grids.has(key)) {
      this.grids.set(key, (async () => {
        if (of) {
          const [a, b] = await Promise.all(of.map(name => this.grid(this.byName.get(name), result)));
          return difference(a, b, ...(fits?.[result] ?? [1, 0]));
        }
        const plane = planes[this.planeIndex(layer, result)];
        return plane.image !== undefined ? pixelsOf(this.images[plane.image]) : unpack(plane, step);
      })());
    }
    return this.grids.get(key);
  }

  /// What one pane shows: {layer: its description, grid, key}.
  async shown(result) {
    if (this.mode === 'difference' && this.comparable()) {
      const [a, b] = await Promise.all([this.grid(this.layer, result), this.grid(this.reference, result)]);
      const layer = this.layers[this.layer];
      const high = layer.colors === 'picture' ? 32 : layer.colors === 'diverging' ? layer.high / 4
                                                                                  : (layer.high - layer.low) / 8;
      const name = `${layer.name} − ${this.layers[this.reference].name}`;
      return {
        layer: {...layer, name, colors: 'diverging', low: -high, high, step: layer.step || 1},
        grid: a && b && difference(a, b), key: `${this.layer} - ${this.reference} ${result}`
      };
    }
    return this.plain(this.mode === 'blink' && this.blinked ? this.reference : this.layer, result);
  }

  /// One layer as shown() gives it.
  async plain(i, result) {
    return {layer: this.layers[i], grid: await this.grid(i, result), key: `${i} ${result}`};
  }

  /// The scale's ends at the exposure that is set.
  range({colors, low, high}) {
    const gain = 2 ** this.stops;
    if (colors === 'picture') return {low: 0, high: 255};
    return colors === 'diverging' ? {low: -high / gain, high: high / gain} : {low, high: low + (high - low) / gain};
  }

  /// A canvas of the grid's size in the layer's colors.
  color({layer, grid, key}) {
    const name = `${key} ${this.stops}`;
    let canvas = this.colored.get(name);
    this.colored.delete(name);
    if (!canvas) {
      canvas = element('canvas');
      canvas.width = grid.w;
      canvas.height = grid.h;
      const image = new ImageData(grid.w, grid.h);
      this.paint(layer, grid, image.data);
      canvas.getContext('2d').putImageData(image, 0, 0);
      if (this.colored.size >= kMostCached) this.colored.delete(this.colored.keys().next().value);
    }
    this.colored.set(name, canvas);
    return canvas;
  }

  paint(layer, {values, rgba}, out) {
    if (layer.colors === 'picture') {
      const gain = 2 ** this.stops;
      const code = Uint8ClampedArray.from({length: 256},
                                          (_, i) => 255 * srgbFromLinear(gain * linearFromSrgb(i / 255)));
      for (let i = 0; i < out.length; ++i) out[i] = i % 4 === 3 ? 255 : code[rgba[i]];
      return;
    }
    const {low, high} = this.range(layer), last = 255;
    const colors = this.scaleColors(layer);
    for (let i = 0; i < values.length; ++i) {
      const t = (values[i] - low) / (high - low);
      const at = isNaN(t) ? -1 : 3 * Math.round(last * clamp(t, 0, 1));
      for (let c = 0; c < 3; ++c) out[4 * i + c] = at < 0 ? 128 : colors[at + c];
      out[4 * i + 3] = 255;
    }
  }

  /// 256 colors from the scale's low end to its high one.
  scaleColors({colors}) {
    if (colors === 'diverging') return this.signs;
    return Uint8ClampedArray.from({length: 3 * 256}, (_, i) => {
      const t = Math.floor(i / 3) / 255;
      return 255 * (colors === 'light' ? srgbFromLinear(t) : t);
    });
  }

  // ---- where

  /// CSS pixels per pixel of the picture.
  scale(canvas) { return this.zoom * canvas.clientWidth / this.width; }

  toPicture(canvas, event) {
    const box = canvas.getBoundingClientRect(), scale = this.scale(canvas);
    return {x: this.center.x + (event.clientX - box.left - box.width / 2) / scale,
            y: this.center.y + (event.clientY - box.top - box.height / 2) / scale};
  }

  /// Zooms about a point that stays where it is.
  zoomBy(factor, about = this.center) {
    const canvas = this.panes[0].canvas;
    const zoom = clamp(this.zoom * factor, 1, Math.max(1, kMostZoom * this.width / canvas.clientWidth));
    const ratio = this.zoom / zoom;
    this.zoom = zoom;
    this.moveTo({x: about.x + (this.center.x - about.x) * ratio, y: about.y + (this.center.y - about.y) * ratio});
  }

  moveTo({x, y}) {
    const halfWidth = this.width / this.zoom / 2, halfHeight = this.height / this.zoom / 2;
    this.center = {x: clamp(x, halfWidth, this.width - halfWidth), y: clamp(y, halfHeight, this.height - halfHeight)};
    this.figure.classList.toggle('zoomed', this.zoom > 1);
    this.redraw();
  }

  wholePicture() {
    this.zoom = 1;
    this.moveTo(this.center);
  }

  // ---- the page's elements

  build() {
    const button = (text, key, onclick, more = {}) =>
        element('button', {type: 'button', onclick, title: key && `key ${key}`, ...more},
                ...(key ? [element('kbd', {'aria-hidden': 'true'}, key)] : []), text);
    this.layerButtons = this.layers.map((layer, i) =>
        button(layer.name, i < 10 ? String((i + 1) % 10) : undefined, () => this.showLayer(i)));
    this.resultButtons = this.results.length < 2 ? [] : this.results.map((name, i) =>
        button(name, undefined, () => this.showResult(i)));
    this.sideButton = button('Side by side', 's', () => this.act('s'), {class: 'apart'});
    this.modeButtons = new Map([['blink', 'b'], ['difference', 'd'], ['wipe', 'w']].map(([mode, key]) =>
        [mode, button(mode[0].toUpperCase() + mode.slice(1), key, () => this.act(key))]));
    this.referenceChoice = element('select', {'aria-label': 'Compare with', onchange: event => {
      this.reference = event.target.selectedIndex;
      this.update();
    }}, ...this.layers.map(layer => element('option', {}, layer.name)));
    this.profileButton = button('Profile', 'p', () => this.act('p'));
    const tools = [button('Whole', 'f', () => this.act('f')),
                   button('−', undefined, () => this.act('-'), {'aria-label': 'Zoom out'}),
                   button('+', undefined, () => this.act('+'), {'aria-label': 'Zoom in'}), this.profileButton,
                   element('label', {class: 'apart'}, 'Compare with ', this.referenceChoice),
                   ...this.modeButtons.values()];
    this.paneBox = element('div', {class: 'panes'});
    this.readout = element('table', {class: 'readout', 'aria-label': 'Values under the pointer'});
    this.histogram = element('canvas', {class: 'histogram', role: 'img'});
    this.bar = element('canvas', {class: 'bar-of-colors', role: 'img', 'aria-label': 'Color bar'});
    this.scaleLabels = element('div', {class: 'scale'});
    this.summary = element('div', {class: 'soft'});
    this.slider = element('input', {type: 'range', min: -5, max: 5, step: 0.25, value: 0, oninput: event => {
      this.stops = Number(event.target.value);
      this.redraw();
    }});
    this.sliderLabel = element('span');
    this.worst = element('div', {class: 'worst'});
    this.worstTitle = element('h5');
    this.note = element('p', {class: 'soft'});
    this.status = element('output', {'aria-live': 'polite', class: 'soft'});
    this.profileBox = element('div', {class: 'profile plot', hidden: ''});
    const keys = element('details', {class: 'keys'}, element('summary', {}, 'Keys'),
                         element('dl', {}, ...kKeys.flatMap(
                             ([key, what]) => [element('dt', {}, key), element('dd', {}, what)])));
    this.figure.classList.add('live');
    this.figure.append(
        element('div', {class: 'choices', role: 'toolbar', 'aria-label': 'Layers'}, ...this.layerButtons),
        ...(this.results.length < 2 ? [] : [element('div', {class: 'choices', role: 'toolbar', 'aria-label': 'Results'},
                                                     ...this.resultButtons, this.sideButton)]),
        element('div', {class: 'tools', role: 'toolbar', 'aria-label': 'Tools'}, ...tools),
        element('div', {}, this.paneBox, this.note, this.profileBox),
        element('div', {class: 'side'}, element('div', {class: 'scroll', tabindex: 0}, this.readout),
                element('div', {}, element('h5', {}, 'In view'), this.histogram, this.bar, this.scaleLabels,
                        this.summary),
                element('label', {}, this.sliderLabel, this.slider),
                element('div', {}, this.worstTitle, this.worst), this.status, keys));
    new ResizeObserver(() => this.redraw()).observe(this.paneBox);
    this.figure.addEventListener('pointerenter', () => { Viewer.active = this; });
    this.figure.addEventListener('focusin', () => { Viewer.active = this; });
  }

  makePane(result) {
    const canvas = element('canvas', {tabindex: 0, role: 'img'});
    canvas.style.aspectRatio = `${this.width} / ${this.height}`;
    const label = element('b');
    const touches = new Map();
    let pressed = null;  // where a drag began: {x, y} of the client, center, whether it draws a line
    canvas.addEventListener('pointerdown', event => {
      canvas.setPointerCapture(event.pointerId);
      touches.set(event.pointerId, event);
      const at = this.toPicture(canvas, event);
      pressed = {x: event.clientX, y: event.clientY, center: {...this.center}, line: this.drawsLine ? at : null};
    });
    canvas.addEventListener('pointermove', event => {
      this.pointer = this.toPicture(canvas, event);
      const others = [...touches.values()].filter(touch => touch.pointerId !== event.pointerId);
      if (touches.has(event.pointerId) && others.length === 1) {
        const before = touches.get(event.pointerId), other = others[0];
        const spread = e => Math.hypot(e.clientX - other.clientX, e.clientY - other.clientY);
        this.zoomBy(spread(event) / Math.max(spread(before), 1), this.pointer);
      } else if (pressed && event.buttons & 1) {
        if (pressed.line) {
          this.line = [pressed.line, this.pointer];
        } else {
          const scale = this.scale(canvas);
          this.moveTo({x: pressed.center.x - (event.clientX - pressed.x) / scale,
                       y: pressed.center.y - (event.clientY - pressed.y) / scale});
        }
      }
      if (touches.has(event.pointerId)) touches.set(event.pointerId, event);
      this.redraw();
    });
    const release = event => {
      touches.delete(event.pointerId);
      pressed = null;
    };
    canvas.addEventListener('pointerup', release);
    canvas.addEventListener('pointercancel', release);
    canvas.addEventListener('pointerleave', () => { this.pointer = null; this.redraw(); });
    canvas.addEventListener('dblclick', event => {
      if (this.zoom > 1) this.wholePicture();
      else this.zoomBy(4, this.toPicture(canvas, event));
    });
    canvas.addEventListener('wheel', event => {  // before it has the focus, the wheel scrolls the page
      if (document.activeElement !== canvas && !event.ctrlKey) return;
      event.preventDefault();
      this.zoomBy(2 ** (-event.deltaY / (event.deltaMode === 0 ? 200 : 5)), this.toPicture(canvas, event));
    }, {passive: false});
    return {box: element('div', {class: 'pane'}, canvas, label), canvas, label, result};
  }

  // ---- what the user does

  showLayer(i) {
    this.layer = clamp(i, 0, this.layers.length - 1);
    if (!this.comparable() || this.reference === this.layer) this.reference = this.counterpart();
    this.update();
  }

  showResult(i) {
    this.result = clamp(i, 0, this.results.length - 1);
    this.update();
  }

  setMode(mode) {
    this.mode = this.mode === mode ? 'off' : mode;
    clearInterval(this.timer);
    this.blinked = false;
    const blink = () => {
      this.blinked = !this.blinked;
      this.redraw();
    };
    if (this.mode === 'blink') this.timer = setInterval(blink, kBlinkMs);
    this.update();
  }

  setStops(stops) {
    this.stops = clamp(stops, -5, 5);
    this.slider.value = this.stops;
    this.redraw();
  }

  setProfile(on) {
    this.drawsLine = on;
    const half = this.width / this.zoom / 2;
    this.line = on ? [{x: this.center.x - half, y: this.center.y}, {x: this.center.x + half, y: this.center.y}] : null;
    this.profileBox.hidden = !on;
    this.update();
  }

  /// What a key does; false: nothing.
  act(key) {
    const step = this.width / this.zoom / 8;
    const zoom = factor => this.zoomBy(factor, this.pointer ?? this.center);
    const move = (x, y) => this.moveTo({x: this.center.x + x * step, y: this.center.y + y * step});
    const actions = {
      ',': () => this.showLayer(this.layer - 1), '.': () => this.showLayer(this.layer + 1),
      '[': () => this.showResult(this.result - 1), ']': () => this.showResult(this.result + 1),
      '+': () => zoom(1.5), '=': () => zoom(1.5), '-': () => zoom(1 / 1.5), 'f': () => this.wholePicture(),
      'ArrowLeft': () => move(-1, 0), 'ArrowRight': () => move(1, 0), 'ArrowUp': () => move(0, -1),
      'ArrowDown': () => move(0, 1),
      's': () => { this.sideBySide = !this.sideBySide && this.results.length > 1; this.update(); },
      'b': () => this.setMode('blink'), 'd': () => this.setMode('difference'), 'w': () => this.setMode('wipe'),
      'p': () => this.setProfile(!this.drawsLine),
      'e': () => this.setStops(this.stops + 0.5), 'q': () => this.setStops(this.stops - 0.5),
      'r': () => this.setStops(0),
    };
    if (/^[0-9]$/.test(key)) {
      const i = (Number(key) + 9) % 10;
      if (i >= this.layers.length) return false;
      this.showLayer(i);
      return true;
    }
    // arrow keys move what is zoomed; otherwise they scroll the page
    if (!actions[key] || (key.startsWith('Arrow') && this.zoom === 1)) return false;
    actions[key]();
    return true;
  }

  // ---- drawing

  /// After a choice: buttons, panes, note; then all that redraw() does.
  update() {
    this.layerButtons.forEach((button, i) => button.setAttribute('aria-pressed', i === this.layer));
    this.resultButtons.forEach(
        (button, i) => button.setAttribute('aria-pressed', i === this.result || this.sideBySide));
    this.sideButton.setAttribute('aria-pressed', this.sideBySide);
    this.figure.classList.toggle('beside', this.sideBySide);
    for (const [mode, button] of this.modeButtons) button.setAttribute('aria-pressed', mode === this.mode);
    this.profileButton.setAttribute('aria-pressed', Boolean(this.drawsLine));
    this.referenceChoice.selectedIndex = this.reference;
    const results = this.sideBySide ? [...this.results.keys()] : [this.result];
    if (this.panes?.length === results.length) {
      this.panes = this.panes.map((pane, i) => ({...pane, result: results[i]}));
    } else {
      this.panes = results.map(result => this.makePane(result));
      this.paneBox.replaceChildren(...this.panes.map(pane => pane.box));
    }
    const {name, note} = this.layers[this.layer], other = this.layers[this.reference].name;
    const incomparable = this.mode === 'difference' && !this.comparable();
    this.note.textContent = incomparable ? `${name} and ${other} differ in kind or unit.` : note;
    const whose = this.results.length < 2 ? '' : this.sideBySide ? ', all results' : `, ${this.results[this.result]}`;
    this.status.textContent = name + whose + (this.mode === 'off' ? '' : `, ${this.mode} with ${other}`);
    this.redraw();
  }

  /// Draws before the next frame, once however often it is called; again where something has changed meanwhile.
  async redraw() {
    this.changed = true;
    if (this.drawing) return;
    this.drawing = true;
    this.figure.setAttribute('aria-busy', 'true');
    while (this.changed) {
      await new Promise(requestAnimationFrame);
      this.changed = false;
      await this.draw();
    }
    this.drawing = false;
    this.figure.setAttribute('aria-busy', 'false');
  }

  async draw() {
    const panes = this.panes;
    const shown = await Promise.all(panes.map(pane => this.shown(pane.result)));
    const wiped = await Promise.all(
        this.mode === 'wipe' ? panes.map(pane => this.plain(this.reference, pane.result)) : []);
    if (panes !== this.panes) return;  // others stand there since
    panes.forEach((pane, i) => this.drawPane(pane, shown[i], wiped[i]));
    this.drawScale(shown[0]);
    await this.fillReadout();
    await this.listWorst(shown[0]);
    if (this.line) await this.drawProfile();
    this.figure.dataset.drawn = Number(this.figure.dataset.drawn ?? 0) + 1;  // for whoever waits for it
  }

  drawPane({canvas, label, result}, shown, wiped) {
    const density = window.devicePixelRatio || 1;
    const width = Math.round(canvas.clientWidth * density), height = Math.round(canvas.clientHeight * density);
    if (canvas.width !== width || canvas.height !== height) {
      canvas.width = width;
      canvas.height = height;
    }
    const context = canvas.getContext('2d'), scale = this.scale(canvas) * density;
    context.resetTransform();
    context.clearRect(0, 0, width, height);
    const left = width / 2 - this.center.x * scale, top = height / 2 - this.center.y * scale;
    const draw = ({layer, grid, key}) => {
      if (!grid) return;
      // a map that was sampled may reach over the picture's right and lower edge
      const w = grid.rgba ? this.width : grid.w * (layer.every ?? 1) * this.width / (layer.width ?? grid.w);
      const h = grid.rgba ? this.height : grid.h * (layer.every ?? 1) * this.height / (layer.height ?? grid.h);
      context.imageSmoothingEnabled = scale * w / grid.w < 2;
      context.imageSmoothingQuality = 'high';
      context.drawImage(this.color({layer, grid, key}), left, top, w * scale, h * scale);
    };
    draw(shown);
    if (wiped) {
      const at = this.pointer ? left + this.pointer.x * scale : width / 2;
      context.save();
      context.beginPath();
      context.rect(at, 0, width - at, height);
      context.clip();
      draw(wiped);
      context.restore();
      context.fillStyle = '#fff';
      context.fillRect(at - density, 0, 2 * density, height);
    }
    if (this.line) {
      const [a, b] = this.line;
      for (const [color, thick] of [['#000', 4], ['#ff0', 1.5]]) {
        context.strokeStyle = color;
        context.lineWidth = thick * density;
        context.beginPath();
        context.moveTo(left + a.x * scale, top + a.y * scale);
        context.lineTo(left + b.x * scale, top + b.y * scale);
        context.stroke();
      }
    }
    const name = shown.layer.name + (this.results.length > 1 ? ` · ${this.results[result]}` : '');
    label.textContent = shown.grid ? name : `${name}: none`;
    canvas.setAttribute('aria-label', `${label.textContent}. ${shown.layer.note ?? ''}`);
  }

  /// The grid's pixel at a point of the picture: {i: its index, x, y: the pixel of the file that it holds}; null:
  /// outside.
  pixelAt({w, h}, layer, {x, y}) {
    const fileWidth = layer.width ?? w, fileHeight = layer.height ?? h, every = layer.every ?? 1;
    const column = Math.floor(x * fileWidth / this.width / every);
    const row = Math.floor(y * fileHeight / this.height / every);
    if (column < 0 || row < 0 || column >= w || row >= h) return null;
    const inFile = (i, size) => Math.min(i * every + (every >> 1), size - 1);
    return {i: row * w + column, x: inFile(column, fileWidth), y: inFile(row, fileHeight)};
  }

  static digits(step) { return step && step < 1 ? Math.ceil(-Math.log10(step)) : 0; }

  valueText(layer, {values, rgba}, i) {
    if (rgba) return `${rgba[4 * i]} ${rgba[4 * i + 1]} ${rgba[4 * i + 2]}`;
    return isNaN(values[i]) ? '–' : values[i].toFixed(Viewer.digits(layer.step));
  }

  /// Every layer's value under the pointer; without one, in the middle of the view.
  async fillReadout() {
    const at = this.pointer ?? this.center;
    const results = this.panes.map(pane => pane.result);
    const rows = await Promise.all(this.layers.map(async (layer, l) => {
      const grids = await Promise.all(results.map(result => this.grid(l, result)));
      const first = grids.find(grid => grid);
      const pixel = first && this.pixelAt(first, layer, at);
      const row = element('tr', {class: l === this.layer ? 'shown' : '', 'data-layer': layer.name},
                          element('th', {scope: 'row', title: layer.unit}, layer.name),
                          element('td', {}, pixel && !first.rgba ? `${pixel.x}, ${pixel.y}` : ''));
      const shared = !layer.of && layer.planes.length === 1;
      for (const grid of shared ? [first] : grids) {
        row.append(element('td', shared ? {colspan: results.length} : {},
                           grid && pixel ? this.valueText(layer, grid, pixel.i) : ''));
      }
      return row;
    }));
    const head = element('tr', {}, element('th', {scope: 'col'}, this.pointer ? 'Pointer' : 'Middle'),
                         element('td', {}, `${Math.floor(at.x)}, ${Math.floor(at.y)}`),
                         ...results.map(result => element('td', {}, results.length > 1 ? this.results[result] : '')));
    this.readout.replaceChildren(head, ...rows);
  }

  /// Histogram of what is in view, over the color bar.
  drawScale({layer, grid}) {
    const {low, high} = this.range(layer);
    const bins = new Float64Array(kHistogramBins);
    let count = 0, sum = 0, squares = 0;
    if (grid) {
      const half = 0.5 / this.zoom, x = this.center.x / this.width, y = this.center.y / this.height;
      const x0 = Math.floor((x - half) * grid.w), x1 = Math.ceil((x + half) * grid.w);
      const y0 = Math.floor((y - half) * grid.h), y1 = Math.ceil((y + half) * grid.h);
      const stride = Math.max(1, Math.floor(Math.sqrt((x1 - x0) * (y1 - y0) / 2e5)));
      for (let y = Math.max(y0, 0); y < Math.min(y1, grid.h); y += stride) {
        for (let x = Math.max(x0, 0); x < Math.min(x1, grid.w); x += stride) {
          const value = grid.values[y * grid.w + x];
          if (isNaN(value)) continue;
          ++count;
          sum += value;
          squares += value * value;
          ++bins[clamp(Math.floor((value - low) / (high - low) * kHistogramBins), 0, kHistogramBins - 1)];
        }
      }
    }
    const style = getComputedStyle(this.figure);
    const canvas = this.histogram, context = canvas.getContext('2d');
    canvas.width = kHistogramBins * 4;
    canvas.height = 140;
    const most = Math.max(...bins, 1);
    context.fillStyle = style.getPropertyValue('--soft');
    // roots, so that small shares show
    bins.forEach((n, i) => context.fillRect(4 * i, 140 * (1 - Math.sqrt(n / most)), 3, 140));
    const colors = this.scaleColors(layer);
    this.bar.width = 256;
    this.bar.height = 1;
    const image = new ImageData(256, 1);
    for (let i = 0; i < 256; ++i) {
      for (let c = 0; c < 3; ++c) image.data[4 * i + c] = colors[3 * i + c];
      image.data[4 * i + 3] = 255;
    }
    this.bar.getContext('2d').putImageData(image, 0, 0);
    const text = value => Number(value.toPrecision(3)).toString();
    this.scaleLabels.replaceChildren(element('span', {}, text(low)), element('span', {}, text((low + high) / 2)),
                                     element('span', {}, `${text(high)} ${layer.unit}`));
    this.summary.textContent =
        count ? `mean ${text(sum / count)}, RMS ${text(Math.sqrt(squares / count))} ${layer.unit}` : 'nothing';
    const from = `Histogram from ${text(low)} to ${text(high)} ${layer.unit}`;
    this.histogram.setAttribute('aria-label', `${from}: ${this.summary.textContent}`);
    const sign = this.stops > 0 ? '+' : '';
    const brightness = layer.colors === 'picture' || layer.colors === 'light';
    this.sliderLabel.textContent =
        brightness ? `Exposure ${sign}${this.stops} EV` : `Scale × ${(2 ** -this.stops).toPrecision(2)}`;
  }

  /// Of the error or the difference that is shown; else of the result's first layer of errors.
  async listWorst(shown) {
    let what = shown;
    if (!this.layers[this.layer].of && this.mode !== 'difference') {
      const errors = this.layers.findIndex(layer => layer.of);
      what = errors < 0 ? {} : await this.plain(errors, this.result);
    }
    const key = what.grid ? what.key : '';
    if (this.worstKey === key) return;
    this.worstKey = key;
    this.worstTitle.textContent = what.grid ? `Worst of ${what.layer.name}, mean in ${what.layer.unit}` : '';
    this.worst.replaceChildren(...(what.grid ? worstRegions(what.grid, 8) : []).map(region => {
      const x = region.x * this.width, y = region.y * this.height;
      return element('button', {type: 'button', title: `at ${Math.round(x)}, ${Math.round(y)}`, onclick: () => {
        this.zoom = 6;
        this.moveTo({x, y});
      }}, region.mean.toPrecision(2));
    }));
  }

  /// The layer's values along the line: one curve for each result, and that of the layer's counterpart.
  async drawProfile() {
    const [a, b] = this.line, layer = this.layers[this.layer];
    const sources = layer.planes?.length === 1 && !layer.of ? [[this.layer, this.result, layer.name]]
                                               : this.results.map((name, result) => [this.layer, result, name]);
    if (this.byName.has(layer.against)) sources.push([this.byName.get(layer.against), this.result, layer.against]);
    const length = Math.hypot(b.x - a.x, b.y - a.y), count = clamp(Math.round(length), 2, 600);
    const curves = [];
    for (const [l, result, name] of sources) {
      const grid = await this.grid(l, result);
      if (!grid) continue;
      const points = [];
      for (let k = 0; k < count; ++k) {
        const t = k / (count - 1);
        const pixel = this.pixelAt(grid, this.layers[l], {x: a.x + t * (b.x - a.x), y: a.y + t * (b.y - a.y)});
        if (pixel && !isNaN(grid.values[pixel.i])) points.push([t, grid.values[pixel.i]]);
      }
      if (points.length) curves.push({name, points});
    }
    const all = curves.flatMap(curve => curve.points.map(point => point[1]));
    if (!all.length) return;
    const low = Math.min(...all), high = Math.max(...all), span = high - low || 1;
    const extent = `${low.toPrecision(3)} … ${high.toPrecision(3)} ${layer.unit}`;
    const svg = (tag, attributes, ...children) => {
      const node = document.createElementNS(kSvg, tag);
      for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
      node.append(...children);
      return node;
    };
    const place = ([t, value]) => `${(1000 * t).toFixed(1)},${(180 * (1 - (value - low) / span) + 5).toFixed(1)}`;
    const chart = svg('svg', {viewBox: '0 0 1000 190', preserveAspectRatio: 'none', role: 'img',
                              'aria-label': `Profile of ${layer.name}, ${extent}`},
                      svg('rect', {class: 'frame', x: 0, y: 0, width: 1000, height: 190}),
                      ...curves.map((curve, i) => svg('g', {class: `c${i % 6}`},
                                                      svg('polyline', {points: curve.points.map(place).join(' ')}))));
    const legend = curves.map((curve, i) => element(
        'span', {class: `name c${i % 6}`},
        svg('svg', {class: 'legend', viewBox: '0 0 22 9'},
            svg('line', {class: 'key', x1: 0, y1: 5, x2: 22, y2: 5, 'stroke-width': 3})), ` ${curve.name} `));
    this.profileBox.replaceChildren(
        element('div', {class: 'soft'}, `${layer.name}: ${extent} along ${Math.round(length)} pixels from ` +
                `${Math.round(a.x)}, ${Math.round(a.y)} to ${Math.round(b.x)}, ${Math.round(b.y)}. `, ...legend),
        chart);
  }
}

// ---------------------------------------------------------------------------------------------- enlarged pictures

const kMostEnlarged = 64;  // times as large as the window shows it

/// A click on one of the pictures opens it in the whole window, where the wheel zooms, a drag moves, arrow keys show the
/// others, and the pixel under the pointer is read out: its column and row, and its sRGB codes.
function makeEnlargeable(pictures) {
  let shown = 0, zoom = 1, x = 0, y = 0;  // where its top left corner lies, CSS pixels
  let pointer = null;  // where it was last seen in the window
  let pixels = null;   // of the picture that is shown, once they are decoded
  const large = element('img', {draggable: 'false'}), title = element('span', {'aria-live': 'polite'});
  const readout = element('span', {class: 'readout'});
  const close = element('button', {type: 'button', onclick: () => dialog.close()}, 'Close (Esc)');
  const dialog = element('dialog', {class: 'enlarged', 'aria-label': 'Enlarged picture'}, large,
                         element('p', {}, title, readout), close);
  document.body.append(dialog);

  const place = () => {
    large.style.transform = `translate(${x}px, ${y}px) scale(${zoom})`;
    read();
  };
  const zoomBy = (factor, at = {x: innerWidth / 2, y: innerHeight / 2}) => {
    const to = clamp(zoom * factor, 1, kMostEnlarged);
    x = to === 1 ? 0 : at.x - (at.x - x) * to / zoom;
    y = to === 1 ? 0 : at.y - (at.y - y) * to / zoom;
    zoom = to;
    place();
  };
  const show = i => {
    shown = (i + pictures.length) % pictures.length;
    const picture = pictures[shown], caption = picture.closest('figure')?.querySelector('figcaption');
    const row = picture.closest('tr')?.cells[0];
    large.src = picture.src;
    large.alt = title.textContent = [(caption ?? row)?.textContent, picture.alt].filter(Boolean).join(': ');
    pixels = null;
    zoomBy(0);
    if (!dialog.open) dialog.showModal();
    pixelsOf(picture).then(decoded => {
      if (picture !== pictures[shown]) return;
      pixels = decoded;
      read();
    });
  };
  /// `object-fit: contain` centers the picture in the element.
  const read = () => {
    readout.textContent = '';
    if (!pixels || !pointer) return;
    const {w, h, rgba} = pixels, box = large.getBoundingClientRect();
    const scale = Math.min(box.width / w, box.height / h);
    const column = Math.floor((pointer.x - box.left - (box.width - w * scale) / 2) / scale);
    const row = Math.floor((pointer.y - box.top - (box.height - h * scale) / 2) / scale);
    const inside = column >= 0 && column < w && row >= 0 && row < h, at = 4 * (row * w + column);
    if (inside) readout.textContent = `${column}, ${row}: ${rgba.slice(at, at + 3).join(' ')}`;
  };

  large.addEventListener('wheel', event => {
    event.preventDefault();
    zoomBy(2 ** (-event.deltaY / 240), {x: event.clientX, y: event.clientY});
  }, {passive: false});
  large.addEventListener('pointerdown', event => large.setPointerCapture(event.pointerId));
  large.addEventListener('pointermove', event => {
    pointer = {x: event.clientX, y: event.clientY};
    if (event.buttons && zoom > 1) {
      x += event.movementX;
      y += event.movementY;
    }
    place();
  });
  const forget = () => {
    pointer = null;
    read();
  };
  large.addEventListener('pointerleave', forget);
  dialog.addEventListener('close', forget);
  const acts = {ArrowLeft: () => show(shown - 1), ArrowRight: () => show(shown + 1), '+': () => zoomBy(1.5),
                '=': () => zoomBy(1.5), '-': () => zoomBy(1 / 1.5), f: () => zoomBy(0)};
  document.addEventListener('keydown', event => {  // wherever a click has left the focus
    if (dialog.open && !event.ctrlKey && !event.metaKey && !event.altKey) acts[event.key]?.();
  });

  pictures.forEach((picture, i) => {
    for (const [name, value] of [['role', 'button'], ['tabindex', '0'], ['title', 'Enlarge']]) {
      picture.setAttribute(name, value);
    }
    picture.addEventListener('click', () => show(i));
    picture.addEventListener('keydown', event => {
      if (event.key !== 'Enter' && event.key !== ' ') return;
      event.preventDefault();
      show(i);
    });
  });
}

document.addEventListener('keydown', event => {
  if (event.ctrlKey || event.metaKey || event.altKey || !Viewer.active) return;
  if (event.target.closest?.('input, select, textarea') || document.querySelector('dialog[open]')) return;
  if (Viewer.active.act(event.key)) event.preventDefault();
});

for (const table of document.querySelectorAll('table')) makeSortable(table);
const flat = [...document.querySelectorAll('img:not(.viewer img, .bar img, button img)')];
if (flat.length) makeEnlargeable(flat);
for (const figure of document.querySelectorAll('.viewer')) {
  const viewer = new Viewer(figure);
  Viewer.active ??= viewer;
}
