"""The operators: each writes files, runs a verb, and puts the results into Blender's data at the end."""
import os

import bpy
import numpy as np

from . import cameras, job, options, pictures, scene, uv_maps
from .job import out
from .program import Refusal
from .surface import read_ply

SECONDS_BETWEEN_LOOKS = 0.1


class VerbOperator:
    """What they have in common. `verb` is that of the program; properties are those of its option table."""
    verb = ""

    def value(self, row):
        """What the caller gave, or else what the panel shows."""
        name = options.key(row)
        given = self.properties.is_property_set(name)
        return getattr(self if given else getattr(bpy.context.scene.marquetry, self.verb), name)

    def is_on(self, name):
        """A setting that several verbs share."""
        given = self.properties.is_property_set(name)
        return getattr(self if given else bpy.context.scene.marquetry, name)

    def row(self, name):
        return next(row for row in options.rows(self.verb) if row["name"] == name)

    def option_words(self, folder, saved=()):
        """`saved`: the pictures that are processed; an option that is a picture wants one for each."""
        def picture_words(row, name):
            image = bpy.data.images.get(name)
            if image is None:
                raise Refusal(f"{options.label(row)}: there is no image {name}")
            if len(saved) > 1:
                raise Refusal(f"{options.label(row)} is one image, but {len(saved)} are processed: "
                              "do one of them, by the panel of the Image editor")
            picture = pictures.Picture(image, row["name"])
            picture.save(folder)
            return ["--" + row["name"], picture.file]

        return options.words_of(self.verb, self.value, picture_words)

    def start(self, context):
        """A job, or None after a report of why there is none."""
        self.names = {}
        try:
            prepare, finish = self.plan(context)
            return job.Job(self.verb, prepare, finish)
        except Refusal as refusal:
            self.report({"ERROR"}, str(refusal))
        except OSError as error:
            self.report({"ERROR"}, f"files for marquetry cannot be written: {error}")
        return None

    def end(self, state, told):
        for level, text in told:
            self.report({level}, pictures.with_names_of_images(text, self.names))
        return {state}

    def execute(self, context):
        """To the end in one go: for scripts and without a window."""
        started = self.start(context)
        return self.end(*started.wait()) if started else {"CANCELLED"}

    def invoke(self, context, event):
        if bpy.app.background:
            return self.execute(context)
        self.job = self.start(context)
        if self.job is None:
            return {"CANCELLED"}
        manager = context.window_manager
        self.timer = manager.event_timer_add(SECONDS_BETWEEN_LOOKS, window=context.window)
        manager.modal_handler_add(self)
        self.show(context)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        escape = event.type == "ESC" and event.value == "PRESS"
        if event.type != "TIMER" and not escape:
            return {"PASS_THROUGH"}
        try:
            state, told = self.job.step("ESC" if escape else "TIMER")
        except BaseException:
            self.leave(context)
            raise
        if state == "RUNNING_MODAL":
            self.show(context)
            return {state if escape else "PASS_THROUGH"}  # timers are for others too
        self.leave(context)
        return self.end(state, told)

    def show(self, context):
        context.workspace.status_text_set(self.job.run.words())

    def leave(self, context):
        context.window_manager.event_timer_remove(self.timer)
        context.workspace.status_text_set(None)
        for window in context.window_manager.windows:
            for area in window.screen.areas:
                area.tag_redraw()  # buttons that could not be pressed

    def cancel(self, context):
        """Blender ends, or loads another file."""
        self.job.close()
        self.leave(context)


