// Best values, or shares of targets reached, over evaluations.

import {
  cells,
  common,
  commonUnit,
  curves,
  data,
  evaluations,
  grid,
  last,
  levels,
  optimizers,
  problems,
  quartiles,
} from "./data.js";
import { lines, shownValue, titleOf } from "./encodings.js";
import { percent, scaleOf, text } from "./numbers.js";
import { chosenOptimizers, chosenProblems, state } from "./state.js";

export const curveView = () => (state.problem === null ? shareView() : valueView(state.problem));

const valueView = (p) => {
  const chosen = chosenOptimizers().filter((o) => cells[p][o]);
  const points = chosen.map((o) => [
    o,
    quartiles(cells[p][o]).map((curve) => Array.from(curve, (each) => shownValue(p, each))),
  ]);
  const y = scaleOf(
    points.flatMap(([, three]) => three.flat()),
    state.ylog,
    state.zoom?.y,
  );
  const spent = grid.map((_, i) => evaluations(p, i));
  const x = scaleOf(spent, state.xlog, state.zoom?.x);
  const rows = [];
  const under = spent.map((each) => ({ x: each, title: text(each) }));
  for (const [o, [q1, median, q3]] of points)
    for (let i = 0; i <= last; i++) {
      const at = (value) => (value <= 0 && y.log ? y.floor : value);
      under[i][`o${o}`] = `${text(median[i])} (${text(q1[i])} to ${text(q3[i])})`;
      if (Number.isFinite(median[i]))
        rows.push({
          o: optimizers[o].label,
          x: spent[i],
          y: at(median[i]),
          low: at(q1[i]),
          high: at(Number.isFinite(q3[i]) ? q3[i] : y.full[1]),
        });
    }
  const marks = state.budget < last ? [{ x: spent[state.budget] }] : [];
  const target = state.target >= 0 && problems[p].targets.find(([level]) => level === levels[state.target]);
  if (target) marks.push({ y: shownValue(p, target[1]) });
  const i = state.budget;
  return {
    spec: lines({ rows, chosen, xTitle: "evaluations", yTitle: titleOf(p), x, y, band: true, under, marks }),
    x,
    y,
    head: ["optimizer", "lower quartile", "median", "upper quartile"],
    rows: points.map(([o, [q1, median, q3]]) => [
      optimizers[o].label,
      ...[q1, median, q3].map((curve) => text(curve[i])),
    ]),
    about: `${problems[p].label}: medians of the best value so far, with quartiles`,
    caption: `${problems[p].label} after ${text(spent[i])} evaluations`,
  };
};

export const reached = (p, o, wanted) => {
  const runs = data.complete ? curves(cells[p][o]) : [quartiles(cells[p][o])[1]];
  const counts = new Float64Array(grid.length);
  for (const curve of runs)
    for (const [, distance] of wanted) {
      const first = curve.findIndex((value) => value <= distance * (1 + 1e-3)); // a curve is rounded to 0.12%
      if (first >= 0) counts[first]++;
    }
  return { counts, of: runs.length * wanted.length };
};

const shareView = () => {
  const own = chosenProblems();
  const chosen = chosenOptimizers();
  const spent = grid.map((_, i) => common(i));
  const x = scaleOf(spent, state.xlog, state.zoom?.x);
  const y = { log: false, full: [0, 1], domain: state.zoom?.y ?? [0, 1] };
  const rows = [];
  const under = spent.map((each) => ({ x: each, title: text(each) }));
  const table = [];
  for (const o of chosen) {
    const total = new Float64Array(grid.length);
    let of = 0;
    for (const p of own.filter((each) => cells[each][o])) {
      const wanted = problems[p].targets.filter(([level]) => state.target < 0 || level === levels[state.target]);
      const found = reached(p, o, wanted);
      of += found.of;
      for (const [i, count] of found.counts.entries()) total[i] += count;
    }
    let sum = 0;
    for (let i = 0; i <= last && of; i++) {
      sum += total[i];
      rows.push({ o: optimizers[o].label, x: spent[i], y: sum / of });
      under[i][`o${o}`] = percent(sum / of);
    }
    table.push([optimizers[o].label, of ? under[state.budget][`o${o}`] : "–"]);
  }
  const which = state.target < 0 ? "all targets" : `the target ${data.targets.title} = ${levels[state.target]}`;
  const marks = state.budget < last ? [{ x: spent[state.budget] }] : [];
  const what = data.complete ? "(run, problem, target)" : "(problem, target), by the median run,";
  return {
    spec: lines({
      rows,
      chosen,
      xTitle: commonUnit,
      yTitle: "share of targets reached",
      x,
      y,
      format: ".0%",
      under,
      marks,
    }),
    x,
    y,
    head: ["optimizer", "share of targets reached"],
    rows: table,
    about: `Share of all ${what} reached: ${which} of ${own.length} problems`,
    caption: `${which} after ${text(spent[state.budget])} ${commonUnit}`,
  };
};
