// What lies over the shapes, a ruler and the axes of their files, and the view in the address of the page.
"use strict";

const AXES = [["x", "#c0392b"], ["y", "#2e8b57"], ["z", "#3b4cc0"]];
const LONGEST = 120, ARM = 24; // pixels

// Lines and words over a canvas so wide, for a view of so many pixels a unit: all shapes are seen alike.
function marks({ turn }, pixels, width) {
  const power = 10 ** Math.floor(Math.log10(LONGEST / pixels));
  const length = [5, 2, 1].map((times) => times * power).find((size) => size * pixels <= LONGEST);
  const end = 14 + length * pixels, ink = "#1c2430";
  const lines = [[[14, 12], [14, 18], [end, 18], [end, 12]]].map((points) => ({ points, ink }));
  const words = [{ text: String(Number(length.toPrecision(1))), at: [(14 + end) / 2, 32], ink }];
  const [cx, cy] = [width - 44, 44];
  data.axes.forEach((axis, i) => {
    const [x, y, z] = [0, 1, 2].map((row) => axis.reduce((sum, part, k) => sum + turn[3 * row + k] * part, 0));
    const [name, colour] = AXES[i], at = (far) => [cx + far * x, cy - far * y];
    lines.push({ points: [[cx, cy], at(ARM)], ink: colour, z });
    words.push({ text: name, at: [at(ARM + 9)[0], at(ARM + 9)[1] + 4], ink: colour });
  });
  return { lines: lines.sort((a, b) => (a.z || 0) - (b.z || 0)), words };
}

// Over the canvas, anew for each view: numbers and letters of ours, nothing that a file holds.
function over(svg, { lines, words }) {
  const drawn = lines.map(({ points, ink }) => `<polyline points="${points.join(" ")}" stroke="${ink}" fill="none" stroke-width="1.5"/>`);
  const said = words.map(({ text, at, ink }) => `<text x="${at[0]}" y="${at[1]}" fill="${ink}" text-anchor="middle">${text}</text>`);
  svg.innerHTML = [...drawn, ...said].join("");
}

// And in a picture.
function onto(pen, { lines, words }) {
  pen.lineWidth = 1.5;
  for (const { points, ink } of lines) {
    pen.strokeStyle = ink;
    pen.beginPath();
    points.forEach(([x, y], i) => (i ? pen.lineTo(x, y) : pen.moveTo(x, y)));
    pen.stroke();
  }
  pen.textAlign = "center";
  for (const { text, at, ink } of words) {
    pen.fillStyle = ink;
    pen.fillText(text, ...at);
  }
}

// Numbers behind #view= in the address: reloaded, bookmarked or sent, it leads to the same view.
function keep(numbers) {
  const address = `#view=${numbers.map((number) => Number(number.toPrecision(4))).join(",")}`;
  try { history.replaceState(null, "", address); } catch { /* a page inside another may have no address of its own */ }
}

function kept(count) {
  const numbers = (location.hash.match(/^#view=([-\d.,e]+)$/) || ["", ""])[1].split(",").map(Number);
  return numbers.length === count && numbers.every(Number.isFinite) ? numbers : null;
}
