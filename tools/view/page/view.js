// The page of `rhoray view`: sends what it wants to see, draws what it is sent.
const $ = (id) => document.getElementById(id);
const canvas = $("picture"), context = canvas.getContext("2d", { alpha: false });
const restMs = 150, headerBytes = 24;

// ---- vectors ----
const add = (a, b) => a.map((x, i) => x + b[i]);
const sub = (a, b) => a.map((x, i) => x - b[i]);
const times = (s, a) => a.map((x) => s * x);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const length = (a) => Math.hypot(...a);
const unit = (a) => times(1 / length(a), a);
/** Turns a vector around an axis of length 1 (Rodrigues). */
function turned(v, axis, angle) {
  const c = Math.cos(angle), s = Math.sin(angle);
  return add(add(times(c, v), times(s, cross(axis, v))), times((1 - c) * dot(axis, v), axis));
}

// ---- what is shown ----
let hello = null, camera = null, surfaces = [];
let wishNumber = 0, isDirty = false, isMoving = false, restTimer = 0, socket = null, retryMs = 250;
let newestDrawn = 0, lastPng = null, hasSize = false;

/** Notes a change; the next animation frame sends it. */
function change(moving = true) {
  isDirty = true;
  isMoving = moving;
  clearTimeout(restTimer);
  if (moving) restTimer = setTimeout(() => change(false), restMs);
}

function sendWish() {
  requestAnimationFrame(sendWish);
  if (!isDirty || !hasSize || !socket || socket.readyState !== WebSocket.OPEN || !camera || document.hidden) return;
  isDirty = false;
  socket.send(JSON.stringify({ n: ++wishNumber, size: [canvas.width, canvas.height], moving: isMoving, camera,
                               isovalues: surfaces.map((s) => [s.layer, s.isovalue]) }));
}

// ---- pictures ----
async function draw(buffer) {
  const view = new DataView(buffer);
  const codec = view.getUint8(1), spacing = view.getUint16(2, true), frame = view.getUint32(4, true);
  const wish = view.getUint32(8, true), width = view.getUint16(12, true), height = view.getUint16(14, true);
  const ms = view.getFloat32(16, true);
  const blob = new Blob([new Uint8Array(buffer, headerBytes)], { type: codec === 2 ? "image/png" : "image/jpeg" });
  try {
    const bitmap = await createImageBitmap(blob, { colorSpaceConversion: "none", premultiplyAlpha: "none" });
    if (wish >= newestDrawn) {  // a newer one may have been decoded before
      newestDrawn = wish;
      lastPng = codec === 2 ? blob : null;
      context.imageSmoothingEnabled = false;
      // A coarse picture has one pixel for each spacing; the last column and row may reach beyond.
      context.drawImage(bitmap, 0, 0, bitmap.width * spacing * canvas.width / width,
                        bitmap.height * spacing * canvas.height / height);
      const fps = pace();
      $("state").textContent = spacing > 1 ? `every ${spacing}th pixel traced` : codec === 2 ? "finished, lossless"
        : isMoving ? "every pixel traced; edges are smoothed at rest" : "finished; sending it without loss";
      $("numbers").textContent = `${width} × ${height}, ${ms.toFixed(1)} ms, ${fps} pictures/s`;
      document.dispatchEvent(new CustomEvent("drawn", { detail: { wish, spacing, isLossless: codec === 2 } }));
    }
    bitmap.close();
  } finally {
    if (socket && socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify({ ack: frame }));
  }
}

const drawnAt = [];
/** Pictures of the last second. */
function pace() {
  const now = performance.now();
  drawnAt.push(now);
  while (now - drawnAt[0] > 1000) drawnAt.shift();
  return drawnAt.length;
}

// ---- connection ----
function token() {
  const given = new URLSearchParams(location.hash.slice(1)).get("token");
  if (given) sessionStorage.setItem("token", given);
  return given ?? sessionStorage.getItem("token") ?? "";
}

function connect() {
  const url = new URL("ws", location.href);
  url.protocol = location.protocol === "https:" ? "wss:" : "ws:";
  url.hash = "";
  socket = new WebSocket(url, ["rhoray.1", token()]);
  socket.binaryType = "arraybuffer";
  socket.onopen = () => { retryMs = 250; newestDrawn = 0; wishNumber = 0; };
  socket.onmessage = (event) => typeof event.data === "string" ? take(JSON.parse(event.data)) : draw(event.data);
  socket.onclose = () => {
    $("state").textContent = `no connection; trying again in ${(retryMs / 1000).toFixed(1)} s`;
    setTimeout(connect, retryMs);
    retryMs = Math.min(8000, 2 * retryMs);
  };
}

