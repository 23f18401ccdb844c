"""Surroundings of an animation, so that it looks right when it is opened: camera, lights, backdrop, materials.

All of it but the materials stands in a prim beside the result: a stage that references the result gets the particles
and their materials alone.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from pxr import Gf, Sdf, UsdGeom, UsdLux, UsdShade, Vt

from warp_mps.usd.animation.colours import srgb_to_linear
from warp_mps.usd.animation.viewpoint import SLOPE, plane_axes, space_axes

if TYPE_CHECKING:
    from warp_mps.scene import StageFrame

SCENERY = "/Scenery"
# width of a picture over its height, and how much more than the scene is in it
ASPECT, MARGIN = 16.0 / 9.0, 1.05
FOCAL_LENGTH = 50.0
# the backdrop, in sizes of the scene
BACKDROP_SIZE = 30.0
BACKDROP_COLOR = (0.78, 0.79, 0.81)
# light per area of what faces it, and the angle that the light fills [deg]: shadows have soft edges
KEY_LIGHT, KEY_ANGLE, SKY_LIGHT = 0.85, 2.0, 0.4
ROUGHNESS = {"body": 0.45, "fluid": 0.2, "wall": 0.7, "backdrop": 0.9}


class Scenery:
    """The surroundings, which grow with the space that the particles have been in.

    The view of a plane is from straight ahead, before a wall; that of a space from obliquely above, on the ground.

    Args:
        stage: The stage; they are defined in it if they are not there.
        frame: How the scene lies in it.
    """

    def __init__(self, stage: Any, frame: StageFrame) -> None:
        up = "XYZ".index(frame.up_axis)
        out_of_plane = [axis for axis in range(3) if "xyz"[axis] not in frame.axes]
        self._axes = plane_axes(out_of_plane[0], up) if out_of_plane else space_axes(up)
        # the backdrop's normal
        self._rise = self._axes[2] if out_of_plane else np.eye(3)[up]
        if not stage.GetPrimAtPath(f"{SCENERY}/Camera"):
            self._define(stage)
        self._camera = UsdGeom.Camera(stage.GetPrimAtPath(f"{SCENERY}/Camera"))
        self._backdrop = UsdGeom.Mesh(stage.GetPrimAtPath(f"{SCENERY}/Backdrop"))
        self._box: np.ndarray | None = None

    def extend_view(self, box: np.ndarray) -> None:
        """Extend the view to include a box.

        Args:
            box: Its corners [stage units], shape [2, 3].
        """
        # ignore a box that is not finite
        if not np.isfinite(box).all():
            return
        old = box if self._box is None else self._box
        new = np.array([np.minimum(old[0], box[0]), np.maximum(old[1], box[1])], dtype=float)
        if self._box is None or not np.array_equal(new, self._box):
            self._box = new
            self._place_camera()
            self._place_backdrop()

    @property
    def _corners(self) -> np.ndarray:
        """Corners of the box, shape [8, 3]."""
        assert self._box is not None
        choices = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij"), axis=-1).reshape(-1, 3)
        return self._box[choices, np.arange(3)]

    def _place_camera(self) -> None:
        corners, middle = self._corners, self._corners.mean(axis=0)
        local = (corners - middle) @ self._axes.T
        size = max(float(np.linalg.norm(np.ptp(corners, axis=0))), 1e-6)
        # a plane is seen without distortion from any distance
        distance = 0.5 * size / SLOPE
        # half the width and half the height of the picture, at a distance of one
        reach = np.abs(local[:, :2]) / (distance - local[:, 2:])
        across = MARGIN * max(float(reach[:, 0].max()), ASPECT * float(reach[:, 1].max()), 1e-6)
        camera = self._camera
        camera.CreateFocalLengthAttr(FOCAL_LENGTH)
        camera.CreateHorizontalApertureAttr(2.0 * across * FOCAL_LENGTH)
        camera.CreateVerticalApertureAttr(2.0 * across * FOCAL_LENGTH / ASPECT)
        camera.CreateClippingRangeAttr(Gf.Vec2f(0.01 * distance, distance + 2.0 * BACKDROP_SIZE * size))
        camera.CreateFocusDistanceAttr(distance)
        matrix = np.eye(4)
        matrix[:3, :3] = self._axes
        matrix[3, :3] = middle + distance * self._axes[2]
        camera.GetOrderedXformOps()[0].Set(Gf.Matrix4d(matrix))

    def _place_backdrop(self) -> None:
        """Place the backdrop behind a plane scene, or below a 3-D scene."""
        corners, middle = self._corners, self._corners.mean(axis=0)
        axis = int(np.abs(self._rise).argmax())
        size = max(float(np.linalg.norm(np.ptp(corners, axis=0))), 1e-6)
        behind = float((corners @ self._rise).min()) - 1e-3 * size
        sides = np.eye(3)[[(axis + 1) % 3, (axis + 2) % 3]] * 0.5 * BACKDROP_SIZE * size
        start = middle + (behind - middle @ self._rise) * self._rise
        points = np.array([start + a * sides[0] + b * sides[1] for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
        points = points.astype(np.float32)
        self._backdrop.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points))
        extent = np.array([points.min(axis=0), points.max(axis=0)])
        self._backdrop.CreateExtentAttr(Vt.Vec3fArray.FromNumpy(extent))

    def _define(self, stage: Any) -> None:
        # an animation with a local origin has made a prim that is moved there
        if not stage.GetPrimAtPath(SCENERY):
            UsdGeom.Scope.Define(stage, SCENERY)
        UsdGeom.Camera.Define(stage, f"{SCENERY}/Camera").AddTransformOp()
        backdrop = UsdGeom.Mesh.Define(stage, f"{SCENERY}/Backdrop")
        backdrop.CreateFaceVertexCountsAttr([4])
        backdrop.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
        backdrop.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
        backdrop.CreateDoubleSidedAttr(True)
        # interactive viewers leave out prims with purpose render, and so centre the particles
        backdrop.CreatePurposeAttr(UsdGeom.Tokens.render)
        paint(backdrop, "backdrop", BACKDROP_COLOR)
        self._define_lights(stage)

    def _define_lights(self, stage: Any) -> None:
        """A sun over the left shoulder of the viewer, and a bright sky."""
        key = UsdLux.DistantLight.Define(stage, f"{SCENERY}/Key")
        # its light does not depend on its angle
        key.CreateNormalizeAttr(True)
        key.CreateIntensityAttr(KEY_LIGHT)
        key.CreateAngleAttr(KEY_ANGLE)
        towards = np.array([-0.6, 0.8, 1.0]) @ self._axes
        matrix = np.eye(4)
        matrix[:3, :3] = space_axes("XYZ".index(str(UsdGeom.GetStageUpAxis(stage))), towards)
        key.AddTransformOp().Set(Gf.Matrix4d(matrix))
        sky = UsdLux.DomeLight.Define(stage, f"{SCENERY}/Sky")
        sky.CreateIntensityAttr(SKY_LIGHT)
        # written although it is the default: some programs use a colour of their own without it
        sky.CreateColorAttr(Gf.Vec3f(1.0))


def paint(shape: Any, role: str, color: tuple[float, float, float]) -> None:
    """Give a shape its colour, and a material that shows its displayColor.

    Args:
        shape: A `UsdGeom.Gprim`.
        role: One of `ROUGHNESS`.
        color: sRGB colour from 0 to 1.
    """
    light = [float(part) for part in srgb_to_linear(color)]
    shape.CreateDisplayColorPrimvar(UsdGeom.Tokens.constant).Set([Gf.Vec3f(*light)])
    stage, path, types = shape.GetPrim().GetStage(), shape.GetPath().AppendChild("Paint"), Sdf.ValueTypeNames
    material = UsdShade.Material.Define(stage, path)
    reader = UsdShade.Shader.Define(stage, path.AppendChild("Colour"))
    reader.CreateIdAttr("UsdPrimvarReader_float3")
    reader.CreateInput("varname", types.String).Set("displayColor")
    reader.CreateInput("fallback", types.Float3).Set(Gf.Vec3f(*light))
    surface = UsdShade.Shader.Define(stage, path.AppendChild("Surface"))
    surface.CreateIdAttr("UsdPreviewSurface")
    surface.CreateInput("roughness", types.Float).Set(ROUGHNESS[role])
    color_input = surface.CreateInput("diffuseColor", types.Color3f)
    color_input.ConnectToSource(reader.CreateOutput("result", types.Float3))
    material.CreateSurfaceOutput().ConnectToSource(surface.CreateOutput("surface", types.Token))
    UsdShade.MaterialBindingAPI.Apply(shape.GetPrim()).Bind(material)
