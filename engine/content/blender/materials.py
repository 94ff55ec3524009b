# SPDX-License-Identifier: Apache-2.0
"""What a material feels like: what an artist has set, or a guess by how it looks.

An artist sets custom properties of the material, and nodes among its nodes by their labels:
- "touchable_stiffness" (N/mm), "touchable_static_friction", "touchable_dynamic_friction": numbers;
- "touchable_relief" (metres): how much higher white is than black of the node "Touch Height";
- the node "Touch Haptic": red, green and blue are factors of the three numbers.
A number may be animated.
"""

import math
from dataclasses import dataclass, field

import bpy

from . import blender_versions

STIFFNESS, STATIC, DYNAMIC, RELIEF = ("touchable_stiffness", "touchable_static_friction", "touchable_dynamic_friction",
                                      "touchable_relief")
HAPTIC_NODE, HEIGHT_NODE = "Touch Haptic", "Touch Height"

# Limits of what a person may set, and a clip can store.
LIMITS = {STIFFNESS: (0.0, 100.0), STATIC: (0.0, 10.0), DYNAMIC: (0.0, 10.0), RELIEF: (0.0, 1000.0)}

# Metres; a deeper relief is not meant to be felt: it is the default of 1 of a node's scale or distance.
DEEPEST_GUESS = 0.1

# Nodes that light shows relief by, and their inputs whose product is its depth; those of the others shift places to any side.
RELIEF_NODES = {"DISPLACEMENT": ("Scale",), "BUMP": ("Strength", "Distance"), "NORMAL_MAP": (), "VECTOR_DISPLACEMENT": ()}

# For objects without a material, or with one that no guess knows: touchable's own defaults.
UNKNOWN = (0.6, 0.4, 0.3)


@dataclass
class Feel:
    """A material's values at one frame, and which sockets of its nodes vary them."""

    name: str
    stiffness: float
    static_friction: float
    dynamic_friction: float
    relief: float = 0.0  # metres; below 0 what the socket has as high is low
    haptic_socket: object = None
    height_socket: object = None
    guessed: list = field(default_factory=list)  # words
    remarks: list = field(default_factory=list)

    def values(self):
        return self.stiffness, self.static_friction, self.dynamic_friction


def metres_per_unit_of(scene):
    return scene.unit_settings.scale_length if scene.unit_settings.system != "NONE" else 1.0


def feel_of(material, metres_per_unit):
    """As the material is now; None: of an object without any."""
    if material is None:
        return Feel("no material", *UNKNOWN, guessed=["stiffness", "friction"])
    guess = _guess_by_looks(material)
    remarks = []
    stated = [_number(material, key, remarks) for key in (STIFFNESS, STATIC, DYNAMIC)]
    stiffness, static = (guess[k] if stated[k] is None else stated[k] for k in (0, 1))
    dynamic = stated[2]
    feel = Feel(material.name, stiffness, static, dynamic, remarks=remarks)
    if dynamic is None:
        feel.dynamic_friction = round(0.75 * static, 2) if stated[1] is not None else min(guess[2], static)
    elif stated[1] is None:
        feel.static_friction = max(static, dynamic)
    elif dynamic > static:
        feel.dynamic_friction = static
        feel.remarks.append(f"the dynamic friction of '{material.name}', {dynamic:g}, is above its static one, {static:g}, which counts")
    if stated[0] is None:
        feel.guessed.append("stiffness")
    if stated[1] is None and stated[2] is None:
        feel.guessed.append("friction")
    _find_sockets(material, feel, metres_per_unit)
    return feel


def _number(material, key, remarks):
    """A custom property as a number within what can be said; None: it is not set, or is no number. Adds to `remarks` where another counts."""
    value = material.get(key)
    if value is None:
        return None
    if not isinstance(value, (int, float)) or not math.isfinite(value):
        remarks.append(f"{key} of '{material.name}' is no number, and counts as not set")
        return None
    least, most = LIMITS[key]
    within = min(max(float(value), least), most)
    if within != value:
        remarks.append(f"{key} of '{material.name}' is {value:g}, and {within:g} counts: it is from {least:g} to {most:g}")
    return within


def _guess_by_looks(material):
    """Metals are hard and slide, what is rough rubs, what light goes into is soft. Two digits, as it is a guess."""
    shader = _principled(material)
    if shader is None:
        return UNKNOWN
    metallic, roughness, subsurface = (_constant(blender_versions.principled_input(shader, name), otherwise)
                                       for name, otherwise in (("Metallic", 0.0), ("Roughness", 0.5), ("Subsurface", 0.0)))
    stiffness = (0.8 + 0.8 * metallic) * (1 - 0.6 * subsurface)
    static = (0.15 + 0.6 * roughness) * (1 - 0.25 * metallic)
    return round(stiffness, 2), round(static, 2), round(0.75 * static, 2)


