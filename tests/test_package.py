"""The public surface: about fifteen names, loaded when used; README, metadata and files agree."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import understudy as us

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
README = (ROOT / "README.md").read_text(encoding="utf-8")


def python(code: str) -> str:
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return done.stdout.strip()


def test_importing_the_package_imports_nothing_heavy():
    loaded = python(
        "import sys, understudy; "
        "print([m for m in ('numpy', 'scipy', 'mujoco', 'numba') if m in sys.modules])"
    )
    assert loaded == "[]"


@pytest.mark.parametrize("name", [n for n in us.__all__ if n != "__version__"])
def test_every_public_name_loads_and_has_a_docstring(name):
    assert getattr(us, name).__doc__


def test_the_public_surface_stays_small():
    assert len(us.__all__) <= 24


def test_simulate_stays_the_function_after_its_submodule_is_imported():
    shown = python(
        "import understudy.simulate, understudy as us; from understudy.simulate import simulate; "
        "print(us.simulate is simulate)"
    )
    assert shown == "True"


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="understudy"):
        us.no_such_name  # noqa: B018


def test_the_version_is_said_once():
    assert us.__version__ == PROJECT["project"]["version"]
    assert f"version: {us.__version__}" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"## {us.__version__}" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")


def test_the_readme_has_two_commands_that_name_real_extras():
    commands = [
        line
        for block in re.findall(r"```bash\n(.*?)```", README, re.DOTALL)
        for line in block.splitlines()
        if line.startswith("python3 -m venv")
    ]
    assert len(commands) == 2
    extras = set(PROJECT["project"]["optional-dependencies"])
    for command in commands:
        assert set(re.findall(r"\.\[(\w+)\]", command)) <= extras
    assert commands[1].endswith("&& .venv/bin/pytest")


def test_links_in_the_documents_lead_somewhere():
    for page in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))):
        text = page.read_text(encoding="utf-8")
        for target in re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", text):
            if not target.startswith(("http:", "https:")):
                assert (page.parent / target).exists(), f"{page.name}: {target}"


def test_every_module_begins_with_a_docstring():
    for path in sorted((ROOT / "src").rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        assert ast.get_docstring(tree), path


def test_motion_needs_only_numpy_and_scipy():
    allowed = {"numpy", "scipy", "understudy"} | set(sys.stdlib_module_names)
    for path in sorted((ROOT / "src" / "understudy" / "motion").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = []
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom):
                names = [node.module or ""]
            for name in names:
                assert name.split(".")[0] in allowed, f"{path.name} imports {name}"


def test_the_readme_script_runs_as_it_stands(tmp_path):
    (script,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    us.write(us.sample("walk").trimmed(0.0, 1.0), tmp_path / "walk.bvh")
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", script],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "joint error" in done.stdout
    assert {"walk_sim.bvh", "walk_sim.glb", "walk.html"} <= {p.name for p in tmp_path.iterdir()}


def test_the_readme_edit_file_performs_as_it_stands(tmp_path):
    (text,) = re.findall(r"```toml\n(.*?)```", README, re.DOTALL)
    (tmp_path / "hit.toml").write_text(text, encoding="utf-8")
    take = us.perform(tmp_path / "hit.toml")
    assert {"GiveWay", "LookAt", "Push", "Throw"} == {
        said.partition("(")[0] for said in take.facts["tasks"]
    }
