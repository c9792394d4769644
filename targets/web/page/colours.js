// Colours of the page's theme, and of scores.

export const colour = name => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

/** Colours by hit type: 0 open, 1 window, 2 wall. */
export const hitColours = () => ['open', 'window', 'wall'].map(colour);

const STOPS = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];

/** A colour from dark violet at 0 to yellow at 1. */
export const ramp = share => {
  const at = Math.min(Math.max(share, 0), 1) * (STOPS.length - 1);
  const low = Math.min(Math.floor(at), STOPS.length - 2);
  return STOPS[low].map((value, i) => Math.round(value + (at - low) * (STOPS[low + 1][i] - value)));
};

/** Fits a canvas to its box and the screen's pixels; its context, in units of the page. */
export const fitted = canvas => {
  const density = window.devicePixelRatio || 1;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  const [columns, rows] = [Math.round(width * density), Math.round(height * density)];
  if (canvas.width !== columns || canvas.height !== rows) Object.assign(canvas, { width: columns, height: rows });
  const context = canvas.getContext('2d');
  context.setTransform(density, 0, 0, density, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, width, height };
};
