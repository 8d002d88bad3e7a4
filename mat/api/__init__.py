"""The public functions of `skyshine.mat`, one module each, and the objects that they return."""
