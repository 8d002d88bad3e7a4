"""Frames as files: apparent temperature in 16 bits, radiance in EXR, counts of a sensor."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import numpy.typing as npt

from skyshine.mat.job.fields import clock_text
from skyshine.mat.render.frames import Picture
from skyshine.mat.render.scene_file import Sensor
from skyshine.mat.runtime.pixel import pixel_value
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError
from skyshine.schemas.whole_files import part_file

VALUES_PER_KELVIN = 100  # values per kelvin of the 16-bit PNG: 10 mK a step, 0 to 655.35 K
HIGHEST = (1 << 16) - 1  # largest value of 16 bits
RENDERED = "rendered"


def picture_folder(beside: Path, out: str | os.PathLike[str] | None) -> Path:
    """The folder of pictures: a given one, or `rendered` beside the file that describes them; made where it lacks.

    Raises
    ------
    InputError
        It cannot be made.
    """
    folder = beside / RENDERED if out is None else Path(out)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot be made: {error.strerror}; name another with --out", file=folder) from None
    return folder


def frame_files(folder: Path, scene: str, frame: Picture, sensor: Sensor | None) -> list[Path]:
    """Write the files of a frame; the names contain scene, band and time.

    Returns
    -------
    list of Path
        ``..._kelvin.png`` with 100 values a kelvin, ``..._radiance.exr`` with W m^-2 sr^-1, and ``..._counts.png`` by
        equation (44) where there is a sensor.

    Raises
    ------
    InputError
        A file cannot be written.
    """
    stem = f"{scene}_{frame.band}_{clock_text(frame.hour).replace(':', '')}"
    notes: dict[str, str | float] = {
        "skyshine:scene": scene,
        "skyshine:band": frame.band,
        "skyshine:local_clock_h": float(frame.hour),
    }
    kelvin = folder / f"{stem}_kelvin.png"
    _write(kelvin, kelvin_values(frame.apparent_temperature), notes | {"skyshine:values_per_kelvin": 100.0})
    radiance = folder / f"{stem}_radiance.exr"
    _write(radiance, frame.radiance.astype(np.float32), notes | {"skyshine:units": "W m^-2 sr^-1"})
    files = [kelvin, radiance]
    if sensor is not None:
        counts = pixel_value(
            frame.radiance,
            bits=sensor.bits,
            gain=sensor.gain,
            buffer_gain=sensor.buffer_gain,
            offset=sensor.offset,
        )
        files.append(folder / f"{stem}_counts.png")
        _write(files[-1], counts.astype(np.uint16), notes | {"skyshine:bits": float(sensor.bits)})
    return files


def kelvin_values(temperature: Floats) -> npt.NDArray[np.uint16]:
    """Values of the 16-bit PNG, the nearest to 100 times the temperature [K], 0 to 65535."""
    return np.clip(np.rint(VALUES_PER_KELVIN * temperature), 0, HIGHEST).astype(np.uint16)


def _write(path: Path, values: npt.NDArray[np.uint16] | npt.NDArray[np.float32], notes: dict[str, str | float]) -> None:
    """One channel as it is, without conversion to a colour space."""
    import OpenImageIO as oiio

    rows, columns = values.shape
    spec = oiio.ImageSpec(columns, rows, 1, "uint16" if values.dtype == np.uint16 else "float")
    spec.channelnames = ("Y",)
    for name, note in notes.items():
        spec.attribute(name, note)
    part = part_file(path).with_suffix(path.suffix)
    output = oiio.ImageOutput.create(path.suffix.removeprefix("."))
    if output is None:
        raise InputError(f"cannot be written: {oiio.geterror()}; install OpenImageIO again", file=path)
    try:
        success = output.open(str(part), spec) and output.write_image(np.ascontiguousarray(values)[..., None])
        if not (output.close() and success):
            raise InputError(f"cannot be written: {output.geterror()}; check free space and permissions", file=path)
        os.replace(part, path)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}; check free space and permissions", file=path) from None
    finally:
        part.unlink(missing_ok=True)
