// A small WebGL viewer: flat-shaded triangles and their edges from binary glTF, one part for each segment.

const VERTEX = `#version 300 es
in vec3 position;
uniform mat4 view;
uniform mat3 turn;
uniform float lift;
out vec3 seen;
void main() {
  gl_Position = view * vec4(position, 1.0);
  gl_Position.z -= lift;
  seen = turn * position;
}`;

// The normal comes from the derivatives of the position: flat shading without normals in the file.
const FRAGMENT = `#version 300 es
precision highp float;
in vec3 seen;
uniform vec4 colour;
uniform bool lit;
out vec4 shown;
void main() {
  float strength = 1.0;
  if (lit) {
    vec3 normal = normalize(cross(dFdx(seen), dFdy(seen)));
    normal *= normal.z < 0.0 ? -1.0 : 1.0;
    strength = 0.55 + 0.45 * max(dot(normal, normalize(vec3(-0.3, 0.6, 0.75))), 0.0);
  }
  shown = vec4(colour.rgb * strength, colour.a);
}`;

// Binary glTF as parts [{name, isLines, positions, indices, colour}]: what csgmesh writes, no more of the format.
export function parseGlb(buffer) {
  const data = new DataView(buffer);
  const jsonLength = data.getUint32(12, true);
  const document = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 20, jsonLength)));
  const start = 20 + jsonLength + 8;
  const array = (index) => {
    const accessor = document.accessors[index];
    const offset = start + (document.bufferViews[accessor.bufferView].byteOffset || 0) + (accessor.byteOffset || 0);
    const Kind = accessor.componentType === 5126 ? Float32Array : Uint32Array;
    return new Kind(buffer, offset, accessor.count * (accessor.type === "VEC3" ? 3 : 1));
  };
  return document.nodes.filter((node) => node.mesh !== undefined).flatMap((node) =>
    document.meshes[node.mesh].primitives.map((primitive) => ({
      name: node.name,
      isLines: primitive.mode === 1,
      positions: array(primitive.attributes.POSITION),
      indices: array(primitive.indices),
      colour: document.materials[primitive.material].pbrMetallicRoughness.baseColorFactor
        .map((value, k) => (k < 3 ? value ** (1 / 2.2) : value)),
    })));
}

