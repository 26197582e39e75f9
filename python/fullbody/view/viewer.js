"use strict";
// Bodies of ellipsoids and polyhedra with their axes and paths in WebGL. Positions are from the barycentre, attitudes are unit quaternions
// [w, x, y, z] that rotate body axes into inertial ones; between samples both are interpolated.
// Seconds that a whole run takes at speed 1.
const SECONDS = 30;
const COLOURS = [[0.45, 0.68, 0.85], [0.95, 0.65, 0.4], [0.75, 0.75, 0.75], [0.5, 0.75, 0.6], [0.85, 0.65, 0.75]];
const AXES = [[0, 0.447, 0.698], [0.902, 0.624, 0], [0, 0, 0]];
const SURFACE = `attribute vec3 point; uniform mat4 camera; uniform mat3 columns, normals; uniform vec3 centre;
varying vec3 normal; varying vec3 ball; varying vec3 site;
void main() { ball = normalize(point); normal = normals * point; site = columns * point + centre;
  gl_Position = camera * vec4(site, 1.0); }`;
// Ellipsoids that cast shadows, at most.
const CASTS = 16;
// A net of meridians and parallels shows the turning of a body whose outline does not change.
const SHADE = `#extension GL_OES_standard_derivatives : enable
precision highp float; varying vec3 normal; varying vec3 ball; varying vec3 site; uniform vec3 colour, light; uniform bool faceted;
uniform bool sunlit; uniform mat3 balls[${CASTS}]; uniform vec3 standing[${CASTS}]; uniform int casts, own;
bool shadowed() {  // whether the way to the Sun goes through an ellipsoid
  for (int k = 0; k < ${CASTS}; k++) {
    if (k >= casts) break;
    if (k == own) continue;
    vec3 p = balls[k] * (site - standing[k]), d = balls[k] * light;
    float along = dot(p, d);
    if (along < 0.0 && along * along > dot(d, d) * (dot(p, p) - 1.0)) return true;
  }
  return false;
}
void main() { vec3 up = faceted ? cross(dFdx(site), dFdy(site)) : normal;  // that of a face looks at the eye
  float height = max(dot(normalize(up), light), 0.0);
  float lit = sunlit ? 0.12 + (shadowed() ? 0.0 : 0.88 * height) : 0.45 + 0.55 * height;
  float lon = atan(ball.y, ball.x) * 3.8197186, lat = asin(clamp(ball.z, -1.0, 1.0)) * 3.8197186;
  float wide = sqrt(max(1.0 - ball.z * ball.z, 0.0)), pixel = 3.8197186 * length(fwidth(ball));
  float net = min(abs(fract(lon + 0.5) - 0.5) * wide, abs(fract(lat + 0.5) - 0.5));
  float ink = (1.0 - smoothstep(0.02, 0.03 + 0.7 * pixel, net)) * min(1.0, 0.2 / pixel);
  gl_FragColor = vec4(colour * lit * (1.0 - 0.3 * ink), 1.0); }`;
const LINE = `attribute vec3 point; uniform mat4 camera; uniform vec3 shift;
void main() { gl_Position = camera * vec4(point + shift, 1.0); gl_PointSize = 4.0; }`;
const FLAT = `precision mediump float; uniform vec3 colour; void main() { gl_FragColor = vec4(colour, 1.0); }`;

function unpack(text, Kind) {  // base64, or an array as it is
  if (typeof text !== "string") return text;
  const bytes = Uint8Array.from(atob(text), c => c.charCodeAt(0));
  return new Kind(bytes.buffer);
}

function matrix([w, x, y, z]) {  // columns, as WebGL wants them
  return [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y),
    2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x),
    2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)];
}

function apply(rotation, v) {  // of columns one after the other
  return [0, 1, 2].map(r => rotation[r] * v[0] + rotation[3 + r] * v[1] + rotation[6 + r] * v[2]);
}

