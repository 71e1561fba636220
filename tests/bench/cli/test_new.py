"""``bench new``: packages and studies made from the examples, and the names that it refuses.

tests/test_examples.py builds, installs and runs what it writes.
"""

import tomllib

import pytest
import yaml

from bench import BenchError, Study
from bench.cli import new


def test_a_package_has_its_own_name_everywhere(tmp_path):
    folder = new.create("optimizer", "my-swarm-2", tmp_path / "made")
    made = {path.relative_to(folder).as_posix(): path.read_text() for path in folder.rglob("*") if path.is_file()}
    assert set(made) == {
        ".gitignore", ".github/workflows/gate.yml", ".github/workflows/tests.yml", "README.md", "gate.toml",
        "pyproject.toml", "src/my_swarm_2.py", "study.toml", "tests/test_my_swarm_2.py",
    }  # fmt: skip
    for text in made.values():
        assert not {"hill-climber", "hill_climber", "HillClimber"} & set(text.replace('"', " ").split())
    assert "class MySwarm2(Optimizer)" in made["src/my_swarm_2.py"]
    project = tomllib.loads(made["pyproject.toml"])["project"]
    assert project["entry-points"]["bench.optimizers"] == {"my-swarm-2": "my_swarm_2:MySwarm2"}
    for workflow in ("gate", "tests"):
        text = made[f".github/workflows/{workflow}.yml"]
        assert yaml.safe_load(text)["name"] == workflow
        assert yaml.safe_load(text)["env"] == {"BENCH_SOURCE": "${{ vars.BENCH_SOURCE || 'backlash-bench' }}"}
        assert 'pip install "$BENCH_SOURCE"' in text
    assert tomllib.loads(made["gate.toml"])["optimizers"] == [{"name": "my-swarm-2"}]
    assert "bench run gate.toml" in made[".github/workflows/gate.yml"]


def test_a_study_is_a_file_that_can_be_run(bench_here, tmp_path):
    done = bench_here("new", "study", "mine", cwd=tmp_path)
    assert done.returncode == 0
    assert done.stdout == "wrote mine.toml; next: bench run mine.toml\n"
    assert Study.load(tmp_path / "mine.toml").name == "mine"


@pytest.mark.parametrize("kind", ["optimizer", "study"])
def test_nothing_that_exists_is_written_over(kind, tmp_path):
    (tmp_path / "here").write_text("mine")
    with pytest.raises(BenchError, match="exists already; choose another name, or give another --output"):
        new.create(kind, "fresh", tmp_path / "here")
    assert (tmp_path / "here").read_text() == "mine"
