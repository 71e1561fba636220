// A simulator that runs for as long as a trial does; build it by: cc -O2 -o beam beam.c -lm
// The mass of a beam's two flanges and its web, where a load may bend it by no more than 1 mm.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
int main(void) {
  static char line[1 << 16];
  printf("{\"protocol\": 1, \"variables\": [\"height\", \"width\", \"ribs\"], \"lower\": [50, 20, 1], "
         "\"upper\": [200, 100, 8], \"integer\": [false, false, true]}\n");
  fflush(stdout); // after every line
  while (fgets(line, sizeof line, stdin)) { // {"x": [120.5, 40.25, 3]}
    char *at = strchr(line, '[');
    if (!at) exit(1);
    double height = strtod(at + 1, &at), width = strtod(at + 1, &at), ribs = strtod(at + 1, &at);
    double bend = 4e8 / (width * pow(height, 3) * (1 + ribs / 10)); // mm
    double mass = 1e-3 * (2 * width * 5 + height * 3) + 0.2 * ribs; // kg
    printf("{\"f\": %.17g}\n", mass + 10 * fmax(0, bend - 1));
    fflush(stdout);
  }
}
