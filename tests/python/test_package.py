# SPDX-License-Identifier: Apache-2.0
"""What comes with the package: its documentation, its wheel and libraries, examples and plots."""
import ast
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
import shutil
import subprocess
import sys
import tempfile
import textwrap
import unittest
import zipfile

import numpy
import touchable
from common import globe, png, source


def members_of(kind):
    """Functions, methods and properties that a class defines for programs."""
    inherited = [base for base in kind.__mro__[1:] if base.__module__.startswith("touchable")]
    for base, name, member in [(base, *each) for base in [kind, *inherited] for each in vars(base).items()]:
        if name.startswith("_") and not (base is kind and name == "__init__"):
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
        library = pathlib.Path(touchable.__file__).parent / "lib/libtouchable.so.0"
        says = lambda *options: subprocess.run(["objdump", *options, library], check=True, capture_output=True, text=True).stdout
        self.assertEqual(set(re.findall(r"NEEDED +(\S+)\.so", says("-p"))) - {"ld-linux-x86-64", "ld-linux-aarch64"}, {"libc", "libm", "libgcc_s"})
        symbols = says("-T")
        self.assertNotRegex(symbols, "GLIBCXX|CXXABI")
        newest = max(map(int, re.findall(r"\(GLIBC_2\.(\d+)", symbols)))
        if "VERSION_CODENAME=bookworm" in pathlib.Path("/etc/os-release").read_text():  # others have a newer C library
            self.assertEqual(newest, 34)
        self.assertEqual(os.path.basename(wheel), f"touchable-{version}-py3-none-manylinux_2_{newest}_{os.uname().machine}.whl")
        with zipfile.ZipFile(wheel) as file:
            names = set(file.namelist())
        self.assertEqual({name for name in names if ".so" in name}, {"touchable/lib/libtouchable.so.0"})
        self.assertIn("touchable/py.typed", names)

    def test_HasLicenceAndMetadata(self):
        with zipfile.ZipFile(os.environ["TOUCHABLE_WHEEL"]) as file:
            licences = [name for name in file.namelist() if name.endswith("/LICENSE")]
            self.assertEqual(len(licences), 1)
            self.assertEqual(file.read(licences[0]), (source / "LICENSE").read_bytes())
        metadata = importlib.metadata.metadata("touchable")
        self.assertEqual(metadata["License-File"], "LICENSE")
        self.assertEqual(metadata["License"], "Apache-2.0")
        self.assertEqual(metadata["Requires-Python"], ">=3.10")
        self.assertEqual(metadata["Description-Content-Type"], "text/markdown")
        kinds = {each.split(" :: ")[0] for each in metadata.get_all("Classifier")}
        self.assertLessEqual({"Development Status", "License", "Operating System", "Topic"}, kinds)
        description = metadata.get_payload() or metadata["Description"]
        program = re.search(r"(?:^    .*\n|^\n(?=    ))+", description, re.M)[0]
        self.assertIn("forces_at", program)
        self.assertIn(program.strip("\n"), (source / "docs/python.md").read_text(), "where it is tried")

    def test_OldestPythonHasAllNames(self):
        """Debian has no Python 3.10 to run it by."""
        newer = set("""typing.Self typing.Never typing.LiteralString typing.Required typing.NotRequired typing.Unpack
            typing.TypeVarTuple typing.assert_never typing.assert_type typing.reveal_type typing.dataclass_transform
            typing.override tomllib ExceptionGroup BaseExceptionGroup datetime.UTC enum.StrEnum enum.ReprEnum enum.EnumType
            enum.verify enum.member enum.nonmember contextlib.chdir hashlib.file_digest itertools.batched math.cbrt math.exp2
            math.sumprod operator.call sys.exception asyncio.TaskGroup asyncio.Runner asyncio.timeout locale.getencoding
            inspect.getmembers_static warnings.deprecated calendar.Month queue.ShutDown""".split())
        files = [*(source / "python/touchable").glob("*.py"), *(source / "examples/python").glob("*.py")]
        self.assertGreater(len(files), 10)
        for file in files:
            names = set()
            for node in ast.walk(ast.parse(file.read_text(), feature_version=(3, 10))):
                if isinstance(node, ast.ImportFrom):
                    names |= {node.module, *(f"{node.module}.{each.name}" for each in node.names)}
                elif isinstance(node, (ast.Attribute, ast.Name, ast.alias)):
                    names.add(ast.unparse(node))
            self.assertEqual(names & newer, set(), file)

    def test_IsWhatIsTested(self):
        version = importlib.metadata.version("touchable")
        self.assertEqual(touchable.__version__, version)
        self.assertFalse(pathlib.Path(touchable.__file__).is_relative_to(source))
        loaded = {line.split()[-1] for line in open("/proc/self/maps") if "libtouchable.so" in line}
        self.assertTrue(loaded)
        for library in loaded:
            self.assertEqual(pathlib.Path(library).parent, pathlib.Path(touchable.__file__).parent / "lib")


