// Distances between points, disks { center, radius } and convex polygons { points }, m.
export const distance = ([x, y], [u, v]) => Math.hypot(x - u, y - v);

// From a point to the edge of a shape; negative inside.
export function gap({ center, radius, points }, point) {
  if (!points) return distance(center, point) - radius;
  const edges = points.map((from, i) => [from, points[(i + 1) % points.length]]);
  const sides = edges.map(([a, b]) => Math.sign((b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0])));
  const nearest = Math.min(...edges.map(([a, b]) => distance(point, nearestOn(a, b, point))));
  return sides.every((side) => side === sides[0]) ? -nearest : nearest;
}

function nearestOn([ax, ay], [bx, by], [x, y]) {
  const [dx, dy] = [bx - ax, by - ay];
  const share = Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy || 1)));
  return [ax + share * dx, ay + share * dy];
}
