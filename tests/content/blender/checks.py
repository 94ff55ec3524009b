# SPDX-License-Identifier: Apache-2.0
"""What is checked within Blender: blender -b --factory-startup --python-exit-code 9 -P checks.py. The first that fails ends it."""

import importlib
import itertools
import os
import subprocess
import sys
import tempfile
import time
import traceback

import bpy
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Vector

sys.dont_write_bytecode = True
HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "../../../engine/content"))

from blender import export, materials, motion
from blender.camera import camera_of, picture_size
from blender.planes import range_of


def fresh():
    bpy.ops.wm.read_factory_settings()
    return bpy.context.scene


def check_cameras():
    """Focal lengths, centre and shifts against what Blender itself says of where a point is seen."""
    scene = fresh()
    seen, render = scene.camera, scene.render
    seen.scale = (1.5, 1.5, 1.5)
    lens = seen.data
    lens.sensor_width, lens.sensor_height = 36, 20
    points = [seen.matrix_world.normalized() @ Vector(place) for place in ((0, 0, -3), (0.7, 0.4, -2), (-1, 0.3, -5), (0.2, -0.9, -4))]
    for fit, size, aspect, percent, shift, focal in itertools.product(
            ("AUTO", "HORIZONTAL", "VERTICAL"), ((720, 480), (300, 901)), ((1, 1), (1.5, 1), (1, 1.7)), (100, 37), ((0, 0), (0.2, -0.35)), (50, 17)):
        lens.sensor_fit, lens.lens, (lens.shift_x, lens.shift_y) = fit, focal, shift
        render.resolution_x, render.resolution_y, render.resolution_percentage = *size, percent
        render.pixel_aspect_x, render.pixel_aspect_y = aspect
        bpy.context.view_layer.update()
        camera, (width, height) = camera_of(scene), picture_size(scene)
        # Blender's own answer is a share of the whole picture of the size before the percentage is taken.
        rounded = abs(width - size[0] * percent / 100) + abs(height - size[1] * percent / 100) > 0
        for point in points:
            place = seen.matrix_world.normalized().inverted() @ point
            ours = (camera.cx + camera.fx * place.x / -place.z, camera.cy - camera.fy * place.y / -place.z)
            share = world_to_camera_view(scene, seen, point)
            theirs = (share.x * width - 0.5, (1 - share.y) * height - 0.5)
            assert rounded or all(abs(a - b) < 0.002 for a, b in zip(ours, theirs)), (fit, size, aspect, percent, shift, focal, ours, theirs)


def check_ranges():
    """Every one of a few values has a code of its own, exactly; of too many the ends have."""
    for values in ({0.5}, {0.2, 0.5, 1.8}, {0.1, 0.25, 0.95, 0.3}, {0.0, 2.0}, {0.333, 0.7}):
        limits = range_of(values, False)
        for value in values:
            code = float(limits.codes(value, 255))
            assert abs(limits.least + (limits.most - limits.least) * code / 255 - value) < 1e-12, (values, limits)
    limits = range_of({0.1234, 0.5, 0.987654}, False)
    assert (limits.least, limits.most) == (0.1234, 0.987654)
    assert range_of({0.5}, True).least == 0


def check_what_moves():
    """Nothing in Blender's own scene; each of these does."""
    def keyframe(scene):
        bpy.data.objects["Cube"].keyframe_insert("location")

    def driver(scene):
        bpy.data.materials["Material"].driver_add("roughness")

    def node_keyframe(scene):
        bpy.data.materials["Material"].node_tree.nodes["Principled BSDF"].inputs["Roughness"].keyframe_insert("default_value")

    def shape_key(scene):
        cube = bpy.data.objects["Cube"]
        cube.shape_key_add(name="Basis")
        cube.shape_key_add(name="Wide").keyframe_insert("value")

    def modifier(scene):
        bpy.data.objects["Cube"].modifiers.new("Wave", "WAVE")

    def particles(scene):
        bpy.data.objects["Cube"].modifiers.new("Dust", "PARTICLE_SYSTEM")

    def film(scene):
        bpy.data.images.new("film", 4, 4).source = "MOVIE"

    def script(scene):
        bpy.app.handlers.frame_change_pre.append(lambda *_: None)

    def marker(scene):
        scene.timeline_markers.new("cut", frame=5).camera = scene.camera

    scene = fresh()
    assert motion.what_may_move() is None, motion.what_may_move()
    scene.frame_set(7)
    assert list(motion.frames_of(scene, None)[0]) == [7]
    assert list(motion.frames_of(scene, (2, 4))[0]) == [2, 3, 4]
    for change in (keyframe, driver, node_keyframe, shape_key, modifier, particles, film, script, marker):
        scene = fresh()
        change(scene)
        assert motion.what_may_move(), change.__name__
        scene.frame_end, scene.frame_step = 11, 4
        assert list(motion.frames_of(scene, None)[0]) == [1, 5, 9], change.__name__
    bpy.app.handlers.frame_change_pre.clear()


