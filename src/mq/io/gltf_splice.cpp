// Positions go back through the node they were read through, x = M⁻¹ p, and only elements that
// moved are written. An embedded picture of another size moves the views behind it in its buffer.
#include <Eigen/Geometry>
#include <Eigen/LU>

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <map>

#include "mq/base/error.h"
#include "mq/io/detail/gltf_container.h"
#include "mq/io/detail/gltf_meshopt.h"
#include "mq/io/detail/gltf_scene.h"
#include "mq/io/detail/json_text.h"
#include "mq/io/uri.h"

namespace mq {
namespace {

class GltfSplicer {
 public:
  GltfSplicer(const Model& model, const Document& document,
              const std::vector<GltfPicture>& pictures, const std::string& stem)
      : model_(model),
        document_(document),
        pictures_(pictures),
        stem_(stem),
        file_(document),
        scene_(read_gltf_scene(file_, document.choice)),
        says_(scene_.file) {}

  /// The files, or none where the change is too large to be spliced in.
  GltfOutput splice() {
    if (!same_connectivity(says_.mesh, model_.mesh) || says_.mesh.uvs != model_.mesh.uvs ||
        !assign_pictures())
      return {};
    if (!edit_positions() || !edit_colors() || !edit_pictures()) return {};
    GltfOutput output;
    output.files.resize(1);
    store_buffers(output.files);
    output.files[0] = {stem_, mesh_file()};
    if (!buffers_.empty() && !reads_back(output.files)) return {};
    for (std::size_t t = 0; t < model_.textures.size(); ++t)
      output.embedded.push_back(!says_.textures[picture_of(t)].picture.empty());
    for (const TextureSlot& slot : says_.others) output.embedded.push_back(!slot.picture.empty());
    output.embedded.resize(std::max(output.embedded.size(), pictures_.size()));
    for (std::size_t s = 0; s < now_.size(); ++s) output.images.try_emplace(image_of(s), now_numbers_[s]);
    return output;
  }

 private:
  /// Whether nothing else changed: accessors may share the bytes that were written.
  bool reads_back(const std::vector<OutputFile>& files) const {
    Document document{document_.format, stem_, files[0].bytes, files, {}, document_.choice};
    try {
      const MeshFile now = read_gltf(document);
      return same_connectivity(now.mesh, says_.mesh) && now.mesh.uvs == says_.mesh.uvs;
    } catch (const Error&) {
      return false;
    }
  }

  /// The picture of the file that a texture is, or is a tile of.
  std::size_t picture_of(std::size_t texture) const {
    return model_.tiles.empty() ? texture : std::size_t(model_.tiles[texture].picture);
  }

  /// Finds out which picture each of the file's becomes; false where that takes a new file.
  bool assign_pictures() {
    const std::size_t textures = model_.textures.size();
    std::vector<std::string> names;
    for (const GltfPicture& picture : pictures_) names.push_back(picture.name);
    const auto slots = slot_names(says_, model_, names);
    if (!slots || slots->size() != says_.textures.size() || (slots->empty() && textures > 0) ||
        names.size() < textures)
      return false;
    for (std::size_t s = 0; s < slots->size(); ++s) {
      std::size_t t = 0;
      while (t < textures && picture_of(t) != s) ++t;
      if (t == textures) return false;
      now_.push_back(pictures_[t]);
      now_.back().name = (*slots)[s];
      now_numbers_.push_back(t);
    }
    if (says_.others.size() <= names.size() - textures)
      for (std::size_t i = textures; i < textures + says_.others.size(); ++i) {
        now_.push_back(pictures_[i]);
        now_numbers_.push_back(i);
      }
    return true;
  }

  /// A copy of a buffer to be changed.
  Bytes& changed_buffer(int b) {
    const auto place = buffers_.try_emplace(b);
    if (place.second) {
      const ByteView bytes = file_.buffer(b);
      place.first->second.assign(bytes.begin(), bytes.end());
    }
    return place.first->second;
  }

