# SPDX-License-Identifier: Apache-2.0
"""Which places of a material are a surface: those that are at least half opaque.

Cycles decides by chance whether a ray passes a surface that is half transparent, for its picture of light is the mean of many rays. The data is
of one ray. So what is less than half opaque becomes wholly transparent for it, and the rest opaque.
"""

from . import blender_versions

HALF = 0.5


class Cutter:
    """Cuts the materials of a file; groups of nodes, which several may share, once."""

    def __init__(self):
        self.groups = {}  # (group, number of its output): the output added for its opacity

    def cut(self, material):
        """Returns a socket that is 1 where the material is a surface and otherwise 0, or None: it is one everywhere."""
        tree = blender_versions.node_tree_of(material)
        output = tree and (tree.get_output_node("CYCLES") or tree.get_output_node("ALL"))
        if not output or not output.inputs["Surface"].links:
            return None
        opacity = self._of_link(tree, output.inputs["Surface"].links[0])
        if opacity is None:
            return None
        above = _math(tree, "GREATER_THAN", opacity, HALF - 1e-6)
        mix, clear, solid = (tree.nodes.new(kind) for kind in ("ShaderNodeMixShader", "ShaderNodeBsdfTransparent", "ShaderNodeEmission"))
        tree.links.new(above, mix.inputs[0])
        tree.links.new(clear.outputs[0], mix.inputs[1])
        tree.links.new(solid.outputs[0], mix.inputs[2])
        tree.links.new(mix.outputs[0], output.inputs["Surface"])
        return above

    def _of_link(self, tree, link):
        """How opaque the shader is that a link comes from: a socket, a number, or None for 1."""
        node = link.from_node
        if node.mute:
            return None
        if node.type == "REROUTE":
            return self._of_input(tree, node.inputs[0])
        if node.type == "BSDF_TRANSPARENT":
            return 0.0
        if node.type == "BSDF_PRINCIPLED":
            alpha = _source(node.inputs["Alpha"])
            return None if alpha == 1 else alpha
        if node.type == "MIX_SHADER":
            first, second = (self._of_input(tree, node.inputs[k]) for k in (1, 2))
            if first is None and second is None:
                return None
            first, second = (1.0 if value is None else value for value in (first, second))
            step = _math(tree, "SUBTRACT", second, first)
            return _math(tree, "ADD", first, _math(tree, "MULTIPLY", step, _source(node.inputs[0])))
        if node.type == "ADD_SHADER":
            # The light of both shaders adds up, and so does their transparency.
            values = [value for value in (self._of_input(tree, socket) for socket in node.inputs) if value is not None]
            return None if not values else values[0] if len(values) == 1 else _math(tree, "SUBTRACT", _math(tree, "ADD", *values), 1.0)
        return self._of_group(node, link.from_socket) if node.type == "GROUP" else None

    def _of_input(self, tree, socket):
        """A shader input with nothing plugged in lets nothing through."""
        return self._of_link(tree, socket.links[0]) if socket.links else None

    def _of_group(self, node, socket):
        """Within the group, and by an output that is added to it."""
        group, number = node.node_tree, list(node.outputs).index(socket)
        if group is None:
            return None
        if (group, number) not in self.groups:
            self.groups[group, number] = None
            output = next((inner for inner in group.nodes if inner.type == "GROUP_OUTPUT" and inner.is_active_output), None)
            inside = self._of_input(group, output.inputs[number]) if output else None
            if inside is not None:
                added = blender_versions.add_group_output(group, f"touchable opacity {number}")
                place = next(k for k, outer in enumerate(output.inputs) if outer.name == added)
                if isinstance(inside, float):
                    output.inputs[place].default_value = inside
                else:
                    group.links.new(inside, output.inputs[place])
                self.groups[group, number] = added
        added = self.groups[group, number]
        return None if added is None else node.outputs[added]


def _source(socket):
    """What feeds an input: a socket, or a number."""
    return socket.links[0].from_socket if socket.links else float(socket.default_value)


def _math(tree, operation, first, second):
    node = tree.nodes.new("ShaderNodeMath")
    node.operation = operation
    for socket, value in zip(node.inputs, (first, second)):
        if isinstance(value, float):
            socket.default_value = value
        else:
            tree.links.new(value, socket)
    return node.outputs[0]
