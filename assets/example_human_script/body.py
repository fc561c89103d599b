# SPDX-License-Identifier: Apache-2.0
"""Skin and hair of the example human as signed-distance fields (cm, Y up, faces +Z)."""
import numpy as np

from .fields import (F32, along, axial_distance, capsule, ellipsoid, fbm, gauss, interp, loft,
                     noise, smax, smin, smoothstep, sphere)

EYE = np.array([3.15, 164.0, 7.95], F32)      # centre of the left eyeball
EYE_RADIUS = 1.25
MOUTH_Y = 156.9
MOUTH_HALF_WIDTH = 2.6

FACE_TABLE = [  # y, half width, front z, back z
    (150.5, 4.2, 9.0, -4.5), (152.5, 4.5, 9.6, -4.5), (154, 5.0, 9.9, -4.5), (156, 5.7, 9.7, -5),
    (158, 6.3, 9.8, -5), (160, 6.7, 9.8, -5.5), (162, 7.0, 9.75, -6), (164, 7.05, 9.7, -6),
    (166, 7.1, 10.1, -6), (168, 7.1, 10.05, -6), (170, 7.0, 9.4, -6), (172, 6.3, 7.8, -6)]

SHOULDER = np.array([17.4, 141.6, -2.4], F32)
ELBOW = np.array([36.0, 121.5, -3.5], F32)
WRIST = np.array([50.0, 100.5, 2.5], F32)


def mirrored(p):
    q = p.copy()
    q[:, 0] = np.abs(q[:, 0])
    return q


def natural(p):
    """Bend space by a millimetre or two, so that left and right differ as in a person."""
    q = p.copy()
    q[:, 0] += 0.16 * noise(p, 0.11, 3)
    q[:, 1] += 0.12 * noise(p, 0.13, 4)
    return q


def skull(p):
    """Head without features: what hair grows on."""
    cranium = ellipsoid(p, (0, 166.6, -0.3), (7.6, 9.0, 9.9))
    face = loft(p, FACE_TABLE, 2.25)
    # The underside of the jaw rises from the chin back to the ear.
    jaw = (152.4 + 0.40 * (9.0 - p[:, 2]) - p[:, 1]) * F32(0.93)
    face = smax(face, jaw, 1.6)
    return smin(cranium, face, 2.0)


_BUMPS = [  # centre, spread, height: one side, mirrored
    ((2.9, 166.1, 9.6), (2.0, 0.75, 2.6), 0.34), ((0.0, 166.2, 10), (1.1, 1.0, 2), 0.16),
    ((3.15, 164.3, 9.2), (1.8, 1.15, 2.6), -0.98), ((1.45, 164.5, 9.7), (0.65, 1.0, 2), -0.50),
    ((6.9, 167.3, 5.2), (1.6, 2.4, 2.6), -0.38), ((5.1, 161.9, 6.9), (1.6, 1.1, 2.2), 0.42),
    ((5.2, 158.6, 6.3), (1.5, 1.8, 2.6), -0.42), ((0.0, 157.2, 10), (2.3, 1.6, 2.6), 0.40),
    ((0.0, 158.5, 10.5), (0.33, 0.6, 1.2), -0.13), ((0.0, 155.35, 10), (1.7, 0.5, 2), -0.34),
    ((0.0, 153.8, 10), (1.5, 1.0, 2.2), 0.42), ((2.5, 162.3, 9.0), (1.1, 0.5, 2), 0.10),
    ((0.0, 170.0, 9.0), (3.0, 1.6, 3), 0.12), ((5.7, 156.2, 2.0), (1.4, 1.5, 2.6), 0.35)]


def _features(q):
    """Outward displacement of the face; q is mirrored to x >= 0."""
    height = np.zeros(len(q), F32)
    for centre, spread, amount in _BUMPS:
        e = (q - np.asarray(centre, F32)) / np.asarray(spread, F32)
        height += F32(amount) * np.exp(-(e * e).sum(1))
    # fold from the nostril to the corner of the mouth
    t, _ = along(q, (1.9, 160.0, 10.2), (3.35, 157.0, 9.0))
    t = np.clip(t, 0, 1)
    r = axial_distance(q, (1.9, 160.0, 10.2), (3.35, 157.0, 9.0), t)
    height -= 0.17 * gauss(r / 0.42) * np.sin(np.pi * np.clip(t * 0.85 + 0.15, 0, 1))
    return height + _lips(q)


def lip_coordinates(q):
    """Share of the half mouth width, and height above the line between the lips."""
    share = np.clip(q[:, 0] / MOUTH_HALF_WIDTH, 0, 1.6)
    line = MOUTH_Y - 0.16 * gauss(q[:, 0] / 0.45) + 0.10 * share ** 2
    return share, q[:, 1] - line