class PictureOperator(VerbOperator):
    """A verb that changes the pictures of the object."""

    def wants_normals(self):
        """Whether a picture may be a normal map, which is told in the axes of corner normals."""
        names = {row["name"] for row in options.rows(self.verb)}
        return "normals" in names and self.value(self.row("normals")) or \
            "normal-space" in names and self.value(self.row("normal-space")) != "auto"

    def plan(self, context):
        thing = scene.active_object(context)
        uv_name = scene.active_uv_map(thing)
        only = bpy.data.images.get(self.image) if self.image else None
        if self.image and only is None:
            raise Refusal(f"there is no image {self.image}")
        saved = []

        def prepare(folder):
            surface, slots = scene.surface_of(context, thing, uv_name, self.is_on("modifiers"))
            images, table = scene.images_of(thing, slots, only)
            saved.extend(scene.save_pictures(images, folder))
            self.names.update((picture.stem, picture.name) for picture in saved)
            surface.write(os.path.join(folder, "surface.ply"), [picture.file for picture in saved], table,
                          self.wants_normals())
            return ["surface.ply", "-o", "out/", *self.option_words(folder, saved),
                    *self.further_words(context, folder)]

        def finish(folder):
            told = [each for picture in saved for each in picture.put(out(folder), self.verb)]
            if any(picture.tiled for picture in saved):
                bpy.ops.ed.undo_push(message=self.bl_label)
            return told

        return prepare, finish

    def further_words(self, context, folder):
        return []


class TextureOperator(PictureOperator):
    """A texture of the photographs of the scene's cameras."""

    def further_words(self, context, folder):
        return ["--cameras", cameras.write(context.scene, context.evaluated_depsgraph_get(), folder)]


class UnwrapOperator(VerbOperator):
    def plan(self, context):
        thing = scene.active_object(context)
        if thing.data.library:
            raise Refusal(f"{thing.data.name} is linked from {thing.data.library.filepath}: make it local first")
        surface, _ = scene.surface_of(context, thing, None, False)
        name = thing.name

        def prepare(folder):
            surface.write(os.path.join(folder, "surface.ply"))
            return ["surface.ply", "-o", "unwrapped.ply", *self.option_words(folder)]

        def finish(folder):
            still = unchanged(name, surface)
            faces = read_ply(os.path.join(folder, "unwrapped.ply"))["face"]
            cut = uv_maps.give(still, surface, scene.corner_values(surface, faces, still), "Marquetry")
            return [("INFO", f"{cut} polygons that a seam crosses were cut along it")] if cut else []

        return prepare, finish


class BakeOperator(VerbOperator):
    def plan(self, context):
        thing = scene.active_object(context)
        target = scene.active_uv_map(thing)
        source = next((layer.name for layer in thing.data.uv_layers if layer.active_render), target)
        if source == target:
            raise Refusal(f"UV map {target} is the one that renders: make another one active, "
                          "for example by Unwrap, and leave the camera icon at the old one")
        saved, name = [], thing.name
        result = []

        def prepare(folder):
            surface, slots = scene.surface_of(context, thing, source, self.is_on("modifiers"))
            other, _ = scene.surface_of(context, thing, target, self.is_on("modifiers"))
            images, table = scene.images_of(thing, slots, None)
            saved.extend(scene.save_pictures(images, folder))
            self.names.update((picture.stem, picture.name) for picture in saved)
            normals = self.value(self.row("normal-space")) != "auto"
            surface.write(os.path.join(folder, "source.ply"), [picture.file for picture in saved], table, normals)
            other.write(os.path.join(folder, "target.ply"), with_normals=normals)
            result.append("baked.exr" if any(picture.is_float for picture in saved) else "baked.png")
            return ["source.ply", "target.ply", "-o", result[0], *self.option_words(folder)]

        def finish(folder):
            values = pictures.pixels_of_file(os.path.join(folder, result[0]))
            image = pictures.new_image(f"{name} baked", values, result[0].endswith(".exr"))
            if not image.is_float and saved[0].image is not None:
                image.colorspace_settings.name = saved[0].image.colorspace_settings.name
            return [("INFO", f"baked from UV map {source} to {target}: image {image.name}; give it to the materials")]

        return prepare, finish


