"""The node between a driver and a consumer in C++ (peers/peer.cpp): rate, copies, virtual time."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
import pytest
from door import DATA, Program, ledger_in, mono, wait
from ros2_door import PRELOAD, QOS, AsapNode, CppPeer, Peer, messages_of, program
from std_msgs.msg import UInt64

BAG = "room_person_evt3.db3"


def test_twenty_million_events_per_second_are_accounted_for(make_peer: Callable[..., Peer]) -> None:
    """What a starved node does not fetch in time, DDS drops: its driver's numbers tell."""
    size, count = 20_000, 3_000
    watcher = make_peer(consume=False)

    def seen() -> int:
        stats = watcher.next_stats()
        return stats["ledger"]["received"] + size * stats["upstream_lost"]["packets"]

    with AsapNode(latency_ms=200) as node, CppPeer("source", size, count, 1_000) as source:
        took = source.result()["seconds"]
        wait(lambda: seen() == size * count, "every event is in the ledger, or lost before")
        code, said = node.interrupt()
    ledger = ledger_in(said)
    print(f"{size * count / took * 1e-6:.1f} Mev/s: {ledger}, {watcher.stats[-1]['upstream_lost']}")
    assert code == 0
    assert ledger.get("rejected", 0) == ledger.get("overflow", 0) == 0
    assert sum(ledger.values()) == 2 * ledger["received"]


def test_in_the_drivers_process_no_packet_is_copied() -> None:
    with CppPeer("process", "asap", 1_000, 1_000, 1_000) as process:
        result = process.result()
    print(result)
    assert result["events"] == 1_000 * 1_000
    assert result["allocations"] == result["messages"]  # the driver's own


def test_a_node_with_more_threads_finds_the_same_corners(make_peer: Callable[..., Peer]) -> None:
    peer, random, found = make_peer(consume=False), np.random.default_rng(0), set()
    x, y = random.integers(100, 140, (2, 200, 100))
    counts: list[int] = []
    peer.create_subscription(UInt64, "asap/corners", lambda count: counts.append(count.data), 10)
    words = [program("asap_ros", "corners"), "--ros-args", "-r", "__node:=asap"]
    words += ["-p", "latency_ms:=10000.0", "-p"]  # a busy machine thins nothing
    for threads in (1, 3):
        with Program([*words, f"threads:={threads}"], PRELOAD) as node:
            peer.wait_for_node(consumers=False)
            for i in range(200):
                peer.send(mono(np.arange(100) + i * 100, x[i], y[i]))
                time.sleep(0.01)
            wait(lambda: peer.next_stats()["ledger"]["delivered"] == 20_000, "all events")
            found.add(counts[-1])
            node.interrupt()
        wait(lambda: peer.driver.get_subscription_count() == 0, "the node is forgotten")
    assert len(found) == 1
    assert found.pop() > 0


def test_two_cameras_in_one_process_are_not_merged(make_peer: Callable[..., Peer]) -> None:
    """They have one frame, one size and the same numbers."""
    watcher, count = make_peer(consume=False), 5_000
    with CppPeer("process", "asap", 100, count, 1_000, 2) as process:
        watcher.diagnosed(1, "two cameras: /source is heard, /source is refused")
        stats = watcher.next_stats()
        events = process.result()["events"]
    print(stats["messages"], stats["clock_resets"], events)
    assert stats["clock_resets"] <= 2
    assert stats["messages"]["refused_publisher"] > 0
    assert events <= 100 * count * 1.1  # of one camera; both for the first second at most


@pytest.mark.skipif(not (DATA / "ros" / BAG).exists(), reason=f"no {BAG}")
def test_virtual_time_makes_the_packages_of_python(make_peer: Callable[..., Peer]) -> None:
    asap = pytest.importorskip("asap", reason="no wheel of asap: set ASAP_DIST")
    messages = messages_of(BAG)
    driver = make_peer(consume=False, qos=QOS)  # every message has to arrive
    with CppPeer("virtual", len(messages)) as bridge:
        wait(lambda: driver.driver.get_subscription_count() > 0, "the bridge subscribes")
        driver.play(messages)
        rows = bridge.result()
    cost = asap.LinearCost(alpha_us=100, beta_ns=3000)
    run = asap.simulate(DATA / "ros" / BAG, cost=cost, latency_ms=10, execution="whole")
    columns = ("start_us", "t_first", "t_last", "offered", "size")
    assert len(rows) > 1_000
    assert [tuple(row) for row in rows] == run.packages[list(columns)].tolist()