def _principled(material):
    tree = blender_versions.node_tree_of(material)
    return next((node for node in tree.nodes if node.type == "BSDF_PRINCIPLED"), None) if tree else None


def _constant(socket, otherwise):
    """What a socket has where nothing is plugged in."""
    if socket is None or socket.is_linked:
        return otherwise
    return min(max(float(socket.default_value), 0.0), 1.0)


def labelled_node(material, label):
    """The node that a person has given this label, or this name."""
    tree = blender_versions.node_tree_of(material)
    return next((node for node in tree.nodes if label in (node.label, node.name) and node.outputs), None) if tree else None


def _find_sockets(material, feel, metres_per_unit):
    haptic, height = labelled_node(material, HAPTIC_NODE), labelled_node(material, HEIGHT_NODE)
    if haptic:
        feel.haptic_socket = haptic.outputs[0]
    relief = _number(material, RELIEF, feel.remarks)
    if height and relief:
        feel.height_socket, feel.relief = height.outputs[0], relief
    elif height and relief is None:
        feel.remarks.append(f"the node '{HEIGHT_NODE}' of '{material.name}' is not felt: set {RELIEF}, in metres")
    elif relief:
        feel.remarks.append(f"{RELIEF} of '{material.name}' is not felt: label the node with its heights '{HEIGHT_NODE}'")
    elif relief is None:
        _guess_relief(material, feel, metres_per_unit)


def _guess_relief(material, feel, metres_per_unit):
    """Of a displacement or bump that light alone shows: it says how deep it is. Where it moves the geometry, depth has it."""
    tree = blender_versions.node_tree_of(material)
    output = tree.get_output_node("ALL") if tree else None
    for node in _nodes_behind(output.inputs["Displacement"], output.inputs["Surface"]) if output else ():
        moves_geometry = node.type.endswith("DISPLACEMENT") and blender_versions.is_displaced(material)
        factors = [node.inputs[name] for name in RELIEF_NODES.get(node.type, ())]
        if node.type not in RELIEF_NODES or node.mute or moves_geometry or factors and not node.inputs["Height"].is_linked:
            continue
        relief = math.prod(factor.default_value for factor in factors) * metres_per_unit * (-1 if getattr(node, "invert", False) else 1)
        why = ("it has no heights" if not factors else "it is in a group of nodes" if node.id_data != tree
               else "another node's relief counts" if feel.height_socket else "nodes compute its depth" if any(factor.is_linked for factor in factors)
               else f"it is {abs(relief):.3g} m deep, and at most {DEEPEST_GUESS:g} m are guessed" if abs(relief) > DEEPEST_GUESS else None)
        if why:
            feel.remarks.append(f"the {node.bl_label} of '{material.name}' is not felt: {why}; label a node with heights '{HEIGHT_NODE}' and set {RELIEF}")
        else:  # at a depth of 0 too: it may be animated
            feel.height_socket, feel.relief = node.inputs["Height"].links[0].from_socket, relief
            feel.guessed += ["relief"] if relief else []
    feel.remarks = list(dict.fromkeys(feel.remarks))


def _nodes_behind(*sockets):
    """Those that feed the sockets, the nearest first, within groups too."""
    waiting, found = list(sockets), []
    for socket in waiting:
        for node in (link.from_node for link in socket.links if link.from_node not in found):
            found.append(node)
            waiting += node.inputs
            if node.type == "GROUP" and node.node_tree:
                waiting += [inner for output in node.node_tree.nodes if output.type == "GROUP_OUTPUT" for inner in output.inputs]
    return found


def materials_in_use():
    """In the order of their names."""
    return sorted((material for material in bpy.data.materials if material.users),
                  key=lambda material: (material.library.filepath if material.library else "", material.name))


def guessed_line(feels):
    """One line for those of a picture's materials of which something was guessed; None: of none."""
    words = []
    for feel in feels:
        if feel.guessed:
            values = [f"{feel.stiffness:g} N/mm"] if "stiffness" in feel.guessed else []
            if "friction" in feel.guessed:
                values.append(f"friction {feel.static_friction:g} and {feel.dynamic_friction:g}")
            if "relief" in feel.guessed:
                values.append(f"relief {1000 * feel.relief:.4g} mm")
            words.append(f"{feel.name} ({', '.join(values)})")
    if not words:
        return None
    rest = f" and {len(words) - 8} more" if len(words) > 8 else ""
    return f"guessed: by how they look, what these materials feel like: {', '.join(words[:8])}{rest}"[:1900]
