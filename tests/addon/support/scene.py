"""Helpers of the tests that run inside Blender."""
import atexit
import os
import shutil
import tempfile
import unittest

import bpy
import human_material

from support import maps_folder

from human_material import compat
from human_material.services import environment, material, relief, render
from human_material.services.maps import read_raster


_ROOT = None   # of all folders of this run


def empty_scene():
    """The one scene, with nothing in it."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    return bpy.context.scene


class Registered(unittest.TestCase):
    """Tests with the add-on registered, each in an empty scene."""
    @classmethod
    def setUpClass(cls):
        human_material.register()

    @classmethod
    def tearDownClass(cls):
        human_material.unregister()

    def setUp(self):
        self.scene = empty_scene()


def folder():
    """A new folder, removed when the tests end."""
    global _ROOT
    if _ROOT is None:
        _ROOT = tempfile.mkdtemp(prefix="hm")
        atexit.register(shutil.rmtree, _ROOT, ignore_errors=True)
    return tempfile.mkdtemp(dir=_ROOT)


def remove_folders():
    """What run.py calls where Python ends without its exit handlers."""
    if _ROOT is not None:
        shutil.rmtree(_ROOT, ignore_errors=True)


def import_person(scene, person, changed=None, **options):
    """(object, Maps) of a made-up person. Its pixels are centimetres wide: light scatters wherever the map says."""
    path = os.path.join(folder(), "person")
    maps_folder.write(path, person, changed)
    item, loaded = relief.load_into(scene, path, **options)
    material.set_visible_scattering(relief.material_of(item), 0)
    return item, loaded


def light_up(scene, direction=None, sky=0.0, peak=1000.0, rotation_deg=0.0):
    path = os.path.join(folder(), "light.exr")
    maps_folder.environment(path, direction, sky=sky, peak=peak)
    return environment.set_environment(scene, path, rotation_deg)


def rendered(scene, samples=16, exact=False, box=False):
    """RGB of each pixel, rows from the bottom. exact: rays through each pixel's centre only; box: each pixel by
    itself."""
    render.prepare(scene, samples)
    scene.render.film_transparent = True
    compat.set_pixel_filter(scene, "POINT" if exact else "BOX" if box else "SOFT")
    path = os.path.join(folder(), "picture.exr")
    render.to_file(scene, path)
    return read_raster(path, 3, scene.render.resolution_x, scene.render.resolution_y)


def show(item, output):
    """Makes the relief glow with a node's output: what is rendered is the value itself."""
    tree = relief.material_of(item).node_tree
    glow = tree.nodes.new("ShaderNodeEmission")
    tree.links.new(output, glow.inputs["Color"])
    end = next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL")
    tree.links.new(glow.outputs[0], end.inputs["Surface"])


def principled(item):
    return relief.material_of(item).node_tree.nodes[material.PRINCIPLED]


def source_of(socket):
    """The output that feeds an input; of an albedo, before it is balanced for this Blender."""
    output = socket.links[0].from_socket
    return source_of(output.node.inputs["Base"]) if output.node.name == material.BALANCE else output


def socket_of(item, meaning):
    return compat.principled_socket(principled(item), meaning)


def inside(loaded, margin=2):
    """Pixels at least so far inside the mask and the frame."""
    width, height = loaded.size
    return [y * width + x for y in range(margin, height - margin) for x in range(margin, width - margin)
            if all(loaded.mask[(y + v) * width + x + u] > 0
                   for v in (-margin, 0, margin) for u in (-margin, 0, margin))]


def front_faces(item):
    """Of a relief: without the guessed back."""
    return [face for face in item.data.polygons if face.material_index == 0]


def front_vertex_count(item):
    return 1 + max(v for face in front_faces(item) for v in face.vertices)


def data_counts():
    """How many data blocks of each kind the file holds."""
    return {kind: len(getattr(bpy.data, kind)) for kind in (
        "objects", "meshes", "materials", "images", "node_groups", "worlds", "cameras", "lights", "scenes")}
