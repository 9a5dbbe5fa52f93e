// Vectors, and a camera that turns about a point.

const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const plus = (a, b, factor = 1) => a.map((x, i) => x + factor * b[i]);
const unit = (a) => a.map((x) => x / Math.hypot(...a));

const MARGIN = 1.16; // room above and below for the title and the controls

function axes(azimuth, elevation) {
  const [ca, sa, ce, se] = [Math.cos(azimuth), Math.sin(azimuth), Math.cos(elevation), Math.sin(elevation)];
  const back = [ce * ca, ce * sa, se], right = [-sa, ca, 0];
  return { right, up: cross(back, right), back };
}

class Camera {
  constructor(view) {
    this.home = view;
    this.reset();
  }

  reset() {
    const { low, high, azimuth, elevation } = this.home;
    this.target = low.map((x, i) => (x + high[i]) / 2);
    this.size = Math.hypot(...low.map((x, i) => high[i] - x)) / 2;
    this.angle = (28 * Math.PI) / 180;
    Object.assign(this, { azimuth, elevation, zoom: 1 });
  }

  // So far away that the box from low to high, seen as at the start, fits into the view.
  distance(aspect) {
    const { low, high, azimuth, elevation } = this.home, { right, up, back } = axes(azimuth, elevation);
    const half = high.map((x, i) => (x - low[i]) / 2), tangent = Math.tan(this.angle / 2);
    let fitting = 0;
    for (let corner = 0; corner < 8; corner++) {
      const place = half.map((x, i) => (corner & (1 << i) ? x : -x));
      const across = Math.max(Math.abs(dot(place, right)) / aspect, Math.abs(dot(place, up)) * MARGIN);
      fitting = Math.max(fitting, across / tangent + dot(place, back));
    }
    return (1.04 * fitting) / this.zoom;
  }

  axes() {
    return axes(this.azimuth, this.elevation);
  }

  turn(dx, dy) {
    this.azimuth -= dx * 0.008;
    this.elevation = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, this.elevation + dy * 0.008));
  }

  move(dx, dy, height, aspect) {
    const { right, up } = this.axes(), unitLength = 1 / this.pixels(height, aspect);
    this.target = plus(plus(this.target, right, -dx * unitLength), up, dy * unitLength);
  }

  // Pixels of a unit of length at the target.
  pixels(height, aspect) {
    return height / 2 / (this.distance(aspect) * Math.tan(this.angle / 2));
  }

  eye(aspect) {
    return plus(this.target, this.axes().back, this.distance(aspect));
  }

  // Column-major projection × view.
  matrix(aspect) {
    const { right, up, back } = this.axes(), eye = this.eye(aspect), far = this.distance(aspect);
    const near = Math.max(far - 6 * this.size, far / 200), end = far + 6 * this.size;
    const f = 1 / Math.tan(this.angle / 2), a = (end + near) / (near - end), b = (2 * end * near) / (near - end);
    const rows = [right.map((x) => (x * f) / aspect), up.map((x) => x * f), back.map((x) => x * a), back.map((x) => -x)];
    const shift = [-dot(rows[0], eye), -dot(rows[1], eye), -dot(rows[2], eye) + b, -dot(rows[3], eye)];
    return new Float32Array([0, 1, 2].flatMap((i) => rows.map((row) => row[i])).concat(shift));
  }
}
