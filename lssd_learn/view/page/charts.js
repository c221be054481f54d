// The embeddings as SVG: a circle a shape, its name when the pointer rests on it.
"use strict";

(() => {
  const SIZE = [460, 340], MARGIN = [16, 16, 34, 34]; // pixels; top, right, bottom, left
  const embeddings = JSON.parse(document.getElementById("data").textContent).embeddings;

  function make(name, attributes, text) {
    const element = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    if (text !== undefined) element.textContent = text;
    return element;
  }

  for (const [label, colour] of embeddings.colours) {
    const entry = document.createElement("span"), dot = document.createElement("i");
    dot.style.background = colour;
    entry.append(dot, label);
    document.getElementById("legend").append(entry);
  }

  for (const panel of embeddings.panels) {
    const svg = make("svg", { viewBox: `0 0 ${SIZE[0]} ${SIZE[1]}`, role: "img" });
    const place = [0, 1].map((axis) => {
      const values = panel.points.map((point) => point[axis]);
      const low = Math.min(...values), range = Math.max(...values) - low || 1;
      const from = axis ? SIZE[1] - MARGIN[2] - 8 : MARGIN[3] + 8;
      const to = axis ? MARGIN[0] + 8 : SIZE[0] - MARGIN[1] - 8;
      return (value) => from + ((value - low) / range) * (to - from);
    });
    const grey = { fill: "#667083", "font-size": 12, "text-anchor": "middle" };
    const [right, bottom] = [SIZE[0] / 2, SIZE[1] / 2];
    svg.append(make("text", { ...grey, x: right, y: SIZE[1] - 10 }, `first component (${panel.ratios[0]})`));
    const side = { ...grey, transform: `translate(18 ${bottom}) rotate(-90)` };
    svg.append(make("text", side, `second component (${panel.ratios[1]})`));
    embeddings.order.forEach((i) => {
      const [x, y] = panel.points[i].map((value, axis) => place[axis](value).toFixed(1));
      const circle = make("circle", { cx: x, cy: y, r: 4.5, fill: embeddings.fill[i], stroke: "#fff", "stroke-width": 0.8 });
      circle.append(make("title", {}, embeddings.names[i]));
      svg.append(circle);
    });
    const figure = document.createElement("figure"), caption = document.createElement("figcaption");
    caption.textContent = panel.title;
    figure.append(caption, svg);
    document.getElementById("charts").append(figure);
  }
})();
