"""Reads every export with libraries that are not ours and compares it with a
plain dump of what should be in it.

    python read_back.py FOLDER DOCS

FOLDER has a folder a case, each with reference.json and the exports; DOCS holds
formats.md, whose snippets are run, and primitives.schema.json.
"""

import copy
import json
import os
import re
import sys
import warnings
from pathlib import Path

import jsonschema
import mujoco
import numpy as np
import plyfile
import trimesh
import yourdfpy
from pypcd4 import PointCloud
from scipy.spatial.transform import Rotation

warnings.filterwarnings("ignore", category=DeprecationWarning)


def same(found, expected, what, atol=0.0):
    found, expected = np.asarray(found), np.asarray(expected)
    assert found.shape == expected.shape, f"{what}: {found.shape} is not {expected.shape}"
    if atol == 0.0:
        assert np.array_equal(found, expected, equal_nan=True), f"{what} differs"
    else:
        np.testing.assert_allclose(found, expected, rtol=0, atol=atol, err_msg=what, equal_nan=True)


class Reference:
    """What should be in the files of a case."""

    def __init__(self, path):
        data = json.loads(path.read_text())
        number = lambda rows: np.array([[np.nan if c is None else c for c in row] for row in rows], float)
        self.points = number(data["points"]).reshape(-1, 3)
        self.labels = np.array(data["labels"], int)
        self.colors = np.array(data["colors"], np.uint8).reshape(-1, 3)
        own = lambda name, kind: None if data[name] is None else np.array(data[name], kind)
        self.normals = own("normals", np.float32)
        self.input_labels = own("input_labels", np.int64)
        self.input_colors = own("input_colors", np.uint8)
        self.mesh = data["mesh"]
        self.primitives = data["primitives"]
        self.density = data["density"]
        self.model_scale = data["model_scale"]

    def scaled(self):
        """The same in metres."""
        metres = copy.copy(self)
        factor = self.model_scale
        lengths = lambda p: {name: [factor * x for x in p[name]] for name in ["scale", "translation"]}
        metres.primitives = [p | lengths(p) | {"volume": factor**3 * p["volume"]} for p in self.primitives]
        return metres


def attributes(ref, get, where):
    """Columns beside the places, by a function from a name to a column."""
    same(get("label"), ref.labels, f"{where}: label")
    for k, name in enumerate(["red", "green", "blue"]):
        same(get(name), ref.colors[:, k], f"{where}: {name}")
        if ref.input_colors is not None:
            same(get(f"input_{name}"), ref.input_colors[:, k], f"{where}: input_{name}")
    if ref.normals is not None:
        for k, name in enumerate(["nx", "ny", "nz"]):
            same(np.asarray(get(name), np.float32), ref.normals[:, k], f"{where}: {name}")
    if ref.input_labels is not None:
        same(get("input_label"), ref.input_labels, f"{where}: input_label")


