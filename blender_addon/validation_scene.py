# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds a scene that `openhumanbrdf validate` wrote and renders it in Cycles, once for each seed.

    blender -b -noaudio --factory-startup -t N --python-exit-code 1 --python validation_scene.py -- scene.json N
    VENV/bin/python validation_scene.py -- scene.json N      (with the module bpy in place of Blender)

N: threads, 0 for all.
Input: scene.json and the raw little-endian arrays and images that it names, beside it (see
renderer/validation/cycles_scene.h). Lengths are metres, axes are Blender's.
Output, in the folder `output` of scene.json: pass_<i>_seed_<k>_box_<j>.exr (whole frame, float RGBA, linear
Rec. 709, premultiplied; 0 outside the box) and report.json (versions, every setting as asked for last and as read
back after the last render, times).
Prints `progress <done> <total>` lines. Exits 1 with a Python traceback if anything is wrong.

The scene's model says which Blender it is for: v1, 3.4 (Principled v1); v2, 4.5 (Principled v2). Each holds for
that version alone: names of sockets and of sampling patterns differ (see docs/commands/validate.md).
"""
import array
import json
import os
import sys
import time

import bpy
from mathutils import Matrix

FORMAT = "openhumanbrdf validation scene 1"
VERSIONS = {"v1": (3, 4), "v2": (4, 5)}
IS_V2 = bpy.app.version >= (4, 0)
LINEAR = "Linear Rec.709" if IS_V2 else "Linear"
LEAST_SUBSURFACE = 1e-5
# Of Blender 3.4. "tables", its default, are 256 patterns, the same whatever the seed, so that their error stays in the
# mean over any number of seeds: up to 256 samples it is that of 65536 random points.
SAMPLING_PATTERNS = {"tables": "PROGRESSIVE_MULTI_JITTER", "scrambled": "SOBOL"}


class Settings:
    """Sets properties and remembers the last value, so that they can be read back after the render."""

    def __init__(self):
        self.entries = {}

    def set(self, name, owner, attribute, value):
        setattr(owner, attribute, value)
        self.entries[name + "." + attribute] = (owner, attribute, value)

    def set_all(self, name, owner, values):
        for attribute, value in values.items():
            self.set(name, owner, attribute, value)

    def read_back(self):
        """Each setting as asked for and as it is now, and whether they agree."""
        rows = []
        for name, (owner, attribute, wanted) in self.entries.items():
            found = plain(getattr(owner, attribute))
            wanted = plain(wanted)
            rows.append({"name": name, "wanted": wanted, "found": found, "same": equal(wanted, found)})
        return rows


def plain(value):
    """A property's value as JSON can hold it."""
    if isinstance(value, (bool, int, float, str)):
        return value
    return [plain(part) for part in value]


def equal(a, b):
    if isinstance(a, list) and isinstance(b, list):
        return len(a) == len(b) and all(equal(x, y) for x, y in zip(a, b))
    if isinstance(a, float) or isinstance(b, float):
        return abs(a - b) <= 1e-6 * max(1.0, abs(a))   # properties are single precision
    return a == b


def read_array(folder, name, kind):
    values = array.array(kind)
    with open(os.path.join(folder, name), "rb") as file:
        values.frombytes(file.read())
    if sys.byteorder == "big":
        values.byteswap()
    return values


# Mesh ---------------------------------------------------------------------------------------------------

