# SPDX-License-Identifier: Apache-2.0
"""Clothes of the example human as signed-distance fields, and the list of all parts."""
import numpy as np

from . import body
from .body import ELBOW, SHOULDER, WRIST, mirrored, natural
from .fields import (F32, along, axial_distance, capsule, ellipsoid, gauss, in_box, interp, loft,
                     noise, smax, smin, smoothstep)

TORSO_TABLE = [  # y, half width, front z, back z
    (84, 17.0, 9.8, -11.5), (92, 17.6, 10.6, -12.4), (100, 16.4, 10.6, -10.8), (106, 15.8, 10.9, -9.6),
    (114, 15.9, 11.0, -9.2), (122, 17.0, 11.4, -10.6), (130, 18.2, 11.9, -12.0), (137, 18.6, 11.2, -12.4),
    (142, 17.4, 8.8, -11.6), (146, 13.5, 5.6, -10.0), (149, 9.0, 3.6, -8.8)]
JACKET_TABLE = [
    (95.5, 18.9, 12.2, -14.0), (98, 18.8, 12.4, -14.0), (102, 18.3, 12.5, -13.0), (109, 17.9, 12.9, -12.0),
    (116, 18.3, 13.2, -12.0), (124, 19.4, 13.7, -12.8), (132, 20.1, 13.7, -13.8), (138, 19.6, 12.6, -13.8),
    (142, 17.6, 10.6, -12.9), (146, 13.2, 7.4, -11.4), (150, 9.2, 4.4, -9.9)]
JEANS_TABLE = [
    (82, 16.6, 9.6, -11.2), (88, 17.5, 10.5, -12.4), (94, 17.4, 10.9, -12.2), (100, 16.8, 10.9, -11.0),
    (103.6, 16.4, 10.9, -10.3)]
HIP = np.array([9.0, 91.0, -0.6], F32)
KNEE = np.array([10.6, 51.0, 0.6], F32)
HEM = np.array([11.7, 6.5, -1.6], F32)
BOOT_ORIGIN = np.array([11.6, 0, -2.0], F32)
BOOT_TURN = np.radians(11.0)


def fold(n, width):
    """Rounded ridges along the zero lines of a stretched noise: how cloth buckles."""
    return gauss(n / width)


def neck_line(q):
    """Signed height above the round neckline of the tee."""
    return (q[:, 1] - (147.6 - 0.40 * (q[:, 2] + 3.0))) * F32(0.93)


def tee(p):
    q = mirrored(p)
    d = loft(q, TORSO_TABLE, 2.35) - 0.25
    d = smin(d, capsule(q, (4.5, 149.5, -4.2), (16, 142.3, -3.5), 4.6, 3.8), 3.0)
    # chest, and the shirt blousing over the belt
    d = d - 0.7 * gauss((q[:, 0] - 7.5) / 5) * gauss((q[:, 1] - 131.5) / 4.5) * (q[:, 2] > 0)
    d = d - 0.9 * gauss((q[:, 1] - 104.6) / 1.7)
    pull = noise(p * np.array([0.16, 0.05, 0.1], F32) + 0.04 * (p[:, [1]] - 120) * np.tanh(p[:, [0]] / 6), 1.0, 51)
    d = d - 0.55 * fold(pull, 0.16) * smoothstep(140, 122, q[:, 1])
    slack = noise(p, (0.07, 0.22, 0.1), 52)
    d = d - 0.65 * fold(slack, 0.16) * smoothstep(118, 106, q[:, 1])
    rib = smoothstep(-2.1, -1.9, neck_line(q))
    d = d - 0.22 * rib
    # under the jacket the shirt lies closer, so that no fold of it comes through
    d = d + 1.6 * smoothstep(0.8, 3.0, q[:, 0] - opening(q)) * smoothstep(-3, 0, q[:, 2])
    d = smax(d, neck_line(q), 0.25)
    return np.maximum(d, 102.6 - q[:, 1]).astype(F32)


# ---- jacket ---------------------------------------------------------------