def check_guesses():
    """Of a material that says something only the rest is guessed."""
    fresh()
    made = bpy.data.materials["Material"]
    feel = materials.feel_of(made, 1.0)
    assert feel.values() == (0.8, 0.45, 0.34) and feel.guessed == ["stiffness", "friction"], feel
    made["touchable_stiffness"] = 3
    made["touchable_dynamic_friction"] = 0.9
    feel = materials.feel_of(made, 1.0)
    assert feel.values() == (3, 0.9, 0.9) and not feel.guessed, feel
    made["touchable_static_friction"] = 0.2
    feel = materials.feel_of(made, 1.0)
    assert feel.values() == (3, 0.2, 0.2) and "0.9" in feel.remarks[0], feel
    none = materials.feel_of(None, 1.0)
    assert none.guessed == ["stiffness", "friction"] and "no material (0.6 N/mm, friction 0.4 and 0.3)" in materials.guessed_line([none])


def check_relief():
    """Of a displacement that only light shows; not of one that moves the geometry, which depth has."""
    scene = fresh()
    made = bpy.data.materials["Material"]
    tree = made.node_tree
    noise, displacement = tree.nodes.new("ShaderNodeTexNoise"), tree.nodes.new("ShaderNodeDisplacement")
    displacement.inputs["Scale"].default_value = 0.02
    tree.links.new(noise.outputs["Fac"], displacement.inputs["Height"])
    tree.links.new(displacement.outputs[0], tree.get_output_node("ALL").inputs["Displacement"])
    feel = materials.feel_of(made, 0.5)
    assert abs(feel.relief - 0.01) < 1e-8 and feel.height_socket == noise.outputs["Fac"] and "relief" in feel.guessed, feel
    assert "relief 10 mm" in materials.guessed_line([feel])
    displacement.inputs["Scale"].default_value = 1
    assert materials.feel_of(made, 0.5).height_socket is None
    displacement.inputs["Scale"].default_value = 0.02
    owner = made if hasattr(made, "displacement_method") else made.cycles
    owner.displacement_method = "BOTH"
    assert materials.feel_of(made, 0.5).height_socket is None
    owner.displacement_method = "BUMP"
    made["touchable_relief"] = 0.0
    assert materials.feel_of(made, 0.5).height_socket is None


