"""How a pipeline and a replay end with their process: exit, Ctrl-C, SIGTERM, fork."""

from __future__ import annotations

import os
import signal
from textwrap import dedent, indent

import pytest

from children import LONG, PATIENCE, run_script, send_when_ready

SAY_THAT_IT_RUNS = """
time.sleep(0.2)
print(time.monotonic(), flush=True)
"""

# What a daemon thread does while the interpreter exits.
BUSY = {
    "waits in the loop": "in_background(lambda: list(asap.Pipeline()))",
    "works natively in run": """
        pipeline = asap.Pipeline(asap.ClusterTracker(346, 260))
        in_background(camera, pipeline)
        in_background(pipeline.run)
        """,
    "never leaves a callback": """
        def spin(events):
            while True: pass
        pipeline = asap.Pipeline(spin)
        fill(pipeline, 10)
        in_background(pipeline.run)
        """,
    "sleeps in a callback": """
        pipeline = asap.Pipeline(lambda events: time.sleep(0.65))
        fill(pipeline, 10)
        in_background(pipeline.run)
        """,
    "waits for room": """
        pipeline = asap.Pipeline(capacity=64, when_full="block")
        in_background(fill, pipeline, 1000)
        """,
    "filters in front": """
        pipeline = asap.Pipeline(lambda events: None, before=lambda events: events[::2].copy())
        in_background(camera, pipeline)
        in_background(pipeline.run)
        """,
    "begins again and again": """
        def again(pipeline):
            while True:
                with pipeline:
                    after(0.001, pipeline.stop)
                    list(pipeline)
        in_background(again, asap.Pipeline(capacity=64))
        """,
    "replays": """
        events = np.zeros(2, asap.EVENT_DTYPE)
        events["t"] = [0, 3_600_000_000]
        in_background(lambda: asap.run(events, algorithm=lambda events: None))
        """,
}


@pytest.mark.parametrize("what", BUSY)
def test_the_interpreter_exits_while_a_thread(what):
    for _ in range(10 if LONG else 1):
        ended = run_script(dedent(BUSY[what]) + SAY_THAT_IT_RUNS)
        assert ended.code == 0, ended.errors
        assert "terminate" not in ended.errors
        assert ended.took_s < 1.0 * PATIENCE


# What an ordinary thread does when the main one is at its end.
CONSUMES = {
    "runs": """
        pipeline = asap.Pipeline(asap.ClusterTracker(64, 64), latency_ms=1)
        threading.Thread(target=pipeline.run).start()
        """,
    "runs for a camera in the background": """
        def push():
            while True:
                fill(pipeline, 10)
        pipeline = asap.Pipeline(lambda events: None)
        in_background(push)
        threading.Thread(target=pipeline.run).start()
        """,
    "works in the loop": """
        def work(pipeline):
            for package in pipeline:
                time.sleep(0.001)
        pipeline = asap.Pipeline()
        in_background(camera, pipeline, 10)
        threading.Thread(target=work, args=(pipeline,)).start()
        """,
    "runs in a pool": """
        import concurrent.futures
        concurrent.futures.ThreadPoolExecutor().submit(asap.Pipeline(lambda events: None).run)
        """,
    "runs in a forked process": """
        import warnings
        warnings.simplefilter("ignore")
        threading.Thread(target=list, args=(asap.Pipeline(),)).start()
        if os.fork() == 0:
            threading.Thread(target=list, args=(asap.Pipeline(),)).start()
            sys.exit(0)
        assert os.wait()[1] == 0
        """,
}


@pytest.mark.parametrize("what", CONSUMES)
def test_the_program_ends_while_an_ordinary_thread(what):
    for _ in range(10 if LONG else 1):
        ended = run_script(dedent(CONSUMES[what]) + SAY_THAT_IT_RUNS)
        assert ended.code == 0, ended.errors
        assert not ended.errors
        assert ended.took_s < 1.0 * PATIENCE


def test_nothing_waits_any_more_when_the_interpreter_exits():
    ended = run_script(
        """
        pipeline = asap.Pipeline()
        fill(pipeline, 10)
        """,
        before=dedent(
            """
            import atexit
            @atexit.register  # runs after the hook that stops the pipelines
            def report():
                fill(pipeline, 10)  # stays where it is
                ledger = pipeline.ledger
                print(pipeline.state, list(pipeline), ledger.received, ledger.pending)
                pipeline.stop()
                try:
                    pipeline.start()
                except RuntimeError as error:
                    print(error)
            """
        ),
    )
    assert ended.code == 0, ended.errors
    assert ended.lines == ["stopped [] 20 20", "pipeline: the interpreter exits"]


# Ctrl-C during the first import, in a function that it calls; a second one follows.
IMPORT_INTERRUPTED = """
import atexit, numpy
def interrupted(*arguments):
    real(*arguments)
    raise KeyboardInterrupt
{0}, real = interrupted, {0}
try:
    import asap
except (KeyboardInterrupt, ImportError):
    print("interrupted")
{0} = real
"""


def test_an_import_may_be_interrupted():
    before = IMPORT_INTERRUPTED.format("atexit.register")
    ended = run_script(BUSY["waits in the loop"] + SAY_THAT_IT_RUNS, before=before)
    assert ended.code == 0, ended.errors
    assert ended.lines[0] == "interrupted"
    assert ended.took_s < 1.0 * PATIENCE


