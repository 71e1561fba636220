"""COCO's best points: its package prints them to a file in the working folder, so another process asks for them."""

import json
import subprocess
import sys

import cocoex
import numpy as np

CODE = """
import cocoex, json, sys
for suite, function, dimension, instance in json.loads(sys.argv[1]):
    only = f"dimensions: {dimension} function_indices: {function}"
    cocoex.Suite(suite, f"instances: {instance}", only)[0]._best_parameter("print")
    print(*open("._bbob_problem_best_parameter.txt").read().split())
"""


def best_points(cases, folder):
    """Return COCO's best point of each case: suite, index of the function from 1, dimension and instance."""
    done = subprocess.run(
        [sys.executable, "-c", CODE, json.dumps(cases)], cwd=folder, capture_output=True, text=True, check=True
    )
    return dict(zip(cases, (np.array(line.split(), float) for line in done.stdout.splitlines()), strict=True))


def function_of(suite, function, dimension, instance):
    """Return COCO's function object of a case."""
    return cocoex.Suite(suite, f"instances: {instance}", f"dimensions: {dimension} function_indices: {function}")[0]


def name(suite, function, dimension, instance):
    """Return this project's name of a case."""
    return f"{suite}-f{function:02d}-d{dimension}-i{instance}"