def build_mesh(folder, description):
    """Triangles with smooth shading on shared vertices: the normals are Blender's own."""
    positions = read_array(folder, description["positions"], "f")
    triangles = read_array(folder, description["triangles"], "i")
    count = len(triangles) // 3
    mesh = bpy.data.meshes.new("model")
    mesh.vertices.add(len(positions) // 3)
    mesh.vertices.foreach_set("co", positions)
    mesh.loops.add(len(triangles))
    mesh.loops.foreach_set("vertex_index", triangles)
    mesh.polygons.add(count)
    mesh.polygons.foreach_set("loop_start", array.array("i", range(0, 3 * count, 3)))
    mesh.polygons.foreach_set("loop_total", array.array("i", [3]) * count)
    mesh.polygons.foreach_set("use_smooth", array.array("b", [1]) * count)
    mesh.polygons.foreach_set("material_index", read_array(folder, description["sets"], "i"))
    mesh.uv_layers.new(name="uv").data.foreach_set("uv", read_array(folder, description["corner_uvs"], "f"))
    mesh.update(calc_edges=True)
    return mesh


def add_object(settings, mesh, turn):
    thing = bpy.data.objects.new("model", mesh)
    bpy.context.scene.collection.objects.link(thing)
    settings.set("object", thing, "rotation_euler", (0.0, 0.0, turn))
    if IS_V2:   # those of object.cycles are still there and do nothing
        settings.set_all("object", thing, {
            "shadow_terminator_shading_offset": 0.0, "shadow_terminator_geometry_offset": 0.0})
    else:
        settings.set("mesh", mesh, "use_auto_smooth", False)
        settings.set_all("object.cycles", thing.cycles, {
            "shadow_terminator_offset": 0.0, "shadow_terminator_geometry_offset": 0.0})
    return thing


# Material -----------------------------------------------------------------------------------------------

def load_image(settings, path, colorspace):
    image = bpy.data.images.load(path)
    name = "image " + os.path.basename(path)
    settings.set(name, image.colorspace_settings, "name", colorspace)
    settings.set(name, image, "alpha_mode", "NONE")
    return image


def image_node(settings, tree, path, colorspace):
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = load_image(settings, path, colorspace)
    settings.set_all("texture " + os.path.basename(path), node, {
        "interpolation": "Linear", "extension": "REPEAT", "projection": "FLAT"})
    uv = tree.nodes.get("uv")
    tree.links.new(uv.outputs["UV"], node.inputs["Vector"])
    return node.outputs["Color"]


def math_node(tree, operation, a, b):
    """A Math node of two inputs, each a socket or a number; its output socket."""
    node = tree.nodes.new("ShaderNodeMath")
    node.operation = operation
    for socket, value in zip(node.inputs, (a, b)):
        if isinstance(value, (int, float)):
            socket.default_value = value
        else:
            tree.links.new(value, socket)
    return node.outputs["Value"]


def srgb_to_linear(tree, encoded):
    """The piecewise sRGB curve (IEC 61966-2-1) as Math nodes."""
    low = math_node(tree, "DIVIDE", encoded, 12.92)
    base = math_node(tree, "DIVIDE", math_node(tree, "ADD", encoded, 0.055), 1.055)
    high = math_node(tree, "POWER", base, 2.4)
    above = math_node(tree, "GREATER_THAN", encoded, 0.04045)
    step = math_node(tree, "MULTIPLY", above, math_node(tree, "SUBTRACT", high, low))
    return math_node(tree, "ADD", low, step)


def normal_socket(settings, tree, path):
    """A signed tangent-space normal map: n / 2 + 1 / 2 is what the Normal Map node expects."""
    encode = tree.nodes.new("ShaderNodeVectorMath")
    encode.operation = "MULTIPLY_ADD"
    encode.inputs[1].default_value = encode.inputs[2].default_value = (0.5, 0.5, 0.5)
    tree.links.new(image_node(settings, tree, path, "Non-Color"), encode.inputs[0])
    node = tree.nodes.new("ShaderNodeNormalMap")
    settings.set_all("normal map", node, {"space": "TANGENT", "uv_map": "uv"})
    node.inputs["Strength"].default_value = 1.0
    tree.links.new(encode.outputs["Vector"], node.inputs["Color"])
    return node.outputs["Normal"]


def link_subsurface(settings, tree, principled, path, scale, albedo):
    """The map scales the radius (1, .2, .1) cm. v1: Subsurface does, which is no blend weight there. v2: Scale does,
    and the weight is 1 where there is any."""
    weight = math_node(tree, "MULTIPLY", image_node(settings, tree, path, "Non-Color"), scale)
    if IS_V2:
        tree.links.new(weight, principled.inputs["Subsurface Scale"])
        is_some = math_node(tree, "GREATER_THAN", weight, LEAST_SUBSURFACE)
        tree.links.new(is_some, principled.inputs["Subsurface Weight"])
    else:
        tree.links.new(weight, principled.inputs["Subsurface"])
        tree.links.new(albedo, principled.inputs["Subsurface Color"])
    settings.set("Subsurface Radius", principled.inputs["Subsurface Radius"], "default_value",
                 (0.01, 0.002, 0.001))
    settings.set("Subsurface IOR", principled.inputs["Subsurface IOR"], "default_value", 1.4)
    settings.set("Subsurface Anisotropy", principled.inputs["Subsurface Anisotropy"], "default_value", 0.0)


def principled_node(settings, tree):
    node = tree.nodes.get("Principled BSDF")
    if IS_V2:
        choices = {"distribution": "MULTI_GGX", "subsurface_method": "RANDOM_WALK_SKIN"}
        zeros = ("Subsurface Weight", "Metallic", "Diffuse Roughness", "Anisotropic", "Sheen Weight", "Coat Weight",
                 "Transmission Weight", "Emission Strength", "Thin Film Thickness")
        settings.set("Principled BSDF IOR", node.inputs["IOR"], "default_value", 1.5)
        settings.set("Principled BSDF Specular Tint", node.inputs["Specular Tint"], "default_value",
                     (1.0, 1.0, 1.0, 1.0))
    else:
        choices = {"distribution": "GGX", "subsurface_method": "RANDOM_WALK"}
        zeros = ("Subsurface", "Metallic", "Specular Tint", "Anisotropic", "Sheen", "Clearcoat", "Transmission",
                 "Emission Strength")
    settings.set_all("Principled BSDF", node, choices)
    for name in zeros:
        settings.set("Principled BSDF " + name, node.inputs[name], "default_value", 0.0)
    settings.set("Principled BSDF Alpha", node.inputs["Alpha"], "default_value", 1.0)
    return node


def build_material(settings, folder, texture_set, sss_scale):
    """Principled v1 of one texture set. Maps that are null are left out (opaque, flat, no subsurface)."""
    material = bpy.data.materials.new(texture_set["name"])
    material.use_nodes = True
    if IS_V2:
        settings.set("material", material, "displacement_method", "BUMP")
        settings.set("material.cycles", material.cycles, "use_bump_map_correction", True)
    else:
        settings.set("material.cycles", material.cycles, "displacement_method", "BUMP")
    tree = material.node_tree
    principled = principled_node(settings, tree)
    uv = tree.nodes.new("ShaderNodeUVMap")
    uv.name = uv.uv_map = "uv"

    def linked(name, socket, colorspace="Non-Color", convert=lambda value: value):
        if texture_set[name]:
            path = os.path.join(folder, texture_set[name])
            output = convert(image_node(settings, tree, path, colorspace))
            tree.links.new(output, principled.inputs[socket])
            return output
        return None

    albedo = linked("albedo", "Base Color", LINEAR)
    linked("roughness", "Roughness")
    linked("specular", "Specular IOR Level" if IS_V2 else "Specular",
           convert=lambda value: math_node(tree, "DIVIDE", srgb_to_linear(tree, value), 0.08))
    linked("alpha", "Alpha")
    if texture_set["normal"]:
        path = os.path.join(folder, texture_set["normal"])
        tree.links.new(normal_socket(settings, tree, path), principled.inputs["Normal"])
    if texture_set["sss"] and sss_scale > 0:
        path = os.path.join(folder, texture_set["sss"])
        link_subsurface(settings, tree, principled, path, sss_scale, albedo)
    return material


# World, lights, camera ----------------------------------------------------------------------------------

def build_world(settings, folder, environment):
    """The environment as it is; black if there is none."""
    world = bpy.data.worlds.new("world")
    bpy.context.scene.world = world
    world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    settings.set("Background", background.inputs["Strength"], "default_value", 1.0)
    if environment is None:
        settings.set("Background", background.inputs["Color"], "default_value", (0.0, 0.0, 0.0, 1.0))
        return
    node = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
    node.image = load_image(settings, os.path.join(folder, environment["file"]), LINEAR)
    settings.set_all("environment", node, {"interpolation": "Linear", "projection": "EQUIRECTANGULAR"})
    world.node_tree.links.new(node.outputs["Color"], background.inputs["Color"])
    settings.set_all("world.cycles", world.cycles, {
        "sampling_method": "MANUAL", "sample_map_resolution": max(4, min(8192, 4 * environment["width_px"]))})


def add_point_light(settings, number, point):
    """Radiant intensity in W/sr by channel; Cycles wants the power of an isotropic light, 4 pi times that."""
    light = bpy.data.lights.new("point%d" % number, "POINT")
    strength = max(point["intensity"]) or 1.0
    settings.set_all(light.name, light, {
        "energy": 4.0 * 3.14159265358979 * strength, "shadow_soft_size": 0.0, "use_nodes": False,
        "color": tuple(value / strength for value in point["intensity"])})
    if IS_V2:
        settings.set_all(light.name, light, {"use_soft_falloff": False, "normalize": True, "exposure": 0.0,
                                             "use_temperature": False})
    thing = bpy.data.objects.new(light.name, light)
    thing.location = point["position"]
    bpy.context.scene.collection.objects.link(thing)


def add_camera(settings, camera):
    """Looks along +Y with Z up."""
    data = bpy.data.cameras.new("camera")
    settings.set_all("camera", data, {
        "type": "PERSP", "sensor_fit": "AUTO", "sensor_width": camera["sensor_mm"], "lens": camera["lens_mm"],
        "shift_x": 0.0, "shift_y": 0.0, "clip_start": camera["clip_start"], "clip_end": camera["clip_end"]})
    settings.set("camera.dof", data.dof, "use_dof", False)
    thing = bpy.data.objects.new("camera", data)
    x, y, z = camera["location"]
    thing.matrix_world = Matrix(((1, 0, 0, x), (0, 0, -1, y), (0, 1, 0, z), (0, 0, 0, 1)))
    bpy.context.scene.collection.objects.link(thing)
    bpy.context.scene.camera = thing


# Settings of the render ---------------------------------------------------------------------------------

def set_cycles(settings, scene, description):
    """Nothing that biases: no clamp, no filter of glossy paths, no adaptive stop, no denoiser."""
    bounces = description["bounces"]
    settings.set("scene.render", scene.render, "engine", "CYCLES")
    settings.set_all("scene.cycles", scene.cycles, {
        "device": "CPU", "feature_set": "SUPPORTED", "sample_offset": 0,
        "use_adaptive_sampling": False, "use_denoising": False, "time_limit": 0.0,
        "sample_clamp_indirect": 0.0, "sample_clamp_direct": 0.0, "blur_glossy": 0.0,
        "caustics_reflective": True, "caustics_refractive": True, "light_sampling_threshold": 0.0,
        "max_bounces": bounces, "diffuse_bounces": bounces, "glossy_bounces": bounces,
        "transmission_bounces": bounces, "volume_bounces": bounces, "transparent_max_bounces": 256,
        "min_light_bounces": 0, "min_transparent_bounces": 0, "use_fast_gi": False, "use_auto_tile": False,
        "auto_scrambling_distance": False, "scrambling_distance": 1.0, "use_animated_seed": False,
        "pixel_filter_type": "BOX", "film_exposure": 1.0,
        "film_transparent_glass": False})
    if not IS_V2:
        settings.set("scene.cycles", scene.cycles, "sampling_pattern", SAMPLING_PATTERNS[description["numbers"]])


def set_later_options(settings, scene, threads):
    """What Blender 4.5 has besides."""
    settings.set_all("scene.cycles", scene.cycles, {
        "use_light_tree": False, "use_guiding": False, "use_sample_subset": False,
        "direct_light_sampling_type": "MULTIPLE_IMPORTANCE_SAMPLING", "sampling_pattern": "TABULATED_SOBOL"})
    settings.set("scene.view_settings", scene.view_settings, "use_white_balance", False)
    if bpy.app.module and threads > 0:   # Blender itself is told by -t
        settings.set_all("scene.render", scene.render, {"threads_mode": "FIXED", "threads": threads})


def set_output(settings, scene, size_px):
    settings.set_all("scene.render", scene.render, {
        "resolution_x": size_px, "resolution_y": size_px, "resolution_percentage": 100,
        "pixel_aspect_x": 1.0, "pixel_aspect_y": 1.0, "film_transparent": True,
        "use_compositing": False, "use_sequencer": False, "use_motion_blur": False, "use_simplify": False,
        "use_persistent_data": True, "use_multiview": False, "use_stamp": False, "use_overwrite": True})
    settings.set_all("scene.render.image_settings", scene.render.image_settings, {
        "file_format": "OPEN_EXR", "color_mode": "RGBA", "color_depth": "32", "exr_codec": "ZIP"})
    settings.set_all("scene.view_settings", scene.view_settings, {
        "view_transform": "Standard", "look": "None", "exposure": 0.0, "gamma": 1.0, "use_curve_mapping": False})


def clear_factory_scene():
    if IS_V2:
        bpy.ops.wm.read_factory_settings()   # the module has read the user's
    for objects in (bpy.data.objects, bpy.data.materials, bpy.data.meshes, bpy.data.lights, bpy.data.cameras,
                    bpy.data.worlds):
        for item in list(objects):
            objects.remove(item)


def build_scene(folder, description, threads):
    """The whole scene; returns the settings to read back."""
    clear_factory_scene()
    settings = Settings()
    scene = bpy.context.scene
    set_cycles(settings, scene, description)
    if IS_V2:
        set_later_options(settings, scene, threads)
    set_output(settings, scene, description["size_px"])
    mesh = build_mesh(folder, description["mesh"])
    for texture_set in description["texture_sets"]:
        mesh.materials.append(build_material(settings, folder, texture_set, description["sss_scale"]))
    add_object(settings, mesh, description["turn"])
    build_world(settings, folder, description["environment"])
    for number, point in enumerate(description["points"]):
        add_point_light(settings, number, point)
    add_camera(settings, description["camera"])
    return settings


# Rendering ----------------------------------------------------------------------------------------------

def timed(action):
    """Wall and processor seconds of the action."""
    wall, processor = time.perf_counter(), time.process_time()
    action()
    return time.perf_counter() - wall, time.process_time() - processor


def render_image(settings, spp, seed, path):
    scene = bpy.context.scene
    settings.set("scene.cycles", scene.cycles, "samples", spp)
    settings.set("scene.cycles", scene.cycles, "seed", seed)
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)


