// Vectors, and a camera that turns about a point.

const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const plus = (a, b, factor = 1) => a.map((x, i) => x + factor * b[i]);
const unit = (a) => a.map((x) => x / Math.hypot(...a));

const MARGIN = 1.16; // room above and below for the title and the controls

class Camera {
  // view: direction towards the viewer, half width, height and depth of what is seen, and its centre at each frame.
  constructor(view) {
    this.home = view;
    this.size = Math.hypot(...view.half);
    this.angle = (28 * Math.PI) / 180;
    const above = Math.abs(view.back[2]) > 0.9; // the pole, about which one turns, points up in the view
    this.frame = above ? [[0, 0, 1], [1, 0, 0], [0, 1, 0]] : [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    this.centre = view.centres[0];
    this.reset();
  }

  reset() {
    const [x, y, pole] = this.frame, { back } = this.home;
    this.azimuth = Math.atan2(dot(back, y), dot(back, x));
    this.elevation = Math.asin(Math.max(-1, Math.min(1, dot(back, pole))));
    this.shift = [0, 0, 0];
    this.zoom = 1;
  }

  // Go with rods that travel.
  follow(frame) {
    const { centres } = this.home;
    this.centre = centres[Math.min(frame, centres.length - 1)];
  }

  get target() {
    return plus(this.centre, this.shift);
  }

  // So far away that what is to be seen fits into the view.
  distance(aspect) {
    const [wide, high, deep] = this.home.half;
    return (Math.max(wide / aspect, high * MARGIN) / Math.tan(this.angle / 2) + deep) / this.zoom;
  }

  axes() {
    const [ca, sa, ce, se] = [Math.cos(this.azimuth), Math.sin(this.azimuth), Math.cos(this.elevation),
      Math.sin(this.elevation)];
    const [x, y, pole] = this.frame, mix = (a, b, c) => plus(plus(plus([0, 0, 0], x, a), y, b), pole, c);
    const back = mix(ce * ca, ce * sa, se), right = mix(-sa, ca, 0);
    return { right, up: cross(back, right), back };
  }

  turn(dx, dy) {
    this.azimuth -= dx * 0.008;
    this.elevation = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, this.elevation + dy * 0.008));
  }

  move(dx, dy, height, aspect) {
    const { right, up } = this.axes(), unitLength = 1 / this.pixels(height, aspect);
    this.shift = plus(plus(this.shift, right, -dx * unitLength), up, dy * unitLength);
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
