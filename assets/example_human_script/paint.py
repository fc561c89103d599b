# SPDX-License-Identifier: Apache-2.0
"""Diffuse colours as functions of the position in space, so charts have no visible seams."""
import numpy as np

from . import body, clothes
from .body import EYE, mirrored, natural
from .fields import F32, fbm, gauss, interp, noise, smoothstep


def rgb(*values):
    return np.array(values, F32)


def mix(a, b, t):
    t = np.clip(np.asarray(t, F32), 0, 1)[:, None]
    return a * (1 - t) + b * t


def stitches(distance, position, offset_cm=0.0, pitch_cm=0.45):
    """1 on a dashed thread that runs `offset_cm` beside a seam."""
    line = gauss((np.abs(distance) - offset_cm) / 0.07)
    return line * smoothstep(-0.5, 0.0, np.sin(position * (2 * np.pi / pitch_cm)))


# ---- skin -----------------------------------------------------------------

def skin(s):
    p, part = s.p, s.part
    q = mirrored(natural(p))
    head = part == clothes.SKIN_HEAD
    colour = np.tile(rgb(0.775, 0.585, 0.485), (len(p), 1))
    tone = fbm(p, 0.35, 3, 101)
    colour = colour + tone[:, None] * rgb(0.018, 0.022, 0.020)
    colour = mix(colour, rgb(0.72, 0.44, 0.37), 0.55 * _blush(p, q, part) + 0.07 * np.clip(noise(p, 1.6, 102), 0, 1))
    face = head & (q[:, 2] > 0)
    colour[face] = _face(p[face], q[face], colour[face])
    hands = ~head
    colour[hands] = _hands(p[hands], part[hands], colour[hands])
    pores = fbm(p, 3.4, 2, 103)
    colour = colour * (1 + 0.045 * pores[:, None])
    freckle = smoothstep(0.62, 0.95, noise(p, 2.1, 104)) * 0.28
    colour = mix(colour, rgb(0.56, 0.38, 0.29), freckle)
    shade = 0.60 + 0.40 * np.clip(s.ao, 0, 1)
    return mix(colour * rgb(0.86, 0.70, 0.66), colour, shade)


def _blush(p, q, part):
    cheeks = gauss((q[:, 0] - 4.4) / 2.2) * gauss((q[:, 1] - 161.3) / 1.9) * (q[:, 2] > 3)
    nose = gauss(q[:, 0] / 1.6) * gauss((q[:, 1] - 160.5) / 1.4) * (q[:, 2] > 10)
    ears = smoothstep(7.2, 8.2, q[:, 0]) * (part == clothes.SKIN_HEAD) * (q[:, 1] > 157)
    neck = 0.35 * (part == clothes.SKIN_HEAD) * smoothstep(152, 147, q[:, 1])
    return 0.75 * cheeks + 0.8 * nose + 0.75 * ears + neck


def _face(p, q, colour):
    lids = gauss((q[:, 0] - 3.1) / 1.9) * gauss((q[:, 1] - 163.7) / 1.3)
    colour = mix(colour, rgb(0.60, 0.41, 0.36), 0.42 * lids)
    # beard shadow beyond the edge of the beard and on the upper lip
    near = smoothstep(-1.5, 0.15, body.beard_line(q)) * (q[:, 1] < 164)
    hairs = smoothstep(0.1, 0.7, noise(p * rgb(1, 0.6, 1), 8.0, 111) + 0.15)
    colour = mix(colour, rgb(0.36, 0.27, 0.22), near * (0.25 + 0.34 * hairs))
    roots = smoothstep(-1.0, 0.1, body.hair_line(q)) * (q[:, 1] > 160)
    root_hairs = smoothstep(0.0, 0.6, body.strands(p, 34, 0.35, 112))
    colour = mix(colour, rgb(0.22, 0.15, 0.11), roots * (0.12 + 0.6 * root_hairs))
    return _eyes(p, q, _brows(p, q, _mouth(p, q, colour)))