def sleeve_coordinates(q):
    """Distance along the sleeve from the shoulder, distance from its axis (mirrored points)."""
    t0, upper_cm = along(q, SHOULDER, ELBOW)
    t1, lower_cm = along(q, ELBOW, WRIST)
    d0 = axial_distance(q, SHOULDER, ELBOW, np.clip(t0, 0, 1))
    d1 = axial_distance(q, ELBOW, WRIST, np.clip(t1, 0, 1))
    reach = np.where(d0 < d1, t0 * upper_cm, upper_cm + t1 * lower_cm)
    return reach.astype(F32), np.minimum(d0, d1), t1 * lower_cm, upper_cm


def _sleeve(p, q):
    reach, _, lower, upper_cm = sleeve_coordinates(q)
    top = capsule(q, SHOULDER, ELBOW, 7.5, 6.2)
    low = capsule(q, ELBOW, WRIST, 6.2, 4.5)
    d = smin(top, low, 1.5)
    # rings that buckle at the elbow and above the cuff, tight in the crook
    tilt = 0.10 * (p[:, 2] + 0.5 * p[:, 1])
    u = np.stack([(reach + tilt) * 0.26, p[:, 2] * 0.075, p[:, 0] * 0.03 + np.sign(p[:, 0]) * 5], 1)
    rings = fold(noise(u.astype(F32), 1.0, 61), 0.27) - 0.45
    crook = 0.55 + 0.45 * smoothstep(-6, 4, q[:, 2] + 1.5)
    amount = 0.82 * gauss((reach - upper_cm) / 8) * crook + 0.50 * gauss((reach - 49) / 5) + 0.45
    d = d - amount * rings * smoothstep(4, 14, reach) * smoothstep(51.5, 49.5, reach)
    d = d - 0.28 * smoothstep(50.4, 50.6, reach) * smoothstep(-1, 1, lower)        # cuff
    return smax(d, lower - 25.4, 0.35)


def sleeve_side(q):
    """Positive on the sleeve's side of the armhole seam."""
    return q[:, 0] - interp(q[:, 1], (95, 122, 127, 131, 138, 144, 152), (60, 30, 22.5, 19.2, 17.2, 17.0, 17.6))


def opening(q):
    """Half width of the open front at each height."""
    return interp(q[:, 1], (95, 108, 120, 132, 142, 150), (8.8, 7.2, 5.6, 5.2, 6.4, 7.4))


def lapel_edge(q):
    top = (q[:, 1] - (147.0 - 0.90 * (q[:, 0] - 7.0))) * F32(0.74)
    outer = (q[:, 0] - interp(q[:, 1], (117, 126, 136, 141), (5.4, 8.8, 13.2, 14.6))) * F32(0.92)
    return np.maximum(top, outer)


_COLLAR = [(0, 152.6, -10.6), (4.8, 152.2, -9.4), (8.2, 150.6, -4.8), (9.0, 148.0, 1.0), (8.3, 143.8, 6.6)]


def collar(q):
    squeeze = np.array([1, 0.36, 1], F32)
    d = None
    for a, b in zip(_COLLAR[:-1], _COLLAR[1:]):
        piece = capsule(q * squeeze, np.array(a) * squeeze, np.array(b) * squeeze, 0.85, 0.8)
        d = piece if d is None else smin(d, piece, 0.4)
    return d


def jacket_seam(q):
    """Distance from the panel seams (mirrored points): yoke, side, princess, armhole, hem band."""
    x, y, z = q[:, 0], q[:, 1], q[:, 2]
    reach, _, lower, _ = sleeve_coordinates(q)
    body_only = sleeve_side(q) < 0
    yoke = np.where((z < 0) & body_only, np.abs(y - 137.0 - 0.02 * x * x), 9)
    yoke_front = np.where((z > 0) & body_only & (lapel_edge(q) > 0.4), np.abs(y - 136.5 - 0.1 * (x - 9)), 9)
    princess = np.where((y < 137) & body_only & (z < 0), np.abs(x - 9.0 - 0.04 * (y - 110)), 9)
    side = np.where((y < 130) & body_only, np.abs(z + 0.6), 9)
    armhole = np.where(y > 124, np.abs(sleeve_side(q)), 9)
    hem = np.where(body_only, np.abs(y - 99.0), 9)
    elbow = np.abs(reach - 33.5) + np.where((reach > 5) & (z < -1), 0, 9)
    return np.minimum.reduce([yoke, yoke_front, princess, side, armhole, hem, elbow]).astype(F32)


