"""A folder keeps its study beside the trials that it was made with."""

import os

import pytest

from bench import BenchError, Study, load_results, run
from bench.storage.folder import Folder

STUDY = {
    "name": "tiny", "trials": 2, "budget": 20,
    "problems": [{"name": "sphere-2"}], "optimizers": [{"name": "scatter"}],
}  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory, testing_plugins):
    path = tmp_path_factory.mktemp("folder") / "out"
    run(Study.from_dict(STUDY), path, n_jobs=1)
    return path


@pytest.fixture
def edited(folder):
    """Return the folder while a text of its study is replaced by another one."""
    file = folder / "study.toml"
    written = file.read_text()

    def edit(old, new):
        assert old in written
        file.write_text(written.replace(old, new))
        return folder

    yield edit
    file.write_text(written)


@pytest.mark.parametrize(
    "command",
    [
        ["report", "out"], ["status", "out"], ["export", "out", "--format", "csv"], ["verify", "out"], ["check", "out"],
        ["merge", "out", "-o", "merged"], ["pack", "out"], ["rm", "out", "--failed"],
    ],
    ids=lambda words: words[0],
)  # fmt: skip
def test_a_study_that_was_edited_beside_its_trials_is_refused_in_one_sentence(command, edited, bench_here):
    path = edited("budget = 20", "budget = 5000")
    done = bench_here(*command, cwd=path.parent)
    assert done.returncode == 2, done.stdout
    (sentence,) = done.stderr.strip().splitlines()
    assert "study.toml was changed: the trials beside it were made with the study of hash" in sentence


def test_what_decides_no_trial_may_be_edited(edited):
    path = edited('title = ""', 'title = "A title"')
    assert len(load_results(path)) == 2


def test_a_run_whose_lock_was_removed_still_keeps_others_out(tmp_path):
    folder = Folder(tmp_path)
    with folder.lock():
        (tmp_path / ".lock").unlink()
        with (
            pytest.raises(BenchError, match=rf"another run \(process {os.getpid()} .* is writing to"),
            Folder(tmp_path).lock(),
        ):
            pass
        assert folder.running()["pid"] == os.getpid()
    with Folder(tmp_path).lock():
        pass


def test_a_link_to_nothing_in_the_place_of_a_folder_is_a_sentence(tmp_path):
    (tmp_path / "link").symlink_to(tmp_path / "nowhere")
    missing = r"cannot be written: .*link is a link to .*nowhere, which is not there"
    with pytest.raises(BenchError, match=missing), Folder(tmp_path / "link").lock():
        pass
