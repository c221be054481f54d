"""GLB, the binary form of glTF 2: the objects of its scene, placed by their nodes, as one surface.

Source: the glTF 2.0 specification of the Khronos Group, ISO/IEC 12113:2022.
"""

import json

import numpy as np

from lssd_learn.shapes.reading.accessors import Accessors
from lssd_learn.shapes.reading.parsed import Parsed, some
from lssd_learn.shapes.reading.polygons import triangles

POINTS, TRIANGLES, STRIP, FAN = 0, 4, 5, 6
# Extensions that may stand behind `required` and change no position, or that are read.
_HARMLESS = ("KHR_materials_", "KHR_texture_", "KHR_lights_", "EXT_texture_", "KHR_xmp", "KHR_mesh_quantization")
_PLACING = "EXT_mesh_gpu_instancing"


def read(data: bytes) -> Parsed:
    """Vertices and faces, object by object in the order of the scene's nodes; points if it has no triangles.

    Skins and morph targets are applied as the nodes stand. Lines, and points beside triangles, are left out.

    Raises:
        ValueError: less than it announces, an extension or a form that is not read, a part in another file.
    """
    tree, numbers = _chunks(data)
    required = [name for name in tree.get("extensionsRequired", []) if not str(name).startswith(_HARMLESS)]
    if required:
        raise ValueError(f"it needs the extension {required[0]}, which is not read")
    if _PLACING in tree.get("extensionsUsed", []):
        raise ValueError(f"it places objects by {_PLACING}, which is not read")
    accessors, nodes, meshes = Accessors(tree, numbers), tree.get("nodes", []), tree.get("meshes", [])
    placed, left_out = _placed(tree)
    vertices, corners, points, lines, at = [], [], [], 0, 0
    begins: dict[tuple, int] = {}
    for number, matrix in placed.items():
        node = nodes[number]
        if "mesh" not in node:
            continue
        mesh = _item(meshes, node["mesh"], "mesh")
        for primitive in mesh.get("primitives", []):
            _check_extensions(primitive)
            mode = primitive.get("mode", TRIANGLES)
            if mode not in (POINTS, TRIANGLES, STRIP, FAN):
                lines += 1
                continue
            if "POSITION" not in primitive.get("attributes", {}):
                raise ValueError("an object without positions")
            found = _morphed(primitive, node.get("weights", mesh.get("weights", [])), accessors)
            if "skin" in node:
                found = _skinned(
                    found, primitive, _item(tree.get("skins", []), node["skin"], "skin"), placed, accessors
                )
                turned = False
            else:
                found, turned = found @ matrix[:3, :3].T + matrix[:3, 3], np.linalg.det(matrix[:3, :3]) < 0
            if mode == POINTS:
                points.append(found)
                continue
            shared = (number, primitive["attributes"]["POSITION"], str(primitive.get("targets")))
            if shared not in begins:  # materials cut an object into parts, which may have their vertices in common
                begins[shared] = at
                vertices.append(found)
                at += len(found)
            index = accessors.scalars(primitive["indices"]) if "indices" in primitive else np.arange(len(found))
            if len(index) and not 0 <= index.min() <= index.max() < len(found):
                raise ValueError(f"faces: expected indices from 0 to {len(found) - 1}, got some to {index.max()}")
            faces = _triangles(index, mode)
            corners.append((faces[:, ::-1] if turned else faces) + begins[shared])
    notes = [f"left out {some(lines, 'object')} of lines"] if lines else []
    if left_out:
        notes.append(f"left out {some(left_out, 'object')} outside its scene")
    if not corners:
        return Parsed(np.concatenate([np.empty((0, 3)), *points]), np.empty((0, 3), np.int64), tuple(notes))
    if points:
        notes.append(f"left out {some(len(points), 'object')} of points")
    corners = np.concatenate(corners)
    faces, told = triangles(np.concatenate(vertices), corners.ravel(), np.full(len(corners), 3))
    return Parsed(np.concatenate(vertices), faces, (*notes, *told))


def _chunks(data: bytes) -> tuple[dict, bytes]:
    """The JSON and the numbers."""
    if data[:4] != b"glTF" or int.from_bytes(data[4:8], "little") != 2:
        raise ValueError("expected glTF, version 2, in its first bytes")
    length, at, found = int.from_bytes(data[8:12], "little"), 12, {}
    if length > len(data):
        raise ValueError(f"it announces {length:,} bytes, {len(data):,} are there")
    if data[length:].strip(b"\0"):
        raise ValueError(f"{len(data) - length:,} bytes more than it announces")
    while at + 8 <= length:
        size, kind = int.from_bytes(data[at : at + 4], "little"), data[at + 4 : at + 8]
        if at + 8 + size > length:
            raise ValueError("one of its chunks is cut off")
        found.setdefault(kind, data[at + 8 : at + 8 + size])
        at += 8 + size
    try:
        tree = json.loads(found[b"JSON"])
    except (KeyError, ValueError, RecursionError) as error:
        raise ValueError(f"its JSON cannot be read: {error}") from None
    if not isinstance(tree, dict):
        raise ValueError("its JSON is no object")
    return tree, found.get(b"BIN\0", b"")


