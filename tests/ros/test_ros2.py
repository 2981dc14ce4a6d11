"""Tests of what only ROS 2 has: DDS, parameters, several drivers. tests/ros/run starts this."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from door import Packet, mono, wait
from event_camera_msgs.msg import EventPacket
from rcl_interfaces.srv import DescribeParameters
from ros2_door import DRIVERS_QOS, AsapNode, CppPeer, Peer

OK, WARN, ERROR = range(3)


def test_the_keys_of_the_stats_are_those_of_python(peer: Peer) -> None:
    asap = pytest.importorskip("asap", reason="no wheel of asap: set ASAP_DIST")
    own = {"messages", "triggers", "failures", "feedback", "last_second"}
    with AsapNode():
        peer.wait_for_node()
        stats = peer.next_stats()
    with asap.Pipeline(latency_ms=10) as pipeline:
        theirs = pipeline.stats()
    assert own < set(stats)
    for name in set(stats) - own:
        assert isinstance(stats[name], dict) == isinstance(theirs[name], dict)
        if isinstance(stats[name], dict):
            assert set(stats[name]) <= set(theirs[name])


def test_diagnostics_say_that_no_end_hears_or_can_hear(make_peer: Callable[..., Peer]) -> None:
    peer = make_peer(consume=False)
    with AsapNode(latency_ms=200, input_reliability="reliable"):
        wait(lambda: peer.count_publishers("asap/stats") > 0, "the node reports")
        status = peer.diagnosed(ERROR, "/peer is not heard")
        assert "input_reliability" in status.message
    with AsapNode(latency_ms=200, output_reliability="best_effort"):
        peer.wait_for_node(consumers=False)
        for _ in range(30):
            peer.send(mono(np.arange(10) + peer.seq * 1000))
            time.sleep(0.05)
        peer.diagnosed(WARN, "no subscriber of the packages")
        make_peer(name="consumer")
        peer.diagnosed(ERROR, "/consumer hears nothing")


def test_parameters_change_or_are_refused_with_a_reason(peer: Peer) -> None:
    with AsapNode(latency_ms=20, feedback="topic") as node:
        peer.wait_for_node()
        peer.send(mono(np.array([1])))
        for bound_ms in (40, 30.5):  # as `ros2 param set` reads them: an integer, a double
            assert peer.set(latency_ms=bound_ms).successful
            us = bound_ms * 1000
            wait(lambda us=us: peer.next_stats()["latency_bound_us"] == us, "the bound")
        refused = {
            "latency_ms = nan: must be between 0.1 and 10000": {"latency_ms": float("nan")},
            "feedback_timeout_ms = 20: must be at least latency_ms = 50": {
                "latency_ms": 50,
                "feedback_timeout_ms": 20.0,
            },
            "latency_ms = soon: must be a number": {"latency_ms": "soon"},
        }
        for reason, values in refused.items():
            result = peer.set(**values)
            assert (result.successful, result.reason) == (False, reason)
        for name, value in (("latency_ms", -1.0), ("rate_bound", 1e12)):
            result = peer.set(**{name: value})
            assert not result.successful
            assert result.reason.startswith(f"{name} = {value:g}: must be between")
        assert not peer.set(encoding="mono").successful  # chosen when the node starts
        assert peer.next_stats()["latency_bound_us"] == 30_500
        assert node.process.poll() is None


FOR_ALL_NODES = """/**:
  ros__parameters:
    use_sim_time: false
    serial: "00042"
    latency_ms: 40
    qos_overrides./events.subscription.depth: 7
camera:
  ros__parameters:
    latency_us: 3
asap:
  ros__parameters:
    feedback: none
"""


def test_a_file_for_all_nodes(peer: Peer, tmp_path: Path) -> None:
    file = tmp_path / "all.yaml"
    words = ["--ros-args", "--params-file", str(file)]
    file.write_text(FOR_ALL_NODES)
    with AsapNode(words=words) as node:
        peer.wait_for_node()
        assert peer.next_stats()["latency_bound_us"] == 40_000
        code, said = node.interrupt()
    assert code == 0
    assert "ignored, not a parameter of this node: serial" in said
    file.write_text(FOR_ALL_NODES.replace("latency_ms", "latncy_ms"))
    with AsapNode(words=words) as node:
        code, said = node.end()
    assert code == 2
    assert "latncy_ms = 40: the node has no such parameter; did you mean latency_ms?" in said


def test_another_run_has_another_domain() -> None:
    code = "import os, ros2_door; print(os.environ['ROS_DOMAIN_ID'])"
    run = [sys.executable, "-c", code]
    other = subprocess.run(run, cwd=Path(__file__).parent, stdout=subprocess.PIPE, text=True)
    assert int(other.stdout) not in (0, int(os.environ["ROS_DOMAIN_ID"]))


def test_parameters_describe_themselves(peer: Peer) -> None:
    changing = {"latency_ms", "feedback_timeout_ms", "rate_bound"}
    fixed = {"reorder_tolerance_us", "warmup_discard_us", "capacity", "seed", "queue", "prefer"}
    fixed |= {"when_full", "feedback", "encoding", "input"}
    fixed |= {"input_reliability", "output_reliability"}
    names = [*changing, *fixed]
    client = peer.create_client(DescribeParameters, "asap/describe_parameters")
    with AsapNode():
        peer.wait_for_node()
        said = peer.ask(client, DescribeParameters.Request(names=names)).descriptors
    for parameter in said:
        assert parameter.description
        assert parameter.read_only == (parameter.name in fixed)
        assert parameter.additional_constraints.startswith(
            ("Must be one of", "Must be between", "Must be a whole number between")
        )


def test_late_events_are_lifted_within_the_tolerance(peer: Peer) -> None:
    with AsapNode(latency_ms=200, reorder_tolerance_us=100):
        peer.wait_for_node()
        peer.send(mono(np.array([1000, 920, 1001, 800])))
        stats = peer.settled()
    assert stats["ledger"]["delivered"] == 3
    assert stats["rejected"]["nonmonotonic"] == 1


def test_a_driver_of_today_reaches_reliable_and_best_effort_consumers(peer: Peer) -> None:
    best_effort = []
    peer.create_subscription(EventPacket, "asap/events", best_effort.append, DRIVERS_QOS)
    with AsapNode(encoding="mono", latency_ms=1000):  # a busy machine thins nothing
        peer.wait_for_node()
        wait(lambda: peer.count_subscribers("asap/events") == 2, "both consumers")
        for i in range(300):
            peer.send(mono(np.arange(100) * 10 + i * 1000))
            time.sleep(0.002)
        ledger = peer.settled()["ledger"]
    assert ledger["received"] == 30_000
    assert len(peer.events) == ledger["delivered"] == 30_000
    assert sum(len(packet.events) // 8 for packet in best_effort) == 30_000


def test_each_reliability_is_that_of_its_parameter(peer: Peer) -> None:
    for given, expected in (
        ({}, ["RELIABLE", "BEST_EFFORT"]),
        (
            {"input_reliability": "reliable", "output_reliability": "best_effort"},
            ["BEST_EFFORT", "RELIABLE"],
        ),
    ):
        with AsapNode(**given) as node:
            wait(lambda: peer.count_publishers("asap/events") > 0, "the node publishes")
            peer.next_stats()
            ends = peer.get_publishers_info_by_topic("asap/events")
            ends += peer.get_subscriptions_info_by_topic("events")
            seen = [end.qos_profile.reliability.name for end in ends if end.node_name == "asap"]
            assert seen == expected
            node.interrupt()
        wait(lambda: peer.count_publishers("asap/events") == 0, "the node is forgotten")


@pytest.mark.parametrize(
    ("parameters", "reason"),
    [
        ({"input": "events"}, "input = events: must be one of event_camera_msgs, dvs_msgs"),
        ({"input_reliability": "tcp"}, "input_reliability = tcp: must be one of best_effort"),
    ],
)
def test_a_node_with_bad_parameters_of_dds_does_not_start(parameters: dict, reason: str) -> None:
    with AsapNode(**parameters) as node:
        code, said = node.end()
    assert code == 2
    assert reason in said


def test_a_consumer_that_is_killed_and_comes_back(make_peer: Callable[..., Peer]) -> None:
    driver = make_peer(consume=False)
    with AsapNode(encoding="mono", latency_ms=200):
        driver.wait_for_node()
        with CppPeer("sink", "asap/events", 10**9) as first:
            wait(lambda: driver.count_subscribers("asap/events") == 1, "a consumer")
            driver.send(mono(np.arange(100)))
            driver.next_stats()
            first.process.kill()
        driver.send(mono(np.arange(100, 200)))
        assert driver.settled()["ledger"]["delivered"] == 200
        with CppPeer("sink", "asap/events", 100) as second:
            # One that was killed is on the list for some seconds more.
            wait(lambda: driver.count_subscribers("asap/events") == 2, "a second one")
            driver.next_stats()
            driver.send(mono(np.arange(200, 300)))
            assert second.result()["events"] == 100
        assert driver.settled()["ledger"]["delivered"] == 300


@pytest.mark.parametrize("latency_ms", [50, 200])
@pytest.mark.parametrize("how", ["loop", "restart", "untold"])
def test_stamps_follow_a_camera_whose_clock_begins_anew(
    make_peer: Callable[..., Peer], how: str, latency_ms: int
) -> None:
    """The consumer is slow, so that packages begin in messages that came long before."""
    consumer, sent = make_peer(), []

    def work(packet: Packet) -> None:
        time.sleep(latency_ms * 0.4e-3)
        consumer.finish(packet.seq, latency_ms * 0.4e-3)

    def play(driver: Peer, start_us: int) -> None:
        for i in range(80):  # .8 s; the number of the message is in x, that of the event in y
            payload = mono(np.arange(10) * 100 + i * 10_000, len(sent), np.arange(10))
            stamp = driver.send(payload, time_base=start_us * 1000)
            sent.append(stamp)
            time.sleep(0.01)

    consumer.on_packet = work
    consumer.answer()
    with AsapNode(encoding="mono", latency_ms=latency_ms):
        driver = make_peer(consume=False)
        consumer.wait_for_node()
        driver.wait_for_node(consumers=False)
        play(driver, 70_000_000)
        if how == "restart":
            driver.close()
            driver = make_peer(consume=False)
            driver.wait_for_node(consumers=False)
            time.sleep(1.0)
        if how == "loop":
            driver.seq = 0
        play(driver, 1_000_000 if how == "untold" else 70_000_000)
        stats = consumer.settled()
    ledger = stats["ledger"]
    assert (ledger["received"], stats["clock_resets"]) == (1600, 1)
    # 32 stamps in a row that stay there tell it, if nothing else does: the first are dropped.
    assert ledger["rejected"] <= (31 if how == "untold" else 0)
    errors_ns = []
    for packet in consumer.packets:
        first = int(np.frombuffer(packet.events[:8], "<u8")[0])
        number, place = first >> 32 & 0xFFFF, first >> 48 & 0x7FFF
        errors_ns.append((number, packet.stamp_ns - sent[number] - place * 100_000))
    if how == "untold":  # the first package may leave before its message has its place in time
        first = next(i for i, (number, _) in enumerate(errors_ns) if number >= 80)
        del errors_ns[first]
    worst_ns = max(abs(error) for _, error in errors_ns)
    print(f"{how}, bound {latency_ms} ms: stamps err by {worst_ns * 1e-6} ms at most")
    assert {number >= 80 for number, _ in errors_ns} == {False, True}
    assert worst_ns <= 1_000_000


def test_arrays_of_dvs_msgs_in_and_out(make_peer: Callable[..., Peer]) -> None:
    dvs = pytest.importorskip("dvs_msgs.msg")
    peer = make_peer(consume=False)
    arrays = []
    driver = peer.create_publisher(dvs.EventArray, "dvs", 10)
    peer.create_subscription(dvs.EventArray, "asap/events", arrays.append, 10)
    sent = dvs.EventArray(width=346, height=260)
    for i in range(100):
        event = dvs.Event(x=i, y=2 * i, polarity=i % 2 == 0)
        event.ts.sec, event.ts.nanosec = 1_700_000_000, i * 1000
        sent.events.append(event)
    with AsapNode(input="dvs_msgs", encoding="dvs_msgs", latency_ms=200, remap="events:=dvs"):
        wait(lambda: driver.get_subscription_count() > 0, "the node subscribes")
        wait(lambda: peer.count_publishers("asap/events") > 0, "the node publishes")
        peer.next_stats()
        driver.publish(sent)
        wait(lambda: sum(len(array.events) for array in arrays) == 100, "all events")
    assert [event for array in arrays for event in array.events] == list(sent.events)
    assert arrays[0].width == 346