def check_clouds(folder, ref):
    for name in ["segmented.ply", "text/segmented.ply"]:
        v = plyfile.PlyData.read(folder / name)["vertex"]
        same(np.stack([v["x"], v["y"], v["z"]], 1), ref.points, name)
        attributes(ref, lambda column: v[column], name)
    table = np.genfromtxt(folder / "segmented.csv", delimiter=",", names=True)
    same(np.stack([table["x"], table["y"], table["z"]], 1), ref.points, "csv")
    attributes(ref, lambda column: table[column], "csv")
    head = (folder / "segmented.xyz").read_text().split("\n", 1)[0].removeprefix("# ").split()
    rows = np.loadtxt(folder / "segmented.xyz", ndmin=2)
    same(rows[:, :3], ref.points, "xyz")
    assert head[-1] == "label"
    attributes(ref, lambda column: rows[:, head.index(column)], "xyz")
    for name, single in [("segmented.pcd", True), ("text/segmented.pcd", True), ("doubles.pcd", False)]:
        cloud = PointCloud.from_path(folder / name)
        places = cloud.numpy(("x", "y", "z"))
        assert cloud.pc_data["x"].dtype == (np.float32 if single else np.float64)
        same(places, ref.points.astype(np.float32) if single else ref.points, name)
        same(cloud.pc_data["label"], ref.labels, f"{name}: label")
        same(PointCloud.decode_rgb(cloud.pc_data["rgb"].reshape(-1, 1)), ref.colors, f"{name}: rgb")
        if ref.normals is not None:
            found = np.stack([cloud.pc_data[f"normal_{c}"] for c in "xyz"], 1)
            same(found, ref.normals, f"{name}: normals")
            same(cloud.pc_data["input_label"], ref.input_labels, f"{name}: input_label")
    arrays = np.load(folder / "segmented.npz", allow_pickle=False)
    same(arrays["points"], ref.points, "npz")
    same(arrays["labels"], ref.labels, "npz: labels")
    same(arrays["colors"], ref.colors, "npz: colors")
    same(arrays["ids"], [p["id"] for p in ref.primitives], "npz: ids")
    if ref.normals is not None:
        same(arrays["normals"], ref.normals, "npz: normals")
        same(arrays["input_labels"], ref.input_labels, "npz: input_labels")
        same(arrays["input_colors"], ref.input_colors, "npz: input_colors")


def name_of(label):
    return "unassigned" if label < 0 else f"primitive-{label}"


def areas(vertices, faces, labels):
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return {name_of(l): area[labels == l].sum() for l in np.unique(labels)}


def placed(scene):
    """Meshes of a scene by the names of their nodes, in world coordinates."""
    found = {}
    for node in scene.graph.nodes_geometry:
        transform, name = scene.graph[node]
        mesh = scene.geometry[name].copy()
        mesh.apply_transform(transform)
        found[node] = mesh
    return found


def objects(path):
    """Objects of an OBJ by their names."""
    scene = trimesh.load_scene(path, split_objects=True, group_material=False, process=False)
    return {name.split(".obj")[0]: mesh for name, mesh in placed(scene).items()}


def stl_solids(path):
    """Solids of a text STL by their names."""
    found = {}
    for part in re.split(r"^endsolid.*\n", path.read_text(), flags=re.M):
        if part.strip():
            name = part.split("\n", 1)[0].removeprefix("solid ").strip()
            text = part + f"endsolid {name}\n"
            found[name] = trimesh.load_mesh(trimesh.util.wrap_as_stream(text.encode()), file_type="stl")
    return found


def ply_mesh(path):
    data = plyfile.PlyData.read(path)
    v, f = data["vertex"], data["face"]
    faces = np.stack(f["vertex_indices"]) if len(f) else np.zeros((0, 3), int)
    colors = np.stack([f["red"], f["green"], f["blue"]], 1)
    return np.stack([v["x"], v["y"], v["z"]], 1), faces, f["label"], colors


def stl_binary(path):
    row = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    return np.fromfile(path, row, offset=84)


def colors_of_stl(attribute):
    assert np.all(attribute >> 15 == 1)
    return np.stack([attribute >> 10 & 31, attribute >> 5 & 31, attribute & 31], 1)


