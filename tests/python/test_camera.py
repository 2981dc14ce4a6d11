"""Cameras: what the driver says, what a camera loses, and how it ends."""

from __future__ import annotations

import json
import math
import os
import re
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import asap
from asap.cli import main
from children import run_script
from fake_driver import PACKET, SERIAL, Driver

UNPLUGGED = "Rusb(NoDevice)"
LONG_MS = 1000.0  # a bound that a busy machine keeps


@pytest.fixture
def attach(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., Driver]]:
    """Make a driver the installed one; at the end all is closed and no thread is left."""
    drivers = []

    def install(*script: str, fault: str | None = None) -> Driver:
        drivers.append(Driver(script, fault))
        monkeypatch.setitem(sys.modules, "neuromorphic_drivers", drivers[-1])
        return drivers[-1]

    threads, interval = set(threading.enumerate()), sys.getswitchinterval()
    yield install
    assert set(threading.enumerate()) <= threads
    assert not any(device.is_open for driver in drivers for device in driver.opened)
    assert sys.getswitchinterval() == interval


def events_in(pipeline: asap.Pipeline) -> int:
    return sum(len(package) for package in pipeline)


# ---- opening --------------------------------------------------------------------------------


def test_cameras_lists_what_is_attached(attach: Callable[..., Driver]) -> None:
    attach()
    (found,) = asap.cameras()
    assert (found.name, found.serial, found.connection) == ("Prophesee EVK4", SERIAL, "USB 3.0")


@pytest.mark.parametrize(
    ("fault", "remedy"),
    [
        ("Access denied (insufficient permissions)", "neuromorphic_drivers.udev"),
        ("Other error", "/dev/bus/usb"),
        ("Input/Output Error", "/sys/bus/usb"),
        ("no device found", "SoftwareCamera"),
        ("No such device (it may have been disconnected)", "plug it in"),
        ("the device is already used by another program", "close that one"),
    ],
)
def test_what_the_driver_raises_comes_with_a_remedy(
    fault: str, remedy: str, attach: Callable[..., Driver]
) -> None:
    attach(fault=fault)
    for call in (asap.cameras, asap.open_camera):
        with pytest.raises(asap.CameraError, match=re.escape(fault)) as raised:
            call()
        assert remedy in str(raised.value)


def test_another_serial_number_is_named(attach: Callable[..., Driver]) -> None:
    attach()
    with pytest.raises(asap.CameraError, match=r"camera ABC: .* not found: .*asap\.cameras\(\)"):
        asap.open_camera("ABC")


def test_options_reach_the_driver_which_never_waits_for_long(attach: Callable[..., Driver]) -> None:
    driver = attach()
    with asap.open_camera(SERIAL, configuration="biases") as camera:
        assert (camera.width, camera.height, camera.serial) == (1280, 720, SERIAL)
        assert camera.device is driver.opened[0]
    assert driver.given == {"configuration": "biases", "iterator_timeout": 0.1}


def test_a_camera_without_a_size_is_refused(attach: Callable[..., Driver]) -> None:
    attach().size = None
    with pytest.raises(asap.CameraError, match="size"):
        asap.open_camera()


# ---- feeding --------------------------------------------------------------------------------


def test_what_came_before_it_was_unplugged_is_delivered(attach: Callable[..., Driver]) -> None:
    driver = attach(*["events"] * 20, UNPLUGGED)
    seen = 0
    with asap.open_camera() as camera, asap.Pipeline(camera=camera, latency_ms=LONG_MS) as pipeline:
        with pytest.raises(asap.CameraError, match=f"EVK4 {SERIAL}: .*NoDevice.*unplugged"):
            for package in pipeline:
                seen += len(package)
        assert pipeline.stats()["camera"]["ended"] == "unplugged"
    assert seen == driver.opened[0].made == pipeline.ledger.received == 20 * PACKET
    assert pipeline.ledger.balanced


def test_an_error_that_no_loop_has_seen_is_raised_at_the_end(attach: Callable[..., Driver]) -> None:
    attach("events", UNPLUGGED)
    with pytest.raises(asap.CameraError, match="unplugged"), asap.open_camera() as camera:
        pipeline = asap.Pipeline(latency_ms=LONG_MS)
        camera._feed(pipeline)
        assert events_in(pipeline) == PACKET


def test_losses_are_differences_of_the_drivers_count(attach: Callable[..., Driver]) -> None:
    attach("events", *["loss", "events"] * 3, UNPLUGGED)
    with (
        asap.open_camera() as camera,
        asap.Pipeline(camera=camera, latency_ms=LONG_MS) as pipeline,
        pytest.raises(asap.CameraError),
    ):
        events_in(pipeline)
    assert pipeline.stats()["upstream_lost"] == {"marks": 3, "packets": 9}


