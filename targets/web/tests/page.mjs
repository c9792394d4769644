// Drives the page in headless Chromium and compares what it finds with the compass command, to the bit.
//
//     node page.mjs COMPASS DEMO_DIR OUT_DIR
//
// COMPASS is the command, DEMO_DIR what `compass demo --out DEMO_DIR` wrote; screenshots go to OUT_DIR. PLAYWRIGHT names a folder
// where playwright-core is installed, CHROMIUM the browser.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, readFileSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { extname, join, normalize } from 'node:path';
import { fileURLToPath } from 'node:url';

const { chromium } = createRequire(join(process.env.PLAYWRIGHT ?? '.', 'x.js'))('playwright-core');
const [command, demo, out] = process.argv.slice(2);
const pages = fileURLToPath(new URL('../page', import.meta.url));
const seen = name => join(demo, 'seen', name);
const scratch = mkdtempSync(join(tmpdir(), 'compass-page-'));
mkdirSync(out, { recursive: true });

const TYPES = { '.html': 'text/html', '.js': 'text/javascript', '.css': 'text/css', '.svg': 'image/svg+xml', '.wasm': 'application/wasm' };
const server = createServer((request, response) => {
  const path = normalize(new URL(request.url, 'http://localhost').pathname);
  try {
    const body = readFileSync(join(pages, path === '/' ? 'index.html' : path));
    response.writeHead(200, { 'content-type': TYPES[extname(path)] ?? 'text/html' }).end(body);
  } catch {
    response.writeHead(404).end();
  }
});
await new Promise(resolve => server.listen(0, '127.0.0.1', resolve));
const origin = `http://127.0.0.1:${server.address().port}`;

// `localize` leaves with 1 where it does not know, which is an answer.
const localized = (...told) => {
  const frames = ['--cam0', seen('cam0.png'), '--cam1', seen('cam1.png'), '--calib', seen('calibration.yaml')];
  return JSON.parse(execFileSync(command, ['localize', '--map', seen('sample.site'), ...frames, ...told, '--json', '-']));
};

const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
  args: ['--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync'],
});
const context = await browser.newContext({ viewport: { width: 1360, height: 1500 }, acceptDownloads: true });
const page = await context.newPage();
const complaints = [];
const asked = new Set();
page.on('pageerror', error => complaints.push(String(error)));
page.on('console', message => message.type() === 'error' && complaints.push(message.text()));
page.on('request', request => asked.add(new URL(request.url()).origin));

const text = id => page.textContent(`#${id}`);
const until = (id, pattern) => page.waitForFunction(([id, source]) => new RegExp(source).test(document.getElementById(id).textContent), [id, pattern.source], { timeout: 120_000 });
const shot = name => page.screenshot({ path: join(out, `${name}.png`), fullPage: true });
const downloaded = async id => {
  const [file] = await Promise.all([page.waitForEvent('download'), page.click(`#${id}`)]);
  return readFileSync(await file.path());
};
const answer = async () => JSON.parse(await downloaded('save-json'));
const checked = what => console.log(`ok: ${what}`);

