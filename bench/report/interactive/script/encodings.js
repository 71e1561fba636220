// What the views share: values, titles, and the parts of a Vega-Lite specification.

import { width } from "./chart.js";
import { colorOf, LISTED, optimizers, problems } from "./data.js";
import { pageColor } from "./page.js";
import { state } from "./state.js";

// Values of the objective, or their distance from the reference

export const shownValue = (p, distance) => (state.distance ? distance : problems[p].reference + distance);
export const titleOf = (p) =>
  problems[p].precision
    ? "best value less the optimum"
    : !state.distance
      ? "best value"
      : problems[p].known
        ? "best value less the known optimum"
        : "best value less the lowest found";

const pensOf = (chosen, field = "o") => {
  const domain = chosen.map((o) => optimizers[o].label);
  const range = (name) => chosen.map((o) => (name === "color" ? colorOf(o) : optimizers[o][name]));
  const legend = null; // the page has one, of text
  return {
    color: { field, type: "nominal", sort: null, scale: { domain, range: range("color") }, legend },
    strokeDash: {
      field,
      type: "nominal",
      sort: null,
      scale: { domain, range: range("dash").map((each) => (each.length ? each : [1, 0])) },
      legend,
    },
  };
};

// Of a tick; Vega leaves those between two powers of ten without a label
const EXTREME = "abs(datum.value) >= 1e6 || abs(datum.value) < 1e-4";
const WRITTEN = `datum.value !== 0 && (${EXTREME}) ? format(datum.value, '.3~e') : format(datum.value, ',.6~g')`;
const NUMBER = `datum.label === '' ? '' : ${WRITTEN}`;
export const quantitative = (field, title, scale, more = {}) => ({
  field,
  type: "quantitative",
  title,
  scale: {
    type: scale.log ? "log" : "linear",
    domain: scale.domain,
    nice: false,
    ...(scale.log ? {} : { zero: false }),
  },
  axis: {
    tickCount: 6,
    format: more.format ?? "~g",
    ...(more.format ? {} : { labelExpr: NUMBER }),
    labelOverlap: true,
    grid: true,
  },
});

export const lines = ({ rows, chosen, xTitle, yTitle, x, y, format, band, under, marks }) => {
  const styles = pensOf(chosen);
  const position = { x: quantitative("x", xTitle, x), y: quantitative("y", yTitle, y, { format }) };
  const shown = under.filter((each) => each.x >= Math.min(...x.domain) && each.x <= Math.max(...x.domain));
  const tooltip = [
    { field: "title", title: xTitle },
    ...chosen.slice(0, LISTED).map((o) => ({ field: `o${o}`, title: optimizers[o].label })),
  ];
  const layer = [
    {
      mark: { type: "line", interpolate: "step-after", strokeWidth: 2, clip: true },
      encoding: { ...position, color: styles.color, strokeDash: styles.strokeDash },
    },
    ...marks.map((mark) => ({
      data: { values: [mark] },
      mark: { type: "rule", color: pageColor("--soft"), strokeDash: [4, 4], clip: true },
      encoding: "x" in mark ? { x: position.x } : { y: position.y },
    })),
    {
      data: { values: shown },
      params: [
        {
          name: "hover",
          select: { type: "point", fields: ["x"], nearest: true, on: "pointermove", clear: "pointerout" },
        },
      ],
      mark: { type: "rule", color: pageColor("--text"), strokeWidth: 1, clip: true },
      encoding: {
        x: position.x,
        opacity: { condition: { param: "hover", empty: false, value: 0.6 }, value: 0 },
        tooltip,
      },
    },
  ];
  if (band)
    layer.unshift({
      mark: { type: "area", interpolate: "step-after", opacity: 0.14, clip: true },
      encoding: { x: position.x, y: { ...position.y, field: "low" }, y2: { field: "high" }, color: styles.color },
    });
  return { data: { values: rows }, width: width(), height: 380, layer };
};