  bool replace(std::initializer_list<JsonStep> steps, const std::string& value) {
    const auto place = find_json(file_.json_text(), steps);
    if (place) edits_.push_back({place->begin, place->end, value});
    return place.has_value();
  }

  bool edit_positions() {
    std::map<std::int64_t, int> uses;
    for (const GltfBlock& block : scene_.blocks) ++uses[block.positions];
    for (const GltfBlock& block : scene_.blocks) {
      const auto begin = block.begin, end = block.begin + block.count;
      if (std::equal(model_.mesh.positions.begin() + begin, model_.mesh.positions.begin() + end,
                     says_.mesh.positions.begin() + begin))
        continue;
      const auto layout = file_.layout(block.positions);
      const Eigen::Matrix4d inverse = block.matrix.inverse();
      if (!layout || uses[block.positions] > 1 || !inverse.allFinite() ||
          file_.values(block.positions, {3}).type != GltfType::f32)
        return false;
      Bytes& bytes = changed_buffer(layout->buffer);
      for (int v = begin; v < end; ++v) {
        const Vector3& now = model_.mesh.positions[std::size_t(v)];
        if (now == says_.mesh.positions[std::size_t(v)]) continue;
        const Eigen::Vector3f local = (inverse * now.homogeneous()).head<3>().cast<float>();
        if (!local.allFinite()) return false;
        std::memcpy(bytes.data() + layout->offset + std::size_t(v - begin) * layout->stride,
                    local.data(), sizeof local);
      }
      edit_bounds(block, *layout, bytes);
    }
    return true;
  }

  void edit_bounds(const GltfBlock& block, const GltfLayout& layout, const Bytes& bytes) {
    Eigen::Vector3f least = Eigen::Vector3f::Constant(std::numeric_limits<float>::max());
    Eigen::Vector3f largest = -least;
    for (int i = 0; i < block.count; ++i) {
      Eigen::Vector3f x;
      std::memcpy(x.data(), bytes.data() + layout.offset + std::size_t(i) * layout.stride,
                  sizeof x);
      least = least.cwiseMin(x);
      largest = largest.cwiseMax(x);
    }
    const auto text = [](const Eigen::Vector3f& v) {
      return fmt::format("[{},{},{}]", v.x(), v.y(), v.z());
    };
    const auto accessor = std::size_t(block.positions);
    replace({"accessors", accessor, "min"}, text(least));
    replace({"accessors", accessor, "max"}, text(largest));
  }

  bool edit_colors() {
    if (color_channels(model_.colors) != says_.colors.channels) return false;
    std::map<std::int64_t, int> uses;
    for (const GltfBlock& block : scene_.blocks) ++uses[block.colors];
    for (const GltfBlock& block : scene_.blocks) {
      if (!recolored(block)) continue;
      if (block.colors < 0 || uses[block.colors] > 1 || !store_colors(block)) return false;
    }
    return true;
  }

  bool recolored(const GltfBlock& block) const {
    for (int v = block.begin; v < block.begin + block.count; ++v)
      for (int c = 0; c < says_.colors.channels; ++c)
        if (color(model_.colors, v, c) != color(says_.colors, v, c)) return true;
    return false;
  }

  bool store_colors(const GltfBlock& block) {
    const auto layout = file_.layout(block.colors);
    const GltfValues values = file_.values(block.colors, {3, 4});
    const bool floats = values.type == GltfType::f32;
    if (!layout || (!floats && values.type != GltfType::u8 && values.type != GltfType::u16))
      return false;
    Bytes& bytes = changed_buffer(layout->buffer);
    for (int i = 0; i < block.count; ++i)
      for (int c = 0; c < values.components; ++c) {
        std::byte* to = bytes.data() + layout->offset + std::size_t(i) * layout->stride +
                        std::size_t(c * size_of(values.type));
        const float value = color(model_.colors, block.begin + i, c);
        const unsigned stored = stored_color(value, unsigned(largest_of(values.type)));
        const auto narrow = std::uint16_t(stored);
        std::memcpy(to, floats ? static_cast<const void*>(&value) : &narrow,
                    std::size_t(size_of(values.type)));
      }
    return true;
  }

