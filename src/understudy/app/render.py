"""`understudy render`: pictures of a saved take."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from tyro.conf import Positional, arg

from understudy.app.outcome import Outcome
from understudy.app.performing import ready, staged

if TYPE_CHECKING:
    from understudy.take import Take

EXAMPLE = "  understudy render out/gesture.take.npz --video --stills"


@dataclass(frozen=True, kw_only=True)
class Options:
    """Make a video, a contact sheet or an HTML player from a saved take.

    Without --video, --stills or --player, the contact sheet and the player are made.

    Attributes:
        take: A take file, NAME.take.npz.
        out: Folder for the files.
        video: NAME.mp4.
        stills: NAME.png, a contact sheet of reference and simulated poses.
        player: NAME_player.html, a 3D player in one file.
        view: front, three-quarter, side or back; follow-... keeps the body in the middle.
        fixed: The camera of the contact sheet stands still; otherwise it follows the body.
        renderer: software works everywhere; opengl is faster; auto is opengl where it works.
        json: Print one JSON object.
    """

    take: Positional[Annotated[Path, arg(metavar="TAKE")]]
    out: Annotated[
        Path | None, arg(metavar="DIR", help_behavior_hint="(default: beside the take)")
    ] = None
    video: bool = False
    stills: bool = False
    player: bool = False
    view: str = "follow"
    fixed: bool = False
    renderer: Annotated[
        Literal["auto", "opengl", "software"] | None,
        arg(
            metavar="{auto,opengl,software}",
            help_behavior_hint="(default: software for stills, auto for video)",
        ),
    ] = None
    json: bool = False


def run(options: Options) -> Outcome:
    """Draw what was asked for."""
    import understudy as us

    folder = options.out or options.take.parent
    ready(folder)
    take = us.load_take(options.take)
    name = options.take.name.removesuffix(".npz").removesuffix(".take")
    with staged(folder, name, keep=(options.take,)) as (folder, files):
        draw(take, folder, name, options)
    result = {"take": str(options.take), "files": files}
    return Outcome(result=result, text="\n".join(files.values()))


def draw(take: Take, folder: Path, name: str, options: Options) -> None:
    """Write the pictures into `folder`."""
    from understudy import output

    nothing = not (options.video or options.stills or options.player)
    if options.stills or nothing:
        output.contact_sheet(
            take,
            folder / f"{name}.png",
            view=options.view,
            follow=not options.fixed,
            renderer=options.renderer or "software",
        )
    if options.player or nothing:
        output.write_player(take, folder / f"{name}_player.html")
    if options.video:
        output.video(
            take,
            folder / f"{name}.mp4",
            view=options.view,
            renderer=options.renderer or "auto",
        )
