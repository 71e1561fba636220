"""The example's loop with the real llamea package, in an environment of its own."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]


@pytest.mark.slow
def test_five_generations_of_prepared_answers_are_judged_and_the_best_is_compared(tmp_path):
    place, uv = tmp_path / "venv", [sys.executable, "-m", "uv"]
    subprocess.run([*uv, "venv", "--python", sys.executable, place], check=True, capture_output=True)
    wanted = ["llamea", "-e", str(ROOT), "coco-experiment"]
    done = subprocess.run(
        [*uv, "pip", "install", "--python", place, *wanted], capture_output=True, text=True, check=False
    )
    if done.returncode:
        pytest.skip(f"llamea cannot be installed: {done.stderr.strip().splitlines()[-1]}")
    command = [place / "bin" / "python", ROOT / "examples" / "generated" / "loop.py", "--no-sandbox"]
    loop = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=1200, check=False)
    assert loop.returncode == 0, loop.stderr
    assert "best: Narrowing" in loop.stdout
    assert "candidates had been judged on the training problems" in loop.stdout
    judged = [json.loads(line) for line in (tmp_path / "runs.jsonl").read_text().splitlines()]
    assert len(judged) == 10
    assert {each["error"] != "" for each in judged} == {True, False}
    assert all((each["score"] > 0) == (each["error"] == "") for each in judged)
