# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the programs are."""
import bpy
from bpy.props import StringProperty

from .. import compat
from ..services import programs
from ..services.errors import InputError

PACKAGE = __package__.rpartition(".")[0]   # the add-on's own name, which an extension's repository changes


class HM_AP_preferences(bpy.types.AddonPreferences):
    bl_idname = PACKAGE
    programs: StringProperty(name="Programs", subtype="DIR_PATH", options=compat.path_options(),
                             description="Folder with openhumanbrdf and humanmaterial. Empty: that of the variable "
                                         "HM_TOOLS, or the PATH")

    environments: StringProperty(name="Environments", subtype="DIR_PATH", options=compat.path_options(),
                                 description="Folder of EXR and HDR pictures that the panel Light shows")

    def draw(self, context):
        self.layout.prop(self, "environments")
        self.layout.prop(self, "programs")
        try:
            self.layout.label(text=find("openhumanbrdf"), icon="CHECKMARK")
        except InputError as error:
            self.layout.label(text=str(error), icon="ERROR")


def _folder(name):
    entry = bpy.context.preferences.addons.get(PACKAGE)
    folder = getattr(entry.preferences, name, "") if entry and entry.preferences else ""
    return bpy.path.abspath(folder) if folder else ""


def find(name):
    """The program's path. Raises InputError."""
    return programs.find(name, _folder("programs"))


def environments():
    """The folder of environments, or ""."""
    return _folder("environments")


CLASSES = (HM_AP_preferences,)
