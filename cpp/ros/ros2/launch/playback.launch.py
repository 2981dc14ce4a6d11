"""A recording in its own pace, asap, and the tracker that takes its packages: no camera is needed.

ros2 launch asap_ros playback.launch.py bag:=recording topic:=/event_camera/events
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue


def node(executable: str, name: str, topic: LaunchConfiguration | str) -> Node:
    """Return a node that takes the events of a topic."""
    latency_ms = ParameterValue(LaunchConfiguration("latency_ms"), value_type=float)
    given = {"parameters": [{"latency_ms": latency_ms}], "remappings": [("events", topic)]}
    return Node(package="asap_ros", executable=executable, name=name, output="screen", **given)


def generate_launch_description() -> LaunchDescription:
    """Start the player, the node and a consumer."""
    return LaunchDescription(
        [
            DeclareLaunchArgument("bag"),
            DeclareLaunchArgument("topic", default_value="/event_camera/events"),
            DeclareLaunchArgument("latency_ms", default_value="10.0"),
            node("asap_node", "asap", LaunchConfiguration("topic")),
            node("cluster_tracker", "asap_cluster_tracker", "/asap/events"),
            ExecuteProcess(cmd=["ros2", "bag", "play", LaunchConfiguration("bag")]),
        ]
    )
