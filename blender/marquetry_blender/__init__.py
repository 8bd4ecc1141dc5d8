"""Marquetry for Blender: textures filtered on the surface, by the program marquetry."""
bl_info = {
    "name": "Marquetry",
    "description": "Signal processing on textured surfaces: filters that know no seams",
    "author": "Marquetry",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "Sidebars of the 3D view and the Image editor, Marquetry",
    "category": "UV",
}

import bpy

from . import job, operators, panels, program


class MarquetryPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    program: bpy.props.StringProperty(name="Program", subtype="FILE_PATH",
                                      description="The program marquetry; empty: the one on PATH")
    threads: bpy.props.IntProperty(name="Threads", min=0, max=4096,
                                   description="How many work; 0: one per core. The result is the same for any number")

    def draw(self, context):
        self.layout.prop(self, "program")
        self.layout.prop(self, "threads")
        try:
            self.layout.label(text=f"Found: {program.find(bpy.path.abspath(self.program))}", icon="CHECKMARK")
        except program.Refusal as refusal:
            self.layout.label(text=str(refusal), icon="ERROR")


classes = [MarquetryPreferences, *operators.classes, *panels.classes]


def register():
    for each in classes:
        bpy.utils.register_class(each)
    bpy.types.Scene.marquetry = bpy.props.PointerProperty(type=panels.MARQUETRY_PG_settings)


def unregister():
    job.close_all()
    del bpy.types.Scene.marquetry
    for each in reversed(classes):
        bpy.utils.unregister_class(each)