def _mouth(p, q, colour):
    share, dy = body.lip_coordinates(q)
    taper = np.sqrt(np.clip(1 - (share / 1.02) ** 2, 0, 1))
    upper = smoothstep(0.80, 0.66, dy / (taper + 1e-3) + 0.10 * gauss((share - 0.16) / 0.13) * -1)
    lower = smoothstep(-1.02, -0.86, dy / (taper + 1e-3))
    lip = np.where(dy > 0, upper, lower) * (taper > 0.02) * (q[:, 2] > 7)
    wrinkle = noise(p, (3.5, 0.5, 1.0), 121)
    tint = rgb(0.640, 0.385, 0.355) * (1 + 0.10 * wrinkle[:, None]) * np.where(dy > 0, 0.92, 1.03)[:, None]
    colour = mix(colour, tint, 0.85 * lip)
    slit = gauss(dy / 0.10) * (share < 1.06) * (q[:, 2] > 7)
    colour = mix(colour, rgb(0.24, 0.11, 0.10), 0.85 * slit)
    nostril = gauss((q[:, 0] - 0.62) / 0.36) * gauss((q[:, 1] - 159.35) / 0.26) * (q[:, 2] > 10.4)
    return mix(colour, rgb(0.24, 0.12, 0.10), 0.9 * nostril)


def _brows(p, q, colour):
    away = q[:, 1] - body.brow_line(q[:, 0])
    half = interp(q[:, 0], (0.8, 1.5, 3.0, 4.8, 6.0), (0.25, 0.50, 0.50, 0.30, 0.08))
    # hairs lean outward and up
    lean = (q[:, 0] * 0.75 - q[:, 1] * 0.65)
    hairs = noise(np.stack([lean * 5.5, (q[:, 0] + q[:, 1]) * 0.8, np.sign(p[:, 0]) * 3], 1).astype(F32), 1.0, 131)
    cover = smoothstep(1.25, 0.45, np.abs(away) / half) * smoothstep(0.75, 1.5, q[:, 0]) * smoothstep(6.1, 5.2, q[:, 0])
    return mix(colour, rgb(0.19, 0.13, 0.095), cover * np.clip(0.74 + 0.45 * hairs, 0.3, 0.95) * (q[:, 2] > 4))


def _eyes(p, q, colour):
    gap = body.eye_aperture(q)
    near = (np.abs(q[:, 0] - EYE[0]) < 2.6) & (np.abs(q[:, 1] - EYE[1]) < 1.8) & (q[:, 2] > 6.5)
    x, y = q[:, 0] - EYE[0] + 0.04, q[:, 1] - EYE[1] - 0.06
    r = np.sqrt(x * x + y * y)
    spoke = noise(np.stack([np.arctan2(y, x) * 5, r * 1.2, np.sign(p[:, 0])], 1).astype(F32), 1.0, 141)
    white = np.tile(rgb(0.84, 0.80, 0.765), (len(p), 1))
    white = mix(white, rgb(0.74, 0.50, 0.45), 0.5 * smoothstep(0.75, 1.5, np.abs(x)) + 0.15 * np.clip(noise(p, 4, 142), 0, 1))
    iris = rgb(0.30, 0.33, 0.30) * (1 + 0.45 * spoke[:, None])
    iris = mix(iris, rgb(0.42, 0.33, 0.20), smoothstep(0.42, 0.24, r))
    iris = mix(iris, rgb(0.09, 0.09, 0.09), smoothstep(0.47, 0.62, r))
    eye = mix(white, iris, smoothstep(0.68, 0.60, r))
    eye = mix(eye, rgb(0.03, 0.025, 0.025), smoothstep(0.28, 0.23, r))
    lid_shadow = smoothstep(0.05, 0.75, q[:, 1] - EYE[1])
    eye = eye * (1 - 0.45 * lid_shadow[:, None])
    colour = mix(colour, eye, smoothstep(0.03, -0.05, gap) * near)
    upper = y > -0.05 + 0.1 * np.abs(x)
    lash = gauss((gap - 0.02) / np.where(upper, 0.13, 0.07)) * np.where(upper, 0.92, 0.40)
    colour = mix(colour, rgb(0.13, 0.085, 0.07), lash * near)
    crease = gauss((gap - 0.46) / 0.10) * upper * near
    return mix(colour, rgb(0.50, 0.32, 0.27), 0.55 * crease)


