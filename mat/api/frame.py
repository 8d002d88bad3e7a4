"""Frames of another renderer as thermal pictures: in memory, or in a folder."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from skyshine.mat.job.fields import clock_text
from skyshine.mat.render.day_picture import MOST, draw_frames, shown_step
from skyshine.mat.render.files import frame_files, picture_folder
from skyshine.mat.render.frame_file import LoadedFrame, load_frame
from skyshine.mat.render.frame_pictures import FrameRenderer
from skyshine.mat.render.frames import Picture
from skyshine.schemas.arrays import Floats
from skyshine.schemas.progress import Progress, silent


class Frame:
    """A frame file: buffers of another renderer (depth, normals, ids) with the materials that they show.

    `schemas/mat-frame.schema.json` describes its keys.

    Parameters
    ----------
    source : path or mapping
        A YAML frame file, or its content.
    folder : path, optional
        Folder to which the paths of a mapping are relative; by default the working directory.

    Attributes
    ----------
    notes : list of str
        What the last pictures took where buffers or tables say nothing.

    Raises
    ------
    InputError
        With `file:line:column` of the first thing that does not fit.

    Examples
    --------
    >>> import skyshine
    >>> frame = skyshine.Frame("carla/frame.yaml")  # doctest: +SKIP
    >>> for mark, picture in frame.pictures():  # doctest: +SKIP
    ...     print(mark, picture.band, picture.apparent_temperature.max())
    """

    def __init__(
        self, source: str | os.PathLike[str] | Mapping[str, Any], *, folder: str | os.PathLike[str] | None = None
    ) -> None:
        self._frame: LoadedFrame = load_frame(source, folder=None if folder is None else Path(folder))
        self.notes: list[str] = []

    @property
    def name(self) -> str:
        return self._frame.model.name

    @property
    def marks(self) -> tuple[str, ...]:
        """What tells the files of the frames apart; one empty text for a single frame."""
        return self._frame.marks

    @property
    def hours(self) -> list[float]:
        """Local clock hours: one for each frame, or several of a single one."""
        return self._frame.hours

    def pictures(self, *, progress: Progress = silent) -> Iterator[tuple[str, Picture]]:
        """Pictures of each frame, hour and band, with what tells the frame apart.

        Raises
        ------
        InputError
            A buffer is wrong, or a database is missing or does not contain what the frame asks for.
        """
        renderer = FrameRenderer(self._frame, progress)
        for mark, picture in renderer.pictures():
            yield mark, picture
            self.notes = renderer.notes
        self.notes = renderer.notes

    def check(self, *, progress: Progress = silent) -> None:
        """Read all frames as `pictures` does, and compute no radiance.

        Raises
        ------
        InputError
            Those of `pictures`.
        """
        renderer = FrameRenderer(self._frame, progress)
        renderer.check()
        self.notes = renderer.notes

    def render(self, out: str | os.PathLike[str] | None = None, *, progress: Progress = silent) -> list[Path]:
        """Write the pictures as `mat render --buffers` does.

        Parameters
        ----------
        out : path, optional
            Folder; by default `rendered` beside the frame file.
        progress : callable, optional
            ``progress(total, text)`` is a context manager that gives a callable to count with.

        Returns
        -------
        list of Path
            A picture of at most 16 of them for each band, then the files of each.
        """
        folder = picture_folder(self._frame.folder, out)
        stride = -(-len(self.hours) // MOST)
        panels: dict[str, list[Floats]] = {}
        titles: dict[int, tuple[str, float]] = {}
        count, files = Counter[str](), []
        for mark, picture in self.pictures(progress=progress):
            sensor = (self._frame.model.sensors or {}).get(picture.band)
            files += frame_files(folder, f"{self.name}_{mark}" if mark else self.name, picture, sensor)
            number = count[picture.band]
            count[picture.band] += 1
            if number % stride == 0:
                band = f"{picture.wavelength[0]:g} to {picture.wavelength[1]:g} um"
                step = shown_step(*reversed(picture.radiance.shape))
                panels.setdefault(band, []).append(picture.apparent_temperature[::step, ::step])
                titles[number] = f"{mark} {clock_text(picture.hour)}".strip(), picture.sun_elevation
        names, sun = zip(*titles.values(), strict=True)
        overview = draw_frames(panels, names, folder / f"{self.name}_frames.png", sun_elevation=sun)
        return [overview, *files]

    def __repr__(self) -> str:
        return f"<Frame '{self.name}' of {self._frame.document.file}: {len(self.marks)} frames>"
