"""Transfer of light: geometry of refracted paths, optical depths, source functions, multiple scattering."""
