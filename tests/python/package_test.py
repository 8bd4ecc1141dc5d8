"""The package itself: quick to import, its functions made of the option tables, its types sound."""
import inspect
import os
import pathlib
import shutil
import subprocess
import sys
import unittest

import marquetry as mq
from marquetry import _run, _verbs
from models import PROGRAM, SOURCE, folder, sample

PACKAGE = pathlib.Path(mq.__file__).parent


class Package(unittest.TestCase):
    def test_import_takes_at_most_three_tenths_of_a_second(self):
        code = ("import time; start = time.process_time(); import marquetry; "
                "print(time.process_time() - start)")
        taken = [float(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout)
                 for _ in range(5)]
        self.assertLessEqual(min(taken), 0.3, taken)

    def test_nothing_large_is_imported_before_it_is_needed(self):
        code = "import sys, marquetry; print([m for m in ('scipy', 'PIL', 'tqdm') if m in sys.modules])"
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        self.assertEqual(done.stdout.strip(), "[]")

    def test_a_call_takes_no_more_memory_than_the_program_and_a_picture(self):
        if "LD_PRELOAD" in os.environ:
            self.skipTest("another allocator keeps what is freed")
        size = 1024
        where = sample("bust", size)
        words = [where / "bust.obj", "--beta", "3", "-o", folder() / "out.png", "--quiet", "--threads", "2"]
        running = subprocess.Popen([PROGRAM, "filter", *map(str, words)], stdout=subprocess.DEVNULL)
        _, status, used = os.wait4(running.pid, 0)
        running.returncode = os.waitstatus_to_exitcode(status)
        self.assertEqual(running.returncode, 0)
        code = ("import resource, sys, marquetry as mq\npeak = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss\n"
                "before = peak()\nmq.filter(sys.argv[1], beta=3.0, threads=2)\nprint(peak() - before)")
        done = subprocess.run([sys.executable, "-c", code, where / "bust.obj"], capture_output=True, text=True, check=True)
        picture = size * size * 3 * 4 // 1024  # in floats
        self.assertLessEqual(int(done.stdout), used.ru_maxrss + picture)

    def test_functions_are_those_of_the_tables(self):
        made = folder() / "_verbs.py"
        subprocess.run([sys.executable, SOURCE / "python" / "make_verbs.py", PACKAGE, made], check=True)
        self.assertEqual(made.read_text(), (PACKAGE / "_verbs.py").read_text())
        for verb, table in _run.tables().items():
            if verb in ("batch", "merge", "view"):
                continue
            function = getattr(mq, verb)
            keywords = inspect.signature(function).parameters
            for row in table["options"]:
                if row["name"] in _run.LEFT_OUT:
                    continue
                name = _run.keyword_of(row["name"])
                self.assertIn(name, keywords, verb)
                self.assertIn(f"    {name}: ", function.__doc__, verb)
            self.assertEqual(set(_verbs.__all__) - set(mq.__all__), set())

    def test_version_is_the_programs(self):
        done = subprocess.run([PROGRAM, "--version"], capture_output=True, text=True, check=True)
        self.assertEqual(done.stdout.split()[-1], mq.__version__)

    def test_types_are_sound(self):
        if shutil.which("mypy") is None:
            self.skipTest("mypy is not installed")
        use = folder() / "use.py"
        use.write_text("import numpy as np\nimport marquetry as mq\n"
                       "made: mq.Result = mq.filter('a.obj', 'a.png', beta=1.0, solver='direct')\n"
                       "space = mq.fem.ImageSpace(3, 4)\nvalues: np.ndarray = mq.smooth(space, np.ones(12), '1%')\n")
        environment = {**os.environ, "MYPYPATH": str(PACKAGE.parent)}
        done = subprocess.run(["mypy", "--strict", "--ignore-missing-imports", "--no-warn-unused-ignores",
                               "--cache-dir", str(folder() / "mypy"), "-p", "marquetry"], capture_output=True,
                              text=True, env=environment, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        wrong = folder() / "wrong.py"
        wrong.write_text("import marquetry as mq\nmq.filter('a.obj', beta='strong', solver='best')\n")
        for source, status in ((use, 0), (wrong, 1)):
            done = subprocess.run(["mypy", "--ignore-missing-imports", "--cache-dir", str(folder() / "mypy"),
                                   str(source)], capture_output=True, text=True, env=environment, check=False)
            self.assertEqual(done.returncode, status, done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main()
