"""Derives `materials/ref/*.csv` from collected source spectra; run by maintainers.

python -m skyshine.mat.materials_build SPECTRA [--out materials/ref] [NAME ...]
"""
