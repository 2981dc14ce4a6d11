"""The node as a robot has it: messages over TCPROS on loopback. tests/ros1/run starts this."""

from __future__ import annotations

import io
import subprocess
import time
from collections.abc import Callable, Iterator
from typing import IO

import genpy.dynamic
import numpy as np
import pytest
import rospy
from asap_ros.msg import ProcessingTime
from asap_ros.srv import Feedback, FeedbackRequest
from diagnostic_msgs.msg import DiagnosticArray
from peers import (
    DATA,
    Array,
    AsapNode,
    Master,
    Packet,
    Peer,
    array,
    events_in,
    ledger_in,
    messages_of,
    packet,
    peers,
    seq_of,
    stamp_of,
    wait,
)

make_peer = pytest.fixture(peers)

# Of `room_person_evt3.bag`, as every reader of bags counts them.
BAG, EVENTS = DATA / "ros" / "room_person_evt3.bag", 343_474
needs_bag = pytest.mark.skipif(not BAG.exists(), reason=f"no {BAG.name}")
LOST = ("rejected", "filtered", "discarded", "stale", "overflow", "pending")


@pytest.fixture(scope="session", autouse=True)
def master() -> Iterator[Master]:
    made = Master()
    made.start()
    rospy.init_node("test", disable_signals=True)
    yield made
    made.kill()


@pytest.fixture
def peer(make_peer: Callable[..., Peer]) -> Peer:
    return make_peer()


@needs_bag
def test_every_event_of_a_bag_is_accounted_for(make_peer: Callable[..., Peer]) -> None:
    peer = make_peer(driver=Packet)
    with AsapNode(latency_ms=200) as node:
        peer.wait_for_node()
        peer.play(messages_of(BAG))
        stats = peer.settled()
        code, said = node.interrupt()
    ledger = ledger_in(said)
    print(ledger, stats["latency_us"])
    assert code == 0
    assert stats["ledger"]["received"] == ledger["received"] == EVENTS
    assert stats["upstream_lost"] == {"marks": 0, "packets": 0}
    assert sum(ledger.get(name, 0) for name in ("delivered", *LOST)) == EVENTS
    events = peer.events
    assert len(events) == ledger["delivered"]
    t_us = events["s"] * np.int64(1_000_000) + events["ns"] // 1000
    assert (np.diff(t_us) >= 0).all()
    assert events["x"].max() < 640
    assert events["y"].max() < 480


@needs_bag
def test_a_consumer_five_times_too_slow_keeps_the_bound(make_peer: Callable[..., Peer]) -> None:
    peer, messages = make_peer(driver=Packet), messages_of(BAG)
    per_event_s = 5 * (messages[-1][0] - messages[0][0]) / EVENTS
    feedback = rospy.Publisher("/asap/processing_time", ProcessingTime, queue_size=10)

    def work(message: bytes) -> None:
        start = time.monotonic()
        time.sleep(len(events_in(message)) * per_event_s)
        feedback.publish(ProcessingTime(seq_of(message), time.monotonic() - start))

    peer.on_package = work
    with AsapNode(latency_ms=200, feedback="topic") as node:
        peer.wait_for_node()
        wait(lambda: feedback.get_num_connections() > 0, "the node listens")
        peer.play(messages)
        stats = peer.settled()
        code, _ = node.interrupt()
    print({key: stats[key] for key in ("ledger", "latency_us", "kept", "feedback", "packages")})
    assert code == 0
    assert stats["ledger"]["received"] == EVENTS
    assert stats["ledger"]["overflow"] == 0
    assert stats["feedback"]["taken"] == stats["packages"]["count"]
    assert 0.02 < stats["kept"] < 0.35
    assert len(peer.events) == stats["ledger"]["delivered"]


def test_arrays_go_in_and_out_as_they_are(peer: Peer) -> None:
    random = np.random.default_rng(1)
    t_us = np.sort(random.integers(1_600_000_000_000_000, 1_600_000_000_100_000, 5000))
    x, y = random.integers(0, 640, 5000), random.integers(0, 480, 5000)
    sent = [
        array(t_us[i : i + 50], x[i : i + 50], y[i : i + 50], seq=i) for i in range(0, 5000, 50)
    ]
    with AsapNode(latency_ms=1000):
        peer.wait_for_node()
        for message in sent:
            peer.send(message)
        wait(lambda: len(peer.events) == 5000, "all events")
    assert (peer.events == np.concatenate([events_in(message) for message in sent])).all()


def test_the_messages_are_those_of_the_published_packages(make_peer: Callable[..., Peer]) -> None:
    """A class that genpy makes of the definition has the sum that the node states, and reads it."""
    peer, definitions = make_peer(consumer=None), []
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
            peer.send(array([5, 6]))
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


