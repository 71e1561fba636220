// A (1+1) search with the one-fifth rule; build it by: cc -O2 -o climb climb.c -lm
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
static char line[1 << 20];
static double seed; // of the generator MINSTD, which is exact in double precision
static double uniform(void) { return (seed = fmod(16807 * seed, 2147483647)) / 2147483647; }
static void numbers(const char *name, double *to, int n) { // the numbers that follow a name in the line
  char *at = strstr(line, name) + strlen(name);
  for (int j = 0; j < n; j++) to[j] = strtod(at + strcspn(at, "-0123456789"), &at);
}
static void answer(const char *name, double *to, int n) {
  fflush(stdout);
  if (!fgets(line, sizeof line, stdin) || strstr(line, "\"stop\"")) exit(0);
  numbers(name, to, n);
}
static double value(const double *x, int d) {
  double f;
  for (int j = 0; j < d; j++) printf("%s%.17g", j ? ", " : "{\"x\": [[", x[j]);
  printf("]]}\n");
  answer("\"f\":", &f, 1);
  return f;
}
int main(void) {
  double dimension, lower[1000], upper[1000], x[1000], y[1000], step = 0.2;
  answer("\"dimension\":", &dimension, 1);
  int d = (int)dimension;
  numbers("\"lower\":", lower, d), numbers("\"upper\":", upper, d), numbers("\"seed\":", &seed, 1);
  printf("{\"initial\": 1}\n"), answer("\"x\":", x, d);
  for (double f = value(x, d);;) {
    for (int j = 0; j < d; j++) {
      y[j] = x[j] + step * (upper[j] - lower[j]) * (2 * uniform() - 1);
      y[j] = fmin(fmax(y[j], lower[j]), upper[j]);
    }
    double g = value(y, d);
    step *= g <= f ? 1.5 : 0.9036020036098449;
    if (g <= f) f = g, memcpy(x, y, sizeof x);
  }
}
