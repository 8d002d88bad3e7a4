"""Constants that are choices of a numerical method, not of a formula: tolerances, guards, limits of iteration, nodes.

A fifth more or less of them changes cost and the last digits alone, so that no test can or should notice it.
"""

from __future__ import annotations

import re

from parso.tree import NodeOrLeaf

# Of module constants; those of physics and of formats are left to be changed.
NAMES = re.compile(
    r"""
    TOLERANCE | BOUND_TOLERANCE | MELTING_RANGE | SKY_HEIGHTS | ROUNDING | PRIOR_ROUNDING | RELATIVE_FLOOR |
    GROUND_TEMPERATURES | HEIGHTS | TEMPERATURES | PLANCK_TEMPERATURES | INCIDENCE_ANGLES | ELEVATIONS | PHASE_ANGLES
    | TARGET_HEIGHTS | ABOVE_RISE | SCATTERING_ANGLES | SKY_ELEVATIONS | SOURCE_ELEVATIONS | SCALE_HEIGHT_KM | _FAR |
    _CLEARANCE_KM | _STEEP | _OPAQUE | _LOG_STEP | _SHORTEST_KM | _NEAREST_KM | PENALTY | LIBRARY_PENALTY |
    SPACING | OFFSETS | HIDDEN | LIMIT | LARGEST_BENDING |
    _ARMIJO | _AWAY | _CLEARANCE | _CLOSE | _COLDEST |
    _DIRECTIONS | _EDGE | _EDGE_SHARE | _EDGE_TOLERANCE | _FAINTEST_LIGHT | _FINE_PANEL_RATIO | _FIT_SHARE | _FLOOR |
    _GAS_SHARE | _GROWTH | _HOTTEST | _LARGE | _LARGEST_ALBEDO | _LARGEST_CHANGE | _LARGEST_FACTOR | _LARGEST_STEP |
    _LAST_PART | _LEAST_ELEVATION | _LEAST_SLOPE | _LEAST_TEMPERATURE | _LEVEL | _LEVEL_CUTS | _MAX_ADDED | _NEAR |
    _PANEL_RATIO | _PHASE_WAVELENGTH_RATIO | _RATIO | _ROUNDING | _SEMI_INFINITE_DEPTHS | _SHORT_PATH | _SMALL |
    _SMALLEST_DEPTH | _SMALLEST_SQUARE | _STEP | _STRAY | _STRUCTURE_TOP | _SURFACE_HEIGHTS | _TEMPERATURE_TOLERANCE |
    _THIN | _UNDERFLOW | _UP_NODES | _WATER_TOLERANCE
    """,
    re.VERBOSE,
)
KEYWORDS = frozenset(("atol", "rtol", "tol", "xtol", "ftol", "gtol"))
GUARDS = frozenset(("ceil", "clip", "floor", "max", "maximum", "min", "minimum"))
SMALL, LARGE = 1e-2, 1e5  # constants that guards use; between them, limits are of physics


def is_numerical_choice(number: NodeOrLeaf) -> bool:
    """Whether a constant is a tolerance, a guard or a node.

    Parameters
    ----------
    number : NodeOrLeaf
        Of the syntax tree of a module.
    """
    value = abs(float(eval(number.value)))
    small_or_large = value <= SMALL or value >= LARGE
    node: NodeOrLeaf | None = number
    while (node := node.parent) is not None:
        if node.type == "argument" and node.children[0].type == "name" and node.children[0].value in KEYWORDS:
            return True
        if node.type == "comparison" and small_or_large:
            return True
        if node.type in ("atom_expr", "power") and small_or_large and _called(node) in GUARDS:
            return True
        if node.type == "expr_stmt":
            assigned = node.children[0].get_code().replace(",", " ").split()
            return any(NAMES.fullmatch(name) for name in assigned)
    return False


def _called(call: NodeOrLeaf) -> str:
    """Name of the function that a call calls; empty where none is named."""
    names = [child.get_code() for child in call.children if child.type == "name" or child.get_code().startswith(".")]
    return names[-1].strip().removeprefix(".") if names else ""
