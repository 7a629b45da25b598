"""Controllers that need no clip: athletes. None is here yet.

In: a desired velocity and facing direction. Out: controls for `simulate`.
"""
