"""The functions behind `skyshine.mat` and its commands, one module each, and the small objects that they return."""
