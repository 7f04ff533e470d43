// The shapes of the picture, each drawn on a Workspace (its context, scale, colours).
const HEAD = 6; // px, head of an arrow
const LEGIBLE = 8; // px, radius of a disk with room for its number
const SEEN = 12; // px, least radius of a ring
const NEAR = 3; // radii, largest gap with a visible line

// The edge of a disk or of a polygon.
export function outline(space, { center, radius, points }) {
  const path = new Path2D();
  if (points) points.forEach((point, i) => (i ? path.lineTo(...space.point(point)) : path.moveTo(...space.point(point))));
  else path.arc(...space.point(center), radius * space.scale, 0, 2 * Math.PI);
  path.closePath();
  return path;
}

export function drawObstacle(space, obstacle) {
  const { context } = space;
  const path = outline(space, obstacle);
  context.fillStyle = context.strokeStyle = space.colour("muted");
  context.globalAlpha = 0.3;
  if (obstacle.status !== "appearing") context.fill(path);
  context.globalAlpha = 1;
  context.lineWidth = 1.25;
  if (obstacle.status === "appearing") context.setLineDash([4, 4]);
  context.stroke(path);
  context.setLineDash([]);
}

export function drawTrail(space, robot, place, stress) {
  const { context } = space;
  const points = [...robot.trail.items.slice(0, -1), place];
  context.beginPath();
  points.forEach((point, i) => (i ? context.lineTo(...space.point(point)) : context.moveTo(...space.point(point))));
  context.lineWidth = 1.75;
  context.lineJoin = "round";
  context.globalAlpha = 0.55 * stress;
  context.strokeStyle = space.hue(robot);
  context.stroke();
  context.globalAlpha = 1;
}

export function drawGoal(space, robot, stress) {
  const { context } = space;
  const [x, y] = space.point(robot.goal);
  const reach = Math.min(5, robot.radius * space.scale * 0.3);
  context.globalAlpha = stress;
  context.strokeStyle = space.hue(robot);
  context.lineWidth = 1.25;
  context.setLineDash([4, 4]);
  context.beginPath();
  context.arc(x, y, robot.radius * space.scale, 0, 2 * Math.PI);
  context.stroke();
  context.setLineDash([]);
  context.beginPath();
  context.moveTo(x - reach, y);
  context.lineTo(x + reach, y);
  context.moveTo(x, y - reach);
  context.lineTo(x, y + reach);
  context.stroke();
  context.globalAlpha = 1;
}

// Line from a robot to its goal.
export function drawWay(space, robot, place) {
  const { context } = space;
  context.beginPath();
  context.moveTo(...space.point(place));
  context.lineTo(...space.point(robot.goal));
  context.lineWidth = 1.25;
  context.setLineDash([2, 4]);
  context.strokeStyle = space.colour("accent");
  context.stroke();
  context.setLineDash([]);
}

// Goal of a click.
export function drawTarget(space, robot, target) {
  const { context } = space;
  context.beginPath();
  context.arc(...space.point(target), robot.radius * space.scale, 0, 2 * Math.PI);
  context.globalAlpha = 0.18;
  context.fillStyle = space.colour("accent");
  context.fill();
  context.globalAlpha = 1;
  context.lineWidth = 1.25;
  context.strokeStyle = space.colour("accent");
  context.stroke();
}

// Ring around a robot, large enough to be visible.
export function drawRing(space, robot, place, colour, width) {
  const { context } = space;
  context.beginPath();
  context.arc(...space.point(place), Math.max(SEEN, robot.radius * space.scale + 4), 0, 2 * Math.PI);
  context.lineWidth = width;
  context.strokeStyle = colour;
  context.stroke();
}