def test_packets_say_when_they_came_and_what_was_lost(attach: Callable[..., Driver]) -> None:
    attach("events", "silence", "frames", "loss", UNPLUGGED)
    packets, before_s = [], time.monotonic()
    with asap.open_camera() as camera, pytest.raises(asap.CameraError):
        for packet in camera:
            packets.append(packet)
            assert before_s - 0.006 < packet.arrival_time < time.monotonic() - 0.004
    sizes = [(len(p.events), p.lost_marks, p.lost_packets) for p in packets]
    assert sizes == [(PACKET, 0, 0), (0, 0, 0), (PACKET, 1, 3)]


class Noted:
    """What a camera feeds, in place of a pipeline."""

    is_open = True

    def __init__(self) -> None:
        self.pushed: list[tuple[Any, float]] = []
        self.stopped = threading.Event()

    def push(self, events: Any, arrival_time: float) -> None:
        self.pushed.append((events, arrival_time))

    def upstream_lost(self, marks: int, packets: int) -> None: ...

    def stop(self) -> None:
        self.stopped.set()


def test_events_that_a_driver_merged_came_one_after_the_other(
    attach: Callable[..., Driver],
) -> None:
    attach("merged", UNPLUGGED)
    noted: Any = Noted()
    with pytest.raises(asap.CameraError), asap.open_camera() as camera:
        camera._feed(noted)
        noted.stopped.wait()
    first_s = noted.pushed[0][1]
    assert sum(len(events) for events, _ in noted.pushed) == 20 * PACKET
    for events, arrival_s in noted.pushed:
        late_s = arrival_s - first_s - 1e-6 * events["t"].astype(float)
        assert np.abs(late_s).max() < 0.0015


def test_one_wild_stamp_and_a_count_that_goes_back_end_no_run(
    attach: Callable[..., Driver],
) -> None:
    attach("events", "wild", "events", UNPLUGGED)
    with pytest.raises(asap.CameraError), asap.open_camera() as camera:
        asap.run(camera, algorithm=len, latency_ms=LONG_MS)
    ledger = asap.last_run().ledger
    assert (ledger.received, ledger.rejected) == (3 * PACKET, 1)
    assert asap.last_run().rejected == {**asap.last_run().rejected, "bad_record": 1}


def test_a_loop_that_is_left_leaves_no_packet_uncounted(attach: Callable[..., Driver]) -> None:
    driver = attach(*["events"] * 2000)
    with asap.open_camera() as camera, asap.Pipeline(camera=camera, latency_ms=LONG_MS) as pipeline:
        for _ in pipeline:
            break
    assert pipeline.ledger.received == driver.opened[0].made
    assert pipeline.ledger.balanced


def test_what_waited_before_the_feed_is_left_out(attach: Callable[..., Driver]) -> None:
    driver = attach("events", "loss", "loss", "events", UNPLUGGED)
    with asap.open_camera() as camera:
        driver.opened[0].waiting = 2
        pipeline = asap.Pipeline(camera=camera, latency_ms=LONG_MS)
        with pipeline, pytest.raises(asap.CameraError):
            events_in(pipeline)
    assert pipeline.ledger.received == 2 * PACKET
    assert pipeline.stats()["upstream_lost"] == {"marks": 1, "packets": 0}


def test_one_camera_feeds_one_pipeline_at_a_time(attach: Callable[..., Driver]) -> None:
    attach(*["events"] * 5)
    with asap.open_camera() as camera:
        for _ in range(2):  # one after the other
            busy = pytest.raises(RuntimeError, match="feeds a pipeline already")
            with asap.Pipeline(camera=camera), busy:
                camera._feed(asap.Pipeline())
    with pytest.raises(RuntimeError, match="closed"):
        camera._feed(asap.Pipeline())


def test_a_program_that_forgets_the_camera_ends() -> None:
    before = f"import sys; sys.path[:] = {sys.path!r}\n"
    script = """
        import fake_driver
        sys.modules["neuromorphic_drivers"] = fake_driver.Driver(("events",) * 10)
        camera = asap.open_camera()
        camera._feed(asap.Pipeline())
        print("fed")
        """
    assert run_script(script, before=before).lines == ["fed"]


