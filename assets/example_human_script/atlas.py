# SPDX-License-Identifier: Apache-2.0
"""Charts, unwrapping, packing and rasterising of the texture atlas."""
import bpy
import numpy as np

from . import clothes
from .body import FINGERS, HAND_N, hand_frame, mirrored
from .clothes import boot_frame, leg_coordinate, sleeve_coordinates, sleeve_side
from .mesher import components

ATLAS_PX = 2048
CELL_PX = 8             # the packer works on cells of this many texels
GUTTER_PX = 5           # each chart keeps at least this distance to the next


def chart_keys(centre, normal, part):
    """A number per face: body region and side, chosen so that a region unwraps flat."""
    q = mirrored(centre)
    left = (centre[:, 0] > 0).astype(int)
    key = part * 100
    on = np.isin(part, (clothes.SKIN_HEAD, clothes.BEARD))
    key = np.where(on, _head_keys(centre, normal, left), key)
    key = np.where(part == clothes.SCALP, 310 + left, key)
    for hand, side in ((clothes.SKIN_HAND_L, 1), (clothes.SKIN_HAND_R, -1)):
        on = part == hand
        key[on] = hand * 100 + _hand_keys(hand_frame(centre[on], side), (normal[on] * (side, 1, 1)) @ HAND_N)
    reach, _, _, _ = sleeve_coordinates(q)
    on_sleeve = sleeve_side(q) > 0
    trunk = np.where(centre[:, 2] > -0.6, 0, 1) * 2 + np.where(centre[:, 2] > -0.6, left, 0)
    sleeve = 10 + 2 * left + (centre[:, 2] > -1.8 + 0.09 * np.clip(reach - 30, 0, 30))
    key = np.where(part == clothes.JACKET, 600 + np.where(on_sleeve, sleeve, trunk), key)
    collar = (part == clothes.JACKET) & (clothes.collar(q) < 0.3)
    key = np.where(collar, 690 + left, key)
    _, leg_z = leg_coordinate(q)
    key = np.where(part == clothes.JEANS, 700 + 2 * left + (leg_z > -0.3), key)
    key = np.where(part == clothes.BELT, 800 + (centre[:, 2] > 0), key)
    b = boot_frame(centre)
    zone = np.where((normal[:, 1] < -0.6) & (b[:, 1] < 2.2), 0, np.where(b[:, 0] > 0, 1, 2))
    return np.where(part == clothes.BOOTS, 900 + 10 * left + zone, key)


def _head_keys(p, normal, left):
    """Face, the two sides with their ears, throat, nape."""
    angle = np.abs(np.degrees(np.arctan2(p[:, 0], p[:, 2] - 1.0)))
    jaw = p[:, 1] < 152.2 + 0.40 * (9.0 - p[:, 2]) + 0.6
    side = 3 + left
    ear = (np.abs(p[:, 0]) > 7.35) & (p[:, 1] > 158.5) & (p[:, 2] < 1.6)
    key = np.where(angle < 62, 1, np.where(angle < 118, side, 2))
    key = np.where(jaw & (angle < 118), 5, key)
    return np.where(ear, 10 + 2 * left + (normal[:, 2] < -0.15), key)


def _hand_keys(h, facing):
    """Palm and back, fingers and thumb, each in two halves by where the surface looks."""
    finger = np.zeros(len(h), int)
    best = np.full(len(h), 1e9)
    for number, (u, w, length, _, spread) in enumerate(FINGERS):
        a = np.radians(spread)
        along_cm = np.clip((h[:, 0] - u) * np.cos(a) + (h[:, 1] - w) * np.sin(a), 0, length)
        away = np.abs((h[:, 1] - w) - np.sin(a) * along_cm)
        closer = (h[:, 0] > u + 0.4) & (away < best) & (h[:, 1] < 4.6)
        best, finger = np.where(closer, away, best), np.where(closer, number + 1, finger)
    thumb = (h[:, 1] - 4.4 > -0.35 * (h[:, 0] - 5.5)) & (finger == 0) & (h[:, 1] > 3.2)
    return np.where(thumb, 5, finger) * 2 + (facing > 0)


