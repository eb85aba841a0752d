"""The character: find and calibrate SMPL-X armatures, create the default human.

Scripts outside of the repository use the function below as ``character.create_character``.
"""


def __getattr__(name: str) -> object:
    if name == "create_character":
        from . import character

        return character.create_character
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
