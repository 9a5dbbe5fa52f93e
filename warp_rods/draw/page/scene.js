// What is drawn, in WebGL 2: rods, then the edges of a box, then membranes, which one sees through.

const TEXTURE_WIDTH = 1024;
const GREY = [0.6, 0.66, 0.76]; // of a surface without colours of its own
const BOX = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]];
const BOX_FACES = [0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4, 1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7];

class Scene {
  constructor(canvas, facts, data) {
    this.gl = canvas.getContext("webgl2", { alpha: false, antialias: true });
    if (!this.gl) throw new Error("This browser has no WebGL 2, which the page needs.");
    this.canvas = canvas;
    this.facts = facts;
    this.rodProgram = this.program(ROD_VERTEX, ROD_FRAGMENT);
    this.sheetProgram = this.program(SHEET_VERTEX, SHEET_FRAGMENT);
    this.lineProgram = this.program(SHEET_VERTEX, LINE_FRAGMENT);
    this.capsule = this.capsuleBox();
    this.colours = this.colourMap(facts.map);
    this.rods = data.rods.map((ensemble) => ({ ...ensemble, pointTexture: this.texture(), valueTexture: this.texture() }));
    this.sheets = data.sheets.map((sheet) => this.sheet(sheet));
    this.edges = facts.edges.length ? this.lines(facts.edges.flat()) : null;
    this.trails = facts.view.trails.map((path) => this.lines(path));
  }

  program(vertex, fragment) {
    const gl = this.gl, program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
    return program;
  }

