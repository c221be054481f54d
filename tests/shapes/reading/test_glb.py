"""GLB in the forms that programs write: scenes, placed objects, any types and layouts."""

import base64
import json
import struct

import numpy as np
import pytest
import trimesh

from lssd_learn.errors import InputError
from lssd_learn.shapes import clean, load

KINDS = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}


class Builder:
    """Puts arrays into one buffer and tells where."""

    def __init__(self, rng: np.random.Generator):
        self.rng, self.numbers = rng, bytearray()
        self.tree = {"asset": {"version": "2.0"}, "bufferViews": [], "accessors": [], "meshes": [], "nodes": []}

    def view(self, data: bytes, stride: int = 0) -> int:
        self.numbers += bytes(-len(self.numbers) % 4)
        view = {"buffer": 0, "byteOffset": len(self.numbers), "byteLength": len(data)}
        self.tree["bufferViews"].append(view | ({"byteStride": stride} if stride else {}))
        self.numbers += data
        return len(self.tree["bufferViews"]) - 1

    def array(self, array: np.ndarray, kind: str, **more) -> int:
        array = np.asarray(array).astype(f"<{kind}")
        shape = {1: "SCALAR", 3: "VEC3", 4: "VEC4", 16: "MAT4"}[1 if array.ndim == 1 else array.shape[1]]
        rows, stride = [row.tobytes() for row in array], 0
        if array.ndim > 1 and self.rng.random() < 0.4:  # with something between
            stride = -(-len(rows[0]) // 4) * 4 + 8
            rows = [row.ljust(stride, b"\7") for row in rows]
        offset = 4 * int(self.rng.integers(3))
        view = self.view(bytes(offset) + b"".join(rows), stride)
        accessor = {"bufferView": view, "byteOffset": offset, "componentType": KINDS[kind], "count": len(array)}
        self.tree["accessors"].append(accessor | {"type": shape} | more)
        return len(self.tree["accessors"]) - 1

    def bytes(self, inside: bool = True) -> bytes:
        self.tree["buffers"] = [{"byteLength": len(self.numbers)}]
        if not inside:
            uri = base64.b64encode(bytes(self.numbers)).decode()
            self.tree["buffers"][0]["uri"] = f"data:application/octet-stream;base64,{uri}"
        text = json.dumps(self.tree).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<I", len(text)) + b"JSON" + text
        if inside:
            numbers = bytes(self.numbers) + bytes(-len(self.numbers) % 4)
            chunks += struct.pack("<I", len(numbers)) + b"BIN\0" + numbers
        return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks


def place(rng: np.random.Generator) -> tuple[dict, np.ndarray]:
    """A node's transform, as glTF tells it and as a matrix."""
    way = rng.integers(4)
    if way == 0:
        return {}, np.eye(4)
    quaternion = rng.standard_normal(4)
    quaternion /= np.linalg.norm(quaternion)
    translation = rng.standard_normal(3) * 3
    scale = np.full(3, rng.uniform(0.5, 2)) if way < 3 else rng.uniform(0.5, 2, 3) * [1, 1, -1]
    turn = trimesh.transformations.quaternion_matrix(quaternion[[3, 0, 1, 2]])
    matrix = trimesh.transformations.translation_matrix(translation) @ turn @ np.diag([*scale, 1])
    if way == 1:
        return {"matrix": matrix.T.ravel().tolist()}, matrix
    return {"translation": translation.tolist(), "rotation": quaternion.tolist(), "scale": scale.tolist()}, matrix


def moved(points: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    return points @ matrix[:3, :3].T + matrix[:3, 3]


@pytest.fixture
def write(draft):
    def make(rng):
        builder = Builder(rng)
        tree = builder.tree
        shape = draft(rng, exact=False, polygons=False)
        vertices, faces = shape.vertices, np.array(shape.polygons)
        primitive, mesh, node = {"attributes": {}}, {}, {}
        form = rng.choice(["plain", "plain", "quantised", "sparse", "morph", "skin"])
        written = vertices.astype(np.float32).astype(np.float64)
        if form == "quantised":
            middle, half = vertices.mean(axis=0), np.abs(vertices - vertices.mean(axis=0)).max()
            whole = np.round((vertices - middle) / half * 32767)
            primitive["attributes"]["POSITION"] = builder.array(whole, "i2", normalized=True)
            tree["extensionsUsed"] = tree["extensionsRequired"] = ["KHR_mesh_quantization"]
            written = whole / 32767
        elif form == "sparse":
            some = np.sort(rng.permutation(len(vertices))[:20])
            base = vertices.copy()
            base[some] += 9
            number = builder.array(base, "f4")
            tree["accessors"][number]["sparse"] = {
                "count": 20,
                "indices": {"bufferView": builder.view(some.astype("<u2").tobytes()), "componentType": KINDS["u2"]},
                "values": {"bufferView": builder.view(vertices[some].astype("<f4").tobytes())},
            }
            primitive["attributes"]["POSITION"] = number
        elif form == "morph":
            # Vertices at one place stay together: a seam that opens is another shape.
            place_of = np.unique(vertices.astype(np.float32), axis=0, return_inverse=True)[1].ravel()
            way = (0.01 * rng.standard_normal((len(vertices), 3))[place_of]).astype(np.float32)
            primitive["attributes"]["POSITION"] = builder.array(vertices, "f4")
            primitive["targets"] = [{"POSITION": builder.array(way, "f4")}] * 2
            mesh["weights"] = [0, 0.5]
            written = written + 0.5 * way.astype(np.float64)
        else:
            primitive["attributes"]["POSITION"] = builder.array(vertices, "f4")
        if rng.random() < 0.5:
            primitive["attributes"]["NORMAL"] = builder.array(np.ones((len(vertices), 3)), "f4")

        kind = str(rng.choice(["u1", "u2", "u4"])) if len(vertices) < 256 else str(rng.choice(["u2", "u4"]))
        layout = rng.choice(["list", "list", "strip", "none", "parts"])
        if layout == "none" and form == "plain":
            primitive["attributes"] = {"POSITION": builder.array(vertices[faces].reshape(-1, 3), "f4")}
            primitives = [primitive]
        elif layout == "strip" and len(faces) < 400:
            strip: list[int] = []
            for a, b, c in faces.tolist():  # corners twice join the triangles, each beginning at an even place
                strip += [*strip[-1:], a] if strip else []
                strip += [a] if len(strip) % 2 else []
                strip += [a, b, c]
            primitives = [primitive | {"indices": builder.array(np.array(strip), kind), "mode": 5}]
        elif layout == "parts":  # two materials
            primitives = [
                primitive | {"indices": builder.array(part.ravel(), kind)} for part in np.array_split(faces, 2)
            ]
        else:
            primitives = [primitive | {"indices": builder.array(faces.ravel(), kind)}]
        if rng.random() < 0.2:
            primitives.append(
                {"attributes": {"POSITION": builder.array(vertices[:4], "f4")}, "mode": int(rng.choice([0, 1, 3]))}
            )
        tree["meshes"].append(mesh | {"primitives": primitives})

        told, matrix = place(rng)
        node |= told | {"mesh": 0}
        above, outer = place(rng)
        tree["nodes"] = [node, above | {"children": [0]}]
        matrix = outer @ matrix
        roots = [1]
        if form == "skin":
            joint, there = place(rng)
            tree["nodes"].append(joint)
            bind = place(rng)[1]
            tree["skins"] = [{"joints": [2], "inverseBindMatrices": builder.array(bind.T.reshape(1, 16), "f4")}]
            node["skin"] = 0
            weights = np.tile([1.0, 0, 0, 0], (len(vertices), 1))
            for p in tree["meshes"][0]["primitives"]:
                n = tree["accessors"][p["attributes"]["POSITION"]]["count"]
                p["attributes"] |= {
                    "JOINTS_0": builder.array(np.zeros((n, 4)), "u1"),
                    "WEIGHTS_0": builder.array(np.resize(weights, (n, 4)), "f4"),
                }
            matrix, roots = there @ bind.astype(np.float32), [1, 2]
        if rng.random() < 0.2:
            tree["nodes"].append({"mesh": 0, "translation": [100, 0, 0]})  # outside the scene
            tree["scenes"], tree["scene"] = [{"nodes": [len(tree["nodes"]) - 1]}, {"nodes": roots}], 1
        elif rng.random() < 0.8:
            tree["scenes"], tree["scene"] = [{"nodes": roots}], 0
        if rng.random() < 0.2:
            tree["extensionsUsed"] = [*tree.get("extensionsUsed", []), "KHR_materials_unlit"]
        data = builder.bytes(inside=rng.random() < 0.8)
        return data, shape.expected(moved(written, matrix)), f"{form} {layout} {kind}"

    return make


def test_some_files(sweep, write):
    sweep(".glb", write, 12, seed=0).check(least=0.99)


@pytest.mark.slow
def test_many_files(sweep, write):
    sweep(".glb", write, 400, seed=1).check(least=0.99)


BOX = trimesh.creation.box()


def boxes(**change) -> bytes:
    """A box twice in a scene, the second one five units away and mirrored."""
    builder = Builder(np.random.default_rng(1))
    primitive = {
        "attributes": {"POSITION": builder.array(BOX.vertices, "f4")},
        "indices": builder.array(BOX.faces.ravel(), "u2"),
    }
    builder.tree["meshes"] = [{"primitives": [primitive | change.pop("primitive", {})]}]
    builder.tree["nodes"] = [{"mesh": 0}, {"mesh": 0, "translation": [5, 0, 0], "scale": [-1, 1, 1]}]
    builder.tree |= change
    return builder.bytes()


def test_objects_of_a_scene_are_placed_and_none_is_turned_inside_out(tmp_path):
    (tmp_path / "a.glb").write_bytes(boxes())
    mesh = load(tmp_path / "a.glb")
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), [6, 1, 1])
    a, b, c = mesh.vertices[mesh.faces.T]
    np.testing.assert_allclose(np.einsum("fx,fx->", a, np.cross(b, c)) / 6, 2)
    np.testing.assert_allclose(clean(mesh).piece_areas, [6, 6])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"extensionsRequired": ["KHR_draco_mesh_compression"]}, "it needs the extension KHR_draco_mesh_compression"),
        ({"extensionsUsed": ["EXT_mesh_gpu_instancing"]}, "it places objects by EXT_mesh_gpu_instancing"),
        ({"primitive": {"extensions": {"KHR_draco_mesh_compression": {}}}}, "an object comes in the form KHR_draco"),
        ({"primitive": {"attributes": {}}}, "an object without positions"),
        ({"scenes": [{"nodes": [0, 7]}]}, "it names node 7, 2 are there"),
        ({"nodes": [{"mesh": 0, "children": [0]}], "scenes": [{"nodes": [0]}]}, "node 0 stands in its scene twice"),
    ],
)
def test_refused(tmp_path, change, message):
    (tmp_path / "a.glb").write_bytes(boxes(**change))
    with pytest.raises(InputError, match=message):
        load(tmp_path / "a.glb")


def test_a_cut_file_is_refused(tmp_path):
    (tmp_path / "a.glb").write_bytes(boxes()[:-4])
    with pytest.raises(InputError, match=r"it announces [\d,]+ bytes, [\d,]+ are there"):
        load(tmp_path / "a.glb")
