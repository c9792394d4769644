// The plan, the robot in it, and answers.

import { colour, fitted, hitColours, ramp } from './colours.js';

const MOVE_M = 0.1;
const TURN_DEG = 5;
const HANDLE_PX = 34;

export class PlanMap {
  plan = null;
  robot = null;
  scan = null;
  candidates = null;
  answer = null;
  showHeat = true;
  #view = null;
  #zoomed = false;
  #picture = null;
  #pending = false;
  #drag = null;
  #moved;

  /** `moved` is told of each pose of the robot. */
  constructor(canvas, moved) {
    this.canvas = canvas;
    this.#moved = moved;
    canvas.addEventListener('pointerdown', event => this.#down(event));
    canvas.addEventListener('pointermove', event => this.#drag && this.#follow(event));
    for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, () => { this.#drag = null; });
    canvas.addEventListener('wheel', event => this.#wheel(event), { passive: false });
    canvas.addEventListener('keydown', event => this.#key(event));
    new ResizeObserver(() => this.#resized()).observe(canvas);
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.#paint());
  }

  /** Shows another plan, with the robot in its middle. */
  show(plan, cells, at) {
    Object.assign(this, { plan, cells, scan: null, candidates: null, answer: null });
    this.#unzoom();
    this.#paint();
    this.place(at ?? [0, 1].map(axis => plan.origin[axis] + plan.size[axis] / 2), 0);
  }

  /** Places the robot, at the heading it has unless another is told. */
  place(at, heading = this.robot?.heading ?? 0) {
    this.robot = { at, heading: ((heading % 360) + 360) % 360 };
    this.#moved(this.robot);
    this.draw();
  }

  /** Draws with the next frame of the screen. */
  draw() {
    if (this.#pending) return;
    this.#pending = true;
    requestAnimationFrame(() => {
      this.#pending = false;
      this.#draw();
    });
  }

  #paint() {
    if (!this.plan) return;
    const [width, height] = this.plan.picture;
    const rgb = name => {
      const probe = document.createElement('canvas').getContext('2d', { willReadFrequently: true });
      probe.fillStyle = colour(name);
      probe.fillRect(0, 0, 1, 1);
      return [...probe.getImageData(0, 0, 1, 1).data];
    };
    const colours = [[0, 0, 0, 0], rgb('wall'), rgb('window')];
    const image = new ImageData(width, height);
    this.cells.forEach((kind, i) => kind && image.data.set(colours[kind], 4 * i));
    this.#picture = document.createElement('canvas');
    Object.assign(this.#picture, { width, height });
    this.#picture.getContext('2d').putImageData(image, 0, 0);
    this.draw();
  }

  #unzoom() {
    this.#view = null;
    this.#zoomed = false;
  }

  #resized() {
    if (!this.#zoomed) this.#view = null;
    this.draw();
  }

  #fit(width, height) {
    const { size, origin } = this.plan;
    const scale = Math.min((width - 24) / size[0], (height - 24) / size[1]);
    return { scale, centre: [0, 1].map(axis => origin[axis] + size[axis] / 2) };
  }

  #pixel([x, y]) {
    const { scale, centre } = this.#view;
    return [this.canvas.clientWidth / 2 + (x - centre[0]) * scale, this.canvas.clientHeight / 2 - (y - centre[1]) * scale];
  }

  #metres([px, py]) {
    const { scale, centre } = this.#view;
    return [centre[0] + (px - this.canvas.clientWidth / 2) / scale, centre[1] - (py - this.canvas.clientHeight / 2) / scale];
  }

  #draw() {
    const { context, width, height } = fitted(this.canvas);
    if (!this.plan) {
      context.fillStyle = colour('quiet');
      context.font = '16px system-ui';
      context.textAlign = 'center';
      context.fillText('Drop a plan here, or take the sample building', width / 2, height / 2);
      return;
    }
    this.#view ??= this.#fit(width, height);
    const { origin, size } = this.plan;
    const [left, top] = this.#pixel([origin[0], origin[1] + size[1]]);
    if (this.candidates) this.#drawCandidates(context);
    if (this.scan) this.#drawRays(context);
    context.imageSmoothingEnabled = this.#view.scale * size[0] < this.#picture.width;
    context.drawImage(this.#picture, left, top, size[0] * this.#view.scale, size[1] * this.#view.scale);
    if (this.scan) this.#drawHits(context);
    this.#drawArrow(context, this.robot, colour('truth'), true);
    if (this.answer) this.#drawAnswer(context);
  }

  #drawCandidates(context) {
    const { places, scores } = this.candidates;
    if (!this.showHeat) return;
    context.globalAlpha = scores ? 0.85 : 1;
    const [least, most] = scores ? [Math.min(...scores), Math.max(...scores)] : [0, 1];
    const radius = Math.max(1.5, Math.min(0.17 * this.#view.scale, 8));
    for (let i = 0; i < places.length / 2; i++) {
      const [x, y] = this.#pixel([places[2 * i], places[2 * i + 1]]);
      context.fillStyle = scores ? `rgb(${ramp((scores[i] - least) / (most - least || 1))})` : colour('rule');
      context.beginPath();
      context.arc(x, y, scores ? radius : 1.5, 0, 2 * Math.PI);
      context.fill();
    }
    context.globalAlpha = 1;
  }

  #ends() {
    const { at, heading } = this.robot;
    return Array.from(this.scan.ranges, (range, bin) => {
      const angle = ((heading + bin) * Math.PI) / 180;
      return this.#pixel([at[0] + range * Math.cos(angle), at[1] + range * Math.sin(angle)]);
    });
  }

  #drawRays(context) {
    const [x, y] = this.#pixel(this.robot.at);
    context.strokeStyle = colour('ray');
    context.lineWidth = 1;
    context.beginPath();
    for (const end of this.#ends()) {
      context.moveTo(x, y);
      context.lineTo(...end);
    }
    context.stroke();
  }

  #drawHits(context) {
    const colours = hitColours();
    this.#ends().forEach(([x, y], bin) => {
      context.fillStyle = colours[this.scan.hits[bin]];
      context.beginPath();
      context.arc(x, y, 2.5, 0, 2 * Math.PI);
      context.fill();
    });
  }

  #drawArrow(context, { at, heading }, fill, handle = false) {
    const [x, y] = this.#pixel(at);
    const angle = (-heading * Math.PI) / 180;
    context.save();
    context.translate(x, y);
    context.rotate(angle);
    context.fillStyle = fill;
    context.strokeStyle = colour('paper');
    context.lineWidth = 1.5;
    context.beginPath();
    for (const [px, py] of [[14, 0], [-9, 8], [-5, 0], [-9, -8]]) context.lineTo(px, py);
    context.closePath();
    context.fill();
    context.stroke();
    if (handle) {
      context.beginPath();
      context.arc(HANDLE_PX, 0, 5, 0, 2 * Math.PI);
      context.fill();
      context.stroke();
    }
    context.restore();
  }

  #drawAnswer(context) {
    const { pose, candidates } = this.answer;
    context.globalAlpha = 0.55;
    candidates.slice(pose ? 1 : 0).reverse().forEach(other =>
      this.#drawArrow(context, { at: [other.x, other.y], heading: other.heading_deg }, colour('quiet')));
    context.globalAlpha = 1;
    if (!pose) return;
    const [[a, b], [, d]] = pose.covariance;
    const [middle, apart] = [(a + d) / 2, Math.hypot((a - d) / 2, b)];
    const [x, y] = this.#pixel([pose.x, pose.y]);
    const axis = value => 2 * Math.sqrt(Math.max(value, 0)) * this.#view.scale;
    context.strokeStyle = colour('found');
    context.lineWidth = 2;
    context.beginPath();
    context.ellipse(x, y, axis(middle + apart), axis(middle - apart), -0.5 * Math.atan2(2 * b, a - d), 0, 2 * Math.PI);
    context.stroke();
    this.#drawArrow(context, { at: [pose.x, pose.y], heading: pose.heading_deg }, colour('found'));
  }

  #down(event) {
    if (!this.plan) return;
    this.canvas.focus();
    this.canvas.setPointerCapture(event.pointerId);
    const [x, y] = this.#pixel(this.robot.at);
    const angle = (-this.robot.heading * Math.PI) / 180;
    const handle = [x + HANDLE_PX * Math.cos(angle), y + HANDLE_PX * Math.sin(angle)];
    const near = Math.hypot(event.offsetX - handle[0], event.offsetY - handle[1]) < 16;
    this.#drag = near ? 'turn' : 'move';
    this.#follow(event);
    event.preventDefault();
  }

  #follow(event) {
    const at = this.#metres([event.offsetX, event.offsetY]);
    if (this.#drag === 'move') return this.place(at);
    const [x, y] = this.robot.at;
    this.place(this.robot.at, (Math.atan2(at[1] - y, at[0] - x) * 180) / Math.PI);
  }

  #wheel(event) {
    if (!this.plan) return;
    event.preventDefault();
    this.#zoom(Math.exp(-event.deltaY / 500), [event.offsetX, event.offsetY]);
  }

  #zoom(factor, around) {
    const fixed = this.#metres(around);
    const scale = Math.min(Math.max(this.#view.scale * factor, 1), 400);
    const ratio = this.#view.scale / scale;
    this.#zoomed = true;
    this.#view = { scale, centre: this.#view.centre.map((value, axis) => fixed[axis] + (value - fixed[axis]) * ratio) };
    this.draw();
  }

  #key(event) {
    if (!this.plan) return;
    const far = event.shiftKey ? 1 : MOVE_M;
    const { at: [x, y], heading } = this.robot;
    const act = {
      ArrowLeft: () => this.place([x - far, y]),
      ArrowRight: () => this.place([x + far, y]),
      ArrowUp: () => this.place([x, y + far]),
      ArrowDown: () => this.place([x, y - far]),
      ',': () => this.place([x, y], heading + TURN_DEG),
      '.': () => this.place([x, y], heading - TURN_DEG),
      '+': () => this.#zoom(1.25, this.#pixel([x, y])),
      '-': () => this.#zoom(0.8, this.#pixel([x, y])),
      0: () => { this.#unzoom(); this.draw(); },
    }[event.key];
    if (!act || event.ctrlKey || event.metaKey) return;
    act();
    event.preventDefault();
  }
}