def test_bad_messages_are_counted_by_reason(peer: Peer) -> None:
    good = array(np.arange(10))
    with AsapNode(latency_ms=200) as node:
        peer.wait_for_node()
        peer.send(good)
        for message in (b"", good[:20], good[:-1], good + b"\0", b"\xff" * 100):
            peer.send(message)
        peer.send(array([15], width=0))
        peer.send(array([20, 15, 30]))  # unsorted
        peer.send(array([40, 41], x=[639, 640]))  # outside
        peer.send(array([50], width=320, height=240))  # another camera's
        peer.send(array([60]))
        wait(lambda: peer.next_stats()["messages"]["received"] == 11, "all messages")
        stats = peer.settled()
        code, said = node.interrupt()
    messages = stats["messages"]
    assert (messages["refused_size"], messages["refused_geometry"]) == (5, 2)
    assert stats["ledger"]["received"] == 16
    assert stats["rejected"]["nonmonotonic"] == stats["rejected"]["out_of_bounds"] == 1
    assert len(peer.events) == stats["ledger"]["delivered"] == 14
    assert code == 0
    assert 1 <= said.count("message refused") <= 10  # once a second


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


def test_bad_packets_are_counted_and_logged_once_a_second(make_peer: Callable[..., Peer]) -> None:
    peer = make_peer(driver=Packet)
    word = (1 << 63 | 5000).to_bytes(8, "little")
    with AsapNode(latency_ms=200) as node:
        peer.wait_for_node()
        peer.send(packet(word))
        peer.send(packet(b"1234567"))
        peer.send(packet(word, big=True))
        peer.send(packet(word)[:-1])
        for _ in range(1000):
            peer.send(packet(b"", encoding=b"evt4"))
        peer.send(packet(word))
        wait(lambda: peer.next_stats()["messages"]["received"] == 1005, "all messages")
        stats = peer.settled()
        code, said = node.interrupt()
    messages = stats["messages"]
    assert (messages["refused_size"], messages["refused_big_endian"]) == (2, 1)
    assert messages["refused_encoding"] == 1000
    assert len(peer.events) == stats["ledger"]["delivered"] == 2
    assert code == 0
    assert 1 <= said.count("message refused") <= 10


def test_what_the_driver_lost_is_counted(peer: Peer) -> None:
    with AsapNode(latency_ms=200):
        peer.wait_for_node()
        peer.send(array([1], seq=1))
        peer.send(array([2], seq=12))
        wait(lambda: peer.next_stats()["upstream_lost"]["packets"] == 10, "ten are missing")
        assert peer.stats[-1]["upstream_lost"]["marks"] == 1


def test_parameters_change_or_are_refused_with_a_reason(peer: Peer) -> None:
    with AsapNode(latency_ms=20, feedback="topic") as node:
        peer.wait_for_node()
        peer.send(array([1]))
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


@pytest.mark.parametrize(
    ("parameters", "reason"),
    [
        ({"prefer": "all"}, "prefer = all: must be one of balanced, events, continuity"),
        ({"encoding": "evt2"}, "encoding = evt2: must be one of evt3, mono, dvs_msgs"),
        (
            {"latency_ms": 5000.0, "feedback": "topic"},
            "feedback_timeout_ms = 1000: must be at least latency_ms = 5000",
        ),
        ({"latency_ms": "10ms"}, "latency_ms = 10ms: must be a number"),
        ({"queue": 0}, "queue = 0: must be between 1 and 100000"),
    ],
)
def test_a_node_with_bad_parameters_does_not_start(parameters: dict, reason: str) -> None:
    with AsapNode(**parameters) as node:
        code, said = node.end()
    assert code == 2
    assert reason in said


def test_sigint_ends_the_node_while_it_waits_for_feedback(peer: Peer) -> None:
    with AsapNode(latency_ms=1000, feedback="topic", feedback_timeout_ms=60_000) as node:
        peer.wait_for_node()
        peer.send(array(np.arange(1000)))
        wait(lambda: peer.packages, "a package")
        peer.send(array(np.arange(1000, 2000)))
        peer.next_stats()
        code, said = node.interrupt()
    ledger = ledger_in(said)
    assert code == 0
    assert ledger["received"] == 2000
    assert ledger.get("pending", 0) == 0
    wait(lambda: len(peer.events) == ledger["delivered"], "what was delivered at the end")


