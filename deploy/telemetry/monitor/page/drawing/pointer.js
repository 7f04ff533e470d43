// The pointer on the picture: finds robots, shows their values, and sets the goal of the selected one.
import { values } from "../panels/selected.js";

const SLOP = { touch: 14, pen: 10, mouse: 4 }; // px, distance from a disk that selects it
const SHOWN = ["distance", "speed", "clearance"];

export class Pointer {
  constructor(workspace, model, selection, orders) {
    Object.assign(this, { workspace, model, selection, orders, at: null });
    this.tip = document.getElementById("tip");
    const { canvas } = workspace;
    canvas.addEventListener("pointermove", (event) => event.pointerType !== "touch" && this.move(event));
    canvas.addEventListener("pointerleave", () => this.leave());
    canvas.addEventListener("click", (event) => this.click(event));
  }

  move(event) {
    this.at = [event.offsetX, event.offsetY];
    this.selection.point(this.find(this.at, "mouse")?.id ?? null);
    this.show();
    this.workspace.wake();
  }

  leave() {
    this.at = null;
    this.selection.point(null);
    this.show();
    this.workspace.wake();
  }

  click(event) {
    const at = [event.offsetX, event.offsetY];
    const robot = this.find(at, event.pointerType || "mouse");
    const target = this.workspace.metres(at);
    if (robot !== null) this.selection.toggle(robot.id);
    else if (!this.workspace.inside(target)) this.selection.select(null);
    else this.orders.order([target], event.shiftKey);
  }

  // The robot with the nearest disk, if it is near enough.
  find(at, kind) {
    const gap = (robot) => {
      const [x, y] = this.workspace.point(robot.to);
      return Math.hypot(at[0] - x, at[1] - y) - robot.radius * this.workspace.scale;
    };
    const nearest = this.model.robots.reduce((best, robot) => (best === null || gap(robot) < gap(best) ? robot : best), null);
    return nearest !== null && gap(nearest) <= (SLOP[kind] ?? SLOP.mouse) ? nearest : null;
  }

  show() {
    const robot = this.at && this.model.robot(this.selection.pointed);
    const target = this.at && this.workspace.metres(this.at);
    const sends = Boolean(target) && !robot && this.orders.open && this.workspace.inside(target);
    this.workspace.preview = sends ? target : null;
    this.workspace.canvas.style.cursor = robot ? "pointer" : sends ? "crosshair" : "";
    this.tip.hidden = !robot;
    if (robot) this.describe(robot);
  }

  describe(robot) {
    const known = new Map(values(robot, this.model));
    const text = [`Robot ${robot.id}: ${known.get("status")}`, ...SHOWN.map((name) => `${name === "distance" ? "to goal" : name} ${known.get(name)}`)].join("\n");
    if (this.tip.textContent !== text) this.tip.textContent = text;
    const [x, y] = this.workspace.point(robot.to);
    const right = x < this.workspace.width / 2;
    const off = robot.radius * this.workspace.scale + 10;
    const shift = `translate(${right ? "0" : "-100%"}, -50%)`;
    Object.assign(this.tip.style, { left: `${x + (right ? off : -off)}px`, top: `${y}px`, transform: shift });
  }
}
