// The mask at any scale, drawn from the file's own rectangles: pixels hold the share that is open.
document.querySelectorAll(".zoom").forEach(async place => {
  const data = JSON.parse(place.nextElementSibling.textContent);
  const canvas = place.querySelector("canvas"), words = place.querySelector("output");
  const pen = canvas.getContext("2d");
  const [left, bottom, right, top] = data.outline;
  const shapes = await unpack(data.packed, data.count);
  const view = {};
  let wide = 0, high = 0, waiting = false;

  async function unpack(packed, count) {
    const bytes = Uint8Array.from(atob(packed), sign => sign.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    const all = new Int32Array(await new Response(stream).arrayBuffer());
    const columns = [...Array(8)].map((_, k) => Float64Array.from(all.subarray(k * count, (k + 1) * count)));
    columns.forEach(column => { for (let i = 1; i < count; i++) column[i] += column[i - 1]; });
    return columns;
  }
  function whole() {
    view.x = (left + right) / 2; view.y = (bottom + top) / 2;
    view.scale = Math.min(wide / (right - left), high / (top - bottom)) * 0.94;
  }
  // So many nm across the narrower side, about the aperture that is nearest to the middle.
  function nearest(span) {
    const [x, y, w, h, columns, rows, dx, dy] = shapes;
    let best = Infinity, at = [view.x, view.y];
    for (let i = 0; i < data.count; i++) {
      const c = step(view.x - x[i] - w[i] / 2, dx[i], columns[i]);
      const r = step(view.y - y[i] - h[i] / 2, dy[i], rows[i]);
      const middle = [x[i] + c * dx[i] + w[i] / 2, y[i] + r * dy[i] + h[i] / 2];
      const away = Math.hypot(middle[0] - view.x, middle[1] - view.y);
      if (away < best) { best = away; at = middle; view.size = [w[i], h[i]]; }
    }
    [view.x, view.y] = at;
    view.scale = Math.min(wide, high) / (span ?? 2 * Math.max(...(view.size ?? [data.pitch, data.pitch])));
  }
  const step = (away, by, count) => by ? Math.min(Math.max(Math.round(away / by), 0), count - 1) : 0;

  // Adds to each pixel the share of it that a rectangle (in pixels) covers, times a density.
  function cover(sum, x0, y0, x1, y1, density) {
    x0 = Math.max(x0, 0); y0 = Math.max(y0, 0); x1 = Math.min(x1, canvas.width); y1 = Math.min(y1, canvas.height);
    if (x0 >= x1 || y0 >= y1) return;
    const endX = Math.min(Math.ceil(x1), canvas.width), endY = Math.min(Math.ceil(y1), canvas.height);
    for (let j = Math.floor(y0); j < endY; j++) {
      const part = density * (Math.min(y1, j + 1) - Math.max(y0, j));
      for (let i = Math.floor(x0); i < endX; i++)
        sum[j * canvas.width + i] += part * (Math.min(x1, i + 1) - Math.max(x0, i));
    }
  }
  function draw() {
    waiting = false;
    const scale = view.scale * canvas.width / wide;
    const toX = x => (x - view.x) * scale + canvas.width / 2, toY = y => canvas.height / 2 - (y - view.y) * scale;
    const sum = new Float32Array(canvas.width * canvas.height);
    const [x, y, w, h, columns, rows, dx, dy] = shapes;
    for (let i = 0; i < data.count; i++) for (let c = 0; c < columns[i]; c++) {
      const x0 = toX(x[i] + c * dx[i]), x1 = x0 + w[i] * scale;
      if (x1 < 0 || x0 > canvas.width) continue;
      // Apertures closer than two pixels are one grey band.
      if (rows[i] > 1 && dy[i] * scale < 2) {
        const low = y[i] - (dy[i] - h[i]) / 2;
        cover(sum, x0, toY(low + rows[i] * dy[i]), x1, toY(low), h[i] / dy[i]);
        continue;
      }
      const floor = view.y - canvas.height / 2 / scale, ceiling = view.y + canvas.height / 2 / scale;
      const first = dy[i] ? Math.max(0, Math.floor((floor - y[i] - h[i]) / dy[i])) : 0;
      const last = dy[i] ? Math.min(rows[i] - 1, Math.ceil((ceiling - y[i]) / dy[i])) : 0;
      for (let r = first; r <= last; r++) {
        const y0 = y[i] + r * dy[i];
        cover(sum, x0, toY(y0 + h[i]), x1, toY(y0), 1);
      }
    }
    paint(sum, toX, toY);
    mark(scale, toX, toY);
  }
  function paint(sum, toX, toY) {
    const image = pen.createImageData(canvas.width, canvas.height);
    const [x0, x1, y0, y1] = [toX(left), toX(right), toY(top), toY(bottom)];
    for (let j = 0, k = 0; j < canvas.height; j++) for (let i = 0; i < canvas.width; i++, k++) {
      const inside = i + 0.5 > x0 && i + 0.5 < x1 && j + 0.5 > y0 && j + 0.5 < y1;
      let share = Math.min(sum[k], 1);
      if (data.drawn === "closed") share = 1 - share;
      const colour = inside ? [255 - 244 * share, 255 - 160 * share, 255 - 90 * share] : [226, 230, 234];
      image.data.set([...colour, 255], 4 * k);
    }
    pen.putImageData(image, 0, 0);
  }
  const length = nm => nm >= 1e6 ? `${+(nm / 1e6).toPrecision(4)} mm` : `${+(nm / 1e3).toPrecision(5)} µm`;
  function mark(scale, toX, toY) {
    const dot = canvas.width / wide;
    pen.lineWidth = dot; pen.strokeStyle = "#8a949e"; pen.fillStyle = "#1d232a";
    if (data.pitch * scale > 14 * dot) {
      pen.beginPath();
      const first = Math.ceil((view.x - canvas.width / 2 / scale - left) / data.pitch);
      for (let x = left + first * data.pitch; toX(x) < canvas.width && x <= right; x += data.pitch) {
        pen.moveTo(toX(x), Math.max(toY(top), 0)); pen.lineTo(toX(x), Math.min(toY(bottom), canvas.height));
      }
      pen.stroke();
    }
    // A scale bar of 1, 2 or 5 and zeros, on a ground of its own.
    const aim = 150 * dot / scale, power = 10 ** Math.floor(Math.log10(aim));
    const bar = [5, 2, 1].map(n => n * power).find(n => n <= aim);
    const x = 12 * dot, y = canvas.height - 14 * dot;
    pen.font = `${12 * dot}px system-ui, sans-serif`;
    pen.fillStyle = "rgba(255,255,255,.86)";
    pen.fillRect(x - 6 * dot, y - 24 * dot, Math.max(bar * scale, 60 * dot) + 12 * dot, 34 * dot);
    pen.fillStyle = "#1d232a";
    pen.fillRect(x, y, bar * scale, 3 * dot);
    pen.fillText(length(bar), x, y - 6 * dot);
    words.textContent = `Shown: ${length(wide / view.scale)} across the grooves × ${length(high / view.scale)} along, `
      + `middle at ${(view.x / 1e6).toFixed(3)}, ${(view.y / 1e6).toFixed(3)} mm`;
  }
  function redraw() {
    const far = Math.min(wide / (right - left), high / (top - bottom)) * 0.5;
    view.scale = Math.min(Math.max(view.scale, far), 0.05);
    view.x = Math.min(Math.max(view.x, left), right); view.y = Math.min(Math.max(view.y, bottom), top);
    if (!waiting) { waiting = true; requestAnimationFrame(draw); }
  }
  function zoom(factor, x = wide / 2, y = high / 2) {
    const [dx, dy] = [(x - wide / 2) / view.scale, (high / 2 - y) / view.scale];
    view.scale *= factor;
    view.x += dx * (1 - 1 / factor); view.y += dy * (1 - 1 / factor);
    redraw();
  }
  const move = (x, y) => { view.x -= x / view.scale; view.y += y / view.scale; redraw(); };
  const actions = {
    panel: () => { whole(); redraw(); }, grooves: () => { nearest(6 * data.pitch); redraw(); },
    aperture: () => { nearest(); redraw(); }, closer: () => zoom(2), farther: () => zoom(0.5),
  };
  place.querySelectorAll("button").forEach(one => one.addEventListener("click", actions[one.name]));
  const keys = {"+": actions.closer, "=": actions.closer, "-": actions.farther, "0": actions.panel,
    ArrowLeft: () => move(60, 0), ArrowRight: () => move(-60, 0), ArrowUp: () => move(0, 60), ArrowDown: () => move(0, -60)};
  canvas.addEventListener("keydown", event => {
    if (event.ctrlKey || event.metaKey || !keys[event.key]) return;
    event.preventDefault(); keys[event.key]();
  });
  // The wheel scrolls the page until the picture is chosen.
  canvas.addEventListener("wheel", event => {
    if (document.activeElement !== canvas) return;
    event.preventDefault(); zoom(2 ** (-event.deltaY / 300), event.offsetX, event.offsetY);
  }, {passive: false});
  const fingers = new Map();
  canvas.addEventListener("pointerdown", event => {
    fingers.set(event.pointerId, [event.offsetX, event.offsetY]);
    if (event.pointerType === "mouse") canvas.setPointerCapture(event.pointerId);
  });
  const lift = event => fingers.delete(event.pointerId);
  canvas.addEventListener("pointerup", lift); canvas.addEventListener("pointercancel", lift);
  canvas.addEventListener("pointermove", event => {
    const before = fingers.get(event.pointerId), now = [event.offsetX, event.offsetY];
    if (!before) return;
    const other = [...fingers].find(([id]) => id !== event.pointerId)?.[1];
    if (!other) move(now[0] - before[0], now[1] - before[1]);
    else {
      const reach = point => Math.hypot(point[0] - other[0], point[1] - other[1]);
      zoom(reach(now) / Math.max(reach(before), 1), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
    }
    fingers.set(event.pointerId, now);
  });
  function fit() {
    if (!canvas.clientWidth || canvas.clientWidth === wide) return;
    const was = wide && view.scale / wide;
    [wide, high] = [canvas.clientWidth, canvas.clientHeight];
    const dot = Math.min(devicePixelRatio || 1, 2);
    canvas.width = Math.round(wide * dot); canvas.height = Math.round(high * dot);
    if (was) view.scale = was * wide; else whole();
    redraw();
  }
  new ResizeObserver(fit).observe(canvas);
  // Paper does not wait for the next frame.
  addEventListener("beforeprint", () => { fit(); if (wide) draw(); });
});
