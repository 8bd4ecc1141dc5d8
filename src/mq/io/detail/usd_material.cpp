// An input is worth what it is connected to, or else its own value (UsdShade, "Connectable"). A texture's colour is
// value · scale + bias, at coordinates that a reader of a primvar gives, which a UsdTransform2d may move.
#include "mq/io/detail/usd_material.h"

#include <fmt/format.h>

#include <algorithm>

#include "mq/io/bytes.h"

namespace mq {
namespace {

constexpr int most_connections = 32;  ///< one after another; files may lead in a circle

/// A property and the prim that has it.
struct UsdPlace {
  const UsdPrim* prim = nullptr;
  const UsdProperty* property = nullptr;
};

class UsdMaterialReader {
 public:
  explicit UsdMaterialReader(const UsdText& text) : text_(text) {}

  UsdPicture read(std::string_view path) {
    material_ = path;
    const UsdPrim* material = text_.prim_at(path);
    const UsdPrim* surface = material ? surface_in(*material) : nullptr;
    if (!surface) {
      note(material ? "has no UsdPreviewSurface, and is not read: bake it where it was made"
                    : "is not there, and nothing is shown in its place: bind one that is");
      return std::move(result_);
    }
    const UsdPrim* texture = source(*surface, "inputs:diffuseColor").prim;
    if (!texture || texture == surface) return {};
    if (const std::string_view id = id_of(*texture); !id.empty() && id != "UsdUVTexture") {
      note("takes its colour from a {}, which is not read", shown(id));
      return std::move(result_);
    }
    const UsdPlace file = source(*texture, "inputs:file");
    result_.file = file.property ? usd_unquoted(first_value(*file.property)) : "";
    if (!file.property || result_.file.empty()) {
      note("has no picture where it names one (inputs:file), and shows none");
      return std::move(result_);
    }
    if (changes(*file.property)) note("shows another picture at other times; the first, {}, is taken",
                                      shown(result_.file));
    note_values(*texture);
    find_uv_set(*texture);
    return std::move(result_);
  }

 private:
  void note(const char* text) { result_.notes.push_back(fmt::format("the material {} {}", material_, text)); }

  template <typename... Arguments>
    requires(sizeof...(Arguments) > 0)
  void note(fmt::format_string<Arguments...> form, Arguments&&... arguments) {
    result_.notes.push_back(
        fmt::format("the material {} {}", material_, fmt::format(form, std::forward<Arguments>(arguments)...)));
  }

  static std::string_view id_of(const UsdPrim& prim) {
    const UsdProperty* id = prim.property("info:id");
    return id ? usd_unquoted(id->value) : "";
  }

  static const UsdPrim* surface_in(const UsdPrim& prim) {
    for (const UsdPrim& child : prim.children) {
      if (id_of(child) == "UsdPreviewSurface") return &child;
      if (const UsdPrim* found = surface_in(child)) return found;
    }
    return nullptr;
  }

  /// Where a prim lies; empty: not in `above`.
  static std::string path_of(const UsdPrim& prim, const UsdPrim& above) {
    for (const UsdPrim& child : above.children) {
      const std::string path = fmt::format("/{}", child.name);
      if (&child == &prim) return path;
      if (const std::string below = path_of(prim, child); !below.empty()) return path + below;
    }
    return "";
  }

  /// What an input is connected to in the end: an output of a shader, or an input that has a value of its own.
  UsdPlace source(const UsdPrim& prim, std::string_view name) const {
    UsdPlace place{&prim, prim.property(name)};
    for (int k = 0; k < most_connections && place.property && !place.property->connection.empty(); ++k) {
      const std::string_view written = place.property->connection;
      const std::vector<std::string> paths = text_.targets(written, path_of(*place.prim, text_.layer()));
      const std::string path = paths.empty() ? "" : paths[0];
      const std::size_t dot = path.find('.');
      place.prim = text_.prim_at(path);
      place.property = place.prim && dot != path.npos ? place.prim->property(path.substr(dot + 1)) : nullptr;
    }
    return place;
  }

  static std::string_view first_value(const UsdProperty& property) {
    const auto sample = std::ranges::find_if(property.samples, [](const UsdSample& s) { return !s.value.empty(); });
    return sample != property.samples.end() ? sample->value : property.value;
  }

  static bool changes(const UsdProperty& property) {
    return property.has_spline || std::ranges::any_of(property.samples, [&](const UsdSample& s) {
             return s.value != first_value(property);
           });
  }

  std::string_view value_of(const UsdPrim& prim, std::string_view name) const {
    const UsdPlace place = source(prim, name);
    return place.property ? first_value(*place.property) : "";
  }

  /// Whether an input has these four numbers, or none.
  bool is_plain(const UsdPrim& prim, std::string_view name, double usual) const {
    const UsdPlace place = source(prim, name);
    if (place.property && changes(*place.property)) return false;
    const std::string_view value = value_of(prim, name);
    return value.empty() || std::ranges::all_of(text_.numbers(value), [&](double v) { return v == usual; });
  }

  void note_values(const UsdPrim& texture) {
    for (const auto& [name, usual] : {std::pair{"inputs:scale", 1.0}, {"inputs:bias", 0.0}})
      if (!is_plain(texture, name, usual))
        note("changes the values of its picture ({} {}); they are taken as the picture has them",
             std::string_view(name).substr(7), value_of(texture, name));
    if (const std::string_view space = usd_unquoted(value_of(texture, "inputs:sourceColorSpace")); space == "raw")
      note("takes the values of its picture for light (sourceColorSpace raw); they are taken as display values");
  }

  void find_uv_set(const UsdPrim& texture) {
    const UsdPrim* reader = source(texture, "inputs:st").prim;
    for (int k = 0; k < most_connections && reader && id_of(*reader) == "UsdTransform2d"; ++k) {
      if (!is_plain(*reader, "inputs:scale", 1) || !is_plain(*reader, "inputs:rotation", 0) ||
          !is_plain(*reader, "inputs:translation", 0))
        note("moves its picture over the surface (UsdTransform2d), which is not followed: bake it");
      reader = source(*reader, "inputs:in").prim;
    }
    if (reader && reader != &texture && id_of(*reader).starts_with("UsdPrimvarReader"))
      result_.uv_set = usd_unquoted(value_of(*reader, "inputs:varname"));
  }

  const UsdText& text_;
  std::string material_;
  UsdPicture result_;
};

}  // namespace

UsdPicture usd_picture(const UsdText& text, std::string_view material) {
  return UsdMaterialReader(text).read(material);
}

}  // namespace mq
