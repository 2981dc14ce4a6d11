"""A recording in its own pace, asap, and the tracker that takes its packages: no camera is needed.

ros2 launch asap_ros playback.launch.py bag:=recording topic:=/event_camera/events
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue


def generate_launch_description() -> LaunchDescription:
    """Start the player, the node and a consumer."""
    latency_ms = ParameterValue(LaunchConfiguration("latency_ms"), value_type=float)
    asap = Node(
        package="asap_ros",
        executable="asap_node",
        name="asap",
        parameters=[{"latency_ms": latency_ms}],
        remappings=[("events", LaunchConfiguration("topic"))],
        output="screen",
    )
    tracker = Node(
        package="asap_ros",
        executable="cluster_tracker",
        name="asap_cluster_tracker",
        parameters=[{"latency_ms": latency_ms}],
        remappings=[("events", "/asap/events")],
        output="screen",
    )
    return LaunchDescription(
        [
            DeclareLaunchArgument("bag"),
            DeclareLaunchArgument("topic", default_value="/event_camera/events"),
            DeclareLaunchArgument("latency_ms", default_value="10.0"),
            asap,
            tracker,
            ExecuteProcess(cmd=["ros2", "bag", "play", LaunchConfiguration("bag")]),
        ]
    )
