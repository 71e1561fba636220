# A (1+1) search with the one-fifth rule: command = ["julia", "climb.jl"]; it needs the package JSON.
using JSON

function answer()
    line = readline()
    message = isempty(line) ? Dict("stop" => "the harness has ended") : JSON.parse(line)
    haskey(message, "stop") && exit()
    return message
end
function ask(request)
    println(JSON.json(request))
    flush(stdout)
    return answer()
end
value(x) = Float64(ask(Dict("x" => [x]))["f"][1])

function search()
    start = answer()
    lower, upper = Float64.(start["lower"]), Float64.(start["upper"])
    seed, step = Float64(start["seed"]), 0.2
    x = Float64.(ask(Dict("initial" => 1))["x"][1])
    f = value(x)
    while true
        y = similar(x)
        for j in eachindex(x)
            seed = mod(16807 * seed, 2147483647) # the generator MINSTD, which is exact in double precision
            y[j] = x[j] + step * (upper[j] - lower[j]) * (2 * seed / 2147483647 - 1)
        end
        y = clamp.(y, lower, upper)
        g = value(y)
        step *= g <= f ? 1.5 : 0.9036020036098449
        g <= f && ((x, f) = (y, g))
    end
end
search()
