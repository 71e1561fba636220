// Read the data: decode curves, and compute quartiles, ranks and budgets from them.

const ANCHOR = "look-further";
const part = document.getElementById(ANCHOR);
const data = JSON.parse(document.getElementById(`${ANCHOR}.data`).textContent);
const { problems, optimizers, grid } = data;
const last = grid.length - 1;
const MANY = 10; // optimizers of which all are shown at first
const LISTED = 15; // optimizers under the pointer

const make = (tag, properties = {}, ...children) => {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
};

const text = (value) => {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  if (Number.isInteger(value) && Math.abs(value) < 1e9) return value.toLocaleString("en");
  const size = Math.abs(value);
  return size >= 1e6 || size < 1e-3 ? value.toExponential(3) : String(Number(value.toPrecision(6)));
};
const percent = (share) => (Number.isNaN(share) ? "–" : `${Number((100 * share).toPrecision(3))} %`);
const pageColor = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim(); // light or dark
const colorOf = (o) => (optimizers[o].color === "#000000" ? pageColor("--text") : optimizers[o].color);
const one = (values, k) => (Array.isArray(values) ? values[k] : values); // a column may hold one value for all runs

// Data: every curve holds distances from the problem's reference, at the budgets of the grid.

const cells = problems.map(() => []);
for (const cell of data.cells) cells[cell.problem][cell.optimizer] = cell;

const decode = (code) => {
  const values = new Float64Array(grid.length);
  const steps = code.split(",");
  let level = Infinity;
  for (let i = 0; i < values.length; i++) {
    const step = steps[i] ?? "";
    if (step === "i") level = Infinity;
    else if (step === "z") level = -Infinity;
    else if (step !== "") level = Number.isFinite(level) ? level - Number(step) : Number(step);
    values[i] = 10 ** (level / 1000);
  }
  return values;
};

const curves = (cell) => (cell.runs ??= (cell.curve ?? []).map(decode));

const quartile = (sorted, share) => {
  const place = share * (sorted.length - 1);
  const [low, high] = [Math.floor(place), Math.ceil(place)];
  if (!Number.isFinite(sorted.at(-1))) return sorted[high];
  return sorted[low] + (place - low) * (sorted[high] - sorted[low]);
};

const quartiles = (cell) => {
  if (!cell.middle) {
    if (cell.quartiles) cell.middle = cell.quartiles.map(decode);
    else {
      cell.middle = [0.25, 0.5, 0.75].map(() => new Float64Array(grid.length));
      for (let i = 0; i <= last; i++) {
        const sorted = Float64Array.from(curves(cell), (curve) => curve[i]).sort();
        [0.25, 0.5, 0.75].forEach((share, at) => (cell.middle[at][i] = quartile(sorted, share)));
      }
    }
  }
  return cell.middle;
};

const evaluations = (p, i) => Math.max(1, Math.floor((grid[i] * problems[p].budget) / grid[last] + 0.5));
const sameBudget = problems.every((each) => each.budget === problems[0].budget);
const perDimension = problems.map((each) => each.budget / each.features.dimension);
const byDimension = !sameBudget && perDimension.every((each) => each === perDimension[0]);
const [commonUnit, common] = sameBudget
  ? ["evaluations", (i) => evaluations(0, i)]
  : byDimension
    ? ["evaluations / dimension", (i) => (grid[i] / grid[last]) * perDimension[0]]
    : ["% of the budget", (i) => (100 * grid[i]) / grid[last]];

// The values by which runs are compared: at the whole budget their places among all runs of the problem, which are
// exact; before, values rounded to 0.12 %. Of medians where not all runs are here.
const compared = (cell, i) =>
  !data.complete ? [quartiles(cell)[1][i]] : i === last ? cell.place : curves(cell).map((curve) => curve[i]);

const ranks = (p, chosen, i) => {
  const own = chosen.filter((o) => cells[p][o]);
  const found = standing(own.map((o) => compared(cells[p][o], i)));
  return new Map(own.map((o, at) => [o, found[at]]));
};

// Features by which problems are chosen, and the levels of the targets

const features = [...new Set(problems.flatMap((each) => Object.keys(each.features)))]
  .map((name) => [name, [...new Set(problems.map((each) => each.features[name] ?? ""))]])
  .filter(([, values]) => values.length > 1 && values.length <= 40);
const levels = [...new Set(problems.flatMap((each) => each.targets.map(([level]) => level)))].sort((a, b) => b - a);