def _lips(q):
    share, dy = lip_coordinates(q)
    taper = np.sqrt(np.clip(1 - share ** 2, 0, 1))
    front = smoothstep(6.0, 8.0, q[:, 2])
    upper = 0.30 * taper * gauss((dy - 0.42 * taper) / 0.34)
    lower = 0.40 * taper * gauss((dy + 0.52 * taper) / 0.42)
    crease = 0.42 * np.clip(1.08 - share ** 4, 0, 1) * gauss(dy / 0.14) * (share < 1.15)
    return front * (upper + lower - crease)


def eye_aperture(q):
    """Signed distance-like: negative between the lids. q mirrored."""
    u = (q[:, 0] - EYE[0]) / 1.52
    tilt = 0.08 * u
    arch = np.clip(1 - u * u, 0, 1)
    upper = EYE[1] + tilt + 0.50 * arch ** 0.75
    lower = EYE[1] + tilt - 0.40 * arch
    return np.maximum(np.maximum(q[:, 1] - upper, lower - q[:, 1]), (np.abs(u) - 1) * 1.4)


def _nose(q):
    d = capsule(q, (0, 165.2, 9.35), (0, 161.0, 11.7), 0.58, 0.72)
    # the body of the nose, so that no gap stays between its ridge and the face
    d = smin(d, capsule(q, (0, 164.4, 9.0), (0, 160.5, 10.5), 0.75, 1.05), 0.5)
    d = smin(d, sphere(q, (0, 160.55, 12.0), 0.88), 0.6)
    d = smin(d, ellipsoid(q, (1.2, 160.15, 10.9), (0.72, 0.68, 0.95)), 0.5)
    d = smin(d, capsule(q, (0, 159.7, 11.7), (0, 158.95, 10.1), 0.44, 0.7), 0.4)
    nostril = ellipsoid(q, (0.62, 159.45, 11.35), (0.36, 0.34, 0.62))
    return smax(d, -nostril, 0.25)


def _ear(q):
    """Shell of the ear: a tilted disc with a raised rim, hollow in the middle."""
    c, s = np.cos(0.34), np.sin(0.34)
    e = q - np.array([7.35, 162.9, -0.6], F32)
    depth = e[:, 0] * c + e[:, 2] * s * 1.0          # across the disc
    back = -e[:, 2] * c + e[:, 0] * s                # towards the back of the head
    up = e[:, 1] - 0.18 * back
    r = np.sqrt((back / 1.65) ** 2 + (up / 2.85) ** 2) + 1e-4
    ring = (r - 1) * 2.0
    disc = smax(np.abs(depth + 0.1) - 0.22, ring, 0.4)
    rim = np.sqrt((ring + 0.22) ** 2 + (depth - 0.38) ** 2) - 0.27
    fold = np.sqrt(((r - 0.55) * 1.9) ** 2 + (depth - 0.28) ** 2) - 0.22
    lobe = ellipsoid(q, (7.35, 160.2, 0.0), (0.5, 0.85, 0.7))
    tragus = ellipsoid(q, (7.45, 162.5, 0.75), (0.4, 0.6, 0.45))
    d = smin(smin(disc, rim, 0.25), smin(fold, smin(lobe, tragus, 0.3), 0.3), 0.2)
    hole = ellipsoid(q, (7.8, 162.5, -0.2), (0.8, 0.85, 0.65))
    return smax(d, -hole, 0.25)


def _neck(q):
    d = capsule(q, (0, 143, -3.6), (0, 158.5, -1.6), 6.6, 5.4)
    d = smin(d, ellipsoid(q, (0, 150.3, 2.5), (1.3, 2.2, 2.2)), 1.8)
    d = smin(d, capsule(q, (5.4, 160, -2.0), (1.6, 145.5, 3.4), 1.1, 1.0), 1.6)
    return smin(d, capsule(q, (3.5, 152, -4.5), (16, 143.0, -4), 3.4, 2.8), 3.0)


def head_skin(p):
    """Face, ears and neck."""
    q = mirrored(natural(p))
    d = skull(q) - _features(q)
    d = smin(d, _nose(q), 0.75)
    lid = np.maximum(sphere(q, EYE, 1.45), -eye_aperture(q) * 0.9)
    lid = smin(d, lid, 0.35)
    crease = gauss((eye_aperture(q) - 0.42) / 0.16) * (q[:, 1] > EYE[1] + 0.1)
    d = lid + 0.10 * crease * (np.abs(q[:, 0] - EYE[0]) < 1.7) * (q[:, 2] > 6)
    d = np.minimum(d, sphere(q, EYE, EYE_RADIUS))
    d = smin(d, _ear(q), 0.4)
    brow = gauss((q[:, 1] - brow_line(q[:, 0])) / 0.35) * (q[:, 2] > 5) * smoothstep(0.9, 1.6, q[:, 0])
    d = d - 0.10 * brow * smoothstep(5.9, 5.0, q[:, 0])
    return smin(d, _neck(q), 1.6)


