# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything that differs between Blender 3.4 and 5.x, and nothing else. Callers say what they mean.

Features are looked for by name; the version number is asked only where one name means different things.
"""
import bpy

NEW_PRINCIPLED = (4, 0)   # from here: energy-conserving layers, Subsurface Scale


# Principled BSDF ----------------------------------------------------------------------------------------

#: what a socket means -> its names, newest first (docs/blender.md, "Blender's generations")
PRINCIPLED_SOCKETS = {
    "base": ("Base Color",),
    "roughness": ("Roughness",),
    "specular": ("Specular IOR Level", "Specular"),      # F0 / 0.08 at IOR 1.5
    "ior": ("IOR",),
    "normal": ("Normal",),
    "subsurface_scale": ("Subsurface Scale", "Subsurface"),   # up to 3.6 "Subsurface" scales the radius
    "subsurface_weight": ("Subsurface Weight",),
    "subsurface_color": ("Subsurface Color",),           # up to 3.6 mixed with the base by Subsurface
    "subsurface_radius": ("Subsurface Radius",),
}


def principled_socket(node, meaning):
    """The input of that meaning, or None where this Blender has no such thing."""
    for name in PRINCIPLED_SOCKETS[meaning]:
        socket = node.inputs.get(name)
        if socket is not None:
            return socket
    return None


def prepare_principled(node):
    """Settings that make maps mean the same in every generation; the maps are linked by the caller."""
    node.distribution = "GGX"
    principled_socket(node, "ior").default_value = 1.5   # before 4.0 without effect; after, level = F0 / 0.08
    weight = principled_socket(node, "subsurface_weight")
    if weight is not None:   # 4.0+: the map is a scale; linked to the weight it would blur a full radius
        weight.default_value = 1.0


#: method -> its identifiers in (up to 3.6, 4.0 to 5.1, 5.2 and later): RANDOM_WALK names three algorithms
SUBSURFACE_METHODS = {
    "burley": ("BURLEY", "BURLEY", "BURLEY"),
    "random_walk_fixed": ("RANDOM_WALK_FIXED_RADIUS", "RANDOM_WALK", "RANDOM_WALK_LEGACY"),
    "random_walk_skin": ("RANDOM_WALK", "RANDOM_WALK_SKIN", "RANDOM_WALK_SKIN"),
}


def subsurface_identifier(method, version):
    generation = 0 if version < (4, 0) else 1 if version < (5, 2) else 2
    return SUBSURFACE_METHODS[method][generation]


def set_subsurface_method(node, method):
    """Sets the method by what it does; keeps Blender's own default where this version has it no more."""
    try:
        node.subsurface_method = subsurface_identifier(method, bpy.app.version[:2])
    except TypeError:
        node.subsurface_method = "BURLEY"


def generation():
    """The Principled BSDF that this Blender renders: "principled_v1" or "principled_v2"."""
    return "principled_v2" if bpy.app.version[:2] >= NEW_PRINCIPLED else "principled_v1"


def validated_model():
    """The model of reflection of `openhumanbrdf validate` that equals the Cycles of this Blender, or ""."""
    return {(3, 4): "v1", (4, 5): "v2"}.get(bpy.app.version[:2], "")


# Node trees ---------------------------------------------------------------------------------------------

def node_tree_of(owner):
    """The node tree of a material or world, made where it is missing."""
    if owner.node_tree is None or not getattr(owner, "use_nodes", True):
        owner.use_nodes = True
    return owner.node_tree


def new_group_socket(tree, name, in_out, kind):
    """An input ("INPUT") or output of a node group. kind: "NodeSocketFloat", "NodeSocketColor"."""
    if hasattr(tree, "interface"):
        return tree.interface.new_socket(name, in_out=in_out, socket_type=kind)
    return (tree.inputs if in_out == "INPUT" else tree.outputs).new(kind, name)


def set_socket_range(socket, low, high, default):
    """Slider limits and default of a float socket of a node group."""
    socket.min_value, socket.max_value, socket.default_value = low, high, default


def socket(sockets, identifier):
    """A socket by identifier: names are translated and change between versions."""
    for candidate in sockets:
        if candidate.identifier == identifier:
            return candidate
    raise KeyError(identifier)



# Materials, meshes, worlds ------------------------------------------------------------------------------

def set_cut_out(material):
    """Alpha as a cut-out in the viewport engine (Cycles needs nothing)."""
    if hasattr(material, "surface_render_method"):
        material.surface_render_method = "DITHERED"
    elif hasattr(material, "blend_method"):
        material.blend_method = "HASHED"
        material.shadow_method = "HASHED"


