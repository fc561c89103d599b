# SPDX-License-Identifier: Apache-2.0
"""Make the three example environments: HDR latitude-longitude maps, half-float EXR.

    blender -b --factory-startup --python-exit-code 1 --python assets/make_environments.py -- OUT_DIR

Linear Rec.709 radiance. Y up, the subject faces +Z. Column and direction:
u = 1/2 + atan2(z, x) / (2 pi), v from the top = acos(y) / pi. The middle of the
picture is +X, and light on the subject's face comes from u = 0.75.
"""
import os
import sys

import bpy
import numpy as np

WIDTH_PX, HEIGHT_PX = 512, 256
SUPERSAMPLE = 3
MEAN_RADIANCE = 0.7


def directions():
    """Unit vectors at the centres of the supersampled texels, shape (H, W, 3)."""
    w, h = WIDTH_PX * SUPERSAMPLE, HEIGHT_PX * SUPERSAMPLE
    azimuth = ((np.arange(w) + 0.5) / w - 0.5) * 2 * np.pi
    polar = (np.arange(h) + 0.5) / h * np.pi
    sin = np.sin(polar)[:, None]
    return np.stack([sin * np.cos(azimuth), np.repeat(np.cos(polar)[:, None], w, 1), sin * np.sin(azimuth)], -1)


def towards(azimuth_deg, elevation_deg):
    """Direction: azimuth 0 is the front (+Z), positive to the subject's left (+X)."""
    a, e = np.radians(azimuth_deg), np.radians(elevation_deg)
    return np.array([np.sin(a) * np.cos(e), np.sin(e), np.cos(a) * np.cos(e)])


def smoothstep(low, high, x):
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def waves(d, scale, seed, octaves=4):
    """Smooth random pattern on the sphere: plane waves of random direction."""
    rng = np.random.RandomState(seed)
    total = np.zeros(d.shape[:2])
    for octave in range(octaves):
        for _ in range(7):
            axis = rng.standard_normal(3)
            axis *= scale * 2 ** octave / np.linalg.norm(axis)
            total += np.sin(d @ axis + rng.uniform(0, 6.3)) * 0.38 / 1.7 ** octave
    return total


def soft_box(d, azimuth_deg, elevation_deg, width_deg, height_deg, soft_deg=1.5):
    """Coverage of a rectangular lamp that faces the subject, brighter in its middle."""
    n = towards(azimuth_deg, elevation_deg)
    right = np.cross([0, 1, 0], n)
    right /= np.linalg.norm(right)
    depth = d @ n
    with np.errstate(divide="ignore", invalid="ignore"):
        x = np.degrees(np.arctan2(d @ right, depth))
        y = np.degrees(np.arctan2(d @ np.cross(n, right), depth))
    cover = smoothstep(soft_deg, -soft_deg, np.abs(x) - width_deg / 2)
    cover *= smoothstep(soft_deg, -soft_deg, np.abs(y) - height_deg / 2)
    return cover * (depth > 0) * (1 - 0.35 * np.clip((x / width_deg) ** 2 + (y / height_deg) ** 2, 0, 1) * 2)


def studio(d):
    """Large key from the front left, weaker fill, two rim strips, grey room with a floor."""
    up = d[..., 1]
    room = 0.055 + 0.03 * up + 0.012 * waves(d, 2.0, 5)
    colour = room[..., None] * np.array([1.0, 0.98, 0.95])
    floor = smoothstep(0.02, -0.05, up) * (0.10 + 0.22 * smoothstep(-0.1, -0.9, up))
    colour = colour * (1 - smoothstep(0.02, -0.05, up))[..., None] + floor[..., None] * np.array([1.0, 0.96, 0.90])
    lamps = [((38, 32, 42, 34), 15, (1.0, 0.95, 0.88)), ((-48, 12, 30, 52), 3.4, (0.88, 0.95, 1.0)),
             ((142, 18, 12, 62), 11, (0.95, 0.98, 1.0)), ((-135, 22, 12, 62), 8, (1.0, 0.93, 0.84)),
             ((5, 78, 46, 30), 4, (1.0, 1.0, 1.0))]
    for place, level, tint in lamps:
        cover = soft_box(d, *place)[..., None]
        colour = colour * (1 - cover) + cover * level * np.array(tint)
    # stands and a back drop edge, so that mirrors have something to show
    stand = (np.abs(np.degrees(np.arctan2(d[..., 0], d[..., 2])) - 38) < 0.7) & (up < 0.35) & (up > -0.5)
    return np.where(stand[..., None], 0.015, colour)


