"""The program marquetry: where it is, a run of it, what it says meanwhile. Knows nothing of Blender."""
import collections
import json
import os
import shutil
import signal
import subprocess
import threading
import time

CANCELLED = 130


class Refusal(Exception):
    """What is wrong, what was found, and what to do next: words for the user."""


def read_tables():
    """The program's option tables, and its version, as scripts/blender_addon packed them."""
    path = os.path.join(os.path.dirname(__file__), "tables.json")
    if not os.path.exists(path):
        raise ImportError(f"{path} is missing: install the zip that scripts/blender_addon makes, not the sources")
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def find(path):
    """The program to call: `path`, or else the one on PATH."""
    if path:
        if not os.path.isfile(path) or not os.access(path, os.X_OK):
            raise Refusal(f"{path} is no program: choose marquetry in the preferences of the add-on")
        return path
    found = shutil.which("marquetry")
    if not found:
        raise Refusal("the program marquetry is not on PATH: install it, "
                      "or choose it in Preferences > Add-ons > Marquetry")
    return found


def check_version(path, wanted):
    """Refuses a program whose options are not those that the add-on was packed with."""
    try:
        said = subprocess.run([path, "--version"], capture_output=True, text=True, timeout=20, check=False).stdout
    except (OSError, subprocess.TimeoutExpired) as error:
        raise Refusal(f"{path} does not run ({error}): choose another in the preferences of the add-on") from error
    words = said.split()
    if len(words) != 2 or words[0] != "marquetry":
        raise Refusal(f"{path} --version says {said.strip()[:60]!r}, not 'marquetry {wanted}': "
                      "choose marquetry in the preferences of the add-on")
    if words[1] != wanted:
        raise Refusal(f"{path} is version {words[1]}, the add-on is made for {wanted}: "
                      "install the add-on that comes with the program")


class Run:
    """A run of the program in a process of its own. `progress` is the last that it told, a dictionary as
    --progress json has it, or None; `messages` are pairs of remark, warning or error, and its text."""

    def __init__(self, words, folder):
        self.start = time.monotonic()
        self.progress = None
        self.messages, self._lines = [], collections.deque()
        self._verb = words[1]
        words = [*words, "--progress=json"]
        self._stops = 0
        try:
            # A session of its own: Ctrl-C in the terminal from which Blender was started is not for it.
            self.process = subprocess.Popen(words, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                            stderr=subprocess.PIPE, encoding="utf-8", errors="replace",
                                            start_new_session=True)
        except OSError as error:
            raise Refusal(f"{words[0]} does not run ({error}): choose another in the preferences of the add-on") \
                from error
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        with self.process.stderr as lines:
            for line in lines:
                self._lines.append(line.rstrip("\n"))

    def _take_lines(self):
        while self._lines:
            line = self._lines.popleft()
            try:
                told = json.loads(line)
                event = told["event"]
            except (ValueError, TypeError, KeyError):
                self.messages.append(("warning", line))  # of a library, or of the system
                continue
            if event == "progress":
                self.progress = told
            elif not told["text"].startswith("wrote "):
                self.messages.append((event, told["text"]))

    def poll(self):
        """The exit status, or None while it works."""
        status = self.process.poll()
        if status is not None:
            self._reader.join(timeout=10)
        self._take_lines()
        return status

    def wait(self):
        self.process.wait()
        return self.poll()

    def stop(self):
        """First asks it to stop, which it does at the next opportunity; the second time it ends at once."""
        self._stops += 1
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)

    def end(self):
        """Stops it and waits: for when Blender ends, or loads another file."""
        for _ in range(2):
            self.stop()
            try:
                self.process.wait(timeout=2)
                break
            except subprocess.TimeoutExpired:
                continue
        else:
            self.process.kill()
        self.wait()

    @property
    def stopped(self):
        return self._stops > 0

    def words(self):
        """How far it is, for the status bar."""
        seconds = f"{time.monotonic() - self.start:.0f} s"
        if self.stopped:
            return f"Marquetry: stopping, {seconds}; Esc again stops at once"
        if self.progress is None:
            return f"Marquetry {self._verb}: {seconds} (Esc cancels)"
        step, left = self.progress["step"].split(" / ")[-1], self.progress["left"]
        left = f", about {left:.0f} s left" if left is not None and left >= 1 else ""
        return f"Marquetry {self._verb}: {100 * self.progress['fraction']:.0f} % {step}, {seconds}{left} (Esc cancels)"
