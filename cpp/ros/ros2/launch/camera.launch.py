"""A camera with its driver, and asap in the same process: packets are not copied.

ros2 launch asap_ros camera.launch.py driver:=metavision serial:=00051 latency_ms:=5.0
"""

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import ComposableNodeContainer
from launch_ros.descriptions import ComposableNode
from launch_ros.parameter_descriptions import ParameterValue

DRIVERS = {"metavision": "metavision_driver::DriverROS2", "libcaer": "libcaer_driver::Driver"}
ARGUMENTS = {
    "driver": ("metavision", "metavision or libcaer"),
    "device_type": ("davis", "for libcaer: davis, dvxplorer, ..."),
    "serial": ("", "serial number of the camera; empty: the first one"),
    "bias_file": ("", "for metavision a .bias file, for libcaer a YAML file of parameters"),
    "namespace": ("", "of both nodes"),
    "latency_ms": (10.0, "as the parameter of asap, and so the rest"),
    "feedback_timeout_ms": (1000.0, ""),
    "queue": (1000, ""),
    "prefer": ("balanced", ""),
    "feedback": ("topic", ""),
    "encoding": ("evt3", ""),
    "input_reliability": ("best_effort", ""),
    "output_reliability": ("reliable", ""),
}


def containers(context: LaunchContext) -> list[ComposableNodeContainer]:
    """Return one container with both components."""
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    driver, bias_file = given["driver"], given["bias_file"]
    names = ["serial", "bias_file" if driver == "metavision" else "device_type"]
    camera = [{name: ParameterValue(given[name], value_type=str) for name in names}]
    if driver == "libcaer" and bias_file:
        camera.append(bias_file)
    asap = {name: type(ARGUMENTS[name][0])(given[name]) for name in [*ARGUMENTS][5:]}
    plugins = [
        (f"{driver}_driver", DRIVERS[driver], "event_camera", camera, []),
        ("asap_ros", "asap_ros::PackageNode", "asap", [asap], [("events", "event_camera/events")]),
    ]
    components = [
        ComposableNode(
            package=package,
            plugin=plugin,
            name=name,
            namespace=given["namespace"],
            parameters=parameters,
            remappings=rules,
            extra_arguments=[{"use_intra_process_comms": True}],
        )
        for package, plugin, name, parameters, rules in plugins
    ]
    container = ComposableNodeContainer(
        name="events",
        namespace=given["namespace"],
        package="rclcpp_components",
        executable="component_container",
        composable_node_descriptions=components,
        output="screen",
    )
    return [container]


def generate_launch_description() -> LaunchDescription:
    """Start the container."""
    declared = [
        DeclareLaunchArgument(name, default_value=str(value), description=text)
        for name, (value, text) in ARGUMENTS.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=containers)])
