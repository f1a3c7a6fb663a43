"""The API page, from the docstrings: tests/python/api_page.py > assets/guides/python-api.md"""

import inspect
import re
import textwrap

import vdbpack

GROUPS = {
    "Runs": ["pack", "densify", "carve", "voids", "verify", "measure", "stiffness", "morphometry", "convert", "repair",
             "inspect_mesh", "inspect_image", "predict"],
    "Results": ["Pack", "Voids", "Report"],
    "Domains": ["box", "ball", "cylinder", "rect", "disc", "image", "level_set", "Image", "LevelSet", "Mesh", "Shape"],
    "Sizes": ["constant", "uniform", "normal", "lognormal", "table", "Sizes"],
    "Files": ["read", "write", "read_points", "write_points"],
    "Errors": ["Error", "ParameterError", "InputError", "FileError", "ResourceError", "VdbpackWarning"],
}


def signature(thing):
    text = re.sub(r"\b(?:[A-Za-z_]\w*\.)+(\w+)", r"\1", str(inspect.signature(thing)))
    return re.sub(r"(\(|, )self(, )?", r"\1", text).replace("'", "")


def text_of(thing):
    """A docstring; what it says of arguments as a list."""
    text = textwrap.dedent(inspect.getdoc(thing) or "").strip().replace("<", "&lt;")
    text = re.sub(r"(?<=\. )(\w+(?:, \w+)*: )", r"\n\1", text)
    return re.sub(r"^(\w+(?:, \w+)*): ", r"- *\1*: ", text, flags=re.M)


def one_line(thing):
    return " ".join((inspect.getdoc(thing) or "").split())


def section(name):
    thing = getattr(vdbpack, name)
    if not isinstance(thing, type):
        return f"### {name}\n\n```\n{name}{signature(thing)}\n```\n\n{text_of(thing)}\n"
    lines = [f"### {name}\n\n{text_of(thing)}\n"]
    for member, value in vars(thing).items():
        if member.startswith("_"):
            continue
        if isinstance(value, property):
            lines.append(f"- `{member}`: {one_line(value)}")
        elif callable(value):
            lines.append(f"- `{member}{signature(value)}`: {one_line(value)}")
    return "\n".join(lines) + "\n"


def page():
    parts = ["# Python API\n\nFrom the docstrings of the module, by `tests/python/api_page.py`. [Python](python.md) has recipes.\n"]
    for group, names in GROUPS.items():
        parts.append(f"## {group}\n")
        parts += [section(name) for name in names]
    return "\n".join(parts).rstrip() + "\n"


if __name__ == "__main__":
    print(page(), end="")
