"""Imports a .glb into Blender and exports it again: blender_roundtrip.py IN OUT [extras]."""
import sys

import bpy

source, target, *options = sys.argv[1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_scene.gltf(filepath=source)
bpy.ops.export_scene.gltf(
    filepath=target, export_format="GLB", export_attributes=True, export_extras="extras" in options
)
