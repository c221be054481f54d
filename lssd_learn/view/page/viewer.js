// The shapes of the page in one canvas, each in a cell of its own, turned together. Plain WebGL 2, no library.
"use strict";

const data = JSON.parse(document.getElementById("data").textContent);

// Arrays travel as base64 of their little-endian bytes, as all machines with WebGL keep them.
function decode(text, Type) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Type(bytes.buffer);
}

// Coordinates in 16 bits between their ends.
function unpack({ low, scale, codes }) {
  return Float32Array.from(decode(codes, Uint16Array), (code) => low + scale * code);
}

// At each vertex the sum of the normals of its triangles, whose lengths weigh them by area; the shader makes them unit.
function vertexNormals(points, faces, normals = new Float32Array(points.length)) {
  normals.fill(0);
  for (let f = 0; f < faces.length; f += 3) {
    const a = 3 * faces[f], b = 3 * faces[f + 1], c = 3 * faces[f + 2];
    const ux = points[b] - points[a], uy = points[b + 1] - points[a + 1], uz = points[b + 2] - points[a + 2];
    const vx = points[c] - points[a], vy = points[c + 1] - points[a + 1], vz = points[c + 2] - points[a + 2];
    const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    normals[a] += x; normals[a + 1] += y; normals[a + 2] += z;
    normals[b] += x; normals[b + 1] += y; normals[b + 2] += z;
    normals[c] += x; normals[c + 1] += y; normals[c + 2] += z;
  }
  return normals;
}

const VERTEX = `#version 300 es
uniform mat3 turn; uniform vec2 scale, shift; uniform float depth, size;
in vec3 point, normal; in float value;
out vec3 direction; out float place;
void main() {
  vec3 seen = turn * point;
  gl_Position = vec4(seen.xy * scale + shift, -seen.z * depth, 1.0);
  gl_PointSize = size;
  direction = turn * normal;
  place = value;
}`;

// The light of the painter that makes the pictures: soft, over the left shoulder, darker towards the outline.
const FRAGMENT = `#version 300 es
precision highp float;
uniform sampler2D colours; uniform bool cloud; uniform vec3 light;
in vec3 direction; in float place; out vec4 colour;
void main() {
  vec3 n = normalize(direction) * (gl_FrontFacing ? 1.0 : -1.0);
  if (cloud) {
    vec2 at = 2.0 * gl_PointCoord - 1.0;
    if (dot(at, at) > 1.0) discard;
    n = vec3(at.x, -at.y, sqrt(1.0 - dot(at, at)));
  }
  float shade = (0.35 + 0.75 * pow(0.5 + 0.5 * dot(n, light), 1.5)) * (0.8 + 0.2 * max(n.z, 0.0));
  colour = vec4(texture(colours, vec2((place * 255.0 + 0.5) / 256.0, 0.5)).rgb * shade, 1.0);
}`;

// 3 × 3 matrices by rows.
const times = (a, b) => a.map((_, i) => [0, 1, 2].reduce((s, k) => s + a[i - (i % 3) + k] * b[3 * k + (i % 3)], 0));
const aboutX = (t) => [1, 0, 0, 0, Math.cos(t), -Math.sin(t), 0, Math.sin(t), Math.cos(t)];
const aboutY = (t) => [Math.cos(t), 0, Math.sin(t), 0, 1, 0, -Math.sin(t), 0, Math.cos(t)];
const seenFrom = (degrees) => times(aboutX(0.12), aboutY((-degrees * Math.PI) / 180));

