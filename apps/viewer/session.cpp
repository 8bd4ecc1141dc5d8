#include "session.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

#include "mq/base/error.h"
#include "mq/io/temporary_folder.h"
#include "shell/verb.h"

namespace mq::view {
namespace {

namespace fs = std::filesystem;

bool can_write_to(const fs::path& folder) {
  return access(folder.empty() ? "." : folder.c_str(), W_OK | X_OK) == 0;
}

/// As `Session::folder` says.
fs::path folder_for(const fs::path& model) {
  if (model.empty()) return {};
  const fs::path beside = model.parent_path();
  const fs::path below = fs::absolute(model).lexically_relative(fs::absolute(sample_folder()));
  const bool is_sample = !below.empty() && *below.begin() != "..";
  if (!is_sample && can_write_to(beside)) return beside;
  const char* const home = std::getenv("HOME");
  return home != nullptr && *home != 0 && can_write_to(home) ? fs::path(home) : fs::current_path();
}

/// "wrote out.png" as "wrote out.png in /home/me/models": a window has no folder of its own.
std::string with_folder(const std::string& said) {
  const std::string wrote = "wrote ";
  if (!said.starts_with(wrote)) return said;
  const fs::path file = said.substr(wrote.size());
  const fs::path folder = fs::absolute(file).parent_path();
  std::error_code ignored;
  if (!file.has_filename() || !fs::is_directory(folder, ignored)) return said;
  return wrote + file.filename().string() + " in " + folder.lexically_normal().string();
}

/// What is said of a file of the window's own is said without its folder; false: it is not worth saying.
bool without_own_folder(std::string& said) {
  const std::size_t at = said.find(temporary_place().string() + "/marquetry-view-");
  if (at == std::string::npos) return true;
  if (said.starts_with("wrote ")) return false;
  const std::size_t end = std::min(said.find_first_of(" :", at), said.size());
  said.erase(at, said.rfind('/', end) + 1 - at);
  return true;
}

std::unique_ptr<LoadedModel> no_model() {
  return std::make_unique<LoadedModel>(TexturedModel(), TextureSet::largest_side(), Progress());
}

}  // namespace

Session::Session(app::Run& the_run, std::unique_ptr<LoadedModel> first)
    : run(the_run), opened(the_run.options()) {
  const bool is_there = first != nullptr;
  open(is_there ? std::move(first) : no_model());
  empty = !is_there;
  run.terminal().set_listener([this](const std::string& text) {
    const std::lock_guard lock(heard_mutex_);
    heard_.push_back(text);
  });
}

/// What the model has most of.
void Session::choose_paint() {
  using enum Look::Paint;
  look.paint = before != nullptr                  ? texture
               : scene->model.colors.channels > 0 ? vertex_colours
               : scene->atlas                     ? charts
                                                  : clay;
}

void Session::open(std::unique_ptr<LoadedModel> other) {
  ++openings;
  const bool other_mesh = empty || (other->opened && other->opened->texts("mesh") != opened.texts("mesh"));
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
  if (other->opened) {
    photographs.clear();
    kept = {};
  }
  folder = folder_for(scene->model.path);
  empty = false;
  if (other_mesh || (other->opened && !lacking_for(look.paint).empty())) choose_paint();
  if (scene->atlas) atlas.texture = std::min(atlas.texture, int(scene->atlas->textures.size()) - 1);
}

void Session::close() {
  kept = {};
  playing = false;
  open(no_model());
  empty = true;
  for (const char* name : {"mesh", "texture"}) opened.reset(name);
  look = Look{};
  atlas = AtlasView{};
  refusal.clear();
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
  constexpr std::size_t most = 12;
  const std::lock_guard lock(heard_mutex_);
  for (std::string& text : heard_) {
    if (!without_own_folder(text)) continue;
    text = with_folder(text);
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
  const fs::path path(name);
  std::string tried = name;
  for (int number = 2; is_taken(tried); ++number)
    tried = (path.parent_path() /
             fmt::format("{}_{}{}", path.stem().string(), number, path.extension().string()))
                .string();
  return tried;
}

bool exists(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

}  // namespace

/// What is wrong with a name is said when something is saved to it.
std::string Session::free_name(const std::string& name, Outputs::Kind kind) const {
  return first_free((folder / name).string(), [&](const std::string& tried) {
    try {
      return std::ranges::any_of(Outputs(tried, scene->model, kind).paths(), exists);
    } catch (const InvalidInput&) {
      return false;
    }
  });
}

std::string Session::texture_file(const std::string& stem) const {
  const std::string each = scene->model.textures.size() > 1 ? "_%s" : "";
  return stem + each + (holds_numbers(scene->model) ? ".exr" : ".png");
}

std::string Session::free_file(const std::string& name) const {
  return first_free((folder / name).string(), [](const std::string& tried) { return exists(tried); });
}

std::string Session::placed(const std::string& name) const {
  return name.empty() ? name : (folder / name).string();  // a whole path stays
}

std::string Session::found(const std::string& name) const {
  const std::string beside = placed(name);
  return !exists(name) && exists(beside) ? beside : name;
}

std::string Session::name_of(const std::string& file) const {
  if (file.empty() || folder.empty()) return file;
  const fs::path below = fs::path(file).lexically_relative(folder);
  return below.empty() || *below.begin() == ".." ? fs::absolute(file).string() : below.string();
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