def brow_line(x):
    return interp(x, (0, 1.2, 3.0, 4.6, 6.0), (165.5, 165.75, 166.35, 166.45, 165.7))


# ---- hair -----------------------------------------------------------------

def hair_line(q):
    """Signed: positive where scalp hair grows. Angle is 0 at the face, 180 at the nape."""
    angle = np.degrees(np.arctan2(q[:, 0], q[:, 2] - 0.3))
    line = interp(angle, (0, 15, 32, 48, 58, 70, 79, 85, 97, 109, 118, 126, 142, 180),
                  (171.4, 171.7, 172.0, 170.6, 167.2, 161.8, 162.6, 166.3, 167.0, 166.4, 162.5, 159.5, 156.2, 155.4))
    return q[:, 1] - line


def strand_coordinates(p):
    """(angle round the flow axis, position along it): hair is combed from brow to nape."""
    axis = np.array([0.10, -0.42, -0.90], F32)
    axis /= np.linalg.norm(axis)
    q = p - np.array([0.8, 165.5, 0], F32)
    side = np.array([1, 0, 0], F32) - axis * axis[0]
    side /= np.linalg.norm(side)
    up = np.cross(side, axis)
    flow = q @ axis
    angle = np.arctan2(q @ side, q @ up)
    angle = angle + 0.10 * noise(p, (0.14, 0.14, 0.10), 11) + 0.03 * noise(p, 0.3, 12)
    return angle.astype(F32), flow.astype(F32)


def strands(p, across_per_radian, along_per_cm, seed):
    """Noise stretched along the hair."""
    angle, flow = strand_coordinates(p)
    r = F32(across_per_radian)
    u = np.stack([np.cos(angle) * r, np.sin(angle) * r, flow * F32(along_per_cm)], 1)
    return noise(u, 1.0, seed)


def scalp_hair(p):
    q = mirrored(natural(p))
    grow = hair_line(q) + 0.30 * strands(p, 7, 0.15, 21)
    volume = 0.55 + 1.75 * smoothstep(167.5, 175.0, q[:, 1]) * smoothstep(8.5, 4.0, q[:, 0])
    volume += 0.2 * smoothstep(1, 8, q[:, 2]) * smoothstep(169, 173, q[:, 1]) * smoothstep(7.0, 3.0, q[:, 0])
    relief = 0.55 * strands(p, 3.2, 0.05, 22) + 0.30 * strands(p, 8.5, 0.08, 23)
    volume = volume + relief * smoothstep(0.0, 2.5, grow) * (0.55 + 0.45 * smoothstep(163, 170, q[:, 1]))
    thick = -0.5 + (volume + 0.5) * smoothstep(-0.6, 1.9 + 1.3 * smoothstep(3, 8, q[:, 2]), grow) - 0.9 * np.clip(-0.8 - grow, 0, 4)
    return (skull(q) - thick).astype(F32)


def beard_line(q):
    """Positive where the short beard grows (mirrored points)."""
    x, y, z = q[:, 0], q[:, 1], q[:, 2]
    cheek = interp(x, (0, 1.4, 2.6, 3.4, 4.6, 5.6, 6.2, 6.6, 7.2),
                   (159.1, 159.2, 159.0, 158.2, 157.7, 158.4, 159.8, 161.8, 164.5)) - y
    under = y - (150.6 + 0.42 * np.clip(8.0 - z, 0, 8))
    share, dy = lip_coordinates(q)
    lips = np.sqrt((x / 2.62) ** 2 + ((dy + 0.05) / np.where(dy > 0, 0.66, 1.0)) ** 2)
    lips = (lips - 1) * 1.0
    behind = z - interp(y, (150, 158, 161.5, 165), (-0.5, 0.9, 1.3, 1.8))
    return np.minimum(np.minimum(np.minimum(cheek, under), lips), behind)


def beard(p):
    q = mirrored(natural(p))
    grow = beard_line(q) + 0.14 * noise(p, (1.9, 1.1, 1.9), 31)
    thick = -0.35 + 0.68 * smoothstep(-0.35, 0.9, grow) - 0.6 * np.clip(-0.5 - grow, 0, 4)
    thick = thick + 0.10 * smoothstep(0.2, 1, grow) * noise(p, (1.3, 0.5, 1.3), 32)
    thick = thick + 0.25 * smoothstep(0.3, 1.5, grow) * gauss((q[:, 1] - 153) / 1.8)
    surface = skull(q) - _features(q)
    surface = np.maximum(surface - thick, -(q[:, 2] + 1.0))
    return np.maximum(surface, 0.6 * (q[:, 1] - 162.5 + 1.5 * (q[:, 0] < 5))).astype(F32)


