// Draws the charts of the panel over the time of viser's bar, and says what holds at the moment that the bar shows.
"use strict";
(() => {
const { times, end, charts } = JSON.parse(document.getElementById("loads").textContent);
const WIDTH = 1000, HEIGHT = 100, LARGEST = "#2a6fd6", OTHERS = "#b4bac6", LIMIT = "#14161c";

function add(parent, name, attributes) {
  const node = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  parent.append(node);
  return node;
}

function largest(values) { return values.reduce((best, v, k) => (v > values[best] ? k : best), 0); }

const drawn = charts.map((chart, index) => {
  const place = document.querySelectorAll("#stiction .chart")[index];
  const plot = place.querySelector(".plot"), svg = add(plot, "svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, preserveAspectRatio: "none" });
  const tops = chart.values.map((line) => Math.max(...line)), high = 1.06 * Math.max(100, ...tops);
  const x = (t) => (WIDTH * t) / end, y = (v) => HEIGHT * (1 - v / high);
  const line = (x1, y1, x2, y2, more) => add(svg, "line", { x1, y1, x2, y2, "vector-effect": "non-scaling-stroke", ...more });
  line(0, HEIGHT, WIDTH, HEIGHT, { stroke: OTHERS });
  line(0, y(100), WIDTH, y(100), { stroke: LIMIT, "stroke-dasharray": "5 4" });
  const limit = document.createElement("span");
  limit.textContent = "100 %"; limit.style.top = `${y(100)}%`; plot.append(limit);
  const first = largest(tops);
  const order = chart.values.map((_, k) => k).filter((k) => k !== first).concat(first);  // the one that is named lies on top
  for (const k of order) {
    const points = chart.values[k].map((v, i) => `${x(times[i]).toFixed(1)},${y(v).toFixed(1)}`).concat(`${WIDTH},${y(chart.values[k].at(-1)).toFixed(1)}`);
    const named = k === first, color = named ? LARGEST : OTHERS;
    add(svg, "polyline", { points: points.join(" "), fill: "none", stroke: color, "stroke-width": named ? 1.6 : 0.8, "vector-effect": "non-scaling-stroke" });
  }
  place.querySelector(".largest").textContent = `— ${chart.names[first]}`;
  const cursor = line(0, 0, 0, HEIGHT, { stroke: LIMIT, "stroke-opacity": 0.6 });
  return { chart, cursor, x, now: place.querySelector(".now") };
});

function show(t) {
  let k = times.length - 1;
  while (k > 0 && times[k] > t + 1e-3) k--;
  for (const { chart, cursor, x, now } of drawn) {
    cursor.setAttribute("x1", x(t)); cursor.setAttribute("x2", x(t));
    const values = chart.values.map((line) => line[k]), most = largest(values);
    now.textContent = `${values[most].toFixed(1)} % ${values[most] > 0 ? chart.names[most] : ""}`;
  }
}

let shown = -1;
function follow() {
  const bar = document.querySelector(".mantine-Slider-thumb"), t = bar ? Number(bar.getAttribute("aria-valuenow")) : 0;
  if (t !== shown) show(shown = t);
  requestAnimationFrame(follow);
}
follow();
})();