def _hands(p, part, colour):
    for side, number in ((1, clothes.SKIN_HAND_L), (-1, clothes.SKIN_HAND_R)):
        on = part == number
        h = body.hand_frame(p[on], side)
        back = smoothstep(0.5, -0.6, h[:, 2])
        local = colour[on]
        local = mix(local, rgb(0.80, 0.56, 0.48), 0.45 * (1 - back))
        for u, w, length, radius, spread in body.FINGERS:
            a = np.radians(spread)
            for share, width in ((0.0, 0.7), (0.46, 0.5), (0.76, 0.4)):
                c = np.array([u + np.cos(a) * length * share, w + np.sin(a) * length * share])
                r = np.linalg.norm((h[:, :2] - c) / np.array([width, 0.8]), axis=1)
                local = mix(local, rgb(0.68, 0.41, 0.35), 0.50 * gauss(r) * back)
        local = _nails(h, side, local)
        vein = gauss(noise(h, (0.16, 0.42, 0.2), 151) / 0.07) * back * smoothstep(9, 6, h[:, 0])
        local = mix(local, rgb(0.58, 0.47, 0.45), 0.16 * vein)
        lines = gauss(noise(h, (0.22, 0.22, 0.1), 152) / 0.05) * (1 - back)
        local = mix(local, rgb(0.62, 0.38, 0.33), 0.25 * lines)
        tips = smoothstep(14.5, 16.5, h[:, 0])
        colour[on] = mix(local, rgb(0.76, 0.48, 0.42), 0.4 * tips)
    return colour


def _nails(h, side, colour):
    tips = [body.finger_joints(u, w, length, spread, curl)[2:]
            for (u, w, length, _, spread), curl in zip(body.FINGERS, body.finger_curls(side))]
    tips.append([np.array((8.0, 6.2, 1.9)), np.array((10.1, 6.7, 2.1))])
    for number, (a, b) in enumerate(tips):
        forward = (b - a) / np.linalg.norm(b - a)
        out = np.array([0, 0.5, -1.0]) if number == 4 else np.array([0, 0, -1.0])
        out = out - forward * (out @ forward)
        out /= np.linalg.norm(out)
        q = h - b - 0.10 * forward
        u, w, n = q @ forward, q @ np.cross(out, forward), q @ out
        shape = ((np.abs(u) / 0.62) ** 3 + (np.abs(w) / 0.50) ** 3) ** (1 / 3)
        on = (n > 0.15) & (n < 1.2)
        colour = mix(colour, rgb(0.56, 0.36, 0.31), 0.55 * gauss((shape - 1.05) / 0.14) * on)
        colour = mix(colour, rgb(0.83, 0.62, 0.56), 0.9 * smoothstep(1.02, 0.92, shape) * on)
        colour = mix(colour, rgb(0.87, 0.80, 0.73), 0.7 * smoothstep(0.38, 0.48, u) * (shape < 1) * on)
    return colour


# ---- hair -----------------------------------------------------------------