def check_bumps():
    """Strength times distance, as a displacement's scale; what light shows and no finger feels is named."""
    def node(tree, kind, source=None, into=None):
        made = tree.nodes.new(f"ShaderNode{kind}")
        if source:
            tree.links.new(source, made.inputs["Height"])
        if into:
            tree.links.new(made.outputs[0], into)
        return made

    def in_group(tree, bump):
        group = bpy.data.node_groups.new("rough", "ShaderNodeTree")
        opacity.blender_versions.add_group_output(group, "Out")
        node(group, "Bump", node(group, "TexNoise").outputs[0], group.nodes.new("NodeGroupOutput").inputs[0])
        outer = node(tree, "Group")
        outer.node_tree = group
        tree.links.new(outer.outputs[0], tree.nodes["Principled BSDF"].inputs["Normal"])

    from blender import opacity
    cases = (  # what is done to a bump of 0.5 and 0.04, where a unit is half a metre; the relief; what is said
        (lambda tree, bump: None, 0.01, None),
        (lambda tree, bump: setattr(bump, "invert", True), -0.01, None),
        (lambda tree, bump: setattr(bump, "mute", True), 0, None),
        (lambda tree, bump: setattr(bump.inputs["Distance"], "default_value", 1), 0, "the Bump of 'Material' is not felt: it is 0.25 m deep"),
        (lambda tree, bump: node(tree, "Value", into=bump.inputs["Distance"]), 0, "nodes compute its depth"),
        (lambda tree, bump: node(tree, "NormalMap", into=bump.inputs["Normal"]), 0.01, "the Normal Map of 'Material' is not felt: it has no heights"),
        (lambda tree, bump: node(tree, "Bump", bump.inputs["Height"].links[0].from_socket, bump.inputs["Normal"]), 0.01, "another node's relief"),
        (in_group, 0, "the Bump of 'Material' is not felt: it is in a group"),
        (lambda tree, bump: setattr(bump, "label", "Touch Height"), 0, "'Touch Height' of 'Material' is not felt: set touchable_relief"),
        (lambda tree, bump: bpy.data.materials["Material"].__setitem__("touchable_relief", 0.1), 0, "label the node"))
    for change, relief, why in cases:
        fresh()
        tree = bpy.data.materials["Material"].node_tree
        bump = node(tree, "Bump", node(tree, "TexNoise").outputs[0], tree.nodes["Principled BSDF"].inputs["Normal"])
        bump.inputs["Strength"].default_value, bump.inputs["Distance"].default_value = 0.5, 0.04
        change(tree, bump)
        feel = materials.feel_of(bpy.data.materials["Material"], 0.5)
        assert abs(feel.relief - relief) < 1e-8 and (feel.height_socket is not None) == ("relief" in feel.guessed) == bool(relief), (relief, why, feel)
        assert len(feel.remarks) == bool(why) and (why or "") in "".join(feel.remarks), (why, feel.remarks)


