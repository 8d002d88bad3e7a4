"""Names of the arrays of the film of water on surfaces, in a ``.htt`` database."""

LOSS, EVAPORATION = "film_heat_loss", "film_evaporation"
SUNLIGHT, DRY_SUNLIGHT = "film_sunlight", "absorbed_sunlight"
BEFORE, CAPACITY, RAIN = "film_before", "film_capacity", "rain"
FILM = (LOSS, EVAPORATION, SUNLIGHT, DRY_SUNLIGHT, CAPACITY, RAIN)  # all or none in a file
