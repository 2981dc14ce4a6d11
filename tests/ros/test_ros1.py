"""Tests of what only ROS 1 has: dvs_msgs/EventArray, the wire, the master. See run_ros1."""

from __future__ import annotations

import io
import subprocess
from collections.abc import Callable
from typing import IO

import genpy.dynamic
import numpy as np
import pytest
import rospy
from asap_ros.srv import Feedback, FeedbackRequest
from door import DATA, ledger_in, mono, wait
from ros1_door import (
    BAGS,
    Array,
    AsapNode,
    Master,
    Packet,
    Peer,
    array,
    events_in,
    seq_of,
)

NAME, (EVENTS, _, _) = next(iter(BAGS.items()))
BAG = DATA / "ros" / NAME
needs_bag = pytest.mark.skipif(not BAG.exists(), reason=f"no {NAME}")


@pytest.fixture
def arrays(make_peer: Callable[..., Peer]) -> Peer:
    return make_peer(driver=Array, consumer=Array)


def test_arrays_go_in_and_out_as_they_are(arrays: Peer) -> None:
    random = np.random.default_rng(1)
    t_us = np.sort(random.integers(1_600_000_000_000_000, 1_600_000_000_100_000, 5000))
    x, y = random.integers(0, 640, 5000), random.integers(0, 480, 5000)
    sent = [
        array(t_us[i : i + 50], x[i : i + 50], y[i : i + 50], seq=i) for i in range(0, 5000, 50)
    ]
    with AsapNode(latency_ms=1000):
        arrays.wait_for_node()
        for message in sent:
            arrays.send_raw(message)
        wait(lambda: len(arrays.array_events) == 5000, "all events")
    assert (arrays.array_events == np.concatenate([events_in(message) for message in sent])).all()


def test_the_messages_are_those_of_the_published_packages(make_peer: Callable[..., Peer]) -> None:
    """A class that genpy makes of the definition has the sum that the node states, and reads it."""
    peer, definitions = make_peer(driver=Array, consume=False), []
    for encoding, name, md5 in (
        ("dvs_msgs", "dvs_msgs/EventArray", Array._md5sum),
        ("evt3", "event_camera_msgs/EventPacket", Packet._md5sum),
    ):
        with AsapNode(latency_ms=1000, encoding=encoding):
            text = []
            any_type = rospy.Subscriber(
                "/asap/events",
                rospy.AnyMsg,
                lambda message, text=text: text.append(message._connection_header),
            )
            wait(lambda any_type=any_type: any_type.get_num_connections() > 0, "a connection")
            wait(lambda: peer.driver.get_num_connections() > 0, "the node subscribes")
            peer.send_raw(array([5, 6]))
            connection = wait(lambda text=text: text, "a message")[0]
            any_type.unregister()
        made = genpy.dynamic.generate_dynamic(name, connection["message_definition"])[name]
        assert (connection["type"], connection["md5sum"]) == (name, md5)
        assert made._md5sum == md5
        definitions.append(made)
    message = definitions[0]().deserialize(array([3_000_001], x=7, y=9, seq=4))
    assert (message.header.seq, message.height, message.width) == (4, 480, 640)
    assert (message.events[0].x, message.events[0].y, message.events[0].polarity) == (7, 9, True)
    assert message.events[0].ts.to_nsec() == 3_000_001_000


def test_another_type_is_refused(peer: Peer) -> None:
    peer.driver.unregister()
    with AsapNode() as node:
        words = ["rostopic", "pub", "-r", "100", "/events", "std_msgs/String", "foreign"]
        foreign = subprocess.Popen(words)
        wait(lambda: peer.stats and peer.next_stats()["messages"]["refused_encoding"], "a refusal")
        foreign.terminate()
        foreign.wait()
        code, said = node.interrupt()
    assert code == 0
    assert "message refused: encoding (from /rostopic" in said
    assert 'encoding "another type"' in said


