"""A Prophesee camera with its driver, and asap in the same process: packets are not copied.

ros2 launch asap_ros camera.launch.py latency_ms:=5.0
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import ComposableNodeContainer
from launch_ros.descriptions import ComposableNode
from launch_ros.parameter_descriptions import ParameterValue


def generate_launch_description() -> LaunchDescription:
    """Start one container with both components."""
    within = [{"use_intra_process_comms": True}]
    driver = ComposableNode(
        package="metavision_driver",
        plugin="metavision_driver::DriverROS2",
        name="event_camera",
        extra_arguments=within,
    )
    asap = ComposableNode(
        package="asap_ros",
        plugin="asap_ros::PackageNode",
        name="asap",
        parameters=[
            {
                "latency_ms": ParameterValue(LaunchConfiguration("latency_ms"), value_type=float),
                "feedback": LaunchConfiguration("feedback"),
                "encoding": LaunchConfiguration("encoding"),
            }
        ],
        remappings=[
            ("events", "/event_camera/events"),
            # As the node of the paper names them, in whatever namespace this one is.
            ("~/events", "/asap/events"),
            ("~/feedback", "/asap/feedback"),
        ],
        extra_arguments=within,
    )
    container = ComposableNodeContainer(
        name="events",
        namespace="",
        package="rclcpp_components",
        executable="component_container",
        composable_node_descriptions=[driver, asap],
        output="screen",
    )
    return LaunchDescription(
        [
            DeclareLaunchArgument("latency_ms", default_value="10.0"),
            DeclareLaunchArgument("feedback", default_value="none"),
            DeclareLaunchArgument("encoding", default_value="evt3"),
            container,
        ]
    )