def test_the_node_ends_by_the_call_of_rosnode_kill(peer: Peer) -> None:
    with AsapNode(latency_ms=200) as node:
        peer.wait_for_node()
        peer.send(array(np.arange(1000)))
        peer.next_stats()
        subprocess.run(["rosnode", "kill", "/asap"], check=True, stdout=subprocess.DEVNULL)
        code, said = node.end()
    assert code == 0
    assert ledger_in(said) == {"received": 1000, "delivered": 1000}


def test_the_node_goes_on_without_feedback(peer: Peer) -> None:
    troubles = []
    diagnostics = rospy.Subscriber("/diagnostics", DiagnosticArray, troubles.append)
    with AsapNode(feedback="topic", feedback_timeout_ms=50):
        peer.wait_for_node()
        for i in range(20):
            peer.send(array([i * 1000]))
            time.sleep(0.02)
        stats = peer.settled()
        assert stats["feedback"]["timeouts"] >= 1
        assert stats["state"] == "stalled"
        assert len(peer.packages) == stats["packages"]["count"]
        wait(lambda: "stalled" in troubles[-1].status[0].message, "a warning")
    diagnostics.unregister()
    assert troubles[-1].status[0].name == "/asap"
    assert troubles[0].status[0].message == "no message on /events"


def test_no_call_of_the_service_is_lost(peer: Peer) -> None:
    count = 10_000
    with AsapNode(feedback="service"):
        rospy.wait_for_service("/asap/feedback", 30.0)
        call = rospy.ServiceProxy("/asap/feedback", Feedback, persistent=True)
        assert not any(call(time=1e-3).success for _ in range(count))  # no package was in flight
        assert peer.next_stats()["feedback"]["refused"] == count
        call.close()


class PublishedFeedback(Feedback):
    """The service of the published node, which has no `seq`."""

    _md5sum = "any other"

    class _request_class(FeedbackRequest):
        def serialize(self, buffer: IO[bytes]) -> None:
            whole = io.BytesIO()
            super().serialize(whole)
            buffer.write(whole.getvalue()[:-8])


@pytest.mark.parametrize("service", [Feedback, PublishedFeedback])
def test_feedback_by_the_service_sends_the_next_package(peer: Peer, service: type) -> None:
    call, taken = rospy.ServiceProxy("/asap/feedback", service, persistent=True), []

    def work(package: bytes) -> None:
        named = {"seq": seq_of(package)} if service is Feedback else {}
        taken.append(call(time=0.0, **named).success)

    peer.on_package = work
    with AsapNode(feedback="service", feedback_timeout_ms=60_000, latency_ms=1000):
        peer.wait_for_node()
        for i in range(10):
            peer.send(array(np.arange(i * 1000, i * 1000 + 10)))
        wait(lambda: len(peer.events) == 100, "all events")
        stats = peer.settled()
        assert all(taken)
        assert stats["feedback"]["taken"] == stats["packages"]["count"] == len(taken)
    call.close()


def test_a_consumer_that_leaves_and_comes_back(make_peer: Callable[..., Peer]) -> None:
    driver, first = make_peer(consumer=None), make_peer()
    with AsapNode(latency_ms=200):
        first.wait_for_node()
        driver.send(array(np.arange(100)))
        wait(lambda: len(first.events) == 100, "the first consumer's events")
        first.close()
        driver.send(array(np.arange(100, 200)))
        driver.settled()
        second = make_peer()
        second.wait_for_node()
        driver.send(array(np.arange(200, 300)))
        wait(lambda: len(second.events) == 100, "the second consumer's events")
        assert driver.settled()["ledger"]["delivered"] == 300


def test_a_driver_that_begins_anew_with_another_sensor(peer: Peer) -> None:
    large = array(np.arange(50), x=1279, y=719, width=1280, height=720, seq=1)
    with AsapNode(latency_ms=200) as node:
        peer.wait_for_node()
        peer.send(array(np.arange(100), seq=5))
        wait(lambda: len(peer.events) == 100, "the old driver's events")
        peer.send(large)
        wait(lambda: peer.next_stats()["messages"]["refused_geometry"] == 1, "a stray message")
        peer.send(large)  # the other one has been silent for a second
        wait(lambda: len(peer.events) == 150, "the new driver's events")
        _, said = node.interrupt()
    assert said.count("run ended: received 100 = delivered 100") == 1
    assert ledger_in(said) == {"received": 50, "delivered": 50}


