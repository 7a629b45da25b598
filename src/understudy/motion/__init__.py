"""Motion in and out: clips, skeletons, readers, writers, edits, samples; NumPy and SciPy only.

In: files of motion data (`read`), key poses (`keyframed`), names of samples. Out: a `Clip`, in
meters, seconds and radians with z up, with notes on what was detected and changed.
"""
