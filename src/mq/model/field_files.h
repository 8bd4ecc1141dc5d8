#pragma once
/// Files of several vector fields of one model, and of their lines.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mq/model/field_lines.h"
#include "mq/model/outputs.h"

namespace mq {

struct FieldFilesOptions {
  std::filesystem::path folder;
  std::string name;  ///< of what the fields are, such as their basis
  int count = 1;
  enum class Lines {
    none,
    textures,  ///< a picture for each texture
    vertices   ///< the model, with colours at its vertices
  } lines = Lines::none;
};

/// Where one field goes.
struct FieldFile {
  std::filesystem::path field;
  std::optional<Outputs> lines;  ///< none: no lines are written

  std::vector<std::filesystem::path> paths() const;
};

/// MODEL_NAME_01.ply and so on, with as many digits as the last number has; and for lines
/// MODEL_NAME_01.png, of several textures MODEL_NAME_01_TEXTURE.png, or MODEL_NAME_01_lines.ply.
std::vector<FieldFile> field_files(const Model& model, const FieldFilesOptions& options);

/// Writes the lines of one field, drawn on the unknowns of `signal`, as greys in place of the
/// model's textures or colours; nothing where the file has no lines. Returns what is worth telling.
std::vector<std::string> write_lines(const FieldFile& file, const Model& model,
                                     const ModelSignal& signal, const Signal& grey,
                                     const Progress& progress = {});

}  // namespace mq
