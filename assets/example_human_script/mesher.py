# SPDX-License-Identifier: Apache-2.0
"""From signed distance to a closed triangle mesh with clean class borders."""
import numpy as np

from .fields import F32

BLOCK = 4     # cells per edge of the blocks that are evaluated or skipped as a whole


def axis_samples(spans):
    """Grid coordinates from (start, end, step) spans, padded to whole blocks."""
    samples = [np.arange(a, b, step) for a, b, step in spans]
    coords = np.concatenate(samples)
    last = spans[-1][2]
    missing = (-(len(coords) - 1)) % BLOCK
    return np.concatenate([coords, coords[-1] + last * np.arange(1, missing + 1)]).astype(F32)


def sample_field(field, xs, ys, zs, reach_cm=2.6):
    """Dense grid of distances, exact near the surface only."""
    coarse = np.stack(np.meshgrid(xs[::BLOCK], ys[::BLOCK], zs[::BLOCK], indexing="ij"), -1)
    shape = coarse.shape[:3]
    d = field(coarse.reshape(-1, 3)).reshape(shape)
    near = np.abs(d) < reach_cm
    block = np.zeros([n - 1 for n in shape], bool)
    low, high = np.full(block.shape, np.inf), np.full(block.shape, -np.inf)
    for i in (0, 1):
        for j in (0, 1):
            for k in (0, 1):
                corner = (slice(i, shape[0] - 1 + i), slice(j, shape[1] - 1 + j), slice(k, shape[2] - 1 + k))
                block |= near[corner]
                low, high = np.minimum(low, d[corner]), np.maximum(high, d[corner])
    block |= (low < 0) & (high > 0)
    grid = np.empty((len(xs), len(ys), len(zs)), F32)
    fine = [np.minimum(np.arange(len(a)) // BLOCK, n - 2) for a, n in zip((xs, ys, zs), shape)]
    grid[:] = np.sign(low + high)[np.ix_(*fine)] * 9
    need = np.zeros(grid.shape, bool)
    for bi, bj, bk in np.argwhere(block):
        need[bi * BLOCK:(bi + 1) * BLOCK + 1, bj * BLOCK:(bj + 1) * BLOCK + 1, bk * BLOCK:(bk + 1) * BLOCK + 1] = True
    index = np.argwhere(need)
    for start in range(0, len(index), 400000):
        i, j, k = index[start:start + 400000].T
        grid[i, j, k] = field(np.stack([xs[i], ys[j], zs[k]], 1))
    return grid, len(index)


# Six tetrahedra round the main diagonal, all of positive orientation.
_STEPS = [(0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2)]


def _tetrahedra():
    result = []
    for number, order in enumerate(_STEPS):
        corner, path = np.zeros(3, int), [np.zeros(3, int)]
        for axis in order:
            corner = corner.copy()
            corner[axis] = 1
            path.append(corner)
        if number >= 3:
            path[1], path[2] = path[2], path[1]
        result.append(path)
    return result


_CASES = {1: [(0, 1, 2, 3), (1, 0, 3, 2), (2, 0, 1, 3), (3, 0, 2, 1)],
          2: [(0, 1, 2, 3), (0, 2, 3, 1), (0, 3, 1, 2), (2, 3, 0, 1), (3, 1, 0, 2), (1, 2, 0, 3)]}


def march(grid, xs, ys, zs):
    """Marching tetrahedra: always closed and manifold. Returns vertices and triangles."""
    grid = np.where(np.abs(grid) < 0.01, np.where(grid < 0, -0.01, 0.01), grid).astype(F32)
    inside = grid < 0
    count = np.zeros([n - 1 for n in grid.shape], np.int8)
    for i in (0, 1):
        for j in (0, 1):
            for k in (0, 1):
                count += inside[i:grid.shape[0] - 1 + i, j:grid.shape[1] - 1 + j, k:grid.shape[2] - 1 + k]
    cells = np.argwhere((count > 0) & (count < 8))
    strides = np.array([grid.shape[1] * grid.shape[2], grid.shape[2], 1])
    base, flat = cells @ strides, grid.ravel()
    edges = []
    for tetrahedron in _tetrahedra():
        ids = np.stack([base + corner @ strides for corner in tetrahedron], 1)
        edges += _tetra_triangles(ids, flat[ids] < 0)
    edges = np.concatenate(edges)                       # (triangles, 3 corners, 2 grid points)
    key = np.sort(edges, 2).reshape(-1, 2)
    unique, inverse = np.unique(key[:, 0] * flat.size + key[:, 1], return_inverse=True)
    a, b = np.divmod(unique, flat.size)
    t = flat[a] / (flat[a] - flat[b])
    where = [np.stack([xs[i], ys[j], zs[k]], 1) for i, j, k in
             (np.unravel_index(a, grid.shape), np.unravel_index(b, grid.shape))]
    return where[0] + t[:, None] * (where[1] - where[0]), inverse.reshape(-1, 3)


def _tetra_triangles(ids, inside):
    result, number = [], inside.sum(1)
    for wanted, flip in ((1, False), (3, True)):
        for a, b, c, d in _CASES[1]:
            rows = ids[(number == wanted) & (inside[:, a] != flip)]
            corners = [(a, b), (a, d), (a, c)] if flip else [(a, b), (a, c), (a, d)]
            result.append(np.stack([rows[:, list(pair)] for pair in corners], 1))
    for i, j, k, l in _CASES[2]:
        rows = ids[(number == 2) & inside[:, i] & inside[:, j]]
        quad = [rows[:, list(pair)] for pair in ((i, k), (i, l), (j, l), (j, k))]
        result += [np.stack([quad[0], quad[1], quad[2]], 1), np.stack([quad[0], quad[2], quad[3]], 1)]
    return result


def components(count, edges):
    """Lowest vertex of each vertex's connected component."""
    label = np.arange(count)
    while True:
        a, b = label[edges[:, 0]], label[edges[:, 1]]
        apart = a != b
        if not apart.any():
            return label
        edges = edges[apart]
        label[np.maximum(a, b)[apart]] = np.minimum(a, b)[apart]
        while True:                                     # point straight at the root
            root = label[label]
            if (root == label).all():
                break
            label = root


def largest_component(vertices, faces):
    """Drop closed bubbles: pockets of air between clothes and body."""
    label = components(len(vertices), faces[:, [0, 1, 1, 2]].reshape(-1, 2))
    sizes = np.bincount(label[faces[:, 0]], minlength=len(vertices))
    return compact(vertices, faces[label[faces[:, 0]] == sizes.argmax()]) + (int((sizes > 0).sum()),)


def compact(vertices, faces):
    used, inverse = np.unique(faces, return_inverse=True)
    return vertices[used], inverse.reshape(-1, 3)


def project(vertices, field, steps=2, limit_cm=0.12):
    """Newton steps back onto the surface, which decimation has left."""
    vertices = vertices.astype(F32)
    h = F32(0.06)
    for _ in range(steps):
        d = field(vertices)
        gradient = np.stack([field(vertices + h * axis) - d for axis in np.eye(3, dtype=F32)], 1) / h
        square = np.maximum((gradient ** 2).sum(1), 0.25)
        move = np.clip(d, -limit_cm, limit_cm) / square
        vertices = vertices - move[:, None] * gradient
    return vertices


def cut_along_classes(vertices, faces, class_of, field_gap, snap=0.22):
    """Split triangles where the class changes, so that borders are smooth curves.

    class_of(points) gives a class index; field_gap(points, a, b) a number that is
    negative where class a wins and positive where b does.
    """
    cls = class_of(vertices)
    edges = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), 1), axis=0)
    a, b = edges[cls[edges[:, 0]] != cls[edges[:, 1]]].T
    low, high = np.zeros(len(a), F32), np.ones(len(a), F32)
    for _ in range(12):
        t = (low + high) / 2
        middle = vertices[a] + t[:, None] * (vertices[b] - vertices[a])
        left = field_gap(middle, cls[a], cls[b]) < 0
        low, high = np.where(left, t, low), np.where(left, high, t)
    t = (low + high) / 2
    point = vertices[a] + t[:, None] * (vertices[b] - vertices[a])
    # A cut close to a vertex moves the vertex instead: no slivers.
    on_border = np.zeros(len(vertices), bool)
    moved = vertices.copy()
    for near, who in ((t < snap, a), (t > 1 - snap, b)):
        moved[who[near]] = point[near]
        on_border[who[near]] = True
    keep = ~(on_border[a] | on_border[b])
    ids = np.full(keep.sum(), 0) + np.arange(keep.sum()) + len(vertices)
    table = dict(zip(zip(a[keep].tolist(), b[keep].tolist()), ids.tolist()))
    return np.concatenate([moved, point[keep]]), _split(faces, table)


