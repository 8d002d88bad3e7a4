"""The YAML job of `mat`: typed models and their reader, weather files, presets, series, trimming."""
