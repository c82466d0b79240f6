"""The claim that stubs name the arguments of what pybind11 binds, which mypy.stubtest cannot see."""

import ast
import re
import unittest
from pathlib import Path

import planar_servo as ps
from support import ROOT

STUBS = ROOT / "python/planar_servo/__init__.pyi"


def shape(function):
    """The names of a function's arguments, those by name alone, and which have defaults."""
    arguments = function.args
    names = [argument.arg for argument in arguments.args]
    only = [argument.arg for argument in arguments.kwonlyargs]
    optional = names[len(names) - len(arguments.defaults):]
    return names, only, optional + [name for name, value in zip(only, arguments.kw_defaults) if value]


def bound(thing):
    """The first signature in a docstring of pybind11; None for what Python defines."""
    line = re.search(r"^(?:1\. )?(\w+\((?!\*args).*\) -> .*)$", thing.__doc__ or "", re.MULTILINE)
    return ast.parse(f"def {line[1]}: ...").body[0] if line else None


class Stubs(unittest.TestCase):
    def test_name_the_arguments_of_bound_functions(self):
        compared = set()

        def compare(owner, body, path):
            for node in body:
                if isinstance(node, ast.ClassDef):
                    compare(getattr(owner, node.name), node.body, node.name + ".")
                elif isinstance(node, ast.FunctionDef) and path + node.name not in compared:
                    signature = bound(getattr(owner, node.name, None))
                    if signature:
                        compared.add(path + node.name)
                        self.assertEqual(shape(node), shape(signature), path + node.name)

        public = [node for node in ast.parse(Path(STUBS).read_text()).body if not getattr(node, "name", "_").startswith("_")]
        compare(ps, public, "")
        self.assertGreater(len(compared), 40)
        self.assertLessEqual({"write_table", "Cell.move_to", "Arm.__init__", "calibrate_camera"}, compared)


if __name__ == "__main__":
    unittest.main()
