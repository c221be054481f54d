// Sliders make coordinates, the map makes coefficients of them, and the mesh follows.
"use strict";

const at = (id) => document.getElementById(id);
const { dimensions, modes, width } = data.map;
const [coordinates, linear, dual] = ["coordinates", "linear", "dual"].map((name) => decode(data.map[name], Float32Array));
const count = coordinates.length / dimensions;
const mesh = new MovingMesh(data.moving);
const bytes = new Uint8Array(mesh.mean.length / 3);
const own = (i) => (i < 0 ? new Float32Array(dimensions) : coordinates.subarray(i * dimensions, (i + 1) * dimensions));

// f(c) = c·linear + Σ exp(−‖c − c_i‖² / 2 width²) dual_i.
function coefficients(c) {
  const found = new Float64Array(modes);
  for (let d = 0; d < dimensions; d++) for (let j = 0; j < modes; j++) found[j] += c[d] * linear[d * modes + j];
  for (let i = 0; i < count; i++) {
    let square = 0;
    for (let d = 0; d < dimensions; d++) square += (c[d] - coordinates[i * dimensions + d]) ** 2;
    const k = Math.exp(-square / (2 * width * width));
    if (k > 1e-9) for (let j = 0; j < modes; j++) found[j] += k * dual[i * modes + j];
  }
  return found;
}

// Of each component: its deviation, and the ends of its slider in them.
const scales = Array.from({ length: data.sliders }, (_, d) => {
  let square = 0, most = 0;
  for (let i = 0; i < count; i++) {
    const x = coordinates[i * dimensions + d];
    square += (x * x) / count;
    most = Math.max(most, Math.abs(x));
  }
  const deviation = Math.sqrt(square) || 1;
  return { deviation, end: Math.ceil((10 * most) / deviation) / 10 };
});

const sliders = scales.map(({ end }, d) => {
  const row = document.createElement("div"), label = document.createElement("label"), input = document.createElement("input");
  Object.assign(input, { type: "range", id: `component-${d + 1}`, min: -end, max: end, step: end / 100, value: 0 });
  label.htmlFor = input.id;
  label.textContent = `${d + 1}`;
  row.className = "row";
  row.append(label, input, document.createElement("output"));
  at("sliders").append(row);
  return input;
});

const panels = {
  components() {
    const c = own(from()).slice();
    sliders.forEach((slider, d) => { if (slider.moved) c[d] = slider.value * scales[d].deviation; });
    return [c, sliders.some((slider) => slider.moved) ? `from ${title(from())}` : title(from())];
  },
  between() {
    const [p, q, r] = ["p", "q", "r"].map((id) => own(at(id).selectedIndex)), u = +at("u").value, w = +at("w").value;
    const c = p.map((x, d) => (1 - w) * ((1 - u) * x + u * q[d]) + w * r[d]);
    return [c, "between"];
  },
  analogy() {
    const [a, b, c] = ["a", "b", "c"].map((id) => own(at(id).selectedIndex)), t = +at("t").value;
    return [c.map((x, d) => x + t * (b[d] - a[d])), `${t ? "as B to A, so to " : ""}${title(at("c").selectedIndex)}`];
  },
};
const title = (i) => (i < 0 ? "the mean" : data.names[i]);
const from = () => at("from").selectedIndex - 1;
let open = "components", waiting = false;

function show() {
  waiting = false;
  const [c, name] = panels[open]();
  for (const input of document.querySelectorAll("input[type=range]")) {
    input.nextElementSibling.value = (Math.round(100 * input.value) / 100 || 0).toFixed(2); // and no -0
  }
  document.querySelector("#names span").textContent = name;
  if (!viewer) return;
  viewer.move(0, mesh.at(coefficients(c)), mesh.bytes(mesh.mean, data.far, bytes));
}

// However many events there are, a frame is made once.
function soon() {
  if (waiting) return;
  waiting = true;
  requestAnimationFrame(show);
}

function back() {
  const c = own(from());
  sliders.forEach((slider, d) => { slider.moved = false; slider.value = c[d] / scales[d].deviation; });
  soon();
}

function choose(name) {
  open = name;
  for (const panel of Object.keys(panels)) {
    at(panel).hidden = panel !== name;
    at(`tab-${panel}`).setAttribute("aria-selected", panel === name);
    at(`tab-${panel}`).tabIndex = panel === name ? 0 : -1;
  }
  soon();
}

for (const name of data.names) for (const id of ["from", "p", "q", "r", "a", "b", "c"]) at(id).append(new Option(name));
at("from").prepend(new Option("the mean"));
at("from").selectedIndex = 0;
[["p", 0], ["q", 1], ["r", 2], ["a", 0], ["b", 1], ["c", 2]].forEach(([id, i]) => { at(id).selectedIndex = Math.min(i, count - 1); });
at("panel").addEventListener("input", (event) => {
  if (sliders.includes(event.target)) event.target.moved = true;
  if (event.target.id === "from") back();
  soon();
});
at("back-to").addEventListener("click", back);
const tabs = Object.keys(panels);
for (const name of tabs) {
  at(`tab-${name}`).addEventListener("click", () => choose(name));
  at(`tab-${name}`).addEventListener("keydown", (event) => {
    const step = { ArrowRight: 1, ArrowLeft: tabs.length - 1 }[event.key];
    if (!step) return;
    const next = tabs[(tabs.indexOf(name) + step) % tabs.length];
    choose(next);
    at(`tab-${next}`).focus();
  });
}
choose("components");
