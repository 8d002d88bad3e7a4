"""Named states, ``atmospheres/presets/NAME.yaml``: what a job's state begins from, key by key."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from skyshine import atmospheres
from skyshine.schemas.documents import read_yaml
from skyshine.schemas.errors import nearest

# A state has one of them: what it writes takes the place of the preset's other.
_AMOUNTS_OF_AEROSOL = ("visibility_km", "aerosol_optical_depth")


@lru_cache(maxsize=1)
def presets() -> dict[str, dict[str, Any]]:
    """Each preset's description and keys, by name."""
    files = sorted(atmospheres.path("presets").glob("*.yaml"))
    return {file.stem: read_yaml(file).data for file in files}


def with_preset(state: dict[str, Any]) -> dict[str, Any]:
    """A state with the keys of the preset it names where it does not write them; weather and gases are joined key by
    key.

    Raises
    ------
    ValueError
        There is no such preset.
    """
    name = state.get("preset")
    if name is None:
        return state
    if name not in presets():
        raise ValueError(f"found the preset '{name}'; {nearest(name, presets())}")
    base = {key: value for key, value in presets()[name].items() if key != "description"}
    for key in ("weather", "gases"):
        stated = state.get(key, {})
        if key in base and isinstance(stated, dict):
            # Other kinds of weather take the place of the preset's temperatures.
            dropped = {"air_temperature_c"} if {"hourly", "file"} & stated.keys() else set()
            base[key] = {k: v for k, v in base[key].items() if k not in dropped} | stated
    for amount, alternative in (_AMOUNTS_OF_AEROSOL, _AMOUNTS_OF_AEROSOL[::-1]):
        if state.get(amount) is not None:
            base.pop(alternative, None)
    joined = {key: base[key] for key in ("weather", "gases") if key in base and isinstance(state.get(key, {}), dict)}
    return base | state | joined
