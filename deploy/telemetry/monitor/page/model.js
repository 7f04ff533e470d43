// The page's model: scenario, newest frame, and past positions, clearance and potential.
import { distance, gap } from "./geometry.js";
import { Thinned } from "./thinned.js";

const HISTORY = 2048;
const TRAILS = 24000; // points of all trails together
const HUES = 6;
const SHORTEST = 40; // ms, least duration of the drawn motion between two frames
const LONGEST = 160;

const worst = (earlier, later) => [later[0], Math.min(earlier[1], later[1]), later[2]];

export class Model {
  constructor() {
    this.overview = null;
    this.frame = null;
    this.robots = [];
    this.history = new Thinned(HISTORY);
  }

  begin(overview) {
    this.overview = overview.scenario === null ? null : overview;
    this.run = overview.run;
    this.frame = null;
    this.tick = overview.tick ?? -1;
    this.received = 0;
    this.history = new Thinned(HISTORY, overview.history ?? [], worst);
    const robots = overview.robots ?? [];
    const limit = Math.max(64, Math.floor(TRAILS / (robots.length || 1)));
    const hues = new Map(this.robots.map((robot) => [robot.id, robot.hue])); // remaining robots keep their colours
    let next = hues.size;
    this.robots = robots.map((robot) => {
      const place = robot.trail.at(-1) ?? robot.start;
      return { ...robot, hue: hues.get(robot.id) ?? next++ % HUES, trail: new Thinned(limit, robot.trail), from: place, to: place, row: null };
    });
  }

  take(frame, now) {
    this.frame = frame;
    this.period = Math.min(LONGEST, Math.max(SHORTEST, now - this.received));
    this.received = now;
    this.robots.forEach((robot, index) => {
      robot.from = robot.to;
      robot.row = frame.robots[index] ?? null;
      robot.goal = robot.row?.goal ?? robot.goal;
      robot.radius = robot.row?.radius ?? robot.radius;
    });
    frame.samples.filter((sample) => sample[0] > this.tick).forEach((sample) => this.append(sample));
  }

  append([tick, time, clearance, potential, places]) {
    this.tick = tick;
    this.history.append([time, clearance, potential]);
    this.robots.forEach((robot, index) => {
      robot.to = places[index];
      robot.trail.append(places[index]);
    });
  }

  robot(id) {
    return this.robots.find((robot) => robot.id === id) ?? null;
  }

  // Obstacles present or about to appear.
  get obstacles() {
    return Object.values({ ...this.overview.obstacles, ...this.frame?.obstacles }).filter((obstacle) => obstacle !== null);
  }

  // Clearance of a robot at the newest positions, m.
  clearance(robot) {
    const obstacles = this.obstacles.filter((obstacle) => obstacle.status !== "appearing");
    const disks = this.robots.filter((other) => other !== robot).map((other) => distance(robot.to, other.to) - other.radius);
    return Math.min(-gap(this.overview.room, robot.to), ...obstacles.map((obstacle) => gap(obstacle, robot.to)), ...disks) - robot.radius;
  }

  // Drawn position of a robot, between the last two frames. A refresh of the screen may have started
  // before the frame arrived.
  place(robot, now) {
    const share = Math.min(1, Math.max(0, (now - this.received) / this.period));
    return robot.from.map((part, axis) => part + (robot.to[axis] - part) * share);
  }

  moving(now) {
    return this.frame !== null && now - this.received < this.period;
  }
}