try {
  await page.goto(origin);
  await until('place', /heading/);
  assert.match(await text('plan-note'), /^sample: 32\.0 x 22\.0 m/);

  // Dragging: as many scans as the screen shows frames, or nearly.
  const box = await page.locator('#map').boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  const before = Number(await page.evaluate(() => document.documentElement.dataset.scans));
  const frames = await page.evaluate(() => new Promise(resolve => {
    const map = document.getElementById('map');
    const box = map.getBoundingClientRect();
    let count = 0;
    const began = performance.now();
    const step = () => {
      const angle = count / 20;
      map.dispatchEvent(new PointerEvent('pointermove', { clientX: box.x + box.width * (0.5 + 0.1 * Math.cos(angle)), clientY: box.y + box.height * (0.5 + 0.1 * Math.sin(angle)), bubbles: true }));
      if (++count < 120) requestAnimationFrame(step);
      else resolve(1000 * count / (performance.now() - began));
    };
    requestAnimationFrame(step);
  }));
  await page.mouse.up();
  const scans = Number(await page.evaluate(() => document.documentElement.dataset.scans)) - before;
  assert.ok(scans >= 100, `${scans} scans of 120 places`);
  checked(`dragging: ${scans} scans of 120 places at ${frames.toFixed(0)} frames a second`);

  const place = await text('place');
  await page.focus('#map');
  await page.keyboard.press('Shift+ArrowRight');
  await page.keyboard.press(',');
  await page.waitForFunction(place => document.getElementById('place').textContent !== place, place);

  // The descriptor of a place is that of the command.
  const described = JSON.parse(execFileSync(command, ['describe', join(demo, 'sample-building.png'), '--at', '9.3,15.2', '--heading', '33', '--json', '-']));
  const channels = await page.evaluate(async () => {
    const { Library } = await import('./library.js');
    const library = new Library();
    await library.call({ call: 'sample' });
    const { bytes } = await library.call({ call: 'scan', at: [9.3, 15.2], heading: 33 });
    return [...new Float32Array(bytes.buffer).slice(720)];
  });
  const apart = described.channels.flat().map((value, i) => Math.abs(value - channels[i]));
  assert.ok(channels.length === 1800 && Math.max(...apart) < 2e-6, `descriptors ${Math.max(...apart)} apart`);
  checked('the descriptor of a place equals that of compass describe');

  // A site is the same file as the command's.
  await page.click('#build');
  await until('site-note', /candidates$/);
  assert.deepEqual(await downloaded('save-site'), readFileSync(seen('sample.site')));
  checked('the site built equals that of the command, byte for byte');

  // Frames of the demo, then the same as files.
  const expected = localized('--mount', 'inverted');
  await page.click('#sample-frames');
  await until('frames-note', /^the frames of the demo/);
  await page.click('#locate');
  await until('answer', /probability/);
  const compared = ({ pose, candidates }, expected) => {
    assert.equal(pose.bits, expected.bits);
    const places = candidates.map(({ x, y, heading_deg }) => [x, y, heading_deg]);
    const wanted = expected.candidates.map(({ x, y, heading_deg }) => [x, y, heading_deg]);
    assert.equal(places.length, wanted.length);
    places.flat().forEach((value, i) => assert.ok(Math.abs(value - wanted.flat()[i]) < 1e-6));
    expected.covariance.flat().forEach((value, i) => assert.ok(Math.abs(value - pose.covariance.flat()[i]) < 1e-9));
  };
  compared(await answer(), expected);
  await page.waitForSelector('#progress', { state: 'hidden' });
  checked('frames that the page renders give the pose of the command to the bit');
  await shot('light');
  await page.emulateMedia({ colorScheme: 'dark' });
  await page.waitForTimeout(300);
  await shot('dark');
  await page.emulateMedia({ colorScheme: 'light' });
  await page.setInputFiles('#frame-files', ['cam1.png', 'calibration.yaml', 'cam0.png'].map(seen));
  await until('frames-note', /^cam0: cam0.png, cam1: cam1.png$/);
  await page.click('#locate');
  await until('answer', /probability/);
  compared(await answer(), expected);
  const first = await text('answer');
  await page.selectOption('#mount', 'auto');
  await page.fill('#height', '1.6');
  await page.click('#locate');
  await page.waitForFunction(first => /probability/.test(document.getElementById('answer').textContent) && document.getElementById('answer').textContent !== first, first);
  compared(await answer(), localized('--camera-height', '1.6'));
  checked('frames from files do too, also with the height told and the mounting not');

  // From a site file alone, and from a plan file.
  await page.setInputFiles('#plan-files', seen('sample.site'));
  await until('site-note', /candidates$/);
  await page.setInputFiles('#plan-files', join(demo, 'sample-building.png'));
  await until('plan-note', /^sample-building: 32\.0 x 22\.0 m/);
  await page.click('#simulate');
  await until('frames-note', /^simulated/);
  await page.click('#locate');
  await until('answer', /^(x|I don)/);
  checked('a plan from a file is searched');

  // What cannot be used is said, and the page goes on.
  const file = (name, content) => {
    writeFileSync(join(scratch, name), content);
    return join(scratch, name);
  };
  const wrong = async (input, files, note, pattern) => {
    await page.setInputFiles(input, files);
    await until(note, pattern);
  };
  await wrong('#plan-files', file('notes.txt.png', 'no picture'), 'plan-note', /notes\.txt\.png: .*not a/);
  await wrong('#plan-files', file('cut.png', readFileSync(join(demo, 'sample-building.png')).subarray(0, 3000)), 'plan-note', /cut\.png: /);
  await wrong('#plan-files', file('cut.site', readFileSync(seen('sample.site')).subarray(0, 3000)), 'site-note', /cut\.site: /);
  await wrong('#plan-files', file('map.yaml', 'image: gone.png\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.2\n'), 'plan-note', /gone\.png/);
  await wrong('#frame-files', file('other.yaml', 'cam0: {}\n'), 'frames-note', /other\.yaml: /);
  await wrong('#frame-files', [seen('cam0.png'), seen('cam1.png'), seen('map.png')], 'frames-note', /3 images/);
  await wrong('#frame-files', seen('map.png'), 'frames-note', /./);
  const refused = await page.evaluate(async () => {
    const { Library } = await import('./library.js');
    const library = new Library();
    const said = json => library.call(json).then(() => 'done', error => error.message);
    const all = [await said({ call: 'scan', at: [1, 1], heading: 0 }), await said({ call: 'nonsense' })];
    await library.call({ call: 'sample' });
    all.push(await said({ call: 'scan', at: [-5, 1], heading: 0 }), await said({ call: 'build', spacing: 0 }), await said({ call: 'build', spacing: null }));
    all.push(await said({ call: 'locate', mount: 'sideways' }), await said({ call: 'simulate', at: [1e300, 1], heading: 0 }));
    // A worker that is killed leaves nobody waiting.
    const waiting = said({ call: 'build', spacing: 0.1 });
    library.restart();
    all.push(await waiting, await said({ call: 'sample' }));
    return all;
  });
  assert.equal(refused.pop(), 'done');
  assert.equal(refused.pop(), 'stopped');
  assert.ok(refused.slice(0, -1).every(said => said !== 'done' && !/stopped/.test(said)), refused.join('\n'));
  checked(`wrong input is said:\n    ${refused.join('\n    ')}`);
  await page.click('#sample');
  await until('plan-note', /^sample/);

  await page.setViewportSize({ width: 400, height: 800 });
  await page.waitForTimeout(300);
  await shot('narrow');
  const overflow = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  assert.ok(overflow <= 0, `${overflow} pixels too wide for a telephone`);
  assert.deepEqual([...asked].filter(asked => asked !== origin && !asked.startsWith('blob') && asked !== 'null'), []);
  assert.deepEqual(complaints, []);
  checked('nothing was asked of another machine, and nothing complained');

  // Beside the command's time for the same frames.
  const native = Object.values(expected.milliseconds).reduce((sum, ms) => sum + ms, 0) - expected.milliseconds.read_map - expected.milliseconds.read_frames;
  const inBrowser = await page.evaluate(async () => {
    const { Library } = await import('./library.js');
    const library = new Library();
    await library.call({ call: 'sample' });
    await library.call({ call: 'build', spacing: 0.5 });
    await library.call({ call: 'simulate' });
    const times = [];
    for (let i = 0; i < 9; i++) {
      const began = performance.now();
      await library.call({ call: 'locate', mount: 'inverted' });
      times.push(performance.now() - began);
    }
    return times.sort((a, b) => a - b)[4];
  });
  console.log(`frames to pose: ${inBrowser.toFixed(0)} ms in the page, ${native.toFixed(0)} ms by the command: ${(inBrowser / native).toFixed(1)} times`);
} catch (error) {
  await shot('failed').catch(() => {});
  console.error(complaints.join('\n'));
  throw error;
} finally {
  await browser.close();
  server.close();
}