def python(*arguments, **options):
    return subprocess.run([sys.executable, *map(str, arguments)], capture_output=True, text=True, **options)


class Examples(unittest.TestCase):
    def says(self, name, *arguments):
        done = python(source / "examples/python" / name, *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stderr, "")
        return done.stdout

    def test_ArrayIsTouchedAndDrawn(self):
        with tempfile.TemporaryDirectory() as folder:
            said = self.says("touch_array.py", folder + "/forces.png")
            self.assertTrue(2 < float(re.search(r"force (\S+) N", said)[1]) < 4)  # 5 mm at 600 N/m
            picture = png(folder + "/forces.png")
            self.assertGreater(min(picture.shape[:2]), 400)
            self.assertGreater(len(numpy.unique(picture.reshape(-1, picture.shape[2]), axis=0)), 500)
        lines = (source / "examples/python/touch_array.py").read_text().splitlines()
        self.assertLessEqual(sum(bool(line.strip()) for line in lines), 15)

    def test_DeviceRunsInVirtualTime(self):
        said = self.says("device_loop.py", "--seconds", "1")
        self.assertGreater(int(re.search(r"in contact for (\d+) ms", said)[1]), 300)
        self.assertEqual(said, self.says("device_loop.py", "--seconds", "1"))

    def test_WallClockCountsLateTicks(self):
        said = self.says("device_loop.py", "--seconds", "0.2", "--wall-clock")
        self.assertRegex(said, r"\d+ ticks were more than 1 ms late")

    def test_SimulatorGetsZeroForMissing(self):
        said = self.says("sim_step.py").splitlines()
        self.assertEqual(said[3], "step 60: left [3. 3. 3. 3. 3.] N, right [3. 3. 3. 3. 3.] N")
        self.assertEqual(said[4], "step 75: left [3. 3. 3. 3. 3.] N, right [0. 0. 0. 0. 0.] N")


class Plots(unittest.TestCase):
    def test_DrawsFingersHolesAndFormats(self):
        depth = numpy.full((30, 40), 500, numpy.uint16)
        depth[10:20, 10:20] = 0
        camera = touchable.Camera(40, 30, fx_px=40.0)
        path = numpy.stack([camera.points(numpy.linspace(2, 38, 50), y, 0.505) for y in range(5, 25)], 1)
        with tempfile.TemporaryDirectory() as folder:
            for fingers in 1, 5, 20:
                touched = touchable.Surface(depth, camera).touch(path[:, :fingers])
                figure = touchable.plot(touched, f"{folder}/{fingers}.svg", title="a title")
                self.assertEqual(figure._suptitle.get_text(), "a title")
                over_depth, over_time = figure.axes[:2]
                self.assertEqual(over_time.get_xlabel(), "time [s]")
                self.assertEqual(len([line for line in over_time.lines]), 4 if fingers == 1 else fingers)
                if fingers == 5:  # counted as in the window
                    self.assertEqual([line.get_label() for line in over_time.lines], [f"finger {k}" for k in range(1, 6)])
                self.assertGreater(os.path.getsize(f"{folder}/{fingers}.svg"), 5000)
            with self.assertRaises(OSError):
                touchable.plot(touched, folder + "/nowhere/x.png")

    def test_WithoutPathPyplotShowsIt(self):
        from matplotlib import pyplot

        depth = numpy.full((30, 40), 500, numpy.uint16)
        figure = touchable.plot(touchable.Surface(depth, touchable.Camera(40, 30)).touch(numpy.zeros((3, 3))))
        self.assertIs(pyplot.gcf(), figure)
        pyplot.close(figure)

    def test_FreeFingersAreDrawn(self):
        nothing = touchable.Surface(numpy.zeros((30, 40), numpy.uint16), touchable.Camera(40, 30))
        with tempfile.TemporaryDirectory() as folder:
            touchable.plot(nothing.touch(numpy.zeros((3, 3)), metres_per_scene_unit=1), folder + "/x.png")
            touchable.plot(nothing.touch(numpy.zeros((0, 3)), metres_per_scene_unit=1), folder + "/y.png")

    def test_WithoutMatplotlibRaisesClearError(self):
        done = python("-c", "import sys; sys.modules['matplotlib'] = None\nimport numpy, touchable\n"
                      "depth = numpy.full((9, 9), 500, numpy.uint16)\n"
                      "touched = touchable.Surface(depth, touchable.Camera(9, 9)).touch([(0, 0, 0)])\n"
                      "try: touchable.plot(touched)\nexcept ImportError as problem: print(problem)")
        self.assertIn("apt install python3-matplotlib", done.stdout)


