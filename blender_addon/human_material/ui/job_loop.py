# SPDX-License-Identifier: GPL-3.0-or-later
"""Jobs are started, shown in the panel of their kind, ended. Nothing here waits while there is a window."""
import bpy

from .. import compat
from ..services import jobs
from ..services.errors import InputError

last_words = {}   # kind -> what the last job of it ended with
_said = []


def expect_free(kind):
    job = jobs.of(kind)
    if job is not None:
        raise InputError("", job.title, "is still running", "wait, or cancel it")


def start(job):
    """In a window returns at once; without one waits for the job. Returns words, raises InputError with the job's."""
    last_words.pop(job.kind, None)
    if not bpy.app.background:
        jobs.running.append(job)
        return job.title
    job.wait()
    last_words[job.kind] = job.end()
    return last_words[job.kind]


def step():
    """Ends the jobs that are done. Returns what went wrong, in words."""
    errors = []
    for job in [j for j in jobs.running if j.is_done()]:
        jobs.running.remove(job)
        try:
            last_words[job.kind] = job.end()
        except InputError as error:
            last_words[job.kind] = str(error)
            errors.append(str(error))
    return errors


def has_news():
    """Whether the panels would say something else than at the last question."""
    said = [(job.kind, job.words(), job.share()) for job in jobs.running]
    is_new = said != _said
    _said[:] = said
    return is_new


def cancel_all():
    for job in jobs.running:
        job.cancel()
    jobs.running.clear()


def draw(layout, kind):
    """Progress and Cancel of the kind's job, or what the last one ended with."""
    job = jobs.of(kind)
    if job is None:
        if last_words.get(kind):
            draw_words(layout, last_words[kind])
        return
    compat.draw_progress(layout, job.share(), job.words())
    layout.operator("hm.cancel_job", icon="CANCEL").kind = kind


def draw_words(layout, words, width=30):
    """In lines that fit the sidebar."""
    column = layout.column(align=True)
    line = ""
    for word in words.split():
        if line and len(line) + len(word) >= width:
            column.label(text=line)
            line = ""
        line = (line + " " + word).strip()
    column.label(text=line)


class HM_OT_cancel_job(bpy.types.Operator):
    """Ask the program to stop; nothing is left half written"""
    bl_idname = "hm.cancel_job"
    bl_label = "Cancel"
    kind: bpy.props.StringProperty(options={"HIDDEN"})

    def execute(self, context):
        job = jobs.of(self.kind)
        if job is not None:
            job.cancel()
        return {"FINISHED"}


CLASSES = (HM_OT_cancel_job,)
