// A (1+1) search with the one-fifth rule: command = ["node", "climb.js"]
import { createInterface } from "node:readline";

const lines = createInterface({ input: process.stdin })[Symbol.asyncIterator]();
const answer = async () => {
  const { value, done } = await lines.next();
  const message = done ? { stop: "the harness has ended" } : JSON.parse(value);
  if ("stop" in message) process.exit();
  return message;
};
const ask = (request) => {
  console.log(JSON.stringify(request));
  return answer();
};
const valueOf = async (point) => (await ask({ x: [point] })).f[0];

let { lower, upper, seed } = await answer();
const uniform = () => {
  seed = (16807 * seed) % 2147483647; // the generator MINSTD, which is exact in double precision
  return seed / 2147483647;
};
let [x] = (await ask({ initial: 1 })).x;
let [f, step] = [await valueOf(x), 0.2];
for (;;) {
  const y = x.map((each, j) => {
    const moved = each + step * (upper[j] - lower[j]) * (2 * uniform() - 1);
    return Math.min(Math.max(moved, lower[j]), upper[j]);
  });
  const g = await valueOf(y);
  step *= g <= f ? 1.5 : 0.9036020036098449;
  if (g <= f) [x, f] = [y, g];
}
