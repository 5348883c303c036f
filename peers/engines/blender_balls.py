"""A ball in Blender's Cycles, seen from each direction, lit by what the exported program does.

blender_balls.py FOLDER OUT.json
"""
import importlib.util
import json
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

AXES = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
DIAGONALS = [tuple(np.array((x, y, z)) / np.sqrt(3)) for x in (1, -1) for y in (1, -1) for z in (1, -1)]
# Paths in each of 16 pixels.
PATHS = {"matte": 4096, "mirror": 16}
NODES = {"matte": "ShaderNodeBsdfDiffuse", "mirror": "ShaderNodeBsdfGlossy"}


def prepared():
    """An empty scene that is rendered as linear light."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.use_denoising = False
    scene.cycles.use_adaptive_sampling = False
    scene.render.resolution_x = scene.render.resolution_y = 4
    scene.view_settings.view_transform = "Raw"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    return scene


def ball_and_camera(scene):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=256, ring_count=128, radius=1)
    ball = bpy.context.object
    bpy.ops.object.shade_smooth()
    lens = bpy.data.cameras.new("camera")
    lens.type, lens.ortho_scale = "ORTHO", 0.01
    camera = bpy.data.objects.new("camera", lens)
    scene.collection.objects.link(camera)
    scene.camera = camera
    return ball, camera


def material(name):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes.clear()
    surface, out = nodes.new(NODES[name]), nodes.new("ShaderNodeOutputMaterial")
    surface.inputs["Color"].default_value = (1, 1, 1, 1)
    surface.inputs["Roughness"].default_value = 0
    links.new(surface.outputs[0], out.inputs[0])
    return made


def picture(scene, camera, d, path):
    # Blender puts (x, y, z) of glTF at (x, -z, y).
    v = Vector((d[0], -d[2], d[1]))
    camera.location = 3 * v
    camera.rotation_euler = (-v).to_track_quat("-Z", "Y").to_euler()
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(path)
    image.colorspace_settings.name = "Non-Color"
    pixels = np.array(image.pixels[:]).reshape(-1, 4)[:, :3].mean(0).tolist()
    bpy.data.images.remove(image)
    return pixels


def add_sky(scene, folder):
    """What the program of the folder does, or Blender's importer of its stage."""
    stage = folder / "sky.usda"
    if stage.exists():
        # The importer makes the nodes of a dome in the world that there is.
        scene.world = bpy.data.worlds.new("world")
        scene.world.use_nodes = True
        bpy.ops.wm.usd_import(filepath=str(stage))
        return
    spec = importlib.util.spec_from_file_location("sky", folder / "sky.py")
    program = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(program)
    program.add_sky(scene, str(folder))


def main():
    folder, out = map(Path, sys.argv[1:])
    scene = prepared()
    add_sky(scene, folder)
    ball, camera = ball_and_camera(scene)
    values = {}
    with tempfile.TemporaryDirectory() as place:
        for name in NODES:
            ball.data.materials.clear()
            ball.data.materials.append(material(name))
            scene.cycles.samples = PATHS[name]
            values[name] = [picture(scene, camera, d, f"{place}/p.exr") for d in [*AXES, *DIAGONALS]]
    out.write_text(json.dumps({"version": bpy.app.version_string, "values": values}))


if __name__ == "__main__":
    main()
