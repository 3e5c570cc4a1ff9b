"use strict";
// Draws a scene that moves, arrows, a field on surfaces and plots over time. What `data` holds: canvas.py.
(() => {
const data = JSON.parse(document.getElementById("data").textContent);
const at = (id) => document.getElementById(id);
const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
const f32 = (text) => new Float32Array(bytes(text)), u32 = (text) => new Uint32Array(bytes(text)), u16 = (text) => new Uint16Array(bytes(text));

// ---- small vectors and 4 × 4 matrices, columns first ----
const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const add = (a, b, s = 1) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => { const n = Math.hypot(...a) || 1; return a.map((x) => x / n); };
const columns = (x, y, z, p) => new Float32Array([...x, 0, ...y, 0, ...z, 0, ...p, 1]);
function multiply(a, b) {
  const out = new Float32Array(16);
  for (let c = 0; c < 4; ++c) for (let r = 0; r < 4; ++r) for (let k = 0; k < 4; ++k) out[4 * c + r] += a[4 * k + r] * b[4 * c + k];
  return out;
}
function pose(n, i) {  // x, y, z, qw, qx, qy, qz
  const [px, py, pz, w, x, y, z] = n.subarray(i, i + 7);
  return columns([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
                 [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
                 [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], [px, py, pz]);
}

// ---- colours of a field, from 0 to 1 ----
const COLORS = [[252, 226, 92], [150, 206, 96], [56, 160, 140], [52, 104, 142], [66, 52, 110]];
function color(t) {
  const x = Math.min(Math.max(t, 0), 1) * (COLORS.length - 1), k = Math.min(Math.floor(x), COLORS.length - 2);
  return COLORS[k].map((c, j) => Math.round(c + (x - k) * (COLORS[k + 1][j] - c)));
}

// ---- WebGL ----
const canvas = at("view"), gl = canvas.getContext("webgl2", { alpha: false, antialias: true, preserveDrawingBuffer: true });
if (!gl) { at("meaning").textContent = ""; at("stiction").querySelector("p").textContent = "This browser has no WebGL 2."; throw new Error("no WebGL 2"); }
function shader(type, text) {
  const s = gl.createShader(type);
  gl.shaderSource(s, text); gl.compileShader(s);
  if (!gl.getShaderParameter(s, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(s));
  return s;
}
const program = gl.createProgram();
gl.attachShader(program, shader(gl.VERTEX_SHADER, `#version 300 es
layout(location = 0) in vec3 p; layout(location = 1) in vec3 n; layout(location = 2) in float value;
uniform mat4 X_WB, view, projection; uniform float size;
out vec3 normal, eye; out float v;
void main() {
  vec4 q = view * X_WB * vec4(p, 1.0);
  normal = mat3(view) * mat3(X_WB) * n; eye = -q.xyz; v = value;
  gl_Position = projection * q; gl_PointSize = size;
}`));
gl.attachShader(program, shader(gl.FRAGMENT_SHADER, `#version 300 es
precision highp float;
in vec3 normal, eye; in float v;
uniform vec4 tint; uniform float field; uniform sampler2D lut; uniform float round; uniform float fade;
out vec4 result;
void main() {
  if (round > 0.5 && length(gl_PointCoord - 0.5) > 0.5) discard;
  vec3 n = normalize(normal); if (dot(n, eye) < 0.0) n = -n;
  vec3 base = field > 0.5 ? texture(lut, vec2(clamp(v, 0.0, 1.0), 0.5)).rgb : tint.rgb;
  float light = 0.42 + 0.38 * max(dot(n, normalize(vec3(0.35, 0.7, 0.6))), 0.0) + 0.28 * max(dot(n, normalize(eye)), 0.0);
  float cover = fade < 1.0 ? clamp((1.0 - v) / (1.0 - fade), 0.0, 1.0) : 1.0;
  result = vec4(round > 0.5 ? base * 0.75 : base * light, tint.a * cover);
}`));
gl.linkProgram(program); gl.useProgram(program);
const uniform = Object.fromEntries(["X_WB", "view", "projection", "size", "tint", "field", "lut", "round", "fade"].map((n) => [n, gl.getUniformLocation(program, n)]));
gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, 256, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array([...Array(256).keys()].flatMap((i) => [...color(i / 255), 255])));
for (const [key, value] of [["MIN_FILTER", "LINEAR"], ["MAG_FILTER", "LINEAR"], ["WRAP_S", "CLAMP_TO_EDGE"], ["WRAP_T", "CLAMP_TO_EDGE"]])
  gl.texParameteri(gl.TEXTURE_2D, gl[`TEXTURE_${key}`], gl[value]);

function upload(points, normals, triangles) {
  const vao = gl.createVertexArray();
  gl.bindVertexArray(vao);
  [points, normals].forEach((array, location) => {
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, array, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(location); gl.vertexAttribPointer(location, 3, gl.FLOAT, false, 0, 0);
  });
  const values = gl.createBuffer();
  gl.bindBuffer(gl.ARRAY_BUFFER, values);
  gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(points.length / 3), gl.DYNAMIC_DRAW);
  gl.enableVertexAttribArray(2); gl.vertexAttribPointer(2, 1, gl.FLOAT, false, 0, 0);
  if (triangles) { gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer()); gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, triangles, gl.STATIC_DRAW); }
  return { vao, values, count: triangles ? triangles.length : points.length / 3, vertices: points.length / 3 };
}
function setValues(mesh, values) { gl.bindBuffer(gl.ARRAY_BUFFER, mesh.values); gl.bufferSubData(gl.ARRAY_BUFFER, 0, values); }

function turned(profile) {  // a profile of (radius, z) about z, flat between two points of it
  const p = [], n = [], t = [], around = 24;
  for (let k = 0; k + 1 < profile.length; ++k) {
    const [r0, z0] = profile[k], [r1, z1] = profile[k + 1], length = Math.hypot(r1 - r0, z1 - z0) || 1, first = p.length / 3;
    for (let i = 0; i <= around; ++i) {
      const a = (2 * Math.PI * i) / around, c = Math.cos(a), s = Math.sin(a);
      p.push(r0 * c, r0 * s, z0, r1 * c, r1 * s, z1);
      const m = [(c * (z1 - z0)) / length, (s * (z1 - z0)) / length, (r0 - r1) / length];
      n.push(...m, ...m);
      if (i < around) { const b = first + 2 * i; t.push(b, b + 2, b + 3, b, b + 3, b + 1); }
    }
  }
  return upload(new Float32Array(p), new Float32Array(n), new Uint32Array(t));
}
const shaft = turned([[0, 0], [1, 0], [1, 1]]), head = turned([[0, 0], [1, 0], [0, 1]]);
const ball = turned([...Array(13).keys()].map((i) => [Math.cos((i / 12 - 0.5) * Math.PI), Math.sin((i / 12 - 0.5) * Math.PI)]));

function normalsOf(p, triangles) {  // means over the triangles at a point, by area
  const out = new Float32Array(p.length), at = (i) => [p[3 * i], p[3 * i + 1], p[3 * i + 2]];
  for (let k = 0; k < triangles.length; k += 3) {
    const a = at(triangles[k]), n = cross(sub(at(triangles[k + 1]), a), sub(at(triangles[k + 2]), a));
    for (let c = k; c < k + 3; ++c) for (let j = 0; j < 3; ++j) out[3 * triangles[c] + j] += n[j];
  }
  return out;
}
function uploadMesh(m) {
  const p = f32(m.points), triangles = u32(m.triangles);
  return upload(p, m.normals ? f32(m.normals) : normalsOf(p, triangles), triangles);
}
const meshes = data.meshes.map((m) => ({ ...m, ...uploadMesh(m),
  near: m.near && u16(m.near), weight: m.weight && new Uint8Array(bytes(m.weight)) }));
const dots = (data.samples || []).map((s) => ({ ...s, ...upload(f32(s.points), f32(s.normals), null) }));
const dressed = meshes.some((m) => m.as === "seen");
const poses = f32(data.poses), bodies = data.bodies, frames = data.times.length;

// ---- state ----
let frame = 0, chosen = 0, showDots = false, playing = false, seen = dressed;  // seen: bodies as their files show them, else what touches
const camera = { look: data.view.look_at, radius: data.view.radius, distance: 0, azimuth: data.view.azimuth, elevation: data.view.elevation, set: false };
const FOV = 0.6;

function field() { return data.fields && data.fields[chosen]; }
function fadesFrom() { return field().fades_from || 0; }  // the value from which a field fades to what is seen, at 1
function valuesOf(link) {
  const f = field(), of = f.values[f.values.length > 1 ? frame : 0];
  return of && u16(of[link]);
}
function showField() {
  if (!field()) return;
  for (const mesh of meshes) {
    if (mesh.link === undefined) continue;
    const samples = valuesOf(mesh.link), out = new Float32Array(mesh.vertices), k = mesh.near.length / mesh.vertices;
    for (let i = 0; i < out.length; ++i) {
      let sum = 0, total = 0;
      for (let j = k * i; j < k * (i + 1); ++j) { sum += mesh.weight[j] * samples[mesh.near[j]]; total += mesh.weight[j]; }
      out[i] = sum / total / 65535;
    }
    setValues(mesh, out);
  }
  for (const d of dots) setValues(d, Float32Array.from(valuesOf(d.link), (x) => x / 65535));
}

// ---- the picture ----
function bases() {
  const { azimuth: a, elevation: e } = camera, back = [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)];
  const right = unit(cross([0, 0, 1], back));
  return { back, right, up: cross(back, right) };
}
function matrices() {
  const w = canvas.width, h = canvas.height, aspect = w / h, f = 1 / Math.tan(FOV / 2);
  if (!camera.set) { camera.distance = (1.02 * camera.radius) / Math.sin(FOV / 2) / Math.min(1, aspect); camera.set = true; }
  const { back, right, up } = bases(), eye = add(camera.look, back, camera.distance);
  const view = new Float32Array([right[0], up[0], back[0], 0, right[1], up[1], back[1], 0, right[2], up[2], back[2], 0, -dot(right, eye), -dot(up, eye), -dot(back, eye), 1]);
  const near = 0.02 * camera.distance, far = 10 * camera.distance + 4 * camera.radius;
  const projection = new Float32Array([f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, (2 * far * near) / (near - far), 0]);
  return { view, projection };
}
function paint(mesh, X, tint, alpha, withField = false, mode = gl.TRIANGLES, fade = 1) {
  gl.bindVertexArray(mesh.vao);
  gl.uniformMatrix4fv(uniform.X_WB, false, X);
  gl.uniform4f(uniform.tint, tint[0] / 255, tint[1] / 255, tint[2] / 255, alpha);
  gl.uniform1f(uniform.field, withField ? 1 : 0);
  gl.uniform1f(uniform.fade, fade);
  gl.uniform1f(uniform.round, mode === gl.POINTS ? 1 : 0);
  if (mode === gl.POINTS) gl.drawArrays(mode, 0, mesh.count);
  else gl.drawElements(mode, mesh.count, gl.UNSIGNED_INT, 0);
}
function ends(arrow) {  // it ends where the force acts and comes from the side that pushes
  const newtons = Math.hypot(...arrow.force), length = Math.min(newtons * data.arrow.scale, data.arrow.longest);
  return { head: arrow.point, direction: unit(arrow.force), length: Math.max(length, 0.2 * data.arrow.longest) };
}
function paintArrow(arrow, alpha) {
  const { head: tip, direction: z, length } = ends(arrow), wide = (arrow.wide || 1) * data.arrow.longest;
  const x = unit(cross(Math.abs(z[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0], z)), y = cross(z, x), tall = Math.min(0.28 * data.arrow.longest, 0.6 * length);
  const scaled = (r, l, p) => columns(x.map((c) => c * r), y.map((c) => c * r), z.map((c) => c * l), p);
  paint(shaft, scaled(0.035 * wide, length - tall, add(tip, z, -length)), arrow.color, alpha);
  paint(head, scaled(0.085 * wide, tall, add(tip, z, -tall)), arrow.color, alpha);
  const r = 0.045 * data.arrow.longest;
  if (arrow.ball) paint(ball, columns([r, 0, 0], [0, r, 0], [0, 0, r], tip), arrow.color, alpha);
}
function draw() {
  const ratio = window.devicePixelRatio || 1, w = Math.round(canvas.clientWidth * ratio), h = Math.round(canvas.clientHeight * ratio);
  if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
  if (w === 0 || h === 0) return;
  gl.viewport(0, 0, w, h);
  gl.clearColor(0.965, 0.969, 0.976, 1); gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl.enable(gl.DEPTH_TEST); gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
  const { view, projection } = matrices(), arrows = data.arrows[frame];
  gl.uniformMatrix4fv(uniform.view, false, view); gl.uniformMatrix4fv(uniform.projection, false, projection);
  gl.uniform1f(uniform.size, 5 * ratio);
  const where = (body) => pose(poses, 7 * (frame * bodies + body));
  const shown = meshes.filter((m) => (!m.frames || (m.frames[0] <= frame && frame < m.frames[1])) && (!m.as || (m.as === "seen") === seen));
  const opaque = (some) => { for (const m of some) if (m.alpha === 1) paint(m, where(m.body), m.color, 1, m.link !== undefined); };
  const translucent = (some) => {
    gl.enable(gl.BLEND); gl.depthMask(false);
    for (const m of some) if (m.alpha < 1) paint(m, where(m.body), m.color, m.alpha);
    gl.depthMask(true); gl.disable(gl.BLEND);
  };
  const marks = seen ? shown.filter((m) => m.mark) : shown;  // with what touches all is drawn at once
  if (seen) { const rest = shown.filter((m) => !m.mark); opaque(rest); translucent(rest); turnToWhatTouches(where); }
  opaque(marks);
  if (showDots) for (const d of dots) paint(d, where(d.body), [0, 0, 0], 1, true, gl.POINTS);
  for (const a of arrows) paintArrow(a, 1);
  translucent(marks);
  gl.enable(gl.BLEND); gl.depthMask(false);
  gl.disable(gl.DEPTH_TEST);
  for (const a of arrows) paintArrow(a, a.front ? 1 : 0.25);  // what is behind the robot shows through
  gl.enable(gl.DEPTH_TEST); gl.depthMask(true); gl.disable(gl.BLEND);
  placeLabels(arrows, multiply(projection, view));
}
// Marks lie on what touches: over bodies as they are seen, and hidden by nothing but what touches. A field there fades to what is seen where it says nothing.
function turnToWhatTouches(where) {
  gl.clear(gl.DEPTH_BUFFER_BIT);
  gl.colorMask(false, false, false, false);
  for (const m of meshes) if (m.as === "touches" || (!m.as && !m.mark && m.alpha === 1)) paint(m, where(m.body), m.color, 1);
  gl.colorMask(true, true, true, true);
  gl.enable(gl.BLEND); gl.depthMask(false); gl.depthFunc(gl.LEQUAL);
  for (const m of meshes) if (m.as === "touches" && m.link !== undefined) paint(m, where(m.body), m.color, 1, true, gl.TRIANGLES, fadesFrom());
  gl.depthFunc(gl.LESS); gl.depthMask(true); gl.disable(gl.BLEND);
}
function placeLabels(arrows, M) {
  const labels = [...document.querySelectorAll(".label")], taken = [];
  arrows.forEach((arrow, i) => {
    const { head: tip, direction, length } = ends(arrow), p = add(tip, direction, -1.05 * length);
    const clip = [0, 1, 3].map((r) => M[r] * p[0] + M[4 + r] * p[1] + M[8 + r] * p[2] + M[12 + r]);
    if (!labels[i]) { const d = document.createElement("div"); d.className = "label"; at("stage").append(d); labels.push(d); }
    const label = labels[i];
    label.hidden = !arrow.label || clip[2] <= 0;
    if (label.hidden) return;
    label.textContent = arrow.label; label.style.color = `rgb(${arrow.color})`;
    const x = ((clip[0] / clip[2] + 1) / 2) * canvas.clientWidth;
    let y = ((1 - clip[1] / clip[2]) / 2) * canvas.clientHeight;
    for (let again = true; again;) {  // below those that are there already
      const hit = taken.find(([u, v]) => Math.abs(u - x) < 40 && Math.abs(v - y) < 18);
      again = hit !== undefined;
      if (again) y = hit[1] + 19;
    }
    taken.push([x, y]);
    label.style.left = `${x}px`; label.style.top = `${y}px`;
  });
  labels.slice(arrows.length).forEach((l) => { l.hidden = true; });
}

// ---- plots ----
const plotTimes = data.plot_times && f32(data.plot_times);
const plots = (data.plots || []).map((p) => ({ ...p, lines: p.lines.map((l) => ({ ...l, values: f32(l.values) })), canvas: document.createElement("canvas") }));
const MARGIN = { left: 46, right: 10, top: 38, bottom: 20 };
function niceStep(span, count) {
  const raw = span / count, ten = 10 ** Math.floor(Math.log10(raw));
  return ten * ([1, 2, 5].find((m) => m * ten >= raw) || 10);
}
function drawPlot(plot) {
  const c = plot.canvas, ratio = window.devicePixelRatio || 1, W = c.clientWidth, H = c.clientHeight;
  if (W === 0) return;
  c.width = W * ratio; c.height = H * ratio;
  const g = c.getContext("2d");
  g.scale(ratio, ratio); g.clearRect(0, 0, W, H); g.font = '11px system-ui, "DejaVu Sans", sans-serif';
  const t1 = plotTimes[plotTimes.length - 1], t0 = plotTimes[0], high = plot.high * 1.08, low = plot.low * 1.08;
  const x = (t) => MARGIN.left + ((t - t0) / (t1 - t0 || 1)) * (W - MARGIN.left - MARGIN.right), y = (v) => H - MARGIN.bottom - ((v - low) / (high - low || 1)) * (H - MARGIN.top - MARGIN.bottom);
  g.strokeStyle = "#e6e8ec"; g.fillStyle = "#767c88"; g.lineWidth = 1;
  const dy = niceStep(high - low || 1, 4), dt = niceStep(t1 - t0 || 1, 5);
  g.textAlign = "right"; g.textBaseline = "middle";
  for (let v = Math.ceil(low / dy) * dy; v <= high; v += dy) { g.beginPath(); g.moveTo(MARGIN.left, y(v)); g.lineTo(W - MARGIN.right, y(v)); g.stroke(); g.fillText(String(+v.toPrecision(3)), MARGIN.left - 4, y(v)); }
  g.textAlign = "center"; g.textBaseline = "top";
  for (let t = Math.ceil(t0 / dt) * dt; t <= t1; t += dt) g.fillText(`${+t.toPrecision(3)} s`, x(t), H - MARGIN.bottom + 4);
  g.textAlign = "left"; g.textBaseline = "top"; g.fillStyle = "#23262d"; g.fillText(`${plot.title} [${plot.unit}]`, MARGIN.left, 5);
  let legend = MARGIN.left;
  for (const line of plot.lines) {
    g.strokeStyle = g.fillStyle = `rgb(${line.color})`; g.lineWidth = 1.3; g.setLineDash(line.dash ? [5, 4] : []);
    g.beginPath();
    line.values.forEach((v, i) => { const u = x(plotTimes[i]), w = y(v); if (i === 0) g.moveTo(u, w); else g.lineTo(u, w); });
    g.stroke();
    if (legend + g.measureText(line.name).width < W) { g.fillText(line.name, legend, 20); legend += g.measureText(line.name).width + 10; }
  }
  g.setLineDash([]); g.strokeStyle = "rgba(20, 22, 28, 0.6)"; g.lineWidth = 1;
  g.beginPath(); g.moveTo(x(data.times[frame]), MARGIN.top - 4); g.lineTo(x(data.times[frame]), H - MARGIN.bottom); g.stroke();
}
function nearestFrame(t) {
  let low = 0, high = frames - 1;
  while (high - low > 1) { const middle = (low + high) >> 1; if (data.times[middle] <= t) low = middle; else high = middle; }
  return t - data.times[low] < data.times[high] - t ? low : high;
}
for (const plot of plots) {
  at("plots").append(plot.canvas);
  const seek = (e) => {
    if (!(e.buttons & 1)) return;
    const t0 = plotTimes[0], t1 = plotTimes[plotTimes.length - 1], share = (e.offsetX - MARGIN.left) / (plot.canvas.clientWidth - MARGIN.left - MARGIN.right);
    stop(); show(nearestFrame(t0 + share * (t1 - t0)));
  };
  plot.canvas.addEventListener("pointerdown", seek); plot.canvas.addEventListener("pointermove", seek);
}
at("plots").hidden = plots.length === 0;

// ---- what is said ----
function cell(row, text) { const td = document.createElement("td"); td.textContent = text; row.append(td); }
function say() {
  const table = at("stiction").querySelector("table");
  table.replaceChildren(...[...data.rows, ...(data.frame_rows ? data.frame_rows[frame] : [])].map((words) => {
    const row = document.createElement("tr");
    words.forEach((w) => cell(row, w));
    return row;
  }));
  at("clock").textContent = `${data.times[frame].toFixed(2)} s`;
  at("slider").value = frame;
}
at("stiction").querySelector("h1").textContent = data.title;
at("stiction").querySelector("p").textContent = data.description;
for (const [tint, text] of data.keys) {
  const span = document.createElement("span"), i = document.createElement("i");
  i.style.background = `rgb(${tint})`; span.append(i, text); at("keys").append(span);
}
if (data.fields) {
  at("scale").hidden = false;
  data.fields.forEach((f, k) => {
    const label = document.createElement("label"), input = document.createElement("input");
    input.type = "radio"; input.name = "field"; input.checked = k === 0; input.value = k;
    input.addEventListener("change", () => { chosen = k; choose(); });
    label.append(input, f.name); at("choice").append(label);
  });
  const label = document.createElement("label"), input = document.createElement("input");
  input.type = "checkbox"; input.id = "dots"; input.addEventListener("change", () => { showDots = input.checked; draw(); });
  label.append(input, "samples"); at("choice").append(label);
}
if (dressed) {
  const button = at("stiction").querySelector("button"), name = () => { button.textContent = seen ? "Show what touches" : "Show what is seen"; };
  button.hidden = false; name();
  button.addEventListener("click", () => { seen = !seen; name(); choose(); });
}
function choose() {
  const f = field();
  if (f) {
    const stops = [...Array(41).keys()].map((i) => `rgba(${color(i / 40)}, ${seen ? Math.min(1, (1 - i / 40) / (1 - fadesFrom())) : 1})`);
    at("bar").style.background = `linear-gradient(to right, ${stops.join(", ")})`;
    at("low").textContent = f.low; at("high").textContent = f.high; at("meaning").textContent = f.meaning;
  }
  showField(); draw();
}

// ---- time ----
function show(k) { frame = Math.min(Math.max(k, 0), frames - 1); say(); showField(); draw(); plots.forEach(drawPlot); }
function stop() { playing = false; at("play").textContent = "▶"; }
at("time").hidden = frames < 2;
at("slider").max = frames - 1;
at("slider").addEventListener("input", () => { stop(); show(Number(at("slider").value)); });
at("play").addEventListener("click", () => {
  if (playing) { stop(); return; }
  playing = true; at("play").textContent = "❚❚";
  if (frame === frames - 1) show(0);
  const begin = performance.now() - 1e3 * data.times[frame];
  const tick = (now) => {
    if (!playing) return;
    const t = (now - begin) / 1e3;
    if (t >= data.times[frames - 1]) { show(frames - 1); stop(); return; }
    const next = nearestFrame(t);
    if (next !== frame) show(next);
    requestAnimationFrame(tick);
  };
  requestAnimationFrame(tick);
});

// ---- camera: drag turns, right or shift drag moves, wheel comes nearer ----
canvas.addEventListener("contextmenu", (e) => e.preventDefault());
canvas.addEventListener("pointerdown", (e) => canvas.setPointerCapture(e.pointerId));
canvas.addEventListener("pointermove", (e) => {
  if (e.buttons === 0) return;
  if (e.shiftKey || e.buttons & 2) {
    const { right, up } = bases(), metres = (2 * camera.distance * Math.tan(FOV / 2)) / canvas.clientHeight;
    camera.look = add(add(camera.look, right, -e.movementX * metres), up, e.movementY * metres);
  } else {
    camera.azimuth -= 0.008 * e.movementX;
    camera.elevation = Math.min(Math.max(camera.elevation + 0.008 * e.movementY, -1.5), 1.5);
  }
  draw();
});
canvas.addEventListener("wheel", (e) => { e.preventDefault(); camera.distance *= Math.exp(0.001 * e.deltaY); draw(); }, { passive: false });
new ResizeObserver(() => { draw(); plots.forEach(drawPlot); }).observe(document.body);

show(0); choose();
document.body.dataset.drawn = "1";
})();