class Libraries(unittest.TestCase):
    """The package without its own libraries, as a copy of its folder."""

    def package(self, *libraries, broken=()):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        without = shutil.ignore_patterns("lib", "__pycache__")
        shutil.copytree(os.path.dirname(touchable.__file__), folder.name + "/touchable", ignore=without)
        os.mkdir(folder.name + "/touchable/lib")
        for library in libraries:
            shutil.copy(f"{os.environ['TOUCHABLE_LIBRARIES']}/{library}", folder.name + "/touchable/lib")
        for library in broken:  # where the system has one, that would be found if it were missing
            open(f"{folder.name}/touchable/lib/{library}", "w").close()
        return folder.name

    def test_SystemLibrariesWork(self):
        environment = {**os.environ, "PYTHONPATH": self.package(), "LD_LIBRARY_PATH": os.environ["TOUCHABLE_LIBRARIES"], "TOUCHABLE_MEDIA": ""}
        program = f"import touchable; print(len(touchable.open({globe()!r})), touchable.__version__)"
        done = python("-c", program, env=environment)
        self.assertEqual(done.stdout, f"12 {touchable.__version__}\n", done.stderr)

    def test_WithoutSolverNamesItsSource(self):
        package = self.package(broken=["libtouchable.so.0"])
        done = python("-c", "import touchable", env={**os.environ, "PYTHONPATH": package})
        self.assertRegex(done.stderr, "ImportError: libtouchable.so.0.*Debian package touchable")

    def test_WithoutMediaSurfacesWork(self):
        program = ("import numpy, touchable\nsurface = touchable.Surface(numpy.full((9, 9), 0.5), touchable.Camera(9, 9))\n"
                   "print(surface.touch([(0, 0, -0.6)] * 9).touching.all())\ntouchable.open('x')")
        package = self.package("libtouchable.so.0", broken=["libtouchable-media.so.0"])
        for media, problem in ("", "file too short"), ("/nowhere", "/nowhere/lib/libtouchable-media.so.0: cannot open"):
            done = python("-c", program, env={**os.environ, "PYTHONPATH": package, "TOUCHABLE_MEDIA": media})
            self.assertEqual(done.stdout, "True\n")
            self.assertRegex(done.stderr, "ImportError: libtouchable-media.so.0, which opens and writes files, cannot be loaded: .*"
                             f"{problem}.*portable archive.*set TOUCHABLE_MEDIA to its folder.*\n$")

    def test_ArchivesMediaWorks(self):
        """As the portable archive has it: in lib, with a libtouchable of its own, which is not loaded."""
        with tempfile.TemporaryDirectory() as archive:
            shutil.copytree(os.environ["TOUCHABLE_LIBRARIES"], archive + "/lib", ignore=shutil.ignore_patterns("*.a", "[!l]*"))
            program = (f"import touchable; print(len(touchable.open({globe()!r})))\n"
                       "print(*{line.split()[-1] for line in open('/proc/self/maps') if 'libtouchable' in line})")
            done = python("-c", program, env={**os.environ, "TOUCHABLE_MEDIA": archive})
            self.assertEqual(done.stderr, "")
            count, loaded = done.stdout.splitlines()
            self.assertEqual(count, "12")
            self.assertEqual({pathlib.Path(path).parent.parent for path in loaded.split()},
                             {pathlib.Path(archive), pathlib.Path(touchable.__file__).parent})

    def copied(self, *names):
        """The package's sources and `names` of the repository, in a folder where they may be built."""
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        built = shutil.ignore_patterns("build", "dist", "*.egg-info", "__pycache__")
        os.mkdir(folder.name + "/touchable")
        for name in ("python", "CMakeLists.txt", *names):
            if (source / name).is_dir():
                shutil.copytree(source / name, f"{folder.name}/touchable/{name}", ignore=built)
            else:
                shutil.copy(source / name, folder.name + "/touchable")
        return folder.name

    def test_WheelWithoutLibrariesIsRejected(self):
        folder = self.copied()
        done = subprocess.run(["/usr/bin/python3", "setup.py", "-q", "bdist_wheel"], cwd=folder + "/touchable/python",
                              capture_output=True, text=True, env={**os.environ, "TOUCHABLE_LIBRARIES": folder})
        self.assertNotEqual(done.returncode, 0)
        self.assertIn(f"{folder} has no libtouchable.so.0; build it", done.stderr)

    def test_SdistHasLibrarySources(self):
        """What CMake configures with it; to compile it takes minutes. The wheel of it has libraries that were built before, both, for
        this machine alone."""
        folder = self.copied("LICENSE", "capi", "cmake", "device", "engine", "haptics_cpu", "shaders")
        subprocess.run(["/usr/bin/python3", "-m", "build", "--sdist", "--no-isolation", "--outdir", folder, folder +
                        "/touchable/python"], check=True, capture_output=True)
        name = f"touchable-{touchable.__version__}"
        subprocess.run(["tar", "xzf", f"{folder}/{name}.tar.gz", "-C", folder], check=True)
        subprocess.run(["cmake", "-S", f"{folder}/{name}/source", "-B", f"{folder}/b", "-G", "Ninja",
                        "-DTOUCHABLE_PARTS=libraries"], check=True, capture_output=True)
        headers = {f"{folder}/{name}/source/{path}" for path in
                   re.findall(r'#include "([a-z_]+/[^"]+)"', "".join(
                       file.read_text() for part in ("capi", "haptics_cpu", "engine/formats", "engine/surface")
                       for file in (source / part).rglob("*.[ch]pp")))}
        self.assertEqual([header for header in headers if not os.path.exists(header)], [])
        done = subprocess.run([sys.executable, "-m", "pip", "wheel", "--quiet", "--disable-pip-version-check", "--no-index",
                               "--no-build-isolation", "--no-deps", "-w", folder, f"{folder}/{name}.tar.gz"],
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        wheel = f"{folder}/{name}-py3-none-linux_{os.uname().machine}.whl"
        with zipfile.ZipFile(wheel) as file, zipfile.ZipFile(os.environ["TOUCHABLE_WHEEL"]) as tested:
            self.assertEqual(set(file.namelist()) - set(tested.namelist()), {"touchable/lib/libtouchable-media.so.0"})

    def test_WithoutCompilerNamesPackages(self):
        folder = self.copied()
        environment = {name: value for name, value in os.environ.items() if name != "TOUCHABLE_LIBRARIES"}
        done = subprocess.run(["/usr/bin/python3", "setup.py", "-q", "bdist_wheel"], cwd=folder + "/touchable/python",
                              capture_output=True, text=True, env={**environment, "PATH": folder})
        self.assertNotEqual(done.returncode, 0)
        self.assertRegex(done.stderr, "there is no c\\+\\+ and no cmake.*apt install g\\+\\+ cmake ninja-build.*libzip-dev")
        named = re.search(r"apt install ([\w+. -]+)", done.stderr)[1].split()
        packages = re.search(r"^packages=\((.*?)\)", (source / "run").read_text(), re.S | re.M)[1].split()
        self.assertEqual(set(named) - set(packages), set())


if __name__ == "__main__":
    unittest.main()
