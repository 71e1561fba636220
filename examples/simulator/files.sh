#!/bin/sh
# A simulator that reads a file and writes a file: problem = ["./files.sh", "{in}", "{out}"]; both are in a folder of its own.
# $1 has a line "height = 120.5" for each variable; the last line of $2 is the value, and the violations after it.
set -e
awk -F ' = ' '{ value[$1] = $2 } END {
  bend = 4e8 / (value["width"] * value["height"] ^ 3 * (1 + value["ribs"] / 10))
  stress = 3e7 / (value["width"] * value["height"] ^ 2)
  mass = 1e-3 * (2 * value["width"] * 5 + value["height"] * 3) + 0.2 * value["ribs"]
  printf "bending: %g mm\nstress: %g MPa\n%.17g %.17g %.17g\n", bend, stress, mass, bend - 1, stress - 80
}' "$1" > "$2"
