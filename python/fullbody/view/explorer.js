// Sliders beside a scene and curves: whatever a slider moves is computed again, and the newest values win.
// `compute(values)` resolves to { scene, curves, time, unit, notice }: what `scene().load` takes, a list of { label, unit, values, inverted },
// the times (K,) of the curves and their unit, and a text or nothing. It rejects with an error whose message is shown beside the slider.

const INK = "#1b5e92", BAND = "rgba(27, 94, 146, .35)", MARK = "#b3261e", GREY = "#666";

function brief(value) {  // four digits
  if (value === 0) return "0";
  const size = Math.abs(value);
  return size >= 1e5 || size < 1e-3 ? value.toExponential(2) : String(+value.toPrecision(4));
}

function written(value, range) {  // six digits of a range
  return Math.abs(value) < 1e-9 * range ? 0 : +value.toPrecision(6);
}

// Draws a curve with the time that the scene shows. Where a pixel holds several samples, it has their envelope and their mean.
function draw_curve(canvas, { label, unit, values, inverted }, time, time_unit, part) {
  const ratio = window.devicePixelRatio || 1, wide = canvas.clientWidth, high = canvas.clientHeight;
  if (!wide) return;
  [canvas.width, canvas.height] = [wide * ratio, high * ratio];
  const pen = canvas.getContext("2d"), [left, right, top, bottom] = [64, 12, 22, 20];
  pen.scale(ratio, ratio);
  pen.font = "12px system-ui, 'DejaVu Sans', sans-serif";
  let [low, up] = [Infinity, -Infinity];
  for (const value of values) if (Number.isFinite(value)) [low, up] = [Math.min(low, value), Math.max(up, value)];
  pen.fillStyle = "#222";
  pen.fillText(unit ? `${label} [${unit}]` : label, left, 14);
  if (low > up) {
    pen.fillText("has no values in this run", left, high / 2);
    return;
  }
  // A curve that is constant but for rounding is drawn as a line.
  const span = Math.max(up - low, 1e-12 * Math.max(Math.abs(up), Math.abs(low)), 1e-300), last = values.length - 1;
  const x = k => left + (wide - left - right) * (time[k] - time[0]) / (time[last] - time[0]);
  const y = value => {
    const height = (value - low) / span;
    return top + (high - top - bottom) * (inverted ? height : 1 - height);
  };
  pen.strokeStyle = "#ccc";
  pen.strokeRect(left, top, wide - left - right, high - top - bottom);
  pen.textAlign = "right";
  for (const value of up > low ? [low, up] : [low]) pen.fillText(brief(value), left - 5, y(value) + 4);
  pen.textAlign = "left";
  pen.fillStyle = GREY;
  pen.fillText(brief(time[0]), left, high - 5);
  pen.textAlign = "right";
  pen.fillText(`${brief(time[last])} ${time_unit}`.trim(), wide - right, high - 5);
  pen.textAlign = "left";
  if (values.length > 2 * wide) {
    const columns = new Map();
    values.forEach((value, k) => {
      if (!Number.isFinite(value)) return;
      const column = Math.round(x(k)), known = columns.get(column) || [Infinity, -Infinity, 0, 0];
      columns.set(column, [Math.min(known[0], value), Math.max(known[1], value), known[2] + value, known[3] + 1]);
    });
    pen.strokeStyle = BAND;
    pen.beginPath();
    for (const [column, [least, most]] of columns) {
      pen.moveTo(column, y(least) + 0.5);
      pen.lineTo(column, y(most) - 0.5);
    }
    pen.stroke();
    pen.strokeStyle = INK;
    pen.beginPath();
    for (const [column, [, , sum, count]] of columns) pen.lineTo(column, y(sum / count));
    pen.stroke();
  } else {
    pen.strokeStyle = INK;
    pen.lineWidth = 1.2;
    pen.beginPath();
    let down = false;
    values.forEach((value, k) => {
      if (Number.isFinite(value)) pen[down ? "lineTo" : "moveTo"](x(k), y(value));
      down = Number.isFinite(value);
    });
    pen.stroke();
  }
  const now = left + (wide - left - right) * part;
  pen.strokeStyle = MARK;
  pen.lineWidth = 1;
  pen.beginPath();
  pen.moveTo(now, top);
  pen.lineTo(now, high - bottom);
  pen.stroke();
}