def jacket_pocket(q):
    """Distance from the slanted zip pockets on the front."""
    a, b = np.array((10.2, 111.5), F32), np.array((14.6, 120.5), F32)
    t = np.clip(((q[:, :2] - a) @ (b - a)) / ((b - a) @ (b - a)), 0, 1)
    r = np.linalg.norm(q[:, :2] - a - t[:, None] * (b - a), axis=1)
    return np.where(q[:, 2] > 3, r, 9).astype(F32)


def jacket(p):
    q = mirrored(p)
    trunk = loft(q, JACKET_TABLE, 2.4)
    trunk = smin(trunk, capsule(q, (5, 148.6, -4.6), (16.5, 143.0, -3.5), 4.9, 4.8), 3.5)
    drag = noise(p * np.array([0.13, 0.06, 0.1], F32) + 0.05 * (p[:, [1]] - 120) * np.tanh(p[:, [0]] / 6), 1.0, 62)
    sag = noise(p, (0.06, 0.15, 0.06), 63)
    trunk = trunk - 0.75 * (fold(drag, 0.26) - 0.35) * smoothstep(145, 132, q[:, 1]) * smoothstep(97, 101, q[:, 1])
    trunk = trunk - 0.60 * (fold(sag, 0.26) - 0.35) * smoothstep(122, 108, q[:, 1]) * smoothstep(97, 101, q[:, 1])
    trunk = trunk - 0.18 * smoothstep(99.2, 98.8, q[:, 1])
    hole = np.maximum(np.abs(p[:, 0] + 0.03 * (p[:, 1] - 130)) - opening(q), -1.5 - q[:, 2])
    front = smax(trunk, -hole, 0.55)
    flap = smax(smax(trunk - 0.95, lapel_edge(q), 0.35), -hole - 0.25, 0.5)
    front = np.where(q[:, 2] > 0, np.minimum(front, flap), front)
    front = smax(front, 95.8 - q[:, 1], 0.4)
    d = smin(front, _sleeve(p, q), 2.6)
    d = d + 0.20 * gauss(jacket_seam(q) / 0.32) + 0.28 * gauss(jacket_pocket(q) / 0.35)
    d = smin(d, collar(q), 0.35)
    return (d - 0.10 * noise(p, 0.35, 64)).astype(F32)


# ---- trousers and belt ----------------------------------------------------

def leg_coordinate(q):
    """Distance from the leg's axis in x and z, for seams (mirrored points)."""
    x = interp(q[:, 1], (HEM[1], KNEE[1], HIP[1]), (HEM[0], KNEE[0], HIP[0]))
    z = interp(q[:, 1], (HEM[1], KNEE[1], HIP[1]), (HEM[2], KNEE[2], HIP[2]))
    return q[:, 0] - x, q[:, 2] - z


def back_pocket(q):
    """Signed distance of the patch pocket in the plane of the back (mirrored points)."""
    x, y = q[:, 0] - 8.2, q[:, 1] - 90.5
    bottom = -5.6 - y - (4.0 - np.abs(x)) * 0.35
    d = np.maximum(np.maximum(np.abs(x) - 4.4 - 0.04 * y, y - 5.6), bottom)
    return np.where(q[:, 2] < -4, d, 9).astype(F32)


def front_pocket(q):
    """Distance from the curved opening of the front pocket."""
    r = np.sqrt((q[:, 0] - 16.6) ** 2 + ((q[:, 1] - 101) * 0.85) ** 2)
    return np.where((q[:, 2] > 0) & (q[:, 1] < 99), np.abs(r - 8.2), 9).astype(F32)


def jeans_seam(q):
    x, z = leg_coordinate(q)
    side = np.where((x > 0) & (q[:, 1] < 99), np.abs(z + 0.3), 9)
    inner = np.where((x < 0) & (q[:, 1] < 82), np.abs(z + 0.3), 9)
    middle = np.where(q[:, 1] > 80, np.abs(q[:, 0]), 9)
    yoke = np.where((q[:, 2] < 0) & (q[:, 1] > 88), np.abs(q[:, 1] - 97.0 + 0.12 * q[:, 0]), 9)
    return np.minimum.reduce([side, inner, middle, yoke]).astype(F32)