# ---- hands ----------------------------------------------------------------

HAND_U = (WRIST - ELBOW) / np.linalg.norm(WRIST - ELBOW)          # towards the finger tips
HAND_U = HAND_U + np.array([-0.06, -0.10, 0.0], F32)
HAND_U = (HAND_U / np.linalg.norm(HAND_U)).astype(F32)
_W = np.array([-0.22, 0.0, 1.0], F32)
HAND_W = _W - HAND_U * (_W @ HAND_U)                              # towards the thumb
HAND_W = (HAND_W / np.linalg.norm(HAND_W)).astype(F32)
HAND_N = np.cross(HAND_U, HAND_W).astype(F32)                     # out of the palm or the back
if HAND_N[0] > 0:
    HAND_N = -HAND_N                                              # the palm looks to the body

FINGERS = [  # base along u, base along w, length, radius, spread in degrees
    (8.9, 2.95, 7.4, 0.86, 7.0), (9.3, 0.95, 8.2, 0.88, 2.0),
    (9.0, -1.05, 7.6, 0.83, -3.0), (8.1, -2.9, 6.0, 0.73, -9.0)]


def hand_frame(p, side):
    """Points in the hand's own axes: along the fingers, to the thumb, out of the palm."""
    q = p.copy()
    q[:, 0] *= side
    q = q - WRIST
    return np.stack([q @ HAND_U, q @ HAND_W, q @ HAND_N], 1).astype(F32)


def finger_joints(base_u, base_w, length, spread, curl):
    """Knuckle, two joints and the tip, in the hand's frame."""
    joints, a, bend = [np.array([base_u, base_w, 0.0])], np.radians(spread), 0.0
    for share, more in zip((0.46, 0.30, 0.24), curl):
        bend += np.radians(more)
        step = np.array([np.cos(a) * np.cos(bend), np.sin(a) * np.cos(bend), np.sin(bend)])
        joints.append(joints[-1] + step * length * share)
    return joints


def finger_curls(side):
    """Bends in degrees of the three joints, index to little finger; the hands differ."""
    if side > 0:
        return [(10, 16, 10), (14, 20, 13), (17, 22, 14), (18, 22, 14)]
    return [(14, 20, 12), (18, 24, 15), (20, 26, 16), (20, 24, 16)]


def _finger(h, base_u, base_w, length, radius, spread, curl):
    """Three phalanges that bend more and more towards the palm."""
    d = None
    joints = finger_joints(base_u, base_w, length, spread, curl)
    for start, end in zip(joints[:-1], joints[1:]):
        r0, r1 = radius, radius * 0.91
        bone = capsule(h, start, end, r0, r1)
        knuckle = sphere(h, start - np.array([0, 0, 0.12]), r0 * 1.06)
        bone = smin(bone, knuckle, 0.25)
        d = bone if d is None else smin(d, bone, 0.2)
        radius = r1
    return d


def hand(p, side):
    h = hand_frame(p, side)
    palm = ellipsoid(h, (5.2, 0.1, 0.0), (6.0, 4.5, 1.65))
    palm = smin(palm, capsule(h, (2.5, -2.2, 0.3), (8.2, -2.7, 0.1), 1.25, 0.95), 1.2)
    palm = smin(palm, capsule(h, (3.0, 2.2, 0.5), (9.0, 2.75, 0.0), 1.3, 1.0), 1.2)
    palm = smax(palm, h[:, 0] - 10.2, 1.0)
    wrist = capsule(h * np.array([1, 0.86, 1.12], F32), (-7, 0, 0), (2, 0, 0), 2.9, 2.5)
    d = smin(palm, wrist, 1.8)
    for finger, curl in zip(FINGERS, finger_curls(side)):
        d = smin(d, _finger(h, *finger, curl), 0.35)
        tendon = capsule(h, (2.5, finger[1] * 0.5, -1.2), (finger[0], finger[1], -0.75), 0.3, 0.35)
        d = smin(d, tendon, 0.7)
    thumb = capsule(h, (2.0, 2.6, 0.7), (5.4, 5.0, 1.5), 1.55, 1.12)
    thumb = smin(thumb, capsule(h, (5.4, 5.0, 1.5), (8.0, 6.2, 1.9), 1.0, 0.92), 0.3)
    thumb = smin(thumb, capsule(h, (8.0, 6.2, 1.9), (10.1, 6.7, 2.1), 0.92, 0.72), 0.2)
    d = smin(d, thumb, 0.9)
    return (d - 0.05 * noise(p, 0.5, 41)).astype(F32)
