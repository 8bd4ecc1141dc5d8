#include "session.h"

#include <fmt/format.h>

#include <algorithm>

#include "mq/base/error.h"
#include "shell/verb.h"

namespace mq::view {

Session::Session(app::Run& the_run, std::unique_ptr<LoadedModel> first)
    : run(the_run), opened(the_run.options()) {
  const bool is_there = first != nullptr;
  open(is_there ? std::move(first)
                : std::make_unique<LoadedModel>(TexturedModel(), TextureSet::largest_side(), Progress()));
  empty = !is_there;
  run.terminal().set_listener([this](const std::string& text) {
    const std::lock_guard lock(heard_mutex_);
    heard_.push_back(text);
  });
}

/// What the first model has most of.
void Session::choose_paint() {
  using enum Look::Paint;
  look.paint = before != nullptr                  ? texture
               : scene->model.colors.channels > 0 ? vertex_colours
               : scene->atlas                     ? charts
                                                  : clay;
}

void Session::open(std::unique_ptr<LoadedModel> other) {
  ++openings;
  pictures.reset();
  rays.reset();
  triangles_at.reset();
  show(nullptr, nullptr);
  scene = std::move(other->scene);
  rays = std::move(other->rays);
  triangles_at = std::move(other->triangles_at);
  before = std::move(other->before);
  after = std::move(other->after);
  pictures = std::make_unique<ModelPictures>(*scene, std::move(*other->drawn));
  if (other->opened) opened = *other->opened;
  sequence = other->sequence;
  frame = other->frame;
  if (std::exchange(empty, false)) choose_paint();
  if (scene->atlas) atlas.texture = std::min(atlas.texture, int(scene->atlas->textures.size()) - 1);
}

const VertexSignal* Session::shown_colours() const {
  if (result_colours) return result_colours.get();
  return scene->model.colors.channels > 0 ? &scene->model.colors : nullptr;
}

void Session::show(std::shared_ptr<TextureSet> textures,
                   std::shared_ptr<const VertexSignal> colours) {
  if (textures == result && colours == result_colours) return;
  result = std::move(textures);
  result_colours = std::move(colours);
  ++results;
}

void Session::show_as(Look::Paint paint) {
  shown_as_ = {paint, look.paint};
  look.paint = paint;
}

void Session::reset_shown() {
  show(nullptr, nullptr);
  if (shown_as_ && look.paint == shown_as_->first) look.paint = shown_as_->second;
  shown_as_.reset();
  if (!after) return;
  const auto lock = after->lock();
  for (int i = 0; i < after->size(); ++i)
    after->show(i, scene->model.textures[std::size_t(i)].pixels);
}

std::string Session::lacking_for(Look::Paint paint) const {
  using enum Look::Paint;
  switch (paint) {
    case charts:
    case stretch:
    case density: return scene->atlas ? "" : "texture coordinates";
    case numbers:
    case normals:
    case tangent_normals: return shown() != nullptr ? "" : "textures";
    case vertex_colours: return shown_colours() != nullptr ? "" : "colours at vertices";
    case lifespans: return sequence && sequence->has_lifespans() ? "" : "lifespans";
    case texture:
    case clay: return "";
  }
  return "";
}

void Session::say(const std::string& text) {
  run.terminal().remark(text);
  listen();
}

void Session::refuse(const std::string& text) {
  refusal = text;
  say(text);
}

void Session::listen() {
  constexpr std::size_t most = 4;
  const std::lock_guard lock(heard_mutex_);
  for (std::string& text : heard_) {
    std::erase_if(news, [&](const News& old) { return old.text == text; });
    if (news.size() == most) news.erase(news.begin());
    news.push_back({std::move(text), Stopwatch()});
    ++messages;
  }
  heard_.clear();
}

namespace {

/// The first of out.png, out_2.png, ... that is none of a person's files.
template <class Taken>
std::string first_free(const std::string& name, const Taken& is_taken) {
  const std::filesystem::path path(name);
  std::string tried = name;
  for (int number = 2; is_taken(tried); ++number)
    tried = (path.parent_path() /
             fmt::format("{}_{}{}", path.stem().string(), number, path.extension().string()))
                .string();
  return tried;
}

bool exists(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

}  // namespace

/// What is wrong with a name is said when something is saved to it.
std::string Session::free_name(const std::string& name, Outputs::Kind kind) const {
  return first_free(name, [&](const std::string& tried) {
    try {
      return std::ranges::any_of(Outputs(tried, scene->model, kind).paths(), exists);
    } catch (const InvalidInput&) {
      return false;
    }
  });
}

std::string Session::free_file(const std::string& name) {
  return first_free(name, [](const std::string& tried) { return exists(tried); });
}

bool holds_numbers(const Model& model) {
  return std::ranges::any_of(model.textures, [](const Texture& texture) {
    return texture.format.depth == Depth::half || texture.format.depth == Depth::f32;
  });
}

OptionValues options_for(const std::string& verb, const Session& session) {
  std::vector<app::Verb> verbs = app::all_verbs();
  const auto found =
      std::ranges::find_if(verbs, [&](const app::Verb& v) { return v.table.verb() == verb; });
  if (found == verbs.end()) throw std::logic_error("no verb " + verb);
  app::add_running_options(found->table);
  OptionValues values(found->table);
  for (const char* name : {"mesh", "texture", "weld", "flipped", "slot", "uv-set", "layer"})
    if (session.opened.given(name)) values.set(name, session.opened.texts(name));
  if (session.sequence) {
    session.sequence->name(session.frame, values);
    const std::string file = values.text("mesh");
    require(names_model(file),
            fmt::format("{}: tools work on models that verbs read: write the frame as one, with "
                        "'marquetry export'",
                        file));
  }
  for (const char* name : {"overwrite", "no-clobber"})
    if (session.run.options().flag(name)) values.set(name, {"true"});
  return values;
}

}  // namespace mq::view
