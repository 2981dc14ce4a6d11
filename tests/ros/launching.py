"""Starts the launch files of the package: by launch_ros, or, where that is missing, by a stand-in.

The stand-in knows the words that our files use. It starts their nodes and containers with the
names, parameters and remappings that stand there; it starts no other process.
"""

from __future__ import annotations

import importlib.util
import runpy
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType
from typing import Any
from unittest import mock

from composition_interfaces.srv import LoadNode
from rclpy.parameter import Parameter
from ros2_door import PREFIXES, PRELOAD, Peer, program

WORDS = {
    "launch": ["LaunchContext", "LaunchDescription"],
    "launch.actions": ["DeclareLaunchArgument", "ExecuteProcess", "OpaqueFunction"],
    "launch.substitutions": ["LaunchConfiguration"],
    "launch_ros": [],
    "launch_ros.actions": ["ComposableNodeContainer", "Node"],
    "launch_ros.descriptions": ["ComposableNode"],
    "launch_ros.parameter_descriptions": ["ParameterValue"],
}

# What `ros2 launch` does.
LAUNCH = """
import sys, launch
from launch.launch_description_sources import PythonLaunchDescriptionSource
service = launch.LaunchService()
given = [tuple(word.split(":=")) for word in sys.argv[2:]]
service.include_launch_description(launch.LaunchDescription([
    launch.actions.IncludeLaunchDescription(
        PythonLaunchDescriptionSource(sys.argv[1]), launch_arguments=given)]))
sys.exit(service.run())
"""


class Said:
    """A word of a launch file: what it was called with."""

    def __init__(self, *values: Any, **fields: Any) -> None:
        self.word, self.values, self.fields = type(self).__name__, values, fields

    def perform(self, context: dict[str, str]) -> str:
        """Return what the launch has for a LaunchConfiguration."""
        return context[self.values[0]]


def actions_of(path: Path) -> list[Said]:
    """Return the actions that a launch file describes."""
    modules = {name: ModuleType(name) for name in WORDS}
    for name, words in WORDS.items():
        for word in words:
            setattr(modules[name], word, type(word, (Said,), {}))
    with mock.patch.dict(sys.modules, modules):
        return runpy.run_path(str(path))["generate_launch_description"]().values[0]


class Launch:
    """A launch file of the package, until the end of the `with` block."""

    def __init__(self, peer: Peer, name: str, *words: str) -> None:
        self.peer = peer
        paths = [prefix / "share/asap_ros/launch" / name for prefix in PREFIXES]
        self.path = next(path for path in paths if path.exists())
        self.given = dict(word.split(":=") for word in words)
        self.started: list[subprocess.Popen] = []

    def __enter__(self) -> Launch:
        if importlib.util.find_spec("launch_ros"):
            words = [f"{name}:={value}" for name, value in self.given.items()]
            self._start([sys.executable, "-c", LAUNCH, str(self.path), *words])
            return self
        for action in actions_of(self.path):
            self._do(action)
        return self

    def __exit__(self, *error: object) -> None:
        for process in self.started:
            process.send_signal(signal.SIGINT)
        for process in self.started:
            process.wait(timeout=60)

    def _start(self, command: Sequence[str]) -> None:
        self.started.append(subprocess.Popen(command, env=PRELOAD))

    def _do(self, action: Said) -> None:
        if action.word == "DeclareLaunchArgument" and action.values[0] not in self.given:
            self.given[action.values[0]] = action.fields["default_value"]
        if action.word == "OpaqueFunction":
            for described in action.fields["function"](self.given):
                self._do(described)
        if action.word not in ("Node", "ComposableNodeContainer"):
            return
        fields = action.fields
        words = ["--ros-args", "-r", f"__node:={fields['name']}"]
        if namespace := fields.get("namespace"):
            words += ["-r", f"__ns:=/{namespace}"]
        for name, value in self._parameters(fields).items():
            words += ["-p", f"{name}:={value}"]
        for rule in self._remappings(fields):
            words += ["-r", rule]
        self._start([program(fields["package"], fields["executable"]), *words])
        for component in fields.get("composable_node_descriptions", []):
            self._load(f"{fields['namespace']}/{fields['name']}".strip("/"), component.fields)

    def _load(self, container: str, fields: dict[str, Any]) -> None:
        """Load a component; as launch_ros does, go on where that fails."""
        request = LoadNode.Request(package_name=fields["package"], plugin_name=fields["plugin"])
        request.node_name, request.node_namespace = fields["name"], "/" + fields["namespace"]
        request.remap_rules = self._remappings(fields)
        for name, value in self._parameters(fields).items():
            request.parameters.append(Parameter(name, value=value).to_parameter_msg())
        for name, value in fields["extra_arguments"][0].items():
            request.extra_arguments.append(Parameter(name, value=value).to_parameter_msg())
        client = self.peer.create_client(LoadNode, f"/{container}/_container/load_node")
        self.peer.ask(client, request)

    def _parameters(self, fields: dict[str, Any]) -> dict[str, Any]:
        given: dict[str, Any] = {}
        for group in fields.get("parameters", []):
            given |= group
        return {name: self._value(value) for name, value in given.items()}

    def _remappings(self, fields: dict[str, Any]) -> list[str]:
        rules = fields.get("remappings", [])
        return [f"{name}:={self._value(to)}" for name, to in rules]

    def _value(self, said: Any) -> Any:
        if not isinstance(said, Said):
            return said
        if said.word == "ParameterValue":
            return said.fields["value_type"](self._value(said.values[0]))
        return said.perform(self.given)
