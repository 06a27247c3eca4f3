// Draws the weights of a vertex inside the cage as colours with contour lines, on triangles that move with the figure.

/** Returns the nodes of a grid inside loops and next to them, and the triangles between them. */
function fieldMesh({ loops, points }, size) {
  const box = boundsOf(pairs(points)), h = Math.max(box[2] - box[0], box[3] - box[1]) / size;
  const nx = Math.ceil((box[2] - box[0]) / h) + 3, ny = Math.ceil((box[3] - box[1]) / h) + 3;
  const x = i => box[0] + (i - 1) * h, y = j => box[1] + (j - 1) * h;
  const inside = new Uint8Array(nx * ny), number = new Int32Array(nx * ny).fill(-1), nodes = [], triangles = [];
  for (let j = 0; j < ny; ++j) for (let i = 0; i < nx; ++i) inside[j * nx + i] = isInside(loops, points, x(i), y(j)) ? 1 : 0;
  const node = (i, j) => {
    const at = j * nx + i;
    if (number[at] < 0) { number[at] = nodes.length / 2; nodes.push(x(i), y(j)); }
    return number[at];
  };
  // Keeps all cells with a point inside, and one more layer, so that triangles cover the cage's boundary.
  const near = (i, j) => {
    for (let v = Math.max(0, j - 1); v <= Math.min(ny - 1, j + 2); ++v)
      for (let u = Math.max(0, i - 1); u <= Math.min(nx - 1, i + 2); ++u) if (inside[v * nx + u]) return true;
    return false;
  };
  for (let j = 0; j + 1 < ny; ++j) {
    for (let i = 0; i + 1 < nx; ++i) {
      if (!near(i, j)) continue;
      const [a, b, c, d] = [node(i, j), node(i + 1, j), node(i, j + 1), node(i + 1, j + 1)];
      triangles.push(a, b, c, b, d, c);
    }
  }
  return { nodes: Float64Array.from(nodes), triangles: Uint32Array.from(triangles) };
}
function pairs(flat) {
  const all = [];
  for (let k = 0; k + 1 < flat.length; k += 2) all.push([flat[k], flat[k + 1]]);
  return all;
}

const FIELD_VERTEX = `#version 300 es
uniform vec4 frame; // scale, then offset, to clip coordinates
in vec2 place;
in float weight;
out float w;
void main() {
  w = weight;
  gl_Position = vec4(place * frame.xy + frame.zw, 0.0, 1.0);
}`;
const FIELD_FRAGMENT = `#version 300 es
precision highp float;
in float w;
out vec4 colour;
const vec3 pink = vec3(0.95, 0.42, 0.66), plum = vec3(0.5, 0.02, 0.36), blue = vec3(0.1, 0.32, 0.8);
/// Returns 1 within width pixels of the line x = 0, else 0, with a smooth edge. change: of x per pixel.
float line_at(float x, float change, float width) { return 1.0 - smoothstep(width - 0.6, width + 0.6, abs(x) / max(change, 1e-9)); }
void main() {
  float size = clamp(abs(w), 0.0, 1.0), level = w * 10.0, change = fwidth(w);
  vec3 c = w < 0.0 ? blue : mix(pink, plum, smoothstep(0.35, 1.0, size));
  float tenth = abs(level) > 0.5 ? line_at(level - round(level), 10.0 * change, 0.7) : 0.0, zero = line_at(w, change, 0.9);
  // On plateaus, where the weight does not change, there are no lines.
  float lines = change > 1e-5 ? max(0.5 * tenth, 0.5 * zero) : 0.0;
  float alpha = max(0.92 * smoothstep(0.0, w < 0.0 ? 0.2 : 0.5, size), lines);
  colour = vec4(mix(c, vec3(0.1, 0.12, 0.18), lines) * alpha, alpha);
}`;

function compileProgram(gl, vertexText, fragmentText) {
  const program = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertexText], [gl.FRAGMENT_SHADER, fragmentText]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  return program;
}

/** Draws fields with WebGL into its own canvas, from which views copy them. */
class FieldPainter {
  constructor() {
    this.canvas = document.createElement('canvas');
    const gl = this.gl = this.canvas.getContext('webgl2', { antialias: true, premultipliedAlpha: true, preserveDrawingBuffer: true });
    if (!gl) return;
    this.program = compileProgram(gl, FIELD_VERTEX, FIELD_FRAGMENT);
    this.places = gl.createBuffer();
    this.weights = gl.createBuffer();
    this.indices = gl.createBuffer();
  }

  /** frame: { scale, x, y } from the figure's coordinates to pixels of a canvas of width × height. */
  paint(mesh, places, weights, frame, width, height) {
    const gl = this.gl;
    if (!gl) return null;
    if (this.canvas.width !== width || this.canvas.height !== height) { this.canvas.width = width; this.canvas.height = height; }
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    gl.useProgram(this.program);
    gl.uniform4f(gl.getUniformLocation(this.program, 'frame'), 2 * frame.scale / width, -2 * frame.scale / height,
                 2 * frame.x / width - 1, 1 - 2 * frame.y / height);
    const feed = (buffer, name, data, size) => {
      const at = gl.getAttribLocation(this.program, name);
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, data, gl.STREAM_DRAW);
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, size, gl.FLOAT, false, 0, 0);
    };
    feed(this.places, 'place', Float32Array.from(places), 2);
    feed(this.weights, 'weight', Float32Array.from(weights), 1);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.indices);
    if (this.uploaded !== mesh) { gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, mesh.triangles, gl.STATIC_DRAW); this.uploaded = mesh; }
    gl.drawElements(gl.TRIANGLES, mesh.triangles.length, gl.UNSIGNED_INT, 0);
    return this.canvas;
  }
}
