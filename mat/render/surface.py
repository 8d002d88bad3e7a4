"""The surface of a scene from its plan or its mesh, with the materials that cover it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.render.gltf_surface import mesh_surface
from skyshine.mat.render.plan_surface import plan_surface
from skyshine.mat.render.scene_file import LoadedScene
from skyshine.mat.render.surface_mesh import SurfaceMesh
from skyshine.schemas.arrays import Floats, Integers
from skyshine.tmm.database.reader import TmmFile, open_tmm

PARTS = 3  # materials of a texel at most


def surface_of_scene(scene: LoadedScene) -> SurfaceMesh:
    """The triangles of a scene.

    Raises
    ------
    InputError
        A file of the surface cannot be read or does not fit.
    """
    plan, mesh = scene.model.surface.plan, scene.model.surface.mesh
    if plan is not None:
        return plan_surface(scene, plan)
    assert mesh is not None
    return mesh_surface(scene, mesh)


@dataclass(frozen=True, eq=False)
class Mixtures:
    """Materials of n points, each a mixture of some.

    Attributes
    ----------
    names : tuple of str
        K materials.
    number : (n, M) int array
        Index into `names`, K more for the same in the shade of the photograph; 0 where unused.
    share : (n, M) array
        They sum to 1 for each point. M is `PARTS`, twice as many where a texture has shade.
    """

    names: tuple[str, ...]
    number: Integers
    share: Floats


class SurfaceMaterials:
    """The coverings of a surface, with their textures open.

    Attributes
    ----------
    names : tuple of str
        All materials that they name or contain, each once.
    places : dict of str to tuple
        Key of the scene file that each comes from.
    shaded_sky : (2 K,) array
        Open share of the sky above materials that are in the shade all day, not a number for others; then the same
        where the photograph shows them in the shade.
    """

    def __init__(self, scene: LoadedScene, surface: SurfaceMesh) -> None:
        self._scene, self._surface = scene, surface
        self._textures: dict[int, TmmFile] = {}
        self._replaced = scene.model.surface.replaced_materials
        unknown = scene.model.surface.unknown_material
        self._unknown = None if unknown is None else self._shown(unknown)
        keys: dict[str, tuple[str | int, ...]] = {}
        if self._unknown is not None:
            keys[self._unknown] = ("surface", "unknown_material")
        for number, covering in enumerate(surface.coverings):
            if covering.texture is None:
                keys.setdefault(self._shown(str(covering.material)), covering.place)
                continue
            self._textures[number] = open_tmm(covering.texture)
            for name, share in self._textures[number].usage.items():
                if share > 0:
                    keys.setdefault(self._shown(name), covering.place)
        self.names, self.places = tuple(keys), keys
        open_shares = self._shaded_sky()
        self.shaded_sky = np.concatenate([open_shares, np.fmin(open_shares, scene.model.surface.shaded_sky)])

    @property
    def in_shade(self) -> bool:
        """Whether anything may be in the shade all day, by its material or by the photograph."""
        by_photograph = any(texture.has_shade for texture in self._textures.values())
        return by_photograph or bool(self._scene.model.surface.shaded_materials)

    def _shaded_sky(self) -> Floats:
        open_sky = np.full(len(self.names), np.nan)
        for name, share in self._scene.model.surface.shaded_materials.items():
            if self._shown(name) not in self.names:
                raise self._scene.error(
                    ("surface", "shaded_materials", name),
                    f"found '{name}'; allowed: the materials of the surface: {', '.join(self.names)}",
                )
            open_sky[self.names.index(self._shown(name))] = share
        return open_sky

    def _shown(self, name: str) -> str:
        """Material that replaces one of the surface."""
        return self._replaced.get(name, name)

    def textures(self) -> dict[int, TmmFile]:
        """Open textures by the number of their covering."""
        return dict(self._textures)

    def texel_size(self, number: int) -> Floats:
        """Side of a texel of level 0 on each face (F,) [m]; of faces of another covering 0."""
        surface, size = self._surface, np.zeros(len(self._surface.triangles))
        if number in self._textures:
            selected = surface.covering == number
            edges = surface.uv[selected, 1:] - surface.uv[selected, :1]
            texels = self._textures[number].width * self._textures[number].height
            covered = 0.5 * np.abs(edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0]) * texels
            size[selected] = np.sqrt(surface.area[selected] / np.maximum(covered, 1e-12))
        return size

    def at(self, face: Integers, weights: Floats, footprint: Floats) -> Mixtures:
        """Mixtures at points on faces.

        Parameters
        ----------
        face : (n,) int array
        weights : (n, 3) array
            Barycentric weights of the corners.
        footprint : (n,) array
            Side of the pixel on the surface [m]: a texture is read at the mip level of that size.

        Raises
        ------
        InputError
            A texel has no material, and the scene names none for such texels.
        """
        number = np.zeros((len(face), PARTS), int)
        share = np.zeros((len(face), PARTS))
        share[:, 0] = 1.0
        shade = np.zeros(len(face))
        covering = self._surface.covering[face]
        for index, kind in enumerate(self._surface.coverings):
            rows = np.flatnonzero(covering == index)
            if not rows.size:
                continue
            if index not in self._textures:
                number[rows, 0] = self.names.index(self._shown(str(kind.material)))
                continue
            uv = self._surface.texture_coordinates(face[rows], weights[rows])
            size = self.texel_size(index)[face[rows]]
            number[rows], share[rows], shade[rows] = self._of_texture(index, uv, footprint[rows] / size)
            unknown = share[rows].sum(axis=-1) == 0
            if unknown.any():
                self._refuse_unknown(index, int(unknown.sum()))
                share[rows[unknown], 0] = 1.0  # the first name is that of texels without material
        if shade.any():
            sunlit = 1.0 - shade[:, None]
            number = np.concatenate([number, number + len(self.names)], axis=1)
            share = np.concatenate([share * sunlit, share * (1.0 - sunlit)], axis=1)
        return Mixtures(self.names, number, share)

    def of_faces(self, face: Integers) -> Integers:
        """Number of the material that covers most of each face (n,), as `Mixtures` has it; -1 where none is known."""
        number = np.zeros(len(face), int)
        centre, covering = np.full((len(face), 3), 1 / 3), self._surface.covering[face]
        for index, kind in enumerate(self._surface.coverings):
            rows = np.flatnonzero(covering == index)
            if index not in self._textures:
                number[rows] = self.names.index(self._shown(str(kind.material)))
            elif rows.size:
                uv = self._surface.texture_coordinates(face[rows], centre[rows])
                texels = np.sqrt(self._surface.area[face[rows]]) / self.texel_size(index)[face[rows]]
                materials, share, _ = self._of_texture(index, uv, texels)
                dominant = np.take_along_axis(materials, share.argmax(axis=1)[:, None], axis=1)[:, 0]
                number[rows] = np.where(share.any(axis=1), dominant, -1 if self._unknown is None else 0)
        return number

    def _refuse_unknown(self, index: int, count: int) -> None:
        if self._unknown is None:
            raise self._scene.error(
                self._surface.coverings[index].place,
                f"{count} texels that are seen have no material; give surface.unknown_material, or classify the"
                " texture without unknown texels",
            )

    def _of_texture(self, index: int, uv: Floats, texels: Floats) -> tuple[Integers, Floats, Floats]:
        """Numbers and shares (n, PARTS), and share in the shade (n,), at texture coordinates (n, 2) of pixels so many
        texels wide (n,); all shares are 0 where no material is known.
        """
        texture = self._textures[index]
        # A texture repeats beyond its borders, as glTF does by default; the last border belongs to the last texel.
        wrapped = np.where((uv < -1e-6) | (uv > 1 + 1e-6), uv - np.floor(uv), np.clip(uv, 0.0, 1.0))
        level = np.clip(np.floor(np.log2(np.maximum(texels, 1.0)) + 0.5), 0, texture.levels - 1).astype(int)
        codes, shares, shade = np.zeros((len(uv), PARTS), int), np.zeros((len(uv), PARTS)), np.zeros(len(uv))
        for number in np.unique(level):
            at_level = level == number
            x, y = (wrapped[at_level] * [texture.width, texture.height]).T
            codes[at_level], shares[at_level] = texture.mixture(x, y, int(number))
            shade[at_level] = texture.shade(x, y, int(number))
        numbers = np.zeros(1 + max(texture.materials), int)
        for code, name in texture.materials.items():
            material = self._shown(name)
            numbers[code] = self.names.index(material) if material in self.names else 0
        shares[codes == 0] = 0.0  # a texel without material may give code 0 a share
        total = shares.sum(axis=-1, keepdims=True)
        return np.where(total > 0, numbers[codes], 0), shares / np.where(total > 0, total, 1.0), shade

    def close(self) -> None:
        for texture in self._textures.values():
            texture.close()

    def __enter__(self) -> SurfaceMaterials:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
