// What is bound for a purpose anywhere on the line goes before all that is bound for all purposes. For one purpose
// the innermost binding counts, unless one further out is stronger than descendants; on one prim a collection goes
// before a direct binding (UsdShadeMaterialBindingAPI, "Material Resolution"). Beyond that, and as a picture says
// more than none, what is bound for full renders alone is taken where nothing else is.
//
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
                           usd_bound_collection = "material:binding:collection";

class UsdBindingReader {
 public:
  UsdBindingReader(const UsdText& text, const UsdMesh& mesh) : text_(text), mesh_(mesh) {}

  UsdBinding read() {
    for (const char* purpose : {"preview", "", "full"})
      if (bind_for(purpose)) break;
    return std::move(result_);
  }

 private:
  /// Looks for what is bound for one purpose, "" for all, from the mesh outwards.
  bool bind_for(std::string_view purpose) {
    const UsdPrim* binder = nullptr;
    std::string path = mesh_.path;
    for (auto prim = mesh_.line.rbegin(); prim != mesh_.line.rend(); ++prim, path.resize(path.rfind('/'))) {
      const auto bind = [&](std::string material) {
        result_.material = std::move(material);
        binder = *prim;
      };
      const UsdProperty* own = (*prim)->property(joined(usd_bound, purpose));
      if (own && !own->value.empty() && (!binder || is_stronger(*own)))
        if (const auto targets = text_.targets(own->value, path); !targets.empty()) bind(targets[0]);
      for (const UsdProperty* property : collections_of(**prim, purpose)) {
        if (binder && binder != *prim && !is_stronger(*property)) continue;
        const std::vector<std::string> targets = text_.targets(property->value, path);
        if (targets.size() != 2) continue;
        const bool turned = targets[1].find('.') != std::string::npos;
        if (!has_mesh(targets[turned ? 1 : 0])) continue;
        bind(targets[turned ? 0 : 1]);
        break;
      }
    }
    return binder != nullptr;
  }

  static std::string joined(std::string_view name, std::string_view purpose) {
    return purpose.empty() ? std::string(name) : fmt::format("{}:{}", name, purpose);
  }

  bool is_stronger(const UsdProperty& property) const {
    return usd_unquoted(text_.member(property.metadata, "bindMaterialAs")) == "strongerThanDescendants";
  }

  /// Those for a purpose: material:binding:collection:NAME, material:binding:collection:PURPOSE:NAME.
  static std::vector<const UsdProperty*> collections_of(const UsdPrim& prim, std::string_view purpose) {
    const std::string begin = joined(usd_bound_collection, purpose) + ":";
    std::vector<const UsdProperty*> all;
    for (const UsdProperty& property : prim.properties)
      if (property.name.starts_with(begin) && property.name.find(':', begin.size()) == property.name.npos &&
          !property.value.empty())
        all.push_back(&property);
    return all;
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
