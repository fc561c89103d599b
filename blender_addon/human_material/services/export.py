# SPDX-License-Identifier: GPL-3.0-or-later
"""A person with its edits as a maps folder, which everything of this project reads, and as a GLB for other programs."""
import json
import os
import shutil
import struct
import tempfile
from array import array

from . import decode, edited, maps_json, picture_files, relief
from .errors import InputError


def maps_folder(item, folder):
    """A new maps folder: the edited maps as EXR, the others and the camera as they were imported."""
    if os.path.exists(folder):
        raise InputError(folder, "", "is there already", "choose another name")
    info = maps_json.read(item[relief.PROPERTY])
    found, (width, height) = edited.rasters(relief.material_of(item))
    if (width, height) != (info.width_px, info.height_px):
        raise InputError(info.folder, "", "its maps are %d x %d, the person's %d x %d"
                         % (info.width_px, info.height_px, width, height), "import them again")
    entries, content = {}, {}
    for name, raster, channels, encoding in (("diffuse", "diffuse", "RGB", "linear"), ("roughness", "roughness", "Y", "value"),
                                             ("specular", "f0", "Y", "linear_f0"), ("sss", "sss", "Y", "value")):
        content[name + ".exr"] = picture_files.exr_bytes(width, height, found[raster], channels)
        entries[name] = {"file": name + ".exr", "encoding": encoding}
    for name in ("mask", "normal", "displacement", "classes"):
        if name in info.maps:
            source = info.maps[name]
            file = name + os.path.splitext(source.path)[1].lower()
            with open(source.path, "rb") as stream:
                content[file] = stream.read()
            entries[name] = {"file": file, "encoding": source.encoding, **({"r_cm": source.r_cm} if source.r_cm else {})}
    document = maps_json.document((width, height), info.camera, entries, {"program": "Human Material",
                                                                           "edited_from": info.name})
    _write_folder(folder, content, document)
    return folder


def _write_folder(folder, content, document):
    """Whole or not at all."""
    try:
        part = tempfile.mkdtemp(dir=os.path.dirname(os.path.abspath(folder)), suffix=".part")
    except OSError as error:
        raise InputError(folder, "", "cannot be written (%s)" % error.strerror, "choose another place") from None
    try:
        for name, data in content.items():
            with open(os.path.join(part, name), "wb") as file:
                file.write(data)
        maps_json.write(part, document)
        os.chmod(part, 0o755)
        os.rename(part, folder)
    except OSError as error:
        shutil.rmtree(part, ignore_errors=True)
        raise InputError(folder, "", "cannot be written (%s)" % error.strerror, "choose another place") from None


MOST_F0 = 0.1   # of the GLB's specular colour at code 255; dielectrics of 0.04 are its unit


def _code(value):
    return min(max(int(255 * value + 0.5), 0), 255)


def _srgb(value):
    return _code(decode.linear_to_srgb(min(max(value, 0.0), 1.0)))


def _textures(found, size):
    """PNG bytes of base colour with the mask, of roughness, and of the specular colour."""
    diffuse, mask = found["diffuse"], found["mask"]
    base, rough, specular = bytearray(), bytearray(), bytearray()
    for p in range(size[0] * size[1]):
        base += bytes((*map(_srgb, diffuse[3 * p:3 * p + 3]), _code(mask[p])))
        rough += bytes((0, _code(found["roughness"][p]), 0))
        specular += bytes((_srgb(found["f0"][p] / MOST_F0),) * 3)
    return [picture_files.png_bytes(*size, codes, channels) for codes, channels in ((base, 4), (rough, 3), (specular, 3))]


