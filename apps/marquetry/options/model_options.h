#pragma once
/// The model as a verb is given it: options, reading, and what the report says of it.

#include <optional>
#include <string>
#include <vector>

#include "mq/model/textured_model.h"
#include "shell/run.h"

namespace mq::app {

/// Options "mesh" and "texture" (positional; the helps say what they are), --weld, --flipped,
/// --slot, --uv-set and --layer.
void add_model_options(
    OptionTable& table,
    const std::string& mesh_help = "the model: OBJ, PLY, glTF or GLB; or a picture",
    const std::string& texture_help =
        "pictures to use instead of those the model names, in its order");

/// Adds --compress, of glTF files that are written.
void add_compress_option(OptionTable& table);

/// What it asks for; none without the option. Throws `InvalidInput` where --output is no glTF file.
Compression asked_compression(const OptionValues& options);

/// Pictures for a model instead of those that "texture" names.
using ModelPictures = std::optional<std::vector<std::filesystem::path>>;

/// What --weld says.
WeldOptions asked_weld(const OptionValues& options);

/// What --flipped says.
AtlasOptions asked_flipped(const OptionValues& options);

/// Textures of a model that gets others.
struct TargetTextures {
  std::optional<int> side = {};        ///< of all, both ways; their pictures are left out
  int assumed = assumed_texture_side;  ///< of those without a picture
  std::optional<std::string> slot = {};  ///< where --slot speaks of another model
};

/// Reads what the options say, a model or a picture, and makes surface and atlas of it, as the step
/// "read" and the step "find charts" with half of `share` each. Fills in the report's input and
/// defects.
TexturedModel read_textured_model(Run& run, MissingPictures missing, double share,
                                  const ModelPictures& pictures = {},
                                  ImageTriangles picture = ImageTriangles::two,
                                  const TargetTextures& target = {}, const ModelWatch& watch = {});

/// The same, and throws `InvalidInput` naming the refused defects, if there are any; the others are
/// said as warnings.
TexturedModel read_usable_model(Run& run, MissingPictures missing, double share,
                                const ModelPictures& pictures = {},
                                ImageTriangles picture = ImageTriangles::two,
                                const TargetTextures& target = {});

/// Protects the files that a model came from: see `Run::will_read`.
void will_read_model(Run& run, const Model& model);

/// Puts into the report's input what the model is.
void describe_input(Run& run, const TexturedModel& model);

/// What the report's input says of a picture whose pixels are worked on, not a surface of it.
Json picture_json(const Model& picture);

/// Adds --depth, and gives all pictures and colours of a model the depth that it asks for.
void add_depth_option(OptionTable& table);
void set_depth(const OptionValues& options, Model& model);

/// What it asks for; nothing where depths are kept.
std::optional<Depth> asked_depth(const OptionValues& options);

/// "u8", "u16", "half" or "float".
std::string depth_name(Depth depth);

/// What the option --depth calls them: "8", "16", "half", "float".
Depth depth_from_name(const std::string& name);

}  // namespace mq::app
