"""The node as a robot has it, in ROS 1 and ROS 2 alike: see `door`."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import pytest
from door import DATA, Packet, ledger_in, mono, this_door, wait

door = this_door()
AsapNode, BAGS, messages_of = door.AsapNode, door.BAGS, door.messages_of
BAG, (EVENTS, _, _) = next(iter(BAGS.items()))
needs_bags = pytest.mark.skipif(not (DATA / "ros" / BAG).exists(), reason=f"no {BAG}")
LOST = ("rejected", "filtered", "discarded", "stale", "overflow", "pending")
OK, WARN, ERROR = range(3)


@needs_bags
@pytest.mark.parametrize("bag", BAGS)
def test_every_event_of_a_bag_is_accounted_for(peer: Any, bag: str) -> None:
    count, width, height = BAGS[bag]
    with AsapNode(encoding="mono", latency_ms=200) as node:
        peer.wait_for_node()
        peer.play(messages_of(bag))
        stats = peer.settled()
        code, said = node.interrupt()
    ledger = ledger_in(said)
    assert code == 0
    assert stats["ledger"]["received"] == ledger["received"] == count
    assert stats["upstream_lost"] == {"marks": 0, "packets": 0}
    assert sum(ledger.get(name, 0) for name in ("delivered", *LOST)) == count
    assert len(peer.events) == ledger["delivered"]
    stamps = [packet.time_base // 1000 for packet in peer.packets]
    assert stamps == sorted(stamps)
    assert {packet[2:5] for packet in peer.packets} == {(width, height, "mono")}
    assert [packet.seq for packet in peer.packets] == list(range(1, len(peer.packets) + 1))


@needs_bags
def test_a_consumer_five_times_too_slow_keeps_the_bound(peer: Any) -> None:
    messages = messages_of(BAG)
    per_event_s = 5 * (messages[-1][0] - messages[0][0]) * 1e-9 / EVENTS

    def work(packet: Packet) -> None:
        start = time.monotonic()
        time.sleep(len(packet.events) / 8 * per_event_s)
        peer.finish(packet.seq, time.monotonic() - start)

    peer.on_packet = work
    peer.answer()
    with AsapNode(encoding="mono", latency_ms=200) as node:
        peer.wait_for_node()
        peer.play(messages)
        status = peer.diagnosed(WARN, "Bottleneck: the algorithm. ")
        stats = peer.settled()
        code, _ = node.interrupt()
    print({key: stats[key] for key in ("ledger", "latency_us", "kept", "feedback", "packages")})
    print(status.message)
    assert code == 0
    assert stats["ledger"]["received"] == EVENTS
    assert stats["ledger"]["overflow"] == 0
    in_time = stats["in_time"] * EVENTS / stats["ledger"]["delivered"]
    assert in_time > 0.9  # p99 is below the bound unless the machine holds the peers up
    assert stats["feedback"]["taken"] == stats["packages"]["count"]
    assert 0.02 < stats["kept"] < 0.35
    assert len(peer.events) == stats["ledger"]["delivered"]


def test_bad_messages_are_counted_by_reason(peer: Any) -> None:
    with AsapNode(encoding="mono", latency_ms=200) as node:
        peer.wait_for_node()
        peer.send(mono(np.arange(10)))
        peer.send(b"", encoding="evt4")
        peer.send(b"1234567")
        peer.send(b"1", encoding="evt3")
        peer.send(mono(np.arange(10)), width=0)
        peer.send(mono(np.arange(10)), width=100_000)
        peer.send(mono(np.arange(10)), is_bigendian=True)
        peer.send(mono(np.array([20, 15, 30])))  # unsorted
        peer.send(mono(np.array([40, 41]), x=np.array([639, 640])))  # outside
        peer.send(mono(np.array([50])), width=320, height=240)  # another camera's
        for _ in range(1000):
            peer.send(b"", encoding="evt4")
            time.sleep(1e-3)
        peer.send(mono(np.array([60])))
        wait(lambda: peer.next_stats()["messages"]["received"] == 1011, "all messages")
        stats = peer.settled()
        code, said = node.interrupt()
    messages = stats["messages"]
    assert (messages["refused_encoding"], messages["refused_size"]) == (1001, 2)
    assert (messages["refused_geometry"], messages["refused_big_endian"]) == (3, 1)
    assert stats["ledger"]["received"] == 16
    assert stats["rejected"]["nonmonotonic"] == stats["rejected"]["out_of_bounds"] == 1
    assert stats["upstream_lost"]["packets"] == 0
    assert len(peer.events) == stats["ledger"]["delivered"] == 14
    assert code == 0
    assert 1 <= said.count("message refused") <= 10  # once a second


def test_diagnostics_name_the_trouble(peer: Any) -> None:
    t_us = 0

    def send(level: int, words: str, **fields: object) -> None:
        nonlocal t_us
        for _ in range(60):
            t_us += 50_000
            peer.send(mono(np.arange(10)), time_base=t_us * 1000, **fields)
            time.sleep(0.05)
        peer.diagnosed(level, words)

    peer.answer()
    peer.on_packet = lambda packet: peer.finish(packet.seq, 0.0)
    with AsapNode(encoding="mono", latency_ms=500):
        peer.wait_for_node()
        peer.diagnosed(WARN, "no message on /events")
        send(OK, "ok")
        send(ERROR, "messages refused: encoding (from ", encoding="evt4")
        peer.seq += 5
        send(WARN, "5 messages are missing: lost by the driver or the network")
        peer.diagnosed(WARN, "no message on /events for 2 s")
        peer.on_packet = lambda packet: peer.finish(packet.seq, 1000.0)  # in ms
        send(WARN, "feedback refused: time = 1000: the package left ")
        peer.on_packet = lambda packet: peer.finish(packet.seq + 1, 0.0)
        send(WARN, "feedback refused: seq = ")
        peer.on_packet = lambda packet: None
        send(WARN, "stalled: no feedback for ")
        peer.on_packet = lambda packet: peer.finish(packet.seq, 0.0)
        send(OK, "ok")
    status = peer.said[-1]
    assert (status.name, status.hardware_id) == ("/asap", "camera")
    assert status.values["state"] == "open"  # no quotes


@pytest.mark.parametrize(
    ("parameters", "reason"),
    [
        ({"prefer": "all"}, "prefer = all: must be one of balanced, events, continuity"),
        ({"encoding": "evt2"}, "encoding = evt2: must be one of evt3, mono, dvs_msgs"),
        ({"latency_ms": 5000.0}, "feedback_timeout_ms = 1000: must be at least latency_ms = 5000"),
        ({"latency_ms": "10ms"}, "latency_ms = 10ms: must be a number"),
        ({"latncy_ms": 5}, "latncy_ms = 5: the node has no such parameter; did you mean latency"),
        ({"seed": 1.5}, "seed = 1.5: must be a whole number between 0 and"),
        ({"queue": 0}, "queue = 0: must be a whole number between 1 and 100000"),
    ],
)
def test_a_node_with_bad_parameters_does_not_start(parameters: dict, reason: str) -> None:
    with AsapNode(**parameters) as node:
        code, said = node.end()
    assert code == 2
    assert reason in said


def test_parameters_of_other_nodes_are_named_and_ignored(peer: Any) -> None:
    with AsapNode(latency_ms=50, fps=30, bias_file="none") as node:
        peer.wait_for_node()
        assert peer.next_stats()["latency_bound_us"] == 50_000
        _, said = node.interrupt()
    for name in ("fps", "bias_file"):
        assert f"ignored, not a parameter of this node: {name}" in said


def test_sigint_ends_the_node_while_it_waits_for_feedback(peer: Any) -> None:
    peer.answer()
    # A busy machine makes nothing stale.
    with AsapNode(encoding="mono", latency_ms=10_000, feedback_timeout_ms=60_000) as node:
        peer.wait_for_node()
        peer.send(mono(np.arange(1000)))
        wait(lambda: peer.packets, "a package")
        peer.send(mono(np.arange(1000, 2000)))
        peer.next_stats()
        code, said = node.interrupt()
    ledger = ledger_in(said)
    assert code == 0
    assert ledger["received"] == 2000
    assert ledger.get("pending", 0) == 0


@pytest.mark.parametrize("way", ["topic", "service"])
def test_late_feedback_of_an_earlier_package_is_refused(peer: Any, way: str) -> None:
    say = peer.finish if way == "topic" else peer.call
    if way == "topic":
        peer.answer()
    with AsapNode(encoding="mono", latency_ms=500, feedback=way, feedback_timeout_ms=1500):
        peer.wait_for_node()
        peer.send(mono(np.arange(10)))
        wait(lambda: len(peer.packets) == 1, "a package")
        wait(lambda: peer.next_stats()["feedback"]["timeouts"] == 1, "its time is up")
        peer.send(mono(np.arange(100, 110)))
        wait(lambda: len(peer.packets) == 2, "the next package")
        say(peer.packets[0].seq, 0.0)
        say(peer.packets[1].seq, 0.0)
        wait(lambda: peer.next_stats()["feedback"]["taken"] == 1, "the right one")
        assert peer.stats[-1]["feedback"]["refused"] == 1


def test_no_call_of_the_service_is_lost(peer: Any) -> None:
    count = 10_000
    with AsapNode(feedback="service"):
        assert not any(peer.calls(count))  # no package was in flight
        assert peer.next_stats()["feedback"]["refused"] == count


def test_refusals_are_logged_under_simulated_time(peer: Any) -> None:
    with AsapNode(use_sim_time=True) as node:  # there is no clock: it stays at 0
        peer.wait_for_node()
        for _ in range(2):
            peer.send(b"", encoding="evt4")
            time.sleep(1.2)
        _, said = node.interrupt()
    assert said.count("message refused: encoding (from /") == 2