def _split(faces, table):
    result = []
    for face in faces.tolist():
        cut = [table.get((min(p, q), max(p, q))) for p, q in zip(face, face[1:] + face[:1])]
        number = 3 - cut.count(None)
        if number == 0:
            result.append(face)
            continue
        for _ in range(3):                                  # rotate to a standard place
            if (number == 1 and cut[0] is not None) or (number == 2 and cut[2] is None) or number == 3:
                break
            face, cut = face[1:] + face[:1], cut[1:] + cut[:1]
        (i, j, k), (u, v, w) = face, cut
        if number == 1:
            result += [[i, u, k], [u, j, k]]
        elif number == 2:
            result += [[u, j, v], [i, u, v], [i, v, k]]
        else:
            result += [[i, u, w], [u, j, v], [w, v, k], [u, v, w]]
    return np.array(result)


def check(vertices, faces):
    """Numbers that tell whether the mesh is closed, manifold and free of empty faces."""
    welded, inverse = np.unique(vertices.astype(F32), axis=0, return_inverse=True)
    faces = inverse.reshape(-1)[faces]
    directed = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).astype(np.int64)
    key = directed[:, 0] * len(welded) + directed[:, 1]
    twin = directed[:, 1] * len(welded) + directed[:, 0]
    once = len(np.unique(key)) == len(key)
    closed = bool(np.isin(key, twin).all())
    p = welded[faces].astype(np.float64)
    cross = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    area = np.linalg.norm(cross, axis=1) / 2
    volume = (p[:, 0] * cross).sum() / 6
    components = largest_component(welded, faces)[2]
    euler = len(np.unique(faces)) - len(key) // 2 + len(faces)
    return dict(triangles=len(faces), welded_vertices=len(welded), closed=closed,
                manifold_edges=bool(once), components=components, euler=int(euler), volume_cm3=float(volume),
                smallest_face_cm2=float(area.min()), area_cm2=float(area.sum()))