def _item(items: list, number: int, what: str):
    if not isinstance(number, int) or not 0 <= number < len(items):
        raise ValueError(f"it names {what} {number}, {len(items)} are there")
    return items[number]


def _check_extensions(primitive: dict) -> None:
    """A compressed object has no other numbers, or may have: neither is read."""
    for name in primitive.get("extensions", {}):
        if not name.startswith(_HARMLESS):
            raise ValueError(f"an object comes in the form {name}, which is not read")


def _placed(tree: dict) -> tuple[dict[int, np.ndarray], int]:
    """The nodes of the scene, in order, with their matrices (4, 4); and how many objects stand outside it."""
    nodes, scenes = tree.get("nodes", []), tree.get("scenes", [])
    children = {child for node in nodes for child in node.get("children", [])}
    if scenes:
        roots = _item(scenes, tree.get("scene", 0), "scene").get("nodes", [])
    else:
        roots = [number for number in range(len(nodes)) if number not in children]
    placed: dict[int, np.ndarray] = {}
    stack = [(root, np.eye(4)) for root in reversed(roots)]
    while stack:
        number, above = stack.pop()
        node = _item(nodes, number, "node")
        if number in placed:
            raise ValueError(f"node {number} stands in its scene twice")
        placed[number] = above @ _matrix(node)
        stack += [(child, placed[number]) for child in reversed(node.get("children", []))]
    return placed, sum("mesh" in node for number, node in enumerate(nodes) if number not in placed)


def _matrix(node: dict) -> np.ndarray:
    """(4, 4) of a node: its matrix, or translation · rotation · scale."""
    if "matrix" in node:
        matrix = np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
        if not np.allclose(matrix[3], [0, 0, 0, 1]):
            raise ValueError("a node's matrix is a projection")
        return matrix
    matrix = np.eye(4)
    x, y, z, w = np.array(node.get("rotation", [0, 0, 0, 1]), dtype=np.float64) / (
        np.linalg.norm(node.get("rotation", [0, 0, 0, 1])) or 1
    )
    matrix[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    matrix[:3, :3] = matrix[:3, :3] * np.array(node.get("scale", [1, 1, 1]), dtype=np.float64)
    matrix[:3, 3] = node.get("translation", [0, 0, 0])
    return matrix


def _morphed(primitive: dict, weights: list, accessors: Accessors) -> np.ndarray:
    """(V, 3) the positions with the morph targets that are on."""
    found = accessors.rows(primitive["attributes"]["POSITION"], 3)
    for weight, target in zip(weights, primitive.get("targets", []), strict=False):
        if weight and "POSITION" in target:
            found = found + weight * accessors.rows(target["POSITION"], 3)
    return found


def _skinned(
    points: np.ndarray, primitive: dict, skin: dict, placed: dict[int, np.ndarray], accessors: Accessors
) -> np.ndarray:
    """(V, 3) where the joints of a skin take the points."""
    joints = skin.get("joints", [])
    if any(joint not in placed for joint in joints):
        raise ValueError("a skin names a joint that is not in its scene")
    bound = np.tile(np.eye(4), (len(joints), 1, 1))
    if "inverseBindMatrices" in skin:
        bound = accessors.rows(skin["inverseBindMatrices"], 16).reshape(-1, 4, 4).transpose(0, 2, 1)
    matrices = np.array([placed[joint] for joint in joints]) @ bound[: len(joints)]
    attributes, out, total = primitive["attributes"], np.zeros_like(points), np.zeros((len(points), 1))
    homogeneous = np.hstack([points, np.ones((len(points), 1))])
    for group in range(8):
        if f"JOINTS_{group}" not in attributes:
            break
        numbers = accessors.rows(attributes[f"JOINTS_{group}"], 4).astype(np.int64)
        weights = accessors.rows(attributes[f"WEIGHTS_{group}"], 4)
        if numbers.max(initial=0) >= len(joints):
            raise ValueError(f"a skin has {len(joints)} joints, number {numbers.max()} is named")
        for column in range(4):
            moved = np.einsum("vab,vb->va", matrices[numbers[:, column], :3], homogeneous)
            out += weights[:, [column]] * moved
            total += weights[:, [column]]
    if not (total > 0).all():
        raise ValueError("a skin leaves vertices without a joint")
    return out / total


def _triangles(index: np.ndarray, mode: int) -> np.ndarray:
    """(F, 3) of a list, a strip or a fan of corners."""
    if mode == TRIANGLES:
        if len(index) % 3:
            raise ValueError(f"its triangles have {len(index):,} corners, no multiple of three")
        return index.reshape(-1, 3)
    if len(index) < 3:
        return np.empty((0, 3), dtype=np.int64)
    if mode == FAN:
        return np.stack([np.full(len(index) - 2, index[0]), index[1:-1], index[2:]], axis=1)
    faces = np.stack([index[:-2], index[1:-1], index[2:]], axis=1)
    faces[1::2] = faces[1::2, [1, 0, 2]]
    return faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]  # a corner twice joins two strips
