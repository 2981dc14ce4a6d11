"""The components in a container, as a robot loads them."""

from __future__ import annotations

import itertools
import re
import struct
import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from composition_interfaces.srv import LoadNode, UnloadNode
from door import mono, wait
from rcl_interfaces.msg import Log
from rclpy.parameter import Parameter
from ros2_door import PRELOAD, Peer, program
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import UInt64


class Container:
    """A component container, until the end of the `with` block."""

    def __init__(self, peer: Peer) -> None:
        self.peer = peer
        made = program("rclcpp_components", "component_container")
        words = [made, "--ros-args", "-r", "__node:=container"]
        self.process = subprocess.Popen(words, env=PRELOAD)
        self._load = peer.create_client(LoadNode, "container/_container/load_node")
        self._unload = peer.create_client(UnloadNode, "container/_container/unload_node")

    def __enter__(self) -> Container:
        return self

    def __exit__(self, *error: object) -> None:
        self.process.kill()
        self.process.wait()

    def load(
        self,
        plugin: str,
        *,
        package: str = "asap_ros",
        remap: Sequence[str] = (),
        **parameters: Any,
    ) -> int:
        request = LoadNode.Request(package_name=package, plugin_name=plugin)
        request.remap_rules = list(remap)
        for name, value in parameters.items():
            request.parameters.append(Parameter(name, value=value).to_parameter_msg())
        within = Parameter("use_intra_process_comms", value=True)
        request.extra_arguments.append(within.to_parameter_msg())
        answer = self.peer.ask(self._load, request)
        assert answer.success, answer.error_message
        return answer.unique_id

    def unload(self, number: int) -> None:
        assert self.peer.ask(self._unload, UnloadNode.Request(unique_id=number)).success

    @property
    def resident_kib(self) -> int:
        status = Path(f"/proc/{self.process.pid}/status").read_text()
        return int(re.search(r"VmRSS:\s+(\d+) kB", status)[1])


@pytest.fixture
def container(make_peer: Callable[..., Peer]) -> Iterator[Container]:
    with Container(make_peer(consume=False)) as made:
        yield made


def test_the_tracker_publishes_its_clusters(container: Container) -> None:
    peer, clouds = container.peer, []
    peer.create_subscription(PointCloud2, "asap_cluster_tracker/clusters", clouds.append, 10)
    container.load("asap_ros::ClusterTrackerNode", latency_ms=200.0)
    wait(lambda: peer.driver.get_subscription_count() > 0, "the tracker subscribes")
    wait(lambda: peer.count_publishers("asap_cluster_tracker/clusters") > 0, "it publishes")
    random = np.random.default_rng(1)
    at, seq = np.array([100.0, 200.0]), 0
    while not any(cloud.width for cloud in clouds):  # a disc that moves by 300 px/s
        t = np.sort(random.integers(0, 10_000, 300)) + seq * 10_000
        x, y = (at + random.normal(0, 4, (300, 2))).astype(int).clip(0, 479).T
        peer.send(mono(t, x, y))
        at[0] += 3 if at[0] < 500 else -400
        seq += 1
        assert seq < 500, "no cluster within five seconds of events"
        time.sleep(0.01)
    cloud = next(cloud for cloud in clouds if cloud.width)
    assert [field.name for field in cloud.fields] == ["x", "y", "z", "vx", "vy", "id", "size"]
    x, y, z, _, _, _, size = struct.unpack_from("<5fiI", bytes(cloud.data))
    assert 80 < x < 520
    assert abs(y - at[1]) < 20
    assert z == 0
    assert size > 0


def test_an_algorithm_of_the_users_own_runs_in_the_container(container: Container) -> None:
    peer, counts = container.peer, []
    peer.create_subscription(UInt64, "own/on_events", lambda count: counts.append(count.data), 10)
    container.load("OwnNode", package="own_node", latency_ms=200.0)
    wait(lambda: peer.driver.get_subscription_count() > 0, "the component subscribes")
    wait(lambda: peer.count_publishers("own/on_events") > 0, "it publishes")
    wait(lambda: peer.count_subscribers("own/on_events") > 0, "we subscribe")
    peer.send(mono(np.arange(1000)))
    wait(lambda: 1000 in counts, "all events are counted")


def test_what_throws_is_reported_and_logged_once(container: Container) -> None:
    peer, log = container.peer, []
    peer.create_subscription(Log, "/rosout", log.append, 1000)
    container.load("FailingNode", package="failing_component", latency_ms=200.0)
    wait(lambda: peer.driver.get_subscription_count() > 0, "the component subscribes")
    wait(lambda: peer.said, "a report")
    message = "process() throws: no room"
    for i in range(150):
        peer.send(mono(np.arange(10) + i * 10_000))
        time.sleep(0.01)
    peer.diagnosed(2, message)
    wait(lambda: [line for line in log if line.msg == message], "a line in the log")
    assert len([line for line in log if line.msg == message]) == 1


OWN = ("OwnNode", "own_node")
OURS = (("asap_ros::PackageNode", "asap_ros"), ("asap_ros::ClusterTrackerNode", "asap_ros"))


@pytest.mark.parametrize("order", list(itertools.permutations((OWN, *OURS))))
def test_components_load_in_any_order(container: Container, order: tuple) -> None:
    for plugin, package in order:
        container.load(plugin, package=package)


def test_the_names_of_the_published_node(container: Container) -> None:
    """By the rules of camera.launch.py."""
    peer = container.peer
    rules = ("__ns:=/robot", "events:=/camera", "~/events:=/asap/events")
    rules = (*rules, "~/feedback:=/asap/feedback")
    container.load("asap_ros::PackageNode", remap=rules, feedback="service")
    wait(lambda: peer.count_publishers("/asap/events") == 1, "the topic")
    wait(lambda: peer.count_services("/asap/feedback") == 1, "the service")
    wait(lambda: peer.count_subscribers("/camera") == 1, "the driver's topic")
    assert peer.count_publishers("/robot/asap/stats") == 1


def test_a_component_that_comes_and_goes_leaves_nothing(container: Container) -> None:
    resident = []
    for _ in range(100):
        container.unload(container.load("asap_ros::PackageNode", feedback="topic"))
        resident.append(container.resident_kib)
    print(f"resident after 10 and 100 loads: {resident[9]} and {resident[-1]} KiB")
    assert resident[-1] - resident[9] <= 1024