class GeodesicOperator(VerbOperator):
    def place_words(self, context):
        mask = self.value(self.row("from-mask"))
        return [] if mask else ["--from=" + ",".join(str(float(x)) for x in context.scene.cursor.location)]

    def plan(self, context):
        thing = scene.active_object(context)
        return self.plan_vertices(context, thing) if self.is_on("into") == "VERTICES" else \
            self.plan_image(context, thing)

    def plan_vertices(self, context, thing):
        if thing.data.library:
            raise Refusal(f"{thing.data.name} is linked from {thing.data.library.filepath}: make it local first")
        surface, _ = scene.surface_of(context, thing, None, False)
        name, shows_numbers = thing.name, self.value(self.row("show")) == "numbers"

        def prepare(folder):
            surface.write(os.path.join(folder, "surface.ply"))
            return ["surface.ply", "--vertices", "-o", "distance.ply", *self.place_words(context),
                    *self.option_words(folder)]

        def finish(folder):
            rows = read_ply(os.path.join(folder, "distance.ply"))["vertex"]
            give_attribute(unchanged(name, surface).data, rows, shows_numbers)
            return []

        return prepare, finish

    def plan_image(self, context, thing):
        uv_name = scene.active_uv_map(thing)
        numbers = self.value(self.row("show")) == "numbers"
        ending = ".exr" if numbers else ".png"
        name, blanks = thing.name, []

        def prepare(folder):
            surface, slots = scene.surface_of(context, thing, uv_name, self.is_on("modifiers"))
            try:
                images, table = scene.images_of(thing, slots, None)
            except scene.NoImages:
                images, table = [], [0]
            blanks.extend([Blank(image, number, ending) for number, image in enumerate(images)] or
                          [Blank(None, 0, ending)])
            for blank in blanks:
                blank.save(folder)
            self.names.update((blank.stem, blank.like or "the image") for blank in blanks)
            surface.write(os.path.join(folder, "surface.ply"), [blank.file for blank in blanks], table)
            return ["surface.ply", "-o", "out/", *self.place_words(context), *self.option_words(folder, blanks)]

        def finish(folder):
            return [("INFO", blank.put(out(folder), f"{name} distance")) for blank in blanks]

        return prepare, finish


class Blank:
    """An empty picture of the size of an image, into which a result goes; it becomes a datablock of its own."""
    side = 1024  # without an image

    def __init__(self, image, number, ending):
        if image is not None:
            pictures.check(image)
        self.like = image.name if image else None
        self.tiled = image is not None and image.source == "TILED"
        self.stem, self.ending = f"picture{number}", ending
        self.is_float = ending == ".exr"

    @property
    def file(self):
        return self.stem + (".<UDIM>" if self.tiled else "") + self.ending

    def save(self, folder):
        image = bpy.data.images[self.like] if self.like else None
        sizes = {str(tile.number): tuple(tile.size) for tile in image.tiles} if self.tiled else \
            {"": tuple(image.size) if image else (self.side, self.side)}
        for number, (width, height) in sizes.items():
            path = os.path.join(folder, self.file.replace("<UDIM>", number))
            if self.is_float:
                pictures.write_exr(path, np.zeros((height, width, 3), np.float32))
            else:
                pictures.write_png(path, np.zeros((height, width, 3), np.uint8))

    def put(self, folder, name):
        if not self.tiled:
            values = pictures.pixels_of_file(os.path.join(folder, self.file))
            made = pictures.new_image(name, values[..., :3], self.is_float, self.is_float)
        else:
            made = bpy.data.images[self.like].copy()
            made.name = name
            made.filepath_raw = os.path.join(folder, self.file)
            made.reload()
            made.pack()
            made.use_fake_user = True
        return f"distances are in image {made.name}"


