// Describe and draw one run: its record, its trace, and its fit to the data of its problem.

import { embed, width } from "./chart.js";
import { cells, colorOf, curves, data, evaluations, grid, last, optimizers, problems, runName } from "./data.js";
import { quantitative, shownValue, titleOf } from "./encodings.js";
import { one, scaleOf, text } from "./numbers.js";
import { labelled, make, option, pageColor } from "./page.js";
import { change, chosenOptimizers, shownProblem, state } from "./state.js";

const command = (p, o, k) => {
  const member = cells[p][o].member?.[k] ?? 0;
  const [problem, optimizer] = [one(problems[p].commands, member), optimizers[o].command];
  const seed = cells[p][o].seed[k];
  return problem && optimizer && seed
    ? `bench solve ${problem} ${optimizer} --budget ${problems[p].budget} --seed ${seed}`
    : "";
};

const describe = (p, o, k) => {
  const [problem, cell] = [problems[p], cells[p][o]];
  const named = (names, values) =>
    (values?.[k] ?? "")
      .split(",")
      .map((value, i) => [names[i], value])
      .filter(([, value]) => value !== "");
  const listed = (pairs) => pairs.map(([name, value]) => `${name} = ${value}`).join(", ");
  const reason = cell.error?.[k];
  return [
    ["optimizer", optimizers[o].label + (optimizers[o].options && ` (${optimizers[o].options})`)],
    ["problem", problem.label + (problem.options && ` (${problem.options})`)],
    ["run", runName(cell, k)],
    ["seed", cell.seed[k] || "unknown"],
    ["best value", text(cell.fun[k])],
    [
      problem.known ? "above the optimum" : "above the lowest found",
      problem.precision ? "" : text(curves(cell)[k][last]),
    ],
    ["evaluations", `${text(one(cell.nfev, k))} of ${text(problem.budget)}`],
    ["stopped by", data.texts[one(cell.stop, k)] || "–"],
    ["time", `${text(one(cell.wall_s, k))} s, ${text(one(cell.objective_s, k))} s of it in the objective`],
    ["best point", listed(named(problem.variables, cell.x))],
    ["metrics", listed(named(problem.metrics, cell.metrics))],
    ["failure", reason === null || reason === undefined ? "" : data.texts[reason]],
  ].filter(([, value]) => value);
};

const runSpec = (p, o, k) => {
  const rows = [];
  const own = curves(cells[p][o]);
  const y = scaleOf(
    own.flatMap((curve) => Array.from(curve, (each) => shownValue(p, each))),
    state.ylog,
    null,
  );
  for (const [at, curve] of own.entries())
    for (const [i, distance] of curve.entries()) {
      const value = shownValue(p, distance);
      if (Number.isFinite(value))
        rows.push({ k: at, x: evaluations(p, i), y: value <= 0 && y.log ? y.floor : value, shown: text(value) });
    }
  const x = scaleOf(
    grid.map((_, i) => evaluations(p, i)),
    state.xlog,
    null,
  );
  const encoding = {
    x: quantitative("x", "evaluations", x),
    y: quantitative("y", titleOf(p), y),
    detail: { field: "k", type: "nominal" },
  };
  return {
    data: { values: rows },
    width: width(),
    height: 220,
    layer: [
      {
        transform: [{ filter: `datum.k !== ${k}` }],
        mark: { type: "line", interpolate: "step-after", color: pageColor("--line"), strokeWidth: 0.8 },
        encoding,
      },
      {
        transform: [{ filter: `datum.k === ${k}` }],
        mark: { type: "line", interpolate: "step-after", color: colorOf(o), strokeWidth: 2.5 },
        encoding: {
          ...encoding,
          tooltip: [
            { field: "x", title: "evaluations", format: "," },
            { field: "shown", title: "value" },
          ],
        },
      },
    ],
  };
};

const samples = (p) => {
  const { t, values } = problems[p].data;
  if (!values.table) {
    let level = 0;
    values.table = values.steps.split(",").map((step, i) => {
      level += Number(step);
      return {
        t: Array.isArray(t) ? t[0] + i * t[1] : t.values[i],
        value: values.low + (level / 9999) * (values.high - values.low),
      };
    });
  }
  return values.table;
};

