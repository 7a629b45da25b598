"""Controllers that need no clip: athletes, so far one that runs.

In: a desired speed and facing direction, or a path (`course`), and a body. Out: controls for
`simulate`.
"""