def warm_up(settings, path):
    """Loads meshes and images and builds the trees; persistent data keeps them for the seeds."""
    render_image(settings, 1, 1, path)
    os.remove(path)


def set_box(settings, box, size_px):
    """Renders only the pixels x0 <= x < x1, y0 <= y < y1 (row 0 at the top) of the frame; all if there is no box."""
    x0, y0, x1, y1 = box or (0, 0, size_px, size_px)
    render = bpy.context.scene.render
    inside = 0.01   # of a pixel: neither rounding nor cutting moves the edge
    settings.set_all("scene.render", render, {
        "use_border": box is not None, "use_crop_to_border": False,
        "border_min_x": (x0 + inside) / size_px, "border_max_x": min(1.0, (x1 + inside) / size_px),
        "border_min_y": (size_px - y1 + inside) / size_px,
        "border_max_y": min(1.0, (size_px - y0 + inside) / size_px)})


def set_adaptive(settings, threshold):
    """Stops pixels whose estimated noise is below the threshold; 0: never, as all that must be unbiased wants."""
    settings.set("scene.cycles", bpy.context.scene.cycles, "use_adaptive_sampling", threshold > 0)
    if threshold > 0:
        settings.set("scene.cycles", bpy.context.scene.cycles, "adaptive_threshold", threshold)