def jeans(p):
    q = mirrored(p)
    hips = smax(loft(q, JEANS_TABLE, 2.35), q[:, 1] - 103.2, 0.3)
    hips = smin(hips, ellipsoid(q, (6.8, 90.5, -6.6), (7.2, 7.6, 6.6)), 2.5)
    thigh = capsule(q, HIP, KNEE, 9.5, 7.3)
    shank = capsule(q, KNEE, HEM, 7.3, 6.7)
    calf = ellipsoid(q, (10.9, 36, -2.4), (6.2, 11, 6.0))
    leg = smin(smin(thigh, shank, 2.0), calf, 2.0)
    y, sign = q[:, 1], np.sign(p[:, 0])
    # stacked rings over the boot, rings round the knee, whiskers from the crotch
    u = np.stack([y * 0.23 + 0.09 * p[:, 2] + 0.08 * p[:, 0], q[:, 2] * 0.11, sign * 4 + q[:, 0] * 0.09], 1)
    rings = fold(noise(u.astype(F32), 1.0, 71), 0.25) - 0.4
    amount = 0.78 * gauss((y - 14) / 8) + 0.68 * gauss((y - 52) / 9) * (0.6 + 0.4 * (q[:, 2] < 0)) + 0.28
    leg = leg - amount * rings * smoothstep(7.6, 9.5, y) * smoothstep(90, 78, y)
    d = smin(hips, leg, 2.6)
    fan = np.stack([np.arctan2(y - 78, q[:, 0] + 4) * 2.6, q[:, 0] * 0.04, sign * 3 + q[:, 2] * 0.06], 1)
    whisker = fold(noise(fan.astype(F32), 1.0, 72), 0.15)
    d = d - 0.55 * whisker * gauss((y - 84) / 8) * smoothstep(1, 5, q[:, 0])
    d = d - 0.16 * smoothstep(9.4, 9.2, y)                                   # turned-up hem
    d = d + 0.14 * gauss(jeans_seam(q) / 0.30) + 0.18 * gauss(front_pocket(q) / 0.3)
    d = d - 0.22 * smoothstep(0.15, -0.15, back_pocket(q))
    d = smax(d, 7.2 - 0.12 * q[:, 2] - y, 0.3)
    return (d - 0.08 * noise(p, 0.3, 73)).astype(F32)


def belt(p):
    q = mirrored(p)
    shell = loft(q, JEANS_TABLE, 2.35)
    d = smax(shell - 0.62, np.abs(q[:, 1] - 101.1) - 1.75, 0.2)
    offset = np.abs(p[:, 0] - 0.4)
    buckle = np.maximum(np.maximum(offset - 2.9, np.abs(q[:, 1] - 101.1) - 2.3), shell - 1.15)
    window = np.maximum(offset - 1.9, np.abs(q[:, 1] - 101.1) - 1.35)
    buckle = smax(buckle, -np.maximum(window, 0.75 - shell), 0.15)
    buckle = np.where(q[:, 2] > 4, buckle, 9)
    return np.minimum(d, buckle).astype(F32)


# ---- boots ----------------------------------------------------------------

_UPPER = [  # z, half width, top y, bottom y
    (-7.9, 1.2, 5.5, 2.2), (-7.0, 2.9, 10.5, 1.0), (-4, 3.9, 14, 1.0), (0, 4.1, 14.5, 1.0),
    (3.5, 4.2, 12.2, 1.0), (7, 4.5, 9.2, 1.0), (10, 4.8, 7.6, 1.0), (14, 4.9, 6.7, 1.0),
    (17.5, 4.3, 6.0, 1.0), (19.8, 3.0, 4.9, 1.3), (21.0, 1.3, 3.4, 1.6)]
_OUTLINE = [(z * 1.02 + 0.1, w + 0.35, 5.0, -5.0) for z, w, _, _ in _UPPER]