def check_opacity():
    """What is less than half opaque is no surface: shaders mixed, added and within groups."""
    from blender import opacity

    def kinds(tree, *names):
        return [tree.nodes.new(f"ShaderNode{name}") for name in names]

    def material_of(build):
        made = bpy.data.materials.new("made")
        made.use_nodes = True
        made.node_tree.nodes.remove(made.node_tree.nodes["Principled BSDF"])
        shader = build(made.node_tree)
        made.node_tree.links.new(shader, made.node_tree.get_output_node("ALL").inputs["Surface"])
        return made

    def mixed(tree, share=0.3):
        mix, clear, solid = kinds(tree, "MixShader", "BsdfTransparent", "BsdfDiffuse")
        mix.inputs[0].default_value = share
        tree.links.new(clear.outputs[0], mix.inputs[1])
        tree.links.new(solid.outputs[0], mix.inputs[2])
        return mix.outputs[0]

    def added(tree):
        add, light = kinds(tree, "AddShader", "Emission")
        tree.links.new(mixed(tree, 0.6), add.inputs[0])
        tree.links.new(light.outputs[0], add.inputs[1])
        return add.outputs[0]

    def grouped(tree):
        group = bpy.data.node_groups.get("leaf")
        if group is None:
            group = bpy.data.node_groups.new("leaf", "ShaderNodeTree")
            opacity.blender_versions.add_group_output(group, "Shader", "NodeSocketShader")
            group.links.new(mixed(group, 0.2), group.nodes.new("NodeGroupOutput").inputs[0])
        node = tree.nodes.new("ShaderNodeGroup")
        node.node_tree = group
        return node.outputs[0]

    fresh()
    cutter = opacity.Cutter()
    opaque = material_of(lambda tree: kinds(tree, "BsdfGlass")[0].outputs[0])
    assert cutter.cut(opaque) is None
    made = [material_of(build) for build in (mixed, lambda tree: mixed(tree, 0.7), added, grouped, grouped)]
    assert all(cutter.cut(each) is not None for each in made)
    assert len(next(node for node in made[-1].node_tree.nodes if node.type == "GROUP").outputs) == 2
    # By Cycles' own word: a row of squares with these materials, seen from above.
    scene = bpy.context.scene
    for thing in list(bpy.data.objects):
        bpy.data.objects.remove(thing)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.data.sensor_width, camera.data.lens = (2.5, 0.5, 10), 5, 10
    scene.collection.objects.link(camera)
    scene.camera = camera
    for number, each in enumerate([opaque, *made]):
        mesh = bpy.data.meshes.new("square")
        mesh.from_pydata([(number - 0.5 + x, y, 0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], [], [(0, 1, 2, 3)])
        mesh.materials.append(each)
        scene.collection.objects.link(bpy.data.objects.new("square", mesh))
    scene.render.resolution_x, scene.render.resolution_y = 60, 12
    from blender import data_pass
    data_pass.prepare(scene, [], [])
    with tempfile.TemporaryDirectory() as folder:
        row = data_pass.take(scene, folder).depth[6]
    seen = [float(sum(row[12 * number - 4:12 * number + 4] < 100)) / 8 for number in range(1, 5)]
    assert seen == [0, 1, 1, 0], seen


def pictures_of(**wish):
    """What an export of the current scene writes, by name, and what it says."""
    from blender import job

    said = []
    with tempfile.TemporaryDirectory() as folder:
        job.Export(job.Wish(size=(32, 32), colour=False, **wish), folder, said.append).run()
        return {entry.name: open(entry.path, "rb").read() for entry in os.scandir(folder)}, said


def check_whole_picture():
    """A render region is the artist's, and no part of what the camera sees."""
    scene = fresh()
    whole, _ = pictures_of()
    scene = fresh()
    scene.render.use_border, scene.render.border_max_x = True, 0.4
    assert pictures_of()[0] == whole


def check_animated():
    """A relief that begins with 0, and one that is guessed, are plugged in; a remark of any frame is said once."""
    def labelled(made, nodes):
        white = nodes.new("ShaderNodeValue")
        white.label, white.outputs[0].default_value = "Touch Height", 1
        for frame, relief in ((1, 0.0), (3, 0.02)):
            made["touchable_relief"] = relief
            made.keyframe_insert('["touchable_relief"]', frame=frame)

    def guessed(made, nodes):
        white, displacement = nodes.new("ShaderNodeValue"), nodes.new("ShaderNodeDisplacement")
        white.outputs[0].default_value = 1
        made.node_tree.links.new(white.outputs[0], displacement.inputs["Height"])
        made.node_tree.links.new(displacement.outputs[0], made.node_tree.get_output_node("ALL").inputs["Displacement"])
        for frame, relief in ((1, 0.0), (3, 0.02)):
            displacement.inputs["Scale"].default_value = relief
            displacement.inputs["Scale"].keyframe_insert("default_value", frame=frame)

    for build in (labelled, guessed):
        fresh()
        made = bpy.data.materials["Material"]
        build(made, made.node_tree.nodes)
        made["touchable_static_friction"] = 0.3
        for frame, friction in ((1, 0.1), (3, 0.6)):
            made["touchable_dynamic_friction"] = friction
            made.keyframe_insert('["touchable_dynamic_friction"]', frame=frame)
        files, said = pictures_of(frames=(1, 3))
        assert files["height_000000.png"] != files["height_000002.png"], build.__name__
        assert len([line for line in said if "which counts" in line]) == 1, said
        if build is guessed:
            assert "relief" in said[-1], said
            # A guess that is too deep for a near surface ends no export.
            assert any("is felt at 0.75" in line for line in pictures_of(frames=(3, 3), near=0.03)[1])


def check_no_numbers():
    """What is no number counts as not set, and what is out of range as the nearest that is not; a line names it."""
    fresh()
    made = bpy.data.materials["Material"]
    plain = materials.feel_of(made, 1).values()
    for key, value in (("stiffness", float("nan")), ("static_friction", float("inf")), ("dynamic_friction", "soft")):
        made[f"touchable_{key}"] = value
    feel = materials.feel_of(made, 1)
    assert feel.values() == plain and len(feel.remarks) == 3 and all("'Material' is no number" in line for line in feel.remarks), feel
    made["touchable_stiffness"] = 1e30
    feel = materials.feel_of(made, 1)
    assert feel.stiffness == 100 and "1e+30, and 100 counts" in feel.remarks[0], feel


def check_broken_textures():
    """Not a number is as a factor of 1, and a line says so."""
    fresh()
    made = bpy.data.materials["Material"]
    nodes, links = made.node_tree.nodes, made.node_tree.links
    white = nodes.new("ShaderNodeValue")
    white.label, white.outputs[0].default_value = "Touch Haptic", 1
    plain, _ = pictures_of()
    fresh()
    made = bpy.data.materials["Material"]
    nodes, links = made.node_tree.nodes, made.node_tree.links
    infinite, nan = nodes.new("ShaderNodeVectorMath"), nodes.new("ShaderNodeVectorMath")
    infinite.operation, nan.operation, nan.label = "MULTIPLY", "SUBTRACT", "Touch Haptic"
    for number in (0, 1):
        infinite.inputs[number].default_value = (1e38,) * 3
        links.new(infinite.outputs[0], nan.inputs[number])
    files, said = pictures_of()
    assert any("no number or infinite" in line for line in said), said
    assert files["haptic_000000.png"] == plain["haptic_000000.png"]


def check_short_files():
    """A full disk cuts a file off wherever it is."""
    from blender import faults, pictures

    scene = fresh()
    from blender import data_pass
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.render.resolution_percentage = 100
    data_pass.prepare(scene, [], [])
    with tempfile.TemporaryDirectory() as folder:
        path = scene.render.filepath = os.path.join(folder, "data.exr")
        scene.render.use_file_extension = False
        bpy.ops.render.render(write_still=True)
        whole = open(path, "rb").read()
        assert pictures.read_exr(path)
        for length in range(0, len(whole), max(1, len(whole) // 50)):
            with open(path, "wb") as file:
                file.write(whole[:length])
            try:
                pictures.read_exr(path)
                assert False, length
            except faults.Fault as fault:
                assert "disk may be full" in str(fault), (length, fault)


def check_addon():
    """Its operators export the file as it is in this session, saved or not, and leave the session as it is."""
    import blender

    scene = fresh()
    blender.register()
    scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", 1, False
    scene.render.resolution_x, scene.render.resolution_y = 64, 48
    made = bpy.data.materials["Material"]
    assert bpy.ops.material.touchable_set.poll()
    bpy.ops.material.touchable_set()
    assert materials.feel_of(made, 1).values() == (0.8, 0.45, 0.34) and not materials.feel_of(made, 1).guessed
    made["touchable_stiffness"] = 3.5
    bpy.ops.material.touchable_texture(label="Touch Height")
    assert materials.labelled_node(made, "Touch Height").type == "TEX_IMAGE" and made["touchable_relief"] == 0.001
    with tempfile.TemporaryDirectory() as folder:
        # A program that only writes down what it is asked to play.
        real, played = os.environ["TOUCHABLE"], os.path.join(folder, "played")
        stand_in = os.path.join(folder, "touchable")
        with open(stand_in, "w") as file:
            file.write(f"#!/bin/sh\nif [ \"$1\" = play ]; then cp \"$2\" '{played}'; else exec '{real}' \"$@\"; fi\n")
        os.chmod(stand_in, 0o755)
        os.environ["TOUCHABLE"] = stand_in
        clip = os.path.join(folder, "clip.mkv")
        assert bpy.ops.export_scene.touchable(filepath=clip) == {"FINISHED"}
        assert "3.5" in subprocess.run([real, "info", clip], capture_output=True, text=True).stdout
        assert bpy.ops.touchable.touch_it() == {"FINISHED"}
        for _ in range(600):
            if os.path.exists(played) and os.path.getsize(played) == os.path.getsize(clip):
                break
            time.sleep(0.1)
        assert os.path.getsize(played) == os.path.getsize(clip)
        assert scene.render.image_settings.file_format == "PNG" and made.pass_index == 0 and bpy.data.filepath == ""
        scene.camera = None
        try:
            bpy.ops.export_scene.touchable(filepath=os.path.join(folder, "none.mkv"))
            assert False
        except RuntimeError as told:
            assert "no camera" in str(told)
        assert sorted(os.listdir(folder)) == ["clip.mkv", "played", "touchable"]
        bpy.ops.material.touchable_guess()
        assert "touchable_stiffness" not in made
    blender.unregister()


def check_refusals():
    """Each with its code, in one line, with nothing written."""
    def no_camera(scene):
        scene.camera = None
        return [], 3, "no camera"

    def panorama(scene):
        scene.camera.data.type = "PANO"
        return [], 3, "panorama"

    def orthographic(scene):
        scene.camera.data.type = "ORTHO"
        return [], 3, "orthographic"

    def zoom(scene):
        for frame, focal in ((1, 50), (3, 40)):
            scene.camera.data.lens = focal
            scene.camera.data.keyframe_insert("lens", frame=frame)
        scene.frame_end = 3
        return [], 3, "frame 2"

    def stereo(scene):
        scene.render.use_multiview = True
        return [], 3, "stereo"

    def too_small(scene):
        scene.render.resolution_percentage, scene.render.resolution_x = 1, 100
        return ["--no-colour"], 3, "1x10 pixels"

    def too_large(scene):
        scene.render.resolution_x, scene.render.resolution_y = 16385, 4
        return ["--no-colour"], 3, "16385x4 pixels"

    def nothing_seen(scene):
        scene.camera.rotation_euler = (3.1, 0, 0)
        return ["--no-colour", "--size", "32x32"], 3, "no surface"

    def deep_relief(scene):
        made = bpy.data.materials["Material"]
        made["touchable_relief"] = 8.0
        made.node_tree.nodes.new("ShaderNodeTexNoise").label = "Touch Height"
        return ["--no-colour", "--size", "32x32"], 3, "touchable_relief"

    def nearer(scene):
        return ["--near", "3", "--far", "2"], 2, "--near 3"

    def unknown(scene):
        return ["--colour-sample", "2"], 2, "--colour-sample"

    def no_frames(scene):
        return ["--frames", "9-2"], 2, "9-2"

    def beyond_frames(scene):
        return ["--frames", "1-99999999999999999999"], 2, "1048574"

    def many_frames(scene):
        return ["--frames", "0-1000000"], 2, "1000001 frames"

    def no_layer(scene):
        scene.view_layers[0].use = False
        return [], 3, "no view layer"

    def fast(scene):
        scene.render.fps = 5000
        return ["--frames", "1-2"], 3, "5000 frames a second"

    def tiny(scene):
        return ["--size", "3x4"], 2, "4 to 16384"

    def all_hidden(scene):
        return ["--no-colour", "--size", "32x32", "--near", "1000"], 3, "--near"

    def no_program(scene):
        return ["--touchable", "/nowhere/touchable"], 2, "/nowhere/touchable"

    def writes_nothing(scene):
        return ["--no-colour", "--size", "32x32", "--frames", "1", "--touchable", "/bin/true"], 1, "wrote no clip"

    def there_already(scene):
        open("out.mkv", "w").write("mine")
        return ["--touchable", "/bin/true"], 2, "--overwrite"

    def no_numpy(scene):
        del sys.modules["blender.job"]
        sys.modules["numpy"] = None
        return [], 4, "module numpy"

    for case in (no_camera, panorama, orthographic, zoom, stereo, too_small, too_large, nothing_seen, deep_relief, nearer, unknown, no_frames, beyond_frames, many_frames,
                 writes_nothing, no_layer, fast, tiny, all_hidden, no_program, there_already, no_numpy):
        scene = fresh()
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            words, code, why = case(scene)
            before = os.listdir(folder)
            sys.argv = ["blender", "--", "out.mkv", *words]
            with open("../" + os.path.basename(folder) + ".err", "w+") as told:
                stderr, sys.stderr = sys.stderr, told
                try:
                    ended = export.main()
                finally:
                    sys.stderr = stderr
                told.seek(0)
                lines = told.read().splitlines()
            os.remove(told.name)
            assert os.listdir(folder) == before, (case.__name__, os.listdir(folder))
            assert ended == code and len(lines) == 1 and why in lines[0] and lines[0].startswith("touchable: "), (case.__name__, ended, lines)
            os.chdir(HERE)


def main():
    for name in os.environ["CHECKS"].split():
        try:
            globals()[f"check_{name}"]()
        except BaseException:
            traceback.print_exc()  # Blender says it on standard output
            raise
        print(f"checked {name}", file=sys.stderr, flush=True)


main()
