"""Features of texels for classification: colour, texture at several scales, shadow."""