def boot_frame(p):
    """Mirrored points in the boot's own axes: x across, y up, z to the toe."""
    q = mirrored(p) - BOOT_ORIGIN
    c, s = np.cos(BOOT_TURN), np.sin(BOOT_TURN)
    return np.stack([q[:, 0] * c - q[:, 2] * s, q[:, 1], q[:, 0] * s + q[:, 2] * c], 1).astype(F32)


def boot_seam(b):
    toe_cap = np.where(b[:, 1] > 2.4, np.abs(b[:, 2] - 13.5 + 0.09 * b[:, 0] ** 2), 9)
    heel = np.abs(b[:, 2] + 2.5 - 0.25 * (b[:, 1] - 6)) + np.where(b[:, 1] > 2.4, 0, 9)
    tongue = np.where(b[:, 2] > 2, np.abs(np.abs(b[:, 0]) - 1.9), 9) + np.where(b[:, 2] < 12, 0, 9)
    return np.minimum.reduce([toe_cap, heel, tongue]).astype(F32)


def boots(p):
    b = boot_frame(p)
    lying = b[:, [0, 2, 1]]
    upper = loft(lying, _UPPER, 2.5)
    upper = smin(upper, capsule(b, (0, 8, -0.8), (0, 19, -0.2), 4.7, 5.2), 2.0)
    upper = upper + 0.16 * gauss(boot_seam(b) / 0.28)
    bend = noise(b * np.array([0.06, 0.15, 0.42], F32), 1.0, 81)
    upper = upper - 0.42 * (fold(bend, 0.17) - 0.2) * gauss((b[:, 2] - 9.5) / 3.2) * (b[:, 1] > 2.6)
    for z in (3.6, 5.3, 7.0, 8.7, 10.4):
        top = float(interp(np.array([z]), [r[0] for r in _UPPER], [r[2] for r in _UPPER])[0])
        for tilt in (0.7, -0.7):
            upper = smin(upper, capsule(b, (-1.9, top - 0.35, z - tilt), (1.9, top - 0.35, z + tilt), 0.28, 0.28), 0.12)
    flat = lying.copy()
    flat[:, 2] = 0
    outline = loft(flat, _OUTLINE, 2.5)
    top = np.where(b[:, 2] < -0.5, 3.3, 2.3)
    arch = 0.9 * smoothstep(-1.2, -0.8, b[:, 2]) * smoothstep(7, 3, b[:, 2])
    sole = smax(smax(outline, b[:, 1] - top, 0.25), arch - b[:, 1], 0.25)
    return np.minimum(upper, sole).astype(F32)


# ---- all parts ------------------------------------------------------------

CLASSES = ["skin", "hair", "fabric", "leather"]
SKIN_HEAD, SKIN_HAND_L, SKIN_HAND_R, SCALP, BEARD, TEE, JACKET, JEANS, BELT, BOOTS = range(10)
PARTS = [  # name, class, field, boxes (low, high)
    ("head", 0, body.head_skin, (-20, 140, -16), (20, 178, 18)),
    ("left hand", 0, lambda p: body.hand(p, 1), (38, 74, -8), (72, 112, 20)),
    ("right hand", 0, lambda p: body.hand(p, -1), (-72, 74, -8), (-38, 112, 20)),
    ("scalp hair", 1, body.scalp_hair, (-14, 148, -16), (14, 184, 17)),
    ("beard", 1, body.beard, (-10, 146, -4), (10, 167, 18)),
    ("tee", 2, tee, (-26, 98, -18), (26, 157, 18)),
    ("jacket", 3, jacket, (-58, 90, -20), (58, 160, 20)),
    ("jeans", 2, jeans, (-26, 2, -20), (26, 108, 18)),
    ("belt", 3, belt, (-23, 94, -17), (23, 108, 17)),
    ("boots", 3, boots, (-24, -4, -16), (24, 26, 26))]
CLASS_OF_PART = np.array([part[1] for part in PARTS])


def distances(p):
    """Distance of every part, shape (parts, N)."""
    p = np.ascontiguousarray(p, F32)
    return np.stack([in_box(p, low, high, field) for _, _, field, low, high in PARTS])


def distance(p):
    return distances(p).min(0)
