"""Draws docs/picture.png, the README's picture: a bundled sample, as made and as simulated."""

from pathlib import Path

import understudy as us
from understudy import output

clip = us.sample("gesture")
take = us.track(clip, us.Character.from_clip(clip))
path = Path(__file__).with_name("picture.png")
output.contact_sheet(take, path, count=6, view="three-quarter", width=190, height=250)
print(f"{path.name}: {path.stat().st_size / 1000:.0f} kB")
