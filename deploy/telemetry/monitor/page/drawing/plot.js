// One quantity over the time of the run: a line, three rules, and the present value beside the heading.
import { Painted } from "./canvas.js";

const LEFT = 40; // px, room for the figures of the vertical axis
const BOTTOM = 20;
const TOP = 8;
const RIGHT = 8;
const ROW = 14; // between two figures of the vertical axis

export class Plot extends Painted {
  constructor(canvas, output, model, options) {
    super(canvas);
    Object.assign(this, { output, model, options, at: null });
    canvas.addEventListener("pointermove", (event) => this.look(event.offsetX));
    canvas.addEventListener("pointerdown", (event) => this.look(event.offsetX));
    canvas.addEventListener("pointerleave", () => this.look(null));
  }

  // Position of the pointer, px from the left; the value of that time is shown in place of the present one.
  look(at) {
    this.at = at;
    this.wake();
  }

  pointed(points) {
    const time = this.begin + ((this.at - LEFT) / (this.width - LEFT - RIGHT)) * this.span;
    const off = (point) => Math.abs(point[0] - time);
    return points.reduce((best, point) => (off(point) < off(best) ? point : best));
  }

  draw() {
    const points = this.model.history.items;
    this.begin = Math.floor(points[0]?.[0] ?? 0); // of what this page has received
    this.span = niceCeiling(Math.max((points.at(-1)?.[0] ?? 0) - this.begin, 2));
    this.range = this.valueRange(points);
    this.drawAxes();
    const looked = this.at !== null && points.length > 0;
    const point = looked ? this.pointed(points) : points.at(-1);
    if (points.length) this.drawLine(points, point);
    if (looked) this.drawCursor(point);
    this.say(point, looked);
    return false;
  }

  valueRange(points) {
    const { pick, floor, ceiling } = this.options;
    let [low, high] = [floor, ceiling ?? floor];
    for (const point of points) {
      low = Math.min(low, pick(point));
      high = Math.max(high, pick(point));
    }
    return [low < floor ? -niceCeiling(-low) : floor, ceiling ?? niceCeiling(high || 1)];
  }

  x(time) {
    return LEFT + ((time - this.begin) / this.span) * (this.width - LEFT - RIGHT);
  }

  y(value) {
    const [low, high] = this.range;
    return this.height - BOTTOM - ((value - low) / (high - low)) * (this.height - TOP - BOTTOM);
  }

  drawAxes() {
    const { context } = this;
    const [low, high] = this.range;
    context.font = this.font(11);
    context.fillStyle = this.colour("muted");
    context.lineWidth = 1;
    context.textAlign = "right";
    context.textBaseline = "middle";
    const ruled = [];
    for (const value of [0, low, high, high / 2]) {
      const y = Math.round(this.y(value)) + 0.5;
      if (ruled.some((other) => Math.abs(other - y) < ROW)) continue;
      ruled.push(y);
      this.rule(y, value);
      context.fillText(short(value), LEFT - 6, y);
    }
    context.textBaseline = "alphabetic";
    for (const [share, align] of [[0, "left"], [0.5, "center"], [1, "right"]]) {
      context.textAlign = align;
      const time = this.begin + share * this.span;
      context.fillText(`${short(time)}${share === 1 ? " s" : ""}`, this.x(time), this.height - 4);
    }
  }

  rule(y, value) {
    const { context } = this;
    const border = value === 0 && this.options.zero;
    context.strokeStyle = this.colour(border ? "alarm" : "hairline");
    context.setLineDash(border ? [3, 3] : []);
    context.beginPath();
    context.moveTo(LEFT, y);
    context.lineTo(this.width - RIGHT, y);
    context.stroke();
    context.setLineDash([]);
    if (border) {
      context.save();
      context.textAlign = "left";
      context.textBaseline = "bottom";
      context.fillStyle = this.colour("alarm");
      context.fillText(this.options.zero, LEFT + 4, y - 1);
      context.restore();
    }
  }

  drawCursor(point) {
    const { context } = this;
    const x = Math.round(this.x(point[0])) + 0.5;
    context.beginPath();
    context.moveTo(x, TOP);
    context.lineTo(x, this.height - BOTTOM);
    context.lineWidth = 1;
    context.strokeStyle = this.colour("muted");
    context.stroke();
  }

  drawLine(points, marked) {
    const { context } = this;
    const { pick } = this.options;
    context.beginPath();
    points.forEach((point, i) => {
      const at = [this.x(point[0]), this.y(pick(point))];
      if (i) context.lineTo(...at);
      else context.moveTo(...at);
    });
    context.lineJoin = "round";
    context.lineWidth = 1.75;
    context.strokeStyle = this.colour("accent");
    context.stroke();
    context.beginPath();
    context.arc(this.x(marked[0]), this.y(pick(marked)), 3, 0, 2 * Math.PI);
    context.fillStyle = this.colour("accent");
    context.fill();
  }

  say(point, past) {
    const { pick, digits, unit } = this.options;
    const text = point ? `${pick(point).toFixed(digits)}${unit}` : "";
    this.output.textContent = past ? `${text} at ${point[0].toFixed(2)} s` : text;
  }
}

// The smallest of 1, 2, 4, 5, 8 times a power of ten that is at least `value`.
function niceCeiling(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  const factor = [1, 2, 4, 5, 8, 10].find((each) => each * power >= value * (1 - 1e-9));
  return factor * power;
}

const short = (value) => String(Number(value.toPrecision(3)));