function start(canvas, gl) {
  const program = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  gl.useProgram(program);
  const uniform = (name) => gl.getUniformLocation(program, name);
  const attribute = (name) => gl.getAttribLocation(program, name);

  function fill(target, made, content) {
    gl.bindBuffer(target, made);
    gl.bufferData(target, content, gl.DYNAMIC_DRAW);
    return made;
  }
  const buffer = (target, content) => fill(target, gl.createBuffer(), content);

  const shapes = data.shapes.map((shape) => {
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    const points = decode(shape.points, Float32Array);
    const faces = shape.faces === null ? null : decode(shape.faces, Uint32Array);
    const placed = {}, normals = vertexNormals(points, faces || []);
    for (const [name, content] of [["point", points], ["normal", normals]]) {
      placed[name] = buffer(gl.ARRAY_BUFFER, content);
      gl.enableVertexAttribArray(attribute(name));
      gl.vertexAttribPointer(attribute(name), 3, gl.FLOAT, false, 0, 0);
    }
    if (faces) buffer(gl.ELEMENT_ARRAY_BUFFER, faces);
    const values = shape.values.map((text) => buffer(gl.ARRAY_BUFFER, decode(text, Uint8Array)));
    const ways = shape.ways.map((way) => ({ middle: unpack(way.middle), step: unpack(way.step) }));
    return { array, values, placed, faces, normals, ways, vertices: points.length / 3, corners: faces ? faces.length : 0 };
  });

  // Other places for the vertices of shape i, and other values of its first field, a byte a vertex.
  function move(i, points, values) {
    const { placed, faces, normals, values: fields } = shapes[i];
    gl.bindVertexArray(null);
    fill(gl.ARRAY_BUFFER, placed.point, points);
    if (faces) fill(gl.ARRAY_BUFFER, placed.normal, vertexNormals(points, faces, normals));
    if (values) fill(gl.ARRAY_BUFFER, fields[0], values);
    draw();
  }

  // The first shape at a place along one of its ways.
  function moveAlong(number, s) {
    const { middle, step } = shapes[0].ways[number];
    move(0, middle.map((value, i) => value + s * step[i]));
  }

  gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
  gl.enable(gl.DEPTH_TEST);
  gl.enable(gl.SCISSOR_TEST);
  gl.clearColor(1, 1, 1, 1);
  gl.uniform3fv(uniform("light"), data.light);

  const view = { turn: seenFrom(data.azimuth), zoom: 1, shift: [0, 0] };
  const field = document.getElementById("field"), svg = document.getElementById("marks");
  let waiting = false, around = null;

  const before = kept(13);
  if (before) {
    Object.assign(view, { turn: before.slice(0, 9), zoom: before[9], shift: before.slice(10, 12) });
    field.selectedIndex = Math.min(Math.max(0, before[12]), data.fields.length - 1);
  }
  const keepView = () => keep([...view.turn, view.zoom, ...view.shift, field.selectedIndex]);
  for (const event of ["pointerup", "keyup", "click", "change", "wheel"]) {
    canvas.parentElement.parentElement.addEventListener(event, () => setTimeout(keepView));
  }

  function choose() {
    const chosen = data.fields[field.selectedIndex];
    const colours = decode(data.colormaps[chosen.colormap], Uint8Array);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, 256, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, colours);
    const pixels = new Uint8ClampedArray(1024).map((_, i) => (i % 4 < 3 ? colours[3 * (i >> 2) + (i % 4)] : 255));
    document.getElementById("colours").getContext("2d").putImageData(new ImageData(pixels, 256, 1), 0, 0);
    document.getElementById("low").textContent = chosen.low;
    document.getElementById("high").textContent = chosen.high;
    draw();
  }

  // Columns and the size of a cell: as large as the shapes can be in some 600 pixels of height, or what is in sight.
  function layout() {
    const width = canvas.clientWidth, count = shapes.length;
    const sight = window.innerHeight - canvas.getBoundingClientRect().top - window.scrollY - 16;
    const high = data.fit ? Math.max(300, Math.min(600, sight)) : 600;
    let best = null;
    for (let columns = 1; columns <= count; columns++) {
      const rows = Math.ceil(count / columns);
      const cell = [width / columns, Math.min(high / rows, (1.15 * data.extent[1] * width) / (columns * data.extent[0]) + 44)];
      const scale = Math.min(cell[0] / data.extent[0], (cell[1] - 44) / data.extent[1]);
      if (!best || scale > best.scale) best = { columns, rows, cell, scale };
    }
    return best;
  }

  function draw() {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => {
      waiting = false;
      render(window.devicePixelRatio || 1);
    });
  }

  function render(ratio) {
    const { columns, rows, cell, scale } = layout();
    const height = rows * cell[1];
    canvas.style.height = `${height}px`;
    canvas.width = Math.round(canvas.clientWidth * ratio);
    canvas.height = Math.round(height * ratio);
    gl.scissor(0, 0, canvas.width, canvas.height);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const pixels = 0.92 * scale * view.zoom;
    gl.uniformMatrix3fv(uniform("turn"), true, view.turn);
    gl.uniform2f(uniform("scale"), (2 * pixels) / cell[0], (2 * pixels) / cell[1]);
    gl.uniform2f(uniform("shift"), (2 * view.shift[0]) / cell[0], (2 * (view.shift[1] + 18)) / cell[1]);
    gl.uniform1f(uniform("depth"), 0.9 / data.radius);
    gl.uniform1f(uniform("size"), Math.max(2, 0.016 * data.extent[1] * pixels * ratio));
    shapes.forEach((shape, i) => {
      const x = (i % columns) * cell[0] * ratio, y = (rows - 1 - Math.floor(i / columns)) * cell[1] * ratio;
      gl.viewport(x, y, cell[0] * ratio, cell[1] * ratio);
      gl.scissor(x, y, cell[0] * ratio, cell[1] * ratio);
      gl.bindVertexArray(shape.array);
      gl.bindBuffer(gl.ARRAY_BUFFER, shape.values[field.selectedIndex]);
      gl.enableVertexAttribArray(attribute("value"));
      gl.vertexAttribPointer(attribute("value"), 1, gl.UNSIGNED_BYTE, true, 0, 0);
      gl.uniform1i(uniform("cloud"), shape.corners ? 0 : 1);
      if (shape.corners) gl.drawElements(gl.TRIANGLES, shape.corners, gl.UNSIGNED_INT, 0);
      else gl.drawArrays(gl.POINTS, 0, shape.vertices);
    });
    over(svg, (around = marks(view, pixels, canvas.clientWidth)));
    [...document.getElementById("names").children].forEach((name, i) => {
      name.style.left = `${(i % columns) * cell[0]}px`;
      name.style.width = `${cell[0]}px`;
      name.style.bottom = `${(rows - 1 - Math.floor(i / columns)) * cell[1]}px`;
    });
  }

  // About the shapes' own vertical where it is known; about the axes of the screen where it is not.
  function rotate(dx, dy) {
    const tilted = times(aboutX(dy), view.turn);
    view.turn = data.upright ? times(tilted, aboutY(dx)) : times(aboutX(dy), times(aboutY(dx), view.turn));
    draw();
  }

  function zoom(factor) {
    view.zoom = Math.min(20, Math.max(0.3, view.zoom * factor));
    draw();
  }

  // A finger scrolls the page up and down (touch-action in the style) and turns the shapes sideways; two take the canvas.
  const pointers = new Map();
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
  });
  for (const end of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(end, (event) => pointers.delete(event.pointerId));
  }
  canvas.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const now = [event.clientX, event.clientY];
    const [dx, dy] = [now[0] - before[0], now[1] - before[1]];
    if (event.shiftKey) view.shift = [view.shift[0] + dx, view.shift[1] - dy];
    else rotate((0.01 * dx) / pointers.size, (0.01 * dy) / pointers.size);
    if (pointers.size === 2) {
      const [, other] = [...pointers].find(([id]) => id !== event.pointerId);
      const apart = (point) => Math.hypot(point[0] - other[0], point[1] - other[1]) || 1;
      zoom(apart(now) / apart(before));
    }
    pointers.set(event.pointerId, now);
    draw();
  });
  canvas.addEventListener("touchmove", (event) => {
    if (event.touches.length > 1 && event.cancelable) event.preventDefault();
  }, { passive: false });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoom(Math.exp(-0.0015 * event.deltaY));
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: [-0.15, 0], ArrowRight: [0.15, 0], ArrowUp: [0, -0.15], ArrowDown: [0, 0.15] }[event.key];
    if (!step) return;
    event.preventDefault();
    rotate(...step);
  });
  const turnTo = (degrees) => () => { view.turn = seenFrom(degrees); draw(); };
  document.getElementById("left").addEventListener("click", turnTo(90));
  document.getElementById("top").addEventListener("click", () => {
    view.turn = times(aboutX(Math.PI / 2), aboutY((-data.azimuth * Math.PI) / 180));
    draw();
  });
  document.getElementById("front").addEventListener("click", turnTo(data.azimuth));
  document.getElementById("back").addEventListener("click", turnTo(data.azimuth + 180));
  document.getElementById("reset").addEventListener("click", () => {
    Object.assign(view, { turn: seenFrom(data.azimuth), zoom: 1, shift: [0, 0] });
    draw();
  });
  field.addEventListener("change", choose);
  window.addEventListener("resize", draw);
  choose();
  document.getElementById("save").addEventListener("click", () => save());
  if (data.shapes[0].ways.length) along(moveAlong, (number) => { field.selectedIndex = number; choose(); });

  // The canvas at twice its size with names and colour bar, as one PNG.
  function save() {
    const ratio = 2 * (window.devicePixelRatio || 1);
    render(ratio);
    const picture = document.createElement("canvas"), pen = picture.getContext("2d");
    [picture.width, picture.height] = [canvas.width, canvas.height + 46 * ratio];
    pen.fillStyle = "#fff";
    pen.fillRect(0, 0, picture.width, picture.height);
    pen.drawImage(canvas, 0, 0);
    pen.scale(ratio, ratio);
    pen.font = "13px system-ui, sans-serif";
    onto(pen, around);
    pen.fillStyle = "#1c2430";
    pen.textAlign = "center";
    for (const name of document.getElementById("names").children) {
      const x = name.offsetLeft + name.offsetWidth / 2;
      [...name.children].filter((part) => part.textContent).forEach((part, i) => {
        pen.fillText(part.textContent, x, name.offsetTop + 14 + 9 * i);
      });
    }
    const below = canvas.height / ratio + 30, middle = canvas.width / ratio / 2;
    const chosen = data.fields[field.selectedIndex];
    pen.fillText(chosen.title, middle, below - 16);
    pen.drawImage(document.getElementById("colours"), middle - 90, below - 8, 180, 12);
    pen.textAlign = "end";
    pen.fillText(chosen.low, middle - 96, below + 2);
    pen.textAlign = "start";
    pen.fillText(chosen.high, middle + 96, below + 2);
    picture.toBlob((blob) => download(`${document.title.replace(/[^\w.-]+/g, "_")}.png`, URL.createObjectURL(blob)));
    draw();
  }
  return { move, draw };
}

// Of a browser without WebGL 2 there is none, and a picture is shown in its place.
const viewer = (() => {
  const field = document.getElementById("field"), names = document.getElementById("names");
  for (const { title } of data.fields) field.append(new Option(title));
  for (const shape of data.shapes) {
    const label = document.createElement("div"), group = document.createElement("b"), name = document.createElement("span");
    group.textContent = shape.group;
    name.textContent = shape.name;
    label.append(group, document.createElement("br"), name);
    names.append(label);
  }
  const canvas = document.getElementById("shapes");
  const gl = canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
  if (gl) return start(canvas, gl);
  for (const id of ["controls", "stage"]) document.getElementById(id).hidden = true;
  document.querySelector(".hint").hidden = true;
  document.getElementById("still").hidden = false;
})();