export function drawDisk(space, robot, place) {
  const { context } = space;
  const [x, y] = space.point(place);
  const radius = robot.radius * space.scale;
  context.beginPath();
  context.arc(x, y, Math.max(1, radius - 0.75), 0, 2 * Math.PI);
  context.fillStyle = space.colour("panel");
  context.globalAlpha = 0.75;
  context.fill();
  context.globalAlpha = robot.row?.alarm ? 0.38 : 0.22;
  context.fillStyle = context.strokeStyle = space.hue(robot);
  context.fill();
  context.globalAlpha = 1;
  context.lineWidth = robot.row?.alarm ? 3 : 2;
  context.stroke();
  if (robot.row?.alarm) drawCross(context, x, y, radius * Math.SQRT1_2);
}

function drawCross(context, x, y, reach) {
  context.beginPath();
  context.moveTo(x - reach, y - reach);
  context.lineTo(x + reach, y + reach);
  context.moveTo(x - reach, y + reach);
  context.lineTo(x + reach, y - reach);
  context.stroke();
}

// The robot's number, if there is room or the robot is selected; for an alarm its status.
export function drawLabel(space, robot, place, wanted) {
  const { context } = space;
  const [x, y] = space.point(place);
  const radius = robot.radius * space.scale;
  if (radius < LEGIBLE && !wanted && !robot.row?.alarm) return;
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.font = space.font(Math.max(9, Math.min(17, radius * 0.62)), 650);
  context.lineWidth = 4;
  if (robot.row?.alarm) {
    context.strokeStyle = space.colour("panel");
    context.strokeText(robot.id, x, y + 0.5);
  }
  context.fillStyle = space.colour(robot.row?.alarm ? "alarm" : "ink");
  context.fillText(robot.id, x, y + 0.5);
  if (robot.row?.alarm) {
    context.font = space.font(12, 650);
    context.strokeText(robot.row.status, x, y + radius + 10);
    context.fillText(robot.row.status, x, y + radius + 10);
  }
  context.textBaseline = "alphabetic";
}

export function drawArrow(space, place, [dx, dy]) {
  const { context } = space;
  const [x, y] = space.point(place);
  const [tx, ty] = [x + dx * space.scale, y - dy * space.scale];
  const length = Math.hypot(tx - x, ty - y);
  if (length < HEAD) return;
  const [ux, uy] = [(tx - x) / length, (ty - y) / length];
  const [bx, by] = [tx - ux * HEAD, ty - uy * HEAD];
  context.strokeStyle = context.fillStyle = space.colour("ink");
  context.lineWidth = 1.5;
  context.globalAlpha = 0.8;
  context.beginPath();
  context.moveTo(x, y);
  context.lineTo(bx, by);
  context.stroke();
  context.beginPath();
  context.moveTo(tx, ty);
  context.lineTo(bx - uy * HEAD * 0.55, by + ux * HEAD * 0.55);
  context.lineTo(bx + uy * HEAD * 0.55, by - ux * HEAD * 0.55);
  context.fill();
  context.globalAlpha = 1;
}

// Segment of the separating line of `robot` towards `other`, between the two.
export function drawSeparatingLine(space, robot, place, other, [, nx, ny, limit], strength) {
  const gap = Math.hypot(other[0] - place[0], other[1] - place[1]) - 2 * robot.radius;
  const nearness = Math.max(0, 1 - gap / (NEAR * robot.radius));
  if (nearness === 0) return;
  const middle = [(place[0] + other[0]) / 2, (place[1] + other[1]) / 2];
  const off = limit - nx * middle[0] - ny * middle[1];
  const foot = [middle[0] + off * nx, middle[1] + off * ny];
  const reach = 1.1 * robot.radius;
  const { context } = space;
  context.beginPath();
  context.moveTo(...space.point([foot[0] - ny * reach, foot[1] + nx * reach]));
  context.lineTo(...space.point([foot[0] + ny * reach, foot[1] - nx * reach]));
  context.lineWidth = 1.5;
  context.globalAlpha = strength * nearness;
  context.strokeStyle = space.hue(robot);
  context.stroke();
  context.globalAlpha = 1;
}
