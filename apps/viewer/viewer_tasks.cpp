// What the panel has for each task, beside what tools have.
#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>

#include "controls.h"
#include "mq/base/error.h"
#include "viewer.h"

namespace mq::view {
namespace {

/// "vertex-colours" as "vertex colours".
std::string spaced(std::string words) {
  std::ranges::replace(words, '-', ' ');
  return words;
}

}  // namespace

void Viewer::look_controls() {
  Look& look = session_.look;
  for (const char* name : {"front", "right", "back", "left", "top"}) {
    if (ImGui::SmallButton(name)) this->look(parse_view(name));
    ImGui::SameLine();
  }
  if (ImGui::SmallButton("whole")) {
    home();
    home_atlas();
  }
  const auto paint = std::size_t(look.paint);
  if (ImGui::BeginCombo("show", spaced(paint_names[paint]).c_str(), ImGuiComboFlags_HeightLarge)) {
    for (std::size_t i = 0; i < paint_names.size(); ++i) {
      const std::string lacking = session_.lacking_for(Look::Paint(i));
      const std::string shown =
          spaced(paint_names[i]) + (lacking.empty() ? "" : " (no " + lacking + ")");
      if (ImGui::Selectable(shown.c_str(), i == paint,
                            lacking.empty() ? 0 : ImGuiSelectableFlags_Disabled))
        look.paint = Look::Paint(i);
    }
    ImGui::EndCombo();
  }
  ImGui::Checkbox("light", &look.lit);
  ImGui::SameLine();
  ImGui::Checkbox("seams", &look.seams);
  ImGui::SameLine();
  ImGui::Checkbox("wires", &look.wires);
  if (shows_numbers(look)) number_controls();
  if (tool_) {
    remark(fmt::format("In hand: {}{}.", tool_words(tool_name_),
                       tool_->unsaved().empty() ? "" : ", not saved"));
    if (ImGui::SmallButton("put it away")) tried(session_, [&] { take_tool("none"); });
  }
  if (ImGui::CollapsingHeader("more")) more_look_controls();
}

void Viewer::more_look_controls() {
  Look& look = session_.look;
  ImGui::Checkbox("charts in colours", &look.chart_tint);
  int up = int(up_);
  ImGui::TextUnformatted("upright axis");
  ImGui::SameLine();
  ImGui::RadioButton("y", &up, 0);
  ImGui::SameLine();
  ImGui::RadioButton("z", &up, 1);
  if (up != int(up_)) set_up(View::Up(up));
  if (session_.before && session_.before->holds_light(session_.atlas.texture)) {
    auto stops = float(look.exposure);
    if (ImGui::SliderFloat("exposure", &stops, -10, 10, "%.2f stops", ImGuiSliderFlags_AlwaysClamp))
      look.exposure = stops;
  }
  if (session_.before && session_.before->size() > 1) {
    int texture = session_.atlas.texture;
    if (ImGui::SliderInt("texture", &texture, 0, session_.before->size() - 1, "%d",
                         ImGuiSliderFlags_AlwaysClamp)) {
      session_.atlas.texture = texture;
      home_atlas();
    }
  }
  const TexturedModel& scene = *session_.scene;
  remark(fmt::format("{} vertices{}", scene.surface.mesh.vertex_count(),
                     scene.atlas ? fmt::format(", {} edges of seams", scene.atlas->seam_count) : ""));
}

void Viewer::number_controls() {
  Look& look = session_.look;
  if (look.paint == Look::Paint::numbers && session_.before)
    ImGui::SliderInt("channel", &look.channel, 0,
                     std::max(0, std::min(session_.before->channels(0), 4) - 1), "%d",
                     ImGuiSliderFlags_AlwaysClamp);
  ImGui::Checkbox("whole range", &look.automatic_scale);
  if (!look.automatic_scale) {
    float range[2] = {float(look.scale.low), float(look.scale.high)};
    if (ImGui::DragFloat2("range", range, 0.01F) && range[0] < range[1])
      look.scale.low = range[0], look.scale.high = range[1];
  }
  int map = int(look.scale.map);
  if (ImGui::Combo("colours", &map, "sequential\0diverging\0"))
    look.scale.map = FalseColour::Map(map);
  ImGui::SliderInt("lines", &look.scale.isolines, 0, 100, "%d", ImGuiSliderFlags_AlwaysClamp);
}

void Viewer::wipe_controls() {
  Look& look = session_.look;
  bool wiping = look.wipe >= 0;
  if (ImGui::Checkbox("before | after", &wiping)) look.wipe = wiping ? 0.5 : -1;
  if (!wiping) return;
  auto wipe = float(look.wipe * 100);
  ImGui::SameLine();
  ImGui::SetNextItemWidth(-1);
  if (ImGui::SliderFloat("##wipe", &wipe, 0, 100, "at %.0f %%", ImGuiSliderFlags_AlwaysClamp))
    look.wipe = wipe / 100;
}

void Viewer::compare_controls() {
  wipe_for_task();
  if (has_changed())
    wipe_controls();
  else if (!tool_ || !tool_->busy())
    remark("Nothing was changed yet: 'paint', 'photographs' and 'change all' change the texture. Or compare with "
           "another one, below.");
  else
    remark(fmt::format("Nothing is changed yet: '{}' is still at work.", tool_words(tool_name_)));
  if (tool_name_ != "compare" && has_changed())
    remark(fmt::format("Left of the line: as it was {}. Right of it: what '{}' made.",
                       session_.kept.words.empty() ? "opened" : "kept on the model", tool_words(tool_name_)));
  if (!session_.before) {
    remark("The model has no textures to compare others with.");
    return;
  }
  difference_controls();
  heading("another texture");
  ImGui::SetNextItemWidth(-scaled(80));
  if (ImGui::InputTextWithHint("##with", "its file", &to_compare_, ImGuiInputTextFlags_EnterReturnsTrue))
    tried(session_, [&] { compare_with(parted(to_compare_)); });
  ImGui::SameLine();
  if (ImGui::Button("choose ..."))
    tried(session_, [&] {
      ask_for_files(FileKind::pictures, [this](const Files& files) {
        to_compare_ = joined(files);
        compare_with(files);
      });
    });
  if (tool_name_ == "compare") tool_controls();
}

/// Where to look for what is different, once something may be.
void Viewer::difference_controls() {
  if (!has_changed()) return;
  const std::string at = tour_.words();
  ImGui::BeginDisabled(tour_.busy());
  if (ImGui::Button(at.empty() ? "go where they differ most" : "go to the next place", {-1, 0}))
    tried(session_, [&] { look_at_difference(); });
  ImGui::EndDisabled();
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("N; the whole model again: F");
  if (tour_.busy())
    ImGui::ProgressBar(float(tour_.fraction()), {-1, 0}, "looking for it");
  else if (!at.empty())
    remark(at);
}

void Viewer::look_at_difference() {
  if (!has_changed())
    return session_.say("nothing was changed yet: there is no place where the texture differs from before");
  tour_.next({double(session_.results), double(uploads_), double(session_.openings)});
}

void Viewer::take_difference() {
  const auto stop = tour_.arrived(up_);
  if (!stop) return;
  if (session_.look.wipe < 0 && tour_.is_at_first()) session_.look.wipe = 0.5;  // both are to be seen
  session_.camera.look_from(stop->view);
  const DifferencePlace& place = stop->place;
  const double zoom = std::min(atlas_at_.width, atlas_at_.height) * session_.scene->atlas->texel_spacing() /
                      stop->view.extent;
  look_at_texel(place.texture, place.column, place.row, zoom);
  pick_ = pick_in_atlas(*session_.scene, *session_.triangles_at, session_.shown(), place.texture, place.column,
                        place.row);
  session_.say(tour_.words());
}

void Viewer::compare_with(const std::vector<std::string>& files) {
  require(!files.empty(), "name the file of a texture to compare with");
  const auto compare = [this, files] {
    change_tool("compare");
    std::vector<std::string> words = {"with"};
    words.insert(words.end(), files.begin(), files.end());
    tool_->command(words);
    if (session_.look.wipe < 0) session_.look.wipe = 0.5;
  };
  if (tool_name_ == "compare")
    compare();
  else
    unless_lost(Leaving::tool, "compare with another texture", compare);
}

/// Photographs with cameras, photographs as textures, or none: then the charts count as some.
void Viewer::photograph_controls() {
  constexpr const char* tools[] = {"texture", "stitch", "charts"};
  int kind = int(std::ranges::find(tools, tool_name_) - std::begin(tools));
  const int was = kind;
  ImGui::RadioButton("with cameras", &kind, 0);
  ImGui::SameLine();
  ImGui::RadioButton("as textures", &kind, 1);
  ImGui::RadioButton("none: the charts of the texture alone", &kind, 2);
  if (kind != was) tried(session_, [&] { take_tool(tools[kind]); });
  if (!tool_) remark("The model needs texture coordinates and a texture for that.");
  if (kind == 0 && session_.photographs.empty() && !has_changed()) {
    if (ImGui::Button("try it with a sample", {-1, 0})) tried(session_, [&] { open_sample("photographs"); });
    if (ImGui::IsItemHovered())
      ImGui::SetTooltip("opens the sample of an owl, with six photographs of it and their cameras");
  }
  tool_controls();
}

void Viewer::play_controls() {
  if (!session_.sequence) {
    remark("This model stands still. What moves is a folder of numbered models, a file "
           "NAME.evolving, or this:");
    if (ImGui::Button("the sample of two drops")) tried(session_, [&] { open_sample("merging"); });
    return;
  }
  const Sequence& sequence = *session_.sequence;
  int frame = session_.frame;
  if (loader_.busy() && asked_frame_ >= 0 && !session_.playing) frame = asked_frame_;
  const std::string number =
      fmt::format("{} of {} frames: number {}", frame + 1, sequence.count(), sequence.number(frame));
  ImGui::SetNextItemWidth(-1);
  if (ImGui::SliderInt("##frame", &frame, 0, sequence.count() - 1, number.c_str(),
                       ImGuiSliderFlags_AlwaysClamp))
    tried(session_, [&] { open_frame(frame); });
  if (ImGui::Button(session_.playing ? "pause" : "play", {scaled(90), 0})) {
    session_.playing = !session_.playing;
    if (!session_.playing) loader_.cancel();
  }
  bool lifespans = session_.look.paint == Look::Paint::lifespans;
  if (sequence.has_lifespans() && ImGui::Checkbox("how long triangles live", &lifespans))
    session_.look.paint = lifespans        ? Look::Paint::lifespans
                          : session_.before ? Look::Paint::texture
                                            : Look::Paint::clay;
}

void Viewer::picture_controls() {
  ImGui::RadioButton("model", &picture_of_, 0);
  ImGui::SameLine();
  ImGui::BeginDisabled(!session_.scene->atlas);
  ImGui::RadioButton("texture", &picture_of_, 1);
  ImGui::EndDisabled();
  ImGui::SameLine();
  ImGui::RadioButton("window", &picture_of_, 2);
  const Rectangle at = place_of(picture_of_ == 1 ? Pane::atlas : Pane::surface);
  if (picture_of_ < 2) {
    std::vector<std::string> sizes;
    for (const int times : {1, 2, 4})
      sizes.push_back(fmt::format("{} × {} pixels", at.width * times, at.height * times));
    if (ImGui::BeginCombo("size", sizes[std::size_t(picture_times_)].c_str())) {
      for (int i = 0; i < 3; ++i)
        if (ImGui::Selectable(sizes[std::size_t(i)].c_str(), i == picture_times_))
          picture_times_ = i;
      ImGui::EndCombo();
    }
  }
  if (ask_to_save(session_, "picture", picture_name_)) screenshot_asked_ = true;
}

void Viewer::change_controls() {
  const float wide = (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x) / 2;
  for (std::size_t i = 0; i < change_words.size(); ++i) {
    const bool chosen = tool_name_ == change_words[i].tool;
    if (i % 2 == 1) ImGui::SameLine();
    if (chosen) ImGui::PushStyleColor(ImGuiCol_Button, ImGui::GetStyleColorVec4(ImGuiCol_ButtonActive));
    if (ImGui::Button(change_words[i].label, {wide, 0}))
      tried(session_, [&] { take_tool(change_words[i].tool); });
    if (chosen) ImGui::PopStyleColor();
  }
  if (!tool_) return;
  ImGui::Separator();
  tool_controls();
}

}  // namespace mq::view
