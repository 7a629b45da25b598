"""Takes and clips as pictures, video, web pages and files.

In: a `Take` or a `Clip`. Out: stills, contact sheets, video, a one-file 3D player, glTF and take
files. `write` chooses by the file's extension; every file appears whole or not at all.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from understudy.output.write import extensions, write

if TYPE_CHECKING:
    from understudy.output.film import Video, video
    from understudy.output.gltf import write_glb
    from understudy.output.pictures import Picture, contact_sheet, still
    from understudy.output.player import player_html, write_player
    from understudy.output.take_file import is_take_file, load_take, save_take

__all__ = [
    "Picture",
    "Video",
    "contact_sheet",
    "extensions",
    "is_take_file",
    "load_take",
    "player_html",
    "save_take",
    "still",
    "video",
    "write",
    "write_glb",
    "write_player",
]

_HOMES = {
    "film": ("Video", "video"),
    "gltf": ("write_glb",),
    "pictures": ("Picture", "contact_sheet", "still"),
    "player": ("player_html", "write_player"),
    "take_file": ("is_take_file", "load_take", "save_take"),
}


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used: each brings different packages."""
    from importlib import import_module

    for home, names in _HOMES.items():
        if name in names:
            value = getattr(import_module(f"{__name__}.{home}"), name)
            globals()[name] = value
            return value
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