def check_mesh(folder, ref):
    vertices = np.array(ref.mesh["vertices"], float)
    faces = np.array(ref.mesh["faces"], int)
    labels = np.array(ref.mesh["labels"], int)
    color = {p["id"]: p["color"] for p in ref.primitives} | {-1: [138] * 3}
    colors = np.array([color[l] for l in labels], np.uint8)
    expected = areas(vertices, faces, labels)
    size = np.ptp(vertices, axis=0).max()
    for name in ["mesh.ply", "text/mesh.ply"]:
        v, f, l, c = ply_mesh(folder / name)
        same(v, vertices, f"{name}: vertices")
        same(f, faces, f"{name}: faces")
        same(l, labels, f"{name}: labels")
        same(c, colors, f"{name}: colours")
    whole = trimesh.load_mesh(folder / "mesh.ply", process=False)
    same(whole.triangles, vertices[faces], "mesh.ply in trimesh")
    parts = {
        "mesh.obj": (objects(folder / "mesh.obj"), 1e-9),
        "mesh.glb": (placed(trimesh.load_scene(folder / "mesh.glb", process=False)), 1e-6),
        "mesh.stl": (stl_solids(folder / "text/mesh.stl"), 1e-9),
    }
    for name, (found, tolerance) in parts.items():
        assert set(found) == set(expected), f"{name}: {set(found)} is not {set(expected)}"
        for part, mesh in found.items():
            assert abs(mesh.area - expected[part]) < 10 * tolerance * size**2, f"{name}: {part}"
    stl = stl_binary(folder / "mesh.stl")
    same(stl["corners"], vertices[faces].astype(np.float32), "mesh.stl")
    same(colors_of_stl(stl["attribute"]), colors >> 3, "mesh.stl: colours")
    # Cut along the boundaries: the same surface, the old vertices first.
    v, f, l, _ = ply_mesh(folder / "split/mesh.ply")
    same(v[: len(vertices)], vertices, "cut vertices")
    assert len(f) > len(faces)
    total = sum(expected.values())
    assert abs(sum(areas(v, f, l).values()) - total) < 1e-9 * total
    for part, area in areas(v, f, l).items():
        assert abs(area - expected.get(part, 0.0)) < 0.1 * total, part


def parameters(p):
    """ε, semi-axes, R, t, k of an entry of the JSON."""
    arrays = [np.array(p[name], float) for name in ["eps", "scale", "rotation", "translation", "taper"]]
    return arrays


def implicit(points, p):
    """ln F of world points, 0 on the surface, from the documented equation."""
    eps, scale, rotation, translation, taper = parameters(p)
    local = (points - translation) @ rotation
    w = local[:, 2] / scale[2]
    x = np.abs(local[:, 0] / np.maximum(1 + taper[0] * w, 1e-300) / scale[0])
    y = np.abs(local[:, 1] / np.maximum(1 + taper[1] * w, 1e-300) / scale[1])
    # H = F^ε1 is of degree two, so that its root is a relative distance.
    xy = (x ** (2 / eps[1]) + y ** (2 / eps[1])) ** (eps[1] / eps[0])
    return (xy + np.abs(w) ** (2 / eps[0])) ** (eps[0] / 2) - 1


def check_parameters(folder, ref, docs):
    schema = json.loads((docs / "primitives.schema.json").read_text())
    jsonschema.Draft202012Validator.check_schema(schema)
    data = json.loads((folder / "primitives.json").read_text())
    jsonschema.validate(data, schema)
    assert data["primitives"] == [{k: v for k, v in p.items() if k in data["primitives"][0]} for p in ref.primitives]
    count = len(ref.primitives)
    all_of = [np.stack(column) for column in zip(*map(parameters, ref.primitives))]
    arrays = np.load(folder / "primitives.npz", allow_pickle=False)
    assert arrays["names"].dtype.kind == "U" and arrays["names"].shape == (1,)
    for name, expected in zip(["exponents", "scale", "rotation", "translation", "tapering"], all_of):
        same(arrays[name], expected[None], f"npz: {name}")
    same(arrays["exist"], np.ones((1, count, 1)), "npz: exist")
    same(arrays["ids"], [[p["id"] for p in ref.primitives]], "npz: ids")
    same(arrays["sigma"], [[p["sigma"] for p in ref.primitives]], "npz: sigma")
    matrix = arrays["assign_matrix"][0]
    assert matrix.shape == (arrays["pc"].shape[1], count)
    same(matrix.sum(0), [p["points"] for p in ref.primitives], "npz: assign_matrix")
    assert set(np.unique(matrix)) <= {0.0, 1.0} and matrix.sum(1).max() <= 1
    rows = np.loadtxt(folder / "primitives.csv", delimiter=",", ndmin=2)
    assert rows.shape == (count, 13)
    eps, scale, rotation, translation, taper = all_of
    same(rows[:, :2], eps, "csv: exponents")
    same(rows[:, 2:5], scale, "csv: semi-axes")
    same(Rotation.from_euler("ZYX", rows[:, 5:8]).as_matrix(), rotation, "csv: angles", atol=1e-14)
    same(rows[:, 8:11], translation, "csv: translation")
    same(rows[:, 11:], taper, "csv: taper")


