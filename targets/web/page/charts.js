// The polar profile and the descriptor.

import { colour, fitted, hitColours, ramp } from './colours.js';

const CHANNELS = ['range', 'hit type', 'gradient', 'inverse range', 'roughness'];

/** Ranges all around by hit type; ahead is up, left is left. */
export const drawPolar = (canvas, scan) => {
  const { context, width, height } = fitted(canvas);
  const [cx, cy, radius] = [width / 2, height / 2, Math.min(width, height) / 2 - 24];
  const most = Math.max(5, ...(scan ? scan.ranges : [30]));
  context.font = '12px system-ui';
  context.textAlign = 'center';
  context.strokeStyle = colour('rule');
  context.fillStyle = colour('quiet');
  for (const metres of [most / 2, most]) {
    context.beginPath();
    context.arc(cx, cy, radius * metres / most, 0, 2 * Math.PI);
    context.stroke();
    context.fillText(`${metres.toFixed(0)} m`, cx, cy - radius * metres / most - 4);
  }
  if (!scan) return;
  const colours = hitColours();
  const ends = Array.from(scan.ranges, (range, bin) => {
    const angle = -Math.PI / 2 - (bin * Math.PI) / 180;
    return [0, 1].map(axis => [cx, cy][axis] + [Math.cos(angle), Math.sin(angle)][axis] * radius * range / most);
  });
  context.fillStyle = colour('panel');
  context.beginPath();
  for (const end of ends) context.lineTo(...end);
  context.fill();
  context.lineWidth = 2.5;
  context.lineCap = 'round';
  ends.forEach(([x, y], bin) => {
    const next = (bin + 1) % 360;
    // A surface goes on to the next ray unless the range jumps.
    const joined = Math.abs(scan.ranges[next] - scan.ranges[bin]) < 0.1 * scan.ranges[bin] && scan.hits[next] === scan.hits[bin];
    context.strokeStyle = colours[scan.hits[bin]];
    context.beginPath();
    context.moveTo(x, y);
    context.lineTo(...(joined ? ends[next] : [x, y]));
    context.stroke();
  });
};

/** The five channels, a row each; ahead is at the left edge, left is a quarter on. */
export const drawMatrix = (canvas, scan) => {
  const { context, width, height } = fitted(canvas);
  if (!scan) return;
  const image = new ImageData(360, 5);
  scan.channels.forEach((value, i) => image.data.set([...ramp(value), 255], 4 * i));
  const rows = document.createElement('canvas');
  Object.assign(rows, { width: 360, height: 5 });
  rows.getContext('2d').putImageData(image, 0, 0);
  context.imageSmoothingEnabled = false;
  const [label, row] = [96, (height - 16) / 5];
  context.font = '12px system-ui';
  context.fillStyle = colour('quiet');
  CHANNELS.forEach((name, i) => {
    context.fillText(name, 4, row * (i + 0.5) + 4);
    context.drawImage(rows, 0, i, 360, 1, label, row * i + 1, width - label, row - 2);
  });
  for (const degrees of [0, 90, 180, 270]) {
    context.fillText(`${degrees}°`, label + (width - label) * degrees / 360, height - 3);
  }
};