def hair(s):
    p = s.p
    scalp = s.part == clothes.SCALP
    lock = body.strands(p, 5.0, 0.05, 201)
    strand = body.strands(p, 22, 0.10, 202)
    fine = body.strands(p, 48, 0.18, 203)
    short = fbm(p * rgb(1, 0.40, 1), 5.0, 2, 204)
    level = np.where(scalp, 0.42 + 0.20 * lock + 0.38 * strand + 0.30 * fine, 0.38 + 0.34 * short)
    colour = mix(np.tile(rgb(0.105, 0.070, 0.052), (len(p), 1)), rgb(0.40, 0.275, 0.185), level)
    q = mirrored(natural(p))
    grey = smoothstep(167, 161, p[:, 1]) * np.where(scalp, 1, 0.4)
    colour = mix(colour, rgb(0.50, 0.45, 0.41), 0.4 * grey * smoothstep(0.25, 0.7, np.where(scalp, fine, short)))
    edge = np.where(scalp, smoothstep(1.1, 0.1, body.hair_line(q)), smoothstep(0.45, 0.02, body.beard_line(q)))
    through = edge * np.clip(0.55 - 0.9 * np.where(scalp, fine, short), 0, 0.85)
    colour = mix(colour, rgb(0.62, 0.45, 0.37), through)
    return colour * (0.55 + 0.45 * np.clip(s.ao, 0, 1) + 0.25 * s.ridge)[:, None]


# ---- cloth ----------------------------------------------------------------

def tee(s):
    p, q = s.p, mirrored(s.p)
    y = p[:, 1] + 0.25 * noise(p, 0.08, 301)
    stripe = smoothstep(-0.08, 0.08, np.abs(((y - 103.2) / 2.7) % 1.0 - 0.5) - 0.32)
    angle = np.arctan2(p[:, 0], p[:, 2] + 3)
    wale = np.sin(angle * 2 * np.pi * 52) * 0.5
    course = np.sin(p[:, 1] * 2 * np.pi * 3.6 + 1.6 * np.abs(np.sin(angle * np.pi * 52)))
    colour = mix(np.tile(rgb(0.79, 0.765, 0.71), (len(p), 1)), rgb(0.125, 0.165, 0.27), stripe)
    rib = smoothstep(-2.1, -1.95, clothes.neck_line(q))
    colour = mix(colour, rgb(0.14, 0.18, 0.285), rib)
    knit = 0.05 * wale + 0.045 * course
    knit = np.where(rib > 0.5, 0.16 * np.sin(angle * 2 * np.pi * 24), knit)
    fuzz = fbm(p, 2.5, 3, 302)
    colour = colour * (1 + knit + 0.05 * fuzz)[:, None] + 0.012 * fuzz[:, None]
    return colour * (0.66 + 0.34 * np.clip(s.ao, 0, 1))[:, None]


def jeans(s):
    p, q = s.p, mirrored(s.p)
    y = p[:, 1]
    front = smoothstep(-3, 6, p[:, 2])
    worn = 0.75 * front * gauss((y - 70) / 15) * gauss((q[:, 0] - 10.2) / 4.6)
    worn += 0.55 * front * gauss((y - 50) / 6) + 0.6 * (1 - front) * gauss((y - 88) / 8) * gauss((q[:, 0] - 8) / 6)
    worn += 0.9 * s.ridge + 0.30 * fbm(p, 0.09, 3, 311)
    slub = noise(p, (2.6, 0.22, 2.6), 312)
    twill = np.sin((y * 1.0 + np.arctan2(p[:, 0] - 10 * np.sign(p[:, 0]), p[:, 2]) * 6.5) * 2 * np.pi * 2.6)
    colour = mix(np.tile(rgb(0.135, 0.180, 0.295), (len(p), 1)), rgb(0.46, 0.54, 0.65), 0.12 + 0.62 * worn)
    colour = colour * (1 + 0.10 * slub + 0.07 * twill + 0.06 * fbm(p, 3.0, 2, 313))[:, None]
    seam = clothes.jeans_seam(q)
    thread = stitches(seam, y + q[:, 0], 0.42) + stitches(clothes.front_pocket(q), q[:, 0] + y, 0.4)
    pocket = clothes.back_pocket(q)
    thread += stitches(pocket + 0.45, q[:, 0] + y) + stitches(pocket + 0.95, q[:, 0] + y)
    arc = np.where(pocket < -1, y - 90.5 + 0.9 * np.cos((q[:, 0] - 8.2) * 0.9), 9)
    thread += stitches(arc, q[:, 0]) + stitches(y - 9.1, np.arctan2(p[:, 2], q[:, 0] - 11.6) * 7)
    fly = np.where((p[:, 2] > 0) & (y > 88), p[:, 0] - 3.6 * np.sqrt(np.clip((y - 87.5) / 3.5, 0.02, 1)), 9)
    thread += stitches(fly, y) + stitches(fly + 0.4, y)
    colour = colour * (1 - 0.35 * gauss(seam / 0.22) - 0.25 * gauss(clothes.front_pocket(q) / 0.25))[:, None]
    pucker = gauss(seam / 0.8) * np.clip(noise(np.stack([y * 0.9, seam, q[:, 0] * 0.2], 1).astype(F32), 1.0, 314), 0, 1)
    colour = mix(colour, rgb(0.52, 0.60, 0.69), 0.45 * pucker)
    colour = mix(colour, rgb(0.66, 0.44, 0.22), 0.85 * thread)
    rivet = np.minimum.reduce([np.hypot(q[:, 0] - 9.0, y - 98.0), np.hypot(q[:, 0] - 15.6, y - 92.7)])
    colour = mix(colour, rgb(0.52, 0.36, 0.22), smoothstep(0.42, 0.34, rivet) * (p[:, 2] > 0))
    return colour * (0.62 + 0.38 * np.clip(s.ao, 0, 1))[:, None]


