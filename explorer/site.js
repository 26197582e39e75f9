// The explorer as a page without Python, where the core in WebAssembly computes every run.
import init, { Model } from "./fullbody_web.js";

const DEGREES = Math.PI / 180;
// The number of equal intervals between the samples of a run.
const INTERVALS = 1000;
const ELEMENTS = [["a", "semi-major axis"], ["e", "eccentricity"], ["i", "inclination"], ["Omega", "longitude of the node"],
  ["omega", "argument of periapsis"], ["M", "mean anomaly"]];
const byId = name => document.getElementById(name);

// Returns the controls of a system in groups; each control has the value of the system's initial state.
function controls(model, system) {
  const { names, length, mass, impact } = system, parameters = JSON.parse(model.parameters()), groups = [];
  const slider = (name, label, min, max, value, unit = "") => ({ name, label, min, max, value, unit });
  names.slice(1).forEach((name, k) => {
    const body = k + 1, start = model.elements(body);
    groups.push({ title: `Orbit of ${name} about ${names[0]}`, open: k === 0, controls: ELEMENTS.map(([key, label], c) => {
      const id = `${key} of ${name}`;
      if (c === 0) return slider(id, label, 0.5 * start[0], 2 * start[0], start[0], length);
      if (c === 1) return slider(id, label, 0, 0.8, start[1]);
      return slider(id, label, 0, c === 2 ? 180 : 360, start[c] / DEGREES, "deg");
    }) });
  });
  names.forEach((name, body) => {
    const rows = ["a", "b", "c"].filter(axis => `semi-axis ${axis} of ${name}` in parameters).map(axis => {
      const id = `semi-axis ${axis} of ${name}`;
      return slider(id, `semi-axis ${axis}`, 0.5 * parameters[id], 1.5 * parameters[id], parameters[id], length);
    });
    const id = `mass of ${name}`;
    if (id in parameters) rows.push(slider(id, "mass", 0.25 * parameters[id], 4 * parameters[id], parameters[id], mass));
    rows.push(slider(`tilt of ${name}`, "tilt about its long axis", -90, 90, 0, "deg"));
    if (impact && impact.body === body) rows.push(slider("beta", "momentum enhancement of an impact from ahead (0: none)", 0, 10, 0));
    groups.push({ title: name, open: false, controls: rows });
  });
  if (system.lit) groups.push({ title: "Light", open: false, controls: [
    slider("phase", "phase angle", 0, 120, 10, "deg"), slider("aspect", "observer's latitude above the first orbit", -90, 90, 0, "deg")
  ] });
  return groups;
}

// Returns the model that has these values. Only values that differ from the initial ones change the model `start`.
function changed(start, system, values, initial) {
  let model = start;
  const differs = name => name in initial && values[name] !== initial[name];
  for (const name of Object.keys(values).filter(name => /^(semi-axis|mass) /.test(name) && differs(name))) model = model.withParameter(name, values[name]);
  system.names.forEach((name, body) => {
    const ids = ELEMENTS.map(([key]) => `${key} of ${name}`);
    if (!ids.some(differs)) return;
    model = model.withElements(body, Float64Array.from(ids, (id, c) => c < 2 ? values[id] : values[id] * DEGREES));
  });
  system.names.forEach((name, body) => {
    if (differs(`tilt of ${name}`)) model = model.withTilt(body, values[`tilt of ${name}`] * DEGREES);
  });
  if (differs("beta")) {
    const momentum = -values.beta * system.impact.momentum;
    model = model.withMomentum(system.impact.body, model.direction(system.impact.body).map(c => c * momentum));
  }
  return model;
}