function take(message) {
  if (message.error) $("state").textContent = message.error;
  if (message.command !== undefined) {
    $("command-text").textContent = message.command;
    navigator.clipboard?.writeText(message.command).catch(() => {});
  }
  if (!message.hello) return;
  const isFirst = !hello;
  hello = message.hello;
  if (isFirst) {
    camera = structuredClone(hello.camera);
    surfaces = hello.surfaces.map((s) => ({ ...s }));
    document.title = `${hello.title}: Rhoray`;
    $("title").textContent = hello.title;
    makeControls();
  }
  change(false);
}

// ---- camera ----
/** A turntable: left and right around the up direction, up and down around the picture's horizontal. */
function turn(dx, dy) {
  const up = unit(hello.camera.up);
  let back = sub(camera.position, camera.target);
  back = turned(back, up, -dx);
  const right = unit(cross(camera.up, back));
  const steep = turned(back, right, -dy), angle = Math.acos(Math.max(-1, Math.min(1, dot(unit(steep), up))));
  if (angle > 0.02 && angle < Math.PI - 0.02) back = steep;
  camera.position = add(camera.target, back);
  camera.up = up;
  change();
}

/** World units that one pixel of the canvas covers at the target. */
function pixelSize() {
  const distance = length(sub(camera.position, camera.target));
  return (camera.ortho_height ?? 2 * distance * Math.tan(camera.fov * Math.PI / 360)) / canvas.clientHeight;
}

function pan(dx, dy) {
  const back = unit(sub(camera.position, camera.target)), right = unit(cross(camera.up, back)), above = cross(back, right);
  const way = times(pixelSize(), add(times(-dx, right), times(dy, above)));
  camera.position = add(camera.position, way);
  camera.target = add(camera.target, way);
  change();
}

function zoom(factor) {
  if (camera.ortho_height) camera.ortho_height /= factor;
  else camera.position = add(camera.target, times(1 / factor, sub(camera.position, camera.target)));
  change();
}

/** Looks from a direction, at the same distance. */
function look(direction, up) {
  camera.position = add(camera.target, times(length(sub(camera.position, camera.target)), direction));
  camera.up = up;
  change(false);
}

const pointers = new Map();
canvas.addEventListener("pointerdown", (event) => {
  canvas.setPointerCapture(event.pointerId);
  canvas.focus();
  pointers.set(event.pointerId, [event.clientX, event.clientY]);
});
canvas.addEventListener("pointermove", (event) => {
  const before = pointers.get(event.pointerId);
  if (!before || !camera) return;
  const now = [event.clientX, event.clientY], dx = now[0] - before[0], dy = now[1] - before[1];
  if (pointers.size === 2) {
    const other = [...pointers].find(([id]) => id !== event.pointerId)[1];
    zoom(Math.hypot(now[0] - other[0], now[1] - other[1]) /
         Math.max(1, Math.hypot(before[0] - other[0], before[1] - other[1])));
    pan(dx / 2, dy / 2);
  } else if (event.shiftKey || event.buttons & 2 || event.buttons & 4) {
    pan(dx, dy);
  } else {
    turn(dx * Math.PI / canvas.clientHeight, dy * Math.PI / canvas.clientHeight);
  }
  pointers.set(event.pointerId, now);
});
for (const name of ["pointerup", "pointercancel"])
  canvas.addEventListener(name, (event) => pointers.delete(event.pointerId));
canvas.addEventListener("contextmenu", (event) => event.preventDefault());
canvas.addEventListener("wheel", (event) => {
  event.preventDefault();
  const lines = event.deltaMode === 0 ? event.deltaY / 100 : event.deltaMode === 1 ? event.deltaY / 3 : event.deltaY;
  zoom(Math.pow(0.85, lines));
}, { passive: false });

document.addEventListener("keydown", (event) => {
  if (event.target.matches("input, select") || event.ctrlKey || event.metaKey || event.altKey || !camera) return;
  const step = Math.PI / 36;
  const keys = {
    ArrowLeft: () => turn(-step, 0), ArrowRight: () => turn(step, 0), ArrowUp: () => turn(0, -step),
    ArrowDown: () => turn(0, step), "+": () => zoom(1.15), "=": () => zoom(1.15), "-": () => zoom(1 / 1.15),
    r: reset, c: askCommand, s: save, "?": () => $("help").showModal(),
  };
  if (event.target.matches(".histogram") && event.key.startsWith("Arrow")) return;
  const view = views()[Number(event.key) - 1];
  const act = keys[event.key] ?? (view && (() => look(view[1], view[2])));
  if (!act) return;
  event.preventDefault();
  act();
});