# ---- leather --------------------------------------------------------------

def _grain(p, per_cm, seed):
    """Pebbles with dark furrows between them."""
    furrow = np.minimum(np.abs(noise(p, per_cm, seed)), np.abs(noise(p, per_cm * 1.3, seed + 1)))
    return smoothstep(0.0, 0.16, furrow)


def jacket(s):
    p, q = s.p, mirrored(s.p)
    grain = _grain(p, 2.2, 401)
    cloud = fbm(p, 0.12, 3, 403)
    colour = np.tile(rgb(0.205, 0.125, 0.088), (len(p), 1)) * (1 + 0.22 * cloud)[:, None]
    worn = np.clip(1.5 * s.ridge + 0.30 * cloud, 0, 1)
    colour = mix(colour, rgb(0.42, 0.275, 0.185), 0.75 * worn * (0.55 + 0.45 * grain))
    colour = colour * (0.80 + 0.22 * grain + 0.05 * fbm(p, 4.5, 1, 404))[:, None]
    seam = clothes.jacket_seam(q)
    run = p[:, 1] + 0.7 * q[:, 0] + 0.5 * p[:, 2]
    colour = colour * (1 - 0.55 * gauss(seam / 0.16))[:, None]
    colour = mix(colour, rgb(0.40, 0.29, 0.20), 0.6 * stitches(seam, run, 0.42, 0.5))
    zip_pocket = clothes.jacket_pocket(q)
    edge = np.abs(np.abs(p[:, 0] + 0.03 * (p[:, 1] - 130)) - clothes.opening(q) - 0.15)
    edge = np.where((p[:, 2] > 3) & (p[:, 1] < 121), edge, 9)
    teeth = smoothstep(-0.3, 0.3, np.sin(p[:, 1] * 2 * np.pi / 0.5))
    for line in (zip_pocket, edge):
        colour = mix(colour, rgb(0.07, 0.06, 0.055), smoothstep(0.50, 0.40, line))
        colour = mix(colour, rgb(0.60, 0.58, 0.54), smoothstep(0.24, 0.16, line) * (0.25 + 0.7 * teeth))
    return colour * (0.62 + 0.38 * np.clip(s.ao, 0, 1))[:, None]


