"""A scene from built databases: frames in memory, pictures in a folder, the contrast of two materials."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from skyshine.mat.job.fields import clock_text
from skyshine.mat.render.day_picture import animate, draw_frames, photograph, shown_step
from skyshine.mat.render.files import frame_files, picture_folder
from skyshine.mat.render.frames import Picture, Renderer
from skyshine.mat.render.scene_file import LoadedScene, load_scene
from skyshine.schemas.arrays import Floats
from skyshine.schemas.progress import Progress, silent


class Scene:
    """A scene file with its surface and camera; see `schemas/mat-scene.schema.json` for its keys.

    Parameters
    ----------
    source : path or mapping
        A YAML scene, or its content.
    folder : path, optional
        Folder to which the paths of a mapping are relative; by default the working directory.

    Raises
    ------
    InputError
        With `file:line:column` of the first thing that does not fit.

    Examples
    --------
    >>> import skyshine.mat
    >>> scene = skyshine.mat.Scene("demo/scene.yaml")  # doctest: +SKIP
    >>> frame = next(scene.frames())  # doctest: +SKIP
    >>> frame.apparent_temperature.mean()  # doctest: +SKIP
    """

    def __init__(
        self, source: str | os.PathLike[str] | Mapping[str, Any], *, folder: str | os.PathLike[str] | None = None
    ) -> None:
        self._scene: LoadedScene = load_scene(source, folder=None if folder is None else Path(folder))

    @property
    def name(self) -> str:
        return self._scene.model.name

    @property
    def hours(self) -> list[float]:
        """Local clock hours of the frames."""
        return self._scene.hours

    def frames(self, *, progress: Progress = silent) -> Iterator[Picture]:
        """Frames for each hour and band: radiance, apparent and surface temperature, range.

        Raises
        ------
        InputError
            A database is missing or does not contain what the scene asks for.
        """
        with Renderer(self._scene, progress) as renderer:
            yield from renderer.frames()

    def render(self, out: str | os.PathLike[str] | None = None, *, progress: Progress = silent) -> list[Path]:
        """Write the frames and the pictures of the day, as `mat render` does.

        Parameters
        ----------
        out : path, optional
            Folder; by default `rendered` beside the scene file.
        progress : callable, optional
            ``progress(total, text)`` is a context manager that gives a callable to count with.

        Returns
        -------
        list of Path
            The picture of the day and the animations, then the files of each frame.
        """
        folder = picture_folder(self._scene.folder, out)
        days: dict[str, list[Floats]] = {}
        titles: dict[str, str] = {}
        sun: dict[float, float] = {}
        step = shown_step(*self._scene.model.camera.size)
        files = []
        for frame in self.frames(progress=progress):
            days.setdefault(frame.band, []).append(frame.apparent_temperature[::step, ::step])
            sun[frame.hour] = frame.sun_elevation
            titles[frame.band] = f"{frame.wavelength[0]:g} to {frame.wavelength[1]:g} um"
            files += frame_files(folder, self.name, frame, (self._scene.model.sensors or {}).get(frame.band))
        pictures = [
            draw_frames(
                {titles[band]: frames for band, frames in days.items()},
                [clock_text(hour) for hour in self.hours],
                folder / f"{self.name}_day.png",
                sun_elevation=[sun[hour] for hour in self.hours],
                photograph=photograph(self._scene),
            )
        ]
        if len(self.hours) > 1:
            pictures += [
                animate(frames, self.hours, folder / f"{self.name}_{band}_day_animated.png")
                for band, frames in days.items()
            ]
        return pictures + files

    def __repr__(self) -> str:
        return f"<Scene '{self.name}' of {self._scene.document.file}: {len(self.hours)} hours>"