def test_what_a_pipeline_refuses_as_its_camera(attach: Callable[..., Driver]) -> None:
    with pytest.raises(TypeError, match="camera = 5"):
        asap.Pipeline(camera=5)
    attach()
    with asap.open_camera() as camera:
        with pytest.raises(ValueError, match=r"when_full = 'block'.*'keep_newest'"):
            asap.Pipeline(camera=camera, when_full="block")
        with pytest.raises(ValueError, match="width = 5"):
            asap.Pipeline(camera=camera, width=5)
        with pytest.raises(RuntimeError, match="within the with block"):
            iter(asap.Pipeline(camera=camera))
        with pytest.raises(RuntimeError, match="within the with block"):
            asap.Pipeline(len, camera=camera).run()


# ---- asap.run -------------------------------------------------------------------------------


def test_run_of_a_camera(attach: Callable[..., Driver], tmp_path: Path) -> None:
    attach(*["events", "loss"] * 20)
    tracker = asap.ClusterTracker(1280, 720)
    with asap.open_camera() as camera:
        run = asap.run(camera, algorithm=tracker, latency_ms=LONG_MS, duration_s=0.3)
        assert asap.last_run() is run
        assert run.algorithm is tracker
        assert run.ledger.delivered == run.ledger.received == 40 * PACKET
        assert run.packages["size"].sum() == 40 * PACKET
        assert run.source["format"] == f"Prophesee EVK4 {SERIAL}"
        assert run.summary()["source"]["upstream_lost"] == {"marks": 20, "packets": 60}
        assert "20 marks, 60 packets" in " ".join(str(run).split())
        loaded = asap.load_run(run.save(tmp_path / "run.npz"))
        assert str(loaded) == str(run)


def test_the_log_of_a_run_is_long(attach: Callable[..., Driver]) -> None:
    attach(*["events"] * 20)
    with asap.open_camera() as camera:
        one = asap.FixedSize(size=1)
        run = asap.run(camera, algorithm=len, scheme=one, latency_ms=LONG_MS, duration_s=0.5)
    assert run.packages.size == run.ledger.delivered > 16384  # more than a pipeline keeps


def test_a_silent_camera_is_named(attach: Callable[..., Driver]) -> None:
    attach()
    with asap.open_camera() as camera, pytest.warns(RuntimeWarning, match="EVK4 .* no event came"):
        run = asap.run(camera, algorithm=len, duration_s=0.2)
    assert run.ledger.received == 0 and math.isnan(run.in_time)


def test_the_command_line_says_that_a_camera_was_silent(
    attach: Callable[..., Driver], capsys: pytest.CaptureFixture[str]
) -> None:
    attach()
    assert main(["run", "--camera", "--duration", "200ms", "--json"]) == 3
    out, err = capsys.readouterr()
    assert json.loads(out)["in_time"] is None and "error: no event was received" in err


@pytest.mark.parametrize(
    "given", [{"speed": 2.0}, {"keep_mask": True}, {"duration_s": 0}, {"start": 1.0}]
)
def test_run_refuses_what_a_camera_has_not(given: Any, attach: Callable[..., Driver]) -> None:
    attach()
    with asap.open_camera() as camera, pytest.raises(ValueError, match=next(iter(given))):
        asap.run(camera, algorithm=len, **given)


def test_a_camera_is_no_recording(attach: Callable[..., Driver]) -> None:
    attach()
    with asap.open_camera() as camera:
        for use in (partial(asap.simulate, cost=asap.LinearCost(1, 1)), asap.check):
            with pytest.raises(TypeError, match=r"asap\.run"):
                use(camera)
    with pytest.raises(ValueError, match="duration_s"):
        asap.run(np.zeros(1, asap.EVENT_DTYPE), algorithm=len, duration_s=1)


# ---- recording ------------------------------------------------------------------------------


def test_record(attach: Callable[..., Driver], tmp_path: Path) -> None:
    attach(*["events"] * 20)
    with asap.open_camera() as camera:
        camera.record(tmp_path / "flight.raw")
        with pytest.raises(RuntimeError, match=r"flight\.raw"):
            camera.record(tmp_path / "other.raw")
        run = asap.run(camera, algorithm=len, latency_ms=LONG_MS, duration_s=0.3)
    events = asap.load(tmp_path / "flight.raw")
    assert events.size == run.ledger.received == 20 * PACKET
    assert camera.recorded == tmp_path / "flight.raw"
    assert camera.stats()["not_recorded"] == 0
    assert (np.diff(events["t"]) >= 0).all()