def belt(s):
    p, q = s.p, mirrored(s.p)
    from_middle = np.abs(p[:, 1] - 101.1)
    colour = np.tile(rgb(0.335, 0.195, 0.110), (len(p), 1)) * (0.85 + 0.2 * _grain(p, 2.6, 411))[:, None]
    colour = colour * (1 + 0.15 * fbm(p, 0.3, 3, 412))[:, None]
    colour = mix(colour, rgb(0.16, 0.09, 0.055), smoothstep(1.45, 1.75, from_middle) * 0.8)
    colour = mix(colour, rgb(0.62, 0.47, 0.30), stitches(from_middle - 1.25, p[:, 0] + p[:, 2]) * 0.7)
    off = np.abs(p[:, 0] - 0.4)
    frame = (off < 3.0) & (from_middle < 2.4) & ~((off < 1.85) & (from_middle < 1.3)) & (p[:, 2] > 4)
    pin = (np.abs(p[:, 1] - 101.1) < 0.2) & (p[:, 0] > -2.2) & (p[:, 0] < 2.4) & (p[:, 2] > 4)
    metal = rgb(0.46, 0.39, 0.28) * (1 + 0.18 * noise(p, 1.5, 413))[:, None]
    colour = np.where((frame | pin)[:, None], metal, colour)
    return colour * (0.6 + 0.4 * np.clip(s.ao, 0, 1))[:, None]


def boots(s):
    p, b = s.p, clothes.boot_frame(s.p)
    grain = _grain(p, 3.0, 421)
    scuff = smoothstep(0.1, 0.7, fbm(p, 0.4, 4, 422)) * (0.35 + 0.65 * smoothstep(9, 17, b[:, 2]))
    colour = np.tile(rgb(0.315, 0.180, 0.105), (len(p), 1)) * (0.85 + 0.16 * grain)[:, None]
    colour = colour * (1 + 0.18 * fbm(p, 0.15, 3, 423))[:, None]
    colour = mix(colour, rgb(0.155, 0.085, 0.055), 0.55 * smoothstep(14.5, 18, b[:, 2]))
    colour = mix(colour, rgb(0.46, 0.31, 0.21), 0.28 * scuff + 0.5 * s.ridge)
    seam = clothes.boot_seam(b)
    colour = colour * (1 - 0.5 * gauss(seam / 0.16))[:, None]
    colour = mix(colour, rgb(0.55, 0.42, 0.28), 0.8 * stitches(seam, b[:, 0] + b[:, 2] + b[:, 1], 0.38, 0.4))
    lace = np.zeros(len(p), F32)
    for z in (3.6, 5.3, 7.0, 8.7, 10.4):
        for tilt in (0.7, -0.7):
            line = np.abs(b[:, 2] - z - tilt * b[:, 0] / 1.9)
            lace = np.maximum(lace, smoothstep(0.36, 0.26, line) * (np.abs(b[:, 0]) < 2.15) * (b[:, 1] > 4))
    woven = 0.8 + 0.2 * np.sin((b[:, 0] + b[:, 2]) * 2 * np.pi * 2.5)
    colour = mix(colour, rgb(0.50, 0.42, 0.30) * woven[:, None], lace)
    sole_top = np.where(b[:, 2] < -0.5, 3.35, 2.35)
    sole = rgb(0.125, 0.100, 0.085) * (1 + 0.25 * fbm(p, 0.7, 3, 424))[:, None]
    colour = mix(colour, sole, smoothstep(0.05, -0.05, p[:, 1] - sole_top))
    welt = gauss((p[:, 1] - sole_top + 0.25) / 0.09) * smoothstep(-0.4, 0.2, np.sin((b[:, 0] + b[:, 2]) * 12))
    colour = mix(colour, rgb(0.58, 0.48, 0.34), 0.7 * welt * (s.normal[:, 1] > -0.5))
    dust = smoothstep(5, 0.5, p[:, 1]) * np.clip(0.3 + fbm(p, 0.5, 3, 425), 0, 1)
    colour = mix(colour, rgb(0.42, 0.37, 0.31), 0.35 * dust)
    return colour * (0.6 + 0.4 * np.clip(s.ao, 0, 1))[:, None]


PAINTERS = {clothes.SKIN_HEAD: skin, clothes.SKIN_HAND_L: skin, clothes.SKIN_HAND_R: skin, clothes.SCALP: hair,
            clothes.BEARD: hair, clothes.TEE: tee, clothes.JACKET: jacket, clothes.JEANS: jeans,
            clothes.BELT: belt, clothes.BOOTS: boots}