def test_a_stray_message_costs_the_camera_one_second(peer: Peer) -> None:
    late = 0
    with AsapNode(latency_ms=200) as node:
        peer.wait_for_node()
        peer.send(array(np.arange(10), width=320, height=240))
        wait(lambda: len(peer.events) == 10, "the stray events")
        start = time.monotonic()
        for i in range(200):
            late += time.monotonic() - start > 1.0
            peer.send(array(np.arange(10) + i * 10_000, seq=i))
            time.sleep(0.01)
        stats = peer.settled()
        _, said = node.interrupt()
    assert 10 * late <= stats["ledger"]["delivered"] <= 10 * (late + 5)
    assert "message refused: geometry (from /test" in said


def test_a_bag_that_loops_loses_no_event_and_keeps_its_stamps(peer: Peer) -> None:
    with AsapNode(latency_ms=200):
        peer.wait_for_node()
        for i in range(160):  # .8 s, twice; a message has its number in x and as its stamp in s
            t_us = np.arange(10) * 100 + i % 80 * 10_000
            peer.send(array(t_us, x=i, seq=i % 80, stamp_s=1000 + i))
            time.sleep(0.005)
        wait(lambda: len(peer.events) == 1600, "all events")
        stats = peer.settled()
    assert (stats["ledger"]["rejected"], stats["clock_resets"]) == (0, 1)
    for package in peer.packages:
        first = events_in(package)[0]
        assert 0 <= stamp_of(package) - (1000 + first["x"]) < 1e-3


def test_diagnostics_have_a_level_for_each_trouble(peer: Peer) -> None:
    said = []
    diagnostics = rospy.Subscriber("/diagnostics", DiagnosticArray, said.append)

    def found(level: int, message: str) -> bool:
        status = said[-1].status[0] if said else None
        return status is not None and status.level == level and message in status.message

    with AsapNode(latency_ms=200):
        peer.wait_for_node()
        wait(lambda: found(1, "no message on /events"), "silence")
        for trouble, level, message in (
            ({"x": 640}, 2, "events rejected"),
            ({"width": 0}, 2, "messages refused"),
            ({}, 0, "ok"),
        ):
            end = time.monotonic() + 30
            while not found(level, message):
                assert time.monotonic() < end, said[-1]
                peer.driver_time = getattr(peer, "driver_time", 0) + 50_000
                peer.send(array(np.arange(10) + peer.driver_time, **trouble))
                time.sleep(0.05)
    status = said[-1].status[0]
    values = {entry.key: entry.value for entry in status.values}
    assert (status.hardware_id, values["state"]) == ("camera", "open")
    diagnostics.unregister()


def test_late_feedback_of_an_earlier_package_is_refused(peer: Peer) -> None:
    finished = rospy.Publisher("/asap/processing_time", ProcessingTime, queue_size=10)
    with AsapNode(feedback="topic", feedback_timeout_ms=1500, latency_ms=500):
        peer.wait_for_node()
        wait(lambda: finished.get_num_connections() > 0, "the node listens")
        peer.send(array(np.arange(10)))
        wait(lambda: peer.next_stats()["feedback"]["timeouts"] == 1, "its time is up")
        peer.send(array(np.arange(100, 110), seq=1))
        wait(lambda: len(peer.packages) == 2, "the next package")
        for package in peer.packages:
            finished.publish(ProcessingTime(seq_of(package), 0.0))
        wait(lambda: peer.next_stats()["feedback"]["taken"] == 1, "the right one")
        assert peer.stats[-1]["feedback"]["refused"] == 1


def test_refusals_are_logged_under_simulated_time(peer: Peer) -> None:
    rospy.set_param("/use_sim_time", True)
    try:
        with AsapNode() as node:  # there is no clock: it stays at 0
            peer.wait_for_node()
            for _ in range(2):
                peer.send(array([1], width=0))
                time.sleep(1.2)
            _, said = node.interrupt()
    finally:
        rospy.delete_param("/use_sim_time")
    assert said.count("message refused: geometry") == 2


def test_a_rate_bound_thins(peer: Peer) -> None:
    with AsapNode(latency_ms=100, rate_bound=10_000.0):
        peer.wait_for_node()
        for i in range(100):  # 100,000 events/s
            peer.send(array(np.arange(i * 10_000, (i + 1) * 10_000, 10)))
            time.sleep(0.01)
        stats = peer.settled()
        assert stats["ledger"]["received"] == 100_000
        assert stats["ledger"]["overflow"] == 0
        elapsed_s = stats["packages"]["count"] / stats["packages"]["per_s"]
        assert len(peer.events) == stats["ledger"]["delivered"] <= 10_000 * elapsed_s * 1.1


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
    with AsapNode(latency_ms=200) as node:
        peer.wait_for_node()
        peer.send(array(np.arange(100)))
        wait(lambda: len(peer.events) == 100, "events")
        master.kill()
        try:
            peer.send(array(np.arange(100, 200)))
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
