#include "mq/io/file_print.h"

#include "mq/io/bytes.h"
#include "mq/io/document.h"
#include "mq/io/detail/evolving_blocks.h"

namespace mq {

std::vector<std::filesystem::path> files_of(const Model& model) {
  if (!model.document) return {};
  std::vector<std::filesystem::path> files = model.document->files;
  for (const Texture& texture : model.textures)
    if (!texture.path.empty() && !texture.pixels.empty()) files.push_back(texture.path);
  return files;
}

FilePrint file_print(const std::filesystem::path& path) {
  const Bytes bytes = read_file(path);
  return {std::int64_t(bytes.size()), crc32(bytes)};
}

}  // namespace mq
