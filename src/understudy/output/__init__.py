"""Takes and clips as pictures, video, web pages and files.

In: a `Take` or a `Clip`. Out: stills, contact sheets, video, a one-file 3D player, glTF and take
files. `write` chooses by the file's extension.
"""