def test_record_alone_leaves_the_camera_open(attach: Callable[..., Driver], tmp_path: Path) -> None:
    driver = attach(*["events"] * 20)
    with asap.open_camera() as camera:
        driver.opened[0].waiting = 5  # older than the call
        first = asap.record(camera, tmp_path / "first.raw", seconds=0.3)
        assert first == tmp_path / "first.raw"
        assert asap.load(first).size == 15 * PACKET
        assert asap.record(camera, tmp_path / "silence.npz", seconds=0.1) is None
        camera.record(tmp_path / "beside.raw")
        with pytest.raises(RuntimeError, match=r"beside\.raw"):
            asap.record(camera, tmp_path / "second.raw")
    assert [path.name for path in tmp_path.iterdir()] == ["first.raw"]


def test_record_alone_keeps_what_came_before_it_was_unplugged(
    attach: Callable[..., Driver], tmp_path: Path
) -> None:
    attach(*["events"] * 20, UNPLUGGED)
    with asap.open_camera() as camera:
        with pytest.raises(asap.CameraError, match="unplugged"):
            asap.record(camera, tmp_path / "flight.raw")
        assert asap.load(tmp_path / "flight.raw").size == 20 * PACKET
        with pytest.raises(RuntimeError, match="unplugged"):
            asap.record(camera, tmp_path / "more.raw")


# ---- the command ----------------------------------------------------------------------------


def test_the_command_lists_cameras(
    attach: Callable[..., Driver], capsys: pytest.CaptureFixture[str]
) -> None:
    attach()
    assert main(["cameras"]) == 0
    assert SERIAL in capsys.readouterr().out
    attach(fault="Access denied")
    assert main(["cameras"]) == 3
    assert "udev" in capsys.readouterr().err


def test_the_command_runs_a_camera(
    attach: Callable[..., Driver], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    attach(*["events"] * 20)
    saved, recorded = tmp_path / "run.npz", tmp_path / "flight.raw"
    options = ["--duration", "300ms", "--latency", "1s", "--save", saved, "--record", recorded]
    assert main(["run", "--camera", *map(str, options)]) == 0
    assert f"EVK4 {SERIAL}" in capsys.readouterr().out
    assert asap.load_run(saved).ledger.received == asap.load(recorded).size == 20 * PACKET

    attach("events", UNPLUGGED)
    assert main(["run", "--camera", SERIAL, "--latency", "1s", "--save", str(saved)]) == 3
    assert "unplugged" in capsys.readouterr().err
    assert asap.load_run(saved).ledger.received == PACKET

    assert main(["run", "--camera", "ABC"]) == 3
    assert main(["run"]) == 2
    assert main(["run", "flight.raw", "--camera"]) == 2


# ---- the driver itself ----------------------------------------------------------------------


def test_the_fake_has_the_names_of_the_driver() -> None:
    real = pytest.importorskip("neuromorphic_drivers")
    driver = Driver(("loss",))
    assert {"list_devices", "open"} <= set(dir(real))
    device = driver.open(iterator_timeout=0.1)
    status, packet = next(device)
    assert vars(status.ring).keys() <= real.status.RingStatus.__dataclass_fields__.keys()
    assert vars(packet).keys() <= real.packet.Evt3Packet.__annotations__.keys()
    methods = {name for name in dir(device) if not name.startswith("_")}
    kind = real.generated.devices.prophesee_evk4.PropheseeEvk4Device
    assert methods - {"made", "is_open", "waiting"} <= set(dir(kind))


class Attached:
    """The driver, with one camera attached that is not there."""

    def __init__(self, real: Any, name: str) -> None:
        self._real, self._name = real, real.Name[name]
        self.given: dict[str, Any] = {}

    def __getattr__(self, name: str) -> Any:
        return getattr(self._real, name)

    def list_devices(self) -> list[Any]:
        return [SimpleNamespace(name=self._name, serial=SERIAL, error=None)]

    def open(self, **given: Any) -> Any:
        self.given = given
        return Driver().open()


@pytest.fixture
def attached(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], Attached]:
    real = pytest.importorskip("neuromorphic_drivers")

    def attach(name: str) -> Attached:
        driver = Attached(real, name)
        monkeypatch.setitem(sys.modules, "neuromorphic_drivers", driver)
        return driver

    return attach


def test_a_region_and_a_rate_reach_the_driver(attached: Callable[[str], Attached]) -> None:
    driver = attached("PROPHESEE_EVK4")
    asap.open_camera(region=(320, 180, 640, 360), rate_bound=5e6).close()
    made = driver.given["configuration"]
    assert made.serialize()  # as the driver takes it
    mask = driver.prophesee_evk4.RowColumnMask(set=False)
    for side, words, begin, end in (("x", made.x_mask, 320, 960), ("y", made.y_mask, 180, 540)):
        bits = np.unpackbits(np.array(words, "<u8").view(np.uint8), bitorder="little")
        bits = bits[: len(getattr(mask, f"{side}_unpacked"))]
        assert np.flatnonzero(bits == 0).tolist() == list(range(begin, end))
    limit = made.rate_limiter
    assert limit.maximum_events_per_period / limit.reference_period_us == 5.0

    driver = attached("INIVATION_DAVIS346")
    asap.open_camera(SERIAL, region=(0, 10, 100, 250)).close()
    assert driver.given["configuration"].serialize()
    assert vars(driver.given["configuration"].region_of_interest) == {
        **{"left": 0, "top": 10, "width": 100, "height": 250}
    }
    asap.open_camera(SERIAL).close()
    assert "configuration" not in driver.given


