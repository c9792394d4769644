// The page: what its controls do.

import { drawMatrix, drawPolar } from './charts.js';
import { clearFrame, drawFrame } from './frames.js';
import { Library, lend } from './library.js';
import { PlanMap } from './map.js';

const element = id => document.getElementById(id);
const say = (id, text, wrong = false) => {
  element(id).textContent = text;
  element(id).classList.toggle('wrong', wrong);
};

// One worker looks around while the other builds and searches.
const stopped = () => say('plan-note', 'The library stopped and starts anew: open the plan again.', true);
const explorer = new Library(() => {}, stopped);
const finder = new Library(percent => { element('progress').value = percent; }, stopped);

const map = new PlanMap(element('map'), look);
const state = { files: [], built: false, calibrated: false, framed: false, images: [null, null] };

// What is around the robot: one request at a time, always for the latest pose.
let asking = false;
let wanted = null;

async function look(robot) {
  wanted = robot;
  if (asking) return;
  asking = true;
  while (wanted) {
    const { at, heading } = wanted;
    wanted = null;
    try {
      const { bytes } = await explorer.call({ call: 'scan', at, heading });
      const values = new Float32Array(bytes.buffer);
      map.scan = { ranges: values.subarray(0, 360), hits: values.subarray(360, 720), channels: values.subarray(720) };
      say('place', `x ${at[0].toFixed(2)} m, y ${at[1].toFixed(2)} m, heading ${heading.toFixed(1)}°`);
    } catch (error) {
      map.scan = null;
      say('place', error.message, true);
    }
    map.draw();
    drawPolar(element('polar'), map.scan);
    drawMatrix(element('matrix'), map.scan);
    document.documentElement.dataset.scans = Number(document.documentElement.dataset.scans ?? 0) + 1;
  }
  asking = false;
}

const number = id => (element(id).value === '' ? undefined : Number(element(id).value));

const options = () => ({
  resolution: number('resolution'),
  scale: number('scale'),
  min_thickness: number('thickness'),
  invert: element('invert').checked,
});

async function showPlan(request, at) {
  say('plan-note', 'reading …');
  try {
    const { json, bytes } = await explorer.call(request);
    await finder.call(request);
    forget();
    map.show(json, bytes, at);
    const [width, height] = json.size.map(side => side.toFixed(1));
    const layers = json.has_structure ? 'plan and structure' : 'one layer';
    say('plan-note', [`${json.name}: ${width} x ${height} m, ${json.resolution} m per pixel, ${layers}`, ...json.notes].join('\n'));
  } catch (error) {
    say('plan-note', error.message, true);
  }
}

/** A plan that is another has no site, and answers on the former mean nothing. */
function forget() {
  state.built = false;
  state.answer = null;
  element('save-site').disabled = element('save-json').disabled = true;
  say('site-note', '');
  say('answer', '');
}

const extension = file => file.name.split('.').pop().toLowerCase();
const isYaml = file => ['yaml', 'yml'].includes(extension(file));

async function openPlan(files) {
  const all = [...files];
  if (!all.length) return;
  try {
    for (const file of all) for (const library of [explorer, finder]) await lend(library, file);
  } catch (error) {
    return say('plan-note', error.message, true);
  }
  const site = all.find(file => extension(file) === 'site');
  if (site) return openSite(site);
  state.files = all;
  await readPlan();
}

async function readPlan() {
  const file = state.files.find(isYaml) ?? state.files[0];
  if (file) await showPlan({ call: 'plan', name: file.name, options: options() });
}

async function openSite(file) {
  try {
    takeSite(await finder.call({ call: 'site', name: file.name }));
  } catch (error) {
    say('site-note', error.message, true);
  }
}

function takeSite({ json, bytes }) {
  state.built = true;
  map.candidates = { places: new Float32Array(bytes.buffer) };
  map.answer = null;
  element('save-site').disabled = false;
  say('site-note', `${json.floors.filter(Boolean).join(', ') || 'site'}: ${json.candidates} candidates`);
  map.draw();
}

/** Does something that takes long, with the controls that start such work off. */
async function busy(note, work) {
  const buttons = ['build', 'simulate', 'sample-frames', 'locate'].map(element);
  for (const button of buttons) button.disabled = true;
  try {
    return await work();
  } catch (error) {
    say(note, error.message, true);
  } finally {
    for (const button of buttons) button.disabled = false;
    element('progress').hidden = true;
  }
}

const build = () => busy('site-note', async () => {
  element('progress').value = 0;
  element('progress').hidden = false;
  say('site-note', 'building …');
  takeSite(await finder.call({ call: 'build', spacing: number('spacing') ?? 0.5 }));
});

const simulate = (at, heading) => busy('frames-note', async () => {
  say('frames-note', 'rendering …');
  await takeFrames(await finder.call({ call: 'simulate', at, heading, seed: at ? 1 : null }));
  element('mount').value = 'inverted';
  say('frames-note', at ? 'simulated frames from the robot’s place, upside down' : 'the frames of the demo');
});

async function takeFrames({ json: { sizes } }) {
  state.images = [null, null];
  for (const camera of [0, 1]) {
    const canvas = element(`cam${camera}`);
    if (!sizes[camera]) {
      clearFrame(canvas);
      continue;
    }
    const { bytes } = await finder.call({ call: 'image', camera });
    state.images[camera] = { size: sizes[camera], rgb: bytes };
    drawFrame(canvas, sizes[camera], bytes);
  }
  map.answer = null;
  say('answer', '');
  map.draw();
}