function slerp(p, q, s) {  // the shorter way
  let cosine = p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3];
  const sign = cosine < 0 ? -1 : 1;
  const angle = Math.acos(Math.min(1, cosine * sign)), sine = Math.sin(angle);
  const [u, v] = sine < 1e-6 ? [1 - s, s] : [Math.sin((1 - s) * angle) / sine, Math.sin(s * angle) / sine];
  return p.map((value, k) => u * value + sign * v * q[k]);
}

function program(gl, vertex, fragment) {
  const made = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  return made;
}

function buffer(gl, values) {
  const made = gl.createBuffer();
  gl.bindBuffer(gl.ARRAY_BUFFER, made);
  gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(values), gl.STATIC_DRAW);
  return made;
}

function sphere(across, down) {
  const at = (i, j) => {
    const u = 2 * Math.PI * i / across, v = Math.PI * j / down;
    return [Math.cos(u) * Math.sin(v), Math.sin(u) * Math.sin(v), Math.cos(v)];
  };
  const points = [];
  for (let i = 0; i < across; i++) for (let j = 0; j < down; j++)
    points.push(...at(i, j), ...at(i, j + 1), ...at(i + 1, j), ...at(i + 1, j), ...at(i, j + 1), ...at(i + 1, j + 1));
  return points;
}

const DOT = [0.75, 0.15, 0.1], TRAIL = [0.85, 0.6, 0.55];
// Samples of the flight behind a dot that are its trail.
const BEHIND = 40;

function particles({ count, time, position, landed, parts }) {  // dots and trails at a time, as points and as pairs of points
  const times = unpack(time, Float64Array), positions = unpack(position, Float32Array), samples = times.length;
  const ends = unpack(landed, Float64Array);
  const back = times[samples - 1] < times[0];
  const index = (p, k) => 3 * (p * samples + k);
  return t => {
    const dots = [], trails = [];
    if ((t < times[0]) !== back && t !== times[0]) return { dots, trails };
    let low = 0, high = samples - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if ((times[middle] <= t) !== back) low = middle; else high = middle;
    }
    const s = Math.min(1, Math.max(0, (t - times[low]) / (times[high] - times[low])));
    for (let p = 0; p < count; p++) {
      const from = index(p, low), to = index(p, high);
      // One that is gone has no position.
      if (!(positions[from] === positions[from] && positions[to] === positions[to])) continue;
      const now = [0, 1, 2].map(c => positions[from + c] + s * (positions[to + c] - positions[from + c]));
      dots.push(...now);
      // What lies on a body moves with it, and leaves no trail.
      if (back ? t <= ends[p] : t >= ends[p]) continue;
      let last = now;
      for (let k = low; k >= Math.max(0, low - BEHIND * parts); k--) {
        const next = Array.from(positions.subarray(index(p, k), index(p, k) + 3));
        trails.push(...last, ...next);
        last = next;
      }
    }
    return { dots, trails };
  };
}

const LAYOUT = `<div class="fullbody-stage"><canvas class="fullbody-canvas"></canvas>
<div class="fullbody-key"></div>
<div class="fullbody-scale"><b></b><span></span></div></div>
<div class="fullbody-bar">
<button class="fullbody-play">Play</button>
<input class="fullbody-slider" type="range" min="0" max="1" step="any" value="0" aria-label="time">
<span class="fullbody-time"></span>
<label>follow <select class="fullbody-follow"></select></label>
<label>view from <select class="fullbody-from"><option value="">camera</option><option value="observer">observer</option>
<option value="sun">Sun</option></select></label>
<label><input class="fullbody-trails" type="checkbox" checked> trails</label>
<label title="At speed 1 the whole run takes 30 seconds.">speed <select class="fullbody-speed"><option value="0.25">1/4 (2 min)</option>
<option value="0.5">1/2 (1 min)</option><option value="1" selected>1 (30 s)</option><option value="2">2 (15 s)</option>
<option value="4">4 (8 s)</option></select></label>
</div>`;