def smooth_normals(normal, pairs, rounds):
    """Average over neighbouring faces, so that charts do not follow every wrinkle."""
    for _ in range(rounds):
        total = normal.copy()
        for axis in range(3):
            total[:, axis] += np.bincount(pairs[:, 0], normal[pairs[:, 1], axis], len(normal))
            total[:, axis] += np.bincount(pairs[:, 1], normal[pairs[:, 0], axis], len(normal))
        normal = total / (np.linalg.norm(total, axis=1, keepdims=True) + 1e-12)
    return normal


def face_neighbours(faces):
    """Pairs of faces that share an edge."""
    directed = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), 1).astype(np.int64)
    key = directed[:, 0] * (faces.max() + 1) + directed[:, 1]
    order = np.argsort(key, kind="stable")
    owner = order // 3
    same = key[order][:-1] == key[order][1:]
    return np.stack([owner[:-1][same], owner[1:][same]], 1)


def connected_charts(key, pairs, smallest=80):
    """Split keys into connected charts; charts of few faces join their best neighbour."""
    for _ in range(12):
        same = key[pairs[:, 0]] == key[pairs[:, 1]]
        chart = np.unique(components(len(key), pairs[same]), return_inverse=True)[1]
        size = np.bincount(chart)
        a, b = chart[pairs[~same]].T
        a, b = np.concatenate([a, b]), np.concatenate([b, a])
        small = (size[a] < smallest) & (size[b] > size[a])
        if not small.any():
            break
        link, votes = np.unique(np.stack([a[small], b[small]], 1), axis=0, return_counts=True)
        best = link[np.lexsort((votes, link[:, 0]))]
        target = np.arange(len(size))
        target[best[:, 0]] = best[:, 1]
        key = target[chart]
    return chart


def unwrap(vertices, faces, chart, pairs):
    """Conformal map of every chart by Blender; returns (faces, 3, 2)."""
    mesh = bpy.data.meshes.new("unwrap")
    mesh.from_pydata(vertices.tolist(), [], faces.tolist())
    mesh.uv_layers.new()
    apart = chart[pairs[:, 0]] != chart[pairs[:, 1]]
    f, g = faces[pairs[apart, 0]], faces[pairs[apart, 1]]
    shared = (f[:, :, None] == g[:, None, :]).any(2)
    ends = np.sort(np.stack([f[np.arange(len(f)), shared.argmax(1)],
                             f[np.arange(len(f)), 2 - shared[:, ::-1].argmax(1)]], 1), 1)
    edge = np.zeros(len(mesh.edges) * 2, np.int32)
    mesh.edges.foreach_get("vertices", edge)
    edge = np.sort(edge.reshape(-1, 2), 1).astype(np.int64)
    count = len(vertices)
    seam = np.isin(edge[:, 0] * count + edge[:, 1], ends[:, 0] * np.int64(count) + ends[:, 1])
    mesh.edges.foreach_set("use_seam", seam)
    obj = bpy.data.objects.new("unwrap", mesh)
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    obj.select_set(True)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.uv.unwrap(method="ANGLE_BASED", fill_holes=True, margin=0.0)
    bpy.ops.object.mode_set(mode="OBJECT")
    uv = np.zeros(len(faces) * 6, np.float32)
    mesh.uv_layers[0].data.foreach_get("uv", uv)
    bpy.data.objects.remove(obj)
    bpy.data.meshes.remove(mesh)
    return uv.reshape(-1, 3, 2).astype(np.float64)


