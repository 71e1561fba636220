// Rank the optimizers of a problem by the rule of bench/analysis/standings.py; tests compare both, case by case.

/**
 * The rank, the rivals beaten and the mean A12 against them (NaN without a rival) of each sample of values.
 *
 * One beats another where more than half of the pairs of their values are lower with it (A12 > 0.5); a tie counts half.
 * The mean A12 decides between those that beat as many; ties share their mean rank.
 */
export const standing = (samples) => {
  const pool = samples.flatMap((values, owner) => Array.from(values, (value) => ({ owner, value })));
  pool.sort((a, b) => (a.value < b.value ? -1 : a.value > b.value ? 1 : 0));
  // Twice the pairs of which the other's value is lower
  const lost = samples.map(() => new Float64Array(samples.length));
  // The values of each that are lower, then those that are not higher
  const below = new Float64Array(samples.length);
  const count = ({ owner }) => {
    for (const [other, values] of below.entries()) lost[owner][other] += values;
  };
  for (let start = 0; start < pool.length; ) {
    let end = start;
    while (end < pool.length && pool[end].value === pool[start].value) end++;
    const equal = pool.slice(start, end);
    equal.forEach(count);
    for (const { owner } of equal) below[owner]++;
    equal.forEach(count);
    start = end;
  }
  const found = samples.map((values, own) => {
    const chances = samples.map((rivals, other) => lost[other][own] / (2 * values.length * rivals.length));
    chances.splice(own, 1);
    const beaten = chances.reduce((sum, chance) => sum + (chance > 0.5 ? 1 : chance === 0.5 ? 0.5 : 0), 0);
    return { beaten, chance: chances.length ? chances.reduce((a, b) => a + b, 0) / chances.length : NaN };
  });
  const keys = found.map(({ beaten, chance }) => 2e9 * beaten + Math.round(1e9 * (chance || 0)));
  const rank = (key) => keys.filter((each) => each > key).length + (keys.filter((each) => each === key).length + 1) / 2;
  return found.map((each, own) => ({ ...each, rank: rank(keys[own]) }));
};