def _mesh(item, found, size):
    """(positions, normals, UVs, triangles) of the front as arrays; the relief's axes and unit are glTF's."""
    mesh = item.data
    positions = array("f", bytes(12 * len(mesh.vertices)))
    mesh.vertices.foreach_get("co", positions)
    corner_uvs, corners = array("f", bytes(8 * len(mesh.loops))), array("i", bytes(4 * len(mesh.loops)))
    mesh.uv_layers.active.data.foreach_get("uv", corner_uvs)
    mesh.loops.foreach_get("vertex_index", corners)
    uvs, normals = array("f", bytes(8 * len(mesh.vertices))), array("f", bytes(12 * len(mesh.vertices)))
    for k, v in enumerate(corners):
        uvs[2 * v], uvs[2 * v + 1] = corner_uvs[2 * k], 1 - corner_uvs[2 * k + 1]
    width, height = size
    for v in range(len(mesh.vertices)):
        x, y = int(uvs[2 * v] * width), int((1 - uvs[2 * v + 1]) * height)
        p = min(max(y, 0), height - 1) * width + min(max(x, 0), width - 1)
        n = found["normal"][3 * p:3 * p + 3]
        length = sum(c * c for c in n) ** 0.5
        normals[3 * v:3 * v + 3] = array("f", [c / length for c in n] if length > 1e-6 else [0, 0, 1])
    mesh.calc_loop_triangles()
    triangles = array("i", bytes(12 * len(mesh.loop_triangles)))
    mesh.loop_triangles.foreach_get("vertices", triangles)
    sides = array("i", bytes(4 * len(mesh.loop_triangles)))
    mesh.loop_triangles.foreach_get("material_index", sides)
    triangles = array("I", [v for k, side in enumerate(sides) if side == 0 for v in triangles[3 * k:3 * k + 3]])
    count = max(triangles) + 1   # the back's come last
    return positions[:3 * count], normals[:3 * count], uvs[:2 * count], triangles


def glb(item, path):
    """One mesh with vertex normals, base colour and mask, roughness, and F0 (KHR_materials_specular). glTF has no
    subsurface scattering that viewers know: it is left out."""
    if os.path.splitext(path)[1].lower() != ".glb":
        raise InputError(path, "", "is no .glb", "choose another name")
    found, size = edited.rasters(relief.material_of(item))
    positions, normals, uvs, triangles = _mesh(item, found, size)
    blocks = [positions.tobytes(), normals.tobytes(), uvs.tobytes(), triangles.tobytes(), *_textures(found, size)]
    counts = len(positions) // 3, len(triangles)
    data = _glb_bytes(_document(item.name, positions, counts, blocks), blocks)
    temporary = path + ".part"
    try:
        with open(temporary, "wb") as file:
            file.write(data)
        os.replace(temporary, path)
    except OSError as error:
        raise InputError(path, "", "cannot be written (%s)" % error.strerror, "choose another place") from None
    return counts


def _document(name, positions, counts, blocks):
    views, at = [], 0
    for block in blocks:
        views.append({"buffer": 0, "byteOffset": at, "byteLength": len(block)})
        at += len(block) + -len(block) % 4
    low, high = ([function(positions[c::3]) for c in range(3)] for function in (min, max))
    vectors = [("VEC3", {"min": low, "max": high}), ("VEC3", {}), ("VEC2", {})]
    accessors = [{"bufferView": k, "componentType": 5126, "count": counts[0], "type": kind, **more}
                 for k, (kind, more) in enumerate(vectors)]
    accessors.append({"bufferView": 3, "componentType": 5125, "count": counts[1], "type": "SCALAR"})
    specular = {"specularColorTexture": {"index": 2}, "specularColorFactor": [MOST_F0 / 0.04] * 3}
    return {"asset": {"version": "2.0", "generator": "Human Material"}, "scene": 0, "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0, "name": name}], "extensionsUsed": ["KHR_materials_specular"],
            "meshes": [{"name": name, "primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2},
                                                      "indices": 3, "material": 0}]}],
            "materials": [{"name": name, "alphaMode": "MASK", "doubleSided": True,
                           "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0,
                                                    "metallicRoughnessTexture": {"index": 1}},
                           "extensions": {"KHR_materials_specular": specular}}],
            "samplers": [{"wrapS": 33071, "wrapT": 33071}],
            "textures": [{"source": k, "sampler": 0} for k in range(3)],
            "images": [{"bufferView": 4 + k, "mimeType": "image/png"} for k in range(3)],
            "accessors": accessors, "bufferViews": views, "buffers": [{"byteLength": at}]}


def _glb_bytes(document, blocks):
    binary = b"".join(block + b"\0" * (-len(block) % 4) for block in blocks)
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    total = 12 + 8 + len(text) + 8 + len(binary)
    return (struct.pack("<4sII", b"glTF", 2, total) + struct.pack("<I4s", len(text), b"JSON") + text
            + struct.pack("<I4s", len(binary), b"BIN\0") + binary)