def sunset(d):
    """Low warm sun in front to the right, glowing horizon, blue zenith, dry ground."""
    up, sun = d[..., 1], towards(-32, 13)
    cosine = np.clip(d @ sun, -1, 1)
    height = np.clip(up, 0, 1)
    glow = np.exp(-height * 5.5)[..., None]
    near = (0.5 + 0.5 * cosine)[..., None] ** 3
    sky = np.array([0.13, 0.22, 0.42]) * (0.75 + 0.5 * height[..., None])
    sky = sky * (1 - glow) + glow * (np.array([0.95, 0.42, 0.18]) * near + np.array([0.30, 0.24, 0.30]) * (1 - near))
    sky += np.array([1.9, 0.95, 0.40]) * (np.exp((cosine - 1) * 22))[..., None]
    cloud = smoothstep(0.1, 0.9, waves(d * [1, 3.2, 1], 3.0, 8)) * smoothstep(0.02, 0.2, up) * smoothstep(0.9, 0.4, up)
    lit = np.array([1.25, 0.60, 0.34]) * (0.25 + near) + np.array([0.10, 0.09, 0.12])
    sky = sky * (1 - 0.65 * cloud[..., None]) + 0.65 * cloud[..., None] * lit
    azimuth = np.arctan2(d[..., 0], d[..., 2])
    hills = 0.035 + 0.022 * np.sin(azimuth * 3 + 1) + 0.012 * np.sin(azimuth * 11) + 0.006 * np.sin(azimuth * 29)
    ridge = smoothstep(-0.004, 0.004, hills - up)[..., None]
    sky = sky * (1 - ridge) + ridge * (np.array([0.09, 0.065, 0.06]) + 0.12 * near * np.array([1, 0.55, 0.3]))
    ground = np.array([0.24, 0.165, 0.105]) * (1 + 0.25 * waves(d / np.maximum(-up, 0.08)[..., None], 1.6, 9))[..., None]
    below = smoothstep(0.0, -0.03, up)[..., None]
    colour = sky * (1 - below) + ground * below
    disc = smoothstep(np.cos(np.radians(1.55)), np.cos(np.radians(1.15)), cosine)[..., None]
    return colour + disc * np.array([820.0, 460.0, 210.0])


def overcast_street(d):
    """Bright cloud over a street that runs from front to back between house fronts."""
    up = d[..., 1]
    front = towards(12, 48)
    sky = (1.15 + 0.55 * up + 1.6 * np.exp((d @ front - 1) * 5) + 0.16 * waves(d * [1, 2, 1], 2.6, 14))
    colour = sky[..., None] * np.array([0.95, 1.0, 1.07])
    # house fronts are planes at x = +-8 m; camera height 1.5 m
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = 8.0 / np.maximum(np.abs(d[..., 0]), 1e-4)
    y, z = 1.5 + d[..., 1] * reach, d[..., 2] * reach
    side = (d[..., 0] > 0).astype(int)
    house = np.floor(z / 9.0).astype(int) + 40 * side
    rng = np.random.RandomState(31)
    tall = rng.uniform(7.5, 13.5, 400)[house % 400]
    paint = np.array([0.36, 0.31, 0.25]) * rng.uniform(0.45, 1.25, (400, 1)) * rng.uniform(0.82, 1.15, (400, 3))
    wall = paint[house % 400] * (0.55 + 0.05 * np.clip(y, 0, 12))[..., None]
    wall *= (1 + 0.10 * waves(np.stack([y, z, side * 9.0], -1), 1.1, 17))[..., None]
    pane = (np.abs(z % 3.0 - 1.5) < 0.62) & (np.abs(y % 3.1 - 1.9) < 0.85)
    glass = np.array([0.16, 0.19, 0.23]) * (0.5 + 0.12 * y)[..., None]
    wall = np.where(pane[..., None], glass, wall)
    far = np.exp(-np.abs(z) / 70.0)[..., None]
    wall = wall * far + np.array([0.70, 0.74, 0.80]) * (1 - far)
    is_wall = (y < tall) & (y > 0) & (reach < 300)
    colour = np.where(is_wall[..., None], wall, colour)
    drop = 1.5 / np.maximum(-up, 1e-3)
    gx, gz = d[..., 0] * drop, d[..., 2] * drop
    asphalt = np.array([0.20, 0.20, 0.205]) * (1 + 0.12 * waves(np.stack([gx, gz * 0.6, gx * 0], -1), 1.3, 19))[..., None]
    kerb = np.where((np.abs(gx) > 4.2)[..., None], np.array([0.34, 0.33, 0.315]), asphalt)
    mark = (np.abs(gx - 2.6) < 0.08) & (gz % 6 < 3)
    kerb = np.where(mark[..., None], 0.55, kerb)
    return np.where(((up < 0) & (np.abs(gx) < 8))[..., None], kerb, colour)


def write_exr(path, radiance):
    """Half-float, ZIP. Blender keeps rows from the bottom."""
    height, width = radiance.shape[:2]
    image = bpy.data.images.new("environment", width, height, float_buffer=True)
    image.colorspace_settings.name = "Linear"
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :3] = radiance[::-1]
    image.pixels.foreach_set(rgba.ravel())
    settings = bpy.context.scene.render.image_settings
    settings.file_format, settings.color_mode = "OPEN_EXR", "RGB"
    settings.color_depth, settings.exr_codec = "16", "ZIP"
    image.save_render(path, scene=bpy.context.scene)


def main():
    out_dir = sys.argv[sys.argv.index("--") + 1]
    os.makedirs(out_dir, exist_ok=True)
    d = directions()
    weight = np.sin((np.arange(HEIGHT_PX) + 0.5) / HEIGHT_PX * np.pi)[:, None, None]
    weight = weight / (weight.sum() * WIDTH_PX)
    for name, make in (("studio", studio), ("sunset", sunset), ("overcast_street", overcast_street)):
        fine = np.maximum(make(d), 0.002)
        radiance = fine.reshape(HEIGHT_PX, SUPERSAMPLE, WIDTH_PX, SUPERSAMPLE, 3).mean((1, 3))
        radiance *= MEAN_RADIANCE / (radiance * weight).sum((0, 1)).mean()
        face = np.clip(directions()[1::SUPERSAMPLE, 1::SUPERSAMPLE, 2], 0, None)
        light = (radiance * weight * face[..., None]).sum((0, 1)) * 4
        write_exr(os.path.join(out_dir, name + ".exr"), radiance)
        print("%s: mean radiance %.2f, peak %.0f, irradiance/pi on the face %s" % (
            name, (radiance * weight).sum((0, 1)).mean(), radiance.max(), np.round(light, 2)), flush=True)


main()
