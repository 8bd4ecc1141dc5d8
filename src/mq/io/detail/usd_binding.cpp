// A collection has what its includes lead to and its excludes do not: of the paths of both that a
// prim lies in, the longest decides. "explicitOnly" takes the paths alone, not what lies in them.
#include "mq/io/detail/usd_binding.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "mq/io/bytes.h"

namespace mq {
namespace {

constexpr std::string_view usd_bound = "material:binding",
                           usd_bound_collection = "material:binding:collection:";

class UsdBindingReader {
 public:
  UsdBindingReader(const UsdText& text, const UsdMesh& mesh) : text_(text), mesh_(mesh) {}

  UsdBinding read() {
    std::string path;
    for (const UsdPrim* prim : mesh_.line) {
      path += fmt::format("/{}", prim->name);
      const auto [property, material] = bound_by(*prim, path);
      if (!property) continue;
      result_.material = material;
      if (usd_unquoted(text_.member(property->metadata, "bindMaterialAs")) ==
          "strongerThanDescendants")
        break;
    }
    return std::move(result_);
  }

 private:
  struct UsdBound {
    const UsdProperty* property = nullptr;
    std::string material = {};
  };

  UsdBound bound_by(const UsdPrim& prim, const std::string& path) {
    for (const UsdProperty& property : prim.properties) {
      if (!property.name.starts_with(usd_bound_collection) || property.value.empty()) continue;
      const std::vector<std::string> targets = text_.targets(property.value, path);
      const std::string_view name = property.name.substr(usd_bound_collection.size());
      if (name.starts_with("full:") || targets.size() != 2) continue;
      const bool turned = targets[1].find('.') != std::string::npos;
      if (has_mesh(targets[turned ? 1 : 0])) return {&property, targets[turned ? 0 : 1]};
    }
    for (const char* purpose : {":preview", "", ":full"})
      if (const UsdProperty* own = prim.property(fmt::format("{}{}", usd_bound, purpose));
          own && !own->value.empty())
        if (const auto targets = text_.targets(own->value, path); !targets.empty())
          return {own, targets[0]};
    return {};
  }

  void note(const std::string& collection, const char* what) {
    result_.notes.push_back(
        fmt::format("a material of {} is bound to the collection {}, which {}; bind it to the "
                    "mesh, or to what it "
                    "lies in",
                    mesh_.path, shown(collection), what));
  }

  /// Whether the mesh is in the collection at a path such as "/root.collection:skin".
  bool has_mesh(const std::string& collection) {
    const std::size_t dot = collection.find('.');
    const UsdPrim* owner = text_.prim_at(collection);
    const std::string name = dot == collection.npos ? "" : collection.substr(dot + 1);
    const auto part = [&](const char* of) { return owner ? owner->property(name + of) : nullptr; };
    const std::string path = collection.substr(0, dot);
    const UsdProperty *included = part(":includes"), *root = part(":includeRoot"),
                      *rule = part(":expansionRule");
    if (const UsdProperty* expression = part(":membershipExpression");
        expression && !expression->value.empty()) {
      note(collection, "chooses by an expression (membershipExpression), and that is not followed");
      return false;
    }
    if (!included && !root) {
      note(collection, "is not there");
      return false;
    }
    std::map<std::string, bool> listed;
    for (const auto& [of, is_in] : {std::pair{":includes", true}, {":excludes", false}})
      if (const UsdProperty* paths = part(of))
        for (const std::string& target : text_.targets(paths->value, path)) {
          if (is_in && target.find('.') != target.npos)
            note(collection, "includes another collection, and that is not followed");
          listed[target] = is_in;
        }
    if (root && (root->value == "true" || root->value == "1")) listed.try_emplace("/", true);
    const bool alone = rule && usd_unquoted(rule->value) == "explicitOnly";
    for (std::string above = mesh_.path;;
         above.resize(std::max<std::size_t>(above.rfind('/'), 1))) {
      if (const auto found = listed.find(above); found != listed.end()) return found->second;
      if (alone || above == "/") return false;
    }
  }

  const UsdText& text_;
  const UsdMesh& mesh_;
  UsdBinding result_;
};

}  // namespace

UsdBinding usd_binding(const UsdText& text, const UsdMesh& mesh) {
  return UsdBindingReader(text, mesh).read();
}

}  // namespace mq