const openFrames = files => busy('frames-note', async () => {
  const all = [...files].sort((a, b) => a.name.localeCompare(b.name));
  if (!all.length) return;
  for (const file of all) await lend(finder, file);
  const calibration = all.find(isYaml);
  if (calibration) {
    await finder.call({ call: 'calibration', name: calibration.name });
    state.calibrated = true;
  }
  const images = all.filter(file => !isYaml(file));
  if (images.length > 2) throw new Error(`${images.length} images: one for each camera, at most two`);
  if (!images.length) return say('frames-note', `${calibration.name} taken; now the frames`);
  if (!state.calibrated) throw new Error('open the calibration of the cameras first, or together with the frames');
  await takeFrames(await finder.call({ call: 'frames', files: [images[0].name, images[1]?.name ?? null] }));
  say('frames-note', images.map((file, camera) => `cam${camera}: ${file.name}`).join(', '));
});

const locate = () => busy('answer', async () => {
  if (!state.built) await build();
  if (!state.built) throw new Error('there is no site to search: see above');
  say('answer', 'searching …');
  const began = performance.now();
  const { json } = await finder.call({ call: 'locate', mount: element('mount').value, camera_height: number('height') ?? null });
  const seconds = (performance.now() - began) / 1000;
  state.answer = map.answer = json;
  element('save-json').disabled = false;
  state.images.forEach((image, camera) => image && drawFrame(element(`cam${camera}`), image.size, image.rgb, json.overlays[camera]));
  say('answer', words(json, seconds));
  map.draw();
  await heat();
});

/** Colours the candidates by how well the descriptor seen matches theirs. */
async function heat() {
  element('progress').value = 0;
  element('progress').hidden = false;
  const { bytes } = await finder.call({ call: 'heat' });
  const values = new Float32Array(bytes.buffer);
  if (!values.length) return;
  map.candidates = {
    places: Float32Array.from({ length: values.length / 3 * 2 }, (_, i) => values[3 * (i >> 1) + (i & 1)]),
    scores: Float32Array.from({ length: values.length / 3 }, (_, i) => values[3 * i + 2]),
  };
  map.draw();
}

function words({ pose, probability, reason, camera_height_m }, seconds) {
  const time = `${seconds.toFixed(2)} s`;
  if (!pose) return `I don’t know (probability ${probability.toFixed(2)}): ${reason}\n${time}`;
  const deviation = i => Math.sqrt(pose.covariance[i][i]);
  const spread = `± ${Math.hypot(deviation(0), deviation(1)).toFixed(2)} m, ± ${(deviation(2) * 180 / Math.PI).toFixed(1)}°`;
  return `x ${pose.x.toFixed(3)} m, y ${pose.y.toFixed(3)} m, heading ${pose.heading_deg.toFixed(2)}° (${spread}) on ${pose.floor}\n` +
    `probability ${probability.toFixed(2)}, camera ${camera_height_m.toFixed(2)} m above the floor, ${time}`;
}

function save(name, content) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(content);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

function droppable(id, open) {
  const zone = element(id);
  for (const kind of ['dragenter', 'dragover']) zone.addEventListener(kind, event => {
    event.preventDefault();
    zone.classList.add('over');
  });
  zone.addEventListener('dragleave', () => zone.classList.remove('over'));
  zone.addEventListener('drop', event => {
    event.preventDefault();
    zone.classList.remove('over');
    open(event.dataTransfer.files);
  });
}

function chosen(id, open) {
  element(id).addEventListener('change', async event => {
    await open(event.target.files);
    // The same file can be chosen again.
    event.target.value = '';
  });
}

const SAMPLE_AT = [17.2, 11.2];
element('sample').onclick = () => {
  state.files = [];
  return showPlan({ call: 'sample' }, SAMPLE_AT);
};
element('build').onclick = build;
element('simulate').onclick = () => map.robot && simulate(map.robot.at, map.robot.heading);
element('sample-frames').onclick = () => simulate(null, 0);
element('locate').onclick = locate;
element('show-heat').onchange = event => {
  map.showHeat = event.target.checked;
  map.draw();
};
element('save-picture').onclick = () => element('map').toBlob(blob => save('compass.png', blob));
element('save-json').onclick = () => save('compass.json', new Blob([JSON.stringify(state.answer, null, 1)], { type: 'application/json' }));
element('save-site').onclick = async () => {
  const { bytes } = await finder.call({ call: 'save' });
  save(`${map.plan?.name ?? 'building'}.site`, new Blob([bytes]));
};
for (const id of ['resolution', 'scale', 'thickness', 'invert']) element(id).onchange = readPlan;
chosen('plan-files', openPlan);
chosen('frame-files', openFrames);
droppable('plan', openPlan);
droppable('find', openFrames);
// A file that misses would replace the page.
for (const kind of ['dragover', 'drop']) addEventListener(kind, event => event.preventDefault());
const drawCharts = () => {
  drawPolar(element('polar'), map.scan);
  drawMatrix(element('matrix'), map.scan);
};
new ResizeObserver(drawCharts).observe(element('look'));
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', drawCharts);

showPlan({ call: 'sample' }, SAMPLE_AT);
