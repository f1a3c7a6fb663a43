"""The page of options, from their table: tests/python/options_page.py renews assets/guides/options.md.

What stands above its heading "All options" is written by hand.
"""

import re

from conftest import ROOT
from vdbpack import _core

PAGE = ROOT / "assets/guides/options.md"
HEADING = "## All options\n\n"


def as_written(option, value=""):
    """An option as the command line has it; bars would end the cell of a table."""
    name = ("" if option.name.isupper() else "--") + option.name
    letter = f"`-{option.letter}`, " if option.letter else ""
    return letter + f"`{name} {value}".rstrip().replace("|", "\\|") + "`"


def row(option):
    value, default = re.fullmatch(r"(.*?)(?: ?\[([^\]]*)\])?", option.shown).groups()
    text = re.sub("`([a-z-]+)`", r"`--\1`", option.help).replace("|", "\\|")
    return f"| {as_written(option, value)} | {default or ''} | {'mm' if option.is_length else ''} | {text} |"


def page():
    text = PAGE.read_text(encoding="utf-8").split(HEADING)[0] + HEADING
    text += "From the table of options, by `tests/python/options_page.py`; `--help` after a command shows the same.\n"
    known = {}
    for command, effect, options in _core.options():
        groups, before = {}, {}
        for option in options:
            if option.group or option.name.isupper():  # else a former name
                first = known.setdefault((option.name, option.shown, option.help), command)
                listed = groups.setdefault(option.group or "Input", []) if first == command else before.setdefault(first, [])
                listed.append(row(option) if first == command else as_written(option))
        text += f"\n### {command}\n\n`vdb_pack {command}`: {effect}.\n"
        for group, rows in groups.items():
            text += "\n".join([f"\n| {group} | default | unit | effect |", "|---|---|---|---|", *rows]) + "\n"
        text += "".join(f"\nAs for `{other}`: {', '.join(names)}.\n" for other, names in before.items())
    return text


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
