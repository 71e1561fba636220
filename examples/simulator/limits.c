// The beam of beam.c with its limits as constraints; build it by: cc -O2 -o limits limits.c -lm
// A run of the simulator gives all three: the mass, the bending and the stress.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
int main(void) {
  static char line[1 << 16];
  printf("{\"protocol\": 1, \"variables\": [\"height\", \"width\", \"ribs\"], \"lower\": [50, 20, 1], "
         "\"upper\": [200, 100, 8], \"integer\": [false, false, true], \"violations\": 2, \"measure\": \"the mass in kg\"}\n");
  fflush(stdout);
  while (fgets(line, sizeof line, stdin)) {
    char *at = strchr(line, '[');
    if (!at) exit(1);
    double height = strtod(at + 1, &at), width = strtod(at + 1, &at), ribs = strtod(at + 1, &at);
    double bend = 4e8 / (width * pow(height, 3) * (1 + ribs / 10)); // mm
    double stress = 3e7 / (width * height * height); // MPa
    double mass = 1e-3 * (2 * width * 5 + height * 3) + 0.2 * ribs; // kg
    printf("{\"f\": %.17g, \"g\": [%.17g, %.17g]}\n", mass, bend - 1, stress - 80); // at most 0 where it holds
    fflush(stdout);
  }
}