let from = 0; // the share of the signal where its window begins
export let whole = false;
const WINDOW = 0.2; // of the signal
const AXIS = 70; // pixels beside a panel of several
const fitSpec = (p, o, k) => {
  const {
    variables,
    data: { model, t_title, title },
  } = problems[p];
  const point = Object.fromEntries(cells[p][o].x[k].split(",").map((value, i) => [variables[i], Number(value)]));
  const table = samples(p);
  const [start, end] = [table[0].t, table.at(-1).t];
  const begin = start + from * (1 - WINDOW) * (end - start);
  const domain = whole ? [start, end] : [begin, begin + WINDOW * (end - start)];
  const x = { field: "t", type: "quantitative", title: t_title, scale: { domain, nice: false, zero: false } };
  const y = (field, name) => ({ field, type: "quantitative", title: name, scale: { zero: false } });
  const tooltip = ["t", "value", "fit", "residual"].map((field) => ({ field, type: "quantitative", format: ".5~g" }));
  return {
    data: { values: whole ? table : table.filter(({ t }) => t >= domain[0] && t <= domain[1]) },
    params: [{ name: "point", value: point }],
    transform: [
      { calculate: model, as: "fit" },
      { calculate: "datum.value - datum.fit", as: "residual" },
    ],
    vconcat: [
      {
        width: width() - AXIS,
        height: 220,
        layer: [
          {
            mark: { type: "point", filled: true, size: 12, color: pageColor("--soft"), clip: true },
            encoding: { x, y: y("value", title), tooltip },
          },
          {
            mark: { type: "line", color: colorOf(o), strokeWidth: 1.8, clip: true },
            encoding: { x, y: y("fit", title) },
          },
        ],
      },
      {
        width: width() - AXIS,
        height: 110,
        mark: { type: "line", color: pageColor("--soft"), strokeWidth: 1, clip: true },
        encoding: { x, y: y("residual", "residual"), tooltip },
      },
    ],
  };
};

const runs = make("select", {
  onchange: () => {
    const [o, k] = runs.value.split(",").map(Number);
    change({ run: runs.value ? { o, k } : null, problem: shownProblem() });
  },
});
export const runChoice = labelled("Run", runs);
export const run = make("section", { className: "run" });

export const showRun = () => {
  const p = shownProblem();
  const usable = p !== null && state.view !== "ranks";
  runChoice.hidden = !usable || !problems.length;
  run.hidden = !usable || !state.run;
  if (!usable) return;
  const chosen = chosenOptimizers().filter((o) => cells[p][o]?.fun);
  if (state.run && !chosen.includes(state.run.o)) chosen.push(state.run.o);
  runs.replaceChildren(
    option("", "none chosen"),
    ...chosen.map((o) => {
      const group = make("optgroup", { label: optimizers[o].label });
      const sorted = cells[p][o].fun.map((fun, k) => [fun ?? Infinity, k]).sort((a, b) => a[0] - b[0]);
      group.append(
        ...sorted.map(([fun, k]) =>
          option(`${o},${k}`, `${optimizers[o].label}, ${runName(cells[p][o], k)}: ${text(fun)}`),
        ),
      );
      return group;
    }),
  );
  runs.value = state.run ? `${state.run.o},${state.run.k}` : "";
  if (!state.run) return run.replaceChildren();
  const { o, k } = state.run;
  const again = command(p, o, k);
  const list = make(
    "dl",
    {},
    ...describe(p, o, k).flatMap(([name, value]) => [
      make("dt", { textContent: name }),
      make("dd", { textContent: value }),
    ]),
  );
  const trace = make("div", { className: "chart trace" });
  run.replaceChildren(make("h3", { textContent: `Run of ${optimizers[o].label} on ${problems[p].label}` }), list);
  if (again)
    run.append(make("p", { className: "note", textContent: "Make it again:" }), make("code", { textContent: again }));
  run.append(
    make("p", {
      className: "about",
      textContent: "Its best value over evaluations; in grey, the other runs of the cell",
    }),
    trace,
  );
  embed(trace, runSpec(p, o, k));
  if (!problems[p].data || !cells[p][o].x?.[k]) return;
  const fit = make("div", { className: "chart fit" });
  const draw = () => embed(fit, fitSpec(p, o, k));
  const slider = make("input", {
    type: "range",
    min: 0,
    max: 1,
    step: 0.01,
    value: from,
    oninput: () => {
      from = Number(slider.value);
      draw();
    },
  });
  const box = make("input", {
    type: "checkbox",
    checked: whole,
    onchange: () => {
      whole = box.checked;
      slider.disabled = whole;
      draw();
    },
  });
  slider.disabled = whole;
  run.append(
    make("p", { className: "about", textContent: "The data with the fit of this run, and the residual" }),
    make("div", { className: "controls" }, labelled("From", slider), labelled("whole signal", box)),
    fit,
  );
  draw();
};