def signed_area(uv):
    a, b = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    return (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2


def planar(points, normal):
    """Flat projection of the faces of one chart along its mean normal."""
    n = normal / (np.linalg.norm(normal) + 1e-9)
    helper = np.eye(3)[np.abs(n).argmin()]
    u = np.cross(helper, n)
    u /= np.linalg.norm(u)
    return np.stack([points @ u, points @ np.cross(n, u)], -1)


def scale_charts(uv, chart, area_cm2, weight):
    """Give every chart the size of its surface times `weight`, unmirrored and upright."""
    uv = uv.copy()
    for faces in chart_groups(chart):
        part = uv[faces]
        flat = signed_area(part)
        if flat.sum() < 0:
            part[..., 0] *= -1
        wanted = (area_cm2[faces] * weight[faces] ** 2).sum()
        part = part * np.sqrt(wanted / max(np.abs(flat).sum(), 1e-12))
        hull = part.reshape(-1, 2)
        best = None
        for degrees in range(0, 90, 3):
            c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
            turned = hull @ np.array([[c, -s], [s, c]])
            size = np.prod(np.ptp(turned, axis=0))
            if best is None or size < best[0]:
                best = (size, turned)
        turned = best[1] - best[1].min(0)
        uv[faces] = turned.reshape(part.shape)
    return uv


def rasterise(uv_px, width, height):
    """Face index per texel (-1: none) and pairs of faces that cover the same texel."""
    image = np.full(height * width, -1, np.int32)
    low = np.floor(uv_px.min(1) - 0.5).astype(int)
    size = np.ceil(uv_px.max(1) - 0.5).astype(int) - low + 1
    clash = []
    bucket = np.maximum(4, 2 ** np.ceil(np.log2(np.maximum(size.max(1), 1)))).astype(int)
    for edge in np.unique(bucket):
        rows = np.flatnonzero(bucket == edge)
        step = max(1, 4_000_000 // (edge * edge))
        for start in range(0, len(rows), step):
            ids = rows[start:start + step]
            gy, gx = np.divmod(np.arange(edge * edge), edge)
            px, py = low[ids, :1] + gx, low[ids, 1:] + gy
            t = uv_px[ids]
            inside = (px >= 0) & (px < width) & (py >= 0) & (py < height)
            for i in range(3):
                a, b = t[:, i], t[:, (i + 1) % 3]
                side = (b[:, :1] - a[:, :1]) * (py + 0.5 - a[:, 1:]) - (b[:, 1:] - a[:, 1:]) * (px + 0.5 - a[:, :1])
                inside &= side > 1e-7
            f, texel = np.nonzero(inside)
            where, owner = py[f, texel] * width + px[f, texel], ids[f]
            before = image[where]
            image[where] = owner
            winner = image[where]
            clash += [np.stack([before, owner], 1)[before >= 0], np.stack([winner, owner], 1)[winner != owner]]
    return image.reshape(height, width), np.concatenate(clash)


def _grow(mask, px):
    padded = np.pad(mask, px)
    rows = padded.copy()
    for shift in range(1, px + 1):
        rows[shift:] |= padded[:-shift]
        rows[:-shift] |= padded[shift:]
    out = rows.copy()
    for shift in range(1, px + 1):
        out[:, shift:] |= rows[:, :-shift]
        out[:, :-shift] |= rows[:, shift:]
    return out


def footprint(part_px):
    """Cells of the packer that a chart needs, with its gutter; and the pixel offset in them."""
    size = np.ceil(part_px.reshape(-1, 2).max(0)).astype(int) + 2
    image, _ = rasterise(part_px, size[0], size[1])
    mask = image >= 0
    corner = np.clip(part_px.reshape(-1, 2).astype(int), 0, size - 1)
    mask[corner[:, 1], corner[:, 0]] = True            # thin faces may miss every texel centre
    mask = _grow(mask, GUTTER_PX)
    mask = np.pad(mask, ((0, -mask.shape[0] % CELL_PX), (0, -mask.shape[1] % CELL_PX)))
    h, w = mask.shape
    return mask.reshape(h // CELL_PX, CELL_PX, w // CELL_PX, CELL_PX).any((1, 3))


def pack(uv, chart, px_per_cm):
    """Place charts, biggest first, where they fit lowest. None when they do not fit."""
    cells = ATLAS_PX // CELL_PX
    used = np.zeros((cells, cells), bool)
    result = np.empty_like(uv)
    groups = chart_groups(chart)
    groups.sort(key=lambda g: -np.prod(np.ptp(uv[g].reshape(-1, 2), axis=0)))
    for faces in groups:
        part = uv[faces] * px_per_cm
        best = None
        turns = 4 if len(faces) > 300 else 1
        spectrum = np.fft.rfft2(used, (2 * cells, 2 * cells))
        for turn in range(turns):
            mask = footprint(part)
            h, w = mask.shape
            if h <= cells and w <= cells:
                kernel = np.fft.rfft2(mask[::-1, ::-1], (2 * cells, 2 * cells))
                overlap = np.fft.irfft2(spectrum * kernel, (2 * cells, 2 * cells))
                free = overlap[h - 1:cells, w - 1:cells] < 0.5
                if free.any():
                    y, x = np.nonzero(free)
                    cost = np.maximum(y + h, x + w) * 1000 + y + x
                    k = cost.argmin()
                    if best is None or cost[k] < best[0]:
                        best = (cost[k], y[k], x[k], mask, part)
            part = np.stack([part[..., 1], -part[..., 0]], -1)
            part = part - part.reshape(-1, 2).min(0)
        if best is None:
            return None
        _, y, x, mask, part = best
        used[y:y + mask.shape[0], x:x + mask.shape[1]] |= mask
        result[faces] = part + np.array([x, y]) * CELL_PX + GUTTER_PX
    return result


def make_atlas(vertices, faces, part, weight, log):
    """UVs in texels, shape (faces, 3, 2), and the face index of every texel."""
    p = vertices[faces].astype(np.float64)
    cross = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    area = np.linalg.norm(cross, axis=1) / 2
    normal = cross / (2 * area[:, None] + 1e-12)
    pairs = face_neighbours(faces)
    chart = connected_charts(chart_keys(p.mean(1), smooth_normals(normal, pairs, 6), part), pairs)
    loose = np.zeros(len(faces), bool)
    for attempt in range(6):
        uv = scale_charts(unwrap(vertices, faces, chart, pairs), chart, area, weight)
        uv, bad = project_where_better(uv, chart, p, cross, area, weight, loose)
        by_part = np.bincount(part[bad], minlength=len(clothes.PARTS))
        log("charts %d, faces to repair %d, by part %s" % (chart.max() + 1, bad.sum(), by_part.tolist()))
        if not bad.any():
            break
        if attempt < 3:                                 # take the neighbours along
            ring = pairs[bad[pairs[:, 0]] | bad[pairs[:, 1]]]
            bad[ring.ravel()] = True
        loose |= bad
        facing = np.abs(normal).argmax(1) * 2 + (np.take_along_axis(normal, np.abs(normal).argmax(1)[:, None], 1)[:, 0] > 0)
        key = np.where(bad, chart.max() + 1 + chart * 6 + facing, chart)
        if attempt >= 3:
            key = np.where(bad, chart.max() * 8 + 10 + np.arange(len(faces)), key)
        chart = connected_charts(key, pairs, 0)
    px_per_cm = np.sqrt(0.67 * ATLAS_PX ** 2 / (area * weight ** 2).sum())
    while True:
        packed = pack(uv, chart, px_per_cm)
        if packed is not None:
            break
        px_per_cm *= 0.97
    image, clash = rasterise(packed, ATLAS_PX, ATLAS_PX)
    log("atlas: %.1f texels per cm, %.0f %% used, texels covered twice: %d" %
        (px_per_cm, 100 * (image >= 0).mean(), len(clash)))
    return packed, image, chart, len(clash)


def chart_groups(chart):
    order = np.argsort(chart, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(chart[order])) + 1)


def project_where_better(uv, chart, p, cross, area, weight, loose):
    """Replace the conformal map of a chart by a projection where that breaks fewer faces."""
    wanted = area * weight ** 2
    bad = broken_faces(uv, chart, wanted)
    for group in chart_groups(chart):
        if not loose[group].any() and bad[group].mean() < 0.05:
            continue
        points, alone = p[group], np.zeros(len(group), int)
        bent = np.arctan2(points[..., 0], points[..., 2] + 1.0) * 9.0          # round the head
        for flat in (planar(points, cross[group].sum(0)), np.stack([bent, points[..., 1]], -1)):
            trial = scale_charts(flat, alone, area[group], weight[group])
            trial_bad = broken_faces(trial, alone, wanted[group])
            if trial_bad.sum() < bad[group].sum() or loose[group].any():
                uv[group], bad[group] = trial, trial_bad
                break
    return uv, bad


def broken_faces(uv, chart, wanted_area):
    """Faces that are flipped, squeezed flat or under another face of their chart."""
    flat = signed_area(uv)
    bad = flat < 0.02 * wanted_area
    for group in chart_groups(chart):
        if len(group) < 2:
            continue
        for px_per_cm, offset in ((11.0, 0.0), (15.0, 0.37)):
            part = uv[group] * px_per_cm + offset
            size = np.ceil(part.reshape(-1, 2).max(0)).astype(int) + 2
            _, clash = rasterise(part, size[0], size[1])
            if len(clash):                              # of each pair move the smaller one
                pair = group[clash]
                bad[pair[np.arange(len(pair)), wanted_area[pair].argmin(1)]] = True
    return bad
