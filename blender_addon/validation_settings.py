# SPDX-License-Identifier: GPL-3.0-or-later
"""What `openhumanbrdf validate` asks of Cycles and of the file that it writes, and whether Blender kept it.

The names of properties and of sampling patterns are those of Blender 3.4, or of 4.5 where IS_V2 is true.
"""
import bpy

IS_V2 = bpy.app.version >= (4, 0)
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
