// The explorer in a notebook: every run is computed by the kernel.
function render({ model, el }) {
  const requests = new Map();
  let last = 0;
  const ask = (what, values) => new Promise((resolve, reject) => {
    requests.set(++last, [resolve, reject]);
    model.send({ id: last, ask: what, values });
  });
  const receive = answer => {
    const [resolve, reject] = requests.get(answer.id) || [];
    if (!resolve) return;
    requests.delete(answer.id);
    if (answer.error === undefined) resolve(answer); else reject(new Error(answer.error));
  };
  model.on("msg:custom", receive);
  const ui = explorer(el, {
    compute: async values => {
      const { result } = await ask("run", values);
      const curves = result.curves.map(curve => ({ ...curve, values: unpack(curve.values, Float64Array) }));
      return { ...result, curves, time: unpack(result.time, Float64Array) };
    },
    code: async values => (await ask("code", values)).code,
  });
  ask("start").then(({ controls }) => ui.setControls([{ title: "Parameters", open: true, controls }]));
  return () => model.off("msg:custom", receive);
}
export default { render };
