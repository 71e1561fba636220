# A (1+1) search with the one-fifth rule: command = ["Rscript", "climb.R"]; it needs the package jsonlite.
input <- file("stdin", "r")
answer <- function() {
  message <- jsonlite::fromJSON(readLines(input, 1), bigint_as_char = FALSE)
  if (!is.null(message$stop)) quit()
  message
}
ask <- function(request) {
  cat(request, "\n", sep = "")
  flush(stdout())
  answer()
}
value <- function(x) ask(sprintf('{"x": [[%s]]}', paste(sprintf("%.17g", x), collapse = ", ")))$f

start <- answer()
width <- start$upper - start$lower
seed <- start$seed
uniform <- function(n) {
  drawn <- numeric(n)
  for (j in seq_len(n)) {
    seed <<- (16807 * seed) %% 2147483647 # the generator MINSTD, which is exact in double precision
    drawn[j] <- seed / 2147483647
  }
  drawn
}
x <- as.vector(ask('{"initial": 1}')$x)
f <- value(x)
step <- 0.2
repeat {
  y <- x + step * width * (2 * uniform(length(x)) - 1)
  y <- pmin(pmax(y, start$lower), start$upper)
  g <- value(y)
  step <- step * if (g <= f) 1.5 else 0.9036020036098449
  if (g <= f) {
    x <- y
    f <- g
  }
}
