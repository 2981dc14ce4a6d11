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
}
PARAMETERS = {  # of asap
    "latency_ms": "10.0",
    "feedback": "none",
    "encoding": "evt3",
    "input_reliability": "best_effort",
    "output_reliability": "reliable",
}


def containers(context: LaunchContext) -> list[ComposableNodeContainer]:
    """Return one container with both components."""

    def given(name: str) -> str:
        return LaunchConfiguration(name).perform(context)

    driver, bias_file, namespace = given("driver"), given("bias_file"), given("namespace")
    camera = [{"serial": ParameterValue(given("serial"), value_type=str)}]
    if driver == "metavision":
        camera[0]["bias_file"] = bias_file
    else:
        camera = [*camera, {"device_type": given("device_type")}, *filter(None, [bias_file])]
    asap = {name: given(name) for name in PARAMETERS} | {"latency_ms": float(given("latency_ms"))}

    def node(package: str, plugin: str, name: str, **fields: list) -> ComposableNode:
        within = [{"use_intra_process_comms": True}]
        return ComposableNode(
            package=package,
            plugin=plugin,
            name=name,
            namespace=namespace,
            extra_arguments=within,
            **fields,
        )

    rules = [("events", "event_camera/events")]
    container = ComposableNodeContainer(
        name="events",
        namespace=namespace,
        package="rclcpp_components",
        executable="component_container",
        composable_node_descriptions=[
            node(f"{driver}_driver", DRIVERS[driver], "event_camera", parameters=camera),
            node("asap_ros", "asap_ros::PackageNode", "asap", parameters=[asap], remappings=rules),
        ],
        output="screen",
    )
    return [container]


def generate_launch_description() -> LaunchDescription:
    """Start the container."""
    arguments = ARGUMENTS | {name: (value, "as in asap") for name, value in PARAMETERS.items()}
    declared = [
        DeclareLaunchArgument(name, default_value=value, description=text)
        for name, (value, text) in arguments.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=containers)])
