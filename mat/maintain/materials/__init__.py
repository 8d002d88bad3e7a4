"""Derives `materials/ref/*.csv` from collected source spectra; run by maintainers.

python -m mat.maintain.materials SPECTRA [--out materials/ref] [NAME ...]
"""