def check_surfaces(folder, ref):
    by_name = {name_of(p["id"]): p for p in ref.primitives}
    found = {
        "primitives.obj": objects(folder / "primitives.obj"),
        "primitives.glb": placed(trimesh.load_scene(folder / "primitives.glb", process=False)),
        "primitives.stl": stl_solids(folder / "text/primitives.stl"),
    }
    v, f, l, _ = ply_mesh(folder / "primitives.ply")
    found["primitives.ply"] = {
        name_of(k): trimesh.Trimesh(v, f[l == k], process=False) for k in np.unique(l)
    }
    for file, meshes in found.items():
        assert set(meshes) == set(by_name), f"{file}: {set(meshes)}"
        for name, mesh in meshes.items():
            p, where = by_name[name], f"{file}: {name}"
            mesh.remove_unreferenced_vertices()
            assert mesh.is_watertight and mesh.is_winding_consistent, f"{where} is open"
            local = (mesh.vertices - p["translation"]) @ np.array(p["rotation"])
            if abs(local[:, 2] / p["scale"][2]).max() > 1 + 1e-6:
                raise AssertionError(f"{where}: beyond its caps")
            assert abs(mesh.volume / p["volume"] - 1) < 0.03, f"{where}: {mesh.volume} {p['volume']}"
            inner = abs(local[:, 2] / p["scale"][2]) < 0.9
            if inner.any():
                off = np.abs(implicit(mesh.vertices[inner], p)).max()
                assert off < (1e-4 if file.endswith("glb") else 1e-9), f"{where}: off by {off}"
    stl = stl_binary(folder / "primitives.stl")
    faces = {name: len(mesh.faces) for name, mesh in found["primitives.ply"].items()}
    assert len(stl) == sum(faces.values())
    color = [p["color"] for p in ref.primitives for _ in range(faces[name_of(p["id"])])]
    same(colors_of_stl(stl["attribute"]), np.array(color, np.uint8) >> 3, "primitives.stl: colours")


