// The ranks of the optimizers on each problem at a budget.

import { width } from "./chart.js";
import { cells, common, commonUnit, data, optimizers, problems, quartiles, ranks } from "./data.js";
import { shownValue } from "./encodings.js";
import { percent, text } from "./numbers.js";
import { pageColor } from "./page.js";
import { change, chosenOptimizers, chosenProblems, state } from "./state.js";

export const rankView = () => {
  const own = chosenProblems();
  const chosen = chosenOptimizers();
  const rows = [];
  const table = [];
  const sums = new Map(chosen.map((o) => [o, []]));
  for (const p of own) {
    const found = ranks(p, chosen, state.budget);
    for (const [o, { rank, chance }] of found) {
      sums.get(o).push(rank);
      rows.push({
        p,
        o,
        problem: problems[p].label,
        optimizer: optimizers[o].label,
        rank,
        shown: text(rank),
        median: text(shownValue(p, quartiles(cells[p][o])[1][state.budget])),
        chance: percent(chance),
      });
    }
    table.push([problems[p].label, ...chosen.map((o) => text(found.get(o)?.rank))]);
  }
  const mean = (list) => (list.length ? list.reduce((a, b) => a + b, 0) / list.length : NaN);
  table.push(["mean rank", ...chosen.map((o) => text(Number(mean(sums.get(o)).toFixed(2))))]);
  const position = {
    x: {
      field: "optimizer",
      type: "nominal",
      sort: null,
      title: null,
      scale: { domain: chosen.map((o) => optimizers[o].label) },
      axis: { orient: "top", labelAngle: -40, labelLimit: 140, ticks: false, domain: false },
    },
    y: {
      field: "problem",
      type: "nominal",
      sort: null,
      title: null,
      scale: { domain: own.map((p) => problems[p].label) },
      axis: { labelLimit: Math.min(width() / 3, 240), ticks: false, domain: false },
    },
  };
  const n = Math.max(chosen.length, 2);
  const few = rows.length <= 1500 && width() / n > 26;
  const how = data.complete ? "by the rivals beaten" : "by the median";
  const layer = [
    {
      mark: { type: "rect", stroke: pageColor("--page"), strokeWidth: 1, cursor: "pointer" },
      encoding: {
        ...position,
        color: {
          field: "rank",
          type: "quantitative",
          scale: { domain: [1, n], range: ["#08306b", "#eaf2fb"] },
          legend: null,
        },
        tooltip: [
          { field: "problem" },
          { field: "optimizer" },
          { field: "shown", title: "rank" },
          { field: "median", title: "median" },
          ...(data.complete ? [{ field: "chance", title: "beats a run of the others" }] : []),
        ],
      },
    },
  ];
  if (few)
    layer.push({
      mark: { type: "text", fontSize: 12, cursor: "pointer" },
      encoding: {
        ...position,
        text: { field: "shown" },
        color: { condition: { test: `datum.rank <= ${(n + 1) / 2}`, value: "#ffffff" }, value: "#1b1f24" },
      },
    });
  return {
    spec: {
      data: { values: rows },
      width: width(),
      height: (own.length > 40 ? 16 : 24) * Math.max(own.length, 1),
      layer,
    },
    x: null,
    y: null,
    pick: (datum) =>
      datum.p !== undefined &&
      change({ view: "values", problem: datum.p, cell: datum.o, optimizers: new Set([...state.optimizers, datum.o]) }),
    head: ["problem", ...chosen.map((o) => optimizers[o].label)],
    rows: table,
    about: `Ranks ${how}, dark is best; a click on a cell shows its problem`,
    caption: `ranks after ${text(common(state.budget))} ${commonUnit}`,
  };
};