// Makes the explorer within an element; `code(values)` returns the text of the lines that make the same run in Python.
function explorer(root, { compute, code, onValues = () => {} }) {
  root.classList.add("fullbody-explorer");
  root.innerHTML = `<form class="fullbody-controls" onsubmit="return false"></form>
<div class="fullbody-shown"><div class="fullbody-view" tabindex="0"></div><p class="fullbody-notice" role="status"></p><div class="fullbody-curves"></div>
<p><button type="button" class="fullbody-copy">Copy as Python</button></p><pre class="fullbody-code" hidden></pre></div>`;
  const element = name => root.querySelector(`.fullbody-${name}`);
  let values = {}, faults = {}, moved = null, busy = false, waiting = false, shown = null, part = 0;
  const picture = scene(element("view"), now => {
    part = now;
    redraw();
  });

  function redraw() {
    if (!shown) return;
    [...element("curves").children].forEach((canvas, k) => draw_curve(canvas, shown.curves[k], shown.time, shown.unit, part));
  }

  function seek(event) {
    if (!event.buttons) return;
    const box = event.target.getBoundingClientRect();
    picture.seek((event.clientX - box.left - 64) / (box.width - 76));
  }

  function load(result) {
    const first = !shown;
    shown = result;
    const charts = element("curves");
    while (charts.children.length > result.curves.length) charts.lastChild.remove();
    while (charts.children.length < result.curves.length) {
      const canvas = document.createElement("canvas");
      canvas.onpointerdown = canvas.onpointermove = seek;
      charts.append(canvas);
    }
    result.curves.forEach((curve, k) => charts.children[k].setAttribute("aria-label", `${curve.label} against time`));
    picture.load(result.scene);
    if (first) picture.seek(0);
    redraw();
    element("notice").textContent = result.notice || "";
    // A test reads the numbers that are shown here.
    root.dispatchEvent(new CustomEvent("fullbody-result", { detail: { values: { ...values }, ...result } }));
  }

  async function update() {
    if (busy) {
      waiting = true;
      return;
    }
    busy = true;
    root.setAttribute("aria-busy", "true");
    do {
      waiting = false;
      const name = moved;
      try {
        const result = await compute({ ...values });
        for (const fault of Object.values(faults)) fault.textContent = "";
        load(result);
      } catch (error) {
        // The last good run stays.
        const fault = faults[name] || element("notice");
        fault.textContent = error.message;
      }
    } while (waiting);
    busy = false;
    root.setAttribute("aria-busy", "false");
  }

  // Makes the sliders of groups [{ title, open, controls: [{ name, label, min, max, value, unit }] }], and computes their run.
  function setControls(groups) {
    values = {};
    faults = {};
    moved = null;
    element("controls").replaceChildren(...groups.map(({ title, open, controls }) => {
      const group = document.createElement("details"), summary = document.createElement("summary");
      group.open = open;
      summary.textContent = title;
      group.append(summary);
      for (const { name, label, min, max, value, unit } of controls) {
        values[name] = value;
        const row = document.createElement("label"), text = document.createElement("span");
        const slider = document.createElement("input"), number = document.createElement("input"), fault = document.createElement("em");
        text.textContent = unit ? `${label} [${unit}]` : label;
        Object.assign(slider, { type: "range", min, max, step: "any", value, name });
        Object.assign(number, { type: "number", step: "any", value: written(value, max - min) });
        number.setAttribute("aria-label", `${label}, typed in`);
        fault.setAttribute("role", "alert");
        faults[name] = fault;
        // A slider of step "any" moves by too little on a key.
        slider.onkeydown = event => {
          const sign = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
          if (!sign) return;
          slider.value = +slider.value + sign * (max - min) / (event.shiftKey ? 1000 : 100);
          slider.oninput();
          event.preventDefault();
        };
        const take = value => {
          values[name] = value;
          moved = name;
          onValues({ ...values });
          update();
        };
        slider.oninput = () => {
          number.value = written(+slider.value, max - min);
          take(+slider.value);
        };
        number.onchange = () => {
          if (!Number.isFinite(number.valueAsNumber)) {
            fault.textContent = `${label} has to be a number`;
            return;
          }
          slider.value = number.valueAsNumber;
          take(number.valueAsNumber);
        };
        row.append(text, slider, number, fault);
        group.append(row);
      }
      return group;
    }));
    update();
  }

  element("copy").onclick = async () => {
    const text = await code({ ...values });
    Object.assign(element("code"), { textContent: text, hidden: false });
    try {
      await navigator.clipboard.writeText(text);
      element("copy").textContent = "Copied";
    } catch {
      element("copy").textContent = "Copy as Python: select the lines below";
    }
  };
  new ResizeObserver(redraw).observe(element("curves"));
  return { setControls, update, picture };
}
