"""Settings in the scene, and panels that show them: sidebars of the 3D view and of the Image editor."""
import bpy

from . import cameras, job, options
from .operators import OPERATORS, own_properties

settings_classes = [type(f"MARQUETRY_PG_{verb}", (bpy.types.PropertyGroup,), {
    "__annotations__": options.annotations(verb)}) for verb, *_ in OPERATORS]


class MARQUETRY_PG_settings(bpy.types.PropertyGroup):
    show_all: bpy.props.BoolProperty(name="All options", description="Show options of the solver and the model too")


MARQUETRY_PG_settings.__annotations__.update(own_properties(["modifiers", "into"]))
MARQUETRY_PG_settings.__annotations__.update(
    {row[0]: bpy.props.PointerProperty(type=group) for row, group in zip(OPERATORS, settings_classes)})


def draw_options(layout, verb, settings):
    group = getattr(settings, verb)
    heading = None
    for row in options.rows(verb):
        if row["group"] in options.SELDOM and not settings.show_all:
            continue
        if row["group"] != heading:
            heading = row["group"]
            column = layout.column(heading="")
            if heading.lower() != verb:
                column.label(text=heading)
        name, label = options.key(row), options.label(row)
        if row["name"] in options.PICTURES:
            column.prop_search(group, name, bpy.data, "images", text=label)
        else:
            column.prop(group, name)


class MainPanel:
    bl_label = "Marquetry"
    bl_region_type = "UI"
    bl_category = "Marquetry"

    def draw(self, context):
        layout, settings = self.layout, context.scene.marquetry
        thing = context.active_object
        if thing is None or thing.type != "MESH":
            layout.label(text="No mesh is active", icon="INFO")
            return
        layout.label(text=thing.name, icon="MESH_DATA")
        layer = thing.data.uv_layers.active
        layout.label(text=layer.name if layer else "No UV map", icon="GROUP_UVS")
        layout.prop(settings, "modifiers")
        layout.prop(settings, "show_all")
        if job.at_work is not None:
            layout.label(text=job.at_work.run.words())


class VerbPanel:
    bl_region_type = "UI"
    bl_category = "Marquetry"
    bl_options = {"DEFAULT_CLOSED"}
    verb, own = "", ()

    def draw(self, context):
        layout, settings = self.layout, context.scene.marquetry
        layout.use_property_split = True
        for name in self.own:
            if name == "into":
                layout.prop(settings, name)
        if self.verb == "texture":
            layout.label(text=f"{len(cameras.with_photographs(context.scene))} cameras with photographs")
        draw_options(layout, self.verb, settings)
        row = layout.row()
        row.enabled = job.at_work is None
        pressed = row.operator(f"marquetry.{self.verb}")
        shown = getattr(context.space_data, "image", None) if context.space_data.type == "IMAGE_EDITOR" else None
        if shown is not None and "image" in self.own:
            pressed.image = shown.name


def panels_of(space, short):
    main = type(f"MARQUETRY_PT_{short}", (MainPanel, bpy.types.Panel), {"bl_space_type": space})
    parts = [type(f"MARQUETRY_PT_{short}_{verb}", (VerbPanel, bpy.types.Panel), {
        "bl_space_type": space, "bl_label": words, "bl_parent_id": main.__name__, "verb": verb, "own": own})
        for verb, _, words, own in OPERATORS]
    return [main, *parts]


classes = [*settings_classes, MARQUETRY_PG_settings, *panels_of("VIEW_3D", "view"),
           *panels_of("IMAGE_EDITOR", "image")]