export class Viewer {
  constructor(canvas, onPick) {
    this.canvas = canvas;
    this.onPick = onPick;
    this.parts = [];
    this.selected = null;
    this.azimuth = -0.57;
    this.elevation = 0.47;
    this.centre = [0, 0, 0];
    this.reach = 1;
    this.zoom = 1;
    this.shift = [0, 0];
    this.gl = canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
    if (this.gl) this.prepare();
    this.listen();
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  prepare() {
    const gl = this.gl;
    const program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    gl.useProgram(program);
    this.place = {};
    for (const name of ["view", "turn", "lift", "colour", "lit"]) this.place[name] = gl.getUniformLocation(program, name);
    this.position = gl.getAttribLocation(program, "position");
    gl.enable(gl.DEPTH_TEST);
    gl.clearColor(1, 1, 1, 1);
  }

  // Show other parts; the camera stays where it is unless `fit`.
  show(parts, fit) {
    const gl = this.gl;
    for (const part of this.parts) if (gl) [part.vertices, part.order].forEach((b) => gl.deleteBuffer(b));
    this.parts = parts.map((part) => {
      if (!gl) return part;
      const vertices = gl.createBuffer();
      gl.bindBuffer(gl.ARRAY_BUFFER, vertices);
      gl.bufferData(gl.ARRAY_BUFFER, part.positions, gl.STATIC_DRAW);
      const order = gl.createBuffer();
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, order);
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, part.indices, gl.STATIC_DRAW);
      return { ...part, vertices, order };
    });
    if (fit) this.fit();
    this.draw();
  }

  fit() {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (const { positions } of this.parts) {
      for (let k = 0; k < positions.length; k++) {
        low[k % 3] = Math.min(low[k % 3], positions[k]);
        high[k % 3] = Math.max(high[k % 3], positions[k]);
      }
    }
    if (low[0] > high[0]) return;
    this.centre = low.map((value, k) => (value + high[k]) / 2);
    this.reach = Math.hypot(...high.map((value, k) => value - low[k])) / 2 || 1;
    this.zoom = 1;
    this.shift = [0, 0];
  }

  // Rows of the rotation: right, up, towards the eye; z is up in the model. Azimuth 0 looks along +y.
  axes() {
    const [sa, ca] = [Math.sin(this.azimuth), Math.cos(this.azimuth)];
    const [se, ce] = [Math.sin(this.elevation), Math.cos(this.elevation)];
    return [[ca, -sa, 0], [sa * se, ca * se, ce], [-sa * ce, -ca * ce, se]];
  }

  draw() {
    const gl = this.gl;
    if (!gl) return;
    const ratio = window.devicePixelRatio || 1;
    this.canvas.width = Math.max(1, Math.round(this.canvas.clientWidth * ratio));
    this.canvas.height = Math.max(1, Math.round(this.canvas.clientHeight * ratio));
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const [right, up, eye] = this.axes();
    const [sx, sy] = this.scale();
    const depth = 1 / (2.5 * this.reach);
    const row = (axis, factor, shift) => [...axis.map((v) => v * factor), -factor * dot(axis, this.centre) + shift];
    const rows = [row(right, sx, this.shift[0]), row(up, sy, this.shift[1]), row(eye, -depth, 0), [0, 0, 0, 1]];
    gl.uniformMatrix4fv(this.place.view, false, [0, 1, 2, 3].flatMap((c) => rows.map((r) => r[c])));
    gl.uniformMatrix3fv(this.place.turn, false, [0, 1, 2].flatMap((c) => [right, up, eye].map((r) => r[c])));
    for (const part of [...this.parts.filter((p) => !isMark(p)), ...this.parts.filter(isMark)]) {
      if (isMark(part)) gl.disable(gl.DEPTH_TEST); else gl.enable(gl.DEPTH_TEST);
      const isChosen = this.selected !== null && part.name.split(" ")[0] === this.selected;
      const fades = this.selected !== null && !isChosen && !part.isLines;
      const colour = fades ? part.colour.map((v, k) => (k < 3 ? 0.35 * v + 0.6 : v)) : part.colour;
      gl.uniform4fv(this.place.colour, colour);
      gl.uniform1i(this.place.lit, part.isLines ? 0 : 1);
      gl.uniform1f(this.place.lift, part.isLines ? 0.002 : 0);
      gl.bindBuffer(gl.ARRAY_BUFFER, part.vertices);
      gl.enableVertexAttribArray(this.position);
      gl.vertexAttribPointer(this.position, 3, gl.FLOAT, false, 0, 0);
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, part.order);
      gl.drawElements(part.isLines ? gl.LINES : gl.TRIANGLES, part.indices.length, gl.UNSIGNED_INT, 0);
    }
  }

  scale() {
    const [wide, high] = [this.canvas.clientWidth || 1, this.canvas.clientHeight || 1];
    const factor = (0.95 * this.zoom) / this.reach;
    return wide > high ? [(factor * high) / wide, factor] : [factor, (factor * wide) / high];
  }

  select(name) {
    this.selected = name;
    this.draw();
  }

  // The name of the part under a point of the canvas, by casting a ray at every triangle.
  pick(x, y) {
    const [right, up, eye] = this.axes();
    const [sx, sy] = this.scale();
    const px = ((2 * x) / this.canvas.clientWidth - 1 - this.shift[0]) / sx + dot(right, this.centre);
    const py = (1 - (2 * y) / this.canvas.clientHeight - this.shift[1]) / sy + dot(up, this.centre);
    let best = -Infinity, found = null;
    for (const { isLines, positions, indices, name } of this.parts) {
      if (isLines) continue;
      for (let t = 0; t < indices.length; t += 3) {
        const [a, b, c] = [0, 1, 2].map((k) => {
          const p = positions.subarray(3 * indices[t + k], 3 * indices[t + k] + 3);
          return [dot(right, p) - px, dot(up, p) - py, dot(eye, p)];
        });
        const [wa, wb, wc] = [cross(b, c), cross(c, a), cross(a, b)];
        const area = wa + wb + wc;
        if (area === 0 || wa / area < 0 || wb / area < 0 || wc / area < 0) continue;
        const near = (wa * a[2] + wb * b[2] + wc * c[2]) / area;
        if (near > best) [best, found] = [near, name];
      }
    }
    return found;
  }

  listen() {
    let last = null, moved = 0;
    const canvas = this.canvas;
    canvas.addEventListener("pointerdown", (event) => {
      last = [event.clientX, event.clientY];
      moved = 0;
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!last) return;
      const [dx, dy] = [event.clientX - last[0], event.clientY - last[1]];
      last = [event.clientX, event.clientY];
      moved += Math.abs(dx) + Math.abs(dy);
      if (event.shiftKey) {
        this.shift[0] += (2 * dx) / canvas.clientWidth;
        this.shift[1] -= (2 * dy) / canvas.clientHeight;
      } else {
        this.turn(dx * 0.008, dy * 0.008);
      }
      this.draw();
    });
    canvas.addEventListener("pointerup", (event) => {
      const isClick = last && moved < 4;
      last = null;
      if (isClick) this.onPick(this.pick(event.offsetX, event.offsetY));
    });
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom = Math.min(Math.max(this.zoom * Math.exp(-event.deltaY * 0.0012), 0.05), 200);
      this.draw();
    }, { passive: false });
    canvas.addEventListener("dblclick", () => { this.fit(); this.draw(); });
    canvas.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[event.key];
      if (step) { event.preventDefault(); this.turn(...step); this.draw(); }
    });
  }

  turn(sideways, upwards) {
    this.azimuth += sideways;
    this.elevation = Math.min(Math.max(this.elevation + upwards, -Math.PI / 2), Math.PI / 2);
  }
}

// Couplings are drawn last and over everything: most lie within a wall or beneath one.
const isMark = (part) => /^(rbe2|rbe3|mpc) edges$/.test(part.name);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => a[0] * b[1] - a[1] * b[0];
