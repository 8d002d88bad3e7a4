"""Light on several faces at each of some places in the open, for the truths of harmonics."""

import numpy as np

from skyshine.mat.quantities.facet_light import Facets, light_among_walls


def facet_irradiance(air, altitude, source_elevation, normal, irradiance, ground_temperature):
    """Irradiance (n, F, P) of F faces with normals (n, F, 3) at each of n places; other arguments by place."""

    def of_faces(values):
        return np.repeat(values, normal.shape[1])

    faces = Facets(normal.reshape(-1, 3), of_faces(ground_temperature))
    light = light_among_walls(air, of_faces(altitude), of_faces(source_elevation), irradiance, faces)
    return light.reshape(*normal.shape[:2], irradiance.size)
