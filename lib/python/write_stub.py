"""Writes _commands.pyi, with the options of each command as keywords: write_stub.py FOLDER_OF_THE_PACKAGE STUB"""

import ast
import pathlib
import sys

folder, stub = sys.argv[1:]
sys.path.insert(0, folder)
from vdbpack import _commands, _core  # noqa: E402

OPTIONS = {command: options for command, _, options in _core.options()}
COMMANDS = {"morphometry": "measure", "repair": "mesh", "inspect_mesh": "mesh", "inspect_image": "image", "predict": "pack"}
WITHOUT_EFFECT = ("dry_run", "json", "quiet")
TYPES = """
from typing import Literal, Sequence
from ._pack import Path
from ._sizes import Radius
Numbers = Union[str, float, Sequence[Union[str, float]], numpy.typing.NDArray[Any]]
"""


def with_keywords(function: ast.FunctionDef) -> ast.FunctionDef:
    """A function whose `**options` are keywords with types, and whose body is its docstring."""
    arguments = function.args
    known = {each.arg for each in arguments.args + arguments.kwonlyargs}
    for option in OPTIONS[COMMANDS.get(function.name, function.name)]:
        if option.group and option.keyword not in known and option.keyword not in WITHOUT_EFFECT:
            kind = f"Union[{option.type}, Sequence[{option.type}]]" if option.repeats else option.type
            kind = "Union[bool, Path]" if option.keyword == "preview" else kind
            arguments.kwonlyargs.append(ast.arg(option.keyword, ast.parse(f"Optional[{kind}]", mode="eval").body))
            arguments.kw_defaults.append(ast.Constant(...))
    arguments.kwarg = None
    function.body = function.body[:1]
    return function


module = ast.parse(pathlib.Path(_commands.__file__).read_text(encoding="utf-8"))
functions = [node for node in module.body if isinstance(node, ast.FunctionDef)]
rest = [node for node in module.body if node not in functions and "_TABLE" not in ast.unparse(node)]
module.body = rest + ast.parse(TYPES).body + [with_keywords(node) for node in functions if node.name[0] != "_"]
pathlib.Path(stub).write_text(ast.unparse(module) + "\n", encoding="utf-8")
