"""Named states, ``atmospheres/presets/NAME.yaml``: what a job's state begins from, key by key."""

from __future__ import annotations

from functools import lru_cache

from skyshine import atmospheres
from skyshine.schemas.documents import read_yaml
from skyshine.schemas.errors import nearest


@lru_cache(maxsize=1)
def presets() -> dict[str, dict]:
    """Each preset's description and keys, by name."""
    files = sorted(atmospheres.path("presets").glob("*.yaml"))
    return {file.stem: read_yaml(file).data for file in files}


def with_preset(state: dict) -> dict:
    """A state with the keys of the preset it names where it does not write them; mappings are joined key by key.

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
    return _joined(base, state)


def _joined(base: dict, over: dict) -> dict:
    both = {
        key: _joined(value, over[key]) if isinstance(value, dict) and isinstance(over.get(key), dict) else over.get(key, value)
        for key, value in base.items()
    }
    return both | {key: value for key, value in over.items() if key not in base}