def check_robots(folder, ref):
    robot = yourdfpy.URDF.load(str(folder / "robot.urdf"), load_collision_meshes=True, build_collision_scene_graph=True)
    assert len(robot.link_map) == len(ref.primitives) + 1
    model = mujoco.MjModel.from_xml_path(str(folder / "robot.xml"))
    for p in ref.primitives:
        name = f"primitive_{p['id']}"
        visual = trimesh.load_mesh(folder / f"robot_meshes/{name}.stl")
        hull = trimesh.load_mesh(folder / f"robot_meshes/{name}_collision.stl")
        assert visual.is_watertight and hull.is_watertight, f"{name} is open"
        assert hull.is_convex or hull.volume / hull.convex_hull.volume > 0.9999, f"{name} is not convex"
        visual.density = ref.density
        mass = visual.mass_properties
        inertial = robot.link_map[name].inertial
        found = {"urdf": (inertial.mass, inertial.origin[:3, 3], inertial.inertia)}
        body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name)
        turn = Rotation.from_quat(model.body_iquat[body], scalar_first=True).as_matrix()
        tensor = turn @ np.diag(model.body_inertia[body]) @ turn.T
        found["mjcf"] = (model.body_mass[body], model.body_ipos[body], tensor)
        size = max(p["scale"])
        for file, (weight, center, inertia) in found.items():
            where = f"{file}: {name}"
            assert abs(weight / mass.mass - 1) < 0.03, f"{where}: mass {weight} {mass.mass}"
            assert abs(weight / (p["volume"] * ref.density) - 1) < 1e-9, f"{where}: mass"
            np.testing.assert_allclose(center, mass.center_mass, atol=0.01 * size, err_msg=where)
            scale = np.abs(mass.inertia).max()
            np.testing.assert_allclose(inertia, mass.inertia, atol=0.04 * scale, err_msg=where)
        joint = robot.joint_map[f"{name}_joint"]
        same(joint.origin[:3, :3], p["rotation"], f"{name}: rotation", atol=1e-12)
        same(joint.origin[:3, 3], p["translation"], f"{name}: translation")
        same(model.body_pos[body], p["translation"], f"{name}: pos", atol=1e-12)
        turn = Rotation.from_quat(model.body_quat[body], scalar_first=True).as_matrix()
        same(turn, p["rotation"], f"{name}: quat", atol=1e-12)
        shapes = robot.link_map[name].collisions[0].geometry
        kinds = {k for k in ["box", "cylinder", "sphere", "mesh"] if getattr(shapes, k) is not None}
        assert kinds == {p["urdf"]}, f"{name}: {kinds} is not {p['urdf']}"
        geom = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, f"{name}_collision")
        kind = mujoco.mjtGeom(model.geom_type[geom]).name.removeprefix("mjGEOM_").lower()
        assert kind == p["mjcf"], f"{name}: {kind} is not {p['mjcf']}"
    total = sum(p["volume"] for p in ref.primitives) * ref.density
    assert abs(model.body_subtreemass[1] / total - 1) < 1e-9


def check_fall(folder):
    """Dropped on a plane, the model comes to rest on it."""
    spec = mujoco.MjSpec.from_file(str(folder / "robot.xml"))
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    low = min(
        data.geom_xpos[g][2] - model.geom_rbound[g] for g in range(model.ngeom) if model.geom_contype[g] > 0
    )
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1], pos=[0, 0, low - 0.01])
    model = spec.compile()
    data = mujoco.MjData(model)
    for _ in range(int(6 / model.opt.timestep)):
        mujoco.mj_step(model, data)
    assert np.isfinite(data.qpos).all() and np.isfinite(data.qvel).all()
    assert data.ncon > 0 and np.abs(data.qvel).max() < 0.05, f"still moving: {data.qvel}"


def check_docs(docs, folder, ref):
    """The snippets of the documentation run, and find what they say."""
    text = (docs / "formats.md").read_text()
    snippets = re.findall(r"```python\n(.*?)```", text, flags=re.S)
    assert len(snippets) >= 12, f"{len(snippets)} snippets"
    os.chdir(folder)
    for snippet in snippets:
        names = {}
        try:
            exec(snippet, names)
        except Exception as error:
            raise AssertionError(f"this snippet fails: {error}\n{snippet}") from error
        if "points" in names and "labels" in names:
            same(names["labels"], ref.labels, snippet)
            same(np.asarray(names["points"], np.float32), ref.points.astype(np.float32), snippet)
        if "face_labels" in names:
            same(names["face_labels"], ref.mesh["labels"], snippet)
    return len(snippets)


def main():
    folder, docs = (Path(argument).resolve() for argument in sys.argv[1:])
    for case in sorted(path for path in folder.iterdir() if path.is_dir()):
        ref = Reference(case / "reference.json")
        check_clouds(case, ref)
        check_parameters(case, ref, docs)
        check_surfaces(case, ref)
        check_robots(case, ref)
        check_robots(case / "scaled", ref.scaled())
        done = ["clouds", "parameters", "surfaces", "robots"]
        if ref.mesh is not None:
            check_mesh(case, ref)
            check_fall(case)
            count = check_docs(docs, case, ref)
            done += ["mesh", "a fall", f"{count} snippets"]
        print(f"{case.name}: {', '.join(done)} agree")


if __name__ == "__main__":
    main()