// Makes a scene within an element. `load(data)` shows a run, `seek(part)` one of its times as a part of the run from 0 to 1, and
// `onTime(part)` is called whenever another time is shown. Without WebGL the scene says so, and loads nothing.
function scene(root, onTime = () => {}) {
  root.classList.add("fullbody-scene");
  root.innerHTML = LAYOUT;
  const element = name => root.querySelector(`.fullbody-${name}`);
  const canvas = element("canvas");
  const gl = canvas.getContext("webgl", { antialias: true, preserveDrawingBuffer: true });
  if (!gl) {
    element("stage").innerHTML = '<p class="fullbody-fault">This picture needs WebGL, which this browser does not offer.</p>';
    return { load() {}, seek() {} };
  }
  gl.getExtension("OES_standard_derivatives");
  const solid = program(gl, SURFACE, SHADE), flat = program(gl, LINE, FLAT);
  const ball = sphere(48, 24), round = { buffer: buffer(gl, ball), count: ball.length / 3 };
  const spare = gl.createBuffer();
  gl.enable(gl.DEPTH_TEST);
  let data, time, position, toward, attitude, many, samples, reach, largest, sizes, surfaces, shapes = [], paths = [], cloud;
  const looks = { azimuth: -1.0, height: 0.45, distance: 0, follow: -1 };
  let part = 0, playing = false, last = 0;
  const trailed = element("trails");
  trailed.onchange = () => draw();
  const centre = (k, b) => Array.from(position.subarray(3 * (k * many + b), 3 * (k * many + b) + 3));
  const quaternion = (k, b) => Array.from(attitude.subarray(4 * (k * many + b), 4 * (k * many + b) + 4));
  const key = (name, colour, dash) => {
    const row = document.createElement("div"), mark = document.createElement("i");
    mark.style.background = `rgb(${colour.map(c => Math.round(255 * c))})`;
    if (dash) Object.assign(mark.style, { height: "3px", border: "0", verticalAlign: ".25em" });
    row.append(mark, name);
    element("key").append(row);
  };

  function load(next) {
    const names = data && data.names, before = reach;
    data = next;
    [time, position, attitude] = [unpack(data.time, Float64Array), unpack(data.position, Float32Array), unpack(data.attitude, Float32Array)];
    toward = Object.fromEntries(["sun", "observer"].filter(to => data[to]).map(to => [to, unpack(data[to], Float32Array)]));
    for (const option of element("from").options) option.hidden = option.value && !toward[option.value];
    element("from").parentElement.hidden = !toward.observer;
    if (!toward[element("from").value]) element("from").value = "";
    [many, samples, reach, largest] = [data.names.length, time.length, 0, 0];
    for (let k = 0; k < samples; k++) for (let b = 0; b < many; b++) reach = Math.max(reach, Math.hypot(...centre(k, b)));
    const size = part => Math.hypot(...part.position) + Math.max(...[0, 3, 6].map(c => Math.hypot(...part.columns.slice(c, c + 3))));
    sizes = data.surfaces.map(parts => Math.max(0, ...parts.map(size)));
    largest = Math.max(largest, ...sizes);
    reach = Math.max(reach, largest) || 1;
    // A point has no size: a small ball stands for it.
    const small = 0.012 * reach, dot = { columns: [small, 0, 0, 0, small, 0, 0, 0, small], position: [0, 0, 0] };
    surfaces = data.surfaces.map(parts => parts.length ? parts : [dot]);
    for (const shape of shapes.flat()) if (shape !== round) gl.deleteBuffer(shape.buffer);
    for (const path of paths) gl.deleteBuffer(path);
    shapes = surfaces.map(parts => parts.map(part => {
      if (!part.triangles) return round;
      const corners = unpack(part.triangles, Float32Array);
      return { buffer: buffer(gl, corners), count: corners.length / 3, faceted: true };
    }));
    paths = data.names.map((_, b) => {
      const points = [];
      for (let k = 0; k < samples; k++) points.push(...centre(k, b));
      return buffer(gl, points);
    });
    cloud = data.particles ? particles(data.particles) : null;
    trailed.parentElement.hidden = !cloud;
    // The camera stays where the reader has moved it, unless the scene has another size or other bodies.
    if (!before || reach > 2 * before || reach < 0.5 * before) looks.distance = 3.4 * reach;
    if (!names || names.join("\n") !== data.names.join("\n")) {
      looks.follow = -1;
      element("follow").replaceChildren(...[[-1, "barycentre"], ...data.names.map((name, b) => [b, name])].map(([value, name]) => {
        const option = document.createElement("option");
        option.value = value;
        option.textContent = name;
        return option;
      }));
      element("key").replaceChildren();
      data.names.forEach((name, b) => key(name, COLOURS[b % COLOURS.length]));
      ["x", "y", "z"].forEach((name, c) => key(`body ${name}`, AXES[c], true));
      if (cloud) key(data.particles.count === 1 ? "particle" : `${data.particles.count} particles`, DOT);
    }
    draw();
  }

  function now() {  // the state at the slider's time, between two samples
    const t = time[0] + part * (time[samples - 1] - time[0]), back = time[samples - 1] < time[0];
    let low = 0, high = samples - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if ((time[middle] <= t) !== back) low = middle; else high = middle;
    }
    const s = high > low ? Math.min(1, Math.max(0, (t - time[low]) / (time[high] - time[low]))) : 0;
    const bodies = data.names.map((_, b) => {
      const from = centre(low, b), to = centre(high, b);
      return { centre: from.map((v, c) => v + s * (to[c] - v)), rotation: matrix(slerp(quaternion(low, b), quaternion(high, b), s)) };
    });
    const direction = to => toward[to] && [0, 1, 2].map(c => {
      const [from, until] = [low, high].map(k => toward[to][3 * k + c]);
      return from + s * (until - from);
    });
    return { t, bodies, sun: direction("sun"), observer: direction("observer") };
  }

  function camera(target, aspect, toward) {
    const { azimuth, height, distance: d } = looks;
    const a = toward ? Math.atan2(toward[1], toward[0]) : azimuth, h = toward ? Math.asin(toward[2] / Math.hypot(...toward)) : height;
    const back = [Math.cos(h) * Math.cos(a), Math.cos(h) * Math.sin(a), Math.sin(h)];
    const right = [-Math.sin(a), Math.cos(a), 0];
    const up = [-Math.sin(h) * Math.cos(a), -Math.sin(h) * Math.sin(a), Math.cos(h)];
    const eye = target.map((v, c) => v + d * back[c]), dot = (p, q) => p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    const f = 2.6, near = 0.02 * d, far = d + 6 * reach, rows = [right, up, back];
    const view = rows.map(r => [...r, -dot(r, eye)]);
    const zoom = [f / Math.max(aspect, 1), f * Math.min(aspect, 1)];
    const m = [view[0].map(v => v * zoom[0]), view[1].map(v => v * zoom[1]),
      view[2].map((v, c) => -(far + near) / (far - near) * v - (c === 3 ? 2 * far * near / (far - near) : 0)),
      view[2].map(v => -v)];
    const columns = [];
    for (let c = 0; c < 4; c++) for (let r = 0; r < 4; r++) columns.push(m[r][c]);
    return { columns, back, up, right, perPixel: 2 * d / (zoom[1] * canvas.clientHeight) };
  }

  function strip(points, count, mode, colour, shift, view) {
    gl.useProgram(flat);
    gl.bindBuffer(gl.ARRAY_BUFFER, points);
    const at = gl.getAttribLocation(flat, "point");
    gl.enableVertexAttribArray(at);
    gl.vertexAttribPointer(at, 3, gl.FLOAT, false, 0, 0);
    gl.uniformMatrix4fv(gl.getUniformLocation(flat, "camera"), false, view.columns);
    gl.uniform3fv(gl.getUniformLocation(flat, "colour"), colour);
    gl.uniform3fv(gl.getUniformLocation(flat, "shift"), shift);
    gl.drawArrays(mode, 0, count);
  }

  function draw() {
    const ratio = window.devicePixelRatio || 1;
    canvas.width = canvas.clientWidth * ratio;
    canvas.height = canvas.clientHeight * ratio;
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0.969, 0.969, 0.961, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const { t, bodies, sun, observer } = now();
    const target = looks.follow < 0 ? [0, 0, 0] : bodies[looks.follow].centre;
    const view = camera(target, canvas.width / canvas.height, { sun, observer }[element("from").value]);
    const light = sun || [0, 1, 2].map(c => 0.75 * view.back[c] + 0.5 * view.up[c] + 0.43 * view.right[c]);
    // A matrix to the unit sphere of an ellipsoid, from the bodies' axes, times the rotation back.
    const shadows = (data.casts || []).flatMap((parts, b) => parts.map((part, p) => ({
      body: b, part: p, standing: apply(bodies[b].rotation, part.position).map((v, c) => v + bodies[b].centre[c]),
      inverse: [0, 1, 2].flatMap(c => apply(part.inverse, [0, 3, 6].map(k => bodies[b].rotation[c + k])))
    }))).slice(0, CASTS);
    bodies.forEach((body, b) => {
      gl.useProgram(solid);
      const at = gl.getAttribLocation(solid, "point"), uniform = name => gl.getUniformLocation(solid, name);
      gl.enableVertexAttribArray(at);
      gl.uniformMatrix4fv(uniform("camera"), false, view.columns);
      gl.uniform3fv(uniform("colour"), COLOURS[b % COLOURS.length]);
      gl.uniform3fv(uniform("light"), light);
      gl.uniform1i(uniform("sunlit"), sun ? 1 : 0);
      gl.uniform1i(uniform("casts"), shadows.length);
      if (shadows.length) {
        gl.uniformMatrix3fv(uniform("balls"), false, shadows.flatMap(one => one.inverse));
        gl.uniform3fv(uniform("standing"), shadows.flatMap(one => one.standing));
      }
      surfaces[b].forEach((part, p) => {
        const shape = shapes[b][p];
        gl.bindBuffer(gl.ARRAY_BUFFER, shape.buffer);
        gl.vertexAttribPointer(at, 3, gl.FLOAT, false, 0, 0);
        gl.uniform1i(uniform("faceted"), shape.faceted ? 1 : 0);
        gl.uniform1i(uniform("own"), shadows.findIndex(one => one.body === b && one.part === p));
        const columns = [0, 3, 6].map(c => apply(body.rotation, part.columns.slice(c, c + 3)));
        // The columns are orthogonal: a normal is along the columns over their squared lengths.
        const normals = columns.map(v => v.map(x => x / (v[0] * v[0] + v[1] * v[1] + v[2] * v[2])));
        gl.uniformMatrix3fv(uniform("columns"), false, columns.flat());
        gl.uniformMatrix3fv(uniform("normals"), false, normals.flat());
        gl.uniform3fv(uniform("centre"), apply(body.rotation, part.position).map((v, c) => v + body.centre[c]));
        gl.drawArrays(gl.TRIANGLES, 0, shape.count);
      });
      strip(paths[b], samples, gl.LINE_STRIP, b ? [0.55, 0.5, 0.45] : [0.45, 0.5, 0.55], [0, 0, 0], view);
      if (!data.surfaces[b].length) return;
      for (let c = 0; c < 3; c++) {
        // Lines are a pixel wide everywhere: a thin cross of ribbons is seen from every side.
        const out = body.rotation.slice(3 * c, 3 * c + 3), length = 1.6 * sizes[b], half = 0.012 * length;
        const points = [];
        for (const n of [1, 2]) {
          const side = body.rotation.slice(3 * ((c + n) % 3), 3 * ((c + n) % 3) + 3);
          for (const [u, v] of [[0, -1], [0, 1], [1, -1], [1, -1], [0, 1], [1, 1]])
            points.push(...out.map((value, k) => value * u * length + side[k] * v * half));
        }
        gl.bindBuffer(gl.ARRAY_BUFFER, spare);
        gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(points), gl.DYNAMIC_DRAW);
        strip(spare, 12, gl.TRIANGLES, AXES[c], body.centre, view);
      }
    });
    if (cloud) {
      const { dots, trails } = cloud(t);
      for (const [points, mode, colour] of [[trailed.checked ? trails : [], gl.LINES, TRAIL], [dots, gl.POINTS, DOT]]) {
        gl.bindBuffer(gl.ARRAY_BUFFER, spare);
        gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(points), gl.DYNAMIC_DRAW);
        strip(spare, points.length / 3, mode, colour, [0, 0, 0], view);
      }
    }
    element("time").textContent = `time ${t.toPrecision(6)} ${data.unit}`;
    element("slider").value = part;
    onTime(part);
    const wish = 120 * view.perPixel, ten = 10 ** Math.floor(Math.log10(wish));
    const nice = [5, 2, 1].find(n => n * ten <= wish) * ten;
    element("scale").querySelector("b").style.width = `${nice / view.perPixel}px`;
    element("scale").querySelector("span").textContent = `${+nice.toPrecision(3)} ${data.length}`;
  }

  function tick(stamp) {
    if (!playing) return;
    part += (stamp - last) / 1000 / SECONDS * element("speed").value;
    last = stamp;
    if (part >= 1) part = 0;
    draw();
    requestAnimationFrame(tick);
  }
  function play(on) {
    playing = on;
    element("play").textContent = on ? "Pause" : "Play";
    last = performance.now();
    if (on) requestAnimationFrame(tick);
  }
  element("play").onclick = () => play(!playing);
  element("slider").oninput = event => seek(+event.target.value);
  element("from").onchange = () => draw();
  element("follow").onchange = event => { looks.follow = +event.target.value; draw(); };
  root.addEventListener("keydown", event => {
    if (event.target.tagName === "SELECT" || event.target.tagName === "BUTTON") return;
    if (event.key === " ") { play(!playing); event.preventDefault(); }
  });
  canvas.onpointerdown = event => canvas.setPointerCapture(event.pointerId);
  canvas.onpointermove = event => {
    if (!event.buttons) return;
    looks.azimuth -= 0.008 * event.movementX;
    looks.height = Math.max(-1.55, Math.min(1.55, looks.height + 0.008 * event.movementY));
    draw();
  };
  canvas.onwheel = event => {
    looks.distance = Math.max(1.5 * largest, Math.min(20 * reach, looks.distance * Math.exp(0.001 * event.deltaY)));
    draw();
    event.preventDefault();
  };
  new ResizeObserver(() => data && draw()).observe(canvas);

  function seek(next) {
    part = Math.min(1, Math.max(0, next || 0));
    if (data) draw();
  }

  return { load, seek, play, looks };
}

function show(data) {
  const shown = scene(document.body);
  document.body.tabIndex = -1;
  document.body.focus();
  shown.load(data);
  // "#play", "#part=0.5" and "#follow=1" open the page in that state.
  for (const [name, value] of new URLSearchParams(location.hash.slice(1))) {
    if (name === "part") shown.seek(+value);
    if (name === "follow" && data.names.length > +value) document.querySelector(".fullbody-follow").value = shown.looks.follow = +value;
    if (name === "zoom") shown.looks.distance /= +value || 1;
  }
  shown.seek(document.querySelector(".fullbody-slider").value);
  if (location.hash.includes("play")) shown.play(true);
}
