"""Warnings about a mapped texture for the user of its database."""

from __future__ import annotations

from skyshine.tmm.inputs.seeds import unlabelled
from skyshine.tmm.mapping.texture_map import TextureMap
from skyshine.tmm.mapping.write import Written


def doubts(mapped: TextureMap, summary: Written) -> list[str]:
    """Sentences, one for each thing that is probably not meant; empty where there is none."""
    warnings = list(mapped.texture.intake.warnings)
    if mapped.seeds is not None and len(mapped.seeds.names) == 1:
        warnings.append(
            f"all seeds are of one material, so that every texel becomes {mapped.seeds.names[0]} or unknown; draw seeds"
            " of others"
        )
    if absent := unlabelled(mapped.job, mapped.seeds):
        warnings.append(f"the label image has no texel of {', '.join(absent)}; fine where the texture has none")
    if not summary.texels.any():
        way = {
            "rules": "no rule matches anywhere; compare the limits with the image",
        }
        warnings.append(
            f"no texel has a material: {way.get(mapped.job.way, 'all are below the thresholds of the classifier')}"
        )
    return warnings
