// The picture: workspace, goals, trails, disks, velocities, separating lines.
import { Painted } from "./canvas.js";
import { drawArrow, drawDisk, drawGoal, drawLabel, drawRing, drawSeparatingLine, drawTarget, drawTrail, drawWay } from "./shapes.js";

const MARGIN = 10; // px
const ARROW_SECONDS = 0.4; // an arrow is as long as the way of so many seconds
const CROWD = 24; // robots; more are drawn with less around them
const FAINT = 0.35;
const STALE = 1.5; // s of simulated time after which a line that was reported is not drawn

export class Workspace extends Painted {
  constructor(canvas, model, selection) {
    super(canvas);
    Object.assign(this, { model, selection });
    this.preview = null; // m, where the selected robot would be sent
    this.layers = {};
    for (const layer of ["trails", "goals", "velocity", "lines"]) {
      const box = document.getElementById(`show-${layer}`);
      this.layers[layer] = () => box.checked;
      box.addEventListener("change", () => this.wake());
    }
  }

  draw(now) {
    const { overview, robots } = this.model;
    if (overview === null) return false;
    this.scale = (Math.min(this.width, this.height) / 2 - MARGIN) / overview.radius;
    this.drawFloor(overview.radius);
    const places = robots.map((robot) => this.model.place(robot, now));
    this.crowd = robots.length > CROWD;
    if (this.layers.trails()) robots.forEach((robot, i) => drawTrail(this, robot, places[i], this.stress(robot)));
    if (this.layers.goals()) robots.filter((robot) => !this.stays(robot)).forEach((robot) => drawGoal(this, robot, this.stress(robot)));
    if (this.layers.lines()) this.drawLines(places);
    robots.forEach((robot, i) => drawDisk(this, robot, places[i]));
    if (this.layers.velocity()) robots.forEach((robot, i) => this.drawVelocity(robot, places[i]));
    robots.forEach((robot, i) => drawLabel(this, robot, places[i], this.standsOut(robot)));
    robots.forEach((robot, i) => this.drawChosen(robot, places[i]));
    this.describe();
    return this.model.moving(now);
  }

  stays(robot) {
    return ["at goal", "cancelled", "given up"].includes(robot.row?.status);
  }

  standsOut(robot) {
    return robot.id === this.selection.selected || robot.id === this.selection.pointed;
  }

  // How strongly what surrounds a robot is drawn: in a crowd, weakly unless somebody looks for it.
  stress(robot) {
    return !this.crowd || this.standsOut(robot) ? 1 : FAINT;
  }

  drawChosen(robot, place) {
    const { selected, pointed } = this.selection;
    if (robot.id === selected) {
      if (!this.stays(robot)) drawWay(this, robot, place);
      if (this.preview) drawTarget(this, robot, this.preview);
    }
    if (robot.id === selected) drawRing(this, robot, place, this.colour("accent"), 3);
    else if (robot.id === pointed) drawRing(this, robot, place, this.colour("muted"), 1.5);
  }

  point([x, y]) {
    return [this.width / 2 + x * this.scale, this.height / 2 - y * this.scale];
  }

  metres([x, y]) {
    return [(x - this.width / 2) / this.scale, (this.height / 2 - y) / this.scale];
  }

  inside(target) {
    return this.model.overview !== null && Math.hypot(...target) < this.model.overview.radius;
  }

  hue(robot) {
    return this.colour(robot.row?.alarm ? "alarm" : `robot-${robot.hue}`);
  }

  drawFloor(radius) {
    const { context } = this;
    const spacing = 10 ** Math.floor(Math.log10(radius));
    const rim = new Path2D();
    rim.arc(...this.point([0, 0]), radius * this.scale, 0, 2 * Math.PI);
    context.fillStyle = this.colour("floor");
    context.fill(rim);
    context.save();
    context.clip(rim);
    this.drawGrid(radius, spacing);
    context.restore();
    context.lineWidth = 1.5;
    context.strokeStyle = this.colour("muted");
    context.stroke(rim);
    this.drawScale(spacing);
  }

  drawGrid(radius, spacing) {
    const { context } = this;
    context.beginPath();
    for (let at = -Math.ceil(radius / spacing) * spacing; at <= radius; at += spacing) {
      context.moveTo(...this.point([at, -radius]));
      context.lineTo(...this.point([at, radius]));
      context.moveTo(...this.point([-radius, at]));
      context.lineTo(...this.point([radius, at]));
    }
    context.lineWidth = 1;
    context.strokeStyle = this.colour("grid");
    context.stroke();
  }

  // The workspace is round, so a corner is free for the scale.
  drawScale(spacing) {
    const { context } = this;
    const length = spacing * this.scale;
    const [x, y] = [2, this.height - 4];
    context.beginPath();
    context.moveTo(x, y - 5);
    context.lineTo(x, y);
    context.lineTo(x + length, y);
    context.lineTo(x + length, y - 5);
    context.lineWidth = 1;
    context.strokeStyle = this.colour("muted");
    context.stroke();
    context.font = this.font(12);
    context.fillStyle = this.colour("muted");
    context.textAlign = "center";
    context.fillText(`${spacing} m`, x + length / 2, y - 6);
  }

  drawLines(places) {
    const { robots, frame, overview } = this.model;
    const index = new Map(robots.map((robot, i) => [robot.id, i]));
    robots.forEach((robot, i) => {
      const age = ((frame?.tick ?? 0) - (robot.row?.lines_tick ?? 0)) * overview.step;
      const strength = Math.max(0, 1 - age / STALE);
      for (const line of robot.row?.lines ?? []) {
        const peer = index.get(line[0]);
        if (peer !== undefined && strength > 0) drawSeparatingLine(this, robot, places[i], places[peer], line, strength);
      }
    });
  }

  drawVelocity(robot, place) {
    const [vx, vy] = robot.row?.velocity ?? [0, 0];
    const speed = Math.hypot(vx, vy);
    if (speed === 0 || this.model.frame?.phase === "ended" || robot.row?.alarm) return;
    const rim = [place[0] + (vx / speed) * robot.radius, place[1] + (vy / speed) * robot.radius];
    drawArrow(this, rim, [vx * ARROW_SECONDS, vy * ARROW_SECONDS]);
  }

  describe() {
    const { robots, frame } = this.model;
    if (frame === null || frame.tick % 20) return; // often enough for who listens to it
    const alarms = robots.filter((robot) => robot.row?.alarm).map((robot) => `robot ${robot.id} ${robot.row.status}`);
    const home = robots.filter((robot) => robot.row?.status === "at goal").length;
    const text = `Workspace: ${robots.length} robots, ${home} at their goals${alarms.map((alarm) => `, ${alarm}`).join("")}`;
    if (this.canvas.getAttribute("aria-label") !== text) this.canvas.setAttribute("aria-label", text);
  }
}
