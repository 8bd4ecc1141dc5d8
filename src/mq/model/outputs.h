#pragma once
/// Where changed signals go: a picture, a picture per texture, or a model.

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "mq/base/progress.h"
#include "mq/io/file_names.h"
#include "mq/io/model.h"

namespace mq {

class Outputs {
 public:
  enum class Kind {
    pictures,  ///< textures changed: pictures alone, or the model with them
    model      ///< the mesh file itself changed: only a model will do
  };

  /// `name` is a model (.obj, .ply, .gltf, .glb), a picture, a picture with %s for the texture's
  /// name or <UDIM> or <UVTILE> for the number of its tile (tiles.h), or a folder (it exists, or ends
  /// in /). Of textures of one name all but the first get a
  /// number, skin_2.png. A model with texture coordinates that names no pictures gets some, named after
  /// it. Throws `InvalidInput` when it does not fit the kind, or when one picture
  /// is to hold several textures.
  Outputs(const std::string& name, const Model& model, Kind kind);

  bool is_model() const { return is_model_; }

  const std::vector<std::filesystem::path>& paths() const { return paths_; }

  /// Folders to be made where they are not there: one that was named, and those below a model's own that
  /// its pictures lie in, as they did beside the one that was read.
  std::set<std::filesystem::path> folders() const;

  /// Writes the pictures, or the model. Beside its source, whose pictures stay, and where it has another name than its
  /// source, a model's changed pictures are named after it: results of one source share a folder. Returns what is worth telling.
  std::vector<std::string> write(Model model, const Progress& progress) const;

 private:
  void plan_model(const std::string& name, const Model& model, Kind kind);
  void plan_tiles(const struct TileName& name, const Model& model);
  void plan_copies(const std::filesystem::path& path, const Model& model);
  void plan_libraries(const std::filesystem::path& path, const Model& model);
  void plan_others(const std::filesystem::path& path, const Model& model);
  void plan_new_others(const std::filesystem::path& path, const Model& model);

  std::vector<std::filesystem::path> paths_;  ///< one per texture, or the model's, its pictures' and libraries'
  std::vector<std::string> texture_names_;    ///< in the model written; empty: as they were
  std::vector<std::string> other_names_;      ///< of its `others`, likewise
  std::filesystem::path folder_;
  bool is_model_ = false;
};

}  // namespace mq
