"""How a study is conducted: what runs, what is kept, what is written, what the command says."""

from __future__ import annotations

import dataclasses
import json
import os
import signal
import subprocess
import sys
from dataclasses import dataclass

import pytest

from asap_laboratory import STUDIES, conduct
from asap_laboratory.cli import main
from asap_laboratory.schemes.cases import Case
from asap_laboratory.schemes.probes import SteadyProbe
from asap_laboratory.study import Batch, State, Study, key_of, write
from house import ROOT

PAGES = ROOT / "python" / "laboratory" / "pages"
SMALL = Case("low", "slow", duration_s=0.05, contenders=("Greedy", "Deadline"))


@dataclass(frozen=True)
class Counted:
    """A task that writes down that it ran."""

    number: int
    measured = []  # noqa: RUF012

    def weight(self):
        return float(self.number)

    def measure(self):
        self.measured.append(self.number)
        return [{"number": self.number, "value": 2.0 * self.number}]


@pytest.fixture
def measured():
    Counted.measured.clear()
    return Counted.measured


@pytest.fixture
def study(tmp_path, measured):
    """Two batches, of which the second depends on what the first has found."""

    def batches(form):
        first = yield Batch([Counted(1), Counted(2)], one_at_a_time=True)
        yield Batch([Counted(10 + len(first) + (form == "full"))])

    (tmp_path / "page.md").write_text(
        "{{ run.command }} {{ doubled }}\n{{ listing(tables.counts, {'value': 'value'}) }}\n"
    )
    return Study(
        name="counts",
        command="asap-study",
        template=tmp_path / "page.md",
        batches=batches,
        summary=lambda rows: {
            "counts": rows,
            "goals": [{"goal": "G", "holds": sum(row["value"] for row in rows) >= 30}],
        },
        tables=("counts", "goals"),
        cells={"value": lambda row: f"{row['value']:.1f}"},
        facts=lambda tables: {"doubled": 2 * len(tables["counts"])},
        shown=lambda tables, writer: f"{len(tables['counts'])} counted",
    )


# ---- conduct --------------------------------------------------------------------------------


def test_a_study_is_measured_written_and_goes_on_where_it_stopped(study, measured, tmp_path):
    out = tmp_path / "out"
    found = conduct(study, out, workers=1)
    assert measured == [2, 1, 12]  # the heavy ones first, batch by batch
    assert found.paths == [out / "counts.md", out / "data" / "counts.csv"]
    assert (out / "counts.md").read_text() == (
        "asap-study 6\n| value |\n| --- |\n| 2.0 |\n| 4.0 |\n| 24.0 |\n"
    )
    assert (out / "data" / "counts.csv").read_text() == "number,value\n1,2\n2,4\n12,24\n"
    again = conduct(study, out, workers=1)
    assert (again.taken_from_file, again.tables["counts"]) == (3, found.tables["counts"])
    full = conduct(study, out, workers=1, form="full")
    assert full.taken_from_file == 2 and full.tables["run"][0]["command"] == "asap-study --full"
    assert measured == [2, 1, 12, 13]
    assert conduct(study, out, workers=1, fresh=True).taken_from_file == 0


def test_page_and_figures_are_made_of_the_files(study, tmp_path):
    out = tmp_path / "out"
    conduct(study, out, workers=1)
    (out / "data" / "counts.csv").write_text("number,value\n1,5\n")
    found = write(study, out)
    assert (out / "counts.md").read_text().endswith("| 5.0 |\n")
    assert found.tables["counts"] == [{"number": 1, "value": 5}]


def test_what_it_does_not_know_is_refused(study, tmp_path):
    with pytest.raises(ValueError, match="form = 'slow'"):
        conduct(study, tmp_path / "out", form="slow")
    with pytest.raises(ValueError, match="workers = 0"):
        conduct(study, tmp_path / "out", workers=0)
    assert not (tmp_path / "out").exists()


# ---- tasks ----------------------------------------------------------------------------------


def test_key_tells_tasks_and_builds_apart(monkeypatch):
    keys = {key_of(SMALL)}
    for change in ({"seed": 2}, {"duration_s": 0.1}, {"profile": "quiet"}, {"cost_model": "fast"}):
        keys.add(key_of(dataclasses.replace(SMALL, **change)))
    keys.add(key_of(SteadyProbe("slow", 1e6)))
    assert len(keys) == 6 and key_of(Case(*dataclasses.astuple(SMALL))) in keys
    monkeypatch.setattr("asap_laboratory.study._build", lambda: "another one")
    assert key_of(SMALL) not in keys


def test_a_line_that_was_cut_short_is_run_again(tmp_path, measured):
    tasks = Batch([Counted(number) for number in range(3)])
    path = tmp_path / "state.jsonl"
    State(path).run(tasks, workers=1)
    path.write_text(path.read_text()[:-20])
    measured.clear()
    assert State(path).run(tasks, workers=1) == 2 and measured == [0]
    assert State(path).run(tasks, workers=1) == 3


def test_progress_counts_what_is_left_and_an_interrupt_keeps_what_is_finished(tmp_path, measured):
    state, seen = State(tmp_path / "state.jsonl"), []
    state.run(Batch([Counted(1)]), workers=1)

    def interrupt(done, total, _):
        seen.append((done, total))
        if len(seen) == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        state.run(Batch([Counted(n) for n in (1, 2, 3, 4)]), workers=1, on_progress=interrupt)
    assert seen == [(4, 9), (7, 9)]
    assert len(State(tmp_path / "state.jsonl").entries) == 3


