#pragma once
/// A model as one works with it: read, welded, its charts found, its pictures fit to be processed.

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "mq/atlas/atlas.h"
#include "mq/fem/image_space.h"
#include "mq/io/model.h"
#include "mq/io/model_watch.h"
#include "mq/mesh/surface.h"
#include "mq/model/messages.h"

namespace mq {

/// What is done about textures that have texture coordinates but no picture.
enum class MissingPictures {
  refuse,   ///< an error
  assume,   ///< as if they had `assumed_side`² texels, with a remark; files that are named must be there
  overlook, ///< the same, and so are those whose files are not there, with a remark on these
  by_head,  ///< pictures are not read: how large they are is what the heads of their files say
  unneeded  ///< nothing: only the shape is of interest, and there is no atlas
};
inline constexpr int assumed_texture_side = 2048;  ///< what `unwrap` packs charts for by default

struct LoadOptions {
  std::vector<std::filesystem::path> textures = {};  ///< in place of the pictures that the model names
  WeldOptions weld = {};
  AtlasOptions atlas = {};
  MissingPictures missing = MissingPictures::refuse;

  /// Texels of all textures, both ways, whatever pictures they have, which are left out: what they
  /// show is to be replaced.
  std::optional<int> side = {};
  int assumed_side = assumed_texture_side;  ///< of those without a picture
  ImageTriangles picture = ImageTriangles::two;  ///< of a picture in place of a model
  std::string slot = {};  ///< whose pictures are processed (`ReadModelOptions::slot`)
  int uv_set = -1;        ///< for all of them; −1: to each the one its material names
  std::string layer = {}; ///< of all pictures (`ReadModelOptions::layer`)
};

/// Refers to nothing outside; signals made of it refer to it.
struct TexturedModel {
  Model model;
  Surface surface;
  std::optional<Atlas> atlas;               ///< nothing where the mesh has no texture coordinates
  std::vector<TextureSize> texture_sizes;   ///< of the textures that triangles use
  bool is_picture = false;                  ///< made of a picture, which has no mesh file

  /// Everything found wrong with file, surface and atlas.
  Defects defects() const;
};

/// Throws `InvalidInput` naming the file and the refused defects, if there are any.
void require_usable(const Defects& defects, const std::string& file);

/// A picture as the flat surface of one chart that `image_rectangle` describes. Throws what
/// `read_texture` throws.
Model read_picture(const std::filesystem::path& path, ImageTriangles triangles,
                   const Progress& progress = {}, NotFinite not_finite = NotFinite::refuse,
                   const std::string& layer = {});

/// Reads the file: a model, whose pictures may hold values that are not finite, or such a picture
/// (`read_picture`, which nobody watches). Throws what `read_model` and `read_texture` throw, and `InvalidInput` where
/// pictures, a slot or a UV set are named beside a picture.
Model read_input(const std::filesystem::path& path, const LoadOptions& options,
                 const Progress& progress = {}, const ModelWatch& watch = {});

/// Surface, charts and sizes of a model that was read. Values of pictures that are infinite or no
/// numbers and that no chart reads become those of the nearest texel that one does (bakes hold such
/// where nothing was baked). A triangle of a picture in tiles that reaches more than a texel into a
/// neighbouring tile is a defect. Remarks on what the reader coped with, on that, and on sizes that were
/// assumed. Throws `InvalidInput` for a model without faces, a texture without picture (see
/// `MissingPictures`), and `IoError` for a value that is not finite inside a chart.
TexturedModel textured_model(Model model, const LoadOptions& options, Messages& messages,
                             const Progress& progress = {});

/// Both.
TexturedModel load_textured_model(const std::filesystem::path& path, const LoadOptions& options,
                                  Messages& messages, const Progress& progress = {});

/// A textured model of one of which one was made before, with other textures or texture coordinates: what is to be said of
/// its files was said then.
TexturedModel textured_again(Model model, const LoadOptions& options, Messages& messages,
                             const Progress& progress = {});

/// Runs `work`, which is about the model: where it throws `InvalidInput` or `Unsupported` without naming the
/// model's file, the name is put before the message.
void about(const Model& model, const std::function<void()>& work);

/// What a texture is called where its file matters: the picture's path, or that it is embedded.
std::string texture_file(const Model& model, std::size_t i);

}  // namespace mq
