#pragma once
/// A model as most verbs want it: read, welded, its charts found, and all of it in the report.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "mq/atlas/atlas.h"
#include "mq/io/model.h"
#include "mq/mesh/surface.h"
#include "shell/run.h"

namespace mq::app {

struct Scene {
  Model model;
  Surface surface;
  std::optional<Atlas> atlas;  ///< nothing where the mesh has no texture coordinates
  std::vector<TextureSize> texture_sizes;
};

/// Options "mesh" and "texture" (positional; the helps say what they are), --weld and --flipped.
void add_scene_options(OptionTable& table,
                       const std::string& mesh_help = "the model: OBJ, PLY, glTF or GLB",
                       const std::string& texture_help =
                           "pictures to use instead of those the model names, in its order");

/// What is done about textures that have texture coordinates but no picture.
enum class MissingPictures {
  refuse,   ///< an error
  assume,   ///< as if they had `assumed_texture_side`² texels, with a remark
  unneeded  ///< nothing: the verb works on the shape alone, and there is no atlas
};
inline constexpr int assumed_texture_side = 1024;

/// Pictures for a model instead of those that "texture" names.
using ScenePictures = std::optional<std::vector<std::filesystem::path>>;

/// Protects the files that a model came from: see `Run::will_read`.
void will_read_model(Run& run, const Model& model);

/// Puts into the report's input what the model is.
void describe_input(Run& run, const Scene& scene);

/// Reads what the options say and makes surface and atlas of it, as the step "read" and the step
/// "find charts" with half of `share` each. Fills in the report's input and defects.
Scene read_scene(Run& run, MissingPictures missing, double share,
                 const ScenePictures& pictures = {});

/// The same, and throws `InvalidInput` naming the refused defects, if there are any; the others are
/// said as warnings.
Scene read_usable_scene(Run& run, MissingPictures missing, double share,
                        const ScenePictures& pictures = {});

/// Everything found wrong so far with file, surface and atlas.
Defects scene_defects(const Scene& scene);

/// Does what is about the model: an `InvalidInput` or `Unsupported` of it that does not name the
/// model's file is thrown again with the name.
void about(const Model& model, const std::function<void()>& work);

/// What a texture is called where its file matters: the picture's path, or that it is embedded.
std::string texture_file(const Model& model, std::size_t i);

/// Throws `InvalidInput` naming the refused defects, if there are any.
void require_usable(const Defects& defects, const std::string& file);

/// "u8", "u16", "half" or "float".
std::string depth_name(Depth depth);

/// What the option --depth calls them: "8", "16", "half", "float".
Depth depth_from_name(const std::string& name);

}  // namespace mq::app
