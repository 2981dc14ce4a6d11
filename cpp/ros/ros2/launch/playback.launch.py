"""A recording in its own pace, asap, and the tracker that takes its packages: no camera is needed.

ros2 launch asap_ros playback.launch.py bag:=recording topic:=/event_camera/events loop:=true
"""

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

ARGUMENTS = {
    "bag": (None, "the recording"),
    "topic": ("/event_camera/events", "its events"),
    "latency_ms": ("10.0", "of both nodes"),
    "prefer": ("balanced", "of both nodes"),
    "rate": ("1.0", "speed of the recording"),
    "loop": ("false", "true: begin again at its end"),
    "clock": ("false", "true: the recording's time is the nodes' time"),
}


def actions(context: LaunchContext) -> list[Node | ExecuteProcess]:
    """Return the node, a consumer and the player."""
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    shared = {
        "latency_ms": float(given["latency_ms"]),
        "prefer": given["prefer"],
        "use_sim_time": given["clock"] == "true",
    }

    def node(executable: str, name: str, topic: str, **own: str) -> Node:
        more = {"parameters": [shared | own], "remappings": [("events", topic)]}
        return Node(package="asap_ros", executable=executable, name=name, output="screen", **more)

    options = [f"--{name}" for name in ("loop", "clock") if given[name] == "true"]
    play = ["ros2", "bag", "play", given["bag"], "--rate", given["rate"], *options]
    return [
        node("asap_node", "asap", given["topic"], feedback="none"),  # the tracker has its own bound
        node("cluster_tracker", "asap_cluster_tracker", "/asap/events"),
        ExecuteProcess(cmd=play),
    ]


def generate_launch_description() -> LaunchDescription:
    """Start them."""
    declared = [
        DeclareLaunchArgument(name, default_value=value, description=text)
        for name, (value, text) in ARGUMENTS.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=actions)])