INTERRUPTED = {
    "a waiting loop": "list(pipeline)",
    "a busy body": """
        in_background(camera, pipeline)
        for package in pipeline:
            package.events["x"].sum()
        """,
    "run with a busy callback": """
        pipeline = asap.Pipeline(lambda events: events["x"].sum())
        in_background(camera, pipeline)
        pipeline.run()
        """,
    "run with a native algorithm": """
        pipeline = asap.Pipeline(asap.ClusterTracker(346, 260))
        in_background(camera, pipeline)
        pipeline.run()
        """,
    "a push that waits for room": """
        pipeline = asap.Pipeline(capacity=64, when_full="block")
        fill(pipeline, 1000)
        """,
    "looks and flushes": """
        in_background(camera, pipeline)
        in_background(lambda: list(pipeline))
        while True:
            pipeline.flush()
            pipeline.stats()
        """,
    "a replay of an array": "asap.run(an_hour, algorithm=len)",
    "a replay of a stream": "asap.run(iter([an_hour]), algorithm=len)",
    "a replay of a stream that waits": """
        def stream():
            yield an_hour
            threading.Event().wait()
        asap.run(stream(), algorithm=len)
        """,
}


INTERRUPT_ME = """
sent = []
ready = threading.Event()
def interrupt():
    ready.wait()
    time.sleep(0.3)
    sent.append(time.monotonic())
    os.kill(os.getpid(), signal.SIGINT)
pipeline = asap.Pipeline()
an_hour = np.zeros(2, asap.EVENT_DTYPE)
an_hour["t"] = [0, 3_600_000_000]
in_background(interrupt)
try:
    ready.set()
{}
except KeyboardInterrupt:
    took = time.monotonic() - sent[0]
pipeline.stop(drain=False)
assert pipeline.ledger.balanced
assert asap.last_run() is None or asap.last_run().ledger.balanced
print(took)
"""


@pytest.mark.parametrize("what", INTERRUPTED)
def test_ctrl_c_interrupts(what):
    ended = run_script(INTERRUPT_ME.format(indent(dedent(INTERRUPTED[what]), "    ")))
    assert ended.code == 0, ended.errors
    assert float(ended.lines[-1]) < 0.1 * PATIENCE


AFTER_A_SIGNAL = """
pipeline = asap.Pipeline(capacity=64, when_full="block")
def handle(*_):
    time.sleep(0.3)
    {}
signal.signal(signal.SIGTERM, handle)
def disturb():
    while pipeline.ledger.pending < 64:
        time.sleep(0.001)
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(0.1)
    pipeline.stop()
in_background(disturb)
fill(pipeline, 1000)
print(pipeline.state, pipeline.ledger.received, pipeline.ledger.overflow)
"""


@pytest.mark.parametrize("what", ["pipeline.stop()", "pipeline.ledger", "pipeline.stats()"])
def test_a_signal_handler_may_stop_and_look_while_a_push_waits(what):
    ended = run_script(AFTER_A_SIGNAL.format(what))
    assert ended.code == 0, ended.errors
    assert ended.lines == ["stopped 1000 936"]


def test_sigterm_ends_the_process():
    code = send_when_ready(
        """
        print("ready", flush=True)
        list(asap.Pipeline())
        """,
        signal.SIGTERM,
    )
    assert code == -signal.SIGTERM


needs_fork = pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")

FORKED = """
    import warnings
    warnings.simplefilter("ignore")  # that a process with threads forks

    def child_says(report):
        read, write = os.pipe()
        if os.fork() == 0:
            try:
                os.write(write, str(report()).encode())
            finally:
                os.close(write)
                sys.exit(0)  # through atexit and all destructors
        os.close(write)
        with os.fdopen(read) as file:
            answer = file.read()
        _, status = os.wait()
        return answer, os.waitstatus_to_exitcode(status)
"""


@needs_fork
def test_a_forked_process_refuses_every_method():
    ended = run_script(
        FORKED
        + """
    events = np.zeros(10, asap.EVENT_DTYPE)
    pipeline = asap.Pipeline(capacity=64, scheme=asap.Greedy())
    called = asap.Pipeline(lambda events: None, capacity=64)
    waiting = asap.Pipeline(capacity=64)
    in_background(lambda: list(waiting))
    blocked = asap.Pipeline(capacity=64, when_full="block")
    in_background(fill, blocked, 1000)
    while blocked.ledger.pending < 64:
        time.sleep(0.001)
    time.sleep(0.1)

    def refused():
        calls = {
            "push": lambda: pipeline.push(events),
            "iterate": lambda: list(pipeline),
            "run": called.run,
            "flush": pipeline.flush,
            "stop": waiting.stop,
            "start": pipeline.start,
            "stats": pipeline.stats,
            "ledger": lambda: pipeline.ledger,
            "packages": lambda: pipeline.packages,
            "state": lambda: pipeline.state,
            "set_latency": lambda: pipeline.set_latency(5),
            "upstream_lost": lambda: pipeline.upstream_lost(1),
            "is_open": lambda: pipeline.is_open,
        }
        others = []
        for name, call in calls.items():
            try:
                call()
                others.append(name)
            except RuntimeError as error:
                if "created before fork" not in str(error):
                    others.append((name, str(error)))
        fresh = asap.Pipeline(scheme=asap.Greedy())
        fresh.push(events)
        fresh.stop()
        return others, repr(pipeline), len(next(iter(fresh)))

    print(*child_says(refused), sep="|")
    pipeline.push(events)
    pipeline.stop()
    print(sum(len(package) for package in pipeline), blocked.ledger.pending)
    """
    )
    assert ended.code == 0, ended.errors
    said, code = ended.lines[0].split("|")
    assert said == "([], '<Pipeline: created before fork, greedy>', 10)"
    assert code == "0"
    assert ended.lines[1] == "10 64"