def set_vertex_normals(mesh, normals):
    """Smooth shading by the given normals, one (x, y, z) a vertex."""
    if hasattr(mesh, "use_auto_smooth"):   # up to 4.0 custom normals count only with it
        mesh.use_auto_smooth = True
    mesh.normals_split_custom_set_from_vertices(normals)


# Rendering ----------------------------------------------------------------------------------------------

def set_cycles(scene, samples, seed):
    """Cycles on the CPU with a fixed seed and no denoiser (builds without one raise if it is on)."""
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples = samples
    scene.cycles.seed = seed
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.use_denoising = False


def can_denoise():
    """Whether this Blender was built with a denoiser for any device (Debian's was not)."""
    try:
        import _cycles
    except ImportError:
        return False
    return bool(getattr(_cycles, "with_openimagedenoise", False))


def render_state(scene):
    """What a user has chosen about rendering: name -> value, in words of Blender's panels."""
    return {"engine": scene.render.engine, "device": scene.cycles.device, "samples": scene.cycles.samples,
            "viewport samples": scene.cycles.preview_samples, "denoiser": scene.cycles.use_denoising,
            "viewport denoiser": scene.cycles.use_preview_denoising,
            "view": scene.view_settings.view_transform, "look": scene.view_settings.look,
            "exposure": scene.view_settings.exposure, "gamma": scene.view_settings.gamma,
            "compositor": has_compositor(scene)}


def set_pixel_filter(scene, kind):
    """"SOFT": Blender's own, 1.5 pixels wide; "BOX": each pixel by itself; "POINT": one point, its centre."""
    scene.cycles.pixel_filter_type = "BOX" if kind == "BOX" else "BLACKMAN_HARRIS"
    scene.cycles.filter_width = 0.01 if kind == "POINT" else 1.5   # a box is always one pixel wide


def set_plain_view(scene):
    """Pictures show sRGB of the linear values: no film curve."""
    scene.display_settings.display_device = "sRGB"
    scene.view_settings.view_transform = "Standard"
    scene.view_settings.look = "None"
    scene.view_settings.exposure = 0
    scene.view_settings.gamma = 1


def set_output(scene, kind):
    """File format "PNG" (16 bits, RGBA) or "OPEN_EXR" (float, RGBA)."""
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):   # 5.0+: which formats there are depends on it
        settings.media_type = "IMAGE"
    settings.file_format = kind
    settings.color_mode = "RGBA"
    settings.color_depth = "16" if kind == "PNG" else "32"
    if kind == "OPEN_EXR":
        settings.exr_codec = "ZIP"


def set_video(scene, container, codec):
    """A film of H.264 or VP9 at high quality."""
    if hasattr(scene.render.image_settings, "media_type"):
        scene.render.image_settings.media_type = "VIDEO"
    scene.render.image_settings.file_format = "FFMPEG"
    scene.render.ffmpeg.format, scene.render.ffmpeg.codec = container, codec
    scene.render.ffmpeg.constant_rate_factor = "HIGH"


def set_shadow_catcher(item):
    item.is_shadow_catcher = True


def straight_keys(owner, path):
    """The keyframes of owner.path are joined by straight lines, whatever the user's preference."""
    data = owner.animation_data
    if hasattr(data.action, "fcurves"):
        curves = data.action.fcurves
    else:   # 5.0+: by layers and slots
        curves = data.action.layers[0].strips[0].channelbag(data.action_slot).fcurves
    for curve in curves:
        if curve.data_path == path:
            for key in curve.keyframe_points:
                key.interpolation = "LINEAR"


def has_compositor(scene):
    """Whether nodes change the picture. From 5.0 `use_nodes` says nothing."""
    if hasattr(scene, "compositing_node_group"):
        return scene.render.use_compositing and scene.compositing_node_group is not None
    return scene.use_nodes


def set_compositor(scene, is_on):
    if hasattr(scene, "compositing_node_group"):
        scene.render.use_compositing = is_on
        if is_on:
            compositor(scene)
    else:
        scene.use_nodes = is_on


def compositor(scene):
    """(tree, the input of what is written), made where there is none."""
    if hasattr(scene, "compositing_node_group"):   # 5.0+
        tree = scene.compositing_node_group
        if tree is None:
            tree = scene.compositing_node_group = bpy.data.node_groups.new("Compositing", "CompositorNodeTree")
        kind = "NodeGroupOutput"
        if not any(n.bl_idname == kind for n in tree.nodes):
            tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    else:
        scene.use_nodes, kind = True, "CompositorNodeComposite"
        tree = scene.node_tree
    output = next((n for n in tree.nodes if n.bl_idname == kind), None) or tree.nodes.new(kind)
    return tree, output.inputs[0]


