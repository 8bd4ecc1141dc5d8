#include "session.h"

#include <algorithm>

#include "mq/base/error.h"
#include "render_request.h"
#include "verb.h"

namespace mq::view {
namespace {

std::unique_ptr<TextureSet> textures_of(const app::Scene& scene) {
  if (!app::has_pictures(scene)) return nullptr;
  return std::make_unique<TextureSet>(scene.model.textures);
}

}  // namespace

Session::Session(app::Run& the_run, app::Scene the_scene)
    : run(the_run),
      scene(std::move(the_scene)),
      rays(scene.surface),
      before(textures_of(scene)),
      after(textures_of(scene)),
      pictures(scene) {
  using enum Look::Paint;
  look.paint = before != nullptr                  ? texture
               : scene.model.colors.channels > 0 ? vertex_colours
               : scene.atlas                      ? charts
                                                  : clay;
}

void Session::reset_shown() {
  result.reset();
  if (!after) return;
  const auto lock = after->lock();
  for (int i = 0; i < after->size(); ++i) after->show(i, scene.model.textures[std::size_t(i)].pixels);
}

void Session::say(const std::string& text) {
  message = text;
  run.terminal().remark(text);
}

OptionValues options_for(const std::string& verb, const Session& session) {
  std::vector<app::Verb> verbs = app::all_verbs();
  const auto found = std::ranges::find_if(
      verbs, [&](const app::Verb& v) { return v.table.verb() == verb; });
  if (found == verbs.end()) throw std::logic_error("no verb " + verb);
  app::add_running_options(found->table);
  OptionValues values(found->table);
  for (const char* name : {"mesh", "texture", "weld", "flipped"})
    if (session.run.options().given(name)) values.set(name, session.run.options().texts(name));
  for (const char* name : {"overwrite", "no-clobber", "quiet"})
    if (session.run.options().flag(name)) values.set(name, {"true"});
  return values;
}

}  // namespace mq::view
