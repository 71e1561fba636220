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

// The share of a cell's runs that are better than a run of another optimizer, of whom all are taken together; a tie
// counts half (Mann-Whitney). Of medians where not all runs are here.
const superiority = (p, chosen, i) => {
  const own = chosen.filter((o) => cells[p][o]);
  const pool = own.flatMap((o) => {
    const values = data.complete ? curves(cells[p][o]).map((curve) => curve[i]) : [quartiles(cells[p][o])[1][i]];
    return values.map((value) => ({ o, value }));
  });
  pool.sort((a, b) => (a.value < b.value ? -1 : a.value > b.value ? 1 : 0));
  const sums = new Map(own.map((o) => [o, { above: 0, n: 0 }]));
  for (let start = 0; start < pool.length; ) {
    let end = start;
    while (end < pool.length && pool[end].value === pool[start].value) end++;
    const middle = (start + 1 + end) / 2;
    for (; start < end; start++) {
      const sum = sums.get(pool[start].o);
      sum.above += pool.length - middle;
      sum.n++;
    }
  }
  return new Map(
    [...sums].map(([o, { above, n }]) => [o, n < pool.length ? (above - (n * (n - 1)) / 2) / (n * (pool.length - n)) : NaN]),
  );
};

const ranks = (p, chosen, i) => {
  const better = superiority(p, chosen, i);
  const order = [...better].sort((a, b) => b[1] - a[1]);
  const found = new Map();
  for (let start = 0; start < order.length; ) {
    let end = start;
    do end++;
    while (end < order.length && order[start][1] - order[end][1] < 1e-9);
    const rank = (start + 1 + end) / 2;
    for (; start < end; start++) found.set(order[start][0], { rank, better: order[start][1] });
  }
  return found;
};

// Features by which problems are chosen, and the levels of the targets

const features = [...new Set(problems.flatMap((each) => Object.keys(each.features)))]
  .map((name) => [name, [...new Set(problems.map((each) => each.features[name] ?? ""))]])
  .filter(([, values]) => values.length > 1 && values.length <= 40);
const levels = [...new Set(problems.flatMap((each) => each.targets.map(([level]) => level)))].sort((a, b) => b - a);
