"""Shorten the paths of an SVG without moving a point."""

from __future__ import annotations

import re

PER_POINT = 100  # steps of a coordinate, which hide no pixel
PAIRS = {"M": 1, "L": 1, "C": 3, "Q": 2}  # pairs of coordinates of a step, by command
NUMBER = re.compile(r"-?\d*\.?\d+(?:e[-+]?\d+)?")
COMMAND = re.compile(r"([A-Za-z])([^A-Za-z]*(?:e[-+]?\d[^A-Za-z]*)*)")

Step = tuple[str, list[int]]  # a command and its numbers, in hundredths


def shortened(path: str) -> str:
    """Return the data of a path in relative steps, with coordinates of 0.01.

    Steps of no length are left out, and level or upright steps in one direction joined, as a curve that stays where it
    is has one for each of its points. Each step leads from one rounded point to the next, so no error adds up. A path
    that does not begin with M, or has other commands than M, L, C, Q and Z, the ones that matplotlib writes, comes
    back as it is.
    """
    commands = COMMAND.findall(path)
    if not commands or commands[0][0] != "M" or any(command not in {*PAIRS, "Z", "z"} for command, _ in commands):
        return path
    steps: list[Step] = []
    here = start = (0, 0)
    for command, text in commands:
        if command not in PAIRS:
            steps.append(("z", []))
            here = start
            continue
        numbers = [round(PER_POINT * float(number)) for number in NUMBER.findall(text)]
        size = 2 * PAIRS[command]
        for at in range(0, len(numbers), size):
            pairs = numbers[at : at + size]
            relative = [value - here[place % 2] for place, value in enumerate(pairs)]
            here = (pairs[-2], pairs[-1])
            if command == "M":
                start = here
            _add(steps, command.lower(), relative)
            command = "L" if command == "M" else command  # further pairs after M are lines
    return _written(steps)


def _add(steps: list[Step], command: str, numbers: list[int]) -> None:
    """Add a step, or lengthen the last one by it."""
    if command == "l" and 0 in numbers and steps[-1][0] != "m":
        if numbers == [0, 0]:
            return
        command, length = ("h", numbers[0]) if numbers[1] == 0 else ("v", numbers[1])
        before, lengths = steps[-1]
        if before == command and (lengths[0] > 0) == (length > 0):
            lengths[0] += length
            return
        numbers = [length]
    steps.append((command, numbers))


def _written(steps: list[Step]) -> str:
    """Return steps as text: a command only where it changes, a space only where two numbers would become one."""
    text, last = "", ""
    for command, numbers in steps:
        words = [_number(number) for number in numbers]
        joined = "".join(word if place == 0 or word[0] == "-" else f" {word}" for place, word in enumerate(words))
        repeated = command == last and command not in "mz"
        text += (joined if joined[0] == "-" else f" {joined}") if repeated else command + joined
        last = command
    return text


def _number(hundredths: int) -> str:
    return re.sub(r"^(-?)0\.", r"\1.", f"{hundredths / PER_POINT:.2f}".rstrip("0").rstrip("."))
