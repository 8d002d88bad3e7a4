"""Derives `materials/ref/*.csv` from collected source spectra; run by maintainers.

python -m skyshine.mat.maintain.materials SPECTRA [--out materials/ref] [NAME ...]
"""