function reset() {
  camera = structuredClone(hello.camera);
  change(false);
}
function askCommand() {
  socket?.send(JSON.stringify({ command: true }));
}
function save() {
  if (!lastPng) { $("state").textContent = "the picture is not finished yet"; return; }
  const link = document.createElement("a");
  link.href = URL.createObjectURL(lastPng);
  link.download = `${hello.title}.png`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

/** Names, directions towards the eye, and up directions. */
function views() {
  const up = unit(hello.camera.up);
  const ahead = Math.abs(up[2]) > 0.5 ? [0, 1, 0] : [0, 0, -1];
  const right = cross(ahead, up);
  return [["front", times(-1, ahead), up], ["back", ahead, up], ["left", times(-1, right), up], ["right", right, up],
          ["top", up, ahead], ["bottom", times(-1, up), times(-1, ahead)]];
}

// ---- isovalues ----
function makeControls() {
  for (const surface of surfaces) $("surfaces").append(makeSurface(surface));
  for (const [name, direction, up] of views()) {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = name;
    button.onclick = () => look(direction, up);
    $("views").append(button);
  }
  $("command").onclick = askCommand;
  $("save").onclick = save;
  $("help-button").onclick = () => $("help").showModal();
}

function makeSurface(surface) {
  const box = document.createElement("fieldset"), legend = document.createElement("legend");
  legend.textContent = surface.unit ? `${surface.field} (${surface.unit})` : surface.field;
  const graph = document.createElement("canvas");
  graph.className = "histogram";
  graph.tabIndex = 0;
  graph.setAttribute("role", "slider");
  graph.setAttribute("aria-label", `isovalue of ${surface.field}`);
  const row = document.createElement("div"), swatch = document.createElement("span"), input = document.createElement("input");
  row.className = "row";
  swatch.className = "swatch";
  swatch.style.background = surface.color;
  input.type = "number";
  input.step = "any";
  input.setAttribute("aria-label", `isovalue of ${surface.field}`);
  row.append(swatch, input);
  box.append(legend, graph, row);
  const [low, high] = surface.range;
  const show = () => {
    input.value = Number(surface.isovalue.toPrecision(6));
    graph.setAttribute("aria-valuemin", low);
    graph.setAttribute("aria-valuemax", high);
    graph.setAttribute("aria-valuenow", surface.isovalue);
    drawHistogram(graph, surface);
  };
  const set = (value, moving = true) => {
    surface.isovalue = Math.max(low, Math.min(high, value));
    show();
    change(moving);
  };
  const take = (event) => {
    const area = graph.getBoundingClientRect();
    set(low + (high - low) * (event.clientX - area.left) / area.width);
  };
  graph.onpointerdown = (event) => { graph.setPointerCapture(event.pointerId); take(event); };
  graph.onpointermove = (event) => { if (event.buttons & 1) take(event); };
  graph.onkeydown = (event) => {
    const way = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
    if (!way) return;
    event.preventDefault();
    set(surface.isovalue + way * (high - low) / (event.shiftKey ? 1000 : 100));
  };
  input.onchange = () => { if (Number.isFinite(input.valueAsNumber)) set(input.valueAsNumber, false); };
  new ResizeObserver(show).observe(graph);
  return box;
}

/** Counts on a logarithmic scale, and a line at the isovalue. */
function drawHistogram(graph, surface) {
  const ratio = devicePixelRatio, width = graph.width = Math.round(graph.clientWidth * ratio);
  const height = graph.height = Math.round(graph.clientHeight * ratio);
  const pen = graph.getContext("2d"), style = getComputedStyle(graph), counts = surface.histogram;
  const most = Math.log1p(Math.max(1, ...counts));
  pen.fillStyle = style.color;
  pen.globalAlpha = 0.45;
  counts.forEach((count, i) => {
    const tall = height * Math.log1p(count) / most;
    pen.fillRect(width * i / counts.length, height - tall, width / counts.length, tall);
  });
  pen.globalAlpha = 1;
  const [low, high] = surface.range, x = width * (surface.isovalue - low) / (high - low || 1);
  pen.fillStyle = getComputedStyle(document.documentElement).getPropertyValue("--accent");
  pen.fillRect(x - ratio, 0, 2 * ratio, height);
}

// ---- size ----
new ResizeObserver((entries) => {
  const box = entries[0].devicePixelContentBoxSize?.[0];
  const width = Math.min(4096, Math.max(1, box ? box.inlineSize : Math.round(canvas.clientWidth * devicePixelRatio)));
  const height = Math.min(4096, Math.max(1, box ? box.blockSize : Math.round(canvas.clientHeight * devicePixelRatio)));
  hasSize = true;
  if (width === canvas.width && height === canvas.height) return;
  canvas.width = width;
  canvas.height = height;
  if (hello) { context.fillStyle = hello.background; context.fillRect(0, 0, width, height); }
  change(false);
}).observe(canvas);
document.addEventListener("visibilitychange", () => { if (!document.hidden) change(false); });

requestAnimationFrame(sendWish);
connect();
