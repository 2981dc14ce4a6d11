"""The launch files of the package."""

from __future__ import annotations

import json
from collections.abc import Callable

import numpy as np
import pytest
from door import mono, wait
from event_camera_msgs.msg import EventPacket
from launching import Launch
from ros2_door import DRIVERS_QOS, Peer
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import String


def test_a_recording_goes_through_asap_to_the_tracker(make_peer: Callable[..., Peer]) -> None:
    peer, clouds = make_peer(), []
    peer.create_subscription(PointCloud2, "asap_cluster_tracker/clusters", clouds.append, 10)
    # There is no player of this bag: the peer publishes in its place.
    words = ("bag:=none", "topic:=/events", "latency_ms:=200.0")
    with Launch(peer, "playback.launch.py", *words):
        peer.wait_for_node()
        wait(lambda: peer.count_subscribers("asap/events") == 2, "the tracker subscribes")
        for i in range(50):
            peer.send(mono(np.arange(1000) + 10_000 * i))
        wait(lambda: clouds, "clusters of packages")
        assert peer.next_stats()["latency_bound_us"] == 200_000


@pytest.mark.parametrize("driver", ["metavision", "libcaer"])
def test_asap_in_the_container_of_a_driver(make_peer: Callable[..., Peer], driver: str) -> None:
    """The container reports that there is no driver here, and goes on with asap."""
    peer, stats = make_peer(), []
    camera = peer.create_publisher(EventPacket, "robot/event_camera/events", DRIVERS_QOS)
    peer.create_subscription(String, "robot/asap/stats", stats.append, 10)
    words = ("latency_ms:=25.0", "feedback:=service", "namespace:=robot", f"driver:={driver}")
    with Launch(peer, "camera.launch.py", *words):
        wait(lambda: camera.get_subscription_count() > 0, "asap hears the driver")
        wait(lambda: peer.count_services("robot/asap/feedback") > 0, "the service")
        wait(lambda: peer.count_publishers("robot/asap/events") > 0, "the packages")
        wait(lambda: stats, "a report")
    said = json.loads(stats[0].data)
    assert (said["state"], said["latency_bound_us"]) == ("open", 25_000)
