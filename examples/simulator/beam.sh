#!/bin/sh
# A script around a simulator that is started for each point: beam.sh HEIGHT WIDTH RIBS prints the value last.
set -e
folder=$(mktemp -d) # of its own, as several may run at a time
trap 'rm -r "$folder"' EXIT
printf 'height = %s\nwidth = %s\nribs = %s\n' "$1" "$2" "$3" > "$folder/input.txt"
# Here would stand: my-simulator "$folder/input.txt" > "$folder/output.txt"
awk -F ' = ' '{ value[$1] = $2 } END {
  bend = 4e8 / (value["width"] * value["height"] ^ 3 * (1 + value["ribs"] / 10))
  mass = 1e-3 * (2 * value["width"] * 5 + value["height"] * 3) + 0.2 * value["ribs"]
  printf "bending: %g mm\nvalue: %.17g\n", bend, mass + 10 * (bend > 1 ? bend - 1 : 0)
}' "$folder/input.txt" > "$folder/output.txt"
sed -n 's/^value: //p' "$folder/output.txt"