def render_seed(settings, spp, seed, boxes, size_px, output, name):
    """One image, of as many files as there are boxes."""
    row = {"seed": seed, "spp": spp, "files": [], "wall_s": 0.0, "cpu_s": 0.0}
    for number, box in enumerate(boxes or [None]):
        set_box(settings, box, size_px)
        file = "%s_box_%d.exr" % (name, number)
        wall, processor = timed(lambda: render_image(settings, spp, seed, os.path.join(output, file)))
        row["files"].append(file)
        row["wall_s"] += wall
        row["cpu_s"] += processor
    return row


def render_passes(settings, description, output):
    passes = []
    total = sum(len(work["seeds"]) for work in description["passes"])
    done = 0
    print("progress %d %d" % (done, total), flush=True)
    for number, work in enumerate(description["passes"]):
        rows = []
        set_adaptive(settings, work["adaptive_threshold"])
        for k, seed in enumerate(work["seeds"]):
            rows.append(render_seed(settings, work["spp"], seed, work["boxes"], description["size_px"], output,
                                    "pass_%d_seed_%d" % (number, k)))
            done += 1
            print("progress %d %d" % (done, total), flush=True)
        passes.append(rows)
    return passes


def check(path, description):
    if description["format"] != FORMAT:
        raise ValueError("%s: format '%s' is not '%s'" % (path, description["format"], FORMAT))
    if bpy.app.version[:2] != VERSIONS[description["model"]]:
        raise ValueError("%s: is for Blender %d.%d, this is %s" % (
            path, *VERSIONS[description["model"]], bpy.app.version_string))


def run(path, threads):
    folder = os.path.dirname(os.path.abspath(path))
    with open(path, encoding="utf-8") as file:
        description = json.load(file)
    check(path, description)
    output = os.path.join(folder, description["output"])
    os.makedirs(output, exist_ok=True)
    built = []
    build_s, _ = timed(lambda: built.append(build_scene(folder, description, threads)))
    settings = built[0]
    load_s, load_cpu_s = timed(lambda: warm_up(settings, os.path.join(output, "warm_up.exr")))
    passes = render_passes(settings, description, output)
    report = {"versions": {"blender": bpy.app.version_string}, "build_s": build_s, "load_s": load_s,
              "load_cpu_s": load_cpu_s, "passes": passes, "settings": settings.read_back()}
    with open(os.path.join(output, "report.json"), "w", encoding="utf-8") as file:
        json.dump(report, file, indent=1)


if __name__ == "__main__":
    arguments = sys.argv[sys.argv.index("--") + 1:]
    run(arguments[0], int(arguments[1]))
    if getattr(bpy.app, "module", False):
        sys.stdout.flush()
        os._exit(0)   # some modules crash while Python ends, after the work