def unchanged(name, surface):
    """The object, if it still has the vertices and corners that results are for."""
    thing = bpy.data.objects.get(name)
    if thing is None:
        raise Refusal(f"{name} is gone, and so is what was made of it")
    if thing.mode == "EDIT":
        raise Refusal(f"{name} is in edit mode, so that the result cannot be given to it: do it again")
    mesh = thing.data
    if len(mesh.vertices) != len(surface.positions) or surface.loops.max() >= len(mesh.loops) or \
            len(mesh.polygons) <= surface.polygons.max():
        raise Refusal(f"{name} was changed meanwhile: do it again")
    return thing


def give_attribute(mesh, rows, as_numbers):
    """Distances at vertices as a number, or as colours with lines."""
    name = "distance" if as_numbers else "distance colours"
    if name in mesh.attributes:
        mesh.attributes.remove(mesh.attributes[name])
    if as_numbers:
        mesh.attributes.new(name, "FLOAT", "POINT").data.foreach_set("value", rows["red"].astype(np.float32))
        return
    colours = np.ones((len(rows), 4), np.float32)
    for channel, word in enumerate(("red", "green", "blue")):
        stored = rows[word] / 255 if rows[word].dtype == np.uint8 else rows[word]
        # Attributes of floats hold linear light.
        colours[:, channel] = np.where(stored <= 0.04045, stored / 12.92, ((stored + 0.055) / 1.055) ** 2.4)
    mesh.color_attributes.new(name, "FLOAT_COLOR", "POINT").data.foreach_set("color", colours.ravel())
    mesh.color_attributes.active_color = mesh.color_attributes[name]


#: Settings of the add-on's own: kinds of properties, and their words.
OWN = {
    "modifiers": (bpy.props.BoolProperty, {
        "name": "Modifiers", "default": True,
        "description": "Work on the surface as modifiers make it, as it is seen; else on the mesh itself"}),
    "into": (bpy.props.EnumProperty, {
        "name": "Into", "description": "Where distances go",
        "items": [("IMAGE", "Image", "A new image"), ("VERTICES", "Vertices", "An attribute of the mesh")]}),
    "image": (bpy.props.StringProperty, {
        "name": "Image", "description": "The image that is processed; without a name those of all materials"}),
}


def own_properties(names, flags=frozenset()):
    return {name: OWN[name][0](options=set(flags), **OWN[name][1]) for name in names}


#: verb, base, words on the button, own properties
OPERATORS = [
    ("filter", PictureOperator, "Filter", ("modifiers", "image")),
    ("texture", TextureOperator, "Texture from Cameras", ("modifiers", "image")),
    ("stitch", PictureOperator, "Stitch Charts", ("modifiers", "image")),
    ("seams", PictureOperator, "Seams", ("modifiers", "image")),
    ("fill", PictureOperator, "Fill", ("modifiers", "image")),
    ("denoise", PictureOperator, "Denoise Bake", ("modifiers", "image")),
    ("shock", PictureOperator, "Shock", ("modifiers", "image")),
    ("geodesic", GeodesicOperator, "Geodesic from Cursor", ("modifiers", "into")),
    ("unwrap", UnwrapOperator, "Unwrap", ()),
    ("bake", BakeOperator, "Bake to New UVs", ("modifiers",)),
]


def make(verb, base, words, own):
    changes_pictures = issubclass(base, PictureOperator)
    kept_out = {"SKIP_SAVE"}  # the panel's settings count, not those of the last call
    return type(f"MARQUETRY_OT_{verb}", (base, bpy.types.Operator), {
        "bl_idname": f"marquetry.{verb}", "bl_label": words,
        "bl_description": options.TABLES[verb]["summary"].rstrip("."),
        # Pictures have an undo of their own, see pictures.push_undo.
        "bl_options": {"REGISTER"} if changes_pictures else {"REGISTER", "UNDO"}, "verb": verb,
        "__annotations__": {**options.annotations(verb, kept_out), **own_properties(own, kept_out)}})


classes = [make(*row) for row in OPERATORS]