// Returns the directions to the observer and to the Sun, which are given relative to the initial orbit.
function directions(model, values) {
  const [, , i, node] = model.elements(1), [b, p] = [values.aspect * DEGREES, values.phase * DEGREES];
  const x = [Math.cos(node), Math.sin(node), 0], y = [-Math.sin(node) * Math.cos(i), Math.cos(node) * Math.cos(i), Math.sin(i)];
  const z = [Math.sin(node) * Math.sin(i), -Math.cos(node) * Math.sin(i), Math.cos(i)];
  const at = (longitude, latitude) => [0, 1, 2].map(c =>
    Math.cos(latitude) * (Math.cos(longitude) * x[c] + Math.sin(longitude) * y[c]) + Math.sin(latitude) * z[c]);
  return [Float64Array.from(at(0, b)), Float64Array.from(at(p, b))];
}

function column(rows, width, c, factor = 1) {
  return Float64Array.from({ length: rows.length / width }, (_, k) => rows[width * k + c] * factor);
}

// Returns the scene and the curves of a run, and the reason if it ended early.
function run(start, system, values, initial, duration) {
  const model = changed(start, system, values, initial), motion = model.integrate(duration, INTERVALS);
  const { time, position, attitude } = motion, count = system.names.length, samples = time.length;
  if (samples < 2) throw new Error(motion.error || "the run has no samples");
  const axes = model.semiAxes(), [observer, sun] = directions(model, { phase: 0, aspect: 0, ...values });
  const surfaces = system.surfaces.map((parts, b) => parts || [{
    columns: [axes[3 * b], 0, 0, 0, axes[3 * b + 1], 0, 0, 0, axes[3 * b + 2]], position: [0, 0, 0]
  }]);
  const all_ellipsoids = surfaces.every(parts => parts.length === 1 && !parts[0].triangles);
  const curves = [], deg = 1 / DEGREES;
  system.names.slice(1).forEach((name, k) => {
    const body = k + 1, orbit = motion.elements(body), tag = count > 2 ? ` of ${name}` : "";
    const separation = Float64Array.from({ length: samples }, (_, s) => Math.hypot(...[0, 1, 2].map(c =>
      position[3 * (s * count + body) + c] - position[3 * s * count + c])));
    curves.push({ label: `separation${tag}`, unit: system.length, values: separation });
    curves.push({ label: `semi-major axis${tag}`, unit: system.length, values: column(orbit, 6, 0) });
    curves.push({ label: `eccentricity${tag}`, unit: "", values: column(orbit, 6, 1) });
    const angles = motion.rollPitchYaw(body);
    ["roll", "pitch", "libration"].forEach((label, c) => curves.push({ label: label + tag, unit: "deg", values: column(angles, 3, c, deg) }));
  });
  curves.push({ label: "energy drift", unit: "", values: motion.energyDrift });
  if (system.lit) {
    const light = motion.brightness(observer, sun), brightest = Math.max(...light);
    curves.push({ label: "light curve", unit: "mag", inverted: true, values: light.map(b => b > 0 ? -2.5 * Math.log10(b / brightest) : NaN) });
  }
  const scene = { names: system.names, surfaces, length: system.length, unit: system.time, time, position: Float32Array.from(position),
    attitude: Float32Array.from(attitude),
    sun: Float32Array.from({ length: 3 * samples }, (_, k) => sun[k % 3]),
    observer: Float32Array.from({ length: 3 * samples }, (_, k) => observer[k % 3]) };
  if (all_ellipsoids) scene.casts = surfaces.map(([part]) => [{ inverse: part.columns.map(a => a && 1 / a), position: [0, 0, 0] }]);
  return { scene, curves, time, unit: system.time, notice: motion.error };
}