@pytest.mark.parametrize(
    ("name", "given", "says"),
    [
        ("INIVATION_DVXPLORER", {"region": (0, 0, 9, 9)}, "region .*no region of iniVation DVX"),
        ("INIVATION_DAVIS346", {"rate_bound": 1e6}, "rate_bound .*no limit of iniVation DAVIS"),
        ("PROPHESEE_EVK4", {"region": (0, 0, 1281, 9)}, "region .*1280 x 720"),
        ("PROPHESEE_EVK4", {"region": (0, 0, 0, 9)}, "region .*1280 x 720"),
        ("PROPHESEE_EVK4", {"region": (0, 0, 9)}, "region .*left, top"),
        ("PROPHESEE_EVK4", {"region": (0, 0, 9, 1.5)}, "region .*whole px"),
        ("PROPHESEE_EVK4", {"rate_bound": 0}, "rate_bound .*events per second"),
        ("PROPHESEE_EVK4", {"rate_bound": 1e6, "configuration": None}, "configuration"),
    ],
)
def test_what_a_camera_cannot_do_is_refused(
    attached: Callable[[str], Attached], name: str, given: dict[str, Any], says: str
) -> None:
    driver = attached(name)
    with pytest.raises(ValueError, match=says):
        asap.open_camera(**given)
    assert not driver.given


BUS = """
import pathlib, struct, subprocess, os
import asap

def ask(what):
    for call in (asap.cameras, asap.open_camera, lambda: asap.open_camera("ABC")):
        try:
            print(what, call())
        except asap.CameraError as error:
            print(what, error)

for place in ("/dev", "/sys/bus"):
    subprocess.run(["mount", "-t", "tmpfs", "none", place], check=True)
for name, minor in (("null", 3), ("urandom", 9)):
    os.mknod(f"/dev/{name}", 0o020666, os.makedev(1, minor))
ask("no bus:")
node, device = (pathlib.Path(p) for p in ("/dev/bus/usb/001/002", "/sys/bus/usb/devices/1-1"))
node.parent.mkdir(parents=True)
device.parent.mkdir(parents=True)
ask("empty:")
device.mkdir()
facts = {"busnum": 1, "devnum": 2, "bConfigurationValue": 1, "speed": 5000}
for name, value in facts.items():
    (device / name).write_text(str(value))
(device / "descriptors").write_bytes(  # an EVK4: device, configuration, interface, endpoint
    struct.pack("<BBHBBBBHHHBBBB", 18, 1, 0x300, 0, 0, 0, 9, 0x4B4, 0xF5, 0x100, 1, 2, 3, 1)
    + struct.pack("<BBHBBBBB", 9, 2, 25, 1, 1, 0, 0x80, 50)
    + struct.pack("<BBBBBBBBB", 9, 4, 0, 0, 1, 255, 0, 0, 0)
    + struct.pack("<BBBBHB", 7, 5, 0x81, 2, 1024, 0)
)
ask("gone:")
node.touch(0)
if os.fork() == 0:
    os.setuid(65534)
    ask("denied:")
    os._exit(0)
os.wait()
"""


def test_the_real_driver_on_an_emulated_bus() -> None:
    """What it raises still has its remedy. Mounts over /dev, so in a namespace of its own."""
    pytest.importorskip("neuromorphic_drivers")
    may = (
        subprocess.run(["unshare", "-m", "true"], capture_output=True, check=False).returncode == 0
    )
    if os.geteuid() != 0 or not may:
        pytest.skip("needs root, and unshare")
    done = subprocess.run(
        ["unshare", "-m", sys.executable, "-u", "-c", BUS],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr
    said = done.stdout.splitlines()
    assert len(said) == 12
    help_of = {
        "no bus": r"/(sys|dev)/bus/usb",
        "empty": r"\[\]|no camera",
        "gone": "plug it in",
        "denied": "neuromorphic_drivers.udev",
    }
    for line in said:
        assert re.search(help_of[line.partition(":")[0]], line), line