def composite_over(scene, image, name):
    """The picture that is written is the rendered one over an image, stretched to it. Other nodes stay before it."""
    remove_composite(scene, name)
    set_compositor(scene, True)
    tree, target = compositor(scene)
    if target.links:
        source = target.links[0].from_socket
    else:
        source = tree.nodes.new("CompositorNodeRLayers").outputs["Image"]
    plate, scale, over = (tree.nodes.new("CompositorNode" + kind) for kind in ("Image", "Scale", "AlphaOver"))
    for k, node in enumerate((plate, scale, over)):
        node.name = node.label = "%s %d" % (name, k)
        node.location = (target.node.location.x - 600 + 200 * k, target.node.location.y - 250)
    plate.image = image
    if hasattr(scale, "space"):
        scale.space = "RENDER_SIZE"
        scale.frame_method = "STRETCH"
    else:   # 5.0+: menus are inputs
        scale.inputs["Type"].default_value = "Render Size"
    colors = [s for s in over.inputs if s.type == "RGBA"]
    tree.links.new(plate.outputs["Image"], scale.inputs[0])
    tree.links.new(scale.outputs[0], colors[0])
    tree.links.new(source, colors[1])
    tree.links.new(over.outputs[0], target)


def remove_composite(scene, name):
    """Takes the nodes of composite_over away: what they were over is written."""
    tree = getattr(scene, "compositing_node_group", None) or getattr(scene, "node_tree", None)
    over = tree.nodes.get("%s 2" % name) if tree is not None else None
    if over is None:
        return
    colors = [s for s in over.inputs if s.type == "RGBA"]
    source = colors[1].links[0].from_socket if colors[1].links else None
    for link in list(over.outputs[0].links):
        if source is not None:
            tree.links.new(source, link.to_socket)
    for k in range(3):
        tree.nodes.remove(tree.nodes["%s %d" % (name, k)])


# User interface -----------------------------------------------------------------------------------------

def path_options():
    """Options of a file property: paths relative to the .blend, where that has to be declared (4.5+)."""
    return {"PATH_SUPPORTS_BLEND_RELATIVE"} if bpy.app.version[:2] >= (4, 5) else set()


def draw_progress(layout, share, text):
    """A bar from 0 to 1; share None: words alone. Before 4.0 the bar is of characters."""
    if share is None:
        layout.label(text=text, icon="SORTTIME")
    elif hasattr(layout, "progress"):
        layout.progress(factor=share, text="%.0f %%" % (100 * share))
        layout.label(text=text)
    else:
        done = round(10 * share)
        layout.label(text="\u2588" * done + "\u2591" * (10 - done) + " %.0f %%" % (100 * share))
        layout.label(text=text)


def user_folder(package):
    """Where the add-on may keep files of its own; in 4.2+ an extension's folder."""
    try:
        return bpy.utils.extension_path_user(package, create=True)
    except (AttributeError, ValueError):   # before 4.2, or an add-on that is no extension
        return bpy.utils.user_resource("CONFIG", path="human_material")


def _drawing():
    import gpu   # there is none without a window
    from gpu_extras.batch import batch_for_shader
    try:
        return gpu, gpu.shader.from_builtin("UNIFORM_COLOR"), batch_for_shader   # 4.0+
    except (ValueError, SystemError):
        return gpu, gpu.shader.from_builtin("2D_UNIFORM_COLOR"), batch_for_shader


def draw_line(points, color, width_px):
    """In a region's pixels, from a draw handler."""
    if len(points) < 2:
        return
    gpu, shader, batch_for_shader = _drawing()
    is_flat = shader.name.find("2D") >= 0
    batch = batch_for_shader(shader, "LINE_STRIP", {"pos": [p if is_flat else (*p, 0) for p in points]})
    gpu.state.blend_set("ALPHA")
    gpu.state.line_width_set(width_px)
    shader.bind()
    shader.uniform_float("color", color)
    batch.draw(shader)
    gpu.state.line_width_set(1)
    gpu.state.blend_set("NONE")


def draw_circle(place, radius_px, color):
    from gpu_extras.presets import draw_circle_2d
    draw_circle_2d(place, color, radius_px)
