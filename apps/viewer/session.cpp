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

Session::Session(app::Run& the_run, app::Scene first) : run(the_run), opened(the_run.options()) {
  open(std::move(first));
  using enum Look::Paint;
  look.paint = before != nullptr                 ? texture
               : scene.model.colors.channels > 0 ? vertex_colours
               : scene.atlas                     ? charts
                                                 : clay;
}

void Session::open(app::Scene other) {
  ++openings;
  pictures.reset();
  rays.reset();
  result.reset();
  scene = std::move(other);
  rays = std::make_unique<mq::Scene>(scene.surface);
  before = textures_of(scene);
  after = textures_of(scene);
  pictures = std::make_unique<ModelPictures>(scene);
  if (scene.atlas) atlas.texture = std::min(atlas.texture, int(scene.atlas->textures.size()) - 1);
}

void Session::open_frame(int wanted) {
  open(sequence->scene(wanted));
  pictures->set_triangle_colours(sequence->lifespans(wanted));
  frame = wanted;
}

void Session::reset_shown() {
  result.reset();
  if (!after) return;
  const auto lock = after->lock();
  for (int i = 0; i < after->size(); ++i)
    after->show(i, scene.model.textures[std::size_t(i)].pixels);
}

void Session::say(const std::string& text) {
  message = text;
  run.terminal().remark(text);
}

OptionValues options_for(const std::string& verb, const Session& session) {
  std::vector<app::Verb> verbs = app::all_verbs();
  const auto found =
      std::ranges::find_if(verbs, [&](const app::Verb& v) { return v.table.verb() == verb; });
  if (found == verbs.end()) throw std::logic_error("no verb " + verb);
  app::add_running_options(found->table);
  OptionValues values(found->table);
  for (const char* name : {"mesh", "texture", "weld", "flipped"})
    if (session.opened.given(name)) values.set(name, session.opened.texts(name));
  for (const char* name : {"overwrite", "no-clobber", "quiet"})
    if (session.run.options().flag(name)) values.set(name, {"true"});
  return values;
}

}  // namespace mq::view
