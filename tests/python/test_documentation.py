import contextlib
import dataclasses
import enum
import importlib.metadata
import inspect
import io
import os
import pathlib
import pydoc
import re
import textwrap
import unittest
import zipfile

import touchable
from common import source


def members_of(kind):
    """Functions, methods and properties that a class defines for programs."""
    for name, member in vars(kind).items():
        if name.startswith("_") and name not in ("__init__",):
            continue
        if isinstance(member, property):
            yield f"{kind.__name__}.{name}", member.fget
        elif hasattr(member, "func") and not inspect.isfunction(member):  # cached
            yield f"{kind.__name__}.{name}", member.func
        elif inspect.isfunction(member) or isinstance(member, classmethod):
            yield f"{kind.__name__}.{name}", getattr(member, "__func__", member)


def public():
    """Every public function, method and property, and every public class."""
    for name in touchable.__all__:
        thing = getattr(touchable, name)
        yield name, thing
        if inspect.isclass(thing) and not issubclass(thing, (enum.Enum, BaseException)):
            yield from members_of(thing)


class Documentation(unittest.TestCase):
    def test_EveryPublicNameHasDocstring(self):
        for name, thing in public():
            own = vars(thing).get("__doc__") if inspect.isclass(thing) else thing.__doc__
            generated = dataclasses.is_dataclass(thing) and (own or "").startswith(f"{name}(")
            # That of a data class is made of its members.
            made = name.endswith(".__init__") and dataclasses.is_dataclass(getattr(touchable, name.split(".")[0]))
            self.assertTrue(made or (own and not generated), name)

    def test_EveryParameterHasTypeHint(self):
        for name, thing in public():
            if inspect.isclass(thing):
                continue
            signature = inspect.signature(thing)
            for parameter in signature.parameters.values():
                if parameter.name not in ("self", "cls"):
                    self.assertIsNot(parameter.annotation, parameter.empty, f"{name}: {parameter.name}")
            self.assertIsNot(signature.return_annotation, signature.empty, name)

    def test_ArraysHaveDocumentedShapes(self):
        for name, thing in public():
            hints = "" if inspect.isclass(thing) else str(inspect.signature(thing))
            if re.search("NDArray|ArrayLike", hints):
                text = thing.__doc__
                shape = r"\((\.\.\.|height|ticks|fingers|frames)[^)]*\)|as Camera.points has it|see touchable.touch"
                has_shape = re.search(shape, text)
                self.assertTrue(has_shape, f"{name}: {text}")

    def test_FunctionsDocumentTheirErrors(self):
        for name, thing in public():
            if inspect.isclass(thing) or name.endswith((".close", ".closed", ".__init__")):
                continue
            body = inspect.getsource(inspect.unwrap(thing))
            if re.search(r"_check_open|raise |refuse\(|made\(", body):
                self.assertRegex(thing.__doc__, "[Rr]aises|see touchable.touch", name)

    def test_AttributesAreDocumented(self):
        for name, thing in public():
            if not inspect.isclass(thing):
                continue
            has = list(getattr(thing, "__dataclass_fields__", None) or getattr(thing, "__members__", ()))
            has += re.findall(r"\n        self\.([a-z]\w*)(?:: [^=]+)? = ", inspect.getsource(thing))
            for member in has:
                self.assertRegex(thing.__doc__, rf"\b{member}(, \w+)*: ", f"{name}.{member}")

    def test_NamesMatchDocumentation(self):
        text = (source / "docs/python.md").read_text()
        for name in touchable.__all__:
            self.assertIn(name, text)
        for name in re.findall(r"touchable\.([A-Za-z_]+)", text):
            self.assertTrue(hasattr(touchable, name) or name in ("mkv", "so", "h", "md", "bag"), name)

    def test_FirstProgramPrintsAsDocumented(self):
        text = (source / "docs/python.md").read_text()
        blocks = re.findall(r"(?:^    .*\n|^\n(?=    ))+", text, re.M)
        program, printed = (textwrap.dedent(block) for block in blocks[:2])
        self.assertIn("forces_at", program)
        with contextlib.redirect_stdout(io.StringIO()) as out:
            exec(compile(program, "docs/python.md", "exec"), {})
        self.assertEqual(out.getvalue().strip(), printed.strip())

    def test_PydocShowsPublicNames(self):
        text = pydoc.plain(pydoc.render_doc(touchable))
        for name in touchable.__all__:
            self.assertRegex(text, rf"(class )?{name}\b")


class Wheel(unittest.TestCase):
    def test_HasLibrariesAndPlatform(self):
        wheel = os.environ["TOUCHABLE_WHEEL"]
        version = re.search(r"project\(touchable VERSION ([0-9.]+)", (source / "CMakeLists.txt").read_text())[1]
        machine = os.uname().machine
        self.assertEqual(os.path.basename(wheel), f"touchable-{version}-py3-none-linux_{machine}.whl")
        with zipfile.ZipFile(wheel) as file:
            names = set(file.namelist())
        expected = {"libtouchable.so.0", "libtouchable-media.so.0"}
        self.assertEqual({pathlib.Path(name).name for name in names if ".so" in name}, expected)
        self.assertIn("touchable/py.typed", names)

    def test_IsWhatIsTested(self):
        version = importlib.metadata.version("touchable")
        self.assertEqual(touchable.__version__, version)
        self.assertFalse(pathlib.Path(touchable.__file__).is_relative_to(source))
        loaded = {line.split()[-1] for line in open("/proc/self/maps") if "libtouchable" in line}
        self.assertTrue(loaded)
        for library in loaded:
            self.assertEqual(pathlib.Path(library).parent, pathlib.Path(touchable.__file__).parent / "lib")


if __name__ == "__main__":
    unittest.main()