  /// The image of the file that one of `now_` is.
  std::int64_t image_of(std::size_t s) const {
    const std::size_t textures = says_.textures.size();
    return s < textures ? scene_.images[s] : scene_.other_images[s - textures];
  }

  bool edit_pictures() {
    const std::size_t textures = says_.textures.size();
    for (std::size_t s = 0; s < now_.size(); ++s) {
      const TextureSlot& slot = s < textures ? says_.textures[s] : says_.others[s - textures];
      if (!edit_picture(slot, image_of(s), now_[s])) return false;
    }
    return edit_views();
  }

  bool edit_picture(const TextureSlot& slot, std::int64_t id, const GltfPicture& now) {
    const auto image = std::size_t(id);
    if (slot.picture.empty())
      return now.name == slot.name ||
             replace({"images", image, "uri"}, json_string(uri_of_name(now.name)));
    if (!now.changed) return true;
    const Bytes bytes = now.file();
    if (bytes.empty()) return true;
    const Json& object = file_.item("images", id);
    const bool stored =
        object.contains("bufferView")
            ? replace_view(json_count(object, "bufferView", 0, file_.name()), bytes)
            : replace({"images", image, "uri"}, json_string(data_uri(now.type, bytes)));
    replace({"images", image, "mimeType"}, json_string(now.type));
    return stored;
  }

  /// A part of a buffer that a view says it has, itself or in its extension for meshopt.
  struct Region {
    std::size_t view;
    const char* extension;  ///< null: itself
    GltfView before, now;
  };

  void gather_regions() {
    for (std::size_t v = 0; v < file_.size("bufferViews"); ++v) {
      const auto id = std::int64_t(v);
      if (const auto view = file_.stored_view(id)) regions_.push_back({v, nullptr, *view, *view});
      if (const auto view = file_.compressed_view(id))
        regions_.push_back({v, meshopt_of(file_.item("bufferViews", id)).second, *view, *view});
    }
  }

  /// Replaces the bytes of a view; those behind it move by a multiple of four.
  bool replace_view(std::int64_t id, const Bytes& bytes) {
    if (regions_.empty()) gather_regions();
    const auto own = std::ranges::find_if(regions_, [&](const Region& region) {
      return std::int64_t(region.view) == id && !region.extension;
    });
    if (own == regions_.end() || file_.compressed_view(id)) return false;
    GltfView& view = own->now;
    const std::size_t old_end = view.offset + view.length;
    for (const Region& other : regions_)
      if (&other != &*own && other.now.buffer == view.buffer && other.now.offset < old_end &&
          other.now.offset + other.now.length > view.offset)
        return false;
    std::size_t room = bytes.size();
    while ((room - view.length) % 4 != 0) ++room;
    Bytes& buffer = changed_buffer(view.buffer);
    Bytes replacement = bytes;
    replacement.resize(room);
    Bytes now(buffer.begin(), buffer.begin() + std::ptrdiff_t(view.offset));
    now.insert(now.end(), replacement.begin(), replacement.end());
    now.insert(now.end(), buffer.begin() + std::ptrdiff_t(old_end), buffer.end());
    buffer = std::move(now);
    for (Region& other : regions_)
      if (&other != &*own && other.now.buffer == view.buffer && other.now.offset >= old_end)
        other.now.offset = other.now.offset - view.length + room;
    view.length = bytes.size();
    return true;
  }

