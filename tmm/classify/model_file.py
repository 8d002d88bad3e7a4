"""Files of trained classifiers.

Layout of a ``.tmm-model.h5``: ``/materials`` (names), ``/colour`` (means, covariances, priors) and
``/network`` (scaling of the features, weights).
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Axis, Group, Header, Variable, open_database, read_file, write_file
from skyshine.tmm.classify.calibration import OFFSET_LIMIT, SLOPE_LIMIT, Calibration
from skyshine.tmm.classify.gaussian import GaussianModel
from skyshine.tmm.classify.trained import Network, TrainedModel
from skyshine.tmm.features.textured import names
from skyshine.tmm.job.model import PACKAGED

FILETYPE = "tmm-model"
COLOUR_DIMENSIONS = 3  # L*, a*, b*
PRIOR_ROUNDING = 1e-3  # by which stored probabilities, rounded to float32, may miss 1


def model_path(name: str, folder: str | os.PathLike[str]) -> Path:
    """Path of the classifier that a job in `folder` names; `PACKAGED` is the one beside this module."""
    return Path(__file__).with_name("library.tmm-model.h5") if name == PACKAGED else Path(folder, name)


def is_model(path: str | os.PathLike[str]) -> bool:
    """Whether a file that can be read as a database says that it is a trained classifier.

    Raises InputError: the file is missing, damaged or hostile.
    """
    with open_database(path) as file:
        return str(file.attrs["filetype"]) == FILETYPE


def write_model(
    model: TrainedModel, path: str | os.PathLike[str], job: str, data_version: str, quality: dict[str, Any]
) -> str:
    """Write a trained classifier; returns the hash of its content.

    Raises InputError: the file cannot be written.

    job : str; what it was trained on, for the attribute `job`.
    quality : dict; attributes of the group ``/quality``.
    """
    count, size = model.colour.means.shape
    # The material axis repeats in each group, as netCDF readers want it.
    materials = {"material": Axis(np.arange(count, dtype=np.int32), "1", "number of the material")}
    text = Variable(("material",), np.array(model.names, dtype=object), "1", "material name")
    groups = {"materials": Group(materials, {"name": text}), "colour": _colour_group(model.colour, materials, size)}
    groups["network"] = _network_group(model.network, materials)
    attributes = {"slope": model.calibration.slope, "offset": model.calibration.offset}
    groups |= {"calibration": Group(attributes=attributes), "quality": Group(attributes=quality)}
    header = Header(FILETYPE, data_version, job, "Classifier of textures")
    return write_file(path, Group(groups=groups), header)


def _colour_group(colour: GaussianModel, materials: dict[str, Axis], size: int) -> Group:
    axes = {name: Axis(np.arange(size, dtype=np.int32), "1", "coordinate: L*, a*, b*") for name in ("row", "column")}
    return Group(
        materials | axes,
        {
            "mean": Variable(("material", "row"), colour.means, "1", "mean colour"),
            "covariance": Variable(("material", "row", "column"), colour.covariances, "1", "covariance of the colour"),
            "log_prior": Variable(("material",), colour.log_prior, "1", "logarithm of the prior probability"),
        },
    )


def _network_group(network: Network, materials: dict[str, Axis]) -> Group:
    inputs = Axis(np.array(names(), dtype=object), "1", "feature")
    units = Axis(np.arange(len(network.inner_offset), dtype=np.int32), "1", "hidden unit")
    return Group(
        {"feature": inputs, "unit": units} | materials,
        {
            "mean": Variable(("feature",), network.mean, "1", "mean of the feature"),
            "scale": Variable(("feature",), network.scale, "1", "standard deviation of the feature"),
            "inner_weight": Variable(("feature", "unit"), network.inner_weight, "1", "weights of the hidden units"),
            "inner_offset": Variable(("unit",), network.inner_offset, "1", "offsets of the hidden units"),
            "outer_weight": Variable(("unit", "material"), network.outer_weight, "1", "weights of the materials"),
            "outer_offset": Variable(("material",), network.outer_offset, "1", "offsets of the materials"),
        },
    )


def read_model(path: str | os.PathLike[str]) -> TrainedModel:
    """Read a trained classifier.

    Raises InputError: the file is missing or damaged, is no classifier, or was trained on other features than this
    version computes.
    """
    root, _ = read_file(Path(path), FILETYPE, verify=True)
    try:
        materials = tuple(root.groups["materials"].variables["name"].data.tolist())
        values = {name: variable.data for name, variable in root.groups["colour"].variables.items()}
        colour = GaussianModel(
            materials, *(values[name].astype(np.float64) for name in ("mean", "covariance", "log_prior"))
        )
        calibration = Calibration(*(float(root.groups["calibration"].attributes[name]) for name in ("slope", "offset")))
        group = root.groups["network"]
        if tuple(group.axes["feature"].values.tolist()) != names():
            raise InputError("was trained on features of another version; train it again with 'tmm train'", file=path)
        network = Network(**{name: variable.data for name, variable in group.variables.items()})
    except (KeyError, TypeError, ValueError):
        raise InputError("lacks a part of a classifier; train it again with 'tmm train'", file=path) from None
    if problem := _problem(colour, network, calibration):
        raise InputError(f"is damaged ({problem}); train it again with 'tmm train'", file=path)
    return TrainedModel(materials, colour, network, calibration)


def _problem(colour: GaussianModel, network: Network, calibration: Calibration) -> str | None:
    """What makes a classifier unusable; None where it is sound."""
    count = len(colour.names)
    if not count or not all(isinstance(name, str) and name for name in colour.names) or len(set(colour.names)) < count:
        return "its materials do not have one name each"
    dimensions = colour.means.shape[-1] if colour.means.ndim else 0
    if dimensions != COLOUR_DIMENSIONS:
        return f"its colours have {dimensions} coordinates"
    shapes: dict[str, tuple[npt.NDArray[Any], tuple[int, ...]]] = {
        "mean": (colour.means, (count, dimensions)),
        "covariance": (colour.covariances, (count, dimensions, dimensions)),
        "log_prior": (colour.log_prior, (count,)),
    }
    features, units = len(names()), network.inner_offset.size
    shapes |= {
        "network/mean": (network.mean, (features,)),
        "network/scale": (network.scale, (features,)),
        "network/inner_weight": (network.inner_weight, (features, units)),
        "network/inner_offset": (network.inner_offset, (units,)),
        "network/outer_weight": (network.outer_weight, (units, count)),
        "network/outer_offset": (network.outer_offset, (count,)),
    }
    for name, (values, shape) in shapes.items():
        if values.dtype.kind != "f" or values.shape != shape:
            return f"{name} is {values.dtype} {values.shape}; allowed: floats {shape}"
        if not np.isfinite(values).all():
            return f"{name} is not finite"
    if (network.scale <= 0).any():
        return "the scale of a feature is not above 0"
    covariances = colour.covariances
    if not np.allclose(covariances, covariances.transpose(0, 2, 1), rtol=1e-5, atol=1e-6 * np.abs(covariances).max()):
        return "a covariance is not symmetric"
    if (np.linalg.eigvalsh(covariances)[:, 0] <= 0).any():
        return "a covariance is not positive definite"
    if abs(np.exp(np.minimum(colour.log_prior, 1)).sum() - 1) > PRIOR_ROUNDING:
        return "the prior probabilities do not sum to 1"
    if not (0 <= calibration.slope <= SLOPE_LIMIT and abs(calibration.offset) <= OFFSET_LIMIT):
        return f"the calibration has slope {calibration.slope:g} and offset {calibration.offset:g}"
    return None
