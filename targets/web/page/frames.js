// A frame with what was seen in it.

import { colour } from './colours.js';

/** Draws pixels (red, green, blue) and over them segments, windows and edges. */
export const drawFrame = (canvas, [width, height], rgb, overlay) => {
  Object.assign(canvas, { width, height });
  const context = canvas.getContext('2d');
  const image = new ImageData(width, height);
  for (let i = 0; i < width * height; i++) {
    image.data.set(rgb.subarray(3 * i, 3 * i + 3), 4 * i);
    image.data[4 * i + 3] = 255;
  }
  context.putImageData(image, 0, 0);
  if (!overlay) return;
  const unit = width / 736;
  const stroke = (lines, name, thick) => {
    context.strokeStyle = colour(name);
    context.lineWidth = thick * unit;
    context.beginPath();
    for (const line of lines) line.forEach(([x, y], i) => (i ? context.lineTo(x + 0.5, y + 0.5) : context.moveTo(x + 0.5, y + 0.5)));
    context.stroke();
  };
  stroke(overlay.segments.map(([a, b, c, d]) => [[a, b], [c, d]]), 'segment', 1.2);
  stroke(overlay.windows, 'window', 3);
  const dots = (points, name, radius) => {
    context.fillStyle = colour(name);
    for (const point of points) {
      if (!point) continue;
      context.beginPath();
      context.arc(point[0] + 0.5, point[1] + 0.5, radius * unit, 0, 2 * Math.PI);
      context.fill();
    }
  };
  dots([...overlay.plan_floor, ...overlay.plan_ceiling], 'found', 1.6);
  dots([...overlay.floor, ...overlay.ceiling], 'edge', 2.6);
};

/** Empties a canvas. */
export const clearFrame = canvas => canvas.getContext('2d').clearRect(0, 0, canvas.width, canvas.height);
