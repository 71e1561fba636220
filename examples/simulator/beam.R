# The simulator of beam.c: problem = ["Rscript", "beam.R"]; it needs the package jsonlite.
cat('{"protocol": 1, "variables": ["height", "width", "ribs"], "lower": [50, 20, 1], ',
    '"upper": [200, 100, 8], "integer": [false, false, true]}\n', sep = "")
flush(stdout()) # after every line
input <- file("stdin", "r")
while (length(line <- readLines(input, 1))) { # {"x": [120.5, 40.25, 3]}
  x <- jsonlite::fromJSON(line)$x
  bend <- 4e8 / (x[2] * x[1]^3 * (1 + x[3] / 10)) # mm
  mass <- 1e-3 * (2 * x[2] * 5 + x[1] * 3) + 0.2 * x[3] # kg
  cat(sprintf('{"f": %.17g}\n', mass + 10 * max(0, bend - 1)))
  flush(stdout())
}
