"""The commands and the consumer of the README of asap_ros, as they stand there."""

from __future__ import annotations

import re
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from door import mono, wait
from event_camera_msgs.msg import EventPacket
from ros2_door import DRIVERS_QOS, PRELOAD, AsapNode, Peer, program

README = (Path(__file__).parents[2] / "cpp/ros/README.md").read_text()


def test_the_command_starts_the_node_on_the_drivers_topic(make_peer: Callable[..., Peer]) -> None:
    (words,) = re.findall(r"^ros2 run asap_ros asap_node (.*)$", README, re.M)
    peer = make_peer(consume=False)
    driver = peer.create_publisher(EventPacket, "/event_camera/events", DRIVERS_QOS)
    with AsapNode(words=words.split()) as node:
        wait(lambda: driver.get_subscription_count() > 0, "the node subscribes")
        assert peer.next_stats()["latency_bound_us"] == 10_000
        (name, value) = re.findall(r"^ros2 param set /asap (\S+) (\S+)$", README, re.M)[0]
        assert peer.set(**{name: float(value)}).successful
        wait(lambda: peer.next_stats()["latency_bound_us"] == 20_000, "the bound is in force")
        code, _ = node.interrupt()
    assert code == 0


@pytest.mark.parametrize("language", ["python", "cpp"])
def test_the_consumer_says_when_it_has_finished(
    make_peer: Callable[..., Peer], language: str
) -> None:
    (code,) = re.findall(r"^```python\n(.*?)^```", README, re.M | re.S)
    in_python, in_cpp = [sys.executable, "-c", code], [program("failing_component", "consumer")]
    peer = make_peer(consume=False)
    consumer = subprocess.Popen(in_cpp if language == "cpp" else in_python, env=PRELOAD)
    try:
        with AsapNode(latency_ms=500):
            peer.wait_for_node()
            for name in ("asap/events", "asap/processing_time"):
                wait(lambda name=name: peer.count_subscribers(name) > 0, name)
            wait(lambda: peer.count_publishers("asap/processing_time") > 0, "it gives feedback")
            peer.next_stats()
            for i in range(50):
                peer.send(mono(np.arange(1000) + 10_000 * i))
                time.sleep(0.01)
            stats = peer.settled()
    finally:
        consumer.kill()
        consumer.wait()
    assert stats["feedback"]["timeouts"] == 0
    assert stats["feedback"]["taken"] == stats["packages"]["count"] > 0


def test_the_source_tree_for_a_release_stands_alone(tmp_path: Path) -> None:
    """It is configured; the tests' package is built from the same files in the checkout."""
    tree = tmp_path / "tree"
    subprocess.run([Path(__file__).parents[2] / "cpp/ros/release", "ros2", tree], check=True)
    words = ["-G", "Ninja", f"-DPython3_EXECUTABLE={sys.executable}"]
    subprocess.run(["cmake", "-S", tree, "-B", tmp_path / "build", *words], check=True)
    assert "asap_event_node" in (tmp_path / "build/build.ninja").read_text()