// Returns the lines of Python that make the same run.
function code(system, values, initial, duration) {
  const lines = ["import fullbody", "import numpy as np", "", `system, state = fullbody.systems.${system.name}()`];
  const differs = name => name in initial && values[name] !== initial[name];
  for (const name of Object.keys(values).filter(name => /^(semi-axis|mass) /.test(name) && differs(name)))
    lines.push(`system = system.changed(${JSON.stringify(name)}, ${values[name]} - system.context.core.parameter_values[${JSON.stringify(name)}])`);
  system.names.forEach((name, body) => {
    const ids = ELEMENTS.map(([key]) => `${key} of ${name}`);
    if (!ids.some(differs)) return;
    const numbers = ids.map((id, c) => c < 2 ? `${values[id]}` : `np.radians(${values[id]})`).join(", ");
    lines.push(`relative = fullbody.KeplerElements(${numbers}).to_cartesian(system.mu(${body}, 0))`,
      `masses = system.masses[[0, ${body}]]`, "shares = np.array([[-masses[1]], [masses[0]]]) / masses.sum()",
      "position, velocity = state.position.copy(), state.velocity.copy()",
      "for vectors, vector in zip((position, velocity), relative):",
      `    vectors[[0, ${body}]] = masses @ vectors[[0, ${body}]] / masses.sum() + shares * vector`,
      "state = state.replace(position=position, velocity=velocity)");
  });
  system.names.forEach((name, body) => {
    if (differs(`tilt of ${name}`)) lines.push(`state = state.rotated(${body}, [1, 0, 0], np.radians(${values[`tilt of ${name}`]}))`);
  });
  if (differs("beta")) {
    const { body, momentum } = system.impact;
    lines.push(`motion = state.velocity[${body}] - state.velocity[0]`,
      `change = ${-values.beta} * ${momentum} / system.masses[${body}] * motion / np.linalg.norm(motion)`,
      `state = state.kick(${body}, change)`);
  }
  lines.push(`run = system.integrate(state, duration=${duration}, output=state.time + ${duration} * np.arange(${INTERVALS + 1}) / ${INTERVALS})`);
  return lines.join("\n") + "\n";
}

async function main() {
  const root = byId("explorer");
  if (typeof WebAssembly !== "object") {
    root.textContent = "This page needs WebAssembly, which this browser does not offer.";
    return;
  }
  const [systems] = await Promise.all([fetch("systems.json").then(answer => answer.json()), init()]);
  let system, start, initial, values;
  const ui = explorer(root, {
    compute: async requested => {
      values = requested;
      // The browser handles input between two runs.
      await new Promise(resolve => setTimeout(resolve));
      const result = run(start, system, values, initial, byId("duration").valueAsNumber);
      byId("link").href = link();
      return result;
    },
    code: requested => code(system, requested, initial, byId("duration").valueAsNumber),
  });

  function link() {
    const changes = Object.keys(values).filter(name => values[name] !== initial[name]).map(name => [name, values[name]]);
    return "#" + new URLSearchParams([["system", system.name], ["duration", byId("duration").value], ...changes]);
  }

  // Shows a system with values of its controls by name; names that it does not have are ignored.
  function choose(name, duration, requested) {
    system = systems.find(other => other.name === name) || systems[0];
    byId("system").value = system.name;
    byId("about").textContent = system.title;
    byId("unit").textContent = system.time;
    byId("duration").value = duration || system.duration;
    start = new Model(JSON.stringify(system.description));
    const groups = controls(start, system), all = groups.flatMap(group => group.controls);
    initial = Object.fromEntries(all.map(control => [control.name, control.value]));
    for (const control of all) if (Number.isFinite(requested[control.name])) control.value = requested[control.name];
    ui.setControls(groups);
  }

  byId("system").replaceChildren(...systems.map(({ name, title }) => {
    const option = document.createElement("option");
    [option.value, option.textContent] = [name, title];
    return option;
  }));
  byId("system").onchange = event => choose(event.target.value, null, {});
  byId("reset").onclick = () => choose(system.name, null, {});
  byId("duration").onchange = () => ui.update();
  const open = () => {
    const query = new URLSearchParams(location.hash.slice(1)), name = query.get("system");
    if (!name) return choose(systems[0].name, null, systems[0].first || {});
    choose(name, +query.get("duration"), Object.fromEntries([...query].map(([key, value]) => [key, +value])));
  };
  window.onhashchange = open;
  open();
}

main().catch(error => {
  byId("explorer").textContent = `The page could not start: ${error.message}`;
});
