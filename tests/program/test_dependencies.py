"""Messages about missing or broken packages, in the preferences, by operators and by the batch."""

from __future__ import annotations

import sys

import bpy
import pytest
from samp_blender.samp_addon import dependencies
from samp_blender.samp_addon.dependencies import Package
from samp_blender.samp_addon.ui import preferences, shell_command

THERE = Package("numpy", "numpy", "anything")
ABSENT = Package("no_such_package", "no-such-package", "anything")


def raised(work):
    try:
        work()
    except Exception as error:
        return error
    raise AssertionError("nothing was raised")


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("raise ModuleNotFoundError('x', name='torch.nn')", "'torch' is missing"),
        ("raise ModuleNotFoundError('x', name='scipy')", "'scipy' is missing"),
        ("raise ModuleNotFoundError('x', name='cv2')", None),
        ("open('/no/such/file')", None),
        ("1 / 0", None),
    ],
)
def test_explanations(source, expected):
    message = dependencies.explain(raised(lambda: exec(source)))
    assert message is None if expected is None else expected in message and "Preferences" in message


@pytest.mark.parametrize("source", ["raise OSError('c10.dll\\nis missing')", "raise ImportError('bad ELF')"])
def test_a_package_that_fails_to_load(monkeypatch, tmp_path, source):
    (tmp_path / "safetensors").mkdir()
    (tmp_path / "safetensors" / "__init__.py").write_text(source)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "safetensors", raising=False)
    message = dependencies.explain(raised(lambda: __import__("safetensors")))
    assert "'safetensors' cannot be loaded (" in message and "\n" not in message


def test_versions_are_found_without_importing():
    assert THERE.present and THERE.version and not ABSENT.present and ABSENT.version == ""


@pytest.mark.parametrize(
    ("names", "lines"),
    [
        (["torch"], ["-m pip install --target F torch"]),
        (["scipy", "packaging"], ["-m pip install --target F --no-deps scipy packaging"]),
        (["scipy", "torch"], ["--target F torch", "--no-deps scipy"]),
    ],
)
def test_install_commands(names, lines):
    packages = [Package(name, name, "") for name in names]
    commands = dependencies.install_commands("py", "F", packages)
    commands = [line.replace('"', "") for line in commands if "ensurepip" not in line]
    assert len(commands) == len(lines)
    assert all(line.endswith(end) for line, end in zip(commands, lines, strict=True))


class Layout:
    """Record what a panel shows."""

    def __init__(self):
        self.shown = []

    def column(self):
        return self

    def label(self, text="", icon="NONE"):
        self.shown.append(text)

    def operator(self, name, icon="NONE"):
        self.shown.append(name)

    def prop(self, data, name, **look):
        """Settings are not about packages."""

    def context_pointer_set(self, name, data):
        """Keys are not about packages."""


@pytest.mark.parametrize("absent", [(), (ABSENT,)])
def test_preferences(monkeypatch, absent):
    monkeypatch.setattr(dependencies, "PACKAGES", (THERE, *absent))
    preferences._found.cache_clear()
    shown = Layout()
    drawn = type("Drawn", (), {"layout": shown, "farm_engine": "NONE"})()
    preferences.SAMP_AP_preferences.draw(drawn, bpy.context)
    preferences._found.cache_clear()
    assert f"numpy: {THERE.version}" in shown.shown
    assert ("samp.copy_install_commands" in shown.shown) is bool(absent)
    assert any("missing, needed for anything" in line for line in shown.shown) is bool(absent)


@pytest.mark.parametrize(
    ("arguments", "status", "message"),
    [(["--help"], 0, "--jobs"), ([], 2, "--action"), (["--action", "sit"], 2, "--target")],
)
def test_the_command_has_the_options_of_the_batch(capsys, arguments, status, message):
    assert shell_command.run(arguments) == status
    output = capsys.readouterr()
    assert message in output.out + output.err and "Traceback" not in output.err


def test_the_command_is_registered_and_unregistered():
    for _ in range(2):
        shell_command.register()
        assert shell_command._registered
        shell_command.unregister()
        assert not shell_command._registered
