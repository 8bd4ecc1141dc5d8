"""A run on Blender's data: a folder of its own, the program, and what becomes of its files."""
import os
import shutil
import tempfile

import bpy

from . import options, program
from .program import Refusal

#: Of reports in Blender, by what the program calls them.
LEVELS = {"remark": "INFO", "warning": "WARNING", "error": "ERROR"}
#: The one at work, if there is one.
at_work = None


def preferences():
    return bpy.context.preferences.addons[__package__].preferences


class Job:
    """Steps of it are taken by an operator, with the types of events that it gets.

    `prepare(folder)` writes the files and gives the words of the command line; `finish(folder)` puts the results into
    Blender's data and gives what is to be told, pairs of a level and a text. Nothing of Blender changes before."""

    def __init__(self, verb, prepare, finish):
        global at_work
        if at_work is not None:
            raise Refusal("Marquetry is at work: wait for it, or press Esc over the window that shows its progress")
        self._finish = finish
        chosen = preferences()
        path = program.find(bpy.path.abspath(chosen.program))
        program.check_version(path, options.VERSION)
        self.folder = tempfile.mkdtemp(prefix="marquetry_", dir=bpy.app.tempdir or None)
        try:
            words = [path, verb, *prepare(self.folder)]
            words += [f"--threads={chosen.threads}"] if chosen.threads else []
            self.run = program.Run(words, self.folder)
        except BaseException:
            shutil.rmtree(self.folder, ignore_errors=True)
            raise
        at_work = self

    def step(self, event):
        """(state, [(level, text), ...]), with the states of operators."""
        if event == "ESC":
            self.run.stop()
        status = self.run.poll()
        if status is None:
            return "RUNNING_MODAL", []
        try:
            return self._end(status)
        finally:
            self.close()

    def wait(self):
        self.run.wait()
        return self.step("TIMER")

    def _end(self, status):
        said = self.run.messages
        if self.run.stopped or status == program.CANCELLED:
            return "CANCELLED", [("INFO", "Cancelled: nothing is changed")]
        if status != 0:
            errors = [text for event, text in said if event == "error"] or [text for _, text in said]
            return "CANCELLED", [("ERROR", errors[-1] if errors else f"marquetry ended with status {status}")]
        told = [(LEVELS[event], text) for event, text in said]
        try:
            told += self._finish(self.folder)
        except Refusal as refusal:
            return "CANCELLED", told + [("ERROR", str(refusal))]
        except (OSError, RuntimeError) as error:
            return "CANCELLED", told + [("ERROR", f"the program's files cannot be read: {error}")]
        return "FINISHED", told

    def close(self):
        global at_work
        self.run.end()
        shutil.rmtree(self.folder, ignore_errors=True)
        if at_work is self:
            at_work = None


def close_all():
    if at_work is not None:
        at_work.close()


def out(folder, *parts):
    """A place for results; what the program reads lies in `folder` itself."""
    return os.path.join(folder, "out", *parts)
