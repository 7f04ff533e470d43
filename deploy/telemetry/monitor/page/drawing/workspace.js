// The picture: workspace, goals, trails, disks, velocities, separating lines.
import { Painted } from "./canvas.js";
import { gap } from "../geometry.js";
import { drawArrow, drawDisk, drawGoal, drawLabel, drawRing, drawSeparatingLine, drawTarget, drawObstacle, drawTrail, drawWay, outline } from "./shapes.js";

const MARGIN = 10; // px
const ARROW_SECONDS = 0.4; // an arrow shows the motion of this time
const CROWD = 24; // robots from which details are faint
const FAINT = 0.35;
const STALE = 1.5; // s of simulated time after which a reported line is not drawn

export class Workspace extends Painted {
  constructor(canvas, model, selection) {
    super(canvas);
    Object.assign(this, { model, selection });
    this.preview = null; // m, goal of the selected robot under the pointer
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
    const [[left, low], [right, high]] = overview.box;
    this.middle = [(left + right) / 2, (low + high) / 2];
    this.scale = Math.min((this.width - 2 * MARGIN) / (right - left), (this.height - 2 * MARGIN) / (high - low));
    this.drawFloor(overview);
    this.model.obstacles.forEach((obstacle) => drawObstacle(this, obstacle));
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

  // Opacity of a robot's details: faint in a crowd, unless the robot is selected.
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
    const [middleX, middleY] = this.middle;
    return [this.width / 2 + (x - middleX) * this.scale, this.height / 2 - (y - middleY) * this.scale];
  }

  metres([x, y]) {
    const [middleX, middleY] = this.middle;
    return [middleX + (x - this.width / 2) / this.scale, middleY - (y - this.height / 2) / this.scale];
  }

  inside(target) {
    return this.model.overview !== null && gap(this.model.overview.room, target) < 0;
  }

  hue(robot) {
    return this.colour(robot.row?.alarm ? "alarm" : `robot-${robot.hue}`);
  }

  drawFloor({ room, box }) {
    const { context } = this;
    const spacing = 10 ** Math.floor(Math.log10((box[1][0] - box[0][0]) / 2));
    const rim = outline(this, room);
    context.fillStyle = this.colour("floor");
    context.fill(rim);
    context.save();
    context.clip(rim);
    this.drawGrid(box, spacing);
    context.restore();
    context.lineWidth = 1.5;
    context.strokeStyle = this.colour("muted");
    context.stroke(rim);
    this.drawScale(spacing);
  }

  drawGrid([[left, low], [right, high]], spacing) {
    const { context } = this;
    context.beginPath();
    for (let at = Math.ceil(left / spacing) * spacing; at <= right; at += spacing) {
      context.moveTo(...this.point([at, low]));
      context.lineTo(...this.point([at, high]));
    }
    for (let at = Math.ceil(low / spacing) * spacing; at <= high; at += spacing) {
      context.moveTo(...this.point([left, at]));
      context.lineTo(...this.point([right, at]));
    }
    context.lineWidth = 1;
    context.strokeStyle = this.colour("grid");
    context.stroke();
  }

  // A corner of a round workspace is free for the scale.
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
    if (frame === null || frame.tick % 20) return; // often enough for a screen reader
    const alarms = robots.filter((robot) => robot.row?.alarm).map((robot) => `robot ${robot.id} ${robot.row.status}`);
    const home = robots.filter((robot) => robot.row?.status === "at goal").length;
    const text = `Workspace: ${robots.length} robots, ${home} at their goals${alarms.map((alarm) => `, ${alarm}`).join("")}`;
    if (this.canvas.getAttribute("aria-label") !== text) this.canvas.setAttribute("aria-label", text);
  }
}