  texture() {
    const gl = this.gl, made = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, made);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.NEAREST);
    for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
    return made;
  }

  colourMap(map) {
    const gl = this.gl, made = this.texture();
    const rgba = Uint8Array.from({ length: 4 * map.length }, (_, k) => (k % 4 < 3 ? map[k >> 2][k % 4] : 255));
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, map.length, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, rgba);
    return made;
  }

  // Whole numbers of each node into a texture; the last row is filled up.
  fill(texture, numbers, channels) {
    const gl = this.gl, rows = Math.ceil(numbers.length / channels / TEXTURE_WIDTH);
    const padded = new numbers.constructor(rows * TEXTURE_WIDTH * channels);
    padded.set(numbers);
    const [inside, format, kind] = channels === 3 ? [gl.RGB16UI, gl.RGB_INTEGER, gl.UNSIGNED_SHORT]
      : [gl.R8UI, gl.RED_INTEGER, gl.UNSIGNED_BYTE];
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texImage2D(gl.TEXTURE_2D, 0, inside, TEXTURE_WIDTH, rows, 0, format, kind, padded);
  }

  attribute(program, name, numbers, usage) {
    const gl = this.gl, buffer = gl.createBuffer(), place = gl.getAttribLocation(program, name);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, numbers, usage);
    if (place >= 0) {
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, 3, gl.FLOAT, false, 0, 0);
    }
    return buffer;
  }

  indices(numbers) {
    const gl = this.gl;
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, numbers, gl.STATIC_DRAW);
  }

  capsuleBox() {
    const gl = this.gl, array = gl.createVertexArray();
    gl.bindVertexArray(array);
    this.attribute(this.rodProgram, "corner", new Float32Array(BOX.flat()), gl.STATIC_DRAW);
    this.indices(new Uint16Array(BOX_FACES));
    return array;
  }

  sheet(sheet) {
    const gl = this.gl, array = gl.createVertexArray(), room = new Float32Array(sheet.points[0].length);
    gl.bindVertexArray(array);
    const points = this.attribute(this.sheetProgram, "point", room, gl.DYNAMIC_DRAW);
    const normals = this.attribute(this.sheetProgram, "normal", room, gl.DYNAMIC_DRAW);
    const tints = this.attribute(this.sheetProgram, "tint", room, gl.DYNAMIC_DRAW);
    this.indices(sheet.triangles);
    return { ...sheet, array, shown: -1, buffers: { points, normals, tints } };
  }

  lines(points) {
    const array = this.gl.createVertexArray();
    this.gl.bindVertexArray(array);
    this.attribute(this.lineProgram, "point", new Float32Array(points.flat()), this.gl.STATIC_DRAW);
    return { array, count: points.length };
  }

  // Take the numbers of a frame to the graphics processor.
  show(frame) {
    this.frame = frame;
    for (const rods of this.rods) {
      this.fill(rods.pointTexture, rodPoints(rods.points, frame, rods.rods, rods.nodes), 3);
      this.fill(rods.valueTexture, rodValues(rods.values, frame, rods.rods, rods.nodes), 1);
      rods.box = rods.boxes[frame];
    }
    for (const sheet of this.sheets) this.showSheet(sheet, Math.min(frame, sheet.frames - 1));
  }

  showSheet(sheet, frame) {
    if (sheet.shown === frame) return;
    const gl = this.gl, [low, spacing] = sheet.box;
    const points = Float32Array.from(sheet.points[frame], (n, k) => low[k % 3] + spacing[k % 3] * n);
    gl.bindBuffer(gl.ARRAY_BUFFER, sheet.buffers.points);
    gl.bufferSubData(gl.ARRAY_BUFFER, 0, points);
    gl.bindBuffer(gl.ARRAY_BUFFER, sheet.buffers.normals);
    gl.bufferSubData(gl.ARRAY_BUFFER, 0, normalsOf(points, sheet.triangles));
    gl.bindBuffer(gl.ARRAY_BUFFER, sheet.buffers.tints);
    gl.bufferSubData(gl.ARRAY_BUFFER, 0, this.tints(sheet, frame));
    sheet.shown = frame;
  }

  // Colours [point × 3] of a membrane by its curvature, or the same grey for all points.
  tints(sheet, frame) {
    if (!sheet.tints) return Float32Array.from({ length: sheet.points[0].length }, (_, k) => GREY[k % 3]);
    const levels = rodValues(sheet.tints, frame, 1, sheet.points[0].length / 3), { map } = this.facts.curvature;
    return Float32Array.from({ length: 3 * levels.length }, (_, k) => map[levels[Math.floor(k / 3)]][k % 3] / 255);
  }

  draw(camera) {
    const gl = this.gl, canvas = this.canvas, aspect = canvas.width / canvas.height;
    const { right, up, back } = camera.axes();
    const common = { matrix: camera.matrix(aspect), eye: camera.eye(aspect),
      key: unit(plus(plus(back, right, -0.45), up, 0.7)), lacking: this.facts.lacking };
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(1, 1, 1, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.disable(gl.BLEND);
    this.drawRods(common);
    this.drawLines(common);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    this.drawSheets(common);
    gl.depthMask(true);
  }

  use(program, uniforms) {
    const gl = this.gl;
    gl.useProgram(program);
    for (const [name, value] of Object.entries(uniforms)) {
      const place = gl.getUniformLocation(program, name);
      if (value.length === 16) gl.uniformMatrix4fv(place, false, value);
      else if (value.length === 3) gl.uniform3fv(place, value);
      else gl.uniform1f(place, value);
    }
  }

  drawRods(common) {
    const gl = this.gl;
    gl.enable(gl.CULL_FACE);
    gl.cullFace(gl.FRONT); // the far faces of the boxes: drawn once, and also when the eye is inside
    gl.bindVertexArray(this.capsule);
    for (const rods of this.rods) {
      this.use(this.rodProgram, { ...common, radius: rods.radius, low: rods.box[0], spacing: rods.box[1] });
      const textures = { points: rods.pointTexture, values: rods.valueTexture, colours: this.colours };
      Object.entries(textures).forEach(([name, texture], slot) => {
        gl.activeTexture(gl.TEXTURE0 + slot);
        gl.bindTexture(gl.TEXTURE_2D, texture);
        gl.uniform1i(gl.getUniformLocation(this.rodProgram, name), slot);
      });
      gl.activeTexture(gl.TEXTURE0);
      gl.uniform1i(gl.getUniformLocation(this.rodProgram, "nodes"), rods.nodes);
      gl.uniform1i(gl.getUniformLocation(this.rodProgram, "width"), TEXTURE_WIDTH);
      gl.drawElementsInstanced(gl.TRIANGLES, 36, gl.UNSIGNED_SHORT, 0, rods.rods * (rods.nodes - 1));
    }
    gl.disable(gl.CULL_FACE);
  }

  // The edges of the box, and where rods that travel have been.
  drawLines(common) {
    const gl = this.gl;
    this.use(this.lineProgram, common);
    if (this.edges) {
      gl.bindVertexArray(this.edges.array);
      gl.drawArrays(gl.LINES, 0, this.edges.count);
    }
    for (const trail of this.trails) {
      gl.bindVertexArray(trail.array);
      gl.drawArrays(gl.LINE_STRIP, 0, this.frame + 1);
    }
  }

  drawSheets(common) {
    const gl = this.gl;
    gl.enable(gl.CULL_FACE);
    for (const face of [gl.FRONT, gl.BACK]) { // what is behind first
      gl.cullFace(face);
      for (const sheet of this.sheets) {
        this.use(this.sheetProgram, { ...common, opacity: sheet.opacity });
        gl.bindVertexArray(sheet.array);
        gl.drawElements(gl.TRIANGLES, sheet.triangles.length, gl.UNSIGNED_INT, 0);
      }
    }
    gl.disable(gl.CULL_FACE);
  }
}
