"""Meshes per body and exposed points, and the disk cache that keeps them."""

import time

import numpy as np
import pinocchio as pin
import pytest

from robot_model import DescriptionError, cache, load_robot
from robot_model.exposure import visible_shares
from robot_model.meshes import cluster, find_mesh, read_triangles


def cube(size: float) -> np.ndarray:
    """Twelve triangles around the origin, wound either way as in bad CAD, (12, 3, 3)."""
    halves = [[[x, x, z], [x, 1 - x, z], [1 - x, x, z]] for z in (0, 1) for x in (0, 1)]
    turns = [np.roll(np.eye(3), shift, axis=0) for shift in range(3)]
    return (np.concatenate([halves @ turn for turn in turns]) - 0.5) * size


def write_stl(path, soup) -> None:
    record = np.zeros(len(soup), dtype=[("normal", "<f4", 3), ("p", "<f4", (3, 3)), ("x", "<u2")])
    record["p"] = soup
    path.write_bytes(bytes(80) + np.uint32(len(soup)).tobytes() + record.tobytes())


@pytest.fixture
def boxed(tmp_path, monkeypatch, request):
    """The tiny robot with a 60 mm cube, with a smaller cube inside, for a hand."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    data = request.path.parent / "data"
    for name in ("arm.yaml", "arm.urdf"):
        (tmp_path / name).write_text((data / name).read_text())
    (tmp_path / "meshes").mkdir()
    write_stl(tmp_path / "meshes" / "hand.stl", np.concatenate([cube(60.0), cube(30.0)]))
    return load_robot(tmp_path / "arm.yaml")


def test_binary_and_text_meshes_are_read_alike(tmp_path):
    soup = cube(1.0)
    write_stl(tmp_path / "binary.stl", soup)
    facets = ["facet normal 0 0 0", "outer loop"]
    corner = "vertex {:g} {:g} {:g}".format
    lines = ["solid cube"]
    for triangle in soup:
        lines += [*facets, *(corner(*point) for point in triangle), "endloop", "endfacet"]
    (tmp_path / "text.stl").write_text("\n".join([*lines, "endsolid cube", ""]))
    binary = read_triangles(tmp_path / "binary.stl")
    text = read_triangles(tmp_path / "text.stl")
    np.testing.assert_allclose(binary, soup)
    assert {tuple(np.round(t.ravel(), 6)) for t in text} == {
        tuple(np.round(t.ravel(), 6)) for t in soup
    }


def test_clustering_keeps_shapes_and_drops_what_collapses():
    vertices, triangles = cluster(np.concatenate([cube(1.0), cube(1.0), cube(1e-3) + 0.005]), 0.01)
    assert len(triangles) == 12
    corners = vertices[triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.linalg.norm(cross, axis=1).sum() / 2 == pytest.approx(6.0)


def test_only_the_outer_cube_is_exposed_with_normals_outward(boxed):
    surface = boxed.load_surface()
    assert [body.name for body in surface.bodies] == ["hand"]
    assert surface.link_of(0) == "hand"
    np.testing.assert_allclose(np.abs(surface.points).max(axis=1), 0.030, atol=1e-6)
    flat = np.sort(np.abs(surface.points), axis=1)[:, 1] < 0.024  # away from the edges
    axis = np.abs(surface.points[flat]).argmax(axis=1)[:, None]
    outward = np.take_along_axis(surface.normals[flat], axis, 1) * np.sign(
        np.take_along_axis(surface.points[flat], axis, 1)
    )
    np.testing.assert_allclose(outward, 1.0, atol=1e-6)
    assert len(surface.points) == pytest.approx(6**3 - 4**3, abs=40)  # cells of 10 mm


def test_a_face_behind_another_is_seen_from_one_side_only():
    grid = np.mgrid[0:0.2:0.0025, 0:0.2:0.0025].reshape(2, -1).T
    sheets = [np.c_[grid, np.full(len(grid), z)] for z in (0.0, 0.05)]
    points = np.concatenate(sheets).astype(np.float32)
    normals = np.tile(np.array([0.0, 0.0, 1.0], dtype=np.float32), (len(points), 1))
    shares = visible_shares(points, normals)
    middle = np.all(np.abs(points[:, :2] - 0.1) < 0.02, axis=1)
    lower, upper = middle & (points[:, 2] == 0.0), middle & (points[:, 2] > 0.0)
    assert shares[0, upper].min() > 0.8 and shares[1, lower].min() > 0.8
    assert shares[1, upper].max() < 0.5 and shares[0, lower].max() < 0.5


def test_the_cache_is_used_and_a_damaged_file_is_built_again(boxed, caplog):
    first = boxed.load_surface()
    points = first.points
    files = sorted(cache.cache_directory().glob("*.npz"))
    assert [file.name.split("-")[1] for file in files] == ["meshes", "points"]
    before = [file.stat().st_mtime_ns for file in files]
    np.testing.assert_array_equal(boxed.load_surface().points, points)
    assert [file.stat().st_mtime_ns for file in files] == before
    for damaged in (b"", b"PK\x03\x04 and then nothing", files[1].read_bytes()[:-40]):
        files[1].write_bytes(damaged)
        np.testing.assert_array_equal(boxed.load_surface().points, points)
    assert "damaged and built again" in caplog.text
    assert not list(cache.cache_directory().glob("*.tmp"))


def test_a_changed_mesh_is_not_answered_from_the_cache(boxed):
    assert boxed.load_surface().bodies[0].radius == pytest.approx(0.030 * 3**0.5, rel=1e-6)
    write_stl(boxed.urdf.path.parent / "meshes" / "hand.stl", cube(80.0))
    assert boxed.load_surface().bodies[0].radius == pytest.approx(0.040 * 3**0.5, rel=1e-6)


def test_a_cache_that_cannot_be_written_is_no_obstacle(boxed, monkeypatch, tmp_path, caplog):
    (tmp_path / "file").write_text("not a directory")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert len(boxed.load_surface().bodies) == 1
    assert "cannot keep" in caplog.text


def test_a_missing_mesh_is_named_with_the_places_that_were_searched(boxed, icub):
    with pytest.raises(DescriptionError, match="mesh 'package://a/b.stl' not found in none"):
        find_mesh(boxed, "package://a/b.stl")
    with pytest.raises(DescriptionError, match="mesh 'b.stl' not found in .*iCubGenova04"):
        find_mesh(icub, "b.stl")


def test_every_link_of_icub_has_a_mesh_in_its_own_frame(icub):
    surface = icub.load_surface()
    assert {body.name for body in surface.bodies} == set(icub.links)
    for body in surface.bodies:
        assert body.triangles.max() < len(body.vertices)
        assert body.joint == icub.bodies[body.name].joint
        reach = np.linalg.norm(body.vertices - body.center, axis=1).max()
        assert reach == pytest.approx(body.radius)
        com = icub.bodies[body.name].inertia.lever
        assert np.linalg.norm(com - body.center) < body.radius


def test_exposed_points_of_icub_lie_on_its_meshes_and_face_outward(icub, random):
    surface = icub.load_surface()
    assert 8_000 < len(surface.points) < 20_000
    np.testing.assert_allclose(np.linalg.norm(surface.normals, axis=1), 1.0, atol=1e-9)
    hit = 0
    for index in random.choice(len(surface.points), 100, replace=False):
        body = surface.bodies[surface.body[index]]
        corners = body.vertices[body.triangles]
        point, normal = surface.points[index], surface.normals[index]
        assert distance_to_planes(corners, point) < 1e-6
        hit += ray_hits(corners, point + 0.003 * normal, normal)
    assert hit <= 3  # a straight way out of its own body, but for a few concave places


def test_touchable_links_of_icub_include_all_limbs_at_home(icub):
    """Chest, head, forearms, hands and legs have points that look away from the body."""
    surface = icub.load_surface()
    data = icub.tree.model.createData()
    pin.framesForwardKinematics(icub.tree.model, data, icub.tree.configuration(icub.home))
    counts = np.bincount(surface.body, minlength=len(surface.bodies))
    named = {body.name: count for body, count in zip(surface.bodies, counts, strict=True)}
    sides = [f"{side}_{link}" for side in "lr" for link in ("hand", "forearm", "upper_leg")]
    for link in ("chest", "head", "root_link", *sides):
        assert named[link] > 200, link
    chest = [i for i in range(len(surface.points)) if surface.link_of(i) == "chest"]
    rotation = data.oMf[icub.tree.frame_id("chest")].rotation
    looks = surface.normals[chest] @ rotation.T
    assert looks[:, 0].min() < -0.9 and looks[:, 0].max() > 0.9  # front and back


def test_a_second_load_is_quick(icub):
    assert len(icub.load_surface().points)
    start = time.process_time()
    assert len(load_robot("icub").load_surface().points)
    assert time.process_time() - start < 0.3


def distance_to_planes(corners, point):
    """Distance to the nearest plane of a triangle whose vertices are near, m."""
    near = np.linalg.norm(corners - point, axis=2).min(axis=1) < 0.05
    a, b, c = np.moveaxis(corners[near], 1, 0)
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    return np.abs(np.einsum("ni,ni->n", point - a, normals)).min()


def ray_hits(corners, origin, direction):
    a, b, c = np.moveaxis(corners, 1, 0)
    cross = np.cross(direction, c - a)
    slope = np.einsum("ni,ni->n", b - a, cross)
    scale = 1.0 / np.where(np.abs(slope) < 1e-15, np.inf, slope)
    u = scale * np.einsum("ni,ni->n", origin - a, cross)
    across = np.cross(origin - a, b - a)
    v, t = scale * (across @ direction), scale * np.einsum("ni,ni->n", c - a, across)
    return bool(((u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0)).any())