def test_parameters_change_or_are_refused_with_a_reason(peer: Peer) -> None:
    with AsapNode(encoding="mono", latency_ms=20) as node:
        peer.wait_for_node()
        peer.send(mono([1]))
        rospy.set_param("/asap/latency_ms", 30.5)
        wait(lambda: peer.next_stats()["latency_bound_us"] == 30_500, "the bound is in force")
        for bad in ("soon", float("nan"), -1, 5000):
            rospy.set_param("/asap/latency_ms", bad)
            for _ in range(3):
                assert peer.next_stats()["latency_bound_us"] == 30_500
        rospy.set_param("/asap/latency_ms", 40)
        wait(lambda: peer.next_stats()["latency_bound_us"] == 40_000, "the bound is in force")
        _, said = node.interrupt()
    for reason in (
        "latency_ms = soon: must be a number",
        "latency_ms = nan: must be between 0.1 and 10000",
        "latency_ms = -1: must be between 0.1 and 10000",
        "feedback_timeout_ms = 1000: must be at least latency_ms = 5000",
    ):
        assert said.count(f"parameters refused: {reason}") == 1


def test_the_node_ends_by_the_call_of_rosnode_kill(peer: Peer) -> None:
    with AsapNode(latency_ms=200) as node:
        peer.wait_for_node()
        peer.send(mono(np.arange(1000)))
        peer.next_stats()
        subprocess.run(["rosnode", "kill", "/asap"], check=True, stdout=subprocess.DEVNULL)
        code, said = node.end()
    assert code == 0
    assert ledger_in(said) == {"received": 1000, "delivered": 1000}


class PublishedFeedback(Feedback):
    """The service of the published node, which has no `seq`."""

    _md5sum = "any other"

    class _request_class(FeedbackRequest):
        def serialize(self, buffer: IO[bytes]) -> None:
            whole = io.BytesIO()
            super().serialize(whole)
            buffer.write(whole.getvalue()[:-8])


@pytest.mark.parametrize("service", [Feedback, PublishedFeedback])
def test_feedback_by_the_service_sends_the_next_package(arrays: Peer, service: type) -> None:
    call, taken = rospy.ServiceProxy("/asap/feedback", service, persistent=True), []

    def work(package: bytes) -> None:
        named = {"seq": seq_of(package)} if service is Feedback else {}
        taken.append(call(time=0.0, **named).success)

    arrays.on_raw = work
    with AsapNode(feedback="service", feedback_timeout_ms=60_000, latency_ms=1000):
        arrays.wait_for_node()
        for i in range(10):
            arrays.send_raw(array(np.arange(i * 1000, i * 1000 + 10)))
        wait(lambda: len(arrays.array_events) == 100, "all events")
        stats = arrays.settled()
        assert all(taken)
        assert stats["feedback"]["taken"] == stats["packages"]["count"] == len(taken)
    call.close()


@needs_bag
def test_the_launch_file_plays_a_bag() -> None:
    rospy.delete_param("/asap")  # another test's
    packages: list[bytes] = []
    consumer = rospy.Subscriber(
        "/asap/events", Array, lambda message: packages.append(message.data)
    )
    words = [f"bag:={BAG}", "events:=/event_camera/events", "latency_ms:=200", "feedback:=none"]
    launch = subprocess.Popen(
        ["roslaunch", "asap_ros", "asap.launch", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    try:
        wait(lambda: packages, "packages")
        wait(lambda: launch.poll() is not None, "the end of the bag")
    finally:
        launch.terminate()
        said, _ = launch.communicate(timeout=60)
        consumer.unregister()
    assert ledger_in(said)["received"] == EVENTS


def test_the_node_survives_its_master(master: Master, peer: Peer) -> None:
    with AsapNode(encoding="mono", latency_ms=200) as node:
        peer.wait_for_node()
        peer.send(mono(np.arange(100)))
        wait(lambda: len(peer.events) == 100, "events")
        master.kill()
        try:
            peer.send(mono(np.arange(100, 200)))
            wait(lambda: len(peer.events) == 200, "events without a master")
            assert peer.settled()["ledger"]["delivered"] == 200
            code, said = node.interrupt()
        finally:
            master.start()
    assert code == 0
    assert ledger_in(said) == {"received": 200, "delivered": 200}


def test_sigint_ends_a_node_that_finds_no_master(master: Master) -> None:
    master.kill()
    try:
        with AsapNode() as node:
            assert node.process.stdout is not None
            while "Failed to contact master" not in node.process.stdout.readline():
                assert node.process.poll() is None
            code, said = node.interrupt()
    finally:
        master.start()
    assert code == 0
    assert "run ended" not in said
