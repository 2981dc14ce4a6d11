"""The launch files, where the workspace has launch_ros (that of shared/ros2 has not)."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from event_camera_msgs.msg import EventPacket
from peers import PREFIXES, PRELOAD, Peer, mono, peers
from sensor_msgs.msg import PointCloud2

pytest.importorskip("launch_ros", reason="the workspace has no launch_ros: launch files not run")
make_peer = pytest.fixture(peers)

# What `ros2 launch` does.
LAUNCH = """
import sys, launch
from launch.launch_description_sources import PythonLaunchDescriptionSource
service = launch.LaunchService()
given = [tuple(word.split(":=")) for word in sys.argv[2:]]
service.include_launch_description(launch.LaunchDescription([
    launch.actions.IncludeLaunchDescription(
        PythonLaunchDescriptionSource(sys.argv[1]), launch_arguments=given)]))
sys.exit(service.run())
"""


@pytest.fixture
def start() -> Iterator[Callable[..., None]]:
    """A function that launches a file of the package, until the end of the test."""
    started: list[subprocess.Popen] = []

    def start(name: str, *words: str) -> None:
        paths = [prefix / "share" / "asap_ros" / "launch" / name for prefix in PREFIXES]
        path = next(path for path in paths if path.exists())
        command = [sys.executable, "-c", LAUNCH, str(path), *words]
        started.append(subprocess.Popen(command, env=PRELOAD))

    yield start
    for process in started:
        process.send_signal(signal.SIGINT)
        process.wait(timeout=60)


def test_a_recording_goes_through_asap_to_the_tracker(
    start: Callable[..., None], make_peer: Callable[..., Peer]
) -> None:
    peer, clouds = make_peer(), []
    peer.create_subscription(PointCloud2, "asap_cluster_tracker/clusters", clouds.append, 10)
    # There is no player of this bag: the peer publishes in its place.
    start("playback.launch.py", "bag:=none", "topic:=/events", "latency_ms:=200.0")
    peer.wait_for_node()
    peer.wait(lambda: peer.count_subscribers("asap/events") == 2, "the tracker subscribes")
    for i in range(50):
        peer.send(mono(np.arange(1000) + 10_000 * i))
    peer.wait(lambda: clouds, "clusters of packages")
    assert peer.next_stats()["latency_bound_us"] == 200_000


def test_the_component_in_the_drivers_container(
    start: Callable[..., None], make_peer: Callable[..., Peer]
) -> None:
    """The container reports that there is no driver here, and goes on with asap."""
    peer = make_peer()
    driver = peer.create_publisher(EventPacket, "event_camera/events", 1000)
    start("camera.launch.py", "latency_ms:=25.0", "feedback:=service")
    peer.wait(lambda: driver.get_subscription_count() > 0, "asap subscribes to the driver")
    peer.wait(lambda: peer.count_services("asap/feedback") > 0, "the published node's service")
    assert peer.next_stats()["state"] == "open"
