"""Scenes of the suite in engines for rigid bodies, judged as our own motions are: from their states
alone. One file of engines/ for each engine, judge.py for what is measured, run.py for the rows."""
