// The page: play and pause, time, colour bar, scale bar, and the mouse.

const SECONDS = 12; // a run is played in about this time, at 10 to 30 frames a second
const UNITS = [[1, "m"], [1e-2, "cm"], [1e-3, "mm"], [1e-6, "µm"], [1e-9, "nm"]];
const element = (id) => document.getElementById(id);
const number = (x) => String(Number(x.toPrecision(3)));

class Player {
  constructor(facts, scene, camera) {
    Object.assign(this, { facts, scene, camera, frame: 0, playing: false, last: 0 });
    this.rate = Math.max(10, Math.min(30, facts.times.length / SECONDS));
    element("frame").max = facts.times.length - 1;
    element("frame").oninput = (event) => this.go(Number(event.target.value), false);
    element("play").onclick = () => this.toggle();
    window.onkeydown = (event) => this.key(event);
    this.colourBar("colours", facts.colour.label, facts.map);
    if (facts.curvature) {
      this.colourBar("curvature", facts.curvature.label, facts.curvature.map);
      this.limits("curvature", facts.curvature.ticks);
    }
    this.mouse(scene.canvas);
    new ResizeObserver(() => this.resize()).observe(scene.canvas);
    this.go(0, facts.times.length > 1);
    requestAnimationFrame((now) => this.tick(now));
  }

  toggle(playing = !this.playing) {
    this.playing = playing && this.facts.times.length > 1;
    element("play").classList.toggle("playing", this.playing);
    element("play").setAttribute("aria-label", this.playing ? "pause" : "play");
  }

  go(frame, playing = this.playing) {
    const count = this.facts.times.length;
    this.frame = ((frame % count) + count) % count;
    this.scene.show(this.frame);
    this.camera.follow(this.frame);
    element("frame").value = this.frame;
    const { factor, decimals, unit } = this.facts.clock;
    element("time").textContent = `t = ${(this.facts.times[this.frame] * factor).toFixed(decimals)}${unit}`;
    this.limits("colours", this.facts.colour.ticks);
    this.toggle(playing);
    this.stale = true;
  }

  key(event) {
    const keys = { " ": () => this.toggle(), ArrowRight: () => this.go(this.frame + 1, false),
      ArrowLeft: () => this.go(this.frame - 1, false), Home: () => this.go(0, false), End: () => this.go(-1, false) };
    if (keys[event.key] && event.target !== element("frame") && event.target !== element("play")) {
      event.preventDefault();
      keys[event.key]();
    }
  }

  tick(now) {
    if (this.playing && now - this.last >= 1000 / this.rate) {
      this.last = now;
      this.go(this.frame + 1);
    }
    if (this.stale) {
      this.scene.draw(this.camera);
      this.stale = false;
    }
    requestAnimationFrame((next) => this.tick(next));
  }

  resize() {
    const canvas = this.scene.canvas, sharp = Math.max(window.devicePixelRatio, 2);
    canvas.width = Math.max(1, Math.round(canvas.clientWidth * sharp));
    canvas.height = Math.max(1, Math.round(canvas.clientHeight * sharp));
    this.scaleBar();
    this.stale = true;
  }

  colourBar(id, label, map) {
    element(id).hidden = false;
    element(id).querySelector("figcaption").textContent = label;
    const context = element(id).querySelector("canvas").getContext("2d");
    map.forEach((rgb, i) => { context.fillStyle = `rgb(${rgb})`; context.fillRect((i * 256) / map.length, 0, 2, 1); });
  }

  limits(id, ticks) {
    element(id).querySelectorAll("span").forEach((span, i) => {
      span.textContent = number(ticks[Math.min(this.frame, ticks.length - 1)][i]);
    });
  }

  // A bar of 1, 2 or 5 times a power of ten metres, or units where these have no length, up to a sixth of the view.
  scaleBar() {
    const { clientWidth: wide, clientHeight: high } = this.scene.canvas, { metres } = this.facts;
    const pixels = this.camera.pixels(high, wide / high) / (metres || 1), longest = wide / 6 / pixels;
    const power = 10 ** Math.floor(Math.log10(longest));
    const length = [5, 2, 1].find((n) => n * power <= longest) * power;
    element("ruler").style.width = `${length * pixels}px`;
    element("length").textContent = metres ? inMetres(length) : number(length);
  }

  mouse(canvas) {
    const held = new Map();
    const changed = () => { this.scaleBar(); this.stale = true; };
    canvas.oncontextmenu = (event) => event.preventDefault();
    canvas.ondblclick = () => { this.camera.reset(); changed(); };
    canvas.onpointerdown = (event) => {
      canvas.setPointerCapture(event.pointerId);
      held.set(event.pointerId, [event.clientX, event.clientY]);
    };
    canvas.onpointerup = canvas.onpointercancel = (event) => held.delete(event.pointerId);
    canvas.onpointermove = (event) => {
      const before = held.get(event.pointerId);
      if (!before) return;
      const [dx, dy] = [event.clientX - before[0], event.clientY - before[1]];
      const { clientWidth: wide, clientHeight: high } = canvas;
      if (held.size === 2) this.pinch(held, event);
      else if (event.buttons & 6 || event.shiftKey) this.camera.move(dx, dy, high, wide / high);
      else this.camera.turn(dx, dy);
      held.set(event.pointerId, [event.clientX, event.clientY]);
      changed();
    };
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.camera.zoom *= Math.exp(-event.deltaY * 0.0012);
      changed();
    }, { passive: false });
  }

  pinch(held, event) {
    const other = [...held].find(([id]) => id !== event.pointerId)[1], before = held.get(event.pointerId);
    const apart = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]) || 1;
    this.camera.zoom *= apart([event.clientX, event.clientY]) / apart(before);
  }
}

function inMetres(length) {
  const [one, name] = UNITS.find(([size]) => length >= size * (1 - 1e-9)) || UNITS.at(-1);
  return `${number(length / one)} ${name}`;
}

async function start() {
  try {
    const facts = JSON.parse(element("facts").textContent);
    const scene = new Scene(element("view"), facts, await loaded(facts));
    window.player = new Player(facts, scene, new Camera(facts.view));
    element("message").textContent = "";
  } catch (error) {
    element("message").textContent = error.message;
    throw error;
  }
}

start();