def test_processes_find_the_same_and_their_errors_come_out(tmp_path):
    tasks = [SMALL, SteadyProbe("slow", 1e5, duration_s=0.05)]
    here, there = State(tmp_path / "here.jsonl"), State(tmp_path / "there.jsonl")
    here.run(Batch(tasks), workers=1)
    there.run(Batch(tasks), workers=2)
    for key in map(key_of, tasks):
        assert here.entries[key]["rows"] == there.entries[key]["rows"]
    broken = dataclasses.replace(SMALL, contenders=("no such row",))
    with pytest.raises(KeyError, match="no such row"):
        there.run(Batch([broken]), workers=2)


INTERRUPTED = """
import os, signal, sys
from pathlib import Path
from asap_laboratory.schemes.probes import SteadyProbe
from asap_laboratory.study import Batch, State
signal.signal(signal.SIGINT, signal.default_int_handler)  # a background job ignores it

def interrupt_all(*_):
    os.killpg(0, signal.SIGINT)

def die(*_):
    os.kill(os.getpid(), signal.SIGKILL)

endless = SteadyProbe("slow", 1e6, duration_s=8e4)
first = SteadyProbe("slow", 1e5, duration_s=0.05)
waiting = [SteadyProbe("slow", 1e3, seed=seed) for seed in range(200)]
at_first = die if sys.argv[2] == "death" else interrupt_all
try:
    state = State(Path(sys.argv[1]))
    state.run(Batch([endless, first, *waiting]), workers=2, on_progress=at_first)
except KeyboardInterrupt:
    sys.exit(130)
"""


@pytest.mark.parametrize(
    ("when", "code"), [("interrupt", 130), ("death", -signal.SIGKILL)], ids=lambda one: str(one)
)
def test_workers_do_not_outlive_the_study(tmp_path, when, code):
    """A process whose task never ends leaves the output alone once its parent has gone."""
    done = subprocess.run(
        [sys.executable, "-c", INTERRUPTED, tmp_path / "state.jsonl", when],
        start_new_session=True,
        capture_output=True,
        text=True,
        timeout=100,
    )
    assert (done.returncode, done.stdout) == (code, "")
    assert when == "death" or done.stderr == ""


# ---- the command ----------------------------------------------------------------------------


@pytest.fixture
def command(study, monkeypatch, tmp_path):
    """Runs the command on the made-up study, and gives what it has said."""
    monkeypatch.setitem(STUDIES, "study", study)
    return lambda *words: main([*words, "--workers", "1", "--out", str(tmp_path / "out")])


def test_command_prints_and_writes(command, tmp_path, capsys):
    assert command() == 0
    out = tmp_path / "out"
    assert capsys.readouterr().out == (
        f"3 counted\n\nwrote {out / 'counts.md'}\nwrote {out / 'data' / 'counts.csv'}\n"
    )
    assert command("--json", "--full") == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["study"], document["form"]) == ("counts", "full")
    assert document["taken_from_file"] == 2 and len(document["tables"]["counts"]) == 3


def test_all_pages_are_those_of_every_study_and_the_figures(command, tmp_path, monkeypatch):
    pytest.importorskip("matplotlib")
    for name in [*STUDIES][1:]:
        monkeypatch.delitem(STUDIES, name)
    assert command("--all-pages") == 0
    written = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"counts.md", "schemes.svg", "scene_A.svg"} <= written
    assert "--full" in (tmp_path / "out" / "counts.md").read_text()
    assert command("--all-pages", "--json") == 2


def test_command_ends_with_1_where_a_goal_is_missed_and_makes_the_page_anew(command, tmp_path):
    assert command() == 0
    (tmp_path / "out" / "data" / "counts_goals.csv").write_text("goal,holds\nG,False\nH,\n")
    assert command("--page") == 1


def test_command_refuses_what_does_not_go_together(tmp_path, capsys):
    for words in (["--quick", "--full"], ["--rivals", "--real"], ["--workers", "none"]):
        assert main([*words, "--out", str(tmp_path / "out")]) == 2
    assert main(["--page", "--real", "--out", str(tmp_path / "out")]) == 2
    assert main(["--page", "--out", str(tmp_path / "out")]) == 2  # there are no data
    assert not (tmp_path / "out").exists()
    assert os.path.basename(str(tmp_path / "out")) in capsys.readouterr().err


# ---- what is published ----------------------------------------------------------------------


@pytest.mark.parametrize("name", ["study", "bounds", "accuracy", "rivals", "ladder"])
def test_the_published_page_is_that_of_its_data(name, tmp_path):
    (tmp_path / "data").symlink_to(PAGES / "data")
    study = dataclasses.replace(STUDIES[name], figures=lambda tables: {})
    found = write(study, tmp_path)
    published = (PAGES / f"{name}.md").read_text()
    assert found.paths[0].read_text() == published
    for figure in STUDIES[name].figures(found.tables) if name != "study" else ("scores",):
        assert f"]({figure}.svg)" in published and (PAGES / f"{figure}.svg").is_file()
