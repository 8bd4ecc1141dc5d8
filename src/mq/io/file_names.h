#pragma once
/// What the name of a file, or how it begins, says about its format.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace mq {

/// ".png" of "A.PNG"; letters beyond ASCII as they are.
std::string lower_extension(const std::filesystem::path& path);

/// Whether a name ends like a model file (.obj, .ply, .gltf, .glb), the last two of these, or like a
/// picture.
bool names_model(const std::filesystem::path& path);
bool names_gltf(const std::filesystem::path& path);
bool names_picture(const std::filesystem::path& path);

/// Whether it is a GLB or USD (.usda, .usdz) for all frames, without a place for their numbers.
bool names_animation(const std::filesystem::path& path);

/// The extension of the format that a file's first bytes (256 are enough) belong to: of a picture, an
/// optical flow, a model, of JSON; text that begins with a line of an OBJ file is one. Empty where they are
/// nothing that is read here.
std::string extension_by_content(std::string_view first_bytes);

/// Whether it is a picture for numbers as well as colours: .exr and .tif.
bool holds_numbers(const std::filesystem::path& path);

/// What `write_model` makes beside a model that no file was read for, its `pictures` aside: the material library of
/// an OBJ with pictures, the buffer of a glTF that is no .glb.
std::vector<std::filesystem::path> files_beside_made(const std::filesystem::path& model, int pictures);

}  // namespace mq
