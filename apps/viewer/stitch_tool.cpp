// What a person or a script does: choose photographs and give them regions.
#include "stitch_tool.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <set>

#include "controls.h"
#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/io/cameras.h"
#include "mq/io/file_names.h"
#include "shell/arguments.h"
#include "theme.h"

namespace mq::view {

namespace {

/// Options that name photographs and the choice between them, of each of the two tools.
constexpr std::array<std::pair<const char*, const char*>, 6> kept_options = {{{"texture", "cameras"},
                                                                              {"texture", "images"},
                                                                              {"texture", "labels"},
                                                                              {"stitch", "partial"},
                                                                              {"stitch", "confidence"},
                                                                              {"stitch", "labels"}}};

}  // namespace

/// Photographs that were chosen before are there again; nothing begins.
StitchTool::StitchTool(const std::string& verb, Session& session)
    : VerbTool(verb, session), with_cameras_(verb == "texture") {
  const bool several = session.scene->model.textures.size() > 1;
  labels_name_ = session.free_name(several ? "choice_%s.png" : "choice.png", Outputs::Kind::pictures);
  for (const auto& [tool, option] : kept_options)
    if (const auto kept = session.photographs.find({tool, option}); tool == verb && kept != session.photographs.end())
      options_.set(option, kept->second);
}

StitchTool::~StitchTool() {
  background_.stop();
  note_photographs();
}

void StitchTool::note_photographs() const {
  for (const auto& [tool, option] : kept_options) {
    if (tool != name()) continue;
    session_.photographs.erase({tool, option});
    if (!options_.texts(option).empty()) session_.photographs[{tool, option}] = options_.texts(option);
  }
}

std::string StitchTool::missing() const {
  return with_cameras_ ? "Photographs are missing: choose the file of cameras that names them."
                       : "Photographs are missing: choose some that are textures of this model.";
}

std::string StitchTool::work_words() const {
  return ready_ ? "borders are being taken away" : "photographs are being read";
}

void StitchTool::panel() {
  note_photographs();
  if (ready_ && has_photographs()) {
    forget_others();
    choices();
  } else {
    remark(has_photographs() ? "Begin; then paint on the model from which photograph it comes."
           : with_cameras_   ? "Name the cameras' file, then begin; then paint on the model from which "
                               "photograph it comes."
                         : "Name photographs that are textures of this model, then begin; then paint "
                           "on the model from which of them it comes.");
  }
  say_what_was_kept();
  name_photographs();
  ask_for_photographs();
  VerbTool::panel();
}

/// Of the other way to have photographs, and why it does not do here.
void StitchTool::say_what_was_kept() const {
  const std::string tool = with_cameras_ ? "stitch" : "texture", option = with_cameras_ ? "partial" : "cameras";
  const auto kept = session_.photographs.find({tool, option});
  if (kept == session_.photographs.end()) return;
  std::vector<std::string> names;
  for (const std::string& file : kept->second) names.push_back(std::filesystem::path(file).filename().string());
  const TextureSize& size = session_.scene->texture_sizes.front();
  remark(with_cameras_
             ? fmt::format("Kept for 'as textures': {}. Alone they do not do here: a file of cameras says from where "
                           "each photograph was taken.",
                           joined(names))
             : fmt::format("Kept for 'with cameras': {}. It does not fit here: these photographs are textures of this "
                           "model, {} × {} texels large.",
                           joined(names), size.width, size.height));
}

bool StitchTool::take_files(const std::vector<std::string>& files) {
  const bool cameras = std::ranges::all_of(files, [](const std::string& file) { return names_cameras(file); });
  const bool pictures = std::ranges::all_of(files, names_picture);
  if (with_cameras_ ? !cameras && !pictures : !pictures) return false;
  require(!with_cameras_ || cameras,
          "photographs alone do not say from where they were taken: drop the file of cameras that names them, or "
          "choose 'as textures'");
  std::vector<std::string> all = with_cameras_ ? std::vector<std::string>() : options_.texts("partial");
  all.insert(all.end(), files.begin(), files.end());
  change(photographs_option(), all);
  return true;
}

/// How many, and the names of their files, whose folders are under the mouse.
void StitchTool::name_photographs() {
  const std::vector<std::string> chosen = options_.texts(photographs_option());
  if (chosen.empty()) return;
  std::string names;
  for (const std::string& file : chosen) {
    std::filesystem::path path = file;
    if (!path.has_filename()) path = path.parent_path();
    names += (names.empty() ? "" : ", ") + path.filename().string();
  }
  remark((with_cameras_ ? "cameras: " : counted(std::ssize(chosen), "photograph") + ": ") + names);
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", fmt::format("{}", fmt::join(chosen, "\n")).c_str());
  if (!ready_ && ImGui::SmallButton("take them away"))
    tried(session_, [&] { change(photographs_option(), {}); });
}

void StitchTool::ask_for_photographs() {
  const std::vector<std::string> chosen = options_.texts(photographs_option());
  const char* const words = with_cameras_     ? "choose cameras ..."
                            : chosen.empty() ? "choose photographs ..."
                                             : "add photographs ...";
  if ((!ready_ || !with_cameras_) && ImGui::Button(words, {-1, 0}))
    tried(session_, [&] {
      const FileKind kind = with_cameras_ ? FileKind::cameras : FileKind::pictures;
      session_.ask_for_files(kind, [this, chosen](std::vector<std::string> files) {
        if (!with_cameras_) files.insert(files.begin(), chosen.begin(), chosen.end());
        change(photographs_option(), files);
      });
    });
}

std::string StitchTool::chosen_name() const {
  return photograph_ == unseen ? "best" : names_[std::size_t(photograph_)];
}

void StitchTool::choices() {
  if (ImGui::BeginCombo("photograph", chosen_name().c_str())) {
    if (ImGui::Selectable("best", photograph_ == unseen)) photograph_ = unseen;
    for (int i = 0; i < int(names_.size()); ++i)
      if (ImGui::Selectable(names_[std::size_t(i)].c_str(), photograph_ == i)) photograph_ = i;
    ImGui::EndCombo();
  }
  int region = int(region_);
  ImGui::RadioButton("brush", &region, 0);
  ImGui::SameLine();
  ImGui::RadioButton("whole chart", &region, 1);
  region_ = Region(region);
  if (region_ == Region::brush) edit_brush(size_, brush_size(), session_.scene->surface.area);
  undo_buttons(session_, *this);
  if (ask_to_save(session_, "choice", labels_name_)) tried(session_, [&] { save_labels(labels_name_); });
  ImGui::Separator();
}

Tool::History StitchTool::history() const {
  History all{{}, undo_.size()};
  for (const Stroke& stroke : undo_) all.strokes.push_back(stroke.name);
  for (auto stroke = redo_.rbegin(); stroke != redo_.rend(); ++stroke)
    all.strokes.push_back(stroke->name);
  return all;
}

void StitchTool::scale_brush(double factor) {
  if (!ready_) return;
  const double percent = 100 * factor * brush_size() / std::sqrt(session_.scene->surface.area);
  size_ = {std::clamp(percent, 0.1, 50.0), Length::Unit::percent};
}

void StitchTool::press(const Pick& pick) {
  if (!ready_) return;
  forget_others();
  begin_stroke();
  dragging_ = true;
  drag(pick);
}

void StitchTool::drag(const Pick& pick) {
  if (!ready_ || pick.chart < 0) return;
  if (last_ && region_ == Region::brush)
    give_along(*last_, pick.point);
  else
    give_at(pick.point);
  last_ = pick.point;
}

void StitchTool::release() {
  if (dragging_.exchange(false)) end_stroke();
}

double StitchTool::brush_size() const {
  const TexturedModel& scene = *session_.scene;
  return std::sqrt(weight_from_length(size_, {scene.surface.area, scene.atlas->texel_spacing()}));
}

nlohmann::ordered_json StitchTool::report() const {
  nlohmann::ordered_json report = VerbTool::report();
  report["prepare_seconds"] = preparing_;
  report["solve_seconds"] = solving_;
  report["prepared"] = prepared_;
  return report;
}

bool StitchTool::command(const std::vector<std::string>& words) {
  const std::string& what = words[0];
  static const std::set<std::string> own = {"photograph", "region", "size",       "stroke",
                                            "undo",       "redo",   "save-labels"};
  if (what == "set")
    require(shows(options_.table().find(words[1])),
            fmt::format("'{}' is not an option that the viewer sets: the model has its textures", words[1]));
  if (!own.contains(what)) return VerbTool::command(words);
  require(
      ready_ && has_photographs(),
      fmt::format("{} chooses between photographs: name them first, with 'set {} FILE'", name(), photographs_option()));
  forget_others();
  if (what == "photograph") {
    const auto number = app::parse_numbers(words[1], 1);
    const int count = int(names_.size());
    require(words[1] == "best" || (number && number->front() >= 0 && number->front() < count &&
                                   number->front() == std::floor(number->front())),
            fmt::format("found '{}', wanted best or a number from 0 to {}", words[1], count - 1));
    photograph_ = words[1] == "best" ? unseen : int(number->front());
  } else if (what == "region") {
    require(words[1] == "brush" || words[1] == "chart",
            fmt::format("found '{}', wanted brush or chart", words[1]));
    region_ = words[1] == "brush" ? Region::brush : Region::chart;
  } else if (what == "size") {
    const Length size = parse_length(words[1]);
    require(size.value > 0, fmt::format("found '{}', wanted a length above 0", words[1]));
    size_ = size;
  } else if (what == "stroke") {
    begin_stroke();
    for (std::size_t i = 1; i < words.size(); ++i) {
      const auto place = app::parse_numbers(words[i], 3);
      require(place.has_value(), fmt::format("found '{}', wanted X,Y,Z", words[i]));
      const Vector3 next((*place)[0], (*place)[1], (*place)[2]);
      if (last_ && region_ == Region::brush)
        give_along(*last_, next);
      else
        give_at(next);
      last_ = next;
    }
    end_stroke();
  } else if (what == "undo") {
    undo();
  } else if (what == "redo") {
    redo();
  } else {
    save_labels(words[1]);
  }
  return true;
}

/// With other photographs neither the one chosen nor what was done means what it did.
void StitchTool::forget_others() {
  if (known_ == prepared_) return;
  known_ = prepared_;
  undo_.clear();
  redo_.clear();
  if (photograph_ >= int(names_.size())) photograph_ = 0;
}

void StitchTool::give_along(const Vector3& from, const Vector3& to) {
  const int count = std::max(1, int(std::ceil((to - from).norm() / (brush_size() / 3))));
  for (int i = 1; i <= count; ++i) give_at(from + double(i) / count * (to - from));
}

void StitchTool::give_at(const Vector3& place) {
  const ClosestPoint at = (*closest_)(place);
  const int chart = session_.scene->atlas->chart[std::size_t(at.triangle)];
  if (chart < 0) return;
  std::vector<int> unknowns;
  if (region_ == Region::brush) {
    unknowns = ball_->reach(at.triangle, at.barycentric, place, brush_size());
  } else {
    const std::vector<int>& charts = target_->space().texels().chart;
    for (int k = 0; k < int(charts.size()); ++k)
      if (charts[std::size_t(k)] == chart) unknowns.push_back(k);
  }
  if (!unknowns.empty()) met_ = std::max(met_, Met::model);
  std::erase_if(unknowns, [&](int k) {
    return photograph_ != unseen &&
           !(partials_[std::size_t(photograph_)].confidence[std::size_t(k)] > 0);
  });
  if (!unknowns.empty()) met_ = Met::photograph;
  give(unknowns, std::vector<int>(unknowns.size(), photograph_));
}

void StitchTool::give(const std::vector<int>& unknowns, const std::vector<int>& photographs) {
  bool changed = false;
  {
    const std::lock_guard lock(choice_mutex_);
    for (std::size_t i = 0; i < unknowns.size(); ++i) {
      int& now = choice_[std::size_t(unknowns[i])];
      if (now == photographs[i]) continue;
      stroke_.unknowns.push_back(unknowns[i]);
      stroke_.before.push_back(now);
      stroke_.after.push_back(photographs[i]);
      now = photographs[i];
      changed = true;
    }
  }
  if (!changed) return;
  if (saving().empty()) background_.cancel();
  make_again();
}

void StitchTool::say_nothing_given() {
  switch (met_) {
    case Met::nothing: return session_.say("the stroke touches nothing of the model that has a texture");
    case Met::model:
      return session_.say("the stroke changes nothing: " + chosen_name() + " does not show what it touches");
    case Met::photograph: return session_.say("the stroke changes nothing: what it touches is so already");
  }
}

void StitchTool::end_stroke() {
  last_.reset();
  if (stroke_.unknowns.empty()) return say_nothing_given();
  stroke_.name = chosen_name();
  undo_.push_back(std::move(stroke_));
  stroke_ = {};
  redo_.clear();
  make_again();
}

void StitchTool::undo() {
  if (undo_.empty()) return;
  Stroke stroke = std::move(undo_.back());
  undo_.pop_back();
  // The last change of a texel is taken back first: a stroke may meet it several times.
  give({stroke.unknowns.rbegin(), stroke.unknowns.rend()},
       {stroke.before.rbegin(), stroke.before.rend()});
  stroke_ = {};
  redo_.push_back(std::move(stroke));
}

void StitchTool::redo() {
  if (redo_.empty()) return;
  Stroke stroke = std::move(redo_.back());
  redo_.pop_back();
  give(stroke.unknowns, stroke.after);
  stroke_ = {};
  undo_.push_back(std::move(stroke));
}

std::unique_ptr<Tool> make_stitch_tool(const std::string& verb, Session& session) {
  return std::make_unique<StitchTool>(verb, session);
}

}  // namespace mq::view
