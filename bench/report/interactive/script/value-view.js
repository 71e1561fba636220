// The values of the runs of a problem at a budget.

import { width } from "./chart.js";
import { cells, colorOf, curves, evaluations, last, optimizers, problems, quartiles, runName } from "./data.js";
import { quantitative, shownValue, titleOf } from "./encodings.js";
import { padded, scaleOf, text } from "./numbers.js";
import { pageColor } from "./page.js";
import { change, chosenOptimizers, shownProblem, state } from "./state.js";

const runValue = (p, o, k) => {
  const cell = cells[p][o];
  if (state.budget === last && !state.distance) return cell.fun[k] ?? Infinity;
  return shownValue(p, curves(cell)[k][state.budget]);
};
export const runView = () => {
  const p = shownProblem();
  const chosen = chosenOptimizers().filter((o) => cells[p][o]);
  const rows = [];
  const names = new Map();
  const table = [];
  for (const o of chosen) {
    const cell = cells[p][o];
    const values = (cell.fun ?? []).map((_, k) => runValue(p, o, k));
    const lost = values.filter((value) => !Number.isFinite(value)).length;
    names.set(o, optimizers[o].label + (lost ? ` (${lost} without a value)` : ""));
    values.forEach((value, k) => {
      if (Number.isFinite(value))
        rows.push({
          o,
          name: names.get(o),
          value,
          k,
          j: ((k * 0.618034) % 1) - 0.5,
          shown: text(value),
          run: runName(cell, k),
        });
    });
    const three = quartiles(cell).map((curve) => shownValue(p, curve[state.budget]));
    if (Number.isFinite(three[1]))
      rows.push({
        o,
        name: names.get(o),
        value: three[1],
        middle: true,
        low: three[0],
        high: Number.isFinite(three[2]) ? three[2] : null,
      });
    table.push([optimizers[o].label, text(cell.trials), text(cell.failed), ...three.map(text)]);
  }
  const x = padded(
    scaleOf(
      rows.flatMap((row) => (row.middle ? [row.low, row.value, row.high ?? row.value] : [row.value])),
      state.ylog,
      state.zoom?.x,
    ),
  );
  const at = (value) => (value <= 0 && x.log ? x.floor : value);
  for (const row of rows) Object.assign(row, { x: at(row.value), low: at(row.low), high: at(row.high ?? x.full[1]) });
  const labels = [...names.values()];
  const range = (name) => [...names.keys()].map((o) => (name === "color" ? colorOf(o) : optimizers[o][name]));
  const faint = state.cell !== null && chosen.includes(state.cell) ? `datum.o !== ${state.cell}` : "false";
  const isRun = state.run ? `datum.o === ${state.run.o} && datum.k === ${state.run.k}` : "false";
  const y = {
    field: "name",
    type: "nominal",
    sort: null,
    scale: { domain: labels },
    title: null,
    axis: { labelLimit: Math.min(width() / 3, 240), grid: false },
  };
  const position = { x: quantitative("x", titleOf(p), x), y };
  const color = {
    field: "name",
    type: "nominal",
    sort: null,
    scale: { domain: labels, range: range("color") },
    legend: null,
  };
  const [points, clicks] = rows.some((row) => !row.middle)
    ? ["every point is a run; ", "; a click on a point shows the run"]
    : ["", ""];
  return {
    spec: {
      data: { values: rows },
      width: width(),
      height: 38 * Math.max(labels.length, 1) + 10,
      layer: [
        {
          transform: [{ filter: "datum.middle" }],
          mark: { type: "rule", strokeWidth: 2, color: pageColor("--soft"), clip: true },
          encoding: { x: { ...position.x, field: "low" }, x2: { field: "high" }, y },
        },
        {
          transform: [{ filter: "datum.middle" }],
          mark: { type: "tick", thickness: 3, size: 34, color: pageColor("--text"), opacity: 0.7, clip: true },
          encoding: position,
        },
        {
          transform: [{ filter: "!datum.middle" }],
          mark: { type: "point", filled: true, size: 50, clip: true, cursor: "pointer" },
          encoding: {
            ...position,
            color,
            yOffset: { field: "j", type: "quantitative", scale: { domain: [-0.75, 0.75], nice: false, zero: false } },
            shape: {
              field: "name",
              type: "nominal",
              sort: null,
              scale: { domain: labels, range: range("shape") },
              legend: null,
            },
            opacity: { condition: { test: faint, value: 0.15 }, value: 0.75 },
            stroke: { condition: { test: isRun, value: pageColor("--text") }, value: "transparent" },
            strokeWidth: { value: 2 },
            size: { condition: { test: isRun, value: 220 }, value: 50 },
            tooltip: [
              { field: "name", title: "optimizer" },
              { field: "run", title: "run" },
              { field: "shown", title: "value" },
            ],
          },
        },
      ],
    },
    x,
    y: null,
    pick: (datum) => datum.k !== undefined && change({ problem: p, run: { o: datum.o, k: datum.k }, cell: state.cell }),
    head: ["optimizer", "trials", "failed", "lower quartile", "median", "upper quartile"],
    rows: table,
    about: `${problems[p].label}: ${points}bars are medians, lines quartiles${clicks}`,
    caption: `${problems[p].label} after ${text(evaluations(p, state.budget))} evaluations`,
  };
};
