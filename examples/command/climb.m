% A (1+1) search with the one-fifth rule: command = ["octave-cli", "--quiet", "climb.m"]; Octave 7 or later.
sigterm_dumps_octave_core(false); % or each trial that is ended leaves a file octave-workspace
function line = answer()
  line = input("", "s"); % fgetl would wait for the line after this one
  if index(line, '"stop"'), exit; end
end
function values = numbers(line, name) % jsondecode would lose the last digit
  values = str2num(["[" regexp(line, ["\"" name "\": \\[*([^\\]\"]*)"], "tokens"){1}{1} "]"]);
end
function line = ask(request)
  printf("%s\n", request);
  fflush(stdout);
  line = answer();
end
function f = value(x)
  written = strjoin(arrayfun(@(each) sprintf("%.17g", each), x, "UniformOutput", false), ", ");
  f = numbers(ask(sprintf('{"x": [[%s]]}', written)), "f");
end
function [drawn, seed] = uniform(n, seed)
  drawn = zeros(1, n);
  for j = 1:n
    seed = mod(16807 * seed, 2147483647); % the generator MINSTD, which is exact in double precision
    drawn(j) = seed / 2147483647;
  end
end
first = answer();
[lower, upper, seed, step] = deal(numbers(first, "lower"), numbers(first, "upper"), numbers(first, "seed"), 0.2);
x = numbers(ask('{"initial": 1}'), "x");
f = value(x);
while true
  [drawn, seed] = uniform(numel(x), seed);
  y = x + step * (upper - lower) .* (2 * drawn - 1);
  y = min(max(y, lower), upper);
  g = value(y);
  if g <= f
    [x, f, step] = deal(y, g, step * 1.5);
  else
    step = step * 0.9036020036098449;
  end
end