  bool edit_views() {
    for (const Region& region : regions_) {
      const auto set = [&](const char* key, std::size_t was, std::size_t is) {
        if (was == is) return true;
        return region.extension ? replace({"bufferViews", region.view, "extensions", region.extension, key},
                                          std::to_string(is))
                                : replace({"bufferViews", region.view, key}, std::to_string(is));
      };
      if (!set("byteOffset", region.before.offset, region.now.offset) ||
          !set("byteLength", region.before.length, region.now.length))
        return false;
    }
    for (const auto& [b, bytes] : buffers_)
      if (bytes.size() != file_.buffer(b).size() &&
          !replace({"buffers", std::size_t(b), "byteLength"}, std::to_string(bytes.size())))
        return false;
    return true;
  }

  /// Parts as they are, or changed and then under the mesh file's own name.
  void store_buffers(std::vector<OutputFile>& files) {
    for (std::size_t b = 0; b < file_.size("buffers"); ++b) {
      const std::string name = file_.buffer_name(b);
      const auto changed = buffers_.find(int(b));
      const std::string uri = json_text_of(file_.item("buffers", std::int64_t(b)), "uri");
      if (!name.empty()) {
        for (const Part& part : document_.parts)
          if (part.name == name && changed == buffers_.end()) files.push_back(part);
        if (changed == buffers_.end()) continue;
        const std::string own = own_name(b);
        if (own != name) replace({"buffers", b, "uri"}, json_string(uri_of_name(own)));
        files.push_back({own, changed->second});
      } else if (!uri.empty() && changed != buffers_.end()) {
        const std::string type = uri.substr(5, uri.find(';') - 5);
        replace({"buffers", b, "uri"}, json_string(data_uri(type, changed->second)));
      }
    }
  }

  /// A name for a changed buffer that no other has.
  std::string own_name(std::size_t b) const {
    std::string name = stem_ + ".bin";
    for (std::size_t other = 0; other < file_.size("buffers"); ++other)
      if (other != b &&
          (file_.buffer_name(other) == name || (other < b && buffers_.contains(int(other)))))
        name = fmt::format("{}_{}.bin", stem_, b);
    return name;
  }

  Bytes mesh_file() {
    const ByteView all = document_.bytes;
    const std::string_view text = file_.json_text();
    const auto begin = std::size_t(text.data() - text_of(all).data());
    if (document_.format == Document::Format::gltf) {
      for (Edit& edit : edits_) {
        edit.begin += begin;
        edit.end += begin;
      }
      return edited(all, std::move(edits_));
    }
    const bool binary_changed = file_.chunk() && buffers_.contains(0) && !has_uri(0);
    if (edits_.empty() && !binary_changed) return document_.bytes;
    std::size_t end = begin + text.size();
    ByteView binary;
    if (file_.chunk()) {
      binary = *file_.chunk();
      end = std::size_t(binary.data() - all.data()) + binary.size();
    }
    if (binary_changed) binary = buffers_.at(0);
    return glb_bytes(edited(bytes_of(text), std::move(edits_)), binary, all.subspan(end));
  }

  bool has_uri(std::int64_t b) const { return file_.item("buffers", b).contains("uri"); }

  const Model& model_;
  const Document& document_;
  const std::vector<GltfPicture>& pictures_;
  const std::string& stem_;
  const GltfFile file_;
  const GltfScene scene_;
  const MeshFile& says_;
  std::vector<GltfPicture> now_;  ///< what each picture of the file becomes, others after textures
  std::vector<std::size_t> now_numbers_;  ///< which of `pictures_` those are
  std::map<int, Bytes> buffers_;  ///< those that change
  std::vector<Region> regions_;   ///< of buffers, once one changes
  std::vector<Edit> edits_;       ///< of the JSON
};

}  // namespace

GltfOutput splice_gltf(const Model& model, const Document& document,
                       const std::vector<GltfPicture>& pictures, const std::string& stem) {
  return GltfSplicer(model, document, pictures, stem).splice();
}

}  // namespace mq
