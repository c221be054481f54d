// A mesh that follows numbers: its vertices are a mean and so much of each of a few modes. See `view/moving.py`.
"use strict";

class MovingMesh {
  constructor({ mean, modes, scales }) {
    this.mean = decode(mean, Float32Array);
    this.modes = modes.map((text) => decode(text, Int16Array));
    this.scales = scales;
    this.points = new Float32Array(this.mean.length);
  }

  // The vertices for these coefficients, one a mode; the array is the same each time.
  at(coefficients) {
    const { points } = this;
    points.set(this.mean);
    this.modes.forEach((mode, j) => {
      const step = coefficients[j] * this.scales[j];
      if (step) for (let i = 0; i < points.length; i++) points[i] += step * mode[i];
    });
    return points;
  }

  // How far each vertex lies from where it is in `others`, a byte each: 255 is `most` or more.
  bytes(others, most, found = new Uint8Array(this.mean.length / 3)) {
    const { points } = this;
    for (let v = 0, i = 0; v < found.length; v++, i += 3) {
      const x = points[i] - others[i], y = points[i + 1] - others[i + 1], z = points[i + 2] - others[i + 2];
      found[v] = Math.min(255, (255 * Math.sqrt(x * x + y * y + z * z)) / most);
    }
    return found;
  }
}
