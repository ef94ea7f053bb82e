"""One file for each engine: a class `Simulation(scene, options, step)` with step(), bodies() and
contacts(), and version(). Only run.py's child processes import them."""
