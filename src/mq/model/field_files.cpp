#include "mq/model/field_files.h"

#include <fmt/format.h>

#include <algorithm>

namespace mq {

std::vector<std::filesystem::path> FieldFile::paths() const {
  std::vector<std::filesystem::path> all = {field};
  if (lines) all.insert(all.end(), lines->paths().begin(), lines->paths().end());
  return all;
}

std::vector<FieldFile> field_files(const Model& model, const FieldFilesOptions& options) {
  using Lines = FieldFilesOptions::Lines;
  const std::size_t digits = std::max<std::size_t>(2, std::to_string(options.count).size());
  std::vector<FieldFile> files;
  for (int k = 1; k <= options.count; ++k) {
    const std::string name =
        (options.folder /
         fmt::format("{}_{}_{:0{}}", model.path.stem().string(), options.name, k, digits))
            .string();
    FieldFile& file = files.emplace_back(FieldFile{name + ".ply", std::nullopt});
    if (options.lines == Lines::vertices)
      file.lines.emplace(name + "_lines.ply", model, Outputs::Kind::model);
    if (options.lines == Lines::textures)
      file.lines.emplace(name + (model.textures.size() > 1 ? "_%s.png" : ".png"), model,
                         Outputs::Kind::pictures);
  }
  return files;
}

std::vector<std::string> write_lines(const FieldFile& file, const Model& model,
                                     const ModelSignal& signal, const Signal& grey,
                                     const Progress& progress) {
  if (!file.lines) return {};
  Model drawn = model;
  signal.replace(grey.replicate(1, 3), Depth::u8, drawn);
  return file.lines->write(std::move(drawn), progress);
}

}  // namespace mq
