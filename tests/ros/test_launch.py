"""The launch files of the package."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from event_camera_msgs.msg import EventPacket
from launching import Launch
from peers import Peer, mono, peers
from sensor_msgs.msg import PointCloud2

make_peer = pytest.fixture(peers)


def test_a_recording_goes_through_asap_to_the_tracker(make_peer: Callable[..., Peer]) -> None:
    peer, clouds = make_peer(), []
    peer.create_subscription(PointCloud2, "asap_cluster_tracker/clusters", clouds.append, 10)
    # There is no player of this bag: the peer publishes in its place.
    words = ("bag:=none", "topic:=/events", "latency_ms:=200.0")
    with Launch(peer, "playback.launch.py", *words):
        peer.wait_for_node()
        peer.wait(lambda: peer.count_subscribers("asap/events") == 2, "the tracker subscribes")
        for i in range(50):
            peer.send(mono(np.arange(1000) + 10_000 * i))
        peer.wait(lambda: clouds, "clusters of packages")
        assert peer.next_stats()["latency_bound_us"] == 200_000


def test_the_component_in_the_drivers_container(make_peer: Callable[..., Peer]) -> None:
    """The container reports that there is no driver here, and goes on with asap."""
    peer = make_peer()
    driver = peer.create_publisher(EventPacket, "event_camera/events", 1000)
    with Launch(peer, "camera.launch.py", "latency_ms:=25.0", "feedback:=service"):
        peer.wait(lambda: driver.get_subscription_count() > 0, "asap subscribes to the driver")
        peer.wait(lambda: peer.count_services("asap/feedback") > 0, "the published node's service")
        stats = peer.next_stats()
    assert (stats["state"], stats["latency_bound_us"]) == ("open", 25_000)
