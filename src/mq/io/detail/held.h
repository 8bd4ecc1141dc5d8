#pragma once
/// What reads and writes files asks first: whether the name is of something in memory (held_files.h).

#include <optional>
#include <span>

#include "mq/io/held_files.h"
#include "mq/io/image_file.h"

namespace mq {

/// What is held under the name; nothing where the name is a file's. Throws `IoError` where nothing is
/// held under such a name, or something else; and what the functions that read files throw.
std::optional<Texture> held_texture(const std::filesystem::path& path, NotFinite not_finite,
                                    const std::string& layer, const Progress& progress);
std::optional<PictureInfo> held_picture_info(const std::filesystem::path& path);
std::optional<Model> held_model(const std::filesystem::path& path, const ReadModelOptions& options,
                                const Progress& progress);

/// Keeps what would be written. False where the name is a file's.
bool hold_texture(const std::filesystem::path& path, const Texture& texture);
bool hold_model(const std::filesystem::path& path, const Model& model);
bool hold_flow(const std::filesystem::path& path, const Image<float>& field);
bool hold_field(const std::filesystem::path& path, const std::vector<Vector3>& field);
bool hold_bytes(const std::filesystem::path& path, std::span<const std::byte> bytes);

/// Throws `IoError` where the name is not a file's, before a file of it is asked for.
void require_file(const std::filesystem::path& path);

}  // namespace mq
