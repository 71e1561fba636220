// Numbers, their texts, and the scales of axes: functions of their arguments alone.

export const text = (value) => {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  if (Number.isInteger(value) && Math.abs(value) < 1e9) return value.toLocaleString("en");
  const size = Math.abs(value);
  return size >= 1e6 || size < 1e-3 ? value.toExponential(3) : String(Number(value.toPrecision(6)));
};
export const percent = (share) => (Number.isNaN(share) ? "–" : `${Number((100 * share).toPrecision(3))}%`);
/** A column may hold one value for all runs. */
export const one = (values, k) => (Array.isArray(values) ? values[k] : values);

export const decode = (code, length) => {
  const values = new Float64Array(length);
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

export const quartile = (sorted, share) => {
  const place = share * (sorted.length - 1);
  const [low, high] = [Math.floor(place), Math.ceil(place)];
  if (!Number.isFinite(sorted.at(-1))) return sorted[high];
  return sorted[low] + (place - low) * (sorted[high] - sorted[low]);
};

export const nearest = (values, wanted) =>
  values.reduce(
    (best, value, i) => (Math.abs(Math.log(value / wanted)) < Math.abs(Math.log(values[best] / wanted)) ? i : best),
    0,
  );
export const sameSet = (a, b) => a.size === b.length && b.every((each) => a.has(each));

/** The scale of an axis: its domain, that of the zoom where there is one; values of 0 stand at a log axis's low end. */
export const scaleOf = (values, wantsLog, zoomed) => {
  const finite = values.filter(Number.isFinite);
  const positive = finite.filter((value) => value > 0);
  const lowest = Math.min(...finite);
  const wide = positive.length && Math.max(...positive) > 30 * Math.min(...positive);
  const possible = positive.length > 0 && lowest >= 0;
  const log = possible && (wantsLog ?? wide);
  const floor = log ? Math.min(...positive) / (lowest === 0 ? 3 : 1) : lowest;
  let domain = finite.length ? [floor, Math.max(...finite)] : [0, 1];
  if (domain[0] === domain[1]) domain = log ? [domain[0] / 2, domain[0] * 2] : [domain[0] - 0.5, domain[1] + 0.5];
  return { log, floor, full: domain, domain: zoomed ?? domain, refused: wantsLog && !possible };
};

/** The scale with a margin on both sides, so that no point stands on an edge; a zoomed one as it is. */
export const padded = (scale) => {
  if (scale.domain !== scale.full) return scale;
  const [low, high] = along(scale, scale.full);
  const margin = 0.03 * (high - low);
  return { ...scale, domain: back(scale, [low - margin, high + margin]) };
};
export const along = (scale, domain) => (scale.log ? domain.map(Math.log) : domain);
export const back = (scale, domain) => (scale.log ? domain.map(Math.exp) : domain);
